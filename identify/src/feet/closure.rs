//! How far two soles are from one floor, as encoders and URDF have them, and what tells.
//!
//! ```text
//! e = W (0 − y(φ))        S = I − K (I + KᵀK)⁻¹ Kᵀ        K = W σ_common per equation
//! χ² = eᵀ S e             gain of a column z:  (zᵀ S e)² / (zᵀ S z)
//! ```
//!
//! S leaves out what soles and floor may be off by in every posture alike.

use nalgebra::{DMatrix, DVector};
use sesc_model::Model;
use sesc_model::effects::other_sole_by_joints;
use sesc_model::tape::{Tape, Values};

use super::criteria::closure::{CLEAR, MORE, NAMED, NO_SLOPE, UNKNOWN};
use super::noise::{self, COMMON, ROWS};
use super::other::OtherFoot;
use super::soles::{ClosureFound, Lies, Offset};
use crate::evaluate::FASTEST;
use crate::observations::criteria::AS_GOOD;
use crate::observations::postures::rms;

/// The equations of a log, posture by posture, and their noise.
#[derive(Debug, Clone)]
pub(crate) struct Closure {
    /// The other sole.
    pub other: OtherFoot,
    /// Standard deviation of each equation in one posture as the log counts it, m, rad, rad.
    pub std: [f64; ROWS],
    /// What soles and floor may be off by in all postures alike, m, rad, rad.
    pub common: [f64; ROWS],
    /// Factor of the noise for postures that are no independent samples.
    pub widened: [f64; ROWS],
    /// Where the noise of each equation is the log's own; else it is the least or the largest
    /// that is believed.
    from_log: [bool; ROWS],
    support: String,
    /// Closure that CAD predicts, m, rad, rad.
    pub(super) values: Vec<f64>,
    /// Independent joints between the soles, and slopes by them, a column each.
    pub(super) joints: Vec<Between>,
    pub(super) slopes: DMatrix<f64>,
}

/// An independent joint between the soles.
#[derive(Debug, Clone)]
pub(super) struct Between {
    pub name: String,
    prismatic: bool,
}

impl Closure {
    /// The equations in postures `q[posture * dof + joint]` (rad or m), at times `t` (s).
    pub fn of(model: &Model, other: OtherFoot, q: &[f64], t: Option<&[f64]>) -> Closure {
        let dof = model.dof();
        let n = q.len() / dof.max(1);
        let tape = Tape::new(&other_sole_by_joints(model, other.place()));
        let mut out = vec![0.0; n * tape.outputs()];
        tape.run(&[Values::PerPosture(q)], n, &mut out, FASTEST);
        let at = |row: usize, column: usize| out[row * (1 + dof) + column];
        let moves = |j: &usize| (0..ROWS * n).any(|row| at(row, 1 + j).abs() > NO_SLOPE);
        let between: Vec<usize> = (0..dof).filter(moves).collect();
        let slopes = DMatrix::from_fn(ROWS * n, between.len(), |row, k| at(row, 1 + between[k]));
        let values: Vec<f64> = (0..ROWS * n).map(|row| at(row, 0)).collect();
        let positions = DMatrix::from_fn(n, between.len(), |k, c| q[k * dof + between[c]]);
        let noise = [0, 1, 2].map(|row| {
            let own: Vec<f64> = values.iter().skip(row).step_by(ROWS).copied().collect();
            let of = DMatrix::from_fn(n, between.len(), |k, c| slopes[(ROWS * k + row, c)]);
            noise::of(row, &own, &of, &positions, t)
        });
        let widened = noise.map(|noise| noise.rows_per_sample.sqrt());
        let dofs = &model.tree.dofs;
        Closure {
            std: [0, 1, 2].map(|row| noise[row].std * widened[row]),
            common: COMMON,
            widened,
            from_log: noise.map(|noise| noise.from_log),
            support: model.support().to_string(),
            joints: between
                .into_iter()
                .map(|index| Between {
                    name: dofs[index].joint.clone(),
                    prismatic: dofs[index].prismatic,
                })
                .collect(),
            slopes,
            values,
            other,
        }
    }

    /// Postures.
    pub fn len(&self) -> usize {
        self.values.len() / ROWS
    }

    /// 1/σ of a row: posture by posture, equation by equation.
    pub fn weight(&self, row: usize) -> f64 {
        1.0 / self.std[row % ROWS]
    }

    /// Whitened residuals (0 − value)/σ of values of the equations.
    pub fn whitened(&self, values: impl Iterator<Item = f64>) -> DVector<f64> {
        let rows = values.enumerate();
        DVector::from_iterator(
            ROWS * self.len(),
            rows.map(|(row, value)| -value * self.weight(row)),
        )
    }

