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
//! 4 per joint and row. They meet in the Jacobian: `J_j = B_p K_j (e_z × t_j)`.

use crate::expr::{Graph, Id, VectorId};
use crate::frames::Twist;
use crate::model::{Function, Given, Model};
use crate::program::{Array, Program, Shape};
use crate::snap::tidy;
use crate::tree::{Coordinate, Motion};

/// Largest multiple of an angle built from its sine and cosine.
const LARGEST_MULTIPLE: f64 = 8.0;

/// A vector of expressions with what is known of it.
#[derive(Clone, Copy)]
struct Known {
    entries: [Id; 3],
    fact: VectorId,
}

pub(crate) fn build(model: &Model, function: Function, given: Given) -> Option<Program> {
    if given == Given::SinesCosines && !sines_suffice(model) {
        return None;
    }
    let mut scratch = Scratch::new(model, given);
    let (rows, cols) = (rows_of(function), columns_of(model, function));
    let outputs = match function {
        Function::Com => scratch.subtrees()[0].v.entries.to_vec(),
        Function::Cop => scratch.subtrees()[0].v.entries[..2].to_vec(),
        Function::ComJacobian => scratch.jacobian(&[0, 1, 2], false),
        Function::GravityMoments => scratch.jacobian(&[2], true),
        Function::Regressor => scratch.regressor(&[0, 1, 2]),
        Function::RegressorCop => scratch.regressor(&[0, 1]),
        Function::RegressorFull => scratch.regressor_full(),
    };
    let shape = match (rows, cols) {
        (1, n) => Shape::Vector(n),
        (rows, cols) => Shape::Matrix { rows, cols },
    };
    let inputs = arrays(model, function, given);
    Some(Program::new(scratch.g, inputs, shape, &outputs))
}

