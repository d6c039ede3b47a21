//! Forward error analysis of one program: enclosures and errors, node by node
//! and vector by vector (see the module above).

use rustc_hash::FxHashMap;

use super::range::{Range, times};
use super::{Arithmetic, CONSTANT_ULPS, Input, KERNEL_UNITS, U64, fixed, operations};
use crate::expr::{Expr, Id};
use crate::program::{Program, operands};

/// The analysis of one program on inputs in given ranges.
struct Analysis<'p> {
    program: &'p Program,
    inputs: &'p [Vec<Input>],
    arithmetic: Arithmetic<'p>,
    ranges: Vec<Range>,
    vector_errors: Vec<f64>,
    vector_norms: Vec<f64>,
    /// The negative of a node, where one exists.
    negatives: FxHashMap<Id, usize>,
    /// Whether a node is computed by operations that cannot round below zero.
    not_negative: Vec<bool>,
}

/// What is known of each node of a program on inputs in given ranges.
pub(super) fn ranges(
    program: &Program,
    inputs: &[Vec<Input>],
    arithmetic: Arithmetic,
) -> Vec<Range> {
    let mut analysis = Analysis {
        program,
        inputs,
        arithmetic,
        ranges: Vec::with_capacity(program.nodes.len()),
        vector_errors: vec![0.0; program.vectors.len()],
        vector_norms: vec![f64::INFINITY; program.vectors.len()],
        negatives: FxHashMap::default(),
        not_negative: Vec::with_capacity(program.nodes.len()),
    };
    analysis.run();
    analysis.ranges
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
            let scale = vector.scale.map_or(0, |id| id.index() + 1);
            ready.push(sources.fold(last(&vector.entries).max(scale), usize::max));
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
                let id = Id(done as u32);
                let mut range = self.step(id, |id| self.ranges[id.index()]);
                if let Some(least) = program.least.get(&id) {
                    range.lower = range.lower.max(*least);
                }
                if let Expr::Neg(x) = node.expr {
                    self.negatives.insert(x, self.ranges.len());
                }
                self.ranges.push(range);
                self.not_negative.push(self.stays_above(node.expr, range));
            }
        }
    }

    /// Whether what is computed for `expr` is zero or more: rounding keeps order,
    /// so sums, products and quotients of such numbers are such numbers.
    fn stays_above(&self, expr: Expr, range: Range) -> bool {
        let above = |id: Id| self.not_negative[id.index()];
        let by_operation = match expr {
            Expr::Const(x) => x >= 0.0,
            Expr::Input { argument, index } => {
                let input = self.inputs[self.program.slot(argument)][index as usize];
                input.lower >= 0.0 && input.ulps_of == 0.0 && input.absolute == 0.0
            }
            Expr::Add(a, b) => (above(a) && above(b)) || self.lifts(a, b) || self.lifts(b, a),
            Expr::Div(a, b) => above(a) && above(b),
            Expr::Mul(a, b) => a == b || (above(a) && above(b)),
            Expr::Clamp(a) | Expr::Pow(a, _) => above(a),
            Expr::Max(a, b) => above(a) || above(b) || self.is_size(a, b),
            Expr::Sub(..) | Expr::Neg(_) | Expr::Sin(_) | Expr::Cos(_) => false,
        };
        by_operation || range.lower - range.error >= 0.0
    }

    /// A clamp is no less than -1, so with 1 or more it is no less than zero.
    fn lifts(&self, clamp: Id, constant: Id) -> bool {
        let exprs = (self.program.expr(clamp), self.program.expr(constant));
        matches!(exprs, (Expr::Clamp(_), Expr::Const(x)) if x >= 1.0)
    }

    /// Whether the larger of the two is a magnitude: one is the negative of the other.
    fn is_size(&self, a: Id, b: Id) -> bool {
        let negative_of = |x: Id, of: Id| self.program.expr(x) == Expr::Neg(of);
        negative_of(a, b) || negative_of(b, a)
    }

    /// Node `id`: one operation on enclosed operands.
    fn step(&self, id: Id, operand: impl Fn(Id) -> Range) -> Range {
        let expr = self.program.expr(id);
        let range = |lower: f64, upper: f64, carried: f64| {
            let size = Range::new(lower, upper, carried).size();
            Range::new(lower, upper, carried + self.rounding(id, size))
        };
        match expr {
            Expr::Const(x) => {
                // Zeros, ones and their like are exact in every precision.
                let simple = x == 0.0 || libm::fabs(x) == 1.0 || x == libm::rint(x);
                let own = if simple { 0.0 } else { CONSTANT_ULPS * U64 };
                let narrowed = match self.arithmetic {
                    Arithmetic::Float { .. } if f64::from(x as f32) == x => 0.0,
                    Arithmetic::Float { precision, .. } => libm::fabs(x) * precision.unit(),
                    Arithmetic::Fixed(formats) => formats.rounding_of_constant(id, x),
                };
                Range::new(x, x, own + narrowed)
            }
            Expr::Input { argument, index } => {
                let input = self.inputs[self.program.slot(argument)][index as usize];
                let narrowed = match self.arithmetic {
                    _ if !input.rounded => 0.0,
                    Arithmetic::Float { precision, .. } => precision.unit() * input.size(),
                    Arithmetic::Fixed(formats) => formats.half_unit(id),
                };
                let error = input.ulps_of * U64 + input.absolute + narrowed;
                Range::new(input.lower, input.upper, error)
            }
            Expr::Add(a, b) => {
                let (a, b) = (operand(a), operand(b));
                range(a.lower + b.lower, a.upper + b.upper, a.error + b.error)
            }
            Expr::Sub(a, b) => {
                let (a, b) = (operand(a), operand(b));
                range(a.lower - b.upper, a.upper - b.lower, a.error + b.error)
            }
            Expr::Mul(a, b) => {
                let (a, b) = (operand(a), operand(b));
                let (lower, upper) = operations::ends([
                    a.lower * b.lower,
                    a.lower * b.upper,
                    a.upper * b.lower,
                    a.upper * b.upper,
                ]);
                let exact = Range::exact(b.lower, b.upper).size();
                let carried = times(a.size(), b.error) + times(exact, a.error);
                range(lower, upper, carried)
            }
            Expr::Neg(a) => {
                let a = operand(a);
                Range::new(-a.upper, -a.lower, a.error)
            }
            // |sin'| ≤ 1.
            Expr::Sin(a) | Expr::Cos(a) => {
                let a = operand(a);
                Range::new(-1.0, 1.0, a.error + self.kernel(a.size()))
            }
            Expr::Clamp(a) => operations::clamped(operand(a)),
            Expr::Max(a, b) => {
                let mut larger = operations::larger(operand(a), operand(b));
                if self.is_size(a, b) {
                    larger.lower = larger.lower.max(0.0);
                }
                larger.error += self.rounding(id, 0.0);
                larger
            }
            Expr::Div(a, b) => operations::quotient(operand(a), operand(b))
                .map_or(operations::UNBOUNDED, |exact| {
                    range(exact.lower, exact.upper, exact.error)
                }),
            Expr::Pow(a, b) => {
                // A maximum with a constant is computed as no less than that.
                let floor = match self.program.expr(a) {
                    Expr::Max(_, b) => match self.program.expr(b) {
                        Expr::Const(x) if x > 0.0 => Some(x),
                        _ => None,
                    },
                    _ => None,
                };
                let floor = floor.or_else(|| self.not_negative[a.index()].then_some(0.0));
                let unit = match self.arithmetic {
                    Arithmetic::Float { precision, .. } => precision.unit(),
                    // Not to be had: refused when formats are chosen.
                    Arithmetic::Fixed(_) => f64::INFINITY,
                };
                operations::power(operand(a), operand(b), floor, unit)
                    .unwrap_or(operations::UNBOUNDED)
            }
        }
    }

    /// What rounding adds to a sum or product of magnitude `size`.
    fn rounding(&self, id: Id, size: f64) -> f64 {
        match self.arithmetic {
            Arithmetic::Float { precision, .. } => precision.unit() * size,
            Arithmetic::Fixed(formats) => formats.rounding(self.program, id),
        }
    }

    /// Error of the sine and cosine of an angle up to `size`, rad.
    fn kernel(&self, size: f64) -> f64 {
        match self.arithmetic {
            // Beyond their domain the kernels answer NaN: nothing is proven.
            Arithmetic::Float { largest_angle, .. } if size > largest_angle => f64::INFINITY,
            Arithmetic::Float { precision, .. } => KERNEL_UNITS * precision.unit(),
            Arithmetic::Fixed(_) => fixed::kernel_error(size),
        }
    }

    /// Error of vector `v` as a vector, then of its entries.
    fn settle(&mut self, v: usize) {
        let vector = &self.program.vectors[v];
        if vector.norm.is_none() && vector.from.is_empty() {
            return self.settle_by_entries(v);
        }
        let mut sources: FxHashMap<Id, Range> = FxHashMap::default();
        let (mut inherited, mut extent) = (0.0, 0.0);
        for &from in &vector.from {
            inherited += self.vector_errors[from.0 as usize];
            extent += self.vector_norms[from.0 as usize];
            for &id in &self.program.vector(from).entries {
                if self.has_other_roles(id) {
                    continue;
                }
                let size = self.ranges[id.index()].size();
                sources.insert(id, Range::exact(-size, size));
            }
        }
        if let Some(scale) = vector.scale {
            let factor = self.ranges[scale.index()];
            let exact = factor.size() - factor.error;
            inherited = times(factor.size(), inherited) + times(extent, factor.error);
            extent = times(exact, extent);
            if !self.has_other_roles(scale) {
                sources.insert(scale, Range::exact(-factor.size(), factor.size()));
            }
        }
        let norm = vector.norm.unwrap_or(extent);
        self.vector_norms[v] = norm;
        let mut squares = 0.0;
        for &id in &vector.entries {
            let local = self.local(id, &mut sources);
            squares += local * local;
        }
        let error = inherited + libm::sqrt(squares);
        self.vector_errors[v] = error;
        for &id in &vector.entries {
            self.tighten(id, error, norm);
        }
    }

    /// A vector of which no more is known than of each entry.
    fn settle_by_entries(&mut self, v: usize) {
        let ranges = self.program.vectors[v].entries.iter();
        let ranges = ranges.map(|id| self.ranges[id.index()]);
        let (mut norm, mut error) = (0.0, 0.0);
        for range in ranges {
            let exact = range.size() - range.error;
            norm += exact * exact;
            error += range.error * range.error;
        }
        self.vector_norms[v] = libm::sqrt(norm);
        self.vector_errors[v] = libm::sqrt(error);
    }

    /// Whether a vector's entry may also be a weight of the map: a sine, a
    /// cosine, a constant, an input. Its error as a weight must not vanish, so
    /// it is no exact starting point; its error then counts twice.
    fn has_other_roles(&self, id: Id) -> bool {
        is_leaf(self.program.expr(id)) || self.program.weights.contains(&id)
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
    fn local(&self, id: Id, sources: &mut FxHashMap<Id, Range>) -> f64 {
        let mut stack = vec![id];
        while let Some(&top) = stack.last() {
            if sources.contains_key(&top) {
                stack.pop();
                continue;
            }
            let expr = self.program.expr(top);
            let leaf = is_leaf(expr);
            let missing: Vec<Id> = operands(expr)
                .filter(|x| !leaf && !sources.contains_key(x))
                .collect();
            if missing.is_empty() {
                let known = self.ranges[top.index()];
                let mut range = known;
                if !leaf {
                    range = self.step(top, |x| sources[&x]);
                    // What is known of the node globally holds here too.
                    range.lower = range.lower.max(known.lower - known.error);
                    range.upper = range.upper.min(known.upper + known.error);
                }
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
        let mut sources: FxHashMap<Id, Range> = FxHashMap::default();
        for &id in va.entries.iter().chain(&vb.entries) {
            if self.has_other_roles(id) {
                continue;
            }
            let known = self.ranges[id.index()];
            let (lower, upper) = (known.lower - known.error, known.upper + known.error);
            sources.insert(id, Range::exact(lower, upper));
        }
        let local = self.local(product.entry, &mut sources);
        let [ea, eb] = product.factors.map(|v| self.vector_errors[v.0 as usize]);
        let [na, nb] = product.factors.map(|v| self.vector_norms[v.0 as usize]);
        let error = times(na, eb) + times(nb, ea) + times(ea, eb) + local;
        let limit = times(na, nb);
        self.tighten(product.entry, error, limit);
    }
}

fn is_leaf(expr: Expr) -> bool {
    let leaf = matches!(expr, Expr::Sin(_) | Expr::Cos(_));
    leaf || operands(expr).next().is_none()
}
