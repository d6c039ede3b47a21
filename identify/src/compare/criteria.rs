//! When two models differ; chosen, not calibrated.

/// A difference that chance makes more often than this is none.
pub const CHANCE: f64 = 0.01;
/// Parameters that are listed as the largest changes.
pub const LISTED: usize = 5;
