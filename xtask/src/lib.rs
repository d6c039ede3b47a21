//! What is done to the project itself; a user of `sesc` needs none of it.

pub mod corrected;
pub mod counts;
pub mod crates;
pub mod fleet_costs;
pub mod fleet_parts;
mod formats;
mod keys;
pub mod regen;
pub mod study;
pub mod study_com;
pub mod study_false_alarms;
pub mod study_fleet;
pub mod study_health;
pub mod study_motion;
pub mod study_recordings;
