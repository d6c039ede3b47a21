//! Encoders that do not move though their joint does.
//!
//! ```text
//! y_k = p(q_k + δ_k e_j) + noise        one unknown δ_k a posture, for the joint j
//! ```
//!
//! A joint that really stands still is no finding: the readings must be explained by its motion,
//! within its limits, and by nothing that is known ([`super::hypotheses`]).
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

use sesc_model::tree::Dof;
use sesc_model::{Function, Model};

use super::criteria::{
    ANYWHERE, BEYOND_LIMITS, BY_CHANCE, CAD, LEAST_MOTION, MORE, NEARLY_ALL, NUMBER, PARKED_ROWS,
    SOME_ROWS, STILL, UNKNOWN_NOISE, WIRING,
};
use super::hypotheses::{by_sensor, left_by_masses, limit, no_wiring_leaves};
use super::rows::{LeftOut, LogRows};
use super::view::{On, View, column, evenly, scatter, span};
use super::{Finding, Kind, Picture};
use crate::evaluate::Evaluator;

/// Units in which people read joints, and how many of them are a rad or m.
const UNITS: ((&str, f64), (&str, f64)) = (("°", 180.0 / std::f64::consts::PI), ("mm", 1e3));

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

/// What holds of a joint, of a pair for revolute and prismatic ones.
pub(super) fn of_joint<T>(dof: &Dof, (revolute, prismatic): (T, T)) -> T {
    if dof.prismatic { prismatic } else { revolute }
}

/// A joint that does not move in the log though the CoP says that it does; in the first of the
/// views, which is nearest to CAD, or in the other, which must explain what the first one leaves.
pub(super) fn stuck(views: &[&View]) -> Option<(Finding, Stuck)> {
    let gap = views[0].chi2(&views[0].cad);
    // In logs that fit it is not looked for, which costs time.
    let enough = |view: &&&View| gap >= BY_CHANCE && view.len() >= 3;
    views
        .iter()
        .filter(enough)
        .find_map(|view| stuck_in(view, gap))
}

fn stuck_in(view: &View, gap: f64) -> Option<(Finding, Stuck)> {
    let model = view.on.model;
    let by_joints = by_joints(model);
    let joints = (0..model.dof()).filter(|&joint| span(view.joint(joint).into_iter()) < STILL);
    let moved = joints.map(|joint| (joint, explaining(view, &by_joints, joint, None)));
    let believable = moved.filter(|(joint, (far, _))| is_believable(view, *joint, far));
    let (joint, (far, left)) = believable.min_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
    // One unknown a posture leaves one of two readings to the noise, which is no larger.
    let mut noise = 1.0;
    if view.data.std.iter().any(|std| std.is_nan()) {
        noise = left.clamp(UNKNOWN_NOISE.0, UNKNOWN_NOISE.1);
    }
    let few = view.few();
    let beyond = |cost: f64| limit(cost, left, noise);
    let is_found = gap > beyond(CAD)
        && no_wiring_leaves(&few, by_sensor(&few), beyond(WIRING))
        && no_number_leaves(&few, beyond(NUMBER))
        && left_by_masses(&few, &few.reading, noise).is_none_or(|left| left > beyond(BY_CHANCE));
    is_found.then(|| found(view, joint, &far, left))
}

/// The finding where motion of a joint that is `far` from where its encoder says explains the
/// readings.
fn found(view: &View, joint: usize, far: &[f64], left: f64) -> (Finding, Stuck) {
    let (n, model) = (view.len(), view.on.model);
    let (dof, own) = (model.dof(), &model.tree.dofs[joint]);
    let mut q = view.data.q.clone();
    for (k, far) in far.iter().enumerate() {
        q[k * dof + joint] += far;
    }
    let positions = column(&q, dof, joint);
    let slopes = Evaluator::new(model, Function::ComJacobian).run(&q, n);
    let slope = |row: usize| slopes[(3 * (row / 2) + row % 2) * dof + joint];
    let anywhere = of_joint(own, ANYWHERE);
    let name = &own.joint;
    let sentence = format!(
        "The encoder of {name} does not move and the CoP does as if the joint did ({:.0} % of the \
         gap): check its cable; readings count only for what its joint cannot move.",
        100.0 * (1.0 - 0.5 * left / view.chi2(&view.cad))
    );
    let (unit, per_unit) = of_joint(own, UNITS);
    let title = format!("{name} as the CoP has it, {unit}");
    let value = |k: usize| vec![(per_unit * positions[k], true)];
    let picture = Picture::new(&title, n, |k| view.row(k), value);
    let finding = Finding::new(Kind::EncoderStuck, name, sentence).showing(picture);
    let stuck = Stuck {
        joint,
        less_known: (0..2 * n).map(|row| anywhere * slope(row).abs()).collect(),
        positions,
    };
    (finding, stuck)
}

/// Whether no offset and no scale of any joint explains the readings.
fn no_number_leaves(view: &View, limit: f64) -> bool {
    let by_joints = by_joints(view.on.model);
    let offset = vec![1.0; view.len()];
    (0..view.on.model.dof()).all(|joint| {
        let leaves = |by: &Vec<f64>| explaining(view, &by_joints, joint, Some(by)).1;
        leaves(&offset) > 2.0 * limit && leaves(&view.joint(joint)) > 2.0 * limit
    })
}

