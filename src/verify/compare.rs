//! Postures in blocks, and how far the functions of a model are from the reference in them.

use sesc_identify::evaluate::Evaluator;
use sesc_model::Function;
use sesc_model::tape::Values;
use sesc_reference::Reference;

use super::motion::{JointMotion, Truth, velocities};
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
    pub(super) fn differences(&self, block: &Block) -> Differences {
        let (q, postures, differentiate) = (&block.q, block.postures, block.differentiate);
        let dof = self.dof;
        let truth = |k: usize| {
            let q = &q[k * dof..(k + 1) * dof];
            match self.bent {
                Some(bent) => bent.truth(q, self.joints, differentiate),
                None => Truth::new(self.reference, q, self.joints, differentiate),
            }
        };
        let truths: Vec<Truth> = (0..postures).map(truth).collect();
        let mut room = Vec::new();
        let unlike = velocities(dof);
        let worst = |own: &Compares| {
            if !differentiate && is_derivative(own.function) {
                return 0.0;
            }
            let width = own.evaluator.width();
            room.resize(postures * width, 0.0);
            let rates = match own.function {
                Function::Zmp => &self.joints.rates,
                _ => &unlike,
            };
            let motion = [rates, &self.joints.accelerations].map(|all| Values::Shared(all));
            own.evaluator
                .run_moving_into(q, motion, postures, &mut room);
            let rows = room.chunks(width.max(1)).zip(&truths);
            let errors =
                rows.map(|(values, truth)| truth.difference(own.function, &own.params, values));
            // A NaN must not slip through a maximum.
            errors.fold(0.0, |worst: f64, error| match error.is_nan() {
                true => f64::INFINITY,
                false => worst.max(error),
            })
        };
        let mut found = Differences {
            worst: self.functions.iter().map(worst).collect(),
            left_out: 0.0,
            settled: true,
        };
        let bent = self.bent.iter().flat_map(|bent| {
            let postures = q.chunks(dof.max(1));
            postures.map(|q| bent.left_out(q))
        });
        for (measured, most) in bent {
            found.left_out = found.left_out.max(measured);
            // Not so for what is not a number.
            found.settled &= measured <= most + world::AT_REST;
        }
        found
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
        Function::ComJacobian
            | Function::ComVelocity
            | Function::GravityMoments
            | Function::CopJacobian
    )
}
