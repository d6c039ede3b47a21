//! Encoders that do not move though their joint does.
//!
//! ```text
//! y_k = p(q_k + δ_k e_j) + noise        one unknown δ_k a posture, for the joint j
//! ```
//!
//! A joint that really stands still is no finding: the readings must be explained by its
//! motion, within its limits, and by no wiring, offset or scale, nor by masses within the usual
//! tolerances of CAD.
//!
//! ```text
//! min over r   ‖(y − X r) / σ‖² + ‖S⁻¹ (r − r_CAD)‖²        S Sᵀ: covariance of the usual tolerances
//! ```
//!
//! # Encoders that stop in the middle of a log
//!
//! ```text
//! q_j = const over a run of rows in which other joints move, and moves elsewhere
//! ‖y − p(q)‖ of the run ≫ ‖y − p(q)‖ of the other rows, and motion of j explains it
//! ```
//!
//! Over the log as a whole such an encoder moves. A joint that is really held for a while leaves
//! no more in that time than in the rest, whatever effects are hidden; rows of a run in which it
//! is not held are left out.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use sesc_model::Function;
use sesc_model::tree::Dof;

use super::criteria::{
    ANYWHERE, BEYOND_LIMITS, BY_MASSES, LEAST_MOTION, NEARLY_ALL, ONE_AS_WELL, PARKED_ROWS,
    PARKED_WORSE, QUIETEST, SOME_ROWS, STILL, STUCK_CHI2, STUCK_LEFT, STUCK_LESS, STUCK_NOISE,
    WIRED_BESIDE, WIRED_NOISE,
};
use super::rows::{LeftOut, LogRows, Parked};
use super::wirings::{Wirings, evenly, scatter};
use super::{Finding, Kind, Look, On, Picture, Row, Views};
use crate::evaluate::Evaluator;
use crate::observations::postures::{range, rms};
use crate::tolerances::Tolerances;

/// Units in which people read joints, and how many of them are a rad or m.
pub(super) const UNITS: ((&str, f64), (&str, f64)) =
    (("°", 180.0 / std::f64::consts::PI), ("mm", 1e3));

/// Where readings have a joint whose encoder does not follow it.
#[derive(Debug, Clone, PartialEq)]
pub struct Stuck {
    /// Number of the joint.
    pub joint: usize,
    /// Posture by posture, rad or m: each is what explains one of its two readings.
    pub positions: Vec<f64>,
    /// Standard deviation that each reading gains without this encoder, m.
    pub less_known: Vec<f64>,
}

/// A joint that does not move in the log though the CoP says that it does. `gap`: χ² a reading of
/// the view of the log that is nearest to CAD.
pub(super) fn stuck(look: &Look, wirings: &Wirings, gap: f64) -> Option<(Finding, Stuck)> {
    let n = look.data.len();
    let gap = gap.min(look.chi2());
    // In logs that fit it is not looked for, which costs time.
    if gap < 1.5 || n < 3 {
        return None;
    }
    let joints = (0..look.model.dof()).filter(|&joint| is_still(look, joint));
    let moved = joints.map(|joint| Moved::of(look, joint));
    let best = moved
        .filter(|moved| moved.is_believable(look))
        .min_by(|a, b| a.left.total_cmp(&b.left))?;
    // One unknown a posture leaves one of two readings to the noise, which is no larger.
    let mut noise = 1.0;
    if !look.noise_is_known {
        noise = best.left.clamp(QUIETEST, 1.0);
    }
    let total = 2.0 * look.chi2();
    let shows = (STUCK_CHI2 * noise).max(STUCK_LESS * best.left);
    if gap < shows || best.left > (STUCK_LEFT * total).max(STUCK_NOISE * noise) {
        return None;
    }
    let least = best.left.max(noise);
    if is_wired_otherwise(look, wirings, noise, best.left)
        || one_number_explains(look, &best, least)
        || left_by_tolerances(look, noise).is_some_and(|left| left < BY_MASSES * least)
    {
        return None;
    }
    Some(Stuck::of(look, best, total))
}

/// What holds of a joint, of a pair for revolute and prismatic ones.
pub(super) fn of_joint<T>(dof: &Dof, (revolute, prismatic): (T, T)) -> T {
    if dof.prismatic { prismatic } else { revolute }
}

