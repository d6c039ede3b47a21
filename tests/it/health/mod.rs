//! Broken data are seen before any hypothesis; healthy ones are left alone.

mod axes;
mod command;
mod effects;
mod encoders;
mod log;
mod noise;
mod rows;
mod stamps;
mod stretches;
mod unusable;
