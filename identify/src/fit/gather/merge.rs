//! Sums of several logs, machines or sessions together, and sums that no logs can have; folds
//! together: all of them, and all but each of them.
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

use sesc_model::standard::Shift;

use super::{Fold, Gathered, LogUsed};
use crate::feet::ClosureFound;
use crate::logs::Weight;
use crate::{Message, Setting, message};

/// Sums of a log are not larger, nor its rows more: what values within their bounds give.
const MOST_SUM: f64 = 1e60;
const MOST_ROWS: f64 = 1e15;

impl Gathered {
    /// The first sum that no logs can have, in a file that was read.
    pub(in crate::fit) fn invalid_reason(&self) -> Option<String> {
        let readings = self.readings as f64;
        let (counts, sums) = (|| 0.0..=MOST_ROWS, || 0.0..=MOST_SUM);
        let mut all = vec![
            ("readings", readings, counts()),
            ("stated", self.stated, sums()),
            ("trusted", self.trusted, 0.0..=readings),
            ("consistency", self.consistency, f64::MIN_POSITIVE..=1.0),
            ("averaged", self.averaged, 0.0..=readings),
            ("moved", self.moved as f64, counts()),
            ("overfull", self.overfull as f64, counts()),
            ("tiny", self.tiny as f64, counts()),
            (
                "motion.rows_left_out",
                self.motion.rows_left_out as f64,
                counts(),
            ),
        ];
        all.extend(
            self.logs
                .iter()
                .map(|log| ("rows", log.rows as f64, counts())),
        );
        all.extend(self.axes.map(|x| ("axes", x, sums())));
        for fold in &self.folds {
            all.push(("each", fold.each, f64::MIN_POSITIVE..=MOST_SUM));
            for factor in [&fold.weighted, &*fold.plain()] {
                all.push(("triangle", factor.largest(), sums()));
                all.push(("rows", factor.rows() as f64, counts()));
            }
        }
        all.into_iter()
            .find(|(_, x, range)| !range.contains(x))
            .map(|(name, x, _)| format!("`{name}` is {x:?}, which no log gives"))
            .or_else(|| self.repeats.invalid_reason(MOST_ROWS, MOST_SUM))
            .or_else(|| self.samples.invalid_reason(MOST_ROWS))
            .or_else(|| self.closure.as_ref()?.invalid_reason())
            .or_else(|| self.again.as_ref()?.invalid_reason())
    }

    /// Add what another machine or session of measurements gathered.
    ///
    /// # Errors
    /// When the parts differ in parameters, folds or stated deviations.
    pub fn merge(&mut self, other: Gathered) -> Result<(), Message> {
        let (here, there) = (self.params(), other.params());
        if here != there {
            return Err(format!("{here} parameters here, {there} there").into());
        }
        let (here, there) = (self.folds.len(), other.folds.len());
        if here != there {
            return Err(message![
                format!("{here} folds here, {there} there; gather all parts with the same "),
                Setting::Folds
            ]);
        }
        if self.readings > 0
            && other.readings > 0
            && self.has_deviations() != other.has_deviations()
        {
            return Err("one part states deviations of its readings, the other does not".into());
        }
        let known = |log: &&LogUsed| self.logs.iter().any(|own| own.hash == log.hash);
        if let Some(log) = other.logs.iter().find(known) {
            return Err(format!("{} is in both: its postures would count twice", log.file).into());
        }
        for (fold, more) in self.folds.iter_mut().zip(&other.folds) {
            fold.merge(more);
        }
        self.repeats.merge(&other.repeats);
        self.stated += other.stated;
        self.readings += other.readings;
        self.logs.extend(other.logs);
        self.down_weighted.extend(other.down_weighted);
        self.trusted += other.trusted;
        self.consistency = self.consistency.min(other.consistency);
        self.moved += other.moved;
        self.overfull += other.overfull;
        self.averaged += other.averaged;
        self.tiny += other.tiny;
        self.health.extend(other.health);
        self.samples.merge(&other.samples);
        self.motion.merge(&other.motion);
        let closures = self.closure.take().into_iter().chain(other.closure);
        self.closure = closures.reduce(ClosureFound::worse);
        let weights = self.weight.take().into_iter().chain(other.weight);
        self.weight = weights.reduce(Weight::farther);
        self.correlated |= other.correlated;
        for (sum, more) in self.axes.iter_mut().zip(other.axes) {
            *sum += more;
        }
        Ok(())
    }

    /// Rewrite the sums for the parameters of another support.
    pub fn shift(&mut self, shift: &Shift) {
        for fold in &mut self.folds {
            fold.weighted = fold.weighted.shifted(shift);
            fold.plain = fold.plain.as_ref().map(|plain| plain.shifted(shift));
        }
    }

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
