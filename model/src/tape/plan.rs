//! The steps of a program in its own order, with a register for every value.

use std::ops::Range;

use super::SHORT;
use super::sources::inputs;
use super::sums::{Sum, Way, ways};
use crate::expr::{Expr, Id};
use crate::program::{Node, Program, operands};

/// An operation on two numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Pow,
    Max,
}

/// A step on registers. What it makes goes to registers that it does not read.
#[derive(Debug, Clone, Copy)]
pub(super) enum Step {
    Binary(Binary, u32, [u32; 2]),
    Neg(u32, u32),
    Clamp(u32, u32),
    /// Sine and cosine of an angle.
    SinCos([u32; 2], u32),
    /// The sum of `x y` and `w`.
    Product(Sum, u32, [u32; 3]),
    /// The sum of `x c` and `y s`.
    Products(Sum, u32, [u32; 4]),
    /// The same, and the sum of `x s` and `y c`.
    Turn([Sum; 2], [u32; 2], [u32; 4]),
    /// Outputs from this one on, as many as [`Plan::columns`] says, go to their rows.
    Write(usize),
}

/// Steps, and where their values stand.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    /// The registers of each input array: the first, each array in one piece.
    pub inputs: Vec<Range<usize>>,
    /// Those of them that a step reads or an output is.
    pub is_read: Vec<bool>,
    /// Values of the registers behind.
    pub constants: Vec<f64>,
    pub steps: Vec<Step>,
    /// Outputs that are written together.
    pub columns: usize,
    pub registers: usize,
    /// Register of each output.
    pub outputs: Vec<usize>,
    /// What each output is multiplied by: −1 where it is the negative of its register.
    pub signs: Vec<f64>,
}

/// Which nodes are negatives that only outputs use: they are made where rows are written.
fn late(program: &Program) -> Vec<bool> {
    let mut left: Vec<usize> = program.nodes.iter().map(|node| node.uses).collect();
    for id in &program.outputs {
        left[id.index()] -= 1;
    }
    let is_late = |(node, left): (&Node, usize)| matches!(node.expr, Expr::Neg(_)) && left == 0;
    program.nodes.iter().zip(left).map(is_late).collect()
}

/// Outputs that are written together as soon as all of them are known: a line of the cache, so
/// that their registers are free again while the first cache still holds them.
struct Groups {
    /// The first output of each; the last group ends with the row.
    starts: Vec<usize>,
    columns: usize,
    /// Values of each that are still unknown.
    unknown: Vec<usize>,
    /// The groups of each node.
    of: Vec<Vec<usize>>,
}

impl Groups {
    /// Groups of outputs that stand in the registers of these nodes.
    fn new(outputs: &[Id], nodes: usize) -> Groups {
        let columns = outputs.len().min(SHORT);
        let last = outputs.len() - columns;
        let whole = (0..last).step_by(columns.max(1));
        let starts: Vec<usize> = whole.chain([last]).collect();
        let mut of = vec![Vec::new(); nodes];
        for (group, start) in starts.iter().enumerate() {
            for id in &outputs[*start..][..columns] {
                of[id.index()].push(group);
            }
        }
        Groups {
            unknown: vec![columns; starts.len()],
            starts,
            columns,
            of,
        }
    }

    /// The groups of which nothing is unknown any more, once `id` is known.
    fn known(&mut self, id: Id) -> Vec<usize> {
        let mut done = Vec::new();
        for &group in &self.of[id.index()] {
            self.unknown[group] -= 1;
            if self.unknown[group] == 0 {
                done.push(self.starts[group]);
            }
        }
        done
    }
}

/// Registers of values, taken again once a value is dead.
struct Registers {
    of: Vec<Option<usize>>,
    /// Uses of each value that are still to come.
    left: Vec<usize>,
    free: Vec<usize>,
    count: usize,
}

impl Registers {
    /// Those of inputs and constants, which are never free: they have one use more than there
    /// are.
    fn new(program: &Program, inputs: &[Range<usize>], groups: &Groups) -> (Registers, Vec<f64>) {
        let mut of = vec![None; program.nodes.len()];
        let mut left: Vec<usize> = program.nodes.iter().map(|node| node.uses).collect();
        for id in &program.outputs {
            left[id.index()] -= 1;
        }
        for (left, groups) in left.iter_mut().zip(&groups.of) {
            *left += groups.len();
        }
        // Negatives that are made where rows are written have no step that lets go.
        for ((_, node), late) in program.iter().zip(late(program)) {
            if let Expr::Neg(of) = node.expr
                && late
            {
                left[of.index()] -= 1;
            }
        }
        let mut count = inputs.last().map_or(0, |last| last.end);
        let mut constants = Vec::new();
        for (id, node) in program.iter() {
            let own = match node.expr {
                Expr::Const(x) => {
                    constants.push(x);
                    count += 1;
                    count - 1
                }
                Expr::Input { argument, index } => {
                    inputs[program.slot(argument)].start + index as usize
                }
                _ => continue,
            };
            of[id.index()] = Some(own);
            left[id.index()] += 1;
        }
        let free = Vec::new();
        let registers = Registers {
            of,
            left,
            free,
            count,
        };
        (registers, constants)
    }

    fn take(&mut self) -> usize {
        self.free.pop().unwrap_or_else(|| {
            self.count += 1;
            self.count - 1
        })
    }

