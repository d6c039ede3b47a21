//! Rounding bounds, proven over the joint limits.
//!
//! Forward error analysis with intervals: node by node, an enclosure of the
//! exact value and a bound on |computed − exact|. Scalars alone would lose a
//! factor √2 with every rotation, so vectors that the graph knows to be sums of
//! orthogonal images are analysed as vectors:
//!
//! ```text
//! E(v) ≤ Σ_from E + ‖rounding made on the way‖₂
//! ```
//!
//! because an exact rotation neither stretches an error nor shrinks it. The
//! result grows linearly with the depth of the tree.
//!
//! Standard model of arithmetic: `fl(a ∘ b) = (a ∘ b)(1 + δ)`, |δ| ≤ u. Sines and
//! cosines are within `KERNEL_ULPS` ulp, as the runtime documents. Constants
//! are correct to `CONSTANT_ULPS`; terms of order u² are covered by a margin.

use std::collections::HashMap;

use crate::expr::{Expr, Id};
use crate::program::{Program, operands};

/// Error of the sine and cosine kernels, in ulp (runtime::trig).
const KERNEL_ULPS: f64 = 1.0;
/// Absolute error of a generated constant, in units of f64's u: an entry of a
/// product of rotations, or an angle, that may be what cancellation left.
const CONSTANT_ULPS: f64 = 40.0;
/// Covers what is quadratic in u: products of errors, and matrices orthogonal up to u.
const MARGIN: f64 = 1.001;
/// Unit roundoff of f64, 2⁻⁵³.
const U64: f64 = 1.1102230246251565e-16;

/// Arithmetic of the generated code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    F64,
    F32,
}

impl Precision {
    /// Unit roundoff u.
    pub fn unit(self) -> f64 {
        match self {
            Precision::F64 => U64,
            Precision::F32 => 5.960464477539063e-8,
        }
    }

    /// Largest angle that the sine and cosine kernels answer, rad (runtime::trig).
    pub fn largest_angle(self) -> f64 {
        match self {
            Precision::F64 => 1_048_576.0,
            Precision::F32 => 1024.0,
        }
    }
}

/// What one element of an input array may be.
#[derive(Debug, Clone, Copy)]
pub struct Input {
    pub lower: f64,
    pub upper: f64,
    /// Error of its f64 value, in units of u times this.
    pub ulps_of: f64,
    /// Whether it is rounded to the working precision on the way in.
    pub rounded: bool,
}

impl Input {
    /// An input that is what it is: a joint position.
    pub fn exact(lower: f64, upper: f64) -> Input {
        Input {
            lower,
            upper,
            ulps_of: 0.0,
            rounded: false,
        }
    }
}

/// The result of the analysis.
#[derive(Debug, Clone)]
pub struct Bound {
    /// Bound on |computed − exact| of each output.
    pub outputs: Vec<f64>,
    /// Largest of them.
    pub worst: f64,
}

/// Enclosure and error of a node.
#[derive(Debug, Clone, Copy)]
struct Range {
    lower: f64,
    upper: f64,
    error: f64,
}

impl Range {
    /// Largest magnitude of the computed value.
    fn size(self) -> f64 {
        libm::fabs(self.lower).max(libm::fabs(self.upper)) + self.error
    }
}

/// Bound the rounding error of `program` for inputs in the given ranges.
pub fn prove(program: &Program, inputs: &[Vec<Input>], precision: Precision) -> Bound {
    let mut analysis = Analysis {
        program,
        inputs,
        u: precision.unit(),
        domain: precision.largest_angle(),
        ranges: Vec::with_capacity(program.nodes.len()),
        vector_errors: vec![0.0; program.vectors.len()],
        negatives: HashMap::new(),
    };
    analysis.run();
    let outputs: Vec<f64> = program
        .outputs
        .iter()
        .map(|id| analysis.ranges[id.index()].error * MARGIN)
        .collect();
    Bound {
        worst: outputs.iter().copied().fold(0.0, f64::max),
        outputs,
    }
}

struct Analysis<'p> {
    program: &'p Program,
    inputs: &'p [Vec<Input>],
    u: f64,
    /// Largest angle of the sine and cosine kernels, rad.
    domain: f64,
    ranges: Vec<Range>,
    vector_errors: Vec<f64>,
    /// The negative of a node, where one exists.
    negatives: HashMap<Id, usize>,
}

