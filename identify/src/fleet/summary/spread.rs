//! How far robots of a group are from what they share, and how well a few robots tell it.
//!
//! ```text
//! v_i ~ N(μ, s_i² + τ²)      w_i = 1/(s_i² + τ²)      μ̂ = Σ w_i v_i / Σ w_i
//! l(τ) = −½ (Σ ln(s_i² + τ²) + ln Σ w_i + Σ w_i (v_i − μ̂)²)        μ integrated out (REML)
//! 95 %:  2 (l(τ̂) − l(τ)) ≤ 3.84                                   profile likelihood
//! ```
//!
//! Robots of a group were chosen because they agree: the interval says what their numbers tell
//! and knows nothing of robots that were left out.

use crate::fleet::row::Size;

/// 95 % of χ² with one degree of freedom.
const CHI2: f64 = 3.841_458_820_694_124;
/// Points at which the likelihood is looked at first.
const POINTS: usize = 400;
/// The first of them, in units of the smallest deviation, and the last, in units of all.
const RANGE: (f64, f64) = (1e-3, 1e3);
/// Halvings of an interval: to a part of 10⁻¹².
const HALVINGS: usize = 40;

/// 95 % interval of τ around an estimate of it; none of fewer than two values.
pub(super) fn interval(values: &[Size], estimate: f64) -> Option<[f64; 2]> {
    let known: Vec<Size> = values.iter().copied().filter(|v| v.std > 0.0).collect();
    if known.len() < 2 {
        return None;
    }
    let least = known.iter().map(|v| v.std).fold(f64::INFINITY, f64::min);
    let reach = |of: &dyn Fn(&Size) -> f64, start: f64, pick: fn(f64, f64) -> f64| {
        known.iter().map(of).fold(start, pick)
    };
    let spread = reach(&|v| v.value, f64::NEG_INFINITY, f64::max)
        - reach(&|v| v.value, f64::INFINITY, f64::min);
    let most = RANGE.1 * (spread + reach(&|v| v.std, 0.0, f64::max));
    let first = RANGE.0 * least;
    let step = (most / first).ln() / (POINTS as f64 - 1.0);
    let points = (0..POINTS).map(|k| first * (step * k as f64).exp());
    let points: Vec<(f64, f64)> = std::iter::once(0.0)
        .chain(points)
        .map(|tau| (tau, likelihood(&known, tau)))
        .collect();
    let (best, top) = points
        .iter()
        .enumerate()
        .map(|(at, (_, l))| (at, *l))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    let level = top - 0.5 * CHI2;
    let is_in = |l: f64| l >= level;
    // The ends of the interval are between a point that is in it and the next that is not.
    let below = (0..best).rev().find(|at| !is_in(points[*at].1));
    let above = (best..points.len()).find(|at| !is_in(points[*at].1));
    let end = |inside: f64, outside: f64| {
        let (mut inside, mut outside) = (inside, outside);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            match is_in(likelihood(&known, middle)) {
                true => inside = middle,
                false => outside = middle,
            }
        }
        inside
    };
    let low = below.map_or(0.0, |at| end(points[at + 1].0, points[at].0));
    let high = above.map_or(most, |at| end(points[at - 1].0, points[at].0));
    // The estimate is by moments, and may be a little outside.
    Some([low.min(estimate), high.max(estimate)])
}

fn likelihood(values: &[Size], tau: f64) -> f64 {
    let variance = |v: &Size| v.std * v.std + tau * tau;
    let sum: f64 = values.iter().map(|v| 1.0 / variance(v)).sum();
    let mean = values.iter().map(|v| v.value / variance(v)).sum::<f64>() / sum;
    let each = values.iter().map(|v| {
        let variance = variance(v);
        variance.ln() + (v.value - mean).powi(2) / variance
    });
    -0.5 * (each.sum::<f64>() + sum.ln())
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, StandardNormal};

    use super::super::history::pooled;
    use super::*;

    /// Eight robots, deviations of 1 to 2, drawn 400 times for each spread between robots.
    #[test]
    fn ninety_five_percent_of_intervals_hold_the_spread_between_robots() {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        for tau in [0.0, 1.0, 5.0] {
            let mut held = 0;
            for _ in 0..400 {
                let values: Vec<Size> = (0..8)
                    .map(|k| {
                        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                        let std = 1.0 + k as f64 / 7.0;
                        Size {
                            value: 30.0 + tau * normal() + std * normal(),
                            std,
                        }
                    })
                    .collect();
                let (_, estimate) = pooled(&values).unwrap();
                let [low, high] = interval(&values, estimate).unwrap();
                assert!(low <= estimate && estimate <= high && high.is_finite());
                held += usize::from(low <= tau && tau <= high);
            }
            // 380 of 400 are expected; at 0 there is nothing below, and more hold it.
            assert!((364..=400).contains(&held), "{tau}: {held} of 400");
        }
    }

    #[test]
    fn two_robots_tell_little_and_one_tells_nothing() {
        let size = |value: f64| Size { value, std: 0.1 };
        assert_eq!(interval(&[size(1.0)], 0.0), None);
        let [low, high] = interval(&[size(1.0), size(1.0)], 0.0).unwrap();
        assert!(low == 0.0 && (0.1..1.0).contains(&high), "{high}");
        let [_, wide] = interval(&[size(1.0), size(2.0)], 0.7).unwrap();
        assert!(wide > 2.0, "{wide}");
    }
}
