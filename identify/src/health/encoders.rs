//! Encoders that do not move though their joint does.
//!
//! ```text
//! y_k = p(q_k + δ_k e_j) + noise        one unknown δ_k a posture, for the joint j
//! ```
//!
//! A joint that really stands still is no finding: the readings must be explained by its
//! motion, within its limits, and by no wiring, offset or scale, nor by masses within the usual
//! tolerances of CAD.

use sesc_model::Function;
use sesc_model::tree::Dof;

use super::criteria::{
    ANYWHERE, BEYOND_LIMITS, BY_MASSES, LEAST_MOTION, ONE_AS_WELL, QUIETEST, SIMPLE_SHARE, STILL,
    STUCK_CHI2, STUCK_LEFT, STUCK_LESS, STUCK_LOOKS, STUCK_NOISE, STUCK_SHARE, WIRED_BESIDE,
    WIRED_NOISE,
};
use super::statistics::scatter;
use super::wirings::Wirings;
use super::{Finding, Kind, Look, Picture, Row, masses};
use crate::evaluate::Evaluator;
use crate::observations::postures::{range, rms};

/// Units in which people read joints, and how many of them are a rad or m.
pub(super) const UNITS: ((&str, f64), (&str, f64)) =
    (("°", 180.0 / std::f64::consts::PI), ("mm", 1e3));
/// Rounds of the search for where the joint is, and its largest step, rad or m.
const ROUNDS: usize = 8;
const LARGEST_STEP: f64 = 0.3;

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
    if gap < STUCK_LOOKS || n < 3 {
        return None;
    }
    let joints = (0..look.model.dof()).filter(|&joint| is_still(look, joint));
    let moved = joints.map(|joint| Moved::of(look, joint));
    let best = moved
        .filter(|moved| moved.is_believable(look))
        .min_by(|a, b| a.left.total_cmp(&b.left))?;
    // One unknown a posture leaves one of two readings to the noise, which is no larger.
    let noise = match look.noise_is_known {
        true => 1.0,
        false => best.left.clamp(QUIETEST, 1.0),
    };
    let total = 2.0 * look.chi2();
    let shows = (STUCK_CHI2 * noise).max(STUCK_LESS * best.left);
    if gap < shows || best.left > (STUCK_LEFT * total).max(STUCK_NOISE * noise) {
        return None;
    }
    let least = best.left.max(noise);
    if is_wired_otherwise(look, wirings, noise, best.left)
        || one_number_explains(look, &best, least)
        || masses::left(look, noise).is_some_and(|left| left < BY_MASSES * least)
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
    let enough = |moved: &Moved| moved.left < ONE_AS_WELL * least;
    if enough(&Moved::together(look, best.joint, Together::Offset)) {
        return true;
    }
    let others = (0..look.model.dof()).filter(|other| *other != best.joint);
    let simple = others.flat_map(|joint| [(joint, Together::Offset), (joint, Together::Scale)]);
    let n = look.data.len();
    let slopes = Evaluator::new(look.model, Function::ComJacobian).run(&look.data.q, n);
    // One step tells which are worth more.
    let mut near = simple.filter(|(joint, how)| {
        let steps = steps(look, *joint, &look.predicted, &slopes);
        let (along, size) = how.sums(look, *joint, &steps);
        along * along / size.max(1e-30) > SIMPLE_SHARE * 2.0 * look.chi2() * n as f64
    });
    near.any(|(joint, how)| enough(&Moved::together(look, joint, how)))
}

/// One number for all postures.
#[derive(Clone, Copy)]
enum Together {
    Offset,
    Scale,
}

impl Together {
    /// How far a posture's joint goes by one unit.
    fn weight(self, look: &Look, joint: usize, k: usize) -> f64 {
        match self {
            Together::Offset => 1.0,
            Together::Scale => look.data.q[k * look.model.dof() + joint],
        }
    }

    /// Gradient along the number, and its square.
    fn sums(self, look: &Look, joint: usize, steps: &[Step]) -> (f64, f64) {
        let own = steps.iter().enumerate();
        own.fold((0.0, 0.0), |(along, size), (k, step)| {
            let weight = self.weight(look, joint, k);
            (
                along + weight * step.along,
                size + weight * weight * step.size,
            )
        })
    }
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

impl Moved {
    /// One unknown a posture, by Gauss and Newton.
    fn of(look: &Look, joint: usize) -> Moved {
        Moved::by(look, joint, |steps, far| {
            for (step, far) in steps.iter().zip(far) {
                let by = step.along / step.size.max(1e-30);
                *far += by.clamp(-LARGEST_STEP, LARGEST_STEP);
            }
        })
    }

    /// One unknown for all postures.
    fn together(look: &Look, joint: usize, how: Together) -> Moved {
        Moved::by(look, joint, |steps, far| {
            let (along, size) = how.sums(look, joint, steps);
            let by = (along / size.max(1e-30)).clamp(-LARGEST_STEP, LARGEST_STEP);
            for (k, far) in far.iter_mut().enumerate() {
                *far += how.weight(look, joint, k) * by;
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
        for _ in 0..ROUNDS {
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
            && inside as f64 >= STUCK_SHARE * self.far.len() as f64
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
