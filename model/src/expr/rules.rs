//! Making nodes: folding, absorption of 0 and ±1, signs pulled outwards.
//!
//! Each constructor applies the rules that need only its operands, so an
//! expression is in its simplest form as soon as it exists. Rules never change
//! the rounding of what they keep, except that constants are folded together.

use super::graph::{Expr, Graph, Id};

impl Graph {
    /// `a + b`, folded where something is known of them.
    pub fn add(&self, a: Id, b: Id) -> Id {
        match (self.expr(a), self.expr(b)) {
            (Expr::Const(x), Expr::Const(y)) => self.constant(x + y),
            (Expr::Const(0.0), _) => b,
            (_, Expr::Const(0.0)) => a,
            (Expr::Const(x), _) if x < 0.0 => self.sub(b, self.constant(-x)),
            (_, Expr::Const(y)) if y < 0.0 => self.sub(a, self.constant(-y)),
            (Expr::Neg(x), Expr::Neg(y)) => self.neg(self.add(x, y)),
            (_, Expr::Neg(y)) => self.sub(a, y),
            (Expr::Neg(x), _) => self.sub(b, x),
            _ => self.intern(Expr::Add(a, b)),
        }
    }

    /// `a − b`, folded where something is known of them.
    pub fn sub(&self, a: Id, b: Id) -> Id {
        match (self.expr(a), self.expr(b)) {
            (Expr::Const(x), Expr::Const(y)) => self.constant(x - y),
            (Expr::Const(0.0), _) => self.neg(b),
            (_, Expr::Const(0.0)) => a,
            (_, Expr::Const(y)) if y < 0.0 => self.add(a, self.constant(-y)),
            _ if a == b => self.constant(0.0),
            (Expr::Neg(x), Expr::Neg(y)) => self.sub(y, x),
            (_, Expr::Neg(y)) => self.add(a, y),
            (Expr::Neg(x), _) => self.neg(self.add(x, b)),
            // b − a exists already: one subtraction serves both signs.
            _ if self.has_difference(b, a) => self.neg(self.intern(Expr::Sub(b, a))),
            _ => self.intern(Expr::Sub(a, b)),
        }
    }

    /// `a b`, folded where something is known of them.
    pub fn mul(&self, a: Id, b: Id) -> Id {
        match (self.expr(a), self.expr(b)) {
            (Expr::Const(x), Expr::Const(y)) => self.constant(x * y),
            (Expr::Const(0.0), _) | (_, Expr::Const(0.0)) => self.constant(0.0),
            (Expr::Const(1.0), _) => b,
            (_, Expr::Const(1.0)) => a,
            (Expr::Const(-1.0), _) => self.neg(b),
            (_, Expr::Const(-1.0)) => self.neg(a),
            // Constants carry no sign, so that k x and -k x share a product.
            (Expr::Const(x), _) if x < 0.0 => self.neg(self.mul(self.constant(-x), b)),
            (_, Expr::Const(_)) => self.mul(b, a),
            (Expr::Neg(x), Expr::Neg(y)) => self.mul(x, y),
            (Expr::Neg(x), _) => self.neg(self.mul(x, b)),
            (_, Expr::Neg(y)) => self.neg(self.mul(a, y)),
            // k (m x) = (k m) x
            (Expr::Const(k), Expr::Mul(m, x)) => match self.value(m) {
                Some(m) => self.mul(self.constant(k * m), x),
                None => self.intern(Expr::Mul(a, b)),
            },
            _ => self.intern(Expr::Mul(a, b)),
        }
    }

    /// `−a`; two signs cancel.
    pub fn neg(&self, a: Id) -> Id {
        match self.expr(a) {
            Expr::Const(x) => self.constant(-x),
            Expr::Neg(x) => x,
            _ => self.intern(Expr::Neg(a)),
        }
    }

    /// `sin a`; the sine of a constant is a constant.
    pub fn sin(&self, a: Id) -> Id {
        match self.expr(a) {
            Expr::Const(x) => self.constant(libm::sin(x)),
            Expr::Neg(x) => self.neg(self.intern(Expr::Sin(x))),
            _ => self.intern(Expr::Sin(a)),
        }
    }

    /// `cos a`; the cosine of a constant is a constant.
    pub fn cos(&self, a: Id) -> Id {
        match self.expr(a) {
            Expr::Const(x) => self.constant(libm::cos(x)),
            Expr::Neg(x) => self.intern(Expr::Cos(x)),
            _ => self.intern(Expr::Cos(a)),
        }
    }

