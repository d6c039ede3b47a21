//! Where simulation and measurement disagree, and why.
//!
//! ```text
//! posture_log → data → problem (evidence of a hypothesis) → search → diagnosis
//! ```

pub mod corrected_urdf;
pub mod criteria;
pub mod diagnosis;
mod dictionary;
pub mod experiment;
pub mod findings;
pub mod further;
pub mod held_out;
pub mod hypothesis;
pub mod leftover;
pub mod model_file;
pub mod next_postures;
pub mod nuisance;
pub mod outliers;
pub mod problem;
pub mod search;
mod sides;
#[cfg(test)]
mod tests;
mod verdict;
pub mod view;
mod wiring;
pub mod words;

pub use diagnosis::{diagnose, diagnose_all};
pub use findings::{About, Diagnosis, Found, Verdict};
