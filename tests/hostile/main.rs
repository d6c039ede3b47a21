//! Files and names that were made to do harm: nothing that is read is trusted.

mod overwrites;
mod sizes;
mod values;