fn is_still(look: &Look, joint: usize) -> bool {
    let column = look.data.q.iter().skip(joint).step_by(look.model.dof());
    let (low, high) = range(column.copied());
    high - low < STILL
}

impl Stuck {
    /// The finding where `moved` explains what it leaves of a χ² of `total` a posture.
    fn of(look: &Look, moved: Moved, total: f64) -> (Finding, Stuck) {
        let (model, data) = (look.model, look.data);
        let (n, dof, joint) = (data.len(), model.dof(), moved.joint);
        let dof_of = &model.tree.dofs[joint];
        let anywhere = of_joint(dof_of, ANYWHERE);
        let position = |k: usize| data.q[k * dof + joint] + moved.far[k];
        let positions: Vec<f64> = (0..n).map(position).collect();
        let mut q = data.q.clone();
        let own = q.iter_mut().skip(joint).step_by(dof);
        own.zip(&positions).for_each(|(q, at)| *q = *at);
        let slopes = Evaluator::new(model, Function::ComJacobian).run(&q, n);
        let slope = |row: usize| slopes[(3 * (row / 2) + row % 2) * dof + joint];
        let less_known = (0..2 * n).map(|row| anywhere * slope(row).abs());
        let less_known = less_known.collect();
        let finding = Finding::new(
            Kind::EncoderStuck,
            &dof_of.joint,
            format!(
                "The encoder of {} does not move and the CoP does as if the joint did ({:.0} % \
                 of the gap): check its cable; readings count only for what its joint cannot \
                 move.",
                dof_of.joint,
                100.0 * (1.0 - moved.left / total)
            ),
        );
        let (unit, per_unit) = of_joint(dof_of, UNITS);
        let title = format!("{} as the CoP has it, {unit}", dof_of.joint);
        let row = |k: usize| Row::among(data, k);
        let picture = Picture::of(&title, n, row, |k| per_unit * positions[k], |_| true);
        let stuck = Stuck {
            joint,
            positions,
            less_known,
        };
        (finding.showing(picture), stuck)
    }
}

/// Whether a wiring explains the readings as well as motion of a joint does, which leaves
/// `left` a posture where the noise leaves `noise`.
fn is_wired_otherwise(look: &Look, wirings: &Wirings, noise: f64, left: f64) -> bool {
    let deviation = rms(look.std.iter().copied());
    let beside = WIRED_BESIDE * (left - noise).max(0.0);
    (wirings.left([0, 1]) / deviation).powi(2) < WIRED_NOISE * noise + beside
}

/// Whether one number for all postures explains the readings about as well as motion of a joint
/// does, which leaves `least` a posture or noise: an offset of it, or an offset or scale of
/// another joint. What is true of the joint itself is told by how far it would be off: where it
/// moves, an offset leaves that.
fn one_number_explains(look: &Look, best: &Moved, least: f64) -> bool {
    let (n, dof) = (look.data.len(), look.model.dof());
    let offset = vec![1.0; n];
    let enough =
        |joint: usize, by: &[f64]| Moved::together(look, joint, by).left < ONE_AS_WELL * least;
    if enough(best.joint, &offset) {
        return true;
    }
    let slopes = Evaluator::new(look.model, Function::ComJacobian).run(&look.data.q, n);
    (0..dof).filter(|other| *other != best.joint).any(|joint| {
        let scale: Vec<f64> = look
            .data
            .q
            .iter()
            .skip(joint)
            .step_by(dof)
            .copied()
            .collect();
        let steps = steps(look, joint, &look.predicted, &slopes);
        // One step tells which are worth a closer look.
        let near = |by: &[f64]| {
            let Step { along, size } = Step::sum(&steps, by);
            along * along / size.max(1e-30) > 0.9 * 2.0 * look.chi2() * n as f64
        };
        [&offset, &scale]
            .into_iter()
            .any(|by| near(by) && enough(joint, by))
    })
}

/// The postures with one joint moved to where the readings are explained best.
struct Moved {
    joint: usize,
    /// Posture by posture, rad or m.
    far: Vec<f64>,
    /// χ² a posture that is left.
    left: f64,
}

