//! What the robot did and what the foot measured, as fits and diagnoses take it.
//!
//! ```text
//! logs ─▶ grouping (rows of one posture) ─▶ repeats ─▶ noise
//!    ├──▶ moving (rows with their motion) ─▶ zmp
//!    └──▶ rows (regressor, tilt, supports)      postures (a log in memory)
//! ```

pub mod correlation;
pub(crate) mod criteria;
pub(crate) mod grouping;
pub mod motion;
pub mod motion_use;
pub(crate) mod moving;
pub mod noise;
pub mod postures;
pub(crate) mod repeats;
pub mod revisits;
pub mod row_matrix;
pub mod rows;
pub mod samples;
pub mod stays;
pub mod zmp;
