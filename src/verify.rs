//! Generated functions against the independent reference.
//!
//! The program that becomes Rust runs on tape; the reference sums `m_i T_i c_i`
//! from its own reading of the URDF. Allowed difference: twice the proven
//! rounding bound (the reference rounds too) and what snapped right angles move.
//!
//! A model with effects is compared with the virtual robot of the reference, which has
//! them (`world`).

mod imperfect;
mod motion;
mod world;

use std::collections::BTreeMap;

use serde::Serialize;
use sesc_codegen::emit::header::function_name;
use sesc_model::bounds::Precision;
use sesc_model::{Function, Given, Model};
use sesc_reference::Reference;

use crate::Error;
pub use imperfect::with_effect;
pub use motion::JointMotion;
use sesc_identify::evaluate::Evaluator;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_identify::threads::each;
use sesc_identify::{Watch, tell};
use world::{Bent, beyond_rounding};

/// Derivatives by differences are this exact, relative to the robot's size.
const DIFFERENCES: f64 = 2e-10;
/// One posture in so many is also differentiated, which costs 6 evaluations a joint,
const DIFFERENTIATED: usize = 50;
/// and where joints are many, so few postures that these many derivatives are taken.
const DERIVATIVES: usize = 10_000;
/// Joint angles that [`samples`] draws, in postures that the limits below hold.
const DRAWN: usize = 1_000_000;
/// Postures of a robot of 100 joints or fewer.
const MOST_SAMPLES: usize = 10_000;
/// Postures of a robot of any size.
const LEAST_SAMPLES: usize = 1_000;
/// Postures evaluated together: their rows stay in the second cache.
const BLOCK: usize = 128;
/// The same where they are differentiated.
const BLOCK_OF_DERIVATIVES: usize = 8;
/// Blocks after which it is told how far the comparison is.
const BLOCKS: usize = 8;

/// What the comparison found.
#[derive(Debug, Clone, Serialize)]
pub struct Verification {
    /// Whether every difference is within its tolerance.
    pub pass: bool,
    /// Postures compared: random ones and corners of the limits.
    pub samples: usize,
    /// Postures left out: gravity does not decide there on which side of its dead band a
    /// joint rests, or the CoP is off the cells that have effects.
    pub undecided: usize,
    /// What four rounds of a model's springs leave out, m: measured, and within what is
    /// proven; beside dead bands what is proven, and part of every bound.
    pub springs_left_out: f64,
    /// Largest difference per function, in its unit; regressor rows by the CoM they give, m.
    pub worst_error: BTreeMap<String, f64>,
    /// What rounding, snapping and springs may explain, in the same units.
    pub bound: BTreeMap<String, f64>,
    /// Functions whose bound is so wide that keeping it verifies nothing: they have to agree to
    /// a billionth of the robot's reach instead ([`UNPROVEN_OF_REACH`]).
    pub beyond_use: Vec<String>,
    /// The widest bound of use, m: a thousandth of the robot's reach ([`USEFUL`]); without what
    /// springs explain.
    pub widest_of_use: f64,
    /// Those units; m of regressor rows.
    #[serde(skip)]
    pub units: BTreeMap<String, &'static str>,
}