/// One posture's gradient along a joint, and its square, whitened.
struct Step {
    along: f64,
    size: f64,
}

impl Step {
    /// Gradient of postures that go `by` so far together, and its square.
    fn sum(steps: &[Step], by: &[f64]) -> Step {
        let zero = Step {
            along: 0.0,
            size: 0.0,
        };
        steps.iter().zip(by).fold(zero, |sum, (step, by)| Step {
            along: sum.along + by * step.along,
            size: sum.size + by * by * step.size,
        })
    }

    /// How far Gauss and Newton go, rad or m.
    fn length(&self) -> f64 {
        (self.along / self.size.max(1e-30)).clamp(-0.3, 0.3)
    }
}

impl Moved {
    /// One unknown a posture, by Gauss and Newton.
    fn of(look: &Look, joint: usize) -> Moved {
        Moved::by(look, joint, |steps, far| {
            for (step, far) in steps.iter().zip(far) {
                *far += step.length();
            }
        })
    }

    /// One unknown for all postures, of which each goes `by` so far.
    fn together(look: &Look, joint: usize, by: &[f64]) -> Moved {
        Moved::by(look, joint, |steps, far| {
            let length = Step::sum(steps, by).length();
            for (far, by) in far.iter_mut().zip(by) {
                *far += by * length;
            }
        })
    }

    /// Steps of Gauss and Newton: `step` adds to where the joint is in each posture what
    /// gradients along it say.
    fn by(look: &Look, joint: usize, step: impl Fn(&[Step], &mut [f64])) -> Moved {
        let (model, data) = (look.model, look.data);
        let (n, dof) = (data.len(), model.dof());
        let (cop, slopes) = (
            Evaluator::new(model, Function::Cop),
            Evaluator::new(model, Function::ComJacobian),
        );
        let mut q = data.q.clone();
        let mut far = vec![0.0; n];
        for _ in 0..8 {
            let steps = steps(look, joint, &cop.run(&q, n), &slopes.run(&q, n));
            step(&steps, &mut far);
            for k in 0..n {
                q[k * dof + joint] = data.q[k * dof + joint] + far[k];
            }
        }
        let at = cop.run(&q, n);
        let gap = |row: usize| (data.reading[row] - at[row]) / look.std[row];
        let left = (0..2 * n).map(|row| gap(row).powi(2)).sum::<f64>() / n as f64;
        Moved { joint, far, left }
    }

    /// Whether the joint moves, and can: where another effect is the cause, it would hardly have
    /// to move, or too far.
    fn is_believable(&self, look: &Look) -> bool {
        let (model, data) = (look.model, look.data);
        let dof_of = &model.tree.dofs[self.joint];
        let beyond = BEYOND_LIMITS * (dof_of.upper - dof_of.lower).max(1e-6);
        let within = |(k, far): (usize, &f64)| {
            let at = data.q[k * model.dof() + self.joint] + far;
            (dof_of.lower - beyond..=dof_of.upper + beyond).contains(&at)
        };
        let far = self.far.iter().enumerate();
        let inside = far.filter(|own| within(*own)).count();
        scatter(&self.far) > of_joint(dof_of, LEAST_MOTION)
            && inside as f64 >= NEARLY_ALL * self.far.len() as f64
    }
}

/// Gradients along a joint, posture by posture, where CAD has the CoP `at` with such `slopes`.
fn steps(look: &Look, joint: usize, at: &[f64], slopes: &[f64]) -> Vec<Step> {
    let dof = look.model.dof();
    let slope = |row: usize| slopes[(3 * (row / 2) + row % 2) * dof + joint] / look.std[row];
    let gap = |row: usize| (look.data.reading[row] - at[row]) / look.std[row];
    let pair = |of: &dyn Fn(usize) -> f64, k: usize| of(2 * k) + of(2 * k + 1);
    let step = |k| Step {
        along: pair(&|row| slope(row) * gap(row), k),
        size: pair(&|row| slope(row).powi(2), k),
    };
    (0..look.data.len()).map(step).collect()
}

