//! From postures and CoP to parameters, their uncertainty, and what the data
//! cannot say.
//!
//! ```text
//! observations → gather (factors) → lsq (with prior) → estimate → identification
//! ```

pub mod corrected;
mod criteria;
mod estimate;
#[cfg(test)]
mod freed_tests;
mod gather;
mod identification;
mod logs;
#[cfg(test)]
mod mass_tests;
pub(crate) mod masses;
#[cfg(test)]
mod noise_tests;
pub(crate) mod offset;
pub mod part;
pub mod population;
pub mod prior;
mod request;
pub mod residuals;
mod robust;
mod run;
mod timing;

pub use crate::observations::motion_use::{MotionModel, MotionUse, Share};
pub use crate::observations::noise::NoiseSource;
pub use crate::observations::repeats::{LackOfFit, Visits};
pub use crate::observations::revisits::Again;
pub use crate::observations::sample_count::SampleCount;
pub(crate) use criteria::HELD_OUT_TIMES;
#[doc(hidden)]
pub use estimate::identify;
#[doc(hidden)]
pub use gather::Gathered;
pub use gather::{DownWeighted, LogUsed};
pub use identification::{
    BodyLength, Correlation, HeightConstant, Identification, ParameterFound, Settings, Unseen,
};
#[doc(hidden)]
pub use masses::Masses;
pub(crate) use offset::OFFSET;
pub use offset::Offset;
pub use request::{Duplicates, FOLDS, Request};
pub use robust::Loss;
pub use run::{Report, fit, gather, residuals};
pub(crate) use run::{check_result, gather_as};
