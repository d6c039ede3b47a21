//! When something is said of a fleet. `cargo xtask study fleet` counts what comes of all of
//! these numbers together.

/// Chance that a fleet of which nothing is wrong gets a shared effect, and that it gets a
/// change: corrected for everything that is looked at in the whole fleet. Chosen: it is the
/// rate of false alarms itself; `cargo xtask study fleet` counts them.
pub const FALSE_ALARM: f64 = 0.01;

/// An effect of the last day alone counts if it is so many deviations large. Chosen: half of it
/// lists robots for one odd day.
pub const CLEAR: f64 = 8.0;

/// Chance that a finding about the data is in a log of a sound robot, at most; taken for the
/// verdict `unexplained`, too. Calibrated on the study of health, where 0 of 300 healthy logs have
/// a finding: 1 % is the upper end of its 95 % interval. Half of it halves the chances that are
/// said of findings, and moves no robot.
pub const FALSE_FINDING: f64 = 0.01;

/// Fewer robots say nothing of how robots are spread. Chosen: four degrees of freedom know a
/// spread to a third (closed form).
pub const ROBOTS: usize = 5;

/// Where more than this part of the robots have effects of their own, bodies are said to differ.
/// Chosen: half of it is reached by a fleet with several batches whose sizes scatter.
pub const OWN_EFFECTS: f64 = 0.5;

/// What changed in a robot.
pub mod changes {
    /// Deviations of an effect on a day that does not show it. Chosen: half of it makes an
    /// effect that is not named on a day smaller than it may be, and changes too many.
    pub const UNSEEN: f64 = 3.0;
    /// Effects and targets that a diagnosis may name. Chosen: a factor of two moves the
    /// threshold by 0.1 deviations (closed form).
    pub const HYPOTHESES: f64 = 500.0;
    /// A day that differs from those before it by so many deviations begins a change. Chosen:
    /// half of it dates changes too early; twice as much dates drifts late.
    pub const ONSET: f64 = 4.0;
    /// An effect that comes or goes is a change where what is fitted without effects differs by
    /// more than chance makes of it in this part of cases. Chosen: half of it tells small effects
    /// later; the rate of false alarms has its own threshold.
    pub const BORNE_OUT: f64 = 0.01;
    /// Fewer pairs of days with one explanation do not tell how days scatter. Chosen: with half of
    /// it two robots whose masses differ on a day hide what changes in a third.
    pub const PAIRS: usize = 5;
    /// Fewer differences than these do not tell how days scatter. Chosen: the root of the
    /// median of so many squares is off by a quarter (closed form), of half as many by a third.
    pub const DIFFERENCES: usize = 20;
    /// Fewest degrees of freedom that are taken for a row's deviations. Chosen: half of it asks
    /// for larger changes in small fleets.
    pub const LEAST_FREEDOM: f64 = 5.0;
}

/// What robots share.
pub mod shared {
    /// Part of the rows of a robot that an effect has to be possible in to be the robot's.
    /// Chosen: half of it groups robots by single days.
    pub const LASTING: f64 = 0.5;
    /// Robots of a group differ by at most this part of its size. Chosen: half of it splits
    /// batches whose offsets scatter.
    pub const ALIKE: f64 = 0.5;
    /// A window is no narrower than this many deviations of an estimate. Chosen: half of it
    /// takes agreement that estimates cannot have for evidence.
    pub const LEAST_WINDOW: f64 = 2.0;
}
