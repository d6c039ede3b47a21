//! When a whole log looks wrong; chosen, not calibrated.

/// With fewer values no unit is guessed.
pub const FEW: u64 = 20;
/// An encoder may stand this far beyond its limit, rad.
pub const SLACK: f64 = 0.2;
/// The CoP of a foot is within its sole: typically further out than this, m,
/// and it was hardly given in metres.
pub const SOLE: f64 = 0.5;
