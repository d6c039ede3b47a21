//! Files and names that were made to do harm: nothing that is read is trusted.

mod cells;
mod changes;
mod factor_files;
mod faults;
mod formats;
mod found;
mod kills;
mod memory;
mod names;
mod overwrites;
mod programs;
mod sizes;
mod values;