/// Whether a joint that is so far from where its encoder says moves, and can: where another effect
/// is the cause, it would hardly have to move, or too far.
fn is_believable(view: &View, joint: usize, far: &[f64]) -> bool {
    let dof = &view.on.model.tree.dofs[joint];
    let beyond = BEYOND_LIMITS * (dof.upper - dof.lower).max(1e-6);
    let within = dof.lower - beyond..=dof.upper + beyond;
    let at = view.joint(joint).into_iter().zip(far);
    let inside = at.filter(|(q, far)| within.contains(&(q + *far))).count();
    scatter(far) > of_joint(dof, LEAST_MOTION) && inside as f64 >= NEARLY_ALL * far.len() as f64
}

/// CoP, and the CoM's slopes by joints.
fn by_joints(model: &Model) -> [Evaluator; 2] {
    [Function::Cop, Function::ComJacobian].map(|function| Evaluator::new(model, function))
}

/// How far a joint is from where its encoder says in each posture, rad or m, and what is left
/// of χ² a posture; by Gauss and Newton with one unknown a posture, or one for all, of which
/// each goes `by` so far.
fn explaining(
    view: &View,
    [cop_of, slopes_of]: &[Evaluator; 2],
    joint: usize,
    by: Option<&Vec<f64>>,
) -> (Vec<f64>, f64) {
    let (n, dof) = (view.len(), view.on.model.dof());
    let mut q = view.data.q.clone();
    let mut far = vec![0.0; n];
    let gap = |cop: &[f64], row: usize| {
        let (k, axis) = (row / 2, row % 2);
        (view.reading[axis][k] - cop[row]) / view.std[axis][k]
    };
    for _ in 0..8 {
        let (cop, slopes) = (cop_of.run(&q, n), slopes_of.run(&q, n));
        let slope = |row: usize| {
            slopes[(3 * (row / 2) + row % 2) * dof + joint] / view.std[row % 2][row / 2]
        };
        // A posture's gradient, and its square.
        let step = |k: usize| {
            let [x, y] = [2 * k, 2 * k + 1];
            let along = slope(x) * gap(&cop, x) + slope(y) * gap(&cop, y);
            (along, slope(x).powi(2) + slope(y).powi(2))
        };
        let length = |(along, size): (f64, f64)| (along / size.max(1e-30)).clamp(-0.3, 0.3);
        let steps: Vec<(f64, f64)> = (0..n).map(step).collect();
        let shared = by.map(|by| {
            let steps = steps.iter().zip(by);
            let sum = steps.fold((0.0, 0.0), |(along, size), (step, by)| {
                (along + by * step.0, size + by * by * step.1)
            });
            (by, length(sum))
        });
        for (k, far) in far.iter_mut().enumerate() {
            *far += shared.map_or_else(|| length(steps[k]), |(by, length)| by[k] * length);
            q[k * dof + joint] = view.data.q[k * dof + joint] + *far;
        }
    }
    let cop = cop_of.run(&q, n);
    let left = (0..2 * n).map(|row| gap(&cop, row).powi(2)).sum::<f64>() / n as f64;
    (far, left)
}

/// The encoder that stops, if there is one; its rows are left out.
pub(super) fn parked(rows: &LogRows, on: On, left_out: &mut LeftOut) -> Option<Finding> {
    let kept = rows.kept(left_out);
    let least = PARKED_ROWS.max((SOME_ROWS * kept.len() as f64).ceil() as usize);
    let moves = |joint: usize, among: &[usize]| {
        let least = of_joint(&on.model.tree.dofs[joint], LEAST_MOTION);
        span(among.iter().map(|k| rows.q(*k)[joint])) > least
    };
    for (joint, dof) in on.model.tree.dofs.iter().enumerate() {
        let run = longest(rows, &kept, joint);
        let others = [&kept[..run.start], &kept[run.end..]].concat();
        let run = &kept[run];
        let other_moves = |other: usize| other != joint && moves(other, run);
        if run.len() < least || !moves(joint, &others) || !(0..rows.dof).any(other_moves) {
            continue;
        }
        // Of the run and of the others, at most 500 rows are compared.
        let [run_views, other_views] =
            [run, &others].map(|among| rows.views(&evenly(among.iter().copied(), 500), on));
        let run_views = nearest_first(&run_views);
        let [off, off_elsewhere] =
            [run_views[0], nearest_first(&other_views)[0]].map(|view| view.gap(&view.cad));
        let worse = off.powi(2) > MORE * off_elsewhere.powi(2);
        if !worse || stuck(&run_views).is_none_or(|(_, found)| found.joint != joint) {
            continue;
        }
        let at = rows.q(run[0])[joint];
        left_out.parked.push((joint, at));
        let parked = |k: usize| (rows.q(k)[joint] - at).abs() <= STILL;
        let sentence = format!(
            "The encoder of {} stops in {} (the longest stretch is rows {} to {}) while other \
             joints and the CoP move as if the joint did: there CAD is {:.1} mm off, elsewhere \
             {:.1} mm. Rows with this position are left out; check its cable.",
            dof.joint,
            rows.some((0..rows.len()).filter(|&k| parked(k)).count()),
            rows.number(run[0]),
            rows.number(run[run.len() - 1]),
            1e3 * off,
            1e3 * off_elsewhere
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

/// Views in the order of their distances from CAD.
pub(super) fn nearest_first<'v, 'a>(views: &'v [View<'a>]) -> Vec<&'v View<'a>> {
    let mut sorted: Vec<&View> = views.iter().collect();
    sorted.sort_by(|a, b| a.gap(&a.cad).total_cmp(&b.gap(&b.cad)));
    sorted
}
