//! How efficient postures are: the error to expect of a fit to so many of them,
//! planned and drawn at random from the same candidates.

use rand::SeedableRng as _;
use rand::seq::index;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::design::{Choice, WhitenedRows};

/// Random choices that the chosen postures are compared with.
const RANDOM: usize = 20;
/// Points of a curve.
const POINTS: usize = 16;

/// Expected RMS errors of the CoP over all candidates, m, of fits to `postures`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Efficiency {
    /// Number of postures.
    pub postures: usize,
    /// To the first of the greedy choice; the last point has the exchanges too.
    pub planned: f64,
    /// To random ones, on average.
    pub random: f64,
}

/// The curve up to the postures chosen; `noise` is that of a reading, m.
///
/// Without a prior it begins where postures can tell all directions.
pub(crate) fn curve(
    rows: &WhitenedRows,
    choice: &Choice,
    noise: f64,
    seed: u64,
    prior: bool,
) -> Vec<Efficiency> {
    let all = choice.chosen.len();
    // A posture tells two.
    let least = match prior {
        true => 0,
        false => rows.directions().div_ceil(2),
    };
    if all < least {
        return Vec::new();
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(1);
    let gram = rows.gram();
    // The first few of a random choice are a random choice of a few.
    let drawn: Vec<Vec<usize>> = (0..RANDOM)
        .map(|_| index::sample(&mut rng, rows.len(), all).into_vec())
        .collect();
    let point = |postures: usize, variance: f64| {
        let error = |chosen: &Vec<usize>| {
            let variance = rows.mean_variance(&chosen[..postures], &gram);
            noise * variance.sqrt()
        };
        Efficiency {
            postures,
            planned: noise * variance.sqrt(),
            random: mean(&drawn.iter().map(error).collect::<Vec<f64>>()),
        }
    };
    let steps = (all - least).min(POINTS - 1);
    let at = |k: usize| least + (all - least) * k / steps.max(1);
    let before = (0..steps).map(|k| point(at(k), choice.greedy[at(k)]));
    before
        .chain([point(all, mean(&choice.variances))])
        .collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use nalgebra::DMatrix;

    use super::*;

    const CONTINUE: ControlFlow<()> = ControlFlow::Continue(());

    fn regressor() -> DMatrix<f64> {
        DMatrix::from_fn(4, 120, |i, j| {
            ((i * 31 + j * j * 7 + i * j) as f64 * 0.61).sin()
        })
    }

    #[test]
    fn a_curve_falls_from_the_prior_to_the_plan() {
        let prior = DMatrix::identity(4, 4) * 0.5;
        let rows = WhitenedRows::with_prior(&regressor(), &prior, 0.3);
        let choice = rows.choose(24, |_| CONTINUE);
        let curve = curve(&rows, &choice, 0.3, 1, true);
        assert_eq!(curve.len(), POINTS);
        assert!(curve.windows(2).all(|w| w[1].postures > w[0].postures
            && w[1].planned < w[0].planned
            && w[1].random < w[0].random));
        // None taken: φ S Sᵀ φᵀ of the prior alone, over all candidates.
        let alone = (0.25 * regressor().norm_squared() / 120.0).sqrt();
        let first = curve[0];
        assert_eq!(first.postures, 0);
        assert!((first.planned - alone).abs() < 1e-12 && (first.random - alone).abs() < 1e-12);
        let last = curve[POINTS - 1];
        assert_eq!(last.postures, 24);
        assert!(curve[1..].iter().all(|point| point.planned < point.random));
        // Greedy steps say what the chosen ones alone would.
        let prefix = rows.choose(5, |_| CONTINUE).greedy;
        assert_eq!(prefix, choice.greedy[..=5]);
    }

    #[test]
    fn without_a_prior_it_begins_where_all_is_told() {
        let rows = WhitenedRows::free(&regressor(), 1e-10);
        let of = |postures: usize| {
            let choice = rows.choose(postures, |_| CONTINUE);
            curve(&rows, &choice, 0.3, 1, false)
        };
        assert!(of(1).is_empty());
        let counts: Vec<usize> = of(4).iter().map(|point| point.postures).collect();
        assert_eq!(counts, [2, 3, 4]);
        assert_eq!(of(2).len(), 1);
    }
}
