//! The functions of the CoM as expressions.
//!
//! Leaf to root, with `t` the subtree vector turned by its joint and `K` the
//! constant twist to the parent:
//!
//! ```text
//! v_i = r_i + Σ_children K_k t_k        t_k = Rz(θ_k) v_k        CoM = v_0
//! ```
//!
//! 4 multiplications per joint. Root to leaf, rows of orientations:
//!
//! ```text
//! b_i = b_p K_i Rz(θ_i)
//! ```
//!
//! 4 per joint and row. They meet in the Jacobian: `J_j = B_p K_j (e_z × t_j)`, which
//! is `B_j (e_z × v_j)`.

pub(crate) mod circumstances;
pub(crate) mod correction;
pub(crate) mod diagnosis;
mod inverse;
pub(crate) mod measured;
mod rows;
mod subtrees;
mod turns;

use crate::expr::{Graph, Id, VectorId};
use crate::model::{Function, Given, Model};
use crate::program::{Array, Program, Shape};
use crate::tree::Coordinate;
use subtrees::Wanted;
use turns::sines_suffice;

/// A vector of expressions with what is known of it.
#[derive(Clone, Copy)]
struct Known {
    entries: [Id; 3],
    fact: VectorId,
}

/// Where the parameters r come from.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Parameters {
    /// An input.
    Argument,
    /// Constants: those of the model file, else CAD's.
    Baked,
}

pub(crate) fn build(
    model: &Model,
    function: Function,
    given: Given,
    parameters: Parameters,
) -> Option<Program> {
    if given != Given::Positions && !sines_suffice(model) {
        return None;
    }
    if given == Given::Direction && function.axes().len() < AXES.len() {
        return None;
    }
    if function == Function::CorrectCop {
        return match given {
            Given::Positions => correction::correct_cop(model),
            Given::SinesCosines | Given::Direction => None,
        };
    }
    if function == Function::Cop && model.static_effects().next().is_some() {
        return diagnosis::cop(model, given, parameters);
    }
    let mut scratch = Scratch::new(model, given);
    if parameters == Parameters::Baked && function.takes_parameters() {
        scratch.baked = Some(model.params());
    }
    let cols = columns_of(model, function);
    let rows = match given {
        Given::Direction => 1,
        _ => function.rows().unwrap_or(1),
    };
    let directions = scratch.directions(function);
    let outputs = match function {
        Function::Com => scratch.subtrees(Wanted::Sums)[0].v.entries.to_vec(),
        Function::Cop => scratch.subtrees(Wanted::Sums)[0].v.entries[..2].to_vec(),
        Function::ComJacobian => scratch.jacobian(&directions, false),
        Function::GravityMoments => scratch.jacobian(&directions, true),
        Function::Regressor | Function::RegressorCop => scratch.regressor(&directions),
        Function::RegressorFull => scratch.regressor_full(&directions),
        Function::CorrectCop => unreachable!("a function of no posture"),
    };
    let shape = match (rows, cols) {
        (1, n) => Shape::Vector(n),
        (rows, cols) => Shape::Matrix { rows, cols },
    };
    let mut inputs = arrays(model, function, given);
    if scratch.baked.is_some() {
        inputs.pop();
    }
    Some(Program::new(scratch.g, inputs, shape, &outputs))
}

/// The input arrays of a function.
fn arrays(model: &Model, function: Function, given: Given) -> Vec<Array> {
    let names: &[&'static str] = match given {
        Given::Positions => &["q"],
        Given::SinesCosines | Given::Direction => &["sin", "cos"],
    };
    let mut arrays: Vec<Array> = names
        .iter()
        .map(|&name| Array {
            name,
            len: model.dof(),
        })
        .collect();
    if function.takes_parameters() {
        arrays.push(Array {
            name: "r",
            len: model.base.params.len(),
        });
    }
    if given == Given::Direction {
        arrays.push(Array {
            name: "along",
            len: 3,
        });
    }
    arrays
}

