//! Generated functions against the independent reference.
//!
//! The program that becomes Rust runs on tape; the reference sums `m_i T_i c_i`
//! from its own reading of the URDF. Allowed difference: twice the proven
//! rounding bound (the reference rounds too) and what snapped right angles move.
//!
//! A model with effects is compared with the virtual robot of the reference, which has
//! them (`world`).

mod compare;
mod functions;
mod motion;
mod world;

use std::collections::BTreeMap;

use serde::Serialize;
use sesc_model::{Function, Model};
use sesc_reference::Reference;

use crate::Error;
use compare::{Compared, blocks};
use functions::functions;
pub use functions::{UNPROVEN_OF_REACH, USEFUL, allowed};
pub use motion::JointMotion;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_identify::threads::each;
use sesc_identify::{Watch, tell};
use world::Bent;
pub use world::with_effect;

/// Joint angles that [`samples`] draws, in postures that the limits below hold.
const DRAWN: usize = 1_000_000;
/// Postures of a robot of 100 joints or fewer.
const MOST_SAMPLES: usize = 10_000;
/// Postures of a robot of any size.
const LEAST_SAMPLES: usize = 1_000;
/// Blocks after which it is told how far the comparison is.
const BLOCKS: usize = 8;

/// What the comparison found.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Verification {
    /// Whether all differences are allowed.
    pub pass: bool,
    /// Postures compared; random ones and corners of the limits.
    pub samples: usize,
    /// Postures left out, where a joint may rest on either side of its dead band or the CoP is off
    /// the cells.
    pub undecided: usize,
    /// What rounds of springs leave out, m; measured within what is proven, proven beside dead
    /// bands; part of every bound.
    pub springs_left_out: f64,
    /// Largest difference per function; in its unit, regressor rows by the CoM they give, m.
    pub worst_error: BTreeMap<String, f64>,
    /// Allowed difference: rounding, snapping, springs.
    pub bound: BTreeMap<String, f64>,
    /// Functions whose bound verifies nothing; they have to agree to a billionth of the robot's
    /// reach ([`UNPROVEN_OF_REACH`]).
    pub beyond_use: Vec<String>,
    /// Widest useful bound without springs, m; a thousandth of the robot's reach ([`USEFUL`]).
    pub widest_of_use: f64,
    /// Those units; m of regressor rows.
    #[serde(skip)]
    pub units: BTreeMap<String, &'static str>,
}

/// The independent reference of `robot` on the support of `model`; it reads the URDF by itself.
///
/// # Errors
/// When the reference cannot read the URDF, or has no such link.
pub fn reference(robot: &Robot, model: &Model) -> Result<Reference, Error> {
    let support = &model.tree.links[model.tree.support].name;
    Ok(Reference::new(&read(robot, model)?, support)?)
}

/// The robot as the reference reads it, with the joints of the model: those of a virtual base are
/// held.
fn read(robot: &Robot, model: &Model) -> Result<sesc_reference::Robot, Error> {
    let joints: Vec<&str> = model.tree.dofs.iter().map(|dof| &*dof.joint).collect();
    Ok(sesc_reference::Robot::from_urdf(robot.text())?.moved_by(&joints)?)
}

/// Random postures that are enough for a robot of `dof` joints: 10,000, and beyond 100 joints a
/// million joint angles in all, since each posture then compares as much more.
pub fn samples(dof: usize) -> usize {
    (DRAWN / dof.max(1)).clamp(LEAST_SAMPLES, MOST_SAMPLES)
}

