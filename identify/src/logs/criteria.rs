//! When a whole log looks wrong; chosen, not calibrated.

/// With fewer values no unit is guessed. Chosen: with half as many a robot that stands still
/// has its unit guessed.
pub const FEW: u64 = 20;
/// An encoder may stand this far beyond its limit, rad. Chosen: 11°; half of it warns of stops
/// that are set by hand.
pub const SLACK: f64 = 0.2;
/// The CoP of a foot is within its sole: typically further out than this, m, and it was hardly
/// given in metres. Chosen: half of it warns of large soles.
pub const SOLE: f64 = 0.5;
