//! A few readings that come from elsewhere: noise of two widths.
//!
//! ```text
//! p(y_i) = (1 − ε) N(0, σ) + ε N(0, ρ σ)        per posture, both axes together
//! ```

use super::criteria;

#[derive(Debug, Clone)]
pub(super) struct Outliers {
    /// ε
    pub share: f64,
    /// ρ
    pub width: f64,
    /// Chance of each posture to be one.
    pub chance: Vec<f64>,
}

impl Outliers {
    /// Share and width that explain whitened residuals best (x, y per posture).
    pub(super) fn of(residual: &[f64], keep: Option<&[bool]>) -> Outliers {
        let squares = squares(residual);
        let kept = |k: usize| keep.is_none_or(|keep| keep[k]);
        let count = (0..squares.len()).filter(|&k| kept(k)).count().max(1) as f64;
        let mut found = Outliers {
            share: 0.05,
            width: 10.0,
            chance: vec![0.0; squares.len()],
        };
        for _ in 0..60 {
            found.judge(&squares);
            let all = |f: &dyn Fn(usize) -> f64| {
                (0..squares.len()).filter(|&k| kept(k)).map(f).sum::<f64>()
            };
            let sum = all(&|k| found.chance[k]);
            let spread = all(&|k| found.chance[k] * squares[k]);
            found.share = (sum / count).clamp(1e-4, criteria::LARGEST_OUTLIER_SHARE);
            let width = if sum > 1e-9 {
                (spread / (2.0 * sum)).sqrt()
            } else {
                criteria::OUTLIER_WIDTH.0
            };
            found.width = width.clamp(criteria::OUTLIER_WIDTH.0, criteria::OUTLIER_WIDTH.1);
        }
        found.judge(&squares);
        found
    }

    /// Log likelihood of a reading of this square by the narrow noise, and by the wide one.
    fn log_likelihoods(&self, square: f64) -> [f64; 2] {
        let shrunk = square / (self.width * self.width);
        [
            (1.0 - self.share).ln() - 0.5 * square,
            self.share.ln() - 2.0 * self.width.ln() - 0.5 * shrunk,
        ]
    }

    fn judge(&mut self, squares: &[f64]) {
        let chance = |square: &f64| {
            let [narrow, wide] = self.log_likelihoods(*square);
            1.0 / (1.0 + (narrow - wide).exp())
        };
        self.chance = squares.iter().map(chance).collect();
    }

    /// Root of the weight of each reading.
    pub(super) fn root_weights(&self, keep: Option<&[bool]>) -> Vec<f64> {
        let narrow = 1.0 / (self.width * self.width);
        let weight = |(k, c): (usize, &f64)| match keep.is_none_or(|keep| keep[k]) {
            true => [(1.0 - c + c * narrow).sqrt(); 2],
            false => [0.0; 2],
        };
        self.chance.iter().enumerate().flat_map(weight).collect()
    }

    /// −2 log likelihood where `narrow` is that of the readings as weighted: the
    /// weighted squares are exchanged for the mixture's.
    pub(super) fn objective(&self, residual: &[f64], keep: Option<&[bool]>, narrow: f64) -> f64 {
        let weights = self.root_weights(keep);
        let squares = squares(residual);
        let mut objective = narrow;
        for (k, square) in squares.iter().enumerate() {
            if keep.is_some_and(|keep| !keep[k]) {
                continue;
            }
            let [near, far] = self.log_likelihoods(*square);
            let most = near.max(far);
            let mixture = most + ((near - most).exp() + (far - most).exp()).ln();
            objective += -2.0 * mixture - weights[2 * k].powi(2) * square;
        }
        objective
    }

    /// Postures that are rather outliers than not.
    pub(super) fn named(&self) -> Vec<usize> {
        (0..self.chance.len())
            .filter(|&k| self.chance[k] > criteria::OUTLIER_CHANCE)
            .collect()
    }
}

fn squares(residual: &[f64]) -> Vec<f64> {
    let pairs = residual.chunks_exact(2);
    let squares = pairs.map(|pair| pair[0] * pair[0] + pair[1] * pair[1]);
    squares.collect()
}
