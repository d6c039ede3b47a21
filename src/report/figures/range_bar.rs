//! A bar for what is used of a range, with a tick per posture.

use super::super::svg::{BAND, BLUE, Figure, INK};

const SIZE: [f64; 2] = [200.0, 12.0];
/// Ticks that stay apart.
const MOST: usize = 100;

/// The range from limit to limit, what is `used` of it, and single `values`.
pub fn range_bar(limits: [f64; 2], used: [f64; 2], values: &[f64]) -> String {
    let [low, high] = limits;
    let at = |value: f64| match high > low {
        true => 2.0 + (SIZE[0] - 4.0) * ((value - low) / (high - low)).clamp(0.0, 1.0),
        false => SIZE[0] / 2.0,
    };
    let share = match high > low {
        true => 100.0 * (used[1] - used[0]) / (high - low),
        false => 0.0,
    };
    let mut figure = Figure::plain(SIZE, &format!("{share:.0} % of the range is used"));
    figure.fill([[2.0, 4.0], [SIZE[0] - 2.0, 8.0]], BAND, 1.0);
    let [from, to] = used.map(at);
    figure.fill([[from, 3.0], [to.max(from + 1.0), 9.0]], BLUE, 1.0);
    let step = values.len().div_ceil(MOST).max(1);
    let ticks = values.iter().step_by(step).map(|value| at(*value));
    figure.lines(ticks.map(|x| [[x, 1.5], [x, 10.5]]), INK, 0.75);
    figure.finish()
}
