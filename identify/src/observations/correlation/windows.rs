//! Means of neighbouring rows, and rows freed of their correlation.
//!
//! ```text
//! ȳ_w = X̄_w r + ē_w        means over the rows of a window: as linear as the rows
//! (z_w − ρ z_{w−1})/√(1 − ρ²)        ρ = exp(−Δ/τ), Δ between the middles of windows, where
//!                                    all of their noise lasts; by a filter where a part does
//! ```
//!
//! Rows at 100 Hz of noise that lasts half a second say little more than their means
//! over a quarter of it; the means are much alike whatever the rate, and whatever sensor
//! noise lies on the slow part.
//!
//! Noise that lasts moves a sum over rows by what windows share:
//!
//! ```text
//! Var(Σ_k z_k e_k) = Σ_w Σ_v S_w S_v Cov(ē_w, ē_v) + (1 − l) Σ_w Σ_k (z_k − z̄_w)²
//! ```
//!
//! over windows w of the process, whose means ē are correlated and whose rows share the part l
//! of their variance; S_w is the sum of z over a window. What changes faster than the noise
//! lasts is moved little by it, what is as slow as it by all of it.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::mixture::Filter;
use super::restricted::lasting;

/// Rows further apart than this many ordinary steps are not neighbours.
pub(crate) const GAP: f64 = 4.0;

/// Windows of less than this part of the longest's rows are cut short.
const WHOLE: f64 = 0.75;

/// How rows are cut into windows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cut {
    /// Rows of a window, at most.
    pub rows: usize,
    /// Rows further apart begin another stretch, s.
    pub gap_s: f64,
}

impl Cut {
    /// Windows of `rows` where rows are `step` seconds apart.
    pub fn new(rows: usize, step: f64) -> Cut {
        Cut {
            rows,
            gap_s: GAP * step,
        }
    }

    /// Windows of rows at times `t`.
    fn windows(&self, t: &[f64]) -> Vec<Range<usize>> {
        let mut starts = Vec::new();
        for k in 0..t.len() {
            match starts.last() {
                Some(&start) if !self.ends(k - start, t[k - 1], t[k]) => {}
                _ => starts.push(k),
            }
        }
        starts.push(t.len());
        starts.windows(2).map(|pair| pair[0]..pair[1]).collect()
    }

    /// Whether a window of `count` rows, the last at `last`, is whole before a row at `t`.
    fn ends(&self, count: usize, last: f64, t: f64) -> bool {
        count >= self.rows || t <= last || t - last > self.gap_s
    }
}

/// Windows of rows at times `t`, those that a gap cut short left out: their means vary
/// more.
pub(super) fn whole(t: &[f64], cut: Cut) -> Vec<Range<usize>> {
    let mut windows = cut.windows(t);
    let longest = windows.iter().map(Range::len).max().unwrap_or(0);
    windows.retain(|window| window.len() as f64 >= WHOLE * longest as f64);
    windows
}

/// Noise that is correlated in time, as means of windows know it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Process {
    /// How rows are cut.
    pub cut: Cut,
    /// Correlation time of the windows' means, s; zero where they are independent.
    pub tau_s: f64,
    /// Part of the means' variance that has this correlation; the others are independent.
    pub share: f64,
    /// Part of a row's variance that averaging does not lower.
    pub lasting: f64,
}

impl Default for Process {
    /// The process of independent rows.
    fn default() -> Process {
        Process {
            cut: Cut {
                rows: 1,
                gap_s: f64::INFINITY,
            },
            tau_s: 0.0,
            share: 1.0,
            lasting: 0.0,
        }
    }
}

impl Process {
    /// Variance of the mean of `rows` rows, in units of a row's.
    pub fn variance(&self, rows: f64) -> f64 {
        self.lasting + (1.0 - self.lasting) / rows
    }

    /// Correlation of what lasts in two means whose middles are `apart` seconds apart.
    pub fn correlation(&self, apart: f64) -> f64 {
        lasting(apart, if apart > 0.0 { self.tau_s } else { 0.0 })
    }

