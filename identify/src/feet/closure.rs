//! How far two soles are from one floor, as encoders and URDF have them, and what tells.
//!
//! ```text
//! e = W (0 − y(φ))        S = I − K (I + KᵀK)⁻¹ Kᵀ        K = W σ_common per equation
//! χ² = eᵀ S e             gain of a column z:  (zᵀ S e)² / (zᵀ S z)
//! ```
//!
//! S leaves out what soles and floor may be off by in every posture alike.
//!
//! # Noise
//!
//! ```text
//! y_c = c + Σ_j slope_cj (δ_j + s_j q_j) + noise        c: height, roll, pitch
//! σ_c = max(what this leaves, floor), at most a limit
//! ```
//!
//! Offsets and scales of all joints take what any of them could; what they leave is noise:
//! ticks of encoders, soles that give way. Beside it soles and floor are not exactly flat,
//! the same in every posture: a tolerance common to all of them.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use sesc_model::Model;
use sesc_model::effects::other_sole_by_joints;
use sesc_model::tape::{Tape, Values};
use sesc_model::tree::Dof;

use super::other::OtherFoot;
use crate::evaluate::FASTEST;
use crate::observations::correlation::{Correlation, left};
use crate::observations::criteria::AS_GOOD;
use crate::observations::postures::rms;

/// χ² from which a column is more than noise: five standard deviations. Chosen: by chance
/// in one column of 1,700,000 (closed form); half of it in one of 2500.
const CLEAR: f64 = 25.0;
/// What an explanation leaves is more than noise from this part of it on. Chosen: half of
/// it calls a fit of soles that bend a little unexplained.
const MORE: f64 = 3.0;
/// An offset that is known no better, rad or m, is not known. Chosen: 29°; half of it
/// leaves offsets unnamed that soles do show.
const UNKNOWN: f64 = 0.5;

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
    pub(super) joints: Vec<Dof>,
    pub(super) slopes: DMatrix<f64>,
}

impl Closure {
    /// The equations in postures `q[posture * dof + joint]` (rad or m), at times `t` (s).
    pub(crate) fn of(model: &Model, other: OtherFoot, q: &[f64], t: Option<&[f64]>) -> Closure {
        let dof = model.dof();
        let n = q.len() / dof.max(1);
        let tape = Tape::new(&other_sole_by_joints(model, other.place()));
        let mut out = vec![0.0; n * tape.outputs()];
        tape.run(&[Values::PerPosture(q)], n, &mut out, FASTEST);
        let at = |row: usize, column: usize| out[row * (1 + dof) + column];
        // Slopes are far above 1e-9 m/rad or rad/rad, or none.
        let moves = |j: &usize| (0..ROWS * n).any(|row| at(row, 1 + j).abs() > 1e-9);
        let between: Vec<usize> = (0..dof).filter(moves).collect();
        let slopes = DMatrix::from_fn(ROWS * n, between.len(), |row, k| at(row, 1 + between[k]));
        let values: Vec<f64> = (0..ROWS * n).map(|row| at(row, 0)).collect();
        let positions = DMatrix::from_fn(n, between.len(), |k, c| q[k * dof + between[c]]);
        let noise = [0, 1, 2].map(|row| {
            let own: Vec<f64> = values.iter().skip(row).step_by(ROWS).copied().collect();
            let of = DMatrix::from_fn(n, between.len(), |k, c| slopes[(ROWS * k + row, c)]);
            noise_of(row, &own, &of, &positions, t)
        });
        let widened = noise.map(|(.., rows_per_sample)| rows_per_sample.sqrt());
        let dofs = &model.tree.dofs;
        Closure {
            std: [0, 1, 2].map(|row| noise[row].0 * widened[row]),
            common: COMMON,
            widened,
            from_log: noise.map(|(_, from_log, _)| from_log),
            support: model.support().to_string(),
            joints: between.iter().map(|index| dofs[*index].clone()).collect(),
            slopes,
            values,
            other,
        }
    }

    /// Postures.
    pub(crate) fn len(&self) -> usize {
        self.values.len() / ROWS
    }

    /// 1/σ of a row: posture by posture, equation by equation.
    pub(crate) fn weight(&self, row: usize) -> f64 {
        1.0 / self.std[row % ROWS]
    }

    /// Whitened residuals (0 − value)/σ of values of the equations.
    pub(crate) fn whitened(&self, values: impl Iterator<Item = f64>) -> DVector<f64> {
        let rows = values.enumerate();
        let rows = rows.map(|(row, value)| -value * self.weight(row));
        DVector::from_iterator(ROWS * self.len(), rows)
    }

