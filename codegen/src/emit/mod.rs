//! Source text from programs.

#[cfg(feature = "c99")]
pub mod c;
pub mod header;
pub mod listing;
pub mod names;
pub mod rust;
mod shared;
