//! Where simulation and measurement disagree, and why.
//!
//! ```text
//! observations → hypothesis (problem) → search → evidence → verdict (criteria) → report
//!                                                        └→ experiments, next postures
//! ```

mod backlash_sides;
pub mod corrected_urdf;
pub mod criteria;
pub mod diagnosis;
mod dictionary;
pub mod experiment;
pub mod findings;
pub mod further_logs;
pub mod held_out;
pub mod hypothesis;
pub mod leftover;
pub mod model_file;
pub mod next_postures;
pub mod nuisance;
pub mod outliers;
pub mod problem;
mod proposal;
mod request;
pub mod search;
#[cfg(test)]
mod tests;
mod verdict;
pub mod view;
mod wiring;
pub mod words;

pub use findings::{Diagnosis, Verdict};
pub use request::{NextLog, Report, Request, diagnose};
