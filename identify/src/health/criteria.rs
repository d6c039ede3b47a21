//! From which size on something is wrong, in one place, with reasons; `cargo xtask study health`
//! counts what comes of all of these numbers together.

/// A deviation where none is known yet, m. Chosen: 1 mm is large for a force plate and small
/// for foot cells; twice as much overlooks small faults.
pub(super) const UNKNOWN_NOISE_M: f64 = 1e-3;

/// Motion is looked at if the gap to the CoP by CAD is larger than so many deviations. Chosen:
/// half of it looks at motion in logs that stand.
pub(super) const MOVED: f64 = 3.0;
/// The same where the noise is not known, m. Chosen: [`MOVED`] times the noise of a good force
/// plate; half of it looks at motion in nearly every log.
pub(super) const MOVED_M: f64 = 1e-3;

/// An axis is dead if under every wiring CAD moves it by so many times what it moves, and it
/// goes with no posture in [`SILENT_ROWS`]. Chosen: half of it calls an axis of a soft sole
/// dead.
pub(super) const MUST_MOVE: f64 = 4.0;
/// Rows in which an axis goes with no posture, at least, to be dead. Chosen: with half as many
/// chance hides what it goes with.
pub(super) const SILENT_ROWS: usize = 20;
/// It goes with the other axis by more than this where the two are exchanged. Chosen: an axis
/// with noise of half its motion goes with it by 0.9 (closed form).
pub(super) const EXCHANGED: f64 = 0.9;
/// A column that moves by less does not move, m. Chosen: far below a digit of any sensor.
pub(super) const CONSTANT_M: f64 = 1e-9;
/// A constant column is dead if CAD moves the CoP by more, m: no sensor is so quiet. Chosen:
/// twice as much overlooks dead axes of robots that hardly move.
pub(super) const MOVES_M: f64 = 1e-4;

/// A gap from which the frame is asked about, m: a sensor's zero is rarely so far off. Chosen:
/// half of it asks for other frames in sound logs, which costs time.
pub(super) const FAR_M: f64 = 0.02;
/// The right frame leaves no more than this part of the gap. Chosen: twice as much names a
/// frame by chance where the robot also has a payload.
pub(super) const FITS: f64 = 0.2;
/// A wiring explains the readings better than another frame does if it leaves less than this
/// part of what is left there; both may have any offset and gain of the sensor. Chosen: as
/// [`FITS`]; half of it asks wirings to be far better.
pub(super) const BETTER: f64 = 0.5;
/// Links that are tried as the other foot, at most. Chosen: it costs time.
pub(super) const FEET: usize = 64;

/// Postures that shuffling can be seen in, at least. Chosen: half as many and chance orders
/// rows.
pub(super) const ENOUGH: usize = 30;
/// Rows are shuffled only if CAD moves the CoP by so many deviations of its noise: a fit to CAD
/// would show then. Chosen: half of it asks of logs in which noise hides the order.
pub(super) const SHUFFLED_MOVES: f64 = 3.0;
/// Ratio of scatters that counts as the same. Chosen: shuffling keeps the scatter exactly; the
/// factor is what an effect may add.
pub(super) const ALIKE: (f64, f64) = (0.6, 1.6);
/// One in this many shuffled logs agrees with some wiring by chance. Chosen: it is the rate of
/// false alarms itself.
pub(super) const CHANCE: f64 = 1000.0;

