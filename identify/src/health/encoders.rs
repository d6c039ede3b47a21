//! Encoders that do not move though their joint does.
//!
//! ```text
//! y_k = p(q_k + δ_k e_j) + noise        one unknown δ_k a posture, for the joint j
//! ```
//!
//! A joint that really stands still is no finding: the readings must be explained by its
//! motion, within its limits, and by no wiring, offset or scale.

use sesc_model::Function;

use super::criteria::{
    ANYWHERE, AS_WELL, LEAST_MOTION, ONE_AS_WELL, SIMPLE_SHARE, STILL, STUCK_CHI2, STUCK_LEFT,
    STUCK_NOISE, STUCK_SHARE,
};
use super::statistics::scatter;
use super::wirings::Wirings;
use super::{Finding, Kind, Look, Picture, Row};
use crate::evaluate::Evaluator;
use crate::observations::postures::rms;

/// Rounds of the search for where the joint is, and its largest step, rad or m.
const ROUNDS: usize = 8;
const LARGEST_STEP: f64 = 0.3;

/// A stuck encoder.
pub(super) struct Stuck {
    pub finding: Finding,
    /// Standard deviation that each reading gains without this encoder, m.
    pub less_known: Vec<f64>,
    pub joint: usize,
    /// Where readings have the joint, posture by posture, rad or m.
    pub positions: Vec<f64>,
}

/// A joint that does not move in the log though the CoP says that it does.
pub(super) fn stuck(look: &Look, wirings: &Wirings) -> Option<Stuck> {
    let (model, data, predicted) = (look.model, look.data, &look.predicted);
    let (n, dof) = (data.len(), model.dof());
    let whitened = |row: usize| (data.reading[row] - predicted[row]) / look.std[row];
    let total: f64 = (0..2 * n).map(|row| whitened(row).powi(2)).sum();
    if total < STUCK_CHI2 * (2 * n) as f64 || n < 3 {
        return None;
    }
    let still = |joint: &usize| {
        let column = (0..n).map(|k| data.q[k * dof + joint]);
        let (low, high) = column.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
            (a.min(x), b.max(x))
        });
        high - low < STILL
    };
    // Where another effect is the cause, the joint would hardly have to move, or too far.
    let believable = |moved: &Moved| {
        let dof_of = &model.tree.dofs[moved.joint];
        let range = (dof_of.upper - dof_of.lower).max(1e-6);
        let within = |k: &usize| {
            let at = data.q[k * dof + moved.joint] + moved.far[*k];
            (dof_of.lower - 0.1 * range..=dof_of.upper + 0.1 * range).contains(&at)
        };
        let inside = (0..n).filter(within).count();
        let least = if dof_of.prismatic {
            LEAST_MOTION.1
        } else {
            LEAST_MOTION.0
        };
        scatter(&moved.far) > least && inside as f64 >= STUCK_SHARE * n as f64
    };
    let joints = (0..dof).filter(still);
    let moved = joints.map(|joint| Moved::of(look, joint));
    let best = moved
        .filter(believable)
        .min_by(|a, b| a.left.total_cmp(&b.left))?;
    let least_left = (STUCK_LEFT * total).max(STUCK_NOISE * n as f64);
    if best.left > least_left {
        return None;
    }
    if is_wired_otherwise(look, wirings, best.left) {
        return None;
    }
    let (joint, most) = (best.joint, total - best.left);
    let by = Evaluator::new(model, Function::ComJacobian);
    let slopes = by.run(&data.q, n);
    let slope = |k: usize, axis: usize, joint: usize| slopes[(3 * k + axis) * dof + joint];
    // One offset or scale for all postures is simpler than one unknown for each. What is true of
    // the joint itself is told by how far it would be off: where it moves, an offset leaves that.
    let one = Moved::together(look, joint).left;
    if one < ONE_AS_WELL * best.left.max(n as f64) {
        return None;
    }
    let by_one = |joint: usize, scale: bool| {
        let column = |row: usize| {
            let by = if scale {
                data.q[row / 2 * dof + joint]
            } else {
                1.0
            };
            by * slope(row / 2, row % 2, joint) / look.std[row]
        };
        let along: f64 = (0..2 * n).map(|row| column(row) * whitened(row)).sum();
        let size: f64 = (0..2 * n).map(|row| column(row).powi(2)).sum();
        along * along / size.max(1e-30)
    };
    let others = (0..dof).filter(|other| *other != joint);
    let simple = others.flat_map(|joint| [by_one(joint, false), by_one(joint, true)]);
    if simple.fold(0.0, f64::max) > SIMPLE_SHARE * total {
        return None;
    }
    let dof_of = &model.tree.dofs[joint];
    let anywhere = if dof_of.prismatic {
        ANYWHERE.1
    } else {
        ANYWHERE.0
    };
    let position = |k: usize| data.q[k * dof + joint] + best.far[k];
    let positions: Vec<f64> = (0..n).map(position).collect();
    let mut moved = data.q.clone();
    let own = moved.iter_mut().skip(joint).step_by(dof);
    own.zip(&positions).for_each(|(q, at)| *q = *at);
    let slopes = by.run(&moved, n);
    let slope = |row: usize| slopes[(3 * (row / 2) + row % 2) * dof + joint];
    let less_known = (0..2 * n).map(|row| anywhere * slope(row).abs());
    let less_known = less_known.collect();
    let finding = Finding::new(
        Kind::EncoderStuck,
        &dof_of.joint,
        format!(
            "The encoder of {} does not move and the CoP does as if the joint did ({:.0} % of \
             the gap): check its cable; readings count only for what its joint cannot move.",
            dof_of.joint,
            100.0 * most / total
        ),
    );
    let unit = if dof_of.prismatic {
        ("mm", 1e3)
    } else {
        ("°", 1f64.to_degrees())
    };
    let title = format!("{} as the CoP has it, {}", dof_of.joint, unit.0);
    let row = |k: usize| Row::among(data, k);
    let picture = Picture::of(&title, n, row, |k| unit.1 * positions[k], |_| true);
    Some(Stuck {
        finding: finding.showing(picture),
        less_known,
        joint,
        positions,
    })
}

