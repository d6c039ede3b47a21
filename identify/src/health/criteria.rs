//! From which size on something is wrong, in one place, with reasons.

/// A deviation where none is known yet, m.
pub(super) const UNKNOWN_NOISE_M: f64 = 1e-3;

/// Motion is looked at if the gap to the CoP by CAD is larger than so many deviations.
pub(super) const MOVED: f64 = 3.0;

/// An axis is dead if under every wiring CAD moves it by so many times what it moves …
pub(super) const MUST_MOVE: f64 = 4.0;
/// … and goes with no posture in so many rows, at least.
pub(super) const SILENT_ROWS: usize = 20;
/// It goes with the other axis by more than this where the two are exchanged.
pub(super) const EXCHANGED: f64 = 0.9;
/// A column that moves by less does not move, m.
pub(super) const CONSTANT_M: f64 = 1e-9;
/// It is dead then if CAD moves the CoP by more, m: no sensor is so quiet.
pub(super) const MOVES_M: f64 = 1e-4;

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
/// Rows are shuffled only if CAD moves the CoP by so many deviations of its noise: a fit to
/// CAD would show then.
pub(super) const SHUFFLED_MOVES: f64 = 3.0;
/// Ratio of scatters that counts as the same.
pub(super) const ALIKE: (f64, f64) = (0.6, 1.6);
/// One in this many shuffled logs agrees with some wiring by chance.
pub(super) const CHANCE: f64 = 1000.0;

/// Largest change of an encoder that does not move, rad or m.
pub(super) const STILL: f64 = 1e-9;
/// χ² a reading from which a stuck encoder is looked for.
pub(super) const STUCK_CHI2: f64 = 9.0;
/// Share of postures in which the joint is within its limits then.
pub(super) const STUCK_SHARE: f64 = 0.9;
/// A joint that its encoder does not follow moves by this, RMS, rad; m for a prismatic one.
pub(super) const LEAST_MOTION: (f64, f64) = (0.04, 0.008);
/// Part of χ² that may be left then, for masses are not known exactly; or this a posture.
pub(super) const STUCK_LEFT: f64 = 0.02;
pub(super) const STUCK_NOISE: f64 = 4.0;
/// One offset of the joint itself explains the readings as well as its motion does if it leaves
/// no more than so many times as much.
pub(super) const ONE_AS_WELL: f64 = 8.0;
/// Part of χ² from which one offset or one scale of another joint is the simpler explanation.
pub(super) const SIMPLE_SHARE: f64 = 0.95;
/// A wiring explains the readings as well if it leaves no more than so many times as much, the
/// sensor's zero and gain free.
pub(super) const AS_WELL: f64 = 2.0;
/// How far a joint with a stuck encoder may be from where it says, rad; m if prismatic.
pub(super) const ANYWHERE: (f64, f64) = (0.5, 0.1);

/// Fewer rows than this are no finding.
pub(super) const FEW_ROWS: usize = 3;
/// Less than this part of the median load is no contact …
pub(super) const LOADED: f64 = 0.2;
/// … nor is a CoP of exactly zero where CAD has it further away than this, m …
pub(super) const CAD_ELSEWHERE_M: f64 = 0.001;
/// … unless so many rows are like that: then the sensor is off.
pub(super) const MOST_LOST: f64 = 0.9;
/// A reading is frozen if it stays for so many times as many rows as others do …
pub(super) const FROZEN_LONGER: usize = 4;
/// … while CAD moves the CoP by so many deviations of the noise, by this, m, and by so many
/// steps of the channel.
pub(super) const FROZEN_MOVES: f64 = 5.0;
pub(super) const FROZEN_MOVES_M: f64 = 1e-3;
pub(super) const FROZEN_STEPS: f64 = 3.0;
/// How far beyond the cells and the cloud of CAD's CoPs no effect takes a reading, m, in
/// diameters of the sole where its shape is known, and in diameters of the cloud.
pub(super) const MARGIN_M: f64 = 0.15;
pub(super) const MARGIN_OF_SOLE: f64 = 0.5;
pub(super) const MARGIN_OF_CLOUD: f64 = 1.0;
/// With more rows outside than this none is left out.
pub(super) const MOST_OUTSIDE: f64 = 0.2;
/// Readings in another unit (cm, mm) scatter so many times as much as CAD says.
pub(super) const OTHER_UNIT: f64 = 10.0;
/// Between these parts of the readings lie most: no fault is in so many rows.
pub(super) const SPREAD: (f64, f64) = (0.2, 0.8);
/// A channel is clipped if so large a part of its values are its end …
pub(super) const CLIPPED_SHARE: f64 = 0.01;
/// … and so many times more than are the next value.
pub(super) const CLIPPED_MORE: usize = 3;
/// Steps of a channel are coarse above so many deviations of the noise, or, where that is not
/// known, with fewer levels than this within its scatter.
pub(super) const COARSE_NOISE: f64 = 3.0;
pub(super) const COARSE_LEVELS: f64 = 3.0;
/// Rows are copied if so large a part agrees with earlier ones …
pub(super) const COPIED_SHARE: f64 = 0.01;
/// … unless so large a part of the readings comes again at other joint positions …
pub(super) const HELD_SHARE: f64 = 0.02;
/// … or the channels move in steps above this part of their scatter.
pub(super) const FINE: f64 = 1e-3;

/// Noise is overstated if it is so many times what is left …
pub(super) const OVERSTATED: f64 = 2.0;
/// … and there are so many independent samples for each unknown that was fitted: fewer, and
/// the fit has eaten the rest …
pub(super) const SAMPLES_PER_UNKNOWN: f64 = 4.0;
/// … or, where rows are independent, chance leaves as little this seldom.
pub(super) const OVERSTATED_BY_CHANCE: f64 = 1e-6;