/// Compare `model` of `robot` with the reference, on `samples` random postures and as
/// many corners as joints allow; with its effects, if it has any, and CAD's parameters.
///
/// # Errors
/// When the reference cannot read the URDF or has no such effect; when `watch` stops the
/// comparison.
pub fn verify(
    robot: &Robot,
    model: &Model,
    samples: usize,
    seed: u64,
    watch: &mut dyn Watch,
) -> Result<Verification, Error> {
    let reference = &reference(robot, model)?;
    let mut postures = Simulator::new(&model.tree.dofs, None, seed).batch(samples);
    postures.extend(corners(model, seed));
    let dof = model.dof();
    let bent = Bent::new(robot, model)?;
    let drawn = postures.len();
    if let Some(bent) = bent.as_ref().filter(|_| dof > 0) {
        let decided = postures.chunks(dof).filter(|q| bent.is_decided(q));
        postures = decided.flatten().copied().collect();
    }
    let undecided = (drawn - postures.len()) / dof.max(1);
    let count = postures.len().checked_div(dof).unwrap_or(1);
    let (mut left_out, mut settled) = (0.0_f64, true);
    let reach = model.reach().max(model.extent()).max(LEAST_REACH_M);
    let joints = JointMotion::of(model);
    let functions = functions(model, bent.as_ref(), reach);
    let named = || functions.iter().map(|own| (own.name.clone(), own));
    // A function without outputs (the Jacobian of a robot without joints) is right.
    let mut worst: BTreeMap<String, f64> = named().map(|(name, _)| (name, 0.0)).collect();
    let bound: BTreeMap<String, f64> = named().map(|(name, own)| (name, own.bound)).collect();
    let blocks = blocks(&postures, count, dof);
    let compared = Compared {
        reference,
        bent: bent.as_ref(),
        joints: &joints,
        dof,
        functions: &functions,
    };
    let mut done = 0;
    for some in blocks.chunks(BLOCKS) {
        let postures: usize = some.iter().map(|block| block.postures).sum();
        // Threads are worth it by what a posture costs, which grows with the joints.
        let cost = postures * dof;
        for found in each(cost, some, |block| compared.differences(block)) {
            for ((name, _), error) in named().zip(found.worst) {
                worst
                    .entry(name)
                    .and_modify(|worst| *worst = worst.max(error));
            }
            left_out = left_out.max(found.left_out);
            settled &= found.settled;
        }
        done += postures;
        tell(watch, "comparing", done as u64, count as u64)?;
    }
    let beyond = named().filter(|(_, own)| !own.is_of_use);
    Ok(Verification {
        // Nothing compared is nothing verified.
        pass: count > 0 && settled && worst.iter().all(|(name, error)| holds(*error, bound[name])),
        beyond_use: beyond.map(|(name, _)| name).collect(),
        widest_of_use: USEFUL * reach,
        samples: count,
        undecided,
        springs_left_out: left_out,
        worst_error: worst,
        units: named()
            .map(|(name, own)| (name, unit(own.function)))
            .collect(),
        bound,
    })
}

/// The unit of a function's error; rows are compared by the CoM that they give.
fn unit(function: Function) -> &'static str {
    match function.error_unit() {
        "" => "m",
        unit => unit,
    }
}

/// Reach that a robot is taken to have at least, m.
const LEAST_REACH_M: f64 = 1e-3;

/// Whether an error keeps its bound; an infinite bound proves nothing.
pub fn holds(error: f64, bound: f64) -> bool {
    bound.is_finite() && error <= bound
}

/// All joints at their lower ends, all at their upper, and mixtures of ends.
pub fn corners(model: &Model, seed: u64) -> Vec<f64> {
    let dofs = &model.tree.dofs;
    let mut coin = Simulator::new(dofs, None, seed.wrapping_add(1));
    let mut corners: Vec<f64> = dofs.iter().map(|dof| dof.lower).collect();
    corners.extend(dofs.iter().map(|dof| dof.upper));
    for _ in 0..2 * dofs.len() {
        let drawn = coin.posture();
        corners.extend(dofs.iter().zip(drawn).map(|(dof, q)| {
            let middle = 0.5 * (dof.lower + dof.upper);
            if q < middle { dof.lower } else { dof.upper }
        }));
    }
    corners
}