/// Largest change of an encoder that does not move, rad or m. Chosen: far below a tick of any
/// encoder.
pub(super) const STILL: f64 = 1e-9;
/// χ² a reading from which a stuck encoder is looked for, the noise taken for
/// [`UNKNOWN_NOISE_M`] where it is not known. Chosen: twice as much overlooks what quiet sensors
/// show; half of it looks in logs that fit, which costs time.
pub(super) const STUCK_LOOKS: f64 = 1.5;
/// χ² a reading from which a stuck encoder is found; where the noise is not known, of the noise
/// that motion of the joint leaves. Chosen: motion of two deviations on each axis has 5 (closed
/// form); half as much takes an encoder's own errors for it.
pub(super) const STUCK_CHI2: f64 = 6.0;
/// And so many times what motion of the joint leaves of one reading, for readings may go with the
/// other joints' motion. Chosen: half of it takes noise that is larger than it is thought to be
/// for what a joint hides.
pub(super) const STUCK_LESS: f64 = 3.0;
/// Share of postures in which the joint is within its limits then, or beyond them by no more than
/// [`BEYOND_LIMITS`]. Chosen: less allows positions that the joint cannot have.
pub(super) const STUCK_SHARE: f64 = 0.9;
/// Part of the range of a joint by which it may be beyond its limits. Chosen: limits in URDFs are
/// often those of commands; half of it misses knees that are straight.
pub(super) const BEYOND_LIMITS: f64 = 0.2;
/// A joint that its encoder does not follow moves by this, RMS, rad; m for a prismatic one.
/// Chosen: a common offset of an encoder; half of it takes compliance for motion.
pub(super) const LEAST_MOTION: (f64, f64) = (0.025, 0.005);
/// Part of χ² that may be left then, for masses are not known exactly; or this a posture.
/// Chosen: half of it misses stuck encoders where masses are off; see `docs/dev/study/health.txt`
/// for what is found.
pub(super) const STUCK_LEFT: f64 = 0.02;
/// Chosen: as [`STUCK_LEFT`], for small logs.
pub(super) const STUCK_NOISE: f64 = 4.0;
/// One number for all postures, such as an offset of the joint itself, explains the readings as
/// well as its motion does if it leaves no more than so many times as much. Chosen: half of it
/// takes offsets of encoders that stay for stuck ones.
pub(super) const ONE_AS_WELL: f64 = 8.0;
/// Part of χ² from which one offset or one scale of another joint is worth a closer look.
/// Chosen: less looks at more of them, which costs time.
pub(super) const SIMPLE_SHARE: f64 = 0.9;
/// A wiring explains the readings if it leaves no more than this of the noise, variance over
/// variance, the sensor's zero and gain free. Chosen: of 38 postures the noise itself is known to
/// 16 % (closed form); twice as much above 1 lets a swap of joints explain what a stuck one does
/// in a slow motion.
pub(super) const WIRED_NOISE: f64 = 1.2;
/// And so many times what motion of the joint leaves beyond the noise. Chosen: masses that are
/// off leave twice as much beside a wiring as beside one unknown a posture (closed form); half of
/// it names faults that a wiring explains.
pub(super) const WIRED_BESIDE: f64 = 2.5;
/// Masses within the usual tolerances of CAD explain the readings as well if they leave no more
/// than so many times as much a reading. Chosen: true ones leave as much as the noise, which 38
/// postures know to 16 % (closed form); half as much above 1 takes chance for what they do not
/// explain, twice as much misses quiet sensors.
pub(super) const BY_MASSES: f64 = 1.5;
/// Variance of the least noise where nothing states it, in squares of [`UNKNOWN_NOISE_M`].
/// Chosen: of a micrometre; readings without noise have some rounding.
pub(super) const QUIETEST: f64 = 1e-6;
/// How far a joint with a stuck encoder may be from where it says, rad; m if prismatic. Chosen:
/// 29° and 10 cm; less misses joints that hang.
pub(super) const ANYWHERE: (f64, f64) = (0.5, 0.1);

/// An encoder that stops in the middle of a log does so for so many rows, and for so large a part
/// of them. Chosen: a second at 50 Hz; half of it looks at every stay of a posture.
pub(super) const PARKED_ROWS: usize = 50;
/// Chosen: as [`PARKED_ROWS`], for long logs: what less moves is small beside noise that lasts.
pub(super) const PARKED_SHARE: f64 = 0.01;
/// CAD is so many times as far off in these rows as in the others. Chosen: an effect of the joint
/// that is held for a while is there before and after, too; half of it takes one for the other.
pub(super) const PARKED_WORSE: f64 = 2.0;

