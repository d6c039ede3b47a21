//! The postures that tell most: D-optimal choice.
//!
//! ```text
//! choose  max log det(M)      M = ε I + Σ_chosen a_kᵀ a_k      a_k = φ_k S / σ
//! add k   det M ← det M · det(I + G_k)      P ← P − P a_kᵀ (I + G_k)⁻¹ a_k P
//! take k  det M ← det M · det(I − G_k)      P ← P + P a_kᵀ (I − G_k)⁻¹ a_k P
//! ```
//!
//! with P = M⁻¹ and G_k = a_k P a_kᵀ, 2 × 2. In coordinates u, r = r_CAD + S u,
//! the prior is the identity (ε = 1). Without a prior the coordinates are those
//! in which all candidates together see every direction alike, directions that
//! none sees are left out, and ε is `RIDGE`.
//!
//! Greedy first; then every chosen posture in turn is exchanged for the best of
//! all, as long as rounds gain something. σ² tr(G_k)/2 is the variance with which
//! the CoP of posture k will be predicted.
//!
//! Their efficiency is the error to expect of a fit to so many of them, beside that of postures
//! drawn at random from the same candidates.
//!
//! # Order
//!
//! The chosen postures are taken in an order that spares motion:
//!
//! ```text
//! d(a, b) = max_j |a_j − b_j|        the time between two postures at equal joint speeds
//! ```
//!
//! From the posture closest to zero always on to the nearest one left, then
//! 2-opt: reverse every stretch whose reversal shortens the way, until none
//! does. Prismatic joints count a metre as a radian. Only postures are planned;
//! the way between two of them is not checked for balance or collisions.

use nalgebra::{Cholesky, DMatrix, Matrix2};
use rand::SeedableRng as _;
use rand::seq::index;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use crate::Error;
use crate::svd::svd;

/// ε where there is no prior: the information of a millionth of a posture.
const RIDGE: f64 = 1e-6;

/// Candidates in whitened coordinates.
pub(super) struct WhitenedRows {
    /// Column 2k + axis is that row of a_k.
    columns: DMatrix<f64>,
    ridge: f64,
}

/// Which candidates were chosen, and what that gained.
pub(super) struct Choice {
    /// The chosen candidates, in the order of choice.
    pub chosen: Vec<usize>,
    /// log det of M / ε after the greedy choice, then after every round of exchanges.
    pub log_det: Vec<f64>,
    /// Exchanges that improved the greedy choice.
    pub exchanges: usize,
    /// Mean of tr(G_k)/2 over all candidates, a variance in units of σ².
    pub variance: f64,
    /// The same before and after every greedy step.
    pub greedy: Vec<f64>,
}

impl WhitenedRows {
    /// `regressor`: φᵀ as columns, two per candidate; `prior`: S.
    pub(super) fn with_prior(
        regressor: &DMatrix<f64>,
        prior: &DMatrix<f64>,
        sigma: f64,
    ) -> WhitenedRows {
        WhitenedRows {
            columns: prior.tr_mul(regressor) / sigma,
            ridge: 1.0,
        }
    }

    /// Without a prior, in the directions that the candidates see.
    pub(super) fn free(regressor: &DMatrix<f64>, unseen: f64) -> WhitenedRows {
        let count = (regressor.ncols() / 2).max(1) as f64;
        // R of the candidates' QR factors: the Gram matrix would lose half the digits.
        let r = regressor.transpose().qr().r();
        let svd = svd(r, false, true);
        let largest = svd.singular_values.max();
        let seen =
            (0..svd.singular_values.len()).filter(|&k| svd.singular_values[k] > unseen * largest);
        let seen: Vec<usize> = seen.collect();
        let none = || DMatrix::zeros(0, regressor.nrows());
        let v = svd.v_t.unwrap_or_else(none);
        let mut whiten = DMatrix::zeros(seen.len(), regressor.nrows());
        for (to, &k) in seen.iter().enumerate() {
            whiten.set_row(to, &(v.row(k) * (count.sqrt() / svd.singular_values[k])));
        }
        WhitenedRows {
            columns: whiten * regressor,
            ridge: RIDGE,
        }
    }