/// The input arrays of a function.
fn arrays(model: &Model, function: Function, given: Given) -> Vec<Array> {
    let names: &[&'static str] = match given {
        Given::Positions => &["q"],
        Given::SinesCosines => &["sin", "cos"],
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
    arrays
}

/// ∂CoM/∂q by the chain rule on the expressions of the CoM itself, row-major.
///
/// Costs more operations than [`Function::ComJacobian`], which knows the
/// geometry; it is there to check it.
pub fn differentiate_com(model: &Model) -> Program {
    let mut scratch = Scratch::new(model, Given::Positions);
    let com = scratch.subtrees()[0].v.entries;
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

fn rows_of(function: Function) -> usize {
    match function {
        Function::ComJacobian | Function::Regressor | Function::RegressorFull => 3,
        Function::RegressorCop => 2,
        _ => 1,
    }
}

fn columns_of(model: &Model, function: Function) -> usize {
    match function {
        Function::Com => 3,
        Function::Cop => 2,
        Function::ComJacobian | Function::GravityMoments => model.dof(),
        Function::Regressor | Function::RegressorCop => model.base.params.len(),
        Function::RegressorFull => model.chain.full_params,
    }
}

/// Whether every angle is a whole multiple of a joint's own.
fn sines_suffice(model: &Model) -> bool {
    model.frames.iter().all(|frame| {
        frame.turn.as_ref().is_none_or(|turn| {
            let times = libm::fabs(turn.angle.factor);
            times == libm::rint(times) && times <= LARGEST_MULTIPLE
        })
    })
}

/// A body's subtree: what it carries, in three frames.
struct Subtree {
    /// In its own canonical axes.
    v: Known,
    /// Turned by its joint.
    t: Known,
}

struct Scratch<'m> {
    m: &'m Model,
    g: Graph,
    given: Given,
    children: Vec<Vec<usize>>,
    /// Sine and cosine per body, once asked for.
    turns: Vec<Option<(Id, Id)>>,
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl<'m> Scratch<'m> {
    fn new(m: &'m Model, given: Given) -> Self {
        Scratch {
            m,
            g: Graph::default(),
            given,
            children: m.chain.children(),
            turns: vec![None; m.chain.bodies.len()],
        }
    }

    /// The input array that holds r.
    fn parameter(&mut self, index: Option<usize>) -> Id {
        let array = match self.given {
            Given::Positions => 1,
            Given::SinesCosines => 2,
        };
        match index {
            Some(index) => self.g.input(array, index),
            None => self.g.constant(0.0),
        }
    }

    /// Position of a slide: factor·q + offset. (`_sc` passes q in `sin`.)
    fn position(&mut self, by: &Coordinate) -> Id {
        let q = self.g.input(0, by.dof);
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

    /// Sine and cosine of the angle that turns `body`.
    fn turn(&mut self, body: usize) -> (Id, Id) {
        if let Some(pair) = self.turns[body] {
            return pair;
        }
        let angle = self.m.frames[body]
            .turn
            .as_ref()
            .expect("asked of turning bodies")
            .angle;
        let key = &self.m.keys[body];
        let pair = match self.given {
            Given::Positions => self.turn_from_position(&angle, key),
            Given::SinesCosines => self.turn_from_sines(&angle, key),
        };
        self.turns[body] = Some(pair);
        pair
    }

    fn turn_from_position(&mut self, angle: &Coordinate, key: &str) -> (Id, Id) {
        let (quarters, rest) = quarters(angle.offset);
        // sin(−x + δ) = −sin(x − δ): joints that turn backwards share their sines.
        let sign = if angle.factor < 0.0 { -1.0 } else { 1.0 };
        let by = Coordinate {
            dof: angle.dof,
            factor: sign * angle.factor,
            offset: sign * rest,
        };
        let x = self.position(&by);
        let (s, c) = (self.g.sin(x), self.g.cos(x));
        self.g.name(s, || format!("s_{key}"));
        self.g.name(c, || format!("c_{key}"));
        let s = if sign < 0.0 { self.g.neg(s) } else { s };
        self.quarter_turns(s, c, quarters)
    }

    fn turn_from_sines(&mut self, angle: &Coordinate, key: &str) -> (Id, Id) {
        let (quarters, rest) = quarters(angle.offset);
        let own = (self.g.input(0, angle.dof), self.g.input(1, angle.dof));
        let (mut s, mut c) = own;
        for _ in 1..libm::fabs(angle.factor) as usize {
            (s, c) = self.sum_of_angles((s, c), own);
        }
        if angle.factor < 0.0 {
            s = self.g.neg(s);
        }
        if rest != 0.0 {
            let (sin, cos) = libm::sincos(rest);
            let constant = (self.g.constant(sin), self.g.constant(cos));
            (s, c) = self.sum_of_angles((s, c), constant);
            self.g.name(s, || format!("s_{key}"));
            self.g.name(c, || format!("c_{key}"));
        }
        self.quarter_turns(s, c, quarters)
    }

    fn sum_of_angles(&mut self, a: (Id, Id), b: (Id, Id)) -> (Id, Id) {
        let s = self.g.dot(&[a.0, a.1], &[b.1, b.0]);
        let (cc, ss) = (self.g.mul(a.1, b.1), self.g.mul(a.0, b.0));
        (s, self.g.sub(cc, ss))
    }

    fn quarter_turns(&mut self, s: Id, c: Id, quarters: i64) -> (Id, Id) {
        match quarters {
            0 => (s, c),
            1 => (c, self.g.neg(s)),
            2 => (self.g.neg(s), self.g.neg(c)),
            _ => (self.g.neg(c), s),
        }
    }

    fn name(&mut self, vector: &[Id; 3], prefix: &str, body: usize) {
        for (id, axis) in vector.iter().zip(AXES) {
            let key = &self.m.keys[body];
            self.g.name(*id, || format!("{prefix}_{key}_{axis}"));
        }
    }

    /// `K x`, or with `transposed` the row `xᵀ K` (a reflection is symmetric).
    fn twist(&mut self, twist: &Twist, x: [Id; 3], transposed: bool) -> [Id; 3] {
        match twist {
            Twist::Sparse(k) => [0, 1, 2].map(|m| {
                let weights = [0, 1, 2].map(|n| {
                    let entry = if transposed { k[(n, m)] } else { k[(m, n)] };
                    self.g.constant(entry)
                });
                self.g.dot(&weights, &x)
            }),
            Twist::Reflection { u, k } => {
                // Where the entry that u weighs with one is absent, k joins the others.
                let free = (0..3).any(|n| u[n] == 1.0 && self.g.value(x[n]) != Some(0.0));
                let (inner, outer) = if free { (1.0, *k) } else { (*k, 1.0) };
                let weights = [0, 1, 2].map(|n| self.g.constant(inner * u[n]));
                let along = self.g.dot(&weights, &x);
                let outer = self.g.constant(outer);
                let along = self.g.mul(outer, along);
                [0, 1, 2].map(|n| {
                    let weight = self.g.constant(u[n]);
                    let step = self.g.mul(weight, along);
                    self.g.sub(x[n], step)
                })
            }
        }
    }

    /// `v_i` and `t_i` of every body, leaf to root.
    fn subtrees(&mut self) -> Vec<Subtree> {
        let bodies = &self.m.chain.bodies;
        let mut built: Vec<Option<Subtree>> = bodies.iter().map(|_| None).collect();
        for i in (0..bodies.len()).rev() {
            self.section(i);
            let v = self.carried(i, &built);
            let t = match &self.m.frames[i].turn {
                None => v,
                Some(turn) => {
                    let (s, c) = self.turn(i);
                    let [x, y, z] = v.entries;
                    let y = if turn.mirrored { self.g.neg(y) } else { y };
                    let (cx, sy) = (self.g.mul(c, x), self.g.mul(s, y));
                    let (sx, cy) = (self.g.mul(s, x), self.g.mul(c, y));
                    let entries = [self.g.sub(cx, sy), self.g.add(sx, cy), z];
                    self.name(&entries, "t", i);
                    let norm = self.norm(v.fact);
                    Known {
                        entries,
                        fact: self.g.know(&entries, norm, &[v.fact]),
                    }
                }
            };
            built[i] = Some(Subtree { v, t });
        }
        built.into_iter().flatten().collect()
    }

    fn norm(&self, fact: VectorId) -> f64 {
        self.g.vectors[fact.0 as usize].norm
    }

    /// `v_i = r_i + Σ_children`, in the canonical axes of body `i`.
    fn carried(&mut self, i: usize, built: &[Option<Subtree>]) -> Known {
        let m = self.m;
        let own = [0, 1, 2].map(|k| m.axis_param(i, k));
        let mut sum = own.map(|index| self.parameter(index));
        let cad = |index: Option<usize>| index.map_or(0.0, |k| m.base.params[k].cad);
        let mut norm = libm::sqrt(own.iter().map(|&k| cad(k) * cad(k)).sum());
        let mut from = Vec::new();
        for c in self.children[i].clone() {
            let child = built[c]
                .as_ref()
                .expect("children are built before parents");
            let (t, v) = (child.t, child.v);
            let mut entries = t.entries;
            let mut extent = self.norm(v.fact);
            if let Some(turn) = &m.frames[c].turn {
                entries = self.twist(&turn.twist, entries, false);
                self.name(&entries, "w", c);
            }
            if let Motion::Slide { axis, by } = m.chain.bodies[c].motion {
                let s = m.slide_param(c);
                let position = self.position(&by);
                let mass = self.parameter(s);
                let moved = self.g.mul(position, mass);
                let axis = (m.axes(i).transpose() * axis).map(tidy);
                for k in 0..3 {
                    let weight = self.g.constant(axis[k]);
                    let step = self.g.mul(weight, moved);
                    entries[k] = self.g.add(entries[k], step);
                }
                extent += m.tree.stroke(&by) * libm::fabs(cad(s));
            }
            from.push(self.g.know(&entries, extent, &[t.fact]));
            norm += extent;
            for k in 0..3 {
                sum[k] = self.g.add(sum[k], entries[k]);
            }
        }
        self.name(&sum, "v", i);
        Known {
            entries: sum,
            fact: self.g.know(&sum, norm, &from),
        }
    }

    /// Row `row` of `B_p K_i` and of `B_i`, in canonical axes, for every body.
    fn orientations(&mut self, row: usize) -> Vec<(Known, Known)> {
        let m = self.m;
        let mut rows: Vec<(Known, Known)> = Vec::with_capacity(m.chain.bodies.len());
        for (i, body) in m.chain.bodies.iter().enumerate() {
            let Some(parent) = body.parent else {
                let entries = [0, 1, 2].map(|k| self.g.constant(if k == row { 1.0 } else { 0.0 }));
                let fact = self.g.know(&entries, 1.0, &[]);
                rows.push((Known { entries, fact }, Known { entries, fact }));
                continue;
            };
            let near = rows[parent].1;
            let Some(turn) = &m.frames[i].turn else {
                rows.push((near, near));
                continue;
            };
            self.section(i);
            let (s, c) = self.turn(i);
            let [x, y, z] = self.twist(&turn.twist, near.entries, true);
            let before = Known {
                entries: [x, y, z],
                fact: self.g.know(&[x, y, z], 1.0, &[near.fact]),
            };
            let first = self.g.dot(&[x, y], &[c, s]);
            let (yc, xs) = (self.g.mul(y, c), self.g.mul(x, s));
            let mut second = self.g.sub(yc, xs);
            if turn.mirrored {
                second = self.g.neg(second);
            }
            let entries = [first, second, z];
            let prefix = format!("b{}", AXES[row]);
            self.name(&before.entries, &format!("k{}", AXES[row]), i);
            self.name(&entries, &prefix, i);
            let after = Known {
                entries,
                fact: self.g.know(&entries, 1.0, &[before.fact]),
            };
            rows.push((before, after));
        }
        rows
    }

    /// Rows of ∂CoM/∂q, row-major; negated for gravity moments.
    fn jacobian(&mut self, rows: &[usize], negated: bool) -> Vec<Id> {
        let m = self.m;
        let subtrees = self.subtrees();
        let orientations: Vec<_> = rows.iter().map(|&row| self.orientations(row)).collect();
        let zero = self.g.constant(0.0);
        let mut jacobian = vec![zero; rows.len() * m.dof()];
        for (i, body) in m.chain.bodies.iter().enumerate() {
            let (Some(parent), Motion::Turn { by, .. } | Motion::Slide { by, .. }) =
                (body.parent, body.motion)
            else {
                continue;
            };
            self.section(i);
            for (k, row) in orientations.iter().enumerate() {
                let mut term = match (&m.frames[i].turn, body.motion) {
                    (Some(turn), _) => {
                        let ([x, y, _], t) = (row[i].0.entries, subtrees[i].t);
                        let (up, down) = (self.g.mul(y, t.entries[0]), self.g.mul(x, t.entries[1]));
                        let arm = self.g.sub(up, down);
                        self.g.know_product(arm, [row[i].0.fact, t.fact]);
                        let factor = self.g.constant(turn.angle.factor);
                        self.g.mul(factor, arm)
                    }
                    (None, Motion::Slide { axis, .. }) => {
                        let along = self.direction(&row[parent].1, parent, &axis);
                        let mass = self.parameter(m.slide_param(i));
                        let factor = self.g.constant(by.factor);
                        let scaled = self.g.mul(factor, mass);
                        self.g.mul(along, scaled)
                    }
                    (None, _) => zero,
                };
                if negated {
                    term = self.g.neg(term);
                }
                let entry = &mut jacobian[k * m.dof() + by.dof];
                *entry = self.g.add(*entry, term);
            }
        }
        jacobian
    }

    /// One row of `B_p a` for a slide on body `parent`.
    fn direction(&mut self, row: &Known, parent: usize, axis: &nalgebra::Vector3<f64>) -> Id {
        let axis = (self.m.axes(parent).transpose() * axis).map(tidy);
        let weights = [0, 1, 2].map(|k| self.g.constant(axis[k]));
        let along = self.g.dot(&weights, &row.entries);
        // A unit vector's image: as good as an entry of an orthogonal matrix.
        self.g.know(&[along], 1.0, &[row.fact]);
        along
    }

    /// Rows of the base regressor, row-major.
    fn regressor(&mut self, rows: &[usize]) -> Vec<Id> {
        use crate::base::Column;
        let m = self.m;
        let mut regressor = Vec::with_capacity(rows.len() * m.base.params.len());
        for &row in rows {
            let b = self.orientations(row);
            for param in &m.base.params {
                let entry = match param.column {
                    Column::Axis { body, axis } => b[body].1.entries[axis],
                    Column::Slide { body } => self.slide_column(&b, body),
                };
                regressor.push(entry);
            }
        }
        regressor
    }

    fn slide_column(&mut self, b: &[(Known, Known)], body: usize) -> Id {
        let (Motion::Slide { axis, by }, Some(parent)) = (
            self.m.chain.bodies[body].motion,
            self.m.chain.bodies[body].parent,
        ) else {
            return self.g.constant(0.0);
        };
        let along = self.direction(&b[parent].1, parent, &axis);
        let position = self.position(&by);
        self.g.mul(along, position)
    }

    /// Three rows of the full regressor: orientations of the link frames themselves.
    fn regressor_full(&mut self) -> Vec<Id> {
        let m = self.m;
        let mut regressor = Vec::with_capacity(3 * m.chain.full_params);
        for row in 0..3 {
            let b = self.orientations(row);
            for (i, body) in m.chain.bodies.iter().enumerate() {
                let entries = [0, 1, 2].map(|k| {
                    let weights = [0, 1, 2].map(|n| self.g.constant(m.axes(i)[(k, n)]));
                    self.g.dot(&weights, &b[i].1.entries)
                });
                self.g.know(&entries, 1.0, &[b[i].1.fact]);
                regressor.extend(entries);
                if body.s.is_some() {
                    regressor.push(self.slide_column(&b, i));
                }
            }
        }
        regressor
    }
}

/// Whole quarter turns (0 to 3) and the rest, at most an eighth of a turn.
fn quarters(angle: f64) -> (i64, f64) {
    let quarter = std::f64::consts::FRAC_PI_2;
    let whole = libm::rint(angle / quarter);
    let rest = angle - whole * quarter;
    let rest = if libm::fabs(rest) < 1e-15 { 0.0 } else { rest };
    ((whole as i64).rem_euclid(4), rest)
}