/// Fewer rows than this are no finding. Chosen: half of it reports single dropped messages.
pub(super) const FEW_ROWS: usize = 3;
/// Less than this part of the median load is no contact; see [`CAD_ELSEWHERE_M`] and
/// [`MOST_LOST`]. Chosen: twice as much calls a foot that is half unloaded lost.
pub(super) const LOADED: f64 = 0.2;
/// A CoP of exactly zero is no contact where CAD has it further away than this, m. Chosen: a
/// sound CoP of exactly zero is rare at any distance.
pub(super) const CAD_ELSEWHERE_M: f64 = 0.001;
/// With more rows like that the sensor is off. Chosen: the sentence changes, not what is left
/// out.
pub(super) const MOST_LOST: f64 = 0.9;
/// A reading is frozen if it stays for so many times as many rows as others do while CAD moves
/// the CoP. Chosen: half of it calls slow sensors frozen.
pub(super) const FROZEN_LONGER: usize = 4;
/// CAD moves the CoP of a frozen reading by so many deviations of the noise. Chosen: half of it
/// calls coarse sensors frozen.
pub(super) const FROZEN_MOVES: f64 = 5.0;
/// It moves by this at least, m. Chosen: as [`FROZEN_MOVES`], where noise is not known.
pub(super) const FROZEN_MOVES_M: f64 = 1e-3;
/// It moves by so many steps of the channel, too. Chosen: as [`FROZEN_MOVES`].
pub(super) const FROZEN_STEPS: f64 = 3.0;
/// How far beyond the cells and the cloud of CAD's CoPs no effect takes a reading, m; see
/// [`MARGIN_OF_SOLE`] and [`MARGIN_OF_CLOUD`]. Chosen: half of it leaves out readings of robots
/// with large offsets.
pub(super) const MARGIN_M: f64 = 0.15;
/// Such a margin in diameters of the sole where its shape is known. Chosen: as [`MARGIN_M`].
pub(super) const MARGIN_OF_SOLE: f64 = 0.5;
/// Such a margin in diameters of the cloud of CoPs by CAD. Chosen: as [`MARGIN_M`].
pub(super) const MARGIN_OF_CLOUD: f64 = 1.0;
/// With more rows outside than this none is left out. Chosen: then the model is wrong, not the
/// rows.
pub(super) const MOST_OUTSIDE: f64 = 0.2;
/// None is left out, either, where a wiring has CAD's CoP in these rows at less than this part of
/// its distance from the readings. Chosen: a wiring that is the cause leaves a tenth and less;
/// twice as much takes faults of a sensor for one.
pub(super) const WIRED_NEARER: f64 = 0.5;
/// Readings in another unit (cm, mm) scatter so many times as much as CAD says. Chosen: the
/// root of 100 between cm and m; a factor of two is far from 100 and 1000 alike.
pub(super) const OTHER_UNIT: f64 = 10.0;
/// Between these parts of the readings lie most: no fault is in so many rows. Chosen: wider
/// ends take faults into the range of sound readings.
pub(super) const SPREAD: (f64, f64) = (0.2, 0.8);
/// A channel is clipped if so large a part of its values are its end, and [`CLIPPED_MORE`]
/// times more than are the next value. Chosen: half of it reports extremes that were reached
/// twice.
pub(super) const CLIPPED_SHARE: f64 = 0.01;
/// How many times more often the end of a clipped channel comes than the next value. Chosen: as
/// [`CLIPPED_SHARE`].
pub(super) const CLIPPED_MORE: usize = 3;
/// Steps of a channel are coarse above so many deviations of the noise, or, where that is not
/// known, with fewer levels than this within its scatter. Chosen: steps add Δ²/12 to the
/// variance (closed form): as much as noise at 3.5 deviations.
pub(super) const COARSE_NOISE: f64 = 3.0;
/// Levels within the scatter of a channel below which its steps are coarse, where noise is not
/// known. Chosen: as [`COARSE_NOISE`].
pub(super) const COARSE_LEVELS: f64 = 3.0;
/// Rows are copied if so large a part agrees with earlier ones; see [`HELD_SHARE`] and
/// [`FINE`]. Chosen: half of it reports a few repeated messages.
pub(super) const COPIED_SHARE: f64 = 0.01;
/// They are not if so large a part of the readings comes again at other joint positions.
/// Chosen: twice as much reports sensors slower than the joints.
pub(super) const HELD_SHARE: f64 = 0.02;
/// They are not if the channels move in steps above this part of their scatter. Chosen: with
/// coarser steps rows agree by chance.
pub(super) const FINE: f64 = 1e-3;

/// Noise is overstated if it is so many times what is left; see [`SAMPLES_PER_UNKNOWN`] and
/// [`OVERSTATED_BY_CHANCE`]. Chosen: half of it warns of every log.
pub(super) const OVERSTATED: f64 = 2.0;
/// Independent samples for each unknown that was fitted, at least: with fewer the fit has eaten
/// the rest. Chosen: with these what is left is 0.87 of the noise, with half as many 0.71
/// (closed form).
pub(super) const SAMPLES_PER_UNKNOWN: f64 = 4.0;
/// Where rows are independent, chance leaves as little this seldom. Chosen: it is the rate of
/// false alarms itself.
pub(super) const OVERSTATED_BY_CHANCE: f64 = 1e-6;

