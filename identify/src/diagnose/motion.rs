//! Readings of a robot that moves.
//!
//! ```text
//! y = sensor(CoP(φ) + Δ)        Δ = ZMP − static CoP, of CAD's masses at the joints that were read
//! ```
//!
//! Δ has no unknown: the URDF gives masses and inertias, the log accelerations. Masses that are
//! free move it by its rows, `∂Δ/∂r`, joints that stand elsewhere by its slopes, `∂Δ/∂q`, joints
//! that are late by its derivatives in time; loads of a hypothesis are accelerated with their
//! links. How much of Δ readings show is tested as a share against 1, once before anything is
//! explained (readings that show none are static), and once beside what was found. Readings that
//! need no explanation where they are static, and would need one in motion, are static, too.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use sesc_model::{Function, Model};

use super::criteria::{self, DELAY_S, OFFSET};
use super::nuisance::Nuisance;
use super::problem::{Fit, Problem, tilts};
use crate::evaluate::Evaluator;
use crate::fit::prior::{Prior, Tolerances};
use crate::observations::correlation::Correlation;
use crate::observations::motion_use::{Column, MotionModel, MotionUse, Share};
use crate::observations::noise::NoiseSource;
use crate::observations::postures::{Postures, rms};
use crate::observations::zmp::{Moved, Zmp};

/// Compare the readings of a log with the ZMP where it knows accelerations, and they show it.
pub(super) fn account(data: &mut Postures, model: &Model, prior: &Prior, asked: MotionModel) {
    let mut moving = data.clone();
    if let (MotionModel::Auto, Some(moved)) = (asked, known(&mut moving, model)) {
        let share = share_of_readings(&moving, model, prior, &moved);
        let is_used = !share.is_some_and(|share| share.is_missing())
            && !explains_more_than_motion(&moving, model, prior, &moved);
        data.motion_use = MotionUse {
            used: false,
            share,
            rows_left_out: 0,
            rms_m: rms(moved.shift.iter().flatten().copied()),
            ..data.motion_use.clone()
        };
        if is_used {
            *data = used(data, moving, moved);
        }
    }
    data.motion_use = std::mem::take(&mut data.motion_use).told();
}

/// Postures compared with the ZMP though their readings do not show it by the encoders: the joint
/// of one that is stuck may hide it. None where motion is not known, or is used.
pub(super) fn anyway(data: &Postures, model: &Model) -> Option<Postures> {
    let mut moving = data.clone();
    let moved = known(&mut moving, model).filter(|_| data.moved.is_none())?;
    let mut moving = used(data, moving, moved);
    moving.motion_use = std::mem::take(&mut moving.motion_use).told();
    Some(moving)
}

/// What motion adds to the readings of those postures whose motion is known, the others left out;
/// none where it adds nothing.
fn known(data: &mut Postures, model: &Model) -> Option<Moved> {
    data.motion.as_ref()?;
    data.leave_out_unknown();
    let moved = moved(data, model);
    let adds = moved.shift.iter().flatten().any(|by| *by != 0.0);
    (adds && data.len() > 2).then_some(moved)
}

/// Those of `all` postures whose motion is known, compared with the ZMP.
fn used(all: &Postures, mut known: Postures, moved: Moved) -> Postures {
    known.motion_use = MotionUse {
        used: true,
        rows_left_out: (all.len() - known.len()) as u64,
        ..all.motion_use.clone()
    };
    known.move_by(moved);
    known
}

/// What motion adds, where joints stand elsewhere than it was taken for.
pub(super) fn again(data: &mut Postures, model: &Model) {
    if let Some(known) = data.moved.take() {
        let mut moved = moved(data, model);
        moved.std.clone_from(&known.std);
        data.tell_moved(moved);
    }
}

/// Δ, and how it changes with positions of joints and with time.
fn moved(data: &Postures, model: &Model) -> Moved {
    let motion = data.motion.clone().unwrap_or_default();
    let (zmp, tilts) = (Zmp::new(model), tilts(data, model));
    let mut moved = zmp.moved(&data.q, &motion, 0..data.len(), &tilts);
    zmp.tell_changes(&mut moved, &data.q, &motion, &tilts);
    moved
}

/// The share that readings show, with masses within their prior and joints that stand
/// elsewhere than encoders say, or did so earlier.
fn share_of_readings(
    data: &Postures,
    model: &Model,
    prior: &Prior,
    moved: &Moved,
) -> Option<Share> {
    let (n, p) = (2 * data.len(), model.base.params.len());
    let residual = gaps(data, model, moved);
    let per_sample = rows_per_sample(data, &residual, 1 + p, |k, axis, c| match c {
        0 => moved.shift[k][axis],
        c => moved.rows[(2 * k + axis, c - 1)],
    });
    let masses = mass_errors(prior, model)?;
    let (m, dof) = (masses.ncols(), model.dof());
    let by_joints = Evaluator::new(model, Function::ComJacobian).run(&data.q, data.len());
    let by_joint = |row: usize, joint: usize| by_joints[(3 * (row / 2) + row % 2) * dof + joint];
    let rates = data.motion.as_ref().map_or(&[][..], |motion| &motion.rates);
    let by_delay = |row: usize| -> f64 {
        let own = rates.iter().skip(row / 2 * dof).take(dof).enumerate();
        let slope = |joint: usize| moved.slopes[row / 2 * dof + joint][row % 2];
        let by_positions = own.map(|(joint, rate)| rate * (by_joint(row, joint) + slope(joint)));
        let by_motion = moved
            .in_time
            .get(row / 2)
            .map_or(0.0, |own| own[0][row % 2]);
        by_positions.sum::<f64>() + by_motion
    };
    let rows = DMatrix::from_fn(n, p + dof + 1, |row, c| match c {
        c if c < p => moved.rows[(row, c)],
        c if c < p + dof => by_joint(row, c - p),
        _ => by_delay(row),
    });
    let unsure = DMatrix::from_fn(p + dof + 1, m + dof + 1, |r, c| match (r, c) {
        (r, c) if r < p && c < m => masses[(r, c)],
        (r, c) if r >= p && r - p + m == c => match r < p + dof {
            true => OFFSET,
            false => DELAY_S,
        },
        _ => 0.0,
    });
    let column = Column {
        shift: moved.shift.concat(),
        smooth: moved.smooth_shift.concat(),
        residual,
        rows,
        masses: p,
    };
    column.share(&unsure, per_sample)
}

