//! From postures and CoP to parameters, their uncertainty, and what the data
//! cannot say.
//!
//! ```text
//! observations → gather (factors) → lsq (with prior) → estimate → identification
//! ```

mod again;
pub mod corrected;
mod estimate;
pub mod gather;
pub mod identification;
mod limits;
pub mod logs;
#[cfg(test)]
mod mass_tests;
pub(crate) mod masses;
#[cfg(test)]
mod noise_tests;
pub mod part;
mod physical;
pub mod prior;
mod request;
pub mod residuals;
pub mod robust;
mod soles;
mod stream;
mod summary;
pub mod timing;

pub use crate::observations::motion_use::{MotionModel, MotionUse, Share};
pub use estimate::{identify, identify_within};
pub use identification::{Identification, Settings};
pub(crate) use request::check_result;
pub use request::{FOLDS, Report, Request, fit, gather, residuals};