/// Time runs backwards if more than this part of the rows is stamped before the one above it.
/// Chosen: recordings that were put behind one another run backwards where they meet only.
pub(super) const BACKWARDS: f64 = 0.9;
/// Stamps are looked at if more than this part of the rows is stamped before the one above it.
/// Chosen: of stamps in any order it is half (closed form); packets of a network are out of
/// order by a few per cent.
pub(super) const OUT_OF_ORDER: f64 = 0.2;
/// Joints jump from stamp to stamp by more than this part of what rows in any order do, where
/// stamps are of other rows. Chosen: with half of it jitter of stamps that are dense is enough.
pub(super) const JUMPS: f64 = 0.5;
/// From row to row they jump by no more than this part of that. Chosen: a sine of 0.4 Hz at
/// 4 Hz has 0.2 (closed form); postures drawn at random have 1.
pub(super) const JUMPS_LESS: f64 = 0.25;

/// The sensor's axes are turned about the normal by this at least, rad. Chosen: 17°; smaller
/// ones are sensors that were not mounted straight, which the effect `sensor_rotation` is for.
pub(super) const LEAST_YAW: f64 = 0.3;
/// A turn this near to a right angle is one, rad. Chosen: 6°; a few degrees of it are a payload.
pub(super) const RIGHT_ANGLE: f64 = 0.1;
/// Turned axes leave no more than this part of what CAD and every wiring leave, each with any
/// zero and gain of the sensor, in quadrature beside the noise. Chosen: a turn by 30° leaves half
/// of CAD's CoP to the gap (closed form); with larger parts other effects of that size are
/// taken for turns.
pub(super) const TURNED_LEAVES: f64 = 0.5;
/// The gap is looked at from so many deviations of the noise on. Chosen: below it noise hides
/// what is turned.
pub(super) const TURNED_SHOWS: f64 = 2.0;
/// Free masses leave so many times more of the readings as they stand than of the readings
/// turned back, m over m. Chosen: with 30 independent samples the odds are e²⁴ (closed form);
/// half as much above 1 is what noise and motion leave of either.
pub(super) const MASSES_LEAVE: f64 = 1.5;

/// A joint without a velocity limit leaps where it is so many times as fast as in the middle of its
/// moves. Chosen: a sine spends half of its time above 0.7 of its peak (closed form); joints that
/// creep between fast moves have 5.
pub(super) const TIMES_MEDIAN: f64 = 10.0;
/// Between rows that are further apart, s, no leap is seen: much may happen there. Chosen: rows of a
/// recording are closer, those of postures are not.
pub(super) const SHORT_S: f64 = 0.25;

/// A total force is not the weight where it is so many times more or less. Chosen: robots as they
/// are bought are off CAD by 10 %, and carry loads of a tenth; twice as much overlooks a second foot
/// on the ground.
pub(super) const FORCE_UNLIKE: f64 = 1.5;
/// A known factor is meant within this. Chosen: as masses and loads are off by.
pub(super) const FORCE_KNOWN: f64 = 1.2;

/// A second sole lies on the floor where it is no higher, m, and no further turned, rad. Chosen: an
/// encoder of a leg that is off by 1.2° opens the soles of a robot of 1.7 m by 6 mm and 1.2°; a
/// lifted foot is higher.
pub(super) const FLAT_M: f64 = 0.01;
/// See [`FLAT_M`].
pub(super) const FLAT_RAD: f64 = 0.05;
/// It does so in this part of the rows. Chosen: the robot may lift a foot now and then.
pub(super) const FLAT_PART: f64 = 0.95;
/// Joints between the soles have to move by so much, rad or m. Chosen: a robot that stands still
/// may rest beside a foot without load.
pub(super) const FLAT_SWING: f64 = 0.05;

/// The whole log is beyond the sole where more than this part of its rows is. Chosen: half.
pub(super) const MOST_BEYOND: f64 = 0.5;
/// So much further out than the sole, in its diameters, is beyond it. Chosen: shapes of soles are
/// coarse, and zeros of sensors are off by a centimetre.
pub(super) const BEYOND_SOLE: f64 = 0.1;
