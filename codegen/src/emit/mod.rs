//! Source text from programs.

pub mod header;
pub mod names;
pub mod rust;
