//! Files and names that were made to do harm: nothing that is read is trusted.

mod cells;
mod changes;
mod faults;
mod kills;
mod names;
mod overwrites;
mod sizes;
mod values;