/// The independent reference of `robot` on `support`; it reads the URDF by itself.
///
/// # Errors
/// When the reference cannot read the URDF, or has no such link.
pub fn reference(robot: &Robot, support: &str) -> Result<Reference, Error> {
    let read = sesc_reference::Robot::from_urdf(robot.text())?;
    Ok(Reference::new(&read, support)?)
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
    let reference = &reference(robot, &model.tree.links[model.tree.support].name)?;
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
    let count = match dof {
        0 => 1,
        _ => postures.len() / dof,
    };
    let decided = decided(model);
    let allowed_for_springs = bent.as_ref().map_or(0.0, Bent::allowed_for_springs);
    let mut left_out: f64 = 0.0;
    let mut settled = true;
    let reach = model.reach().max(model.extent()).max(LEAST_REACH_M);
    let widest_of_use = USEFUL * reach;
    let mut beyond_use = Vec::new();
    let mut worst: BTreeMap<String, f64> = BTreeMap::new();
    let mut bound: BTreeMap<String, f64> = BTreeMap::new();
    let mut units: BTreeMap<String, &str> = BTreeMap::new();
    let joints = JointMotion::of(model);
    let mut evaluators = Vec::new();
    for given in [Given::Positions, Given::SinesCosines, Given::Direction] {
        for function in Function::ALL {
            let params = model.cad_params();
            if let Some(evaluator) = Evaluator::variant(model, function, given, params) {
                let evaluator = match function {
                    Function::Zmp => evaluator.moving(&joints.rates, &joints.accelerations),
                    _ => evaluator.moving(&velocities(dof), &[]),
                };
                let name = function_name(function, given);
                let own = bent.is_some();
                let own = own.then(|| beyond_rounding(model, function, allowed_for_springs));
                let allowed = match allowed(&decided, function, given) {
                    infinite if own.is_some() && infinite.is_infinite() => {
                        UNPROVEN_M * magnified(model)
                    }
                    proven => proven,
                };
                // Springs beside dead bands have bounds of millimetres, which are told by name.
                let is_of_use = own.is_some() || allowed <= widest_of_use;
                let allowed = match is_of_use {
                    true => allowed,
                    false => {
                        beyond_use.push(name.clone());
                        // What is infinite or no number stays so, and fails.
                        match allowed.is_finite() {
                            true => UNPROVEN_OF_REACH * reach,
                            false => allowed,
                        }
                    }
                };
                bound.insert(name.clone(), allowed + own.unwrap_or(0.0));
                // Rows are compared by the CoM that they give.
                let unit = Some(function.error_unit()).filter(|unit| !unit.is_empty());
                units.insert(name.clone(), unit.unwrap_or("m"));
                evaluators.push((name, function, explained_by(model, function), evaluator));
            }
        }
    }
    let blocks = Blocks::of(&postures, count, dof);
    let blocks: Vec<Block> = blocks.iter().collect();
    let compared = Compared {
        reference,
        bent: bent.as_ref(),
        joints: &joints,
        dof,
        evaluators: &evaluators,
    };
    let mut done = 0;
    for some in blocks.chunks(BLOCKS) {
        let postures = some.iter().map(|block| block.postures).sum();
        for found in each(postures, some, |block| compared.differences(block)) {
            for ((name, ..), error) in evaluators.iter().zip(found.worst) {
                let entry = worst.entry(name.clone()).or_default();
                *entry = entry.max(error);
            }
            left_out = left_out.max(found.left_out);
            settled &= found.settled;
        }
        done += postures;
        tell(watch, "comparing", done as u64, count as u64)?;
    }
    // A function without outputs (the Jacobian of a robot without joints) is right.
    for name in bound.keys() {
        worst.entry(name.clone()).or_default();
    }
    Ok(Verification {
        // Nothing compared is nothing verified.
        pass: count > 0 && settled && worst.iter().all(|(name, error)| holds(*error, bound[name])),
        beyond_use,
        widest_of_use,
        samples: count,
        undecided,
        springs_left_out: left_out,
        worst_error: worst,
        bound,
        units,
    })
}

/// Part of the robot's reach from which on a bound is too wide to verify anything.
pub const USEFUL: f64 = 1e-3;

/// Reach that a robot is taken to have at least, m.
const LEAST_REACH_M: f64 = 1e-3;

/// Part of the robot's reach that is allowed where the proven bound is of no use.
pub const UNPROVEN_OF_REACH: f64 = 1e-9;

/// What is allowed where an effect of the model file divides or takes powers, so that no
/// bound is proven, m.
const UNPROVEN_M: f64 = 1e-9;

/// Whether an error keeps its bound; an infinite bound proves nothing.
pub fn holds(error: f64, bound: f64) -> bool {
    bound.is_finite() && error <= bound
}

/// The model whose rounding counts: postures that are compared have every loose joint at an
/// end of its dead band, by a moment that rounding does not turn round. Where springs give
/// way on the way to that end, the bound of the whole model is taken.
fn decided(model: &Model) -> Model {
    let mut decided = model.clone();
    if !decided.effects.iter().any(|(i, _)| i.effect.is_spring()) {
        let effects = &mut decided.effects;
        effects.retain(|(i, _)| i.effect.dead_band().is_none());
    }
    decided
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

/// What postures are compared by.
struct Compared<'a> {
    reference: &'a Reference,
    bent: Option<&'a Bent>,
    joints: &'a JointMotion,
    dof: usize,
    /// Name, function, what its rows are multiplied with, and its program on tape.
    evaluators: &'a [(String, Function, Vec<f64>, Evaluator)],
}

/// What a block of postures shows.
struct Differences {
    /// Largest difference of each function; infinite where one is no number.
    worst: Vec<f64>,
    /// What rounds of springs leave out, m.
    left_out: f64,
    /// Whether that is within what is proven.
    settled: bool,
}