/// What such masses leave of a reading, squared, in units of the look's deviations, the penalty
/// of the tolerances included; `noise`: variance of the noise in the same units.
pub(super) fn left_by_tolerances(look: &Look, noise: f64) -> Option<f64> {
    let (model, data) = (look.model, look.data);
    let (chosen, rows) = look.rows_of_masses(500);
    let tolerances = Tolerances::usual().factor(model);
    let reading = |row: usize| 2 * chosen[row / 2] + row % 2;
    let weight = |row: usize| 1.0 / (noise.sqrt() * look.std[reading(row)]);
    let gap = DVector::from_fn(rows.nrows(), |row, _| {
        (data.reading[reading(row)] - look.predicted[reading(row)]) * weight(row)
    });
    let mut free = rows * tolerances;
    for (row, mut columns) in free.row_iter_mut().enumerate() {
        columns *= weight(row);
    }
    let inner = free.tr_mul(&free) + DMatrix::identity(free.ncols(), free.ncols());
    let along = free.tr_mul(&gap);
    let explained = along.dot(&inner.cholesky()?.solve(&along));
    Some(noise * (gap.norm_squared() - explained) / gap.len() as f64)
}

/// The encoder that stops, if there is one; its rows are left out.
pub(super) fn parked(rows: &LogRows, on: On, left_out: &mut LeftOut) -> Option<Finding> {
    let kept = rows.kept(left_out);
    let dofs = &on.model.tree.dofs;
    let least = PARKED_ROWS.max((SOME_ROWS * kept.len() as f64).ceil() as usize);
    let moves = |joint: usize, among: &[usize]| {
        let (low, high) = range(among.iter().map(|k| rows.q(*k)[joint]));
        high - low > of_joint(&dofs[joint], LEAST_MOTION)
    };
    for (joint, dof) in dofs.iter().enumerate() {
        let run = longest(rows, &kept, joint);
        let others = [&kept[..run.start], &kept[run.end..]].concat();
        let run = &kept[run];
        let other_moves = |other: usize| other != joint && moves(other, run);
        if run.len() < least || !moves(joint, &others) || !(0..rows.dof).any(other_moves) {
            continue;
        }
        // Of the run and of the others, at most 500 rows are compared.
        let [run_views, other_views] = [run, &others[..]].map(|among| {
            let some = evenly(among.iter().copied(), 500);
            rows.views(&some, on.model)
        });
        let (read, still) = other_views;
        let gap_of_others = Views::of(on, &read, still.as_ref()).gap;
        let (read, still) = run_views;
        let views = Views::of(on, &read, still.as_ref());
        if views.gap < PARKED_WORSE * gap_of_others {
            continue;
        }
        if views.stuck().is_none_or(|(_, found)| found.joint != joint) {
            continue;
        }
        let at = rows.q(run[0])[joint];
        left_out.parked.push(Parked { joint, at });
        let parked = |k: usize| (rows.q(k)[joint] - at).abs() <= STILL;
        let count = (0..rows.len()).filter(|&k| parked(k)).count();
        let sentence = format!(
            "The encoder of {} stops in {} (the longest stretch is rows {} to {}) while other \
             joints and the CoP move as if the joint did: there CAD is {:.1} mm off, elsewhere \
             {:.1} mm. Rows with this position are left out; check its cable.",
            dof.joint,
            rows.some(count),
            rows.number[run[0]],
            rows.number[run[run.len() - 1]],
            1e3 * views.gap,
            1e3 * gap_of_others
        );
        let (unit, per_unit) = of_joint(dof, UNITS);
        let title = format!("{} by its encoder, {unit}", dof.joint);
        let about = (Kind::EncoderStuck, dof.joint.as_str(), sentence);
        let position = |k: usize| per_unit * rows.q(k)[joint];
        return Some(rows.finding(about, &title, position, parked));
    }
    None
}

/// The longest run among `kept` rows, by their places there, in which a joint does not move.
fn longest(rows: &LogRows, kept: &[usize], joint: usize) -> Range<usize> {
    let (mut longest, mut from) = (0..0, 0);
    for k in 0..kept.len() {
        if (rows.q(kept[k])[joint] - rows.q(kept[from])[joint]).abs() > STILL {
            from = k;
        }
        if k + 1 - from > longest.len() {
            longest = from..k + 1;
        }
    }
    longest
}
