//! Steps that a channel moves in.

/// The step that all values are multiples of, if there is one.
pub(super) fn step(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    let gaps: Vec<f64> = sorted.windows(2).map(|w| w[1] - w[0]).collect();
    let least = gaps
        .iter()
        .copied()
        .filter(|g| *g > 1e-9)
        .fold(f64::INFINITY, f64::min);
    let whole = |gap: &f64| {
        let times = gap / least;
        (times - times.round()).abs() < 0.01 * times.clamp(1.0, 10.0)
    };
    let regular = least.is_finite() && gaps.len() >= 2 && gaps.iter().all(whole);
    // Few values far apart have a step only if some of them share it.
    let shared = gaps.iter().filter(|g| **g < 1.5 * least).count();
    (regular && 4 * shared >= gaps.len() && shared >= 2).then_some(least)
}
