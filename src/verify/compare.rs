//! Postures in blocks, and how far the functions of a model are from the reference in them.

use sesc_identify::evaluate::Evaluator;
use sesc_model::Function;
use sesc_reference::Reference;

use super::motion::JointMotion;
use super::world::{self, Bent};

/// One posture in so many is also differentiated, which costs a few evaluations a joint,
const DIFFERENTIATED: usize = 50;
/// and where joints are many, so few postures that these many derivatives are taken.
const DERIVATIVES: usize = 10_000;
/// Postures evaluated together: their rows stay in the second cache.
const BLOCK: usize = 128;
/// The same where they are differentiated.
const BLOCK_OF_DERIVATIVES: usize = 8;

/// What postures are compared by.
pub(super) struct Compared<'a> {
    pub reference: &'a Reference,
    pub bent: Option<&'a Bent>,
    pub joints: &'a JointMotion,
    pub dof: usize,
    pub functions: &'a [Compares],
}

/// A function that is compared.
pub(super) struct Compares {
    /// That of generated code.
    pub name: String,
    pub function: Function,
    /// What its rows are multiplied with, if it has any.
    pub params: Vec<f64>,
    /// Its program on tape.
    pub evaluator: Evaluator,
    /// Largest difference that it may have, in its unit.
    pub bound: f64,
    /// Whether the proven bound verifies anything, so that `bound` is made of it.
    pub is_of_use: bool,
}

/// What a block of postures shows.
pub(super) struct Differences {
    /// Largest difference of each function; infinite where one is no number.
    pub worst: Vec<f64>,
    /// What rounds of springs leave out, m.
    pub left_out: f64,
    /// Whether that is within what is proven.
    pub settled: bool,
}

impl Compared<'_> {
    pub fn differences(&self, block: &Block) -> Differences {
        let (q, postures, differentiate) = (&block.q, block.postures, block.differentiate);
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
        let worst = |compares: &Compares| {
            let Compares {
                function,
                params,
                evaluator,
                ..
            } = compares;
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
        let worst = self.functions.iter().map(worst).collect();
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

/// Postures that are compared together.
pub(super) struct Block {
    pub q: Vec<f64>,
    /// Robots without joints have one, of no numbers.
    pub postures: usize,
    pub differentiate: bool,
}

/// `count` postures in blocks: first those that are differentiated, one in [`DIFFERENTIATED`] or,
/// where joints are many, one in so many that [`DERIVATIVES`] are taken; then the others.
pub(super) fn blocks(postures: &[f64], count: usize, dof: usize) -> Vec<Block> {
    let one_in = DIFFERENTIATED.max((count * dof).div_ceil(DERIVATIVES));
    let mut blocks = Vec::new();
    for (differentiate, size) in [(true, BLOCK_OF_DERIVATIVES), (false, BLOCK)] {
        let own = (0..count).filter(|k| k.is_multiple_of(one_in) == differentiate);
        for own in own.collect::<Vec<usize>>().chunks(size) {
            let q = own.iter().flat_map(|k| &postures[k * dof..(k + 1) * dof]);
            blocks.push(Block {
                q: q.copied().collect(),
                postures: own.len(),
                differentiate,
            });
        }
    }
    blocks
}

/// Whether the function is compared where postures are differentiated alone.
fn is_derivative(function: Function) -> bool {
    matches!(
        function,
        Function::ComJacobian | Function::ComVelocity | Function::GravityMoments
    )
}

// What the reference says of one posture, and how far the values of a function are from it.

/// What the reference says of one posture.
pub(super) struct Truth {
    pub com: [f64; 3],
    /// The CoM that regressor rows give: of the robot with effects of the encoders alone.
    pub rows: [f64; 3],
    /// The CoP as the sensor reads it.
    pub cop: [f64; 2],
    /// The ZMP as joints move, where it is known.
    pub zmp: Option<[f64; 2]>,
    /// Row-major Jacobian and gravity moments, where they were taken.
    pub derivatives: Option<(Vec<f64>, Vec<f64>)>,
}

impl Truth {
    pub fn new(
        reference: &Reference,
        q: &[f64],
        joints: &JointMotion,
        differentiate: bool,
    ) -> Truth {
        let com = reference.com(q);
        let derivatives = differentiate.then(|| {
            let jacobian = reference.com_jacobian(q).transpose();
            let moments = -jacobian.column(2);
            (jacobian.as_slice().to_vec(), moments.as_slice().to_vec())
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
    pub fn difference(&self, function: Function, params: &[f64], values: &[f64]) -> f64 {
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

/// Largest |a − b| over the entries of `a`; NaN if there is one.
fn largest(a: &[f64], b: &[f64]) -> f64 {
    let differences = a.iter().zip(b).map(|(x, y)| (x - y).abs());
    differences.fold(0.0, |most, x| if x.is_nan() || x > most { x } else { most })
}
