//! A fleet of virtual robots on the command line: one row for each robot and day, the same
//! bytes however often and in whatever order.

mod faults;
mod inputs;
mod prior;
mod table;
