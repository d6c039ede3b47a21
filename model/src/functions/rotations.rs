//! Sines and cosines of joint angles: each κ q + θ from q, or from given
//! sines and cosines.
//!
//! ```text
//! sin(a + b) = sin a cos b + cos a sin b      cos(a + b) = cos a cos b − sin a sin b
//! ```
//!
//! Quarter turns in θ swap the two for nothing.

use std::collections::BTreeMap;

use super::{Known, Scratch};
use crate::expr::{Argument, Expr, Id};
use crate::frames::Rotation;
use crate::interface::Given;
use crate::robot::Robot;
use crate::snap::quarters;
use crate::tree::{Coordinate, Motion};

/// Largest multiple of an angle built from its sine and cosine.
const LARGEST_MULTIPLE: f64 = 8.0;

/// Whether sines and cosines of the joints, and positions of the prismatic joints, determine
/// everything: every angle must be a whole multiple of that of a revolute joint,
/// and every stroke follow a prismatic joint (a mimic may tie one kind to the other).
pub(super) fn sines_suffice(robot: &Robot) -> bool {
    let prismatic = |by: &Coordinate| robot.tree.dofs[by.dof].prismatic;
    robot.chain.bodies.iter().all(|body| match &body.motion {
        Motion::Fixed => true,
        Motion::Prismatic { by, .. } => prismatic(by),
        Motion::Revolute { by, .. } => {
            let times = libm::fabs(by.factor);
            !prismatic(by) && times == libm::rint(times) && times <= LARGEST_MULTIPLE
        }
    })
}

/// `Σ multiple·q + rest`, the rest free of joint positions.
struct Split {
    multiples: BTreeMap<usize, f64>,
    rest: Id,
}