/// ∂CoM/∂q by the chain rule on the expressions of the CoM itself, row-major.
///
/// Costs more operations than [`Function::ComJacobian`], which knows the
/// geometry; it is there to check it.
pub fn differentiate_com(model: &Model) -> Program {
    let mut scratch = Scratch::new(model, Given::Positions);
    let com = scratch.subtrees(Wanted::Sums)[0].v.entries;
    let inputs: Vec<Id> = (0..model.dof()).map(|j| scratch.g.input(0, j)).collect();
    let columns: Vec<Vec<Id>> = inputs
        .iter()
        .map(|&q| scratch.g.derivative(&com, q))
        .collect();
    let rows = (0..3).flat_map(|k| columns.iter().map(move |column| column[k]));
    let outputs: Vec<Id> = rows.collect();
    let shape = Shape::Matrix {
        rows: 3,
        cols: model.dof(),
    };
    let inputs = arrays(model, Function::ComJacobian, Given::Positions);
    Program::new(scratch.g, inputs, shape, &outputs)
}

fn columns_of(model: &Model, function: Function) -> usize {
    match function {
        Function::Com => 3,
        Function::Cop | Function::CorrectCop => 2,
        Function::ComJacobian | Function::GravityMoments => model.dof(),
        Function::Regressor | Function::RegressorCop => model.base.params.len(),
        Function::RegressorFull => model.chain.full_params,
    }
}

struct Scratch<'m> {
    m: &'m Model,
    g: Graph,
    given: Given,
    /// Values of r, where they are constants.
    baked: Option<Vec<f64>>,
    /// What takes the place of joint positions, where effects rewrote them.
    positions: Option<Vec<Id>>,
    /// What takes the place of r, each with its largest magnitude.
    masses: Option<Vec<(Id, f64)>>,
    /// Stands behind the prefix of names: which of several passes over the chain.
    pass: String,
    /// Of each body, those that carry the longest chain last.
    children: Vec<Vec<usize>>,
    /// Sine and cosine per body, once asked for.
    turns: Vec<Option<(Id, Id)>>,
}

/// Children in the order of the joints above them, the shortest first.
fn longest_last(mut children: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    let mut length = vec![0_usize; children.len()];
    // Parents stand before their children.
    for i in (0..children.len()).rev() {
        children[i].sort_by_key(|&c| length[c]);
        let longest = children[i].last();
        length[i] = longest.map_or(0, |&c| length[c] + 1);
    }
    children
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl<'m> Scratch<'m> {
    fn new(m: &'m Model, given: Given) -> Self {
        Scratch {
            m,
            g: Graph::default(),
            given,
            baked: None,
            positions: None,
            masses: None,
            pass: String::new(),
            children: longest_last(m.chain.children()),
            turns: vec![None; m.chain.bodies.len()],
        }
    }

    /// Parameter `index` of r; zero where there is none.
    fn parameter(&mut self, index: Option<usize>) -> Id {
        if let (Some(index), Some(masses)) = (index, &self.masses) {
            return masses[index].0;
        }
        let array = match self.given {
            Given::Positions => 1,
            Given::SinesCosines | Given::Direction => 2,
        };
        match (index, &self.baked) {
            (Some(index), None) => self.g.input(array, index),
            (Some(index), Some(values)) => self.g.constant(values[index]),
            (None, _) => self.g.constant(0.0),
        }
    }

    /// Largest magnitude of a parameter.
    fn parameter_limit(&self, index: Option<usize>) -> f64 {
        if let (Some(index), Some(masses)) = (index, &self.masses) {
            return masses[index].1;
        }
        match (index, &self.baked) {
            (Some(index), None) => self.m.param_limits[index],
            (Some(index), Some(values)) => libm::fabs(values[index]),
            (None, _) => 0.0,
        }
    }

    /// Position of a slide: factor·q + offset. (`_sc` passes q in `sin`.)
    fn position(&mut self, by: &Coordinate) -> Id {
        let q = match &self.positions {
            Some(positions) => positions[by.dof],
            None => self.g.input(0, by.dof),
        };
        let (factor, offset) = (self.g.constant(by.factor), self.g.constant(by.offset));
        let scaled = self.g.mul(factor, q);
        self.g.add(scaled, offset)
    }

    fn section(&mut self, body: usize) {
        let title = match &self.m.chain.bodies[body].joint {
            Some(joint) => joint.clone(),
            None => self.m.chain.bodies[body].name.clone(),
        };
        self.g.section(title);
    }

    fn name(&mut self, vector: &[Id; 3], prefix: &str, body: usize) {
        for (id, axis) in vector.iter().zip(AXES) {
            let (key, pass) = (&self.m.keys[body], &self.pass);
            self.g.name(*id, || format!("{prefix}{pass}_{key}_{axis}"));
        }
    }

    fn norm(&self, fact: VectorId) -> f64 {
        self.g.vectors[fact.0 as usize].norm
    }
}