/// What CAD in motion leaves of readings that were corrected for it, m.
fn gaps(data: &Postures, model: &Model, moved: &Moved) -> DVector<f64> {
    let predicted = moved.rows.times(&DVector::from_vec(model.cad_params()));
    let taken = moved.correction.iter().flatten().zip(&predicted);
    let gaps = data.reading.iter().zip(taken);
    let gaps = gaps.map(|(y, (by, predicted))| y - by - predicted);
    DVector::from_vec(gaps.collect())
}

/// Rows per independent one of what is left, of the axis that has fewer, beside a constant and so
/// many columns, of which `entry` has row, axis and number.
fn rows_per_sample(
    data: &Postures,
    left: &DVector<f64>,
    columns: usize,
    entry: impl Fn(usize, usize, usize) -> f64,
) -> f64 {
    let of_axis = |axis: usize| {
        let y = DVector::from_fn(data.len(), |k, _| left[2 * k + axis]);
        let x = DMatrix::from_fn(data.len(), 1 + columns, |k, c| match c {
            0 => 1.0,
            c => entry(k, axis, c - 1),
        });
        Some(Correlation::of(data.t.as_deref()?, &y, &x).rows_per_sample)
    };
    (0..2).filter_map(of_axis).fold(1.0, f64::max)
}

/// Factor of the covariance of mass errors: within the usual tolerances where a prior leaves
/// masses free.
fn mass_errors(prior: &Prior, model: &Model) -> Option<DMatrix<f64>> {
    let usual = || Prior::Cad(Tolerances::usual()).covariance_factor(model);
    prior.covariance_factor(model).or_else(usual)
}

/// Whether masses within their prior leave no more than noise where readings are static, and
/// clearly more where they are those of motion: then what motion adds is not in them, however
/// little an explanation of the difference would cost. Asked where the noise is known.
fn explains_more_than_motion(data: &Postures, model: &Model, prior: &Prior, moved: &Moved) -> bool {
    let stated = [
        NoiseSource::Given,
        NoiseSource::Stated,
        NoiseSource::Repeats,
    ];
    let masses = mass_errors(prior, model);
    let (Some(masses), true) = (masses, stated.contains(&data.noise_source)) else {
        return false;
    };
    let (n, gaps) = (2 * data.len(), gaps(data, model, moved));
    // As `Moved` corrects readings of motion; those of a robot that stands lack the shift.
    let left = |share: f64| -> (f64, f64) {
        let weight = |row: usize| {
            let by_motion = share * moved.std[row / 2][row % 2];
            1.0 / data.std[row].hypot(by_motion)
        };
        let y = DVector::from_fn(n, |row, _| {
            (gaps[row] + (1.0 - share) * moved.shift[row / 2][row % 2]) * weight(row)
        });
        let rows = DMatrix::from_fn(n, masses.nrows(), |row, c| {
            moved.rows[(row, c)] * weight(row)
        });
        let square = y.dot(&Nuisance::of(&rows * &masses).project_out_one(&y));
        (square, rows_per_sample(data, &y, 0, |_, _, _| 0.0))
    };
    let ((standing, per_sample), (moving, _)) = (left(0.0), left(1.0));
    let rows = n as f64;
    let noise = rows + criteria::NOISE_ALONE * (2.0 * rows * per_sample).sqrt();
    standing <= noise && (moving - standing) / per_sample > criteria::MOTION_COSTS
}

/// What is said of the motion in a log, once an explanation is found.
pub(super) fn said(problem: &Problem, fit: &Fit) -> MotionUse {
    let mut said = problem.data().motion_use.clone();
    if let Some(moved) = problem.data().moved.as_ref().filter(|_| said.used) {
        said.share = share_beside(problem, fit, moved).or(said.share);
    }
    said.told()
}

/// The share of Δ in what an explanation leaves, with masses and its effects free.
fn share_beside(problem: &Problem, fit: &Fit, moved: &Arc<Moved>) -> Option<Share> {
    let slopes = fit.slopes();
    let whitened = |shift: &Vec<[f64; 2]>| {
        let own = shift.iter().flatten().zip(&problem.first().weight);
        let mut all: Vec<f64> = own.map(|(by, weight)| by * weight).collect();
        all.resize(slopes.nrows(), 0.0);
        all
    };
    let shifts = [&moved.shift, &moved.smooth_shift].map(whitened);
    let masses = problem.masses(&fit.terms);
    let left = |x: &DMatrix<f64>| masses.project_out(x);
    Share::of(shifts, &slopes, &fit.residual(), left, 1.0)
}