impl Analysis<'_> {
    /// Nodes in order; a vector is settled as soon as everything it rests on is.
    fn run(&mut self) {
        let program = self.program;
        let last = |ids: &[Id]| ids.iter().map(|id| id.index() + 1).max().unwrap_or(0);
        let mut ready: Vec<usize> = Vec::with_capacity(program.vectors.len());
        for vector in &program.vectors {
            let sources = vector
                .from
                .iter()
                .map(|&from| ready[from.0 as usize].max(last(&program.vector(from).entries)));
            ready.push(sources.fold(last(&vector.entries), usize::max));
        }
        let mut settled: Vec<Vec<usize>> = vec![Vec::new(); program.nodes.len() + 1];
        for (v, &at) in ready.iter().enumerate() {
            settled[at].push(v);
        }
        let mut products: Vec<Vec<usize>> = vec![Vec::new(); program.nodes.len() + 1];
        for (p, product) in program.products.iter().enumerate() {
            let factors = product.factors.map(|v| ready[v.0 as usize]);
            let at = factors[0].max(factors[1]).max(product.entry.index() + 1);
            products[at].push(p);
        }
        for done in 0..=program.nodes.len() {
            for &v in &settled[done] {
                self.settle(v);
            }
            for &p in &products[done] {
                self.multiply_out(p);
            }
            if let Some(node) = program.nodes.get(done) {
                let range = self.step(node.expr, |id| self.ranges[id.index()]);
                if let Expr::Neg(x) = node.expr {
                    self.negatives.insert(x, self.ranges.len());
                }
                self.ranges.push(range);
            }
        }
    }

    /// One operation on enclosed operands.
    fn step(&self, expr: Expr, operand: impl Fn(Id) -> Range) -> Range {
        let u = self.u;
        let rounded = |lower: f64, upper: f64, carried: f64| {
            let size = libm::fabs(lower).max(libm::fabs(upper));
            Range {
                lower,
                upper,
                error: carried + u * (size + carried),
            }
        };
        match expr {
            Expr::Const(x) => {
                // Zeros, ones and their like are exact in every precision.
                let simple = x == 0.0 || libm::fabs(x) == 1.0 || x == libm::rint(x);
                let own = if simple { 0.0 } else { CONSTANT_ULPS * U64 };
                let narrowed = if f64::from(x as f32) == x { 0.0 } else { u };
                Range {
                    lower: x,
                    upper: x,
                    error: own + libm::fabs(x) * narrowed,
                }
            }
            Expr::Input { array, index } => {
                let input = self.inputs[array as usize][index as usize];
                let size = libm::fabs(input.lower).max(libm::fabs(input.upper));
                let narrowed = if input.rounded { u * size } else { 0.0 };
                Range {
                    lower: input.lower,
                    upper: input.upper,
                    error: input.ulps_of * U64 + narrowed,
                }
            }
            Expr::Add(a, b) => {
                let (a, b) = (operand(a), operand(b));
                rounded(a.lower + b.lower, a.upper + b.upper, a.error + b.error)
            }
            Expr::Sub(a, b) => {
                let (a, b) = (operand(a), operand(b));
                rounded(a.lower - b.upper, a.upper - b.lower, a.error + b.error)
            }
            Expr::Mul(a, b) => {
                let (a, b) = (operand(a), operand(b));
                let corners = [
                    a.lower * b.lower,
                    a.lower * b.upper,
                    a.upper * b.lower,
                    a.upper * b.upper,
                ];
                let carried = a.size() * b.error + (b.size() - b.error) * a.error;
                rounded(
                    corners.iter().copied().fold(f64::INFINITY, f64::min),
                    corners.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                    carried,
                )
            }
            Expr::Neg(a) => {
                let a = operand(a);
                Range {
                    lower: -a.upper,
                    upper: -a.lower,
                    error: a.error,
                }
            }
            // |sin'| ≤ 1; an ulp of a value below one is at most u.
            Expr::Sin(a) | Expr::Cos(a) => Range {
                lower: -1.0,
                upper: 1.0,
                // Beyond their domain the kernels answer NaN: nothing is proven.
                error: if operand(a).size() > self.domain {
                    f64::INFINITY
                } else {
                    operand(a).error + KERNEL_ULPS * u
                },
            },
        }
    }

    /// Error of vector `v` as a vector, then of its entries.
    fn settle(&mut self, v: usize) {
        let vector = &self.program.vectors[v];
        let mut sources: HashMap<Id, Range> = HashMap::new();
        let mut inherited = 0.0;
        for &from in &vector.from {
            let error = self.vector_errors[from.0 as usize];
            inherited += error;
            for &id in &self.program.vector(from).entries {
                if self.has_other_roles(id) {
                    continue;
                }
                let size = self.ranges[id.index()].size();
                // Computed values, taken as exact starting points.
                let exact = Range {
                    lower: -size,
                    upper: size,
                    error: 0.0,
                };
                sources.insert(id, exact);
            }
        }
        let mut squares = 0.0;
        for &id in &vector.entries {
            let local = self.local(id, &mut sources);
            squares += local * local;
        }
        let error = inherited + libm::sqrt(squares);
        self.vector_errors[v] = error;
        for &id in &vector.entries {
            self.tighten(id, error, vector.norm);
        }
    }

    /// Whether a vector's entry may also be a weight of the map: a sine, a
    /// cosine, a constant, an input. Its error as a weight must not vanish, so
    /// it is no exact starting point; its error then counts twice.
    fn has_other_roles(&self, id: Id) -> bool {
        let leaf = matches!(
            self.program.expr(id),
            Expr::Const(_) | Expr::Input { .. } | Expr::Sin(_) | Expr::Cos(_)
        );
        leaf || self.program.weights.contains(&id)
    }

    /// What is known of a node holds for its negative too.
    fn tighten(&mut self, id: Id, error: f64, norm: f64) {
        let negative = self.negatives.get(&id).copied();
        for k in [Some(id.index()), negative].into_iter().flatten() {
            let range = &mut self.ranges[k];
            range.error = range.error.min(error);
            range.lower = range.lower.max(-norm);
            range.upper = range.upper.min(norm);
        }
    }

    /// Rounding made between the sources and node `id`.
    fn local(&self, id: Id, sources: &mut HashMap<Id, Range>) -> f64 {
        let mut stack = vec![id];
        while let Some(&top) = stack.last() {
            if sources.contains_key(&top) {
                stack.pop();
                continue;
            }
            let expr = self.program.expr(top);
            let leaf = matches!(
                expr,
                Expr::Const(_) | Expr::Input { .. } | Expr::Sin(_) | Expr::Cos(_)
            );
            let missing: Vec<Id> = operands(expr)
                .filter(|x| !leaf && !sources.contains_key(x))
                .collect();
            if missing.is_empty() {
                let range = match leaf {
                    true => self.ranges[top.index()],
                    false => {
                        let mut range = self.step(expr, |x| sources[&x]);
                        // What is known of the node globally holds here too.
                        let known = self.ranges[top.index()];
                        range.lower = range.lower.max(known.lower - known.error);
                        range.upper = range.upper.min(known.upper + known.error);
                        range
                    }
                };
                sources.insert(top, range);
                stack.pop();
            } else {
                stack.extend(missing);
            }
        }
        sources[&id].error
    }

    /// Error of a scalar product of two known vectors.
    fn multiply_out(&mut self, p: usize) {
        let product = self.program.products[p];
        let [a, b] = product.factors;
        let (va, vb) = (self.program.vector(a), self.program.vector(b));
        let (ea, eb) = (
            self.vector_errors[a.0 as usize],
            self.vector_errors[b.0 as usize],
        );
        let mut sources: HashMap<Id, Range> = HashMap::new();
        for &id in va.entries.iter().chain(&vb.entries) {
            if self.has_other_roles(id) {
                continue;
            }
            let known = self.ranges[id.index()];
            let exact = Range {
                lower: known.lower - known.error,
                upper: known.upper + known.error,
                error: 0.0,
            };
            sources.insert(id, exact);
        }
        let local = self.local(product.entry, &mut sources);
        let error = va.norm * eb + vb.norm * ea + ea * eb + local;
        let limit = va.norm * vb.norm;
        self.tighten(product.entry, error, limit);
    }
}
