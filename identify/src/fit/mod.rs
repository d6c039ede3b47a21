//! From postures and CoP to parameters, their uncertainty, and what the data
//! cannot say.
//!
//! ```text
//! observations → gather (factors) → lsq (with prior) → estimate → identification
//! ```

pub mod corrected;
mod criteria;
mod estimate;
pub mod fitted;
#[cfg(test)]
mod freed_tests;
mod gather;
mod identification;
mod joined;
mod limits;
mod logs;
mod looked;
#[cfg(test)]
mod mass_tests;
pub(crate) mod masses;
#[cfg(test)]
mod noise_tests;
pub mod part;
mod physical;
pub mod population;
pub mod prior;
mod report;
mod request;
pub mod residuals;
mod revisits;
mod robust;
mod soles;
mod stream;
mod summary;
mod timing;

pub use crate::observations::motion_use::{MotionModel, MotionUse, Share};
pub use crate::observations::noise::NoiseSource;
pub use crate::observations::repeats::{LackOfFit, Visits};
pub use crate::observations::revisits::Again;
pub use crate::observations::samples::Samples;
#[doc(hidden)]
pub use estimate::identify;
#[cfg(test)]
use estimate::identify_within;
#[doc(hidden)]
pub use gather::Gathered;
pub use gather::{DownWeighted, LogUsed};
pub use identification::{
    BodyLength, Correlation, HeightConstant, Identification, ParameterFound, Settings, Unseen,
};
#[doc(hidden)]
pub use logs::Logs;
pub use looked::gather;
pub(crate) use looked::gather_as;
pub(crate) use report::check_result;
pub use report::{Report, fit, residuals};
pub use request::{Duplicates, FOLDS, Request};
pub use robust::Loss;