impl Scratch<'_> {
    /// Whether the axes of body `i` and those of its parent are of different hands.
    pub(super) fn reflects(&self, i: usize) -> bool {
        let rotation = self.m.frames[i].rotation.as_ref();
        rotation.is_some_and(|rotation| {
            rotation.mirrored != (rotation.twist.matrix().determinant() < 0.0)
        })
    }

    /// `Rz(θ) v` of a vector of a body on a revolute joint.
    pub(super) fn rotated(&mut self, body: usize, rotation: &Rotation, v: &Known) -> [Id; 3] {
        let [cx, sy, sx, cy] = self.rotated_products(body, rotation, v);
        [self.g.sub(cx, sy), self.g.add(sx, cy), v.entries[2]]
    }

    /// The row `xᵀ K` of a vector of its parent as such a body has it before its joint rotates,
    /// and `xᵀ K Rz(θ)` after.
    pub(super) fn rotated_back(
        &mut self,
        body: usize,
        rotation: &Rotation,
        x: [Id; 3],
    ) -> [[Id; 3]; 2] {
        let (s, c) = self.rotation(body);
        let [x, y, z] = self.twist(&rotation.twist, x, true);
        let first = self.g.dot(&[x, y], &[c, s]);
        let second = self.g.sub(self.g.mul(y, c), self.g.mul(x, s));
        let second = self.signed(second, rotation.mirrored);
        [[x, y, z], [first, second, z]]
    }

    /// `−x`, or `x`.
    pub(super) fn signed(&self, x: Id, minus: bool) -> Id {
        if minus { self.g.neg(x) } else { x }
    }

    /// Sine and cosine of the angle that rotates `body`.
    pub(super) fn rotation(&mut self, body: usize) -> (Id, Id) {
        if let Some(pair) = self.rotations[body] {
            return pair;
        }
        let angle = self.m.frames[body]
            .rotation
            .as_ref()
            .expect("asked of revolute bodies")
            .angle;
        let key = &self.m.keys[body];
        let pair = match self.given {
            Given::Positions => self.rotation_from_position(&angle, key),
            Given::SinesCosines | Given::Direction => self.rotation_from_sines(&angle, key),
        };
        self.g.know_weight(pair.0);
        self.g.know_weight(pair.1);
        self.rotations[body] = Some(pair);
        pair
    }

    fn rotation_from_position(&mut self, angle: &Coordinate, key: &str) -> (Id, Id) {
        let (quarters, rest) = quarters(angle.offset);
        // sin(−x + δ) = −sin(x − δ): joints that rotate backwards share their sines.
        let sign = if angle.factor < 0.0 { -1.0 } else { 1.0 };
        let by = Coordinate {
            dof: angle.dof,
            factor: sign * angle.factor,
            offset: sign * rest,
        };
        let x = self.position(&by);
        let (s, c) = (self.g.sin(x), self.g.cos(x));
        self.name_rotation(s, c, key);
        let s = self.signed(s, sign < 0.0);
        self.quarter_turns(s, c, quarters)
    }

    /// The sine and cosine of `factor·φ + offset` for a position φ that effects may have
    /// rewritten: whole multiples of joint angles, and what is added to them.
    fn rotation_from_sines(&mut self, angle: &Coordinate, key: &str) -> (Id, Id) {
        let Split { multiples, rest } = self.split(self.positions[angle.dof]);
        let added = self.g.value(rest).unwrap_or(0.0);
        let (quarters, constant) = quarters(angle.factor * added + angle.offset);
        // As from positions: the angle is taken forwards.
        let sign = if angle.factor < 0.0 { -1.0 } else { 1.0 };
        let (times, constant) = (sign * angle.factor, sign * constant);
        let mut sum: Option<(Id, Id)> = None;
        for (dof, multiple) in multiples {
            let pair = self.multiple_angle(dof, times * multiple);
            sum = Some(match sum {
                Some(sum) => self.sum_of_angles(sum, pair),
                None => pair,
            });
        }
        let one = (self.g.constant(0.0), self.g.constant(1.0));
        let (mut s, mut c) = sum.unwrap_or(one);
        let mut beside = None;
        if self.g.value(rest).is_none() {
            let scaled = self.g.mul(self.g.constant(times), rest);
            let x = self.g.add(scaled, self.g.constant(constant));
            beside = Some((self.g.sin(x), self.g.cos(x)));
        } else if constant != 0.0 {
            let (sin, cos) = libm::sincos(constant);
            beside = Some((self.g.constant(sin), self.g.constant(cos)));
        }
        if let Some(beside) = beside {
            (s, c) = self.sum_of_angles((s, c), beside);
            self.name_rotation(s, c, key);
        }
        let s = self.signed(s, sign < 0.0);
        self.quarter_turns(s, c, quarters)
    }

    fn name_rotation(&mut self, s: Id, c: Id, key: &str) {
        let pass = &self.pass;
        self.g.name(s, || format!("s{pass}_{key}"));
        self.g.name(c, || format!("c{pass}_{key}"));
    }

    /// Sine and cosine of a whole multiple of joint angle `dof`.
    fn multiple_angle(&mut self, dof: usize, multiple: f64) -> (Id, Id) {
        let times = libm::fabs(multiple);
        if times != libm::rint(times) || times > LARGEST_MULTIPLE {
            self.beyond_sines = true;
        }
        let own = (
            self.g.input(Argument::Sines, dof),
            self.g.input(Argument::Cosines, dof),
        );
        let (mut s, mut c) = own;
        for _ in 1..times.min(LARGEST_MULTIPLE) as usize {
            (s, c) = self.sum_of_angles((s, c), own);
        }
        (self.signed(s, multiple < 0.0), c)
    }

    /// A position as multiples of joint positions and a rest.
    fn split(&self, x: Id) -> Split {
        let whole = Split {
            multiples: BTreeMap::new(),
            rest: x,
        };
        match self.g.expr(x) {
            Expr::Input {
                argument: Argument::Positions,
                index,
            } => Split {
                multiples: [(index as usize, 1.0)].into(),
                rest: self.g.constant(0.0),
            },
            Expr::Add(a, b) | Expr::Sub(a, b) => {
                let minus = matches!(self.g.expr(x), Expr::Sub(..));
                let (a, b) = (self.split(a), self.split(b));
                if a.multiples.is_empty() && b.multiples.is_empty() {
                    return whole;
                }
                let mut multiples = a.multiples;
                for (dof, multiple) in b.multiples {
                    let sign = if minus { -1.0 } else { 1.0 };
                    *multiples.entry(dof).or_insert(0.0) += sign * multiple;
                }
                multiples.retain(|_, multiple| *multiple != 0.0);
                let rest = match minus {
                    true => self.g.sub(a.rest, b.rest),
                    false => self.g.add(a.rest, b.rest),
                };
                Split { multiples, rest }
            }
            Expr::Neg(a) => match self.split(a) {
                Split { multiples, .. } if multiples.is_empty() => whole,
                Split { multiples, rest } => Split {
                    multiples: multiples.into_iter().map(|(dof, m)| (dof, -m)).collect(),
                    rest: self.g.neg(rest),
                },
            },
            // Products have their constant first.
            Expr::Mul(k, a) => match (self.g.value(k), self.split_product(k, a)) {
                (Some(k), Some(Split { multiples, rest })) => Split {
                    multiples: multiples.into_iter().map(|(dof, m)| (dof, k * m)).collect(),
                    rest: self.g.mul(self.g.constant(k), rest),
                },
                _ => whole,
            },
            _ => whole,
        }
    }

    /// The second factor of a product with a constant, where it holds joint positions.
    fn split_product(&self, k: Id, a: Id) -> Option<Split> {
        self.g.value(k)?;
        let split = self.split(a);
        (!split.multiples.is_empty()).then_some(split)
    }

    fn sum_of_angles(&self, a: (Id, Id), b: (Id, Id)) -> (Id, Id) {
        let s = self.g.dot(&[a.0, a.1], &[b.1, b.0]);
        (s, self.g.sub(self.g.mul(a.1, b.1), self.g.mul(a.0, b.0)))
    }

    fn quarter_turns(&self, s: Id, c: Id, quarters: i64) -> (Id, Id) {
        match quarters {
            0 => (s, c),
            1 => (c, self.g.neg(s)),
            2 => (self.g.neg(s), self.g.neg(c)),
            _ => (self.g.neg(c), s),
        }
    }
}
