//! Every number that decides what is said of readings before an effect is looked for.
//!
//! Where no calibration is named, the number was chosen, not calibrated; the studies of
//! recordings and of false alarms (`docs/`) count what comes of all of them together.

/// Explanations whose −2 log odds against the best are no more than this are as good: odds of
/// 150 to 1.
pub const AS_GOOD: f64 = 10.0;

/// How many independent samples a log in time is worth.
pub mod correlation {
    /// Twice the log likelihood that correlation must gain over none.
    pub const SIGNIFICANT: f64 = 10.0;
    /// Windows are tried on several lengths: they must gain more.
    pub const OF_WINDOWS: f64 = 16.0;
    /// Standard deviations by which windows must scatter more than independent rows.
    pub const SCATTER: f64 = 4.0;
    /// Standard deviations by which neighbours that are not alike may correlate.
    pub const ALIKE: f64 = 3.5;
    /// Means of so many rows are looked at that this many times the columns are left.
    pub const FEW: usize = 3;
    /// Windows whose means are less correlated than this are long enough.
    pub const ENOUGH_APART: f64 = 0.7;
    /// How often the scale of rows that hold coefficients follows what is found.
    pub const SCALED: usize = 3;
    /// Longer windows count where they are worth this much less than shorter ones say.
    pub const WORTH_LESS: f64 = 1.15;
    /// Factor by which windows twice as long may show rows to be worth less.
    pub const LEAP: f64 = 2.5;
    /// Unless there are this many windows for each column.
    pub const ROOM: usize = 4;
    /// What white noise over an AR(1) process must gain beyond that: about the logarithm of
    /// some hundred rows (Schwarz 1978).
    pub const UNDER_WHITE: f64 = 6.0;
    /// More windows are not filtered: longer ones say the same of slow noise in less time.
    pub const FILTERED: usize = 1600;
    /// Rows that correlation can be seen in, at least, beyond the columns of X.
    pub const ENOUGH: usize = 20;
    /// Windows beyond twice the columns of X.
    pub const WINDOWS: usize = 20;
    /// More steps than this part that do not go forward are no order.
    pub const BACKWARDS: f64 = 0.02;
}

/// Whether readings show the motion of the joints.
pub mod motion {
    /// Readings are without motion where twice the log likelihood of that is this much larger.
    pub const SURE: f64 = 4.0;
    /// A share this many deviations from 1 is another one,
    pub const ANOTHER: f64 = 4.0;
    /// if it is off by this as well: accelerations are not known better.
    pub const CLEARLY: f64 = 0.1;
    /// Shares that are known less well are not told.
    pub const TOLD: f64 = 1.0;
}

/// What repeated readings and visits of postures tell.
pub mod repeats {
    /// More than noise leaves with less than this chance is no noise.
    pub const UNLIKELY: f64 = 1e-3;
    /// Degrees of freedom of visits, or repeats, without which they are no measure of noise.
    pub const FEWEST: u64 = 10;
    /// Degrees of freedom from which visits are said to differ or not.
    pub const SAID: u64 = 2;
}
