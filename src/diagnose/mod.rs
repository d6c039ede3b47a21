//! Where simulation and measurement disagree, and why.
//!
//! ```text
//! posture_log → data → problem (evidence of a hypothesis) → search → verdict
//! ```

pub mod data;
mod dictionary;
pub mod nuisance;
pub mod outliers;
pub mod problem;
pub mod search;
mod sides;
mod wiring;
