//! From which size on something is wrong, in one place, with reasons; `cargo xtask study health`
//! counts what comes of all of these numbers together.

/// A deviation where none is known, m, and the least motion of the CoP that counts. Chosen: 1 mm is
/// large for a force plate and small for foot cells; twice as much overlooks small faults.
pub(super) const UNKNOWN_NOISE_M: f64 = 1e-3;

// What hypotheses cost. A fault that leaves the variance f of the readings is found where a known
// explanation leaves more than
//
//     cost · (1 + MORE · max(f − BY_CHANCE, 0))
//
// in variances of the noise; `cargo xtask study health` counts what comes of it.

/// Closed form: noise of 38 postures is known to 16 %, and by chance is so much more than it is
/// thought to be in one of 300 logs. It is the cost of masses within the tolerances of CAD, too, and
/// below it nothing is asked. Half as much above 1 takes chance for what masses do not explain,
/// twice as much misses quiet sensors.
pub(super) const BY_CHANCE: f64 = 1.5;
/// How many times what a fault leaves beyond the noise others leave. Chosen: masses that are off
/// leave twice as much beside a wiring as beside one unknown a posture (closed form); half of it
/// names faults that a wiring explains, twice as much misses faults of robots whose masses are off.
/// A stretch, a wiring of far readings and an exchange of axes count from there on, too.
pub(super) const MORE: f64 = 2.5;
/// Cost of CAD as it is. Chosen: motion of two deviations on each axis has 5 (closed form); half as
/// much takes an encoder's own errors for a stuck one, and names a frame by chance where the robot
/// also has a payload.
pub(super) const CAD: f64 = 6.0;
/// Cost of a wiring, with any offset and gain of the sensor. Chosen: twice as much above 1 lets a
/// swap of joints explain what a stuck one does in a slow motion.
pub(super) const WIRING: f64 = 1.2;
/// Cost of an offset or a scale of one joint. Chosen: half of it takes offsets of encoders that
/// stay for stuck ones.
pub(super) const NUMBER: f64 = 4.0;
/// Variance of the noise where nothing states it, at least and at most, in squares of
/// [`UNKNOWN_NOISE_M`]. Chosen: readings without noise are rounded to a micrometre; more than 2 mm
/// is a gap.
pub(super) const UNKNOWN_NOISE: (f64, f64) = (1e-6, 4.0);

/// A gap from which the frame is asked about, m: a sensor's zero is rarely so far off. Chosen:
/// half of it asks for other frames in sound logs, which costs time.
pub(super) const FAR_M: f64 = 0.02;
/// The sensor's axes are turned about the normal by this at least, and from a right angle, rad.
/// Chosen: 17°; smaller ones are sensors that were not mounted straight, which the effect
/// `sensor_rotation` is for.
pub(super) const LEAST_YAW: f64 = 0.3;
/// An axis is dead if under every wiring CAD moves it by so many times what it moves, and it goes
/// with no posture. Chosen: half of it calls an axis of a soft sole dead.
pub(super) const MUST_MOVE: f64 = 4.0;
/// A constant column is dead if CAD moves the CoP by more, m: no sensor is so quiet. Chosen:
/// twice as much overlooks dead axes of robots that hardly move.
pub(super) const MOVES_M: f64 = 1e-4;
/// Postures that shuffling can be seen in, at least. Chosen: half as many and chance orders
/// rows.
pub(super) const ENOUGH: usize = 30;
/// Ratio of scatters that counts as the same. Chosen: shuffling keeps the scatter exactly; the
/// factor is what an effect may add.
pub(super) const ALIKE: (f64, f64) = (0.6, 1.6);

/// Largest change of an encoder, or of a column of the CoP, that does not move, rad or m. Chosen:
/// far below a tick of any encoder and a digit of any sensor.
pub(super) const STILL: f64 = 1e-9;
/// Part of the range of a joint by which it may be beyond its limits. Chosen: limits in URDFs are
/// often those of commands; half of it misses knees that are straight.
pub(super) const BEYOND_LIMITS: f64 = 0.2;
/// A joint that its encoder does not follow moves by this, RMS, rad; m for a prismatic one.
/// Chosen: a common offset of an encoder; half of it takes compliance for motion.
pub(super) const LEAST_MOTION: (f64, f64) = (0.025, 0.005);
/// How far a joint with a stuck encoder may be from where it says, rad; m if prismatic. Chosen:
/// 29° and 10 cm; less misses joints that hang.
pub(super) const ANYWHERE: (f64, f64) = (0.5, 0.1);

