//! Every number that decides what is said of readings before an effect is looked for.
//!
//! Each doc says whether its number follows from a closed form, was calibrated, or was chosen.
//! What a factor of two changes follows from what the number does; it was counted only where a
//! study is named. The studies of recordings and of false alarms (`docs/`) count what comes of
//! all of them together.

/// Explanations whose −2 log odds against the best are no more than this are as good: odds of
/// 150 to 1. The score of a class: see `CLASS_SCORE` in `identify/src/diagnose/criteria.rs` for
/// what the study counts of it. Correlation must gain more over none, too: by chance it does in one
/// log of 600 (closed form, χ² of one), half of it in one of 39.
pub(crate) const AS_GOOD: f64 = 10.0;
/// An explanation has to beat "nothing is missing" by this. Calibrated on logs of the study
/// without any effect: 2 false alarms in 300 without it, none in 470 with it.
pub const OVER_NOTHING: f64 = 4.0;

/// Standard deviations from which a difference is no chance: of a share of motion from 1, of windows
/// that scatter more than independent rows. Chosen: one log of 16,000 by chance, one of 30,000 to one
/// side (closed form); half of it one of 22.
pub(crate) const CERTAIN: f64 = 4.0;

/// From which side joints came to where they stand.
pub(crate) mod approach {
    /// A move counts from this on, rad. Chosen: three deviations of an encoder that is good to
    /// 0.07°; half of it takes noise for moves, twice as much misses small ones.
    pub(crate) const LEAST_RAD: f64 = 3.5e-3;
    /// The same of a joint that slides, m. Chosen: as for the angle.
    pub(crate) const LEAST_M: f64 = 2e-4;
}

/// How many independent samples a log in time is worth.
pub(crate) mod correlation {
    /// Windows are tried on several lengths: they must gain more. Chosen: half of it finds
    /// correlation in white noise where several lengths are tried.
    pub(crate) const OF_WINDOWS: f64 = 16.0;
    /// Standard deviations by which neighbours that are not alike may correlate. Chosen: one
    /// log of 2000 by chance (closed form); half of it one of 12.
    pub(crate) const ALIKE: f64 = 3.5;
    /// Means of so many rows are looked at that this many times the columns are left. Chosen:
    /// with half as many the fit eats what correlation is seen in.
    pub(crate) const FEW: usize = 3;
    /// Windows whose means are less correlated than this are long enough. Chosen: half of it
    /// asks for longer windows, of which there are fewer.
    pub(crate) const ENOUGH_APART: f64 = 0.7;
    /// How often the scale of rows that hold coefficients follows what is found. Chosen: it
    /// costs time.
    pub(crate) const SCALED: usize = 3;
    /// Longer windows count where they are worth this much less than shorter ones say. Chosen:
    /// twice the excess keeps windows that say a log is worth a third more than it is.
    pub(crate) const WORTH_LESS: f64 = 1.15;
    /// Factor by which windows twice as long may show rows to be worth less. Chosen: more is
    /// noise of few windows; twice as much lets one pair of windows decide.
    pub(crate) const LEAP: f64 = 2.5;
    /// Unless there are this many windows for each column. Chosen: with half as many a leap may
    /// be chance.
    pub(crate) const ROOM: usize = 4;
    /// What white noise over an AR(1) process that leaves nothing must gain beyond that: about
    /// the logarithm of some hundred rows (Schwarz 1978). Closed form: half of it is for e³ = 20
    /// rows, twice as much for 160,000.
    pub(crate) const UNDER_WHITE: f64 = 6.0;
    /// More windows are not filtered: longer ones say the same of slow noise in less time.
    /// Chosen: it costs time, with its square.
    pub(crate) const FILTERED: usize = 1600;
    /// Rows, or windows, that correlation can be seen in, at least, beyond what the columns of X
    /// take. Chosen: half as many give correlation times that are off by half.
    pub(crate) const ENOUGH: usize = 20;
    /// Columns beside which noise is judged are means over this long to either side, s. Chosen: half of
    /// it leaves columns of markers a third of their noise; twice as much takes half of a bow of 0.5 Hz.
    pub(crate) const MEANS_S: f64 = 0.5;
    /// Noise that lasts for more than this part of a log is not told from what is missing. Chosen:
    /// two and a half independent samples; half of it asks for five.
    pub(crate) const SHORT: f64 = 0.2;
    /// Noise that nothing states is no noise from this part of the sole on. Chosen: half of it is that
    /// of a worn foot sensor; twice as much leaves a balanced robot nothing to move its CoP over.
    pub(crate) const LARGE: f64 = 0.2;
    /// More steps than this part that do not go forward are no order. Chosen: half of it
    /// refuses recordings with late messages.
    pub(crate) const BACKWARDS: f64 = 0.02;
}

