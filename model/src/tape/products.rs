//! The steps of one posture: products and sums as one operation, in the order in which they are
//! waited for.
//!
//! ```text
//! z = x y + w        a b = a b + (−0),   a + b = a · 1 + b,   a − b = b · (−1) + a
//! ```
//!
//! A product that one sum alone uses is part of it. It is rounded before the sum, and products
//! with ±1 are exact: the bits are those of the steps one by one. As everything but angles,
//! sines and a few others is that one operation, a loop walks it without a branch; what most
//! steps are made of goes first, so that many are under way that do not wait for each other.

use std::cmp::Reverse;

use super::lowering::{About, Lowering, PARTS};
use super::sources::{RegisterFill, inputs};
use super::step::Step;
use crate::expr::Expr;
use crate::program::Program;

/// All steps of a program, on places.
pub(super) struct Steps {
    pub parts: [Vec<Step>; PARTS],
    /// Constants in their places, zero elsewhere.
    pub initial: Vec<f64>,
    pub outputs: Vec<usize>,
}

impl Steps {
    /// Inputs stand in the first places, constants among the `sources` behind them.
    pub(super) fn new(program: &Program, sources: &[RegisterFill]) -> Steps {
        let mut lowering = Lowering::new(program);
        for (id, node) in program.iter() {
            lowering.lower(id, node.expr);
        }
        lowering.placed(sources)
    }
}

impl Lowering<'_> {
    /// How many steps behind each other are made of each value.
    fn heights(&self) -> Vec<usize> {
        let mut height = vec![0; self.about.len()];
        for step in self.steps.iter().rev() {
            let own = step.results().map(|to| height[to]).max().unwrap_or(0);
            for of in step.operands() {
                height[of] = height[of].max(own + 1);
            }
            for to in step.results() {
                height[to] = own;
            }
        }
        height
    }

    /// Steps in their order, with a place for every value: taken again once a value is dead.
    fn placed(mut self, sources: &[RegisterFill]) -> Steps {
        let about = &self.about;
        let first = |step: &Step| step.results().next().unwrap_or_default();
        let height = self.heights();
        self.steps.sort_by_key(|step| {
            let About { part, phase, .. } = about[first(step)];
            (part, phase, Reverse(height[first(step)]))
        });
        let mut left = vec![0usize; self.about.len()];
        let outputs = self.program.outputs.iter().map(|id| id.index());
        for value in self
            .steps
            .iter()
            .flat_map(|step| step.operands())
            .chain(outputs)
        {
            left[value] += 1;
        }
        let mut places: Vec<Option<usize>> = vec![None; self.about.len()];
        let inputs = inputs(self.program);
        let mut initial = vec![0.0; inputs.last().map_or(0, |last| last.end)];
        let computed = |expr| !matches!(expr, Expr::Const(_) | Expr::Input { .. });
        let nodes = self.program.iter().filter(|(_, node)| !computed(node.expr));
        for ((id, _), source) in nodes.zip(sources) {
            places[id.index()] = Some(match *source {
                RegisterFill::Const(x) => {
                    initial.push(x);
                    initial.len() - 1
                }
                RegisterFill::Input { array, index } => inputs[array].start + index,
            });
            // Never free: one use more than there are.
            left[id.index()] += 1;
        }
        for (value, x) in &self.constants {
            places[*value] = Some(initial.len());
            initial.push(*x);
            left[*value] += 1;
        }
        let mut free = Vec::new();
        let mut parts: [Vec<Step>; PARTS] = Default::default();
        for step in &self.steps {
            for to in step.results() {
                places[to] = Some(free.pop().unwrap_or_else(|| {
                    initial.push(0.0);
                    initial.len() - 1
                }));
            }
            let place = |value: usize| places[value].expect("operands come before their users");
            parts[self.about[first(step)].part].push(step.placed(place));
            for value in step.operands() {
                left[value] -= 1;
                if left[value] == 0 {
                    free.extend(places[value]);
                }
            }
            for to in step.results().filter(|to| left[*to] == 0) {
                free.extend(places[to]);
            }
        }
        let outputs = self.program.outputs.iter();
        let outputs = outputs.map(|id| places[id.index()].expect("outputs are live"));
        Steps {
            parts,
            outputs: outputs.collect(),
            initial,
        }
    }
}