    /// `S x`: whitened columns without what may be common to all postures.
    pub(crate) fn without_common(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
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
    pub(crate) fn without_common_of(&self, x: &DVector<f64>) -> DVector<f64> {
        let x = DMatrix::from_column_slice(x.len(), 1, x.as_slice());
        self.without_common(&x).column(0).into_owned()
    }

    /// χ² of whitened residuals against the noise as it is, however few samples the postures
    /// are worth, and what noise leaves.
    pub(crate) fn chi2(&self, residual: &DVector<f64>) -> (f64, f64) {
        let left = self.without_common_of(residual);
        let rows = left.iter().enumerate();
        let chi2 = rows.map(|(row, e)| (e * self.widened[row % ROWS]).powi(2));
        (chi2.sum(), left.len() as f64)
    }

    /// RMS of whitened residuals in their own units.
    pub(crate) fn lies(&self, residual: &DVector<f64>) -> Lies {
        Lies::from([0, 1, 2].map(|row| {
            let own = residual.iter().skip(row).step_by(ROWS);
            rms(own.map(|e| e * self.std[row]))
        }))
    }

    /// What is said where an explanation leaves `after` of what CAD leaves.
    pub(crate) fn said(&self, before: &DVector<f64>, after: &DVector<f64>) -> ClosureFound {
        let (chi2, expected) = self.chi2(after);
        ClosureFound {
            support: self.support.clone(),
            other_foot: self.other.name.clone(),
            postures: self.len(),
            before: self.lies(before),
            after: self.lies(after),
            noise: Lies::from([0, 1, 2].map(|row| self.std[row] / self.widened[row])),
            noise_from_log: self.from_log.iter().any(|own| *own),
            tolerance: Lies::from(self.common),
            chi2,
            expected,
            closes: chi2 <= MORE * expected,
            explained_by: Vec::new(),
            sentence: String::new(),
        }
    }

    /// Offsets of zero with the deviation that each has in such postures alone; those that the
    /// soles hardly show are left out.
    pub(crate) fn precision(&self) -> Vec<Offset> {
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
            let found = Offset::new(joint, offset, std);
            (offset * offset * square, k, found)
        };
        let all = (0..self.joints.len()).map(of).collect();
        (whole, all)
    }

    /// Whether the soles close as joint positions are by their `source`, CAD or the model file:
    /// what is said of it, with the joints whose offsets explain where they do not.
    pub(crate) fn found_by(&self, source: &str) -> ClosureFound {
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
            offsets.truncate(4);
            found.explained_by = offsets.into_iter().map(|(.., offset)| offset).collect();
        }
        found.sentence = found.of_joints(left, source);
        found
    }
}

/// Equations per posture: height (m), roll and pitch (rad) of the other sole.
pub(crate) const ROWS: usize = 3;
/// Noise of a posture is no smaller, m, rad, rad: ticks of encoders add up to about as much.
pub(super) const FLOOR: [f64; ROWS] = [3e-4, 1e-3, 1e-3];
/// … and no larger: soles that move more than this do not stand flat.
pub(super) const LIMIT: [f64; ROWS] = [5e-3, 0.02, 0.02];
/// Soles and floor are flat and parallel to this, m, rad, rad.
pub(super) const COMMON: [f64; ROWS] = [1e-3, 2.5e-3, 2.5e-3];
/// Standard deviation of equation `row` in a posture, whether the log has it, and postures per
/// independent one: from its values in every posture and its slopes by every joint that moves the
/// sole, at positions `q` of those joints.
fn noise_of(
    row: usize,
    values: &[f64],
    slopes: &DMatrix<f64>,
    q: &DMatrix<f64>,
    t: Option<&[f64]>,
) -> (f64, bool, f64) {
    let n = values.len();
    let joints = slopes.ncols();
    let y = DVector::from_column_slice(values);
    // Two postures a column leave noise.
    let counts = [1 + 2 * joints, 1 + joints];
    let Some(count) = counts.into_iter().find(|count| n >= 2 * count) else {
        return (FLOOR[row], false, 1.0);
    };
    let x = DMatrix::from_fn(n, count, |k, c| match c {
        0 => 1.0,
        c if c <= joints => slopes[(k, c - 1)],
        c => slopes[(k, c - 1 - joints)] * q[(k, c - 1 - joints)],
    });
    let std = left(&x, &y).0.sqrt();
    let known = if std.is_finite() { std } else { LIMIT[row] };
    let correlation = t.map_or(Correlation::NONE, |t| Correlation::of(t, &y, &x));
    (
        known.clamp(FLOOR[row], LIMIT[row]),
        (FLOOR[row]..=LIMIT[row]).contains(&known),
        correlation.rows_per_sample,
    )
}

/// How a sole lies on the floor, or how well that is known.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Lies {
    /// Roll, rad.
    pub roll_rad: f64,
    /// Pitch, rad.
    pub pitch_rad: f64,
    /// Height over the floor, m.
    pub height_m: f64,
}

impl From<[f64; ROWS]> for Lies {
    fn from([height_m, roll_rad, pitch_rad]: [f64; ROWS]) -> Lies {
        Lies {
            roll_rad,
            pitch_rad,
            height_m,
        }
    }
}

impl Lies {
    /// `1.52° of roll, 0.31° of pitch and 3.1 mm of height`
    pub fn sentence(&self) -> String {
        format!(
            "{:.2}° of roll, {:.2}° of pitch and {:.1} mm of height",
            self.roll_rad.to_degrees(),
            self.pitch_rad.to_degrees(),
            1e3 * self.height_m
        )
    }
}

