//! On which side of its dead band each joint rests, posture by posture.
//!
//! Gravity decides: `sign τ_j` with every other joint where it rests. A joint
//! that carries the robot is an inverted pendulum: near zero moment both sides
//! hold, and the reading decides which, at a penalty.

use std::borrow::Cow;

use sesc_model::effects::{PostureContext, ROUNDS};

use super::{Block, Problem, side, stacked_residual};
use crate::diagnose::criteria;
use crate::diagnose::hypothesis::{CarriedExplanation, Term};

/// Sides of a block, written into its posture context, with the penalty of the unlikely ones.
pub(crate) struct Sides {
    pub posture_context: Vec<f64>,
    pub penalty: f64,
    /// Postures with a joint on its unlikely side.
    pub flipped: Vec<usize>,
}

/// The side of every slack joint in every posture of each block: gravity's, and where that is
/// nearly even and the unknowns are `fitted`, the reading's.
pub(crate) fn settle(
    problem: &Problem,
    terms: &[Term],
    unknowns: &[f64],
    fitted: bool,
) -> Vec<Sides> {
    let blocks = problem.blocks.iter();
    let blocks = blocks.map(|block| (block, problem.carried(block, terms, unknowns)));
    let blocks: Vec<(&Block, CarriedExplanation)> = blocks.collect();
    let resting = blocks.iter().map(|(block, own)| by_gravity(block, own));
    let (mut sides, moments): (Vec<Sides>, Vec<Vec<f64>>) = resting.unzip();
    if fitted {
        let contexts = sides.iter().map(|own| own.posture_context[..].into());
        let contexts: Vec<Cow<[f64]>> = contexts.collect();
        let predicted = problem.predict(terms, unknowns, &contexts, None);
        let residual = stacked_residual(&predicted);
        let unexplained = problem.masses(terms).project_out_one(&residual);
        let own = sides.iter_mut().zip(&blocks).zip(&moments);
        let own = own.zip(problem.readings());
        for (((sides, (block, own)), moments), range) in own {
            let unexplained = &unexplained.as_slice()[range];
            by_reading(block, own, moments, unexplained, sides);
        }
    }
    sides
}

/// The sides that gravity decides, and the moments there.
fn by_gravity(block: &Block, own: &CarriedExplanation) -> (Sides, Vec<f64>) {
    let joints = block.slack_joints(&own.terms);
    let joints = || joints.iter().map(|(joint, _)| *joint);
    let mut posture_context = block.data.posture_context.clone();
    let mut moments = Vec::new();
    if joints().len() > 0 {
        let dof = block.context.robot.dof();
        // From the middle of every band, all at once, as in `Measured::bend`.
        block.put_sides(&mut posture_context, joints(), |_, _, _| 0.0);
        for _ in 0..ROUNDS {
            let q = &block.data.q;
            moments = block.evaluate_moments(&own.terms, &own.unknowns, q, &posture_context);
            block.put_sides(&mut posture_context, joints(), |k, joint, before| {
                before + side(moments[k * 3 * dof + joint]) / ROUNDS as f64
            });
        }
    }
    let sides = Sides {
        posture_context,
        penalty: 0.0,
        flipped: Vec::new(),
    };
    (sides, moments)
}

/// Put joints that may rest on either side where the reading has them.
fn by_reading(
    block: &Block,
    CarriedExplanation {
        terms, unknowns, ..
    }: &CarriedExplanation,
    moments: &[f64],
    unexplained: &[f64],
    sides: &mut Sides,
) {
    let layout = PostureContext::of(block.context.robot);
    let joints = block.slack_joints(terms);
    let dof = block.context.robot.dof();
    for (k, own) in moments.chunks_exact(3 * dof).enumerate() {
        let near = bistable(block, own, unknowns, &joints, k);
        if near.is_empty() {
            continue;
        }
        let own = &mut sides.posture_context[k * layout.len()..];
        let left = [unexplained[2 * k], unexplained[2 * k + 1]];
        let (flips, cost) = best_flips(left, &near, |joint| own[layout.side(joint)]);
        sides.penalty += cost;
        if !flips.is_empty() {
            sides.flipped.push(k);
        }
        for joint in flips {
            own[layout.side(joint)] *= -1.0;
        }
    }
}

/// A joint that may rest on either side: what moving there does to the reading.
struct Near {
    joint: usize,
    /// Whitened change of the reading by half a width.
    half: [f64; 2],
    /// How far from even the odds are, 0 to 1.
    certainty: f64,
}

fn bistable(
    block: &Block,
    moments: &[f64],
    unknowns: &[f64],
    joints: &[(usize, usize)],
    k: usize,
) -> Vec<Near> {
    let dof = block.context.robot.dof();
    let mut near: Vec<Near> = Vec::new();
    for &(joint, at) in joints {
        let half = 0.5 * unknowns[at].abs();
        let slope = [moments[dof + joint], moments[2 * dof + joint]];
        let lever = slope[0].hypot(slope[1]);
        let change = [0, 1].map(|axis| half * slope[axis] * block.weight[2 * k + axis]);
        let reach = half * lever + criteria::MOMENT_ERROR_M;
        let certainty = moments[joint].abs() / reach;
        if 2.0 * change[0].hypot(change[1]) > criteria::SIDE_MATTERS
            && certainty < criteria::MOMENT_CERTAIN
        {
            near.push(Near {
                joint,
                half: change,
                certainty: certainty / criteria::MOMENT_CERTAIN,
            });
        }
    }
    let reach = |near: &Near| near.half[0].hypot(near.half[1]);
    near.sort_by(|a, b| reach(b).total_cmp(&reach(a)));
    near.truncate(criteria::SIDE_JOINTS);
    near
}

/// The joints to put on their other side, and what that costs.
fn best_flips(residual: [f64; 2], near: &[Near], side: impl Fn(usize) -> f64) -> (Vec<usize>, f64) {
    let mut best = (0, 0.0, residual[0].powi(2) + residual[1].powi(2));
    for choice in 1..1_usize << near.len() {
        let (mut left, mut cost) = (residual, 0.0);
        for (bit, joint) in near.iter().enumerate() {
            if choice >> bit & 1 == 1 {
                for (left, half) in left.iter_mut().zip(joint.half) {
                    *left += 2.0 * side(joint.joint) * half;
                }
                cost += criteria::SIDE_SCORE * (criteria::SIDE_EVEN + joint.certainty);
            }
        }
        let total = left[0].powi(2) + left[1].powi(2) + cost;
        if total < best.2 {
            best = (choice, cost, total);
        }
    }
    let flips = near.iter().enumerate();
    let flips = flips.filter(|(bit, _)| best.0 >> bit & 1 == 1);
    (flips.map(|(_, joint)| joint.joint).collect(), best.1)
}
