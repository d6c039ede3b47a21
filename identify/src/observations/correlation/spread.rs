//! How far noise that lasts moves a sum over rows.
//!
//! ```text
//! Var(Σ_k z_k e_k) = Σ_w Σ_v S_w S_v Cov(ē_w, ē_v) + (1 − l) Σ_w Σ_k (z_k − z̄_w)²
//! ```
//!
//! over windows w of the process, whose means ē are correlated and whose rows share the part l
//! of their variance; S_w is the sum of z over a window. What changes faster than the noise
//! lasts is moved little by it, what is as slow as it by all of it.

use nalgebra::{DMatrix, DVector};

use super::Process;

impl Process {
    /// `Var(zᵀ e)`, k × k, over the variance of a row, of the `k` columns of `z` (one row for
    /// each time of `t`, s) and noise e that follows this process.
    pub fn spread(&self, t: &[f64], z: &DMatrix<f64>) -> DMatrix<f64> {
        let k = z.ncols();
        let mut spread = DMatrix::zeros(k, k);
        // What earlier windows say of the noise of this one, and the middle of the last.
        let mut before: Option<(f64, DVector<f64>)> = None;
        let mut start = 0;
        while start < t.len() {
            let mut end = start + 1;
            while end < t.len() && !self.cut.ends(end - start, t[end - 1], t[end]) {
                end += 1;
            }
            let rows = (end - start) as f64;
            let own = z.rows(start, end - start);
            let sum = own.row_sum_tr();
            let middle = t[start..end].iter().sum::<f64>() / rows;
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
            start = end;
        }
        spread
    }
}
