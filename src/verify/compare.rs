//! Postures in blocks, and how far the functions of a model are from the reference in them.

use sesc_identify::evaluate::Evaluator;
use sesc_model::Function;
use sesc_reference::Reference;

use super::motion::JointMotion;
use super::truth::Truth;
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

/// Postures in blocks: first those that are differentiated, then the others.
pub(super) struct Blocks {
    dof: usize,
    differentiated: Vec<f64>,
    others: Vec<f64>,
    /// Postures of each; robots without joints have one, of no numbers.
    counts: [usize; 2],
}

/// Postures that are compared together.
pub(super) struct Block<'a> {
    pub q: &'a [f64],
    pub postures: usize,
    pub differentiate: bool,
}

impl Blocks {
    /// `count` postures, one in [`DIFFERENTIATED`] of them to be differentiated or, where
    /// joints are many, one in so many that [`DERIVATIVES`] are taken.
    pub fn of(postures: &[f64], count: usize, dof: usize) -> Blocks {
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

    pub fn iter(&self) -> impl Iterator<Item = Block<'_>> {
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

/// Whether the function is compared where postures are differentiated alone.
fn is_derivative(function: Function) -> bool {
    matches!(
        function,
        Function::ComJacobian | Function::ComVelocity | Function::GravityMoments
    )
}
