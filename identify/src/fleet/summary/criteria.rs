//! When something is said of a fleet. Where no calibration is named, the number was chosen,
//! not calibrated; `cargo xtask study-fleet` counts what comes of all of them together.

/// Chance that a fleet of which nothing is wrong gets a shared effect, and that it gets a
/// change: corrected for everything that is looked at in the whole fleet.
pub const FALSE_ALARM: f64 = 0.01;

/// An effect of the last day alone counts if it is so many deviations large.
pub const CLEAR: f64 = 8.0;

/// Fewer robots say nothing of how robots are spread.
pub const ROBOTS: usize = 5;

/// What changed in a robot.
pub mod changes {
    /// Deviations of an effect on a day that does not show it.
    pub const UNSEEN: f64 = 3.0;
    /// Effects and targets that a diagnosis may name.
    pub const HYPOTHESES: f64 = 500.0;
    /// A day that differs from those before it by so many deviations begins a change.
    pub const ONSET: f64 = 4.0;
    /// Fewer differences than these do not tell how days scatter.
    pub const DIFFERENCES: usize = 20;
    /// Fewest degrees of freedom that are taken for a row's deviations.
    pub const LEAST_FREEDOM: f64 = 5.0;
}

/// What robots share.
pub mod shared {
    /// Part of the rows of a robot that an effect has to be possible in to be the robot's.
    pub const LASTING: f64 = 0.5;
    /// Robots of a group differ by at most this part of its size.
    pub const ALIKE: f64 = 0.5;
    /// A window is no narrower than this many deviations of an estimate.
    pub const LEAST_WINDOW: f64 = 2.0;
}