    /// Candidates.
    pub(super) fn len(&self) -> usize {
        self.columns.ncols() / 2
    }

    /// Directions there are to tell.
    pub(super) fn directions(&self) -> usize {
        self.columns.nrows()
    }

    /// Choose `n` of the candidates; `progress` hears of every posture looked at.
    ///
    /// # Errors
    /// Those of `progress`.
    pub(super) fn choose(
        &self,
        n: usize,
        mut progress: impl FnMut() -> Result<(), Error>,
    ) -> Result<Choice, Error> {
        let mut state = State::new(self);
        let mut chosen = Vec::with_capacity(n);
        let mut log_det = 0.0;
        let mut greedy = vec![state.mean_variance()];
        for _ in 0..n.min(self.len()) {
            let best = state.best();
            log_det += state.gain(best);
            state.update(best, 1.0);
            chosen.push(best);
            greedy.push(state.mean_variance());
            progress()?;
        }
        let mut steps = vec![log_det];
        let mut exchanges = 0;
        while steps.len() <= 50 && chosen.len() < self.len() {
            // Rounding of many updates does not add up.
            state.refresh(&chosen);
            let before = exchanges;
            for slot in &mut chosen {
                let old = *slot;
                let (kept, values) = (state.inverse.clone(), state.gains.clone());
                let lost = state.loss(old);
                state.update(old, -1.0);
                let best = state.best();
                let gained = state.gain(best);
                if best == old || gained <= lost + 1e-9 {
                    (state.inverse, state.gains) = (kept, values);
                    state.used[old] = true;
                } else {
                    state.update(best, 1.0);
                    *slot = best;
                    log_det += gained - lost;
                    exchanges += 1;
                }
                progress()?;
            }
            let gain = log_det - steps[steps.len() - 1];
            steps.push(log_det);
            if exchanges == before || gain < 1e-4 * self.directions() as f64 {
                break;
            }
        }
        state.refresh(&chosen);
        Ok(Choice {
            chosen,
            log_det: steps,
            exchanges,
            variance: state.mean_variance(),
            greedy,
        })
    }

    /// Σ aᵀ a of all candidates.
    pub(super) fn gram(&self) -> DMatrix<f64> {
        &self.columns * self.columns.transpose()
    }

    /// Mean of tr(G)/2 over all candidates, whose [`gram`](Self::gram) this is, with
    /// only these chosen.
    pub(super) fn mean_variance(&self, chosen: &[usize], gram: &DMatrix<f64>) -> f64 {
        self.inverse(chosen).dot(gram) / self.columns.ncols().max(1) as f64
    }

    fn inverse(&self, chosen: &[usize]) -> DMatrix<f64> {
        let columns: Vec<usize> = chosen.iter().flat_map(|k| [2 * k, 2 * k + 1]).collect();
        let rows = self.columns.select_columns(&columns);
        let order = self.directions();
        let information = &rows * rows.transpose() + DMatrix::identity(order, order) * self.ridge;
        Cholesky::new(information).map_or_else(
            || DMatrix::identity(order, order) / self.ridge,
            |factor| factor.inverse(),
        )
    }
}

struct State<'r> {
    rows: &'r WhitenedRows,
    /// P
    inverse: DMatrix<f64>,
    /// G_k
    gains: Vec<Matrix2<f64>>,
    used: Vec<bool>,
}

