//! The body that a function of positions and that of their sines and cosines have in common.
//!
//! ```text
//! f(q) = core(sin α(q), cos α(q))        f_sc(sin, cos) = core(sin α, cos α by addition theorems)
//! ```
//!
//! `α` are the angles that links turn by: joint positions, some with a constant of the URDF
//! added. Where both programs are of the same operations but for how the sines of `α` come about,
//! the body is written once, and either function has the bits of a body of its own.

use std::collections::HashMap;

use sesc_model::Function;
use sesc_model::expr::{Argument, Expr, Id};
use sesc_model::program::{Program, Shape, operands};

/// The common body and what it takes.
#[derive(Debug, Clone)]
pub(super) struct Shared {
    /// The program of positions; its angles are inputs.
    pub core: Program,
    /// In the order of joints.
    pub angles: Vec<Angle>,
    /// Whether the body reads positions of prismatic joints.
    pub reads_positions: bool,
}

/// An angle that a link turns by.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Angle {
    /// Where it stands in the program of positions.
    pub id: Id,
    /// Its joint.
    pub joint: usize,
    /// Sine and cosine in the program of sines and cosines; none where they are the joint's.
    pub turned: Option<[Option<Id>; 2]>,
}

/// Functions whose bodies stand twice: a common body costs each more than 2 %. In Rust `com_sc`
/// takes 2.8 % more instructions, `com_velocity` 3.4 % and `gravity_moments` 6.3 %; on a Cortex-M4F
/// `com_ticks` and `cop_ticks` take 224 bytes of stack for 208. Regressors have one: with it they
/// take between 7 % fewer and 6 % more instructions, and `regressor_cop_sc` 11 % more.
const TWICE: [Function; 4] = [
    Function::Com,
    Function::ComVelocity,
    Function::GravityMoments,
    Function::Cop,
];
/// Not of more angles than these, where what counts is how long a compiler takes.
const ANGLES_TWICE: usize = 64;

impl Shared {
    /// `None` where the programs are not of the same operations, there is no angle, or a common
    /// body would be slower.
    pub(super) fn new(function: Function, positions: &Program, sines: &Program) -> Option<Shared> {
        if TWICE.contains(&function) && positions.angles().len() <= ANGLES_TWICE {
            return None;
        }
        let mut angles: Vec<Angle> = Vec::new();
        for id in positions.angles().into_keys() {
            let joint = joint_of(positions, id)?;
            let is_position = matches!(positions.expr(id), Expr::Input { .. });
            let turned = (!is_position).then_some([None; 2]);
            angles.push(Angle { id, joint, turned });
        }
        angles.sort_by_key(|angle| (angle.joint, angle.id));
        if angles.is_empty() {
            return None;
        }
        let mut core = positions.clone();
        for angle in &angles {
            core.nodes[angle.id.index()].expr = Expr::Input {
                argument: Argument::Positions,
                index: angle.joint as u32,
            };
        }
        core.keep(positions.outputs.clone());
        let mut shared = Shared {
            reads_positions: false,
            core,
            angles,
        };
        shared.matches(sines).then_some(shared)
    }

    /// The place of an angle in the order of joints.
    pub(super) fn place(&self, angle: Id) -> usize {
        let found = self.angles.iter().position(|known| known.id == angle);
        found.expect("angles of the body are its inputs")
    }

    /// Whether the body is what `sines` computes; finds the sines of turned angles there.
    fn matches(&mut self, sines: &Program) -> bool {
        let mut known: HashMap<Id, Id> = HashMap::new();
        let outputs = self.core.outputs.iter().zip(&sines.outputs);
        let mut open: Vec<(Id, Id)> = outputs.map(|(a, b)| (*a, *b)).collect();
        while let Some((a, b)) = open.pop() {
            match known.insert(a, b) {
                Some(before) if before == b => continue,
                Some(_) => return false,
                None => {}
            }
            let (of_core, of_sines) = (self.core.expr(a), sines.expr(b));
            let same = match (of_core, of_sines) {
                (Expr::Sin(angle), _) => self.is_sine(angle, 0, b, of_sines),
                (Expr::Cos(angle), _) => self.is_sine(angle, 1, b, of_sines),
                (Expr::Const(x), Expr::Const(y)) => x.to_bits() == y.to_bits(),
                (
                    Expr::Input {
                        argument: Argument::Positions,
                        index,
                    },
                    _,
                ) => {
                    self.reads_positions = true;
                    let argument = Argument::Sines;
                    of_sines == Expr::Input { argument, index }
                }
                (Expr::Input { .. }, _) => of_core == of_sines,
                _ => {
                    let pairs = operands(of_core).zip(operands(of_sines));
                    open.extend(pairs);
                    std::mem::discriminant(&of_core) == std::mem::discriminant(&of_sines)
                }
            };
            if !same {
                return false;
            }
        }
        true
    }

    /// Whether node `b` is the sine (0) or cosine (1) of an angle of the body.
    fn is_sine(&mut self, angle: Id, which: usize, b: Id, expr: Expr) -> bool {
        let place = self.place(angle);
        let angle = &mut self.angles[place];
        match &mut angle.turned {
            Some(turned) => turned[which].replace(b).is_none_or(|before| before == b),
            None => {
                let argument = [Argument::Sines, Argument::Cosines][which];
                let index = angle.joint as u32;
                expr == Expr::Input { argument, index }
            }
        }
    }
}

/// The joint whose position an angle is made of, if that and constants are all.
fn joint_of(program: &Program, angle: Id) -> Option<usize> {
    let mut joint = None;
    let mut open = vec![angle];
    while let Some(id) = open.pop() {
        match program.expr(id) {
            Expr::Const(_) => {}
            Expr::Input {
                argument: Argument::Positions,
                index,
            } if joint.is_none_or(|joint| joint == index as usize) => joint = Some(index as usize),
            Expr::Add(..) | Expr::Sub(..) | Expr::Mul(..) | Expr::Neg(_) => {
                open.extend(operands(program.expr(id)));
            }
            _ => return None,
        }
    }
    joint
}

/// A program of some of the values of another.
pub(super) fn values(program: &Program, outputs: &[Id]) -> Program {
    let mut values = program.clone();
    values.shape = Shape::Vector(outputs.len());
    values.sections.clear();
    values.keep(outputs.to_vec());
    values
}