/// What an encoder is off by.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Offset {
    /// The joint.
    pub joint: String,
    /// Offset of a revolute joint, rad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_rad: Option<f64>,
    /// Offset of a prismatic joint, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_m: Option<f64>,
    /// Its standard deviation, rad or m.
    pub std: f64,
}

impl Offset {
    pub(super) fn new(joint: &Dof, offset: f64, std: f64) -> Offset {
        Offset {
            joint: joint.joint.clone(),
            offset_rad: (!joint.prismatic).then_some(offset),
            offset_m: joint.prismatic.then_some(offset),
            std,
        }
    }

    /// rad or m
    pub(super) fn value(&self) -> f64 {
        self.offset_rad.or(self.offset_m).unwrap_or(0.0)
    }

    /// `1.49° of l_knee`
    fn sentence(&self) -> String {
        match self.offset_rad {
            Some(offset) => format!("{:.2}° of {}", offset.to_degrees(), self.joint),
            None => format!("{:.1} mm of {}", 1e3 * self.value(), self.joint),
        }
    }
}

/// How two soles of a log of both feet close.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ClosureFound {
    /// Link whose sole is the floor.
    pub support: String,
    /// Link of the other sole.
    pub other_foot: String,
    /// Postures that were looked at.
    pub postures: usize,
    /// RMS of roll, pitch, height by CAD.
    pub before: Lies,
    /// The same with the explanation.
    pub after: Lies,
    /// Standard deviation in one posture.
    pub noise: Lies,
    /// Whether the log has this noise; else it is the least that is believed.
    pub noise_from_log: bool,
    /// Tolerance in every posture alike.
    pub tolerance: Lies,
    /// χ² of what the explanation leaves.
    pub chi2: f64,
    /// χ² that noise leaves.
    pub expected: f64,
    /// Whether only noise is left.
    pub closes: bool,
    /// Joints whose offset alone explains it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub explained_by: Vec<Offset>,
    /// The whole in words.
    pub sentence: String,
}

impl ClosureFound {
    /// Returns the one of two logs whose soles lie worse.
    pub(crate) fn worse(self, other: ClosureFound) -> ClosureFound {
        let ratio = |found: &ClosureFound| {
            let open = if found.closes { 0.0 } else { 1e9 };
            open + found.chi2 / found.expected.max(1.0)
        };
        if ratio(&other) > ratio(&self) {
            other
        } else {
            self
        }
    }

    /// What no log gives, in a file that was read.
    pub(crate) fn invalid_reason(&self) -> Option<String> {
        let lies = [&self.before, &self.after, &self.noise, &self.tolerance];
        let sizes = lies.map(|lies| [lies.roll_rad, lies.pitch_rad, lies.height_m]);
        let sizes = sizes.into_iter().flatten();
        let numbers = sizes.chain([self.chi2, self.expected]);
        let of_joints = self.explained_by.iter().map(|offset| offset.value().abs());
        let valid = numbers.chain(of_joints).all(|x| (0.0..=1e30).contains(&x))
            && self.sentence.len() <= 10_000;
        (!valid).then(|| "`closure` that no log gives".to_string())
    }

    /// `The soles of r_sole and l_sole are 1.52° of roll … apart by CAD`
    fn apart(&self, by: &str) -> String {
        format!(
            "By {by} the sole of {} is {} RMS off that of {}",
            self.other_foot,
            self.before.sentence(),
            self.support
        )
    }

    /// What a fit says, which can do nothing about it; `left`: the best offset leaves more
    /// than noise, `by`: who has the joints there.
    fn of_joints(&self, left: bool, by: &str) -> String {
        let apart = self.apart(by);
        if self.closes {
            return format!("{apart}, as noise and the flatness of soles allow.");
        }
        let offsets: Vec<String> = self.explained_by.iter().map(Offset::sentence).collect();
        let Some((first, others)) = offsets.split_first() else {
            return format!(
                "{apart}, and no offset of one joint explains it: check that both soles are flat \
                 on one floor and that their frames lie in them, z up."
            );
        };
        let or = match others {
            [] => String::new(),
            others => format!(" (or {})", others.join(", or ")),
        };
        let most = if left { "most of it" } else { "it" };
        format!(
            "{apart}: an offset of {first}{or} explains {most}, which bends the legs and moves the \
             CoM."
        )
    }

    /// What a diagnosis says, whose explanation leaves `after`; `changed` where there is one.
    pub(crate) fn explained(mut self, changed: bool) -> ClosureFound {
        let after = self.after.sentence();
        let rest = match (self.closes, changed) {
            (true, false) => "as noise and the flatness of soles allow".to_string(),
            (true, true) => format!("{after} with it"),
            (false, _) => {
                let still = if changed {
                    format!("still {after} with it, ")
                } else {
                    String::new()
                };
                format!(
                    "{still}which noise does not explain: check that both soles are flat on one \
                     floor, and that their frames lie in them, z up"
                )
            }
        };
        self.sentence = format!("{}, {rest}.", self.apart("CAD"));
        self
    }
}