/// Where accelerations are known.
pub(crate) mod accelerations {
    /// Longest interval between rows, s. Chosen: recordings of 5 Hz are taken as they are, and
    /// [`BENT`] is asked of slower ones; half of it asks those of 10 Hz, too.
    pub(crate) const LONGEST_S: f64 = 0.2;
    /// Longest interval between rows where joints move so slowly that rows show it, s. Chosen:
    /// a little above a row a second, as such recordings are made.
    pub(crate) const LONGEST_OF_SLOW_S: f64 = 1.1;
    /// Rows of a robot that moves are looked at so far apart by a diagnosis, s: the noise of a CoP
    /// lasts longer, and a recording has one answer at 20 Hz and more. Chosen: half of it takes
    /// twice the time.
    pub(crate) const APART_S: f64 = 0.049;
    /// What order 4 may bend of an acceleration at most where rows are further apart than
    /// [`LONGEST_S`]. Chosen: twice as much lets recordings in whose accelerations are 2 % off.
    pub(crate) const BENT: f64 = 0.01;
    /// What order 3 may bend of an acceleration, squared, that order 4 is freed of what it bends
    /// itself; of more, so much. Chosen: 45 %; with more, the next powers of the swing's rate
    /// count as much, half of it leaves accelerations of 0.4 Hz at 5 Hz 0.3 % off.
    pub(crate) const MOST_BENT: f64 = 0.2;
    /// How often an acceleration that is bent counts against one that is noisy. Chosen: half of
    /// it takes longer windows; see `docs/dev/study/motion.txt` for what comes of it.
    pub(crate) const COHERENT: f64 = 10.0;
    /// Longer windows must be whole for this part of the log that the shortest are whole for.
    /// Chosen: half of it gives up rows beside pauses.
    pub(crate) const COVERED: f64 = 0.8;
    /// A joint moves where its acceleration is this many times what noise makes of one, RMS.
    /// Chosen: half of it takes noise of encoders for motion.
    pub(crate) const MOVES: f64 = 2.0;
    /// Joints of which rows leave more of the polynomials are not read by so much noise, but go from
    /// posture to posture, rad or m. Chosen: four times the noise of markers.
    pub(crate) const NOISIEST: f64 = 0.02;
    /// Where the ground carries less of the weight, or cells less of their median load, a row is no
    /// reading of a CoP. Closed form: noise of the cells moves such a CoP five times as far, ten
    /// times at half of it. Chosen.
    pub(crate) const LEAST_LOAD: f64 = 0.2;
    /// Parabolas through accelerations reach this far to either side where rows are dense, s; rows
    /// further apart than twice that know no change of an acceleration. Closed form: a parabola
    /// over such rows is 4 % off at 0.7 Hz, at twice as much 16 %.
    pub(crate) const REACH_S: f64 = 0.06;
}

/// Whether readings show the motion of the joints.
pub(crate) mod motion {
    /// Readings are without motion where twice the log likelihood of that is this much larger.
    /// Chosen: odds of 150 to 1, since readings hold it by the laws of mechanics; less than half of it
    /// drops motion that is there (the study of labs), twice as much keeps it where it only adds noise.
    pub(crate) const SURE: f64 = 10.0;
    /// A share that is off from 1 by less is 1: accelerations are not known better. Chosen: half
    /// of it calls errors of accelerations a share.
    pub(crate) const CLEARLY: f64 = 0.1;
    /// Shares that are known less well are not told. Chosen: a share known to ± 1 tells
    /// nothing.
    pub(crate) const TOLD: f64 = 1.0;
}

/// What noise is known from.
pub(crate) mod noise {
    /// Rows beyond the rank that an estimate of the noise from residuals needs. Chosen: five
    /// know it to 32 % (closed form), half as many to 45 %.
    pub(crate) const ROWS: f64 = 5.0;
    /// What is larger than so many deviations of the noise, or steps of a channel, shows: motion,
    /// the order of rows, the steps of a coarse channel, values that are left out of an estimate.
    /// Chosen: one value of 370 by chance (closed form), with half of it one of 7; steps add Δ²/12
    /// to the variance (closed form): as much as noise at 3.5 deviations.
    pub(crate) const SHOWS: f64 = 3.0;
    /// What noise has of the variance that a fit leaves, at least. Chosen: half of it lets
    /// effects be all of it.
    pub(crate) const LEAST_PART: f64 = 0.1;
    /// Stated deviations that scatter less than this are estimates of one number. Chosen: those
    /// of 23 repeats scatter so (closed form), with half of it those of 90.
    pub(crate) const SCATTER: f64 = 0.15;
}

/// What repeated readings and visits of postures tell.
pub(crate) mod repeats {
    /// More than noise leaves with less than this chance is no noise, and rows that agree with a
    /// wiring by less are not shuffled. Chosen: it is the rate of
    /// false alarms itself (closed form).
    pub(crate) const UNLIKELY: f64 = 1e-3;
    /// Degrees of freedom of visits, or repeats, without which residuals say more of noise.
    /// Chosen: ten degrees of freedom know a deviation to 22 % (closed form), half as many to
    /// 32 %.
    pub(crate) const FEWEST: u64 = 10;
    /// Degrees of freedom from which visits are said to differ or not. Chosen: two know a
    /// deviation to a half (closed form).
    pub(crate) const SAID: u64 = 2;
    /// Joint positions of a posture that is reached again under another number are off by no more,
    /// rad or m. Chosen: 20 servos that come back to 0.5° are off by up to 2.6° in a log of 240
    /// pairs of visits (closed form); half of it is for servos of 0.3°.
    pub(crate) const REACHED: f32 = 0.06;
    /// Other postures are so many times further away. Chosen: of postures drawn at random along a
    /// line, the five closest pairs show such a gap in one log of 3000, in a plane in one of ten
    /// million (closed form); half of it finds it in one of 100 along a line.
    pub(crate) const APART: f32 = 5.0;
    /// Axes have noises of their own where repeats scatter so unalike with less than this chance.
    /// Chosen: by chance in one log of 20 (closed form), whose axes are then known as well as
    /// repeats know them; half of it keeps one noise for axes that differ a little more.
    pub(crate) const UNALIKE: f64 = 0.05;
    /// Deviation of an axis over that of both, at least. Chosen: an axis that reads one value has
    /// no noise of its own, and half of it would let it decide alone.
    pub(crate) const LEAST_OF_AN_AXIS: f64 = 0.1;
}