    /// `S x`: whitened columns without what may be common to all postures.
    pub fn without_common(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let n = self.len() as f64;
        let mut rest = x.clone();
        for mut column in rest.column_iter_mut() {
            for row in 0..ROWS {
                let strength = n * (self.common[row] / self.std[row]).powi(2);
                let own = column.iter().skip(row).step_by(ROWS);
                let mean = own.sum::<f64>() / n;
                let taken = strength / (1.0 + strength) * mean;
                let own = column.iter_mut().skip(row).step_by(ROWS);
                own.for_each(|x| *x -= taken);
            }
        }
        rest
    }

    /// The same of one column.
    pub fn without_common_of(&self, x: &DVector<f64>) -> DVector<f64> {
        let x = DMatrix::from_column_slice(x.len(), 1, x.as_slice());
        self.without_common(&x).column(0).into_owned()
    }

    /// χ² of whitened residuals against the noise as it is, however few samples the postures
    /// are worth, and what noise leaves.
    pub fn chi2(&self, residual: &DVector<f64>) -> (f64, f64) {
        let left = self.without_common_of(residual);
        let rows = left.iter().enumerate();
        let chi2 = rows.map(|(row, e)| (e * self.widened[row % ROWS]).powi(2));
        (chi2.sum(), left.len() as f64)
    }

    /// RMS of whitened residuals in their own units.
    pub fn lies(&self, residual: &DVector<f64>) -> Lies {
        let [height_m, roll_rad, pitch_rad] = [0, 1, 2].map(|row| {
            let own = residual.iter().skip(row).step_by(ROWS);
            rms(own.map(|e| e * self.std[row]))
        });
        Lies {
            roll_rad,
            pitch_rad,
            height_m,
        }
    }

    /// What is said where an explanation leaves `after` of what CAD leaves.
    pub fn said(&self, before: &DVector<f64>, after: &DVector<f64>) -> ClosureFound {
        let (chi2, expected) = self.chi2(after);
        let noise = |of: &dyn Fn(usize) -> f64| Lies {
            height_m: of(0),
            roll_rad: of(1),
            pitch_rad: of(2),
        };
        ClosureFound {
            support: self.support.clone(),
            other_foot: self.other.name.clone(),
            postures: self.len(),
            before: self.lies(before),
            after: self.lies(after),
            noise: noise(&|row| self.std[row] / self.widened[row]),
            noise_from_log: self.from_log.iter().any(|own| *own),
            tolerance: noise(&|row| self.common[row]),
            chi2,
            expected,
            closes: chi2 <= MORE * expected,
            explained_by: Vec::new(),
            sentence: String::new(),
        }
    }

    /// Offsets of zero with the deviation that each has in such postures alone; those that the
    /// soles hardly show are left out.
    pub fn precision(&self) -> Vec<Offset> {
        let all = self.offsets(&DVector::zeros(ROWS * self.len())).1;
        let known = all.into_iter().map(|(.., offset)| offset);
        known.filter(|offset| offset.std < UNKNOWN).collect()
    }

    /// Whitened columns of the joints; and of each alone its χ², its place and its offset.
    fn offsets(&self, rest: &DVector<f64>) -> (DMatrix<f64>, Vec<(f64, usize, Offset)>) {
        let rows = ROWS * self.len();
        let whole = DMatrix::from_fn(rows, self.joints.len(), |row, k| {
            self.slopes[(row, k)] * self.weight(row)
        });
        let projected = self.without_common(&whole);
        let of = |k: usize| {
            let square = whole.column(k).dot(&projected.column(k)).max(1e-12);
            let offset = whole.column(k).dot(rest) / square;
            let joint = &self.joints[k];
            let std = 1.0 / square.sqrt();
            let found = Offset::new(joint.name.clone(), joint.prismatic, offset, std);
            (offset * offset * square, k, found)
        };
        let all = (0..self.joints.len()).map(of).collect();
        (whole, all)
    }

    /// Whether the soles close as CAD has them: what is said of it, with the joints whose
    /// offsets explain where they do not.
    pub fn of_cad(&self) -> ClosureFound {
        self.found_by("CAD")
    }

    /// The same where joint positions are those of a model file.
    pub fn of_model(&self) -> ClosureFound {
        self.found_by("the model file")
    }

    fn found_by(&self, source: &str) -> ClosureFound {
        let residual = self.whitened(self.values.iter().copied());
        let rest = self.without_common_of(&residual);
        let (whole, mut offsets) = self.offsets(&rest);
        offsets.sort_by(|a, b| b.0.total_cmp(&a.0));
        let best = offsets.first().map_or(0.0, |best| best.0);
        let clear = best > CLEAR;
        let mut after = residual.clone();
        if let Some((_, k, offset)) = offsets.first().filter(|_| clear) {
            after -= whole.column(*k) * offset.value();
        }
        let mut found = self.said(&residual, &after);
        let left = !found.closes;
        found.closes &= !clear;
        if clear {
            offsets.retain(|(gain, ..)| *gain > best - AS_GOOD);
            offsets.truncate(NAMED);
            found.explained_by = offsets.into_iter().map(|(.., offset)| offset).collect();
        }
        found.sentence = found.of_joints(left, source);
        found
    }
}
