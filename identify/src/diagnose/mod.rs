//! Where simulation and measurement disagree, and why.
//!
//! ```text
//! observations → hypothesis (problem) → search → evidence → verdict (criteria) → report
//!                                                        └→ experiments, next postures
//! ```

mod criteria;
mod diagnosis;
mod dictionary;
mod experiment;
mod findings;
mod functions;
mod held_out;
mod hypothesis;
mod leftover;
mod model_file;
mod motion;
mod noise;
mod nuisance;
mod outliers;
mod problem;
pub mod remedy;
mod request;
mod samples;
mod search;
#[cfg(test)]
mod tests;
mod verdict;
#[doc(hidden)]
pub mod view;
#[doc(hidden)]
pub mod words;

pub(crate) use criteria::TOLD_APART;
pub use criteria::{CLASS_SCORE, FLOOR_M, OVER_NOTHING};
pub use experiment::NextLog;
pub use findings::{
    ActsOn, Blind, Change, Diagnosis, ExperimentProposal, Gap, Last, Leftover, Member, ModelOnLog,
    NextPostures, Quantity, Remedy, Score, Step, Suspect, UrdfChange, Verdict,
};
pub(crate) use hypothesis::FREE_MASSES;
#[doc(hidden)]
pub use hypothesis::{MODEL_PAGES, subject};
pub use request::{Report, Request, diagnose, look};