/// An encoder that stops in the middle of a log does so for so many rows, and for so large a part
/// of them. Chosen: a second at 50 Hz; half of it looks at every stay of a posture.
pub(super) const PARKED_ROWS: usize = 50;
/// Fewer rows than this are no finding. Chosen: half of it reports single dropped messages.
pub(super) const FEW_ROWS: usize = 3;
/// Part of the rows that is nearly all of them: more without contact, and the sensor is off; more
/// stamped before the row above, and time runs backwards; in fewer within the limits of a joint,
/// and the joint cannot be where readings have it. Chosen: the sentence changes, not what is left
/// out.
pub(super) const NEARLY_ALL: f64 = 0.9;
/// A reading is frozen if it stays for so many times as many rows as others do while CAD moves
/// the CoP; a channel is clipped if its end comes so many times more often than the next value.
/// Chosen: half of it calls slow sensors frozen.
pub(super) const MORE_OFTEN: usize = 4;
/// How far beyond the cells and the cloud of CAD's CoPs no effect takes a reading, m. Chosen: half
/// of it leaves out readings of robots with large offsets.
pub(super) const MARGIN_M: f64 = 0.15;
/// With more of the rows beyond the sole none is left out: then the model is wrong, not the rows.
/// With more of them stamped before the row above stamps are looked at. Chosen: of stamps in any
/// order it is half (closed form); packets of a network are out of order by a few per cent.
pub(super) const MANY_ROWS: f64 = 0.2;
/// Readings in another unit (cm, mm) scatter so many times as much as CAD says, and a joint
/// without a velocity limit leaps where it is so many times as fast as in the middle of its moves.
/// Chosen: the root of 100 between cm and m; a sine spends half of its time above 0.7 of its peak
/// (closed form), joints that creep between fast moves have 5.
pub(super) const TENFOLD: f64 = 10.0;
/// Nothing is said of copies, values at the end of a channel, or an encoder that stops, in a
/// smaller part of the rows; nor of copies where more of the readings come again at other joint
/// positions. Chosen: half of it reports a few repeated messages; what less moves is small beside
/// noise that lasts.
pub(super) const SOME_ROWS: f64 = 0.01;
/// Rows are no copies if the channels move in steps above this part of their scatter. Chosen: with
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

/// Joints jump from stamp to stamp by more than this part of what rows in any order do, where
/// stamps are of other rows, and from row to row by no more than this part of that. Chosen: a sine
/// of 0.4 Hz at 4 Hz has 0.2 (closed form), postures drawn at random have 1; with half of it jitter
/// of stamps that are dense is enough.
pub(super) const JUMPS: f64 = 0.5;

/// Between rows that are further apart, s, no leap is seen: much may happen there. Chosen: rows of
/// a recording are closer, those of postures are not.
pub(super) const SHORT_S: f64 = 0.25;

/// A total force is not the weight where it is so many times more or less; a known factor is meant
/// within its root. Chosen: robots as they are bought are off CAD by 10 %, and carry loads of a
/// tenth; twice as much overlooks a second foot on the ground.
pub(super) const FORCE_UNLIKE: f64 = 1.5;

/// A second sole lies on the floor where it is no higher, m, and no further turned, rad, which joints
/// between the soles move by more, too. Chosen: an encoder of a leg that is off by 1.2° opens the
/// soles of a robot of 1.7 m by 6 mm and 1.2°; a lifted foot is higher.
pub(super) const FLAT: (f64, f64) = (0.01, 0.05);

/// So much further out than the sole, in its diameters, is beyond it. Chosen: shapes of soles are
/// coarse, and zeros of sensors are off by a centimetre.
pub(super) const BEYOND_SOLE: f64 = 0.1;

/// What a total force says.
pub(super) mod weight {
    /// Half a window over which a total force is averaged, s. Chosen: what a step adds to it is
    /// over; half of it takes accelerations that CAD does not have for loads.
    pub(crate) const HALF_S: f64 = 0.5;
    /// Shorter windows have no second difference, s: a position that is off by 0.1 mm is then one of
    /// 0.04 m/s² (closed form).
    pub(crate) const SHORTEST_S: f64 = 0.1;
    /// Rows that are further apart follow no other, s. Chosen: five of them make a window.
    pub(crate) const APART_S: f64 = 0.25;
    /// Something else carries this part of the weight. Chosen: sensors drift by less; the recorded
    /// fall of a robot of 217 N takes 20 N from its plate; twice as much overlooks a hand.
    pub(crate) const HELD: f64 = 0.08;
    /// … and this many deviations of a row's force. Closed form: one row of 30,000 by chance.
    pub(crate) const NOISE: f64 = 4.0;
    /// Stretches whose means tell the scatter of a force that drifts. Chosen: the scatter is then
    /// known to a quarter (closed form).
    pub(crate) const STRETCHES: usize = 10;
    /// Scale of a force plate, and of what it stands on. Chosen: makers state 0.2 to 1 %; twice as
    /// much knows a payload half as well.
    pub(crate) const PLATE: f64 = 0.005;
    /// Two levels are further apart than this part of the weight. Chosen: a plate drifts by less.
    pub(crate) const CLEARLY: f64 = 0.03;
    /// … and than this many deviations of both. Closed form: halves of a normal distribution are
    /// 1.9 of them apart, of an even one 2.4, of a sine 2.9.
    pub(crate) const LEVELS_APART: f64 = 4.0;
    /// Rounds in which the middle between two levels settles. Chosen: it costs time.
    pub(crate) const LEVELS: usize = 4;
}