    /// A register for the value of a node.
    fn make(&mut self, id: Id) -> u32 {
        let own = self.take();
        self.of[id.index()] = Some(own);
        short(own)
    }

    fn at(&self, id: Id) -> u32 {
        short(self.of[id.index()].expect("operands come before their users"))
    }

    /// The step of a node by itself.
    fn alone(&mut self, id: Id, expr: Expr) -> Option<Step> {
        let (operation, a, b) = match expr {
            Expr::Add(a, b) => (Binary::Add, a, b),
            Expr::Sub(a, b) => (Binary::Sub, a, b),
            Expr::Mul(a, b) => (Binary::Mul, a, b),
            Expr::Div(a, b) => (Binary::Div, a, b),
            Expr::Pow(a, b) => (Binary::Pow, a, b),
            Expr::Max(a, b) => (Binary::Max, a, b),
            Expr::Neg(a) => return Some(Step::Neg(self.make(id), self.at(a))),
            Expr::Clamp(a) => return Some(Step::Clamp(self.make(id), self.at(a))),
            Expr::Const(_) | Expr::Input { .. } | Expr::Sin(_) | Expr::Cos(_) => return None,
        };
        Some(Step::Binary(
            operation,
            self.make(id),
            [self.at(a), self.at(b)],
        ))
    }

    /// The step of a sine and a cosine, when the first of them is met.
    fn sines(&mut self, pair: [Option<Id>; 2], angle: Id) -> Option<Step> {
        let known = |id: &Id| self.of[id.index()].is_some();
        if pair.iter().flatten().any(known) {
            return None;
        }
        let to = [self.take(), self.take()];
        for (node, own) in pair.into_iter().zip(to) {
            match node {
                Some(node) => self.of[node.index()] = Some(own),
                None => self.free.push(own),
            }
        }
        Some(Step::SinCos(to.map(short), self.at(angle)))
    }

    fn release_all(&mut self, ids: &[Id]) {
        ids.iter().for_each(|id| self.release(*id));
    }

    fn release(&mut self, id: Id) {
        let left = &mut self.left[id.index()];
        *left -= 1;
        if *left == 0 {
            self.free.extend(self.of[id.index()]);
        }
    }
}

/// A register in 32 bits: half the memory of steps.
fn short(k: usize) -> u32 {
    u32::try_from(k).expect("fewer than 2^32 values")
}

impl Plan {
    /// Assign registers in the order of the program: each value is used soon.
    pub(super) fn new(program: &Program) -> Plan {
        let (inputs, ways, late) = (inputs(program), ways(program), late(program));
        let output = |id: &Id| match program.expr(*id) {
            Expr::Neg(of) if late[id.index()] => (of, -1.0),
            _ => (*id, 1.0),
        };
        let (made, signs): (Vec<Id>, Vec<f64>) = program.outputs.iter().map(output).unzip();
        let mut groups = Groups::new(&made, program.nodes.len());
        let pairs = program.angles();
        let (mut registers, constants) = Registers::new(program, &inputs, &groups);
        let mut steps = Vec::new();
        let mut outputs = vec![0; made.len()];
        let mut write = |id: Id, registers: &mut Registers, steps: &mut Vec<Step>| {
            for start in groups.known(id) {
                steps.push(Step::Write(start));
                let columns = start..start + groups.columns;
                for (place, id) in outputs[columns.clone()].iter_mut().zip(&made[columns]) {
                    *place = registers.at(*id) as usize;
                    registers.release(*id);
                }
            }
        };
        for (id, node) in program.iter() {
            if late[id.index()] {
                continue;
            }
            let way = ways[id.index()];
            // The destination is taken before operands are released: no step overwrites what it
            // reads.
            steps.extend(match way {
                Way::Inside => None,
                Way::Alone => match node.expr {
                    Expr::Sin(angle) | Expr::Cos(angle) => {
                        let (sin, cos) = pairs[&angle];
                        registers.sines([sin, cos], angle)
                    }
                    expr => registers.alone(id, expr),
                },
                Way::Product(sum, of) => {
                    let of = of.map(|of| registers.at(of));
                    Some(Step::Product(sum, registers.make(id), of))
                }
                Way::Products(sum, of) => {
                    let of = of.map(|of| registers.at(of));
                    Some(Step::Products(sum, registers.make(id), of))
                }
                Way::Turn(sums, second, of) => {
                    let of = of.map(|of| registers.at(of));
                    let to = [id, second].map(|id| registers.make(id));
                    Some(Step::Turn(sums, to, of))
                }
            });
            match way {
                Way::Inside => {}
                Way::Alone => operands(node.expr).for_each(|of| registers.release(of)),
                Way::Product(_, of) => registers.release_all(&of),
                Way::Products(_, of) => registers.release_all(&of),
                Way::Turn(_, _, of) => {
                    registers.release_all(&of);
                    registers.release_all(&of);
                }
            }
            // A value that a step before made is written at its own place.
            write(id, &mut registers, &mut steps);
        }
        let mut is_read = vec![false; inputs.last().map_or(0, |last| last.end)];
        for (id, node) in program.iter() {
            if matches!(node.expr, Expr::Input { .. }) && node.uses > 0 {
                is_read[registers.at(id) as usize] = true;
            }
        }
        Plan {
            columns: groups.columns,
            inputs,
            is_read,
            constants,
            steps,
            registers: registers.count,
            outputs,
            signs,
        }
    }
}
