//! What the robot did and what the foot measured, as fits and diagnoses take it.
//!
//! ```text
//! logs → grouping (rows of one posture)
//! ```

pub mod grouping;
