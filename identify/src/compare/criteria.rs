//! When two models differ; chosen, not calibrated.

/// A difference that chance makes more often than this is none. Chosen: it is the rate of false
/// alarms itself (closed form).
pub const CHANCE: f64 = 0.01;
/// Parameters that are listed as the largest changes. Chosen: it shortens a list alone.
pub const LISTED: usize = 5;
/// A chance below this is said to be below it, for further digits of it mean nothing. Chosen: it
/// changes a sentence alone.
pub const LEAST_CHANCE: f64 = 1e-12;
