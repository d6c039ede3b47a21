//! The functions of the CoM as expressions.
//!
//! Leaf to root, with `t` the subtree vector rotated by its joint and `K` the
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

mod motion;
mod rates;
mod rotations;
mod rows;
mod subtrees;

use nalgebra::Vector3;

use crate::expr::{Argument, Graph, Id, VectorId};
use crate::interface::{Extent, Function, Given};
use crate::program::{Array, Program, Shape};
use crate::robot::Robot;
use crate::snap::tidy;
use crate::tree::{Coordinate, Dof};
pub(crate) use motion::JointMotion;
use rotations::sines_suffice;
pub(crate) use rows::Direction;
pub(crate) use subtrees::{Subtree, Wanted};

/// A vector of expressions with what is known of it.
#[derive(Clone, Copy)]
pub(crate) struct Known {
    pub(crate) entries: [Id; 3],
    pub(crate) fact: VectorId,
}

impl Known {
    /// A vector of at most this length, made of these beside terms of its own.
    fn within(g: &mut Graph, entries: [Id; 3], norm: f64, from: &[VectorId]) -> Known {
        let fact = g.know(&entries, norm, from);
        Known { entries, fact }
    }

    /// A sum of orthogonal images of these alone.
    fn sum(g: &mut Graph, entries: [Id; 3], from: &[VectorId]) -> Known {
        let fact = g.know_sum(&entries, from);
        Known { entries, fact }
    }

    /// A vector of which no more is known than of each entry.
    fn of_entries(g: &mut Graph, entries: [Id; 3]) -> Known {
        let fact = g.know_entries(&entries);
        Known { entries, fact }
    }
}

/// Where the parameters r come from.
#[derive(Clone)]
pub(crate) enum Parameters {
    /// An input, with the largest magnitude of each.
    Argument(Vec<f64>),
    /// Constants.
    Baked(Vec<f64>),
}

/// The program of a function of a posture from what its expressions are; `None` where
/// sines and cosines do not tell all of it.
pub(crate) fn program(
    scratch: Scratch,
    function: Function,
    given: Given,
    outputs: &[Id],
) -> Option<Program> {
    if scratch.beyond_sines {
        return None;
    }
    let robot = scratch.m;
    let baked = matches!(scratch.parameters, Parameters::Baked(_));
    let rows = match given {
        Given::Direction => 1,
        _ => function.rows().unwrap_or(1),
    };
    let shape = match (rows, function.columns().on(robot)) {
        (1, n) => Shape::Vector(n),
        (rows, cols) => Shape::Matrix { rows, cols },
    };
    let inputs = arrays(robot, function, given, baked);
    let program = Program::new(scratch.g, inputs, shape, outputs);
    // Positions stand for angles whose sines and cosines alone are given.
    let unknown = given != Given::Positions && program.reads(Argument::Positions);
    (!unknown).then_some(program)
}

/// Whether a function can be had from what is given, before it is tried.
pub(crate) fn can_be_had(robot: &Robot, function: Function, given: Given) -> bool {
    match given {
        Given::Positions => true,
        Given::SinesCosines => sines_suffice(robot),
        Given::Direction => sines_suffice(robot) && function.axes().len() == AXES.len(),
    }
}

/// The input arrays of a function.
fn arrays(robot: &Robot, function: Function, given: Given, baked: bool) -> Vec<Array> {
    let arguments = function.arguments(given).into_iter();
    arguments
        .filter(|argument| !(baked && *argument == Argument::Parameters))
        .map(|argument| Array::new(argument, Extent::of(argument).on(robot)))
        .collect()
}

/// What the ZMP of CAD's masses is made of, from `q`, `q̇`, `q̈`: rows of the CoM and of its
/// acceleration by the base parameters (3 × p each, row-major), then the rate of angular
/// momentum about the CoM over the mass, `(L̇_y, −L̇_x)/M`.
///
/// ```text
/// p_xy = c_xy − (c_z c̈_xy + L̇⊥/M)/(g + c̈_z)        c = rows · r,  c̈ = rows of c̈ · r
/// ```
pub fn motion_rows(robot: &Robot) -> Program {
    of_motion(robot, |scratch, joints| scratch.motion_rows(joints))
}