    /// `a / b`; a constant `b` becomes a factor.
    pub fn div(&self, a: Id, b: Id) -> Id {
        match (self.expr(a), self.expr(b)) {
            (Expr::Const(x), Expr::Const(y)) => self.constant(x / y),
            (Expr::Const(0.0), _) => self.constant(0.0),
            (_, Expr::Const(y)) => self.mul(self.constant(1.0 / y), a),
            (Expr::Neg(x), Expr::Neg(y)) => self.div(x, y),
            (Expr::Neg(x), _) => self.neg(self.div(x, b)),
            (_, Expr::Neg(y)) => self.neg(self.div(a, y)),
            _ => self.intern(Expr::Div(a, b)),
        }
    }

    /// The number in [-1, 1] nearest to `a`.
    pub fn clamp(&self, a: Id) -> Id {
        match self.expr(a) {
            Expr::Const(x) => self.constant(x.clamp(-1.0, 1.0)),
            Expr::Neg(x) => self.neg(self.clamp(x)),
            _ => self.intern(Expr::Clamp(a)),
        }
    }

    /// `a` to the power of `b`, for `a` not negative.
    pub fn pow(&self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => self.constant(libm::pow(x, y)),
            (_, Some(0.0)) => self.constant(1.0),
            (_, Some(1.0)) => a,
            _ => self.intern(Expr::Pow(a, b)),
        }
    }

    /// The larger of `a` and `b`; a constant stands second.
    pub fn max(&self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => self.constant(if x < y { y } else { x }),
            _ if a == b => a,
            (Some(_), None) => self.intern(Expr::Max(b, a)),
            _ => self.intern(Expr::Max(a, b)),
        }
    }

    /// The smaller of `a` and `b`.
    pub fn min(&self, a: Id, b: Id) -> Id {
        self.neg(self.max(self.neg(a), self.neg(b)))
    }

    /// `|a|`
    pub fn abs(&self, a: Id) -> Id {
        let a = self.unsigned(a);
        self.max(a, self.neg(a))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Argument;

    fn graph() -> (Graph, Id, Id) {
        let g = Graph::default();
        let (x, y) = (
            g.input(Argument::Positions, 0),
            g.input(Argument::Positions, 1),
        );
        (g, x, y)
    }

    #[test]
    fn equal_expressions_are_one_node() {
        let (g, x, y) = graph();
        assert_eq!(g.add(x, y), g.add(y, x));
        assert_eq!(g.mul(x, y), g.mul(y, x));
        assert_ne!(g.sub(x, y), g.sub(y, x));
    }

    #[test]
    fn zeros_ones_and_signs_vanish() {
        let (g, x, y) = graph();
        let (zero, one, minus) = (g.constant(0.0), g.constant(1.0), g.constant(-1.0));
        assert_eq!(g.mul(x, zero), zero);
        assert_eq!(g.mul(one, x), x);
        assert_eq!(g.add(x, zero), x);
        let minus_x = g.mul(minus, x);
        assert_eq!(g.neg(minus_x), x);
        let difference = g.sub(y, x);
        assert_eq!(g.add(minus_x, y), difference);
        assert_eq!(g.sub(x, x), zero);
        let minus_y = g.neg(y);
        assert_eq!(g.mul(minus_x, minus_y), g.mul(x, y));
        // A difference serves both signs, and constants fold through products.
        let opposite = g.sub(x, y);
        assert_eq!(difference, g.neg(opposite));
        let (two, three, six) = (g.constant(2.0), g.constant(-3.0), g.constant(6.0));
        let (nested, direct) = (g.mul(three, x), g.mul(six, x));
        assert_eq!(g.mul(two, nested), g.neg(direct));
        assert_eq!(g.sin(minus_x), {
            let s = g.sin(x);
            g.neg(s)
        });
        assert_eq!(g.cos(minus_x), g.cos(x));
    }

    #[test]
    fn quotients_clamps_powers_and_maxima_fold() {
        let (g, x, y) = graph();
        let (half, two, one) = (g.constant(0.5), g.constant(2.0), g.constant(1.0));
        assert_eq!(g.div(x, two), g.mul(half, x));
        let minus_y = g.neg(y);
        let ratio = g.div(x, y);
        assert_eq!(g.div(x, minus_y), g.neg(ratio));
        assert_eq!(g.clamp(two), one);
        let inside = g.clamp(y);
        assert_eq!(g.clamp(minus_y), g.neg(inside));
        assert_eq!(g.pow(x, one), x);
        assert_eq!(g.pow(two, two), g.constant(4.0));
        assert_eq!(g.max(half, two), two);
        assert_eq!(g.max(x, x), x);
        assert_eq!(g.max(half, x), g.max(x, half));
        assert_eq!(g.max(x, y), g.max(y, x));
        assert_eq!(g.abs(minus_y), g.abs(y));
    }
}
