//! When a whole log looks wrong; chosen, not calibrated.

/// With fewer values no unit is guessed. Chosen: with half as many a robot that stands still
/// has its unit guessed.
pub(crate) const FEW: u64 = 20;
/// An encoder may stand this far beyond its limit, rad. Chosen: 11°; half of it warns of stops
/// that are set by hand.
pub(crate) const SLACK: f64 = 0.2;
/// The CoP of a foot is within its sole: typically further out than this, m, and it was hardly
/// given in metres. Chosen: half of it warns of large soles.
pub(crate) const SOLE: f64 = 0.5;
/// Stamps are hardly in seconds where no joint ever moves faster than this part of its limit, in
/// rows that follow each other smoothly. Chosen: 0.16°/s for a servo of 5.6 rad/s; twice as much
/// doubts robots that creep.
pub(crate) const CREEPS: f64 = 5e-4;
/// In the unit that stamps are in instead, joints move no faster than so many limits. Chosen:
/// stamps jitter, and an interval may be half of the others.
pub(crate) const FASTEST: f64 = 2.0;
/// Rows are then this far apart, s: the rates at which robots are logged. Chosen: 1 Hz to 2 kHz.
pub(crate) const LOGGED: (f64, f64) = (5e-4, 1.0);
/// Rows follow each other smoothly where from one to the next joints move by no more than this
/// part of the variance of two rows drawn at random. Closed form: a sine of 0.4 Hz at 10 Hz has
/// 0.03; postures drawn at random have 1.
pub(crate) const SMOOTH: f64 = 0.05;
/// A joint moves if it scatters by more than this, rad or m. Chosen: below it lies the noise of
/// encoders, which says nothing of speeds.
pub(crate) const MOVES: f64 = 0.01;
/// Rows are of a robot that moves where its steps change by less than this part of themselves, as
/// squares. Closed form: a sine of 0.4 Hz at 10 Hz has 0.06; steps that are independent have 2.
pub(crate) const GOES_ON: f64 = 0.5;
/// Stamps are coarse where more than this part of the rows has that of the row above. Chosen: a
/// clock of 1 ms shares one in a hundred at 1 kHz.
pub(crate) const SHARED: f64 = 0.2;
/// A joint leaps where it moves by more than this, rad or m, and faster than [`FASTER`] limits.
/// Chosen: 3°, above what jitter of stamps makes of a fast motion.
pub(crate) const LEAP: f64 = 0.05;
/// Velocity limits that no joint exceeds by more than this factor. Chosen: servos are up to a
/// third faster than their data sheet says, and stamps jitter.
pub(crate) const FASTER: f64 = 1.5;
/// The limit of joints that have none, rad/s or m/s. Chosen: twice that of fast servos.
#[cfg(feature = "mcap")]
pub(crate) const FASTEST_RAD_S: f64 = 20.0;
/// A leap returns where what remains of it is a smaller part than this. Chosen: a step of a
/// controller overshoots by less.
#[cfg(feature = "mcap")]
pub(crate) const RETURNS: f64 = 0.2;
