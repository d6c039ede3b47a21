//! Rows of a part of the postures: over their deviations, and as they are; and how they get there.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use crate::lsq::factor::Factor;
use crate::lsq::solve::{Seen, with_prior};
use crate::observations::row_matrix::RowMatrix;
use crate::threads::each;

/// Rows of one fold, or of several.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fold {
    /// Rows over their stated deviations.
    pub weighted: Factor,
    /// Rows as they are, where no one number makes them of the weighted ones.
    pub plain: Option<Factor>,
    /// Deviation that each row was divided by as long as `plain` is none: that which a log
    /// states of all rows, m, or 1 where it states none.
    pub each: f64,
}

impl Fold {
    /// No rows yet of `params` parameters.
    pub fn new(params: usize) -> Fold {
        Fold {
            weighted: Factor::new(params),
            plain: None,
            each: 1.0,
        }
    }

    /// Rows as they are.
    pub fn plain(&self) -> Cow<'_, Factor> {
        match &self.plain {
            Some(plain) => Cow::Borrowed(plain),
            None if self.each == 1.0 => Cow::Borrowed(&self.weighted),
            None => Cow::Owned(self.weighted.scaled(self.each)),
        }
    }

    /// From here on rows as they are get a factor of their own.
    pub(super) fn part_plain(&mut self) -> &mut Factor {
        let own = self.plain().into_owned();
        self.plain.get_or_insert(own)
    }

    /// Rows so far and rows over `each` have one deviation.
    pub(super) fn takes(&mut self, each: f64) -> bool {
        if self.plain.is_none() && self.weighted.rows() == 0 {
            self.each = each;
        }
        self.plain.is_none() && self.each == each
    }

    /// What these rows see; the same for every deviation and every prior.
    pub(in crate::fit) fn seen(&self) -> Seen {
        Seen::by(&self.plain(), &self.weighted)
    }

    /// Parameters by these rows, whose deviations are `sigma` times those stated (m where none
    /// are), and a prior with factor S about `cad`: with a prior they need no singular values.
    pub fn params(
        &self,
        sigma: f64,
        cad: &DVector<f64>,
        prior: Option<&DMatrix<f64>>,
    ) -> DVector<f64> {
        match prior {
            None => self.seen().solve(&self.weighted, sigma, cad, None).params,
            Some(s) => cad + s * with_prior(&self.weighted, sigma, cad, s).mean,
        }
    }

    /// Add the rows of another fold.
    pub(super) fn merge(&mut self, more: &Fold) {
        let empty = more.plain.is_none() && more.weighted.rows() == 0;
        let one_deviation = more.plain.is_none() && self.takes(more.each);
        if !empty && !one_deviation {
            self.part_plain().merge(&more.plain());
        }
        self.weighted.merge(&more.weighted);
    }
}

/// What becomes of rows.
pub(in crate::fit) enum Goal {
    /// They are weighed; and taken as they are where one number does not make those of them.
    Both,
    /// They are weighed alone.
    Weighted,
    /// They are taken as they are.
    Plain,
}

/// Rows for all folds.
pub(in crate::fit) struct Work {
    pub matrix: RowMatrix,
    pub reading: DVector<f64>,
    /// Numbers of the rows of each fold, and their weights.
    pub shares: Vec<Vec<(usize, f64)>>,
    pub goal: Goal,
}

impl Work {
    fn fold(&self, index: usize, fold: &mut Fold) {
        let share = &self.shares[index];
        let Some((_, weight)) = share.first() else {
            return;
        };
        let is_one = *weight > 0.0 && share.iter().all(|(_, own)| own == weight);
        let is_plain = match self.goal {
            Goal::Both => !(is_one && fold.takes(1.0 / weight)),
            Goal::Weighted => false,
            Goal::Plain => true,
        };
        if is_plain {
            let plain = share.iter().map(|(row, _)| (*row, 1.0));
            fold.part_plain()
                .push_rows(&self.matrix, &self.reading, plain);
        }
        if !matches!(self.goal, Goal::Plain) {
            let weighted = share.iter().copied();
            fold.weighted
                .push_rows(&self.matrix, &self.reading, weighted);
        }
    }
}

/// Fold rows in, each fold by one thread and in the order of the rows: what it comes to does not
/// depend on how many threads there are.
pub(in crate::fit) fn fold_in(work: &[Work], folds: &mut [Fold]) {
    let rows = work.iter().map(|work| work.matrix.rows()).sum();
    each(rows, folds.iter_mut().enumerate(), |(index, fold)| {
        work.iter().for_each(|work| work.fold(index, fold));
    });
}
