//! When something said of a fleet is more than chance.

/// Chance that a fleet of which nothing is wrong gets a shared effect, and that it gets a
/// change: corrected for everything that is looked at in the whole fleet.
pub const FALSE_ALARM: f64 = 0.01;
