//! Folds together: all of them, and all but each of them.
//!
//! ```text
//! others(k) = all folds but k        halves share what is outside both:
//!
//!     all ─┬─ left half, with the right one outside ─┬─ …
//!          └─ right half, with the left one outside ─┴─ …
//! ```
//!
//! Of n folds that is n log₂ n merges where each fold's others alone would be n (n − 1), and
//! log₂ n factors are held at once.

use std::ops::Range;

use super::{Fold, Gathered};

impl Gathered {
    /// All folds together.
    pub fn together(&self) -> Fold {
        self.with(Fold::new(self.params()), 0..self.folds.len())
    }

    /// Call `take` with the number of each fold, in order, and all others together.
    pub(in crate::fit) fn without_each(&self, take: &mut dyn FnMut(usize, &Fold)) {
        self.without(0..self.folds.len(), Fold::new(self.params()), take);
    }

    fn without(&self, folds: Range<usize>, outside: Fold, take: &mut dyn FnMut(usize, &Fold)) {
        if folds.len() == 1 {
            return take(folds.start, &outside);
        }
        let middle = folds.start + folds.len() / 2;
        let (left, right) = (folds.start..middle, middle..folds.end);
        self.without(
            left.clone(),
            self.with(outside.clone(), right.clone()),
            take,
        );
        self.without(right, self.with(outside, left), take);
    }

    /// These folds with others.
    fn with(&self, mut others: Fold, folds: Range<usize>) -> Fold {
        for fold in &self.folds[folds] {
            others.merge(fold);
        }
        others
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::lsq::factor::Factor;

    /// Against the rows themselves, in one factor each.
    #[test]
    fn others_are_all_rows_but_those_of_the_fold() {
        for folds in [2, 3, 7, 10] {
            let mut gathered = Gathered::new(4, folds);
            let entry = |i: usize, j: usize| ((i * 7 + j * 13 + i * j) as f64 * 0.7).sin();
            let rows = |k: usize| {
                let matrix = DMatrix::from_fn(5, 4, |i, j| entry(5 * k + i, j));
                let reading = DVector::from_fn(5, |i, _| entry(5 * k + i, 9));
                (matrix, reading)
            };
            for (k, fold) in gathered.folds.iter_mut().enumerate() {
                let (matrix, reading) = rows(k);
                fold.weighted.push(&matrix, &reading, &[2.0; 5]);
                // The last fold has deviations of its own.
                if k + 1 == folds {
                    let mut plain = Factor::new(4);
                    plain.push(&matrix, &reading, &[1.0; 5]);
                    fold.plain = Some(plain);
                }
            }
            let params = DVector::from_vec(vec![0.3, -0.2, 0.9, 0.1]);
            let sum = |k: usize| {
                let (matrix, reading) = rows(k);
                (matrix * &params - reading).norm_squared()
            };
            let mut taken = Vec::new();
            gathered.without_each(&mut |k, others| {
                let own: f64 = (0..folds).filter(|other| *other != k).map(sum).sum();
                let found = others.weighted.residual_sum(&params);
                assert!((found - 4.0 * own).abs() < 1e-12 * own, "{found} {own}");
                // As they are, those that have no deviations count four times.
                let others_last = f64::from(u8::from(k + 1 < folds));
                let last = others_last * 3.0 * sum(folds - 1);
                let found = others.plain().residual_sum(&params);
                assert!((found - (4.0 * own - last)).abs() < 1e-12 * own);
                assert_eq!(others.weighted.rows(), 5 * (folds as u64 - 1));
                taken.push(k);
            });
            assert_eq!(taken, (0..folds).collect::<Vec<_>>());
            assert_eq!(gathered.together().weighted.rows(), 5 * folds as u64);
        }
    }
}
