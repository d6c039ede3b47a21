//! Sines and cosines of joint angles: each κ q + θ from q, or from given
//! sines and cosines.
//!
//! ```text
//! sin(a + b) = sin a cos b + cos a sin b      cos(a + b) = cos a cos b − sin a sin b
//! ```
//!
//! Quarter turns in θ swap the two for nothing.

use super::Scratch;
use crate::expr::{Argument, Id};
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

impl Scratch<'_> {
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

    pub(super) fn rotation_from_position(&mut self, angle: &Coordinate, key: &str) -> (Id, Id) {
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
        let pass = &self.pass;
        self.g.name(s, || format!("s{pass}_{key}"));
        self.g.name(c, || format!("c{pass}_{key}"));
        let s = if sign < 0.0 { self.g.neg(s) } else { s };
        self.quarter_turns(s, c, quarters)
    }

    pub(super) fn rotation_from_sines(&mut self, angle: &Coordinate, key: &str) -> (Id, Id) {
        let (quarters, rest) = quarters(angle.offset);
        let own = (
            self.g.input(Argument::Sines, angle.dof),
            self.g.input(Argument::Cosines, angle.dof),
        );
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

    pub(super) fn sum_of_angles(&mut self, a: (Id, Id), b: (Id, Id)) -> (Id, Id) {
        let s = self.g.dot(&[a.0, a.1], &[b.1, b.0]);
        let (cc, ss) = (self.g.mul(a.1, b.1), self.g.mul(a.0, b.0));
        (s, self.g.sub(cc, ss))
    }

    pub(super) fn quarter_turns(&mut self, s: Id, c: Id, quarters: i64) -> (Id, Id) {
        match quarters {
            0 => (s, c),
            1 => (c, self.g.neg(s)),
            2 => (self.g.neg(s), self.g.neg(c)),
            _ => (self.g.neg(c), s),
        }
    }
}
