//! The soles of a two-foot stand under a hypothesis: further rows beside the readings.
//!
//! ```text
//! χ² = (y − f)ᵀ S_masses (y − f) + (0 − h)ᵀ S_soles (0 − h)        h: see `feet`
//! ```
//!
//! Masses move no sole, and sensors and the ground's slope do not: what bends the legs does.
//! Where joints give way, they do so as in the readings, under the moments of a robot that
//! stands on the support alone.

use nalgebra::{DMatrix, DVector};
use sesc_model::effects::Stage;
use sesc_model::tape::Values;

use super::{Fit, Problem};
use crate::diagnose::hypothesis::Term;
use crate::diagnose::nuisance::Nuisance;
use crate::evaluate::FASTEST;
use crate::feet::{Closure, ROWS};

/// Whitened rows of the soles: three a posture.
#[derive(Debug, Clone)]
pub struct Closed {
    /// (0 − value)/σ
    pub residual: DVector<f64>,
    /// Derivative of the value by the unknowns, over σ.
    pub slopes: DMatrix<f64>,
}

/// Whether a term moves a joint from where its encoder says.
fn bends(term: &Term) -> bool {
    let moves = |stage| stage <= Stage::Joints || stage == Stage::Bends;
    term.stage().is_some_and(moves)
}

impl Problem<'_> {
    /// The soles under `terms`; `None` where the log is not of both feet.
    pub fn closed(
        &self,
        terms: &[Term],
        unknowns: &[f64],
        posture_context: &[f64],
    ) -> Option<Closed> {
        self.closed_at(terms, unknowns, &self.data.q, posture_context)
    }

    /// The same at joint positions `q`.
    pub fn closed_at(
        &self,
        terms: &[Term],
        unknowns: &[f64],
        q: &[f64],
        posture_context: &[f64],
    ) -> Option<Closed> {
        let closure = self.closure.as_deref()?;
        // Sensors, masses and the ground move no sole: one program is enough for them all.
        let idle = !terms.iter().any(bends);
        let (own, given): (&[Term], &[f64]) = match idle {
            true => (&[], &[]),
            false => (terms, unknowns),
        };
        let tape = self.soles(own, &closure.other);
        let n = self.data.len();
        let mut out = vec![0.0; n * tape.outputs()];
        let arguments = [
            Values::PerPosture(q),
            Values::Shared(given),
            Values::PerPosture(posture_context),
        ];
        tape.run(&arguments, n, &mut out, FASTEST);
        let width = 1 + given.len();
        let slopes = DMatrix::from_fn(ROWS * n, unknowns.len(), |row, k| match idle {
            true => 0.0,
            false => out[row * width + 1 + k] * closure.weight(row),
        });
        Some(Closed {
            residual: closure.whitened(out.iter().step_by(width).copied()),
            slopes,
        })
    }

    /// Columns of readings and, below them, of the soles.
    pub(in crate::diagnose) fn stacked(
        &self,
        readings: &DMatrix<f64>,
        soles: Option<&DMatrix<f64>>,
    ) -> DMatrix<f64> {
        let Some(soles) = soles else {
            return readings.clone();
        };
        let (n, p) = readings.shape();
        let mut all = DMatrix::zeros(n + soles.nrows(), p);
        all.rows_mut(0, n).copy_from(readings);
        all.rows_mut(n, soles.nrows()).copy_from(soles);
        all
    }

    /// Whitened residuals of readings and, below them, of the soles.
    pub(in crate::diagnose) fn stacked_residual(
        &self,
        readings: &DVector<f64>,
        soles: Option<&Closed>,
    ) -> DVector<f64> {
        let Some(soles) = soles else {
            return readings.clone();
        };
        let all = readings.iter().chain(soles.residual.iter());
        DVector::from_iterator(readings.len() + soles.residual.len(), all.copied())
    }

    /// What of stacked columns is neither a mass error nor common to all soles.
    pub(in crate::diagnose) fn project_out(
        &self,
        masses: &Nuisance,
        stacked: &DMatrix<f64>,
    ) -> DMatrix<f64> {
        let n = 2 * self.data.len();
        let of_readings = masses.project_out(&stacked.rows(0, n).into_owned());
        let soles = self.closure.as_deref().map(|closure: &Closure| {
            let own = stacked.rows(n, stacked.nrows() - n).into_owned();
            closure.without_common(&own)
        });
        self.stacked(&of_readings, soles.as_ref())
    }

    /// The same of one column.
    pub(in crate::diagnose) fn project_out_one(
        &self,
        masses: &Nuisance,
        stacked: &DVector<f64>,
    ) -> DVector<f64> {
        let column = DMatrix::from_column_slice(stacked.len(), 1, stacked.as_slice());
        self.project_out(masses, &column).column(0).into_owned()
    }

    /// Whitened residuals of `fit`, of readings and soles; and its slopes.
    pub(in crate::diagnose) fn whole(&self, fit: &Fit) -> (DVector<f64>, DMatrix<f64>) {
        let closed = fit.closed.as_ref();
        (
            self.stacked_residual(&fit.residual, closed),
            self.stacked(&fit.slopes, closed.map(|closed| &closed.slopes)),
        )
    }
}
