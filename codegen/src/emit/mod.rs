//! Source text from programs.

pub mod c;
pub mod header;
pub mod listing;
pub mod names;
pub mod rust;
