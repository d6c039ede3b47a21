//! From postures and CoP to parameters, their uncertainty, and what the data
//! cannot say.
//!
//! ```text
//! posture_log → measurement → gather (factors) → solve (with prior) → fit → identification
//! ```

pub mod corrected;
mod estimate;
pub mod factor;
pub mod gather;
pub mod identification;
pub mod limits;
pub mod logs;
#[cfg(test)]
mod mass_tests;
pub mod masses;
pub mod measurement;
pub mod noise;
mod noise_level;
#[cfg(test)]
mod noise_tests;
mod non_negative;
pub mod part;
pub mod physical;
pub mod prior;
pub mod quadratic;
pub mod residuals;
pub mod robust;
pub mod solve;
mod statements;

pub use estimate::{identify, identify_within};
pub use identification::{Identification, Settings};