/// Whether a wiring explains the readings as well as motion of the joint does, which leaves
/// χ² of `left`, or all but noise.
fn is_wired_otherwise(look: &Look, wirings: &Wirings, left: f64) -> bool {
    let noise = rms(look.std.iter().copied());
    let beside = (left / look.data.len() as f64).max(1.0).sqrt();
    wirings.left([0, 1]) < AS_WELL * noise * beside
}

/// The postures with one joint moved to where the readings are explained best.
struct Moved {
    joint: usize,
    /// Posture by posture, rad or m.
    far: Vec<f64>,
    /// χ² that is left.
    left: f64,
}

impl Moved {
    /// One unknown a posture, by Gauss and Newton.
    fn of(look: &Look, joint: usize) -> Moved {
        Moved::by(look, joint, |along, size, far| {
            for ((along, size), far) in along.iter().zip(size).zip(far) {
                *far += (along / size.max(1e-30)).clamp(-LARGEST_STEP, LARGEST_STEP);
            }
        })
    }

    /// One unknown for all postures.
    fn together(look: &Look, joint: usize) -> Moved {
        Moved::by(look, joint, |along, size, far| {
            let step = along.iter().sum::<f64>() / size.iter().sum::<f64>().max(1e-30);
            let step = step.clamp(-LARGEST_STEP, LARGEST_STEP);
            far.iter_mut().for_each(|far| *far += step);
        })
    }

    /// Steps of Gauss and Newton: `step` adds to where the joint is in each posture what
    /// gradients along it over their squares say.
    fn by(look: &Look, joint: usize, step: impl Fn(&[f64], &[f64], &mut [f64])) -> Moved {
        let (model, data) = (look.model, look.data);
        let (n, dof) = (data.len(), model.dof());
        let (cop, slopes) = (
            Evaluator::new(model, Function::Cop),
            Evaluator::new(model, Function::ComJacobian),
        );
        let mut q = data.q.clone();
        let mut far = vec![0.0; n];
        let mut left = f64::INFINITY;
        for round in 0..=ROUNDS {
            let (at, by) = (cop.run(&q, n), slopes.run(&q, n));
            let gap = |row: usize| (data.reading[row] - at[row]) / look.std[row];
            left = (0..2 * n).map(|row| gap(row).powi(2)).sum();
            if round == ROUNDS {
                break;
            }
            let slope = |row: usize| by[(3 * (row / 2) + row % 2) * dof + joint] / look.std[row];
            let pair = |of: &dyn Fn(usize) -> f64, k: usize| of(2 * k) + of(2 * k + 1);
            let along = |k| pair(&|row| slope(row) * gap(row), k);
            let size = |k| pair(&|row| slope(row) * slope(row), k);
            let along: Vec<f64> = (0..n).map(along).collect();
            let size: Vec<f64> = (0..n).map(size).collect();
            step(&along, &size, &mut far);
            for k in 0..n {
                q[k * dof + joint] = data.q[k * dof + joint] + far[k];
            }
        }
        Moved { joint, far, left }
    }
}