impl Compared<'_> {
    fn differences(&self, block: &Block) -> Differences {
        let Block {
            q,
            postures,
            differentiate,
        } = *block;
        let dof = self.dof;
        let truths: Vec<Truth> = (0..postures)
            .map(|k| {
                let q = &q[k * dof..(k + 1) * dof];
                match self.bent {
                    Some(bent) => bent.truth(q, self.joints, differentiate),
                    None => Truth::new(self.reference, q, self.joints, differentiate),
                }
            })
            .collect();
        let mut room = Vec::new();
        let worst = |(_, function, params, evaluator): &(_, Function, Vec<f64>, Evaluator)| {
            if !differentiate && is_derivative(*function) {
                return 0.0;
            }
            room.resize(postures * evaluator.width(), 0.0);
            evaluator.run_into(q, postures, &mut room);
            let rows = room.chunks(evaluator.width().max(1)).zip(&truths);
            let errors = rows.map(|(values, truth)| truth.difference(*function, params, values));
            // A NaN must not slip through a maximum.
            errors.fold(0.0, |worst: f64, error| match error.is_nan() {
                true => f64::INFINITY,
                false => worst.max(error),
            })
        };
        let worst = self.evaluators.iter().map(worst).collect();
        let (mut left_out, mut settled) = (0.0_f64, true);
        for q in q.chunks(dof.max(1)) {
            if let Some(bent) = self.bent {
                let (measured, most) = bent.left_out(q);
                left_out = left_out.max(measured);
                // Not so for what is not a number.
                settled &= measured <= most + world::AT_REST;
            }
        }
        Differences {
            worst,
            left_out,
            settled,
        }
    }
}

/// Postures in blocks: first those that are differentiated, then the others.
struct Blocks {
    dof: usize,
    differentiated: Vec<f64>,
    others: Vec<f64>,
    /// Postures of each; robots without joints have one, of no numbers.
    counts: [usize; 2],
}

/// Postures that are compared together.
struct Block<'a> {
    q: &'a [f64],
    postures: usize,
    differentiate: bool,
}

impl Blocks {
    /// `count` postures, one in [`DIFFERENTIATED`] of them to be differentiated or, where
    /// joints are many, one in so many that [`DERIVATIVES`] are taken.
    fn of(postures: &[f64], count: usize, dof: usize) -> Blocks {
        let one_in = DIFFERENTIATED.max((count * dof).div_ceil(DERIVATIVES));
        let differentiated = count.div_ceil(one_in);
        let mut blocks = Blocks {
            dof,
            differentiated: Vec::with_capacity(differentiated * dof),
            others: Vec::with_capacity((count - differentiated) * dof),
            counts: [differentiated, count - differentiated],
        };
        for (k, q) in postures.chunks(dof.max(1)).enumerate() {
            match k % one_in {
                0 => blocks.differentiated.extend(q),
                _ => blocks.others.extend(q),
            }
        }
        blocks
    }

    fn iter(&self) -> impl Iterator<Item = Block<'_>> {
        let parts = [&self.differentiated, &self.others];
        let parts = parts.into_iter().zip(self.counts).zip([true, false]);
        parts.flat_map(move |((q, count), differentiate)| {
            let size = match differentiate {
                true => BLOCK_OF_DERIVATIVES,
                false => BLOCK,
            };
            (0..count).step_by(size).map(move |start| {
                let end = count.min(start + size);
                Block {
                    q: &q[start * self.dof..end * self.dof],
                    postures: end - start,
                    differentiate,
                }
            })
        })
    }
}

/// Joint velocities that the velocity of the CoM is compared at, rad/s or m/s: no two alike.
fn velocities(dof: usize) -> Vec<f64> {
    (0..dof).map(|j| 1.0 / (1.0 + j as f64)).collect()
}

/// What the reference says of one posture.
struct Truth {
    com: [f64; 3],
    /// The CoM that regressor rows give: of the robot with effects of the encoders alone.
    rows: [f64; 3],
    /// The CoP as the sensor reads it.
    cop: [f64; 2],
    /// The ZMP as joints move, where it is known.
    zmp: Option<[f64; 2]>,
    /// Row-major Jacobian and gravity moments, where they were taken.
    derivatives: Option<(Vec<f64>, Vec<f64>)>,
}

impl Truth {
    fn new(reference: &Reference, q: &[f64], joints: &JointMotion, differentiate: bool) -> Truth {
        let com = reference.com(q);
        let derivatives = differentiate.then(|| {
            let (jacobian, moments) = reference.derivatives(q);
            let jacobian = jacobian.transpose().as_slice().to_vec();
            (jacobian, moments.as_slice().to_vec())
        });
        Truth {
            com: [com.x, com.y, com.z],
            rows: [com.x, com.y, com.z],
            cop: [com.x, com.y],
            zmp: Some(
                reference
                    .zmp(q, &joints.rates, &joints.accelerations)
                    .into(),
            ),
            derivatives,
        }
    }