    /// `Var(zᵀ e)`, k × k, over the variance of a row, of the `k` columns of `z` (one row for
    /// each time of `t`, s) and noise e that follows this process.
    pub fn spread(&self, t: &[f64], z: &DMatrix<f64>) -> DMatrix<f64> {
        let k = z.ncols();
        let mut spread = DMatrix::zeros(k, k);
        // What earlier windows say of the noise of this one, and the middle of the last.
        let mut before: Option<(f64, DVector<f64>)> = None;
        for window in self.cut.windows(t) {
            let rows = window.len() as f64;
            let own = z.rows(window.start, window.len());
            let sum = own.row_sum_tr();
            let middle = t[window].iter().sum::<f64>() / rows;
            let within = own.tr_mul(&own) - &sum * sum.transpose() / rows;
            spread += within * (1.0 - self.lasting);
            let of_mean = sum * self.variance(rows).sqrt();
            spread += &of_mean * of_mean.transpose();
            let told = match before {
                Some((earlier, told)) => told * self.correlation(middle - earlier),
                None => DVector::zeros(k),
            };
            let shared = &of_mean * told.transpose() * self.share;
            spread += &shared + shared.transpose();
            before = Some((middle, told + of_mean));
        }
        spread
    }
}

/// A window's rows so far.
#[derive(Debug, Clone, PartialEq)]
struct Open {
    key: i64,
    count: usize,
    trust: f64,
    /// Σ of times, and the last, s.
    t: f64,
    last: f64,
    /// Σ of rows (x, y), each times its trust.
    sum: Vec<f64>,
}

/// Turns the rows of one axis into independent ones, as they come.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Whitener {
    process: Process,
    open: Option<Open>,
    /// Middle of the window before, s, and what is known of the noise that lasts.
    before: Option<(f64, Filter)>,
}

/// An independent row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Independent {
    /// Position in time of its first row.
    pub key: i64,
    /// (x, y), of the variance of a single row.
    pub row: Vec<f64>,
    /// Mean trust of its rows.
    pub trust: f64,
}

impl Whitener {
    /// Prepare to whiten noise that follows `process`.
    pub(crate) fn new(process: Process) -> Whitener {
        Whitener {
            process,
            open: None,
            before: None,
        }
    }

    /// A row (x, y) over its deviation, which belongs to `key`; gives the window that ended.
    pub(crate) fn push(
        &mut self,
        t: f64,
        key: i64,
        row: &[f64],
        trust: f64,
    ) -> Option<Independent> {
        let cut = self.process.cut;
        let ends = |open: &Open| open.key != key || cut.ends(open.count, open.last, t);
        let ends = self.open.as_ref().is_some_and(ends);
        let ended = ends.then(|| self.end()).flatten();
        let open = self.open.get_or_insert_with(|| Open {
            key,
            count: 0,
            trust: 0.0,
            t: 0.0,
            last: t,
            sum: vec![0.0; row.len()],
        });
        open.count += 1;
        open.trust += trust;
        open.t += t;
        open.last = t;
        open.sum
            .iter_mut()
            .zip(row)
            .for_each(|(sum, x)| *sum += trust * x);
        ended
    }

    /// The log ends.
    pub(crate) fn end(&mut self) -> Option<Independent> {
        let open = self.open.take()?;
        let (count, trust) = (open.count as f64, open.trust.max(f64::MIN_POSITIVE));
        let size = 1.0 / (trust * self.process.variance(count).sqrt());
        let mut row: Vec<f64> = open.sum.iter().map(|x| x * size).collect();
        let (t, share) = (open.t / count, self.process.share);
        let (rho, mut filter) = match self.before.take() {
            Some((before, filter)) => (self.process.correlation(t - before), filter),
            None => (0.0, Filter::new(row.len(), share)),
        };
        filter.whiten(rho, share, &mut row);
        self.before = Some((t, filter));
        Some(Independent {
            key: open.key,
            row,
            trust: open.trust / count,
        })
    }
}
