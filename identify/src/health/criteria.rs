//! From which size on something is wrong, in one place, with reasons.

/// An axis is dead if CAD moves it by so many deviations of its noise …
pub(super) const MUST_MOVE: f64 = 20.0;
/// … it moves by less than so many …
pub(super) const SILENT: f64 = 3.0;
/// … and goes with CAD by less than this correlation. Wrong masses and effects leave more.
pub(super) const UNRELATED: f64 = 0.3;
/// It goes with the other axis by more than this where the two are exchanged.
pub(super) const EXCHANGED: f64 = 0.9;
/// A column that moves by less does not move, m.
pub(super) const CONSTANT_M: f64 = 1e-9;

/// A gap from which the frame is asked about, m: a sensor's zero is rarely so far off.
pub(super) const FAR_M: f64 = 0.02;
/// The right frame leaves no more than this part of the gap.
pub(super) const FITS: f64 = 0.2;
/// A wiring explains the readings better than another frame does if it leaves less than
/// this part of what is left there; both may have any offset and gain of the sensor.
pub(super) const BETTER: f64 = 0.5;
/// Links that are tried as the other foot, at most.
pub(super) const FEET: usize = 64;

/// Postures that shuffling can be seen in, at least.
pub(super) const ENOUGH: usize = 30;
/// Ratio of scatters that counts as the same.
pub(super) const ALIKE: (f64, f64) = (0.6, 1.6);
/// Of so many shuffled logs one looks as if it went with some wiring.
pub(super) const CHANCE: f64 = 1000.0;

/// Largest change of an encoder that does not move, rad or m.
pub(super) const STILL: f64 = 1e-9;
/// χ² a reading from which a stuck encoder is looked for.
pub(super) const STUCK_CHI2: f64 = 9.0;
/// Share of postures in which the joint is within its limits then.
pub(super) const STUCK_SHARE: f64 = 0.9;
/// A joint that its encoder does not follow moves by this, RMS, rad; m for a prismatic one.
pub(super) const LEAST_MOTION: (f64, f64) = (0.1, 0.02);
/// Part of χ² that may be left then, for masses are not known exactly; or this a posture.
pub(super) const STUCK_LEFT: f64 = 0.02;
pub(super) const STUCK_NOISE: f64 = 4.0;
/// Part of χ² from which one offset or one scale is the simpler explanation.
pub(super) const SIMPLE_SHARE: f64 = 0.8;
/// A wiring explains the gap if it leaves less than this part, the sensor's zero and gain free.
pub(super) const KNOWN: f64 = 0.3;
/// How far a joint with a stuck encoder may be from where it says, rad; m if prismatic.
pub(super) const ANYWHERE: (f64, f64) = (0.5, 0.1);