    /// Largest difference between `values` of `function` and the truth, m; of rows by what
    /// they give times `params`, of a velocity by that of joints that move at `params`.
    fn difference(&self, function: Function, params: &[f64], values: &[f64]) -> f64 {
        let times = |row: &[f64]| -> f64 { row.iter().zip(params).map(|(a, b)| a * b).sum() };
        let explained =
            |rows: &[f64]| -> Vec<f64> { rows.chunks(params.len().max(1)).map(times).collect() };
        match (function, &self.derivatives) {
            (Function::Com, _) => largest(values, &self.com),
            (Function::Cop, _) => largest(values, &self.cop),
            (Function::Zmp, _) => self.zmp.map_or(0.0, |zmp| largest(values, &zmp)),
            // Not of a posture: nothing to compare.
            (Function::CorrectCop, _) => 0.0,
            (Function::Regressor | Function::RegressorCop | Function::RegressorFull, _) => {
                largest(&explained(values), &self.rows)
            }
            (Function::ComJacobian, Some((jacobian, _))) => largest(values, jacobian),
            (Function::GravityMoments, Some((_, moments))) => largest(values, moments),
            (Function::ComVelocity, Some((jacobian, _))) => largest(values, &explained(jacobian)),
            (Function::ComJacobian | Function::ComVelocity | Function::GravityMoments, None) => 0.0,
        }
    }
}

/// Whether the function is compared where postures are differentiated alone.
fn is_derivative(function: Function) -> bool {
    matches!(
        function,
        Function::ComJacobian | Function::ComVelocity | Function::GravityMoments
    )
}

/// What rows of a function are multiplied with to be compared, if it has any.
fn explained_by(model: &Model, function: Function) -> Vec<f64> {
    match function {
        Function::Regressor | Function::RegressorCop => model.cad_params(),
        Function::RegressorFull => model.chain.full_cad(),
        Function::ComVelocity => velocities(model.dof()),
        _ => Vec::new(),
    }
}

/// How many times further a reading moves than its CoP; 1 without effects of the sensor.
fn magnified(model: &Model) -> f64 {
    let at = |x: f64, y: f64| model.reading_of([x, y]);
    let (here, step) = (at(0.0, 0.0), 1e-3);
    let moved = |there: [f64; 2]| (there[0] - here[0]).hypot(there[1] - here[1]) / step;
    moved(at(step, 0.0)).max(moved(at(0.0, step)))
}

/// Largest |a − b| over the entries of `a`; NaN if there is one.
fn largest(a: &[f64], b: &[f64]) -> f64 {
    let differences = a.iter().zip(b).map(|(x, y)| (x - y).abs());
    differences.fold(0.0, |most, x| if x.is_nan() || x > most { x } else { most })
}

/// How far generated code may be from the reference, m; infinite for a variant
/// that cannot be had.
pub fn allowed(model: &Model, function: Function, given: Given) -> f64 {
    let rounding = |function: Function, given: Given| {
        let program = model.program(function, given);
        program.map_or(f64::INFINITY, |program| {
            model.rounding(&program, Precision::F64).worst
        })
    };
    let snapped: f64 = model
        .tree
        .snaps
        .iter()
        .map(|snap| snap.com_error)
        .sum::<f64>()
        + model.base.regrouping_error;
    let tilted: f64 = model.tree.snaps.iter().map(|snap| snap.angle_error).sum();
    // The CoM that rows are compared by comes from no direction.
    let com = match given {
        Given::Direction => rounding(Function::Com, Given::SinesCosines),
        given => rounding(Function::Com, given),
    };
    let com = 2.0 * com + snapped;
    // Rows times parameters: every entry's error, weighed, and a long sum's own.
    let weighed = |params: Vec<f64>| {
        let sum: f64 = params.iter().map(|x| x.abs()).sum();
        sum * (rounding(function, given) + params.len() as f64 * f64::EPSILON)
    };
    match function {
        Function::Com => com,
        Function::Cop if model.effects.is_empty() => com,
        // A sensor may magnify what is snapped, and give it another unit.
        Function::Cop => 2.0 * rounding(function, given) + snapped * magnified(model),
        Function::Zmp => {
            let moved = JointMotion::of(model).snapped(model, snapped);
            2.0 * rounding(function, given) + moved
        }
        // Not of a posture: nothing to compare.
        Function::CorrectCop => 0.0,
        Function::Regressor | Function::RegressorCop => com + weighed(model.cad_params()),
        Function::RegressorFull => com + weighed(model.chain.full_cad()),
        Function::ComJacobian | Function::ComVelocity | Function::GravityMoments => {
            // A column is a × S: turning what is below the joint by ε changes it by
            // what it moves the CoM, turning the joint itself by no more. The
            // axis of a prismatic joint turns as a whole.
            let prismatic = model.tree.dofs.iter().any(|dof| dof.prismatic);
            let turned = if prismatic { snapped + tilted } else { snapped };
            let columns: f64 = match function {
                Function::ComVelocity => velocities(model.dof()).iter().sum(),
                _ => 1.0,
            };
            2.0 * rounding(function, given)
                + columns.max(1.0) * model.largest_tie() * (DIFFERENCES * model.reach() + turned)
        }
    }
}
