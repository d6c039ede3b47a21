//! What is done to the project itself; a user of `sesc` needs none of it.

pub mod counts;
pub mod hidden;
mod json;
pub mod regen;
pub mod study;
