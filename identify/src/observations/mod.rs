//! What the robot did and what the foot measured, as fits and diagnoses take it.
//!
//! ```text
//! logs ─▶ grouping (rows of one posture) ─▶ repeats ─▶ noise
//!    ├──▶ moving (rows with their motion) ─▶ zmp
//!    └──▶ rows (regressor, tilt, supports)      postures (a log in memory)
//! ```

pub(crate) mod approach;
pub(crate) mod correlation;
pub(crate) mod criteria;
pub(crate) mod grouping;
pub(crate) mod motion;
pub(crate) mod motion_use;
pub(crate) mod moving;
pub(crate) mod noise;
pub(crate) mod postures;
pub(crate) mod repeats;
pub(crate) mod revisits;
pub(crate) mod row_matrix;
pub(crate) mod rows;
pub(crate) mod sample_count;
pub(crate) mod stays;
pub(crate) mod zmp;

pub use motion::{Plan, Wanted};
pub use postures::{Postures, rms};
pub use rows::Measurement;
pub use zmp::Zmp;
