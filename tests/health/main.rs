//! Broken data are seen before any hypothesis; healthy ones are left alone.

mod command;
mod effects;
mod log;
mod rows;
mod stretches;
mod unusable;