impl<'r> State<'r> {
    fn new(rows: &'r WhitenedRows) -> State<'r> {
        let mut state = State {
            rows,
            inverse: DMatrix::zeros(0, 0),
            gains: Vec::new(),
            used: vec![false; rows.len()],
        };
        state.refresh(&[]);
        state
    }

    /// P and G from the chosen rows alone.
    fn refresh(&mut self, chosen: &[usize]) {
        let columns = &self.rows.columns;
        self.inverse = self.rows.inverse(chosen);
        let spread = &self.inverse * columns;
        let gain = |k: usize| {
            let of = |a: usize, b: usize| columns.column(2 * k + a).dot(&spread.column(2 * k + b));
            Matrix2::new(of(0, 0), of(0, 1), of(0, 1), of(1, 1))
        };
        self.gains = (0..self.rows.len()).map(gain).collect();
    }

    /// Mean of tr(G_k)/2 over all candidates.
    fn mean_variance(&self) -> f64 {
        let sum: f64 = self.gains.iter().map(Matrix2::trace).sum();
        sum / (2 * self.gains.len().max(1)) as f64
    }

    /// log det(I + G_k)
    fn gain(&self, k: usize) -> f64 {
        (Matrix2::identity() + self.gains[k]).determinant().ln()
    }

    /// −log det(I − G_k)
    fn loss(&self, k: usize) -> f64 {
        let left = (Matrix2::identity() - self.gains[k]).determinant();
        -left.max(f64::MIN_POSITIVE).ln()
    }

    /// The unused candidate that gains most; the first of equals.
    fn best(&self) -> usize {
        let size = |k: usize| (k, (Matrix2::identity() + self.gains[k]).determinant());
        let free = (0..self.gains.len()).filter(|&k| !self.used[k]).map(size);
        let best = free.reduce(|best, own| if own.1 > best.1 { own } else { best });
        best.map_or(usize::MAX, |(k, _)| k)
    }

    /// M + sign · a_kᵀ a_k: take a candidate in or out.
    fn update(&mut self, k: usize, sign: f64) {
        self.used[k] = sign > 0.0;
        let columns = &self.rows.columns;
        let core = Matrix2::identity() + self.gains[k] * sign;
        let core = core.try_inverse().unwrap_or_else(Matrix2::zeros) * sign;
        let toward = &self.inverse * columns.columns(2 * k, 2);
        for (j, gain) in self.gains.iter_mut().enumerate() {
            let of = |a: usize, b: usize| columns.column(2 * j + a).dot(&toward.column(b));
            let across = Matrix2::new(of(0, 0), of(0, 1), of(1, 0), of(1, 1));
            *gain -= across * core * across.transpose();
        }
        let half = &toward * core;
        self.inverse -= half * toward.transpose();
    }
}

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
pub(super) fn curve(
    rows: &WhitenedRows,
    choice: &Choice,
    noise: f64,
    seed: u64,
    prior: bool,
) -> Vec<Efficiency> {
    let all = choice.chosen.len();
    // A posture tells two.
    let least = if prior {
        0
    } else {
        rows.directions().div_ceil(2)
    };
    if all < least {
        return Vec::new();
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(1);
    let gram = rows.gram();
    // The first few of a random choice are a random choice of a few.
    let drawn = (0..20).map(|_| index::sample(&mut rng, rows.len(), all).into_vec());
    let drawn: Vec<Vec<usize>> = drawn.collect();
    let point = |postures: usize, variance: f64| {
        let std = |chosen: &Vec<usize>| rows.mean_variance(&chosen[..postures], &gram).sqrt();
        Efficiency {
            postures,
            planned: noise * variance.sqrt(),
            random: noise * drawn.iter().map(std).sum::<f64>() / drawn.len() as f64,
        }
    };
    let steps = (all - least).min(POINTS - 1);
    let at = |k: usize| least + (all - least) * k / steps.max(1);
    let before = (0..steps).map(|k| point(at(k), choice.greedy[at(k)]));
    before.chain([point(all, choice.variance)]).collect()
}

/// Indices of postures `q[k * dof + joint]` in a short order.
pub(crate) fn short_order(q: &[f64], dof: usize) -> Vec<usize> {
    let n = q.len() / dof.max(1);
    let posture = |k: usize| &q[k * dof..(k + 1) * dof];
    let from_rest = |k: usize| distance(posture(k), &vec![0.0; dof]);
    let Some(first) = (0..n).min_by(|&a, &b| from_rest(a).total_cmp(&from_rest(b))) else {
        return Vec::new();
    };
    let pairs = (0..n * n).map(|at| (posture(at / n), posture(at % n)));
    let table: Vec<f64> = pairs.map(|(a, b)| distance(a, b)).collect();
    let between = |a: usize, b: usize| table[a * n + b];
    let mut order = vec![first];
    let mut left: Vec<usize> = (0..n).filter(|&k| k != first).collect();
    while let Some(at) = (0..left.len()).min_by(|&a, &b| {
        let here = order[order.len() - 1];
        between(here, left[a]).total_cmp(&between(here, left[b]))
    }) {
        order.push(left.remove(at));
    }
    // Far fewer rounds are ever taken.
    for _ in 0..100 {
        if !untangle(&mut order, &between) {
            break;
        }
    }
    order
}

/// One round of 2-opt with the first posture kept; whether the way became shorter.
fn untangle(order: &mut [usize], between: &impl Fn(usize, usize) -> f64) -> bool {
    let n = order.len();
    let mut shorter = false;
    for i in 0..n.saturating_sub(2) {
        for j in i + 2..n {
            // Reverse i+1 ..= j; the end of the way is open.
            let (a, b, c) = (order[i], order[i + 1], order[j]);
            let after = order.get(j + 1).copied();
            let end = |from: usize| after.map_or(0.0, |to| between(from, to));
            let gain = between(a, b) + end(c) - between(a, c) - end(b);
            if gain > 1e-12 {
                order[i + 1..=j].reverse();
                shorter = true;
            }
        }
    }
    shorter
}

/// Length of the way through postures in this order.
pub(super) fn way(q: &[f64], dof: usize, order: &[usize]) -> f64 {
    let posture = |k: usize| &q[k * dof..(k + 1) * dof];
    let steps = order.windows(2);
    let way = |pair: &[usize]| distance(posture(pair[0]), posture(pair[1]));
    steps.map(way).sum()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let gaps = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    gaps.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    mod design {
        use super::*;

        fn regressor(candidates: usize) -> DMatrix<f64> {
            DMatrix::from_fn(4, 2 * candidates, |i, j| {
                ((i * 31 + j * j * 7 + i * j) as f64 * 0.61).sin()
            })
        }

        fn log_det(rows: &WhitenedRows, chosen: &[usize]) -> f64 {
            let order = rows.directions();
            let mut information = DMatrix::identity(order, order) * rows.ridge;
            for &k in chosen {
                let a = rows.columns.columns(2 * k, 2);
                information += a * a.transpose();
            }
            (information.determinant() / rows.ridge.powi(order as i32)).ln()
        }

        /// Against determinants of the whole, and against all choices there are.
        #[test]
        fn the_choice_is_the_best_of_all() {
            let regressor = regressor(9);
            let prior =
                DMatrix::from_fn(4, 3, |i, j| if i == j { 0.5 } else { 0.1 * (i + j) as f64 });
            for rows in [
                WhitenedRows::with_prior(&regressor, &prior, 0.3),
                WhitenedRows::free(&regressor, 1e-10),
            ] {
                let choice = rows.choose(4, || Ok(())).unwrap();
                let found = log_det(&rows, &choice.chosen);
                let last = choice.log_det[choice.log_det.len() - 1];
                assert!((found - last).abs() < 1e-6 * found.abs(), "{found} {last}");
                let mut best = f64::NEG_INFINITY;
                for mask in 0u32..1 << 9 {
                    if mask.count_ones() == 4 {
                        let set: Vec<usize> = (0..9).filter(|k| mask >> k & 1 == 1).collect();
                        best = best.max(log_det(&rows, &set));
                    }
                }
                assert!(found > best - 0.02 * best.abs(), "{found} of {best}");
                let mean = rows.mean_variance(&choice.chosen, &rows.gram());
                assert!((mean - choice.variance).abs() < 1e-9 * mean);
            }
        }

        #[test]
        fn exchanges_never_lose_and_nothing_is_taken_twice() {
            let regressor = regressor(200);
            let rows = WhitenedRows::free(&regressor, 1e-10);
            assert_eq!(rows.directions(), 4);
            let choice = rows.choose(20, || Ok(())).unwrap();
            assert!(choice.log_det.windows(2).all(|pair| pair[1] >= pair[0]));
            let mut sorted = choice.chosen.clone();
            sorted.sort_unstable();
            sorted.dedup();
            assert_eq!(sorted.len(), 20);
            let first: Vec<usize> = (0..20).collect();
            let of = |chosen: &[usize]| rows.mean_variance(chosen, &rows.gram());
            assert!(of(&choice.chosen) < 0.8 * of(&first));
            let all = rows.choose(500, || Ok(())).unwrap();
            assert_eq!(all.chosen.len(), 200);
        }

        /// No set of postures can determine a direction that no candidate moves.
        #[test]
        fn unseen_directions_are_left_out() {
            let mut regressor = regressor(30);
            let twice = regressor.row(1) * 2.0;
            regressor.set_row(3, &twice);
            assert_eq!(WhitenedRows::free(&regressor, 1e-10).directions(), 3);
        }
    }

    mod efficiency {
        use nalgebra::DMatrix;

        use super::*;

        fn regressor() -> DMatrix<f64> {
            DMatrix::from_fn(4, 120, |i, j| {
                ((i * 31 + j * j * 7 + i * j) as f64 * 0.61).sin()
            })
        }

        #[test]
        fn a_curve_falls_from_the_prior_to_the_plan() {
            let prior = DMatrix::identity(4, 4) * 0.5;
            let rows = WhitenedRows::with_prior(&regressor(), &prior, 0.3);
            let choice = rows.choose(24, || Ok(())).unwrap();
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
            let prefix = rows.choose(5, || Ok(())).unwrap().greedy;
            assert_eq!(prefix, choice.greedy[..=5]);
        }

        #[test]
        fn without_a_prior_it_begins_where_all_is_told() {
            let rows = WhitenedRows::free(&regressor(), 1e-10);
            let of = |postures: usize| {
                let choice = rows.choose(postures, || Ok(())).unwrap();
                curve(&rows, &choice, 0.3, 1, false)
            };
            assert!(of(1).is_empty());
            let counts: Vec<usize> = of(4).iter().map(|point| point.postures).collect();
            assert_eq!(counts, [2, 3, 4]);
            assert_eq!(of(2).len(), 1);
        }
    }

    mod order {
        use super::*;

        #[test]
        fn points_on_a_line_are_walked_along_it() {
            let q = [0.9, -0.1, 0.4, 0.2, 0.7, 0.05];
            let order = short_order(&q, 1);
            assert_eq!(order[0], 5);
            assert!((way(&q, 1, &order) - (0.15 + 1.0)).abs() < 1e-12);
        }

        #[test]
        fn every_posture_is_visited_once_on_a_shorter_way() {
            let n = 60;
            let q: Vec<f64> = (0..3 * n)
                .map(|k| ((k * k * 7 + k) as f64 * 0.37).sin())
                .collect();
            let order = short_order(&q, 3);
            let plain: Vec<usize> = (0..n).collect();
            let mut sorted = order.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, plain);
            assert!(way(&q, 3, &order) < 0.6 * way(&q, 3, &plain));
            assert_eq!(short_order(&[], 3), Vec::<usize>::new());
            assert_eq!(short_order(&[0.1, 0.2], 2), [0]);
        }
    }
}
