//! From the nodes of a program to steps that multiply and add, each with its part and depth.

use std::collections::HashMap;

use rustc_hash::FxHashMap;

use super::step::{Operation, Step};
use crate::expr::{Expr, Id};
use crate::program::{Node, Program, operands};

/// When a step can be done: angles that no sine is part of, their sines, the rest.
pub(super) const PARTS: usize = 3;
const SINES: usize = 1;
const REST: usize = 2;

/// What is known of a value.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct About {
    pub part: usize,
    /// Products stand in even phases, others in odd ones.
    pub phase: usize,
    /// Steps behind each other that make it.
    depth: usize,
}

pub(super) struct Lowering<'a> {
    pub program: &'a Program,
    pub about: Vec<About>,
    /// Constants that the program has not, and their values.
    pub constants: Vec<(usize, f64)>,
    /// The negative of a value, for a part.
    negated: FxHashMap<(usize, usize), usize>,
    /// Products that are part of a sum.
    inside: Vec<bool>,
    angles: HashMap<Id, (Option<Id>, Option<Id>)>,
    pub steps: Vec<Step>,
}

impl<'a> Lowering<'a> {
    pub(super) fn new(program: &'a Program) -> Lowering<'a> {
        let mut about = vec![About::default(); program.nodes.len()];
        for (part, about) in parts(program).into_iter().zip(&mut about) {
            about.part = part;
        }
        let mut lowering = Lowering {
            program,
            about,
            constants: Vec::new(),
            negated: FxHashMap::default(),
            inside: Vec::new(),
            angles: program.angles(),
            steps: Vec::new(),
        };
        lowering.inside = lowering.sums();
        lowering
    }

    /// Which products only one sum of the same part uses; of two in a sum, the one that is
    /// known later.
    fn sums(&self) -> Vec<bool> {
        let nodes = &self.program.nodes;
        let mut depth = vec![0; nodes.len()];
        let mut inside = vec![false; nodes.len()];
        for (id, node) in self.program.iter() {
            let before = operands(node.expr).map(|operand| depth[operand.index()] + 1);
            depth[id.index()] = before.max().unwrap_or(0);
            let is_free = |of: &Id| {
                let part = self.about[of.index()].part;
                let product = matches!(nodes[of.index()].expr, Expr::Mul(..));
                product && nodes[of.index()].uses == 1 && part == self.about[id.index()].part
            };
            let chosen = match node.expr {
                Expr::Add(a, b) if a != b => {
                    let free = [a, b].into_iter().filter(is_free);
                    free.max_by_key(|of| depth[of.index()])
                }
                Expr::Sub(a, b) if a != b => Some(b).filter(is_free).filter(|b| {
                    // Its negative is had for little: of a factor that others have, too.
                    let Expr::Mul(x, y) = nodes[b.index()].expr else {
                        return false;
                    };
                    self.cheap(x) || self.cheap(y)
                }),
                _ => None,
            };
            if let Some(of) = chosen {
                inside[of.index()] = true;
            }
        }
        inside
    }

    /// Whether many steps have a use for the negative of a value: constants, inputs, sines.
    fn cheap(&self, of: Id) -> bool {
        matches!(
            self.program.nodes[of.index()].expr,
            Expr::Const(_) | Expr::Input { .. } | Expr::Sin(_) | Expr::Cos(_)
        )
    }

    /// The step of a node, and what has to stand before it.
    pub(super) fn lower(&mut self, id: Id, expr: Expr) {
        let (to, part) = (id.index(), self.about[id.index()].part);
        match expr {
            Expr::Const(_) | Expr::Input { .. } => {}
            Expr::Mul(..) if self.inside[to] => {}
            Expr::Mul(a, b) => {
                let zero = self.constant(-0.0);
                self.push(Step::Product([to, a.index(), b.index(), zero]), part);
            }
            Expr::Neg(a) => {
                let (minus, zero) = (self.constant(-1.0), self.constant(-0.0));
                self.push(Step::Product([to, a.index(), minus, zero]), part);
            }
            Expr::Add(a, b) => {
                let [a, b] = match self.inside[b.index()] {
                    true => [b, a],
                    false => [a, b],
                };
                let step = match self.factors(a) {
                    Some([x, y]) => [to, x.index(), y.index(), b.index()],
                    None => {
                        // What is known later comes to the sum alone.
                        let depth = |of: Id| self.about[of.index()].depth;
                        let [a, b] = if depth(a) > depth(b) { [b, a] } else { [a, b] };
                        [to, a.index(), self.constant(1.0), b.index()]
                    }
                };
                self.push(Step::Product(step), part);
            }
            Expr::Sub(a, b) => {
                let step = match self.factors(b) {
                    Some([x, y]) => {
                        let [x, y] = if self.cheap(x) { [x, y] } else { [y, x] };
                        [to, self.negative(x, part), y.index(), a.index()]
                    }
                    None => [to, b.index(), self.constant(-1.0), a.index()],
                };
                self.push(Step::Product(step), part);
            }
            Expr::Div(a, b) => {
                let places = [to, a.index(), b.index()];
                self.push(Step::Other(Operation::Div, places), part);
            }
            Expr::Pow(a, b) => {
                let places = [to, a.index(), b.index()];
                self.push(Step::Other(Operation::Pow, places), part);
            }
            Expr::Max(a, b) => {
                let places = [to, a.index(), b.index()];
                self.push(Step::Other(Operation::Max, places), part);
            }
            Expr::Clamp(a) => {
                let places = [to, a.index(), a.index()];
                self.push(Step::Other(Operation::Clamp, places), part);
            }
            Expr::Sin(angle) | Expr::Cos(angle) => self.sines(id, angle, part),
        }
    }

    /// Sine and cosine of an angle, when the first of them is met.
    fn sines(&mut self, id: Id, angle: Id, part: usize) {
        let (sin, cos) = self.angles[&angle];
        let other = if sin == Some(id) { cos } else { sin };
        if other.is_some_and(|other| other < id) {
            return;
        }
        let [to, also] = [sin, cos].map(|of| of.map(Id::index));
        let [to, also] = [to, also].map(|of| of.unwrap_or_else(|| self.value(part)));
        self.push(
            Step::Other(Operation::SinCos, [to, angle.index(), also]),
            part,
        );
    }

    /// The factors of a product that is part of a sum.
    fn factors(&self, of: Id) -> Option<[Id; 2]> {
        match self.program.nodes[of.index()].expr {
            Expr::Mul(x, y) if self.inside[of.index()] => Some([x, y]),
            _ => None,
        }
    }

    fn negative(&mut self, of: Id, part: usize) -> usize {
        if let Expr::Const(x) = self.program.nodes[of.index()].expr {
            return self.constant(-x);
        }
        if let Some(known) = self.negated.get(&(of.index(), part)) {
            return *known;
        }
        let (minus, zero) = (self.constant(-1.0), self.constant(-0.0));
        let to = self.value(part);
        self.push(Step::Product([to, of.index(), minus, zero]), part);
        self.negated.insert((of.index(), part), to);
        to
    }

    fn constant(&mut self, x: f64) -> usize {
        let mut known = self.constants.iter();
        if let Some((value, _)) = known.find(|(_, own)| own.to_bits() == x.to_bits()) {
            return *value;
        }
        let value = self.value(0);
        self.constants.push((value, x));
        value
    }

    fn value(&mut self, part: usize) -> usize {
        self.about.push(About {
            part,
            ..About::default()
        });
        self.about.len() - 1
    }

    fn push(&mut self, step: Step, part: usize) {
        let before = || step.operands().map(|of| self.about[of]);
        let depth = 1 + before().map(|about| about.depth).max().unwrap_or(0);
        let same = before().filter(|about| about.part == part);
        let first = same.map(|about| about.phase).max().unwrap_or(0);
        let turn = usize::from(matches!(step, Step::Other(..)));
        let phase = first + (first + turn) % 2;
        for of in step.results() {
            self.about[of] = About { part, phase, depth };
        }
        self.steps.push(step);
    }
}

/// The part of each node.
fn parts(program: &Program) -> Vec<usize> {
    // Whether a node is made of sines, and whether sines are made of it.
    let mut made = vec![false; program.nodes.len()];
    for (id, node) in program.iter() {
        let trig = matches!(node.expr, Expr::Sin(_) | Expr::Cos(_));
        made[id.index()] = trig || operands(node.expr).any(|operand| made[operand.index()]);
    }
    let early = |id: Id| !made[id.index()];
    let mut angle = vec![false; program.nodes.len()];
    for (id, node) in program.iter().rev() {
        let asks = matches!(node.expr, Expr::Sin(_) | Expr::Cos(_)) || angle[id.index()];
        for operand in operands(node.expr).filter(|operand| asks && early(*operand)) {
            angle[operand.index()] = true;
        }
    }
    let part = |(id, node): (Id, &Node)| match node.expr {
        _ if angle[id.index()] => 0,
        Expr::Sin(a) | Expr::Cos(a) if early(a) => SINES,
        _ => REST,
    };
    program.iter().map(part).collect()
}
