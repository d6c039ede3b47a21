//! What is asked of a fit.

use std::sync::Arc;

use sesc_model::Snapping;

use super::part::Part;
use super::prior::PriorChoice;
use super::robust::Loss;
use crate::feet::Feet;
use crate::logs::{Angles, LogSource, Stays};
use crate::observations::motion_use::MotionModel;
use crate::robot::Robot;

/// Folds of the cross-validation unless given.
pub const FOLDS: usize = 10;

/// What is to be fitted, and how.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Request {
    /// The robot of the logs; that of the parts unless given.
    pub robot: Option<Arc<Robot>>,
    /// Logs: paths, bytes or tables.
    pub logs: Vec<LogSource>,
    /// What was gathered of other logs, each with the name that messages give it.
    pub parts: Vec<(String, Part)>,
    /// The link whose parameters are meant, and on the ground in rows that do not say;
    /// the first log's own unless given.
    pub support: Option<String>,
    /// Whether decimals of right angles are made exact.
    pub snapping: Snapping,
    /// Unit of revolute joints; the sidecar's, else rad, unless given.
    pub angles: Option<Angles>,
    /// How far masses may be off CAD.
    pub prior: PriorChoice,
    /// Standard deviation of a single reading on one axis, m; the log's unless given.
    pub noise: Option<f64>,
    /// Trust postures less that no noise explains.
    pub robust: Option<Loss>,
    /// Folds of the cross-validation; [`FOLDS`], or those of the parts, unless given.
    pub folds: Option<usize>,
    /// Errors are expected for joints within ± this of zero, rad; else for their limits.
    pub range: Option<f64>,
    /// Standard deviation of an offset of readings before the data, m: 0 for none; as readings of
    /// feet and plates are off unless given.
    pub offset: Option<f64>,
    /// Whether masses have to be possible.
    pub physical: bool,
    /// Whether some of the readings are wanted beside their predictions.
    pub residuals: bool,
    /// Whether the motion of the joints counts.
    pub motion: MotionModel,
    /// What becomes of rows in which the robot holds still.
    pub stays: Stays,
    /// Which feet are on the floor; each log's own unless given.
    pub feet: Feet,
    /// The robot of its type that the logs are of, such as its serial number: parts of another
    /// one are refused.
    pub unit: Option<String>,
    /// What becomes of logs that are in a part already.
    pub duplicates: Duplicates,
}

/// What becomes of logs that are in a part already.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Duplicates {
    /// They are an error: their postures would count twice.
    #[default]
    Refuse,
    /// A part whose logs are all there already is left out.
    Skip,
}
