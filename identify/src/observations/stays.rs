//! How long noise lasts within the stays of a log.
//!
//! ```text
//! y_k = ȳ_stay + e_k                                  one mean for each stay
//! Var(mean of n rows)/Var(row) = f(n) = m/n − 2 a (1 − aⁿ)/(n (1 − a))²
//! ```
//!
//! with m = (1 + a)/(1 − a) rows per independent one. The means take the slow part of the
//! noise, so m is found by restricted maximum likelihood ([`super::correlation`]).

use nalgebra::{DMatrix, DVector};

use super::correlation::{Correlation, step};

/// Stays and rows that are looked at, at most.
const STAYS: usize = 40;
const ROWS: usize = 8000;

/// A row: its time and its reading.
type Row = (f64, [f64; 2]);

/// Rows of the first stays.
#[derive(Debug, Clone, Default)]
pub(crate) struct Stays {
    /// The posture and the visit of each, and its rows.
    all: Vec<((usize, u32), Vec<Row>)>,
    rows: usize,
}

impl Stays {
    /// One row of the `visit`-th visit of posture `number`.
    pub(crate) fn push(&mut self, stay: (usize, u32), t: f64, reading: [f64; 2]) {
        let room = self.all.len() < STAYS && self.rows < ROWS;
        // One row is no stay.
        if self
            .all
            .last()
            .is_some_and(|(last, rows)| *last != stay && rows.len() == 1)
            && room
        {
            self.all.pop();
            self.rows -= 1;
        }
        match self.all.last_mut() {
            Some((last, rows)) if *last == stay && self.rows < ROWS => rows.push((t, reading)),
            _ if room => self.all.push((stay, vec![(t, reading)])),
            // Rows that follow are not those of the last stay that is known.
            _ => self.rows = ROWS,
        }
        self.rows += 1;
    }

    /// Correlation of each axis; `variance` is over the mean square about the means.
    pub(crate) fn correlation(&self) -> [Correlation; 2] {
        let stays = || self.all.iter().filter(|(_, rows)| rows.len() > 1);
        let t: Vec<f64> = stays()
            .flat_map(|(_, rows)| rows.iter().map(|r| r.0))
            .collect();
        let (n, p) = (t.len(), stays().count());
        if p == 0 || step(&t).is_none() {
            return [Correlation::NONE; 2];
        }
        let mut x = DMatrix::zeros(n, p);
        let mut row = 0;
        for (stay, (_, rows)) in stays().enumerate() {
            for _ in rows {
                x[(row, stay)] = 1.0;
                row += 1;
            }
        }
        [0, 1].map(|axis| {
            let about_mean = |rows: &Vec<Row>| -> Vec<f64> {
                let mean = rows.iter().map(|r| r.1[axis]).sum::<f64>() / rows.len() as f64;
                rows.iter().map(|r| r.1[axis] - mean).collect()
            };
            let y: Vec<f64> = stays().flat_map(|(_, rows)| about_mean(rows)).collect();
            let square = y.iter().map(|y| y * y).sum::<f64>() / (n - p) as f64;
            if square.is_nan() || square <= 0.0 {
                return Correlation::NONE;
            }
            let y = DVector::from_vec(y) / square.sqrt();
            Correlation::of(&t, &y, &x)
        })
    }
}

/// Variance of the mean of `n` rows over a row's.
pub(crate) fn of_mean(correlation: &Correlation, n: f64) -> f64 {
    let m = correlation.rows_per_sample;
    let a = (m - 1.0) / (m + 1.0);
    let part = m / n - 2.0 * a * (1.0 - a.powf(n)) / (n * (1.0 - a)).powi(2);
    part.clamp(1.0 / n, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the sum (1/n²) Σ_jk a^|j − k|.
    #[test]
    fn the_mean_of_a_stay_is_known_as_its_rows_say() {
        for (a, n) in [(0.0, 5), (0.5, 1), (0.9, 20), (0.99, 200)] {
            let a: f64 = a;
            let pairs = (0..n).flat_map(|j: i32| (0..n).map(move |k: i32| (j - k).abs()));
            let sum: f64 = pairs.map(|lag| a.powi(lag)).sum();
            let expected = sum / f64::from(n * n);
            let known = Correlation {
                rows_per_sample: (1.0 + a) / (1.0 - a),
                ..Correlation::NONE
            };
            let found = of_mean(&known, f64::from(n));
            assert!((found / expected - 1.0).abs() < 1e-9, "{a} {n}: {found}");
        }
    }
}