/// The same with the parameters of CAD in the place of rows: CoM c (m), its acceleration c̈
/// (m/s²) and `L̇⊥/M`, eight numbers.
pub fn motion_parts(robot: &Robot) -> Program {
    of_motion(robot, |scratch, joints| scratch.motion_parts(joints))
}

fn of_motion(
    robot: &Robot,
    outputs: impl FnOnce(&mut Scratch<'_>, &JointMotion) -> Vec<Id>,
) -> Program {
    let baked = Parameters::Baked(robot.cad_params());
    let mut scratch = Scratch::new(robot, Given::Positions, baked);
    let joints = JointMotion {
        rates: scratch.g.inputs(Argument::Velocities, robot.dof()),
        accelerations: scratch.g.inputs(Argument::Accelerations, robot.dof()),
    };
    let outputs = outputs(&mut scratch, &joints);
    let inputs = [
        Argument::Positions,
        Argument::Velocities,
        Argument::Accelerations,
    ];
    let inputs = inputs.map(|argument| Array::new(argument, robot.dof()));
    let shape = Shape::Vector(outputs.len());
    Program::new(scratch.g, inputs.to_vec(), shape, &outputs)
}

/// The chain of a robot while functions of it are written down.
pub(crate) struct Scratch<'m> {
    pub(crate) m: &'m Robot,
    pub(crate) g: Graph,
    given: Given,
    parameters: Parameters,
    /// Joint positions, as effects rewrite them. From sines and cosines they stand for
    /// angles of which only those are known.
    pub(crate) positions: Vec<Id>,
    /// An angle is no sum of whole multiples of joint angles and what is known.
    beyond_sines: bool,
    /// What takes the place of r, each with its largest magnitude.
    pub(crate) masses: Option<Vec<(Id, f64)>>,
    /// Stands after the prefix of names: which of several passes over the chain.
    pub(crate) pass: String,
    /// Children of each body, those that carry the longest chain last.
    children: Vec<Vec<usize>>,
    /// Sine and cosine per body, once asked for.
    pub(crate) rotations: Vec<Option<(Id, Id)>>,
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
    pub(crate) fn new(m: &'m Robot, given: Given, parameters: Parameters) -> Self {
        let g = Graph::default();
        let position = |(j, dof): (usize, &Dof)| match given {
            // `_sc` passes the positions of prismatic joints in `sin`.
            Given::SinesCosines | Given::Direction if dof.prismatic => g.input(Argument::Sines, j),
            _ => g.input(Argument::Positions, j),
        };
        let positions = m.tree.dofs.iter().enumerate().map(position).collect();
        Scratch {
            m,
            g,
            given,
            parameters,
            positions,
            beyond_sines: false,
            masses: None,
            pass: String::new(),
            children: longest_last(m.chain.children()),
            rotations: vec![None; m.chain.bodies.len()],
        }
    }

    /// Parameter `index` of r with its largest magnitude; zero where there is none.
    pub(crate) fn parameter(&self, index: Option<usize>) -> (Id, f64) {
        let Some(index) = index else {
            return (self.g.constant(0.0), 0.0);
        };
        match (&self.masses, &self.parameters) {
            (Some(masses), _) => masses[index],
            (None, Parameters::Argument(limits)) => {
                (self.g.input(Argument::Parameters, index), limits[index])
            }
            (None, Parameters::Baked(values)) => {
                (self.g.constant(values[index]), libm::fabs(values[index]))
            }
        }
    }

    /// factor·q + offset
    fn position(&self, by: &Coordinate) -> Id {
        let (factor, offset) = (self.g.constant(by.factor), self.g.constant(by.offset));
        self.g
            .add(self.g.mul(factor, self.positions[by.dof]), offset)
    }

    /// The weights of the canonical axes of body `i` in a direction of its link frame.
    fn weights(&self, i: usize, direction: &Vector3<f64>) -> [Id; 3] {
        self.constants(&(self.m.axes(i).transpose() * direction).map(tidy))
    }

    fn constants(&self, x: &Vector3<f64>) -> [Id; 3] {
        [0, 1, 2].map(|k| self.g.constant(x[k]))
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
        let norm = self.g.vectors[fact.0 as usize].norm;
        norm.unwrap_or(f64::INFINITY)
    }
}
