//! From postures and CoP to parameters, their uncertainty, and what the data
//! cannot say.
//!
//! ```text
//! posture_log → measurement → gather (factors) → solve (with prior) → identification
//! ```

pub mod factor;
pub mod fit;
pub mod gather;
pub mod identification;
pub mod logs;
pub mod measurement;
pub mod noise;
pub mod part;
pub mod prior;
pub mod robust;
pub mod solve;

pub use identification::{Identification, Settings, identify};
