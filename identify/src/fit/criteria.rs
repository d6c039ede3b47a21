//! Every number that decides what a fit says, and where it comes from.

/// Held-out errors beyond this many times the noise ask for a diagnosis. Chosen: half the excess
/// asks for one after most fits of few postures, twice as much misses ankles that are off by 1°.
pub(super) const FAR: f64 = 1.5;
/// Axes of which one leaves this many times as much as the other ask for one, too, where no repeats
/// tell their noise. Chosen: readings of a long sole differ by its length over its width, about two.
pub(super) const GROSSLY: f64 = 3.0;
/// A parameter is elsewhere than in CAD by this at least, m. Chosen: what CAD's usual tolerance
/// of a centre of mass is; half of it lists parameters that such a CAD has.
pub(super) const ELSEWHERE_M: f64 = 5e-3;
/// It is so many of its deviations away, too. Chosen: one parameter of 16,000 by chance (closed
/// form), with half of it one of 22.
pub(super) const SURELY: f64 = 4.0;
/// Correlations of parameters from this magnitude on are listed. Chosen: it lengthens or
/// shortens a list alone.
pub(super) const CORRELATED: f64 = 0.9;

/// Length of a pair of residuals, in units of their scale, from which Huber's loss is linear.
/// Chosen. Closed form for normal noise: 97.8 % as good as least squares, with half of it 88 %,
/// with twice as much no less than 99.9 %, and outliers count twice as much.
pub(super) const HUBER: f64 = 1.9;
/// Length from which Tukey's loss gives no weight. Chosen. Closed form for normal noise: 94.5 %
/// as good as least squares, with half of it 52 %, with twice as much 99.7 %.
pub(super) const TUKEY: f64 = 5.0;
/// Rows beyond the parameters without which no outlier is looked for. Chosen: with half as many
/// a fit may follow the outlier.
pub(super) const TO_SEE_OUTLIERS: f64 = 10.0;

/// Held-out blocks are longer than this many correlation times. Chosen: noise in the middle of
/// a block goes with the rest by e⁻² = 0.14 (closed form), with half of it by 0.37.
pub(crate) const HELD_OUT_TIMES: f64 = 4.0;
/// Axes whose noise differs by more are not weighed any further. Chosen: an axis counts a
/// hundred times as much as the other by then.
pub(super) const MOST_APART: f64 = 10.0;
/// Rows a visit from which a robot is said to stay. Chosen: two rows are the fewest that could
/// show it; twice as many misses short stays.
pub(super) const ROWS_OF_STAY: usize = 3;
/// Degrees of freedom that tell the noise of an axis. Chosen: ten know it to 22 % (closed
/// form), half as many to 32 %.
pub(super) const TO_KNOW_NOISE: f64 = 10.0;
