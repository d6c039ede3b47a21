//! The steps of a program in an order, with a register for every value.

use crate::expr::{Expr, Id};
use crate::program::{Program, operands};

#[derive(Debug, Clone, Copy)]
pub(super) enum Step {
    Add(usize, usize),
    Sub(usize, usize),
    Mul(usize, usize),
    Div(usize, usize),
    Neg(usize),
    Clamp(usize),
    Pow(usize, usize),
    /// Angle; the second destination is the cosine's.
    SinCos(usize),
}

/// What fills a register before any step.
#[derive(Debug, Clone, Copy)]
pub(super) enum RegisterFill {
    Const(f64),
    Input { array: usize, index: usize },
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Instruction {
    pub step: Step,
    pub to: usize,
    /// Second destination, for the cosine.
    pub also: usize,
}

/// Steps, and where their values stand.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub steps: Vec<Instruction>,
    pub registers: usize,
    /// Register of each output.
    pub outputs: Vec<usize>,
}

/// What fills the first registers of every plan, in their order.
pub(super) fn sources(program: &Program) -> Vec<RegisterFill> {
    let source = |(_, node): (Id, &crate::program::Node)| match node.expr {
        Expr::Const(x) => Some(RegisterFill::Const(x)),
        Expr::Input { argument, index } => Some(RegisterFill::Input {
            array: program.slot(argument),
            index: index as usize,
        }),
        _ => None,
    };
    program.iter().filter_map(source).collect()
}

/// Computed nodes in the order of the program: each value is used soon.
pub(super) fn as_written(program: &Program) -> Vec<Id> {
    let computed = |expr| !matches!(expr, Expr::Const(_) | Expr::Input { .. });
    let nodes = program.iter().filter(|(_, node)| computed(node.expr));
    nodes.map(|(id, _)| id).collect()
}

impl Plan {
    /// Assign registers: linear scan over `order`, after those of the sources.
    pub fn new(program: &Program, order: &[Id]) -> Plan {
        let pairs = program.angles();
        let mut left: Vec<usize> = program.nodes.iter().map(|node| node.uses).collect();
        let mut register: Vec<Option<usize>> = vec![None; program.nodes.len()];
        let mut count = 0;
        for (id, node) in program.iter() {
            if matches!(node.expr, Expr::Const(_) | Expr::Input { .. }) {
                register[id.index()] = Some(count);
                // Never free: one use more than there are.
                left[id.index()] += 1;
                count += 1;
            }
        }
        let mut free = Vec::new();
        let mut take = |free: &mut Vec<usize>| {
            free.pop().unwrap_or_else(|| {
                count += 1;
                count - 1
            })
        };
        let mut steps = Vec::with_capacity(order.len());
        for &id in order {
            let (k, node) = (id.index(), &program.nodes[id.index()]);
            let at = |id: Id, register: &[Option<usize>]| {
                register[id.index()].expect("operands come before their users")
            };
            let step = match node.expr {
                Expr::Const(_) | Expr::Input { .. } => continue,
                Expr::Add(a, b) => Step::Add(at(a, &register), at(b, &register)),
                Expr::Sub(a, b) => Step::Sub(at(a, &register), at(b, &register)),
                Expr::Mul(a, b) => Step::Mul(at(a, &register), at(b, &register)),
                Expr::Div(a, b) => Step::Div(at(a, &register), at(b, &register)),
                Expr::Neg(a) => Step::Neg(at(a, &register)),
                Expr::Clamp(a) => Step::Clamp(at(a, &register)),
                Expr::Pow(a, b) => Step::Pow(at(a, &register), at(b, &register)),
                Expr::Sin(a) | Expr::Cos(a) => Step::SinCos(at(a, &register)),
            };
            if let Expr::Sin(a) | Expr::Cos(a) = node.expr {
                if register[k].is_none() {
                    let (sin, cos) = pairs[&a];
                    let (to, also) = (take(&mut free), take(&mut free));
                    for (node, place) in [(sin, to), (cos, also)] {
                        match node {
                            Some(node) => register[node.index()] = Some(place),
                            None => free.push(place),
                        }
                    }
                    steps.push(Instruction { step, to, also });
                }
            } else {
                // The destination is taken before operands are released: no step
                // overwrites what it reads.
                let to = take(&mut free);
                register[k] = Some(to);
                steps.push(Instruction { step, to, also: to });
            }
            for operand in operands(node.expr) {
                left[operand.index()] -= 1;
                if left[operand.index()] == 0 {
                    free.extend(register[operand.index()]);
                }
            }
        }
        Plan {
            outputs: program
                .outputs
                .iter()
                .map(|id| register[id.index()].expect("outputs are live"))
                .collect(),
            steps,
            registers: count,
        }
    }
}
