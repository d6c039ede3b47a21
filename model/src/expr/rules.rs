//! Making nodes: folding, absorption of 0 and ±1, signs pulled outwards.
//!
//! Each constructor applies the rules that need only its operands, so an
//! expression is in its simplest form as soon as it exists. Rules never change
//! the rounding of what they keep, except that constants are folded together.

use super::graph::{Expr, Graph, Id};

impl Graph {
    /// `a + b`, folded where something is known of them.
    pub fn add(&mut self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x + y),
            (Some(0.0), _) => return b,
            (_, Some(0.0)) => return a,
            (Some(x), _) if x < 0.0 => {
                let x = self.constant(-x);
                return self.sub(b, x);
            }
            (_, Some(y)) if y < 0.0 => {
                let y = self.constant(-y);
                return self.sub(a, y);
            }
            _ => {}
        }
        match (self.expr(a), self.expr(b)) {
            (Expr::Neg(x), Expr::Neg(y)) => {
                let sum = self.add(x, y);
                self.neg(sum)
            }
            (_, Expr::Neg(y)) => self.sub(a, y),
            (Expr::Neg(x), _) => self.sub(b, x),
            _ => self.intern(Expr::Add(a, b)),
        }
    }

    /// `a − b`, folded where something is known of them.
    pub fn sub(&mut self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x - y),
            (Some(0.0), _) => return self.neg(b),
            (_, Some(0.0)) => return a,
            (_, Some(y)) if y < 0.0 => {
                let y = self.constant(-y);
                return self.add(a, y);
            }
            _ => {}
        }
        if a == b {
            return self.constant(0.0);
        }
        match (self.expr(a), self.expr(b)) {
            (Expr::Neg(x), Expr::Neg(y)) => self.sub(y, x),
            (_, Expr::Neg(y)) => self.add(a, y),
            (Expr::Neg(x), _) => {
                let sum = self.add(x, b);
                self.neg(sum)
            }
            // b − a exists already: one subtraction serves both signs.
            _ if self.has_difference(b, a) => {
                let opposite = self.intern(Expr::Sub(b, a));
                self.neg(opposite)
            }
            _ => self.intern(Expr::Sub(a, b)),
        }
    }

    /// `a b`, folded where something is known of them.
    pub fn mul(&mut self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x * y),
            (Some(0.0), _) | (_, Some(0.0)) => return self.constant(0.0),
            (Some(1.0), _) => return b,
            (_, Some(1.0)) => return a,
            (Some(-1.0), _) => return self.neg(b),
            (_, Some(-1.0)) => return self.neg(a),
            // Constants carry no sign, so that k x and -k x share a product.
            (Some(x), _) if x < 0.0 => {
                let x = self.constant(-x);
                let product = self.mul(x, b);
                return self.neg(product);
            }
            (_, Some(_)) => return self.mul(b, a),
            _ => {}
        }
        match (self.expr(a), self.expr(b)) {
            (Expr::Neg(x), Expr::Neg(y)) => self.mul(x, y),
            (Expr::Neg(x), _) => {
                let product = self.mul(x, b);
                self.neg(product)
            }
            (_, Expr::Neg(y)) => {
                let product = self.mul(a, y);
                self.neg(product)
            }
            // k (m x) = (k m) x
            (Expr::Const(k), Expr::Mul(m, x)) if self.value(m).is_some() => {
                let m = self.value(m).unwrap_or_default();
                let km = self.constant(k * m);
                self.mul(km, x)
            }
            _ => self.intern(Expr::Mul(a, b)),
        }
    }

    /// `−a`; two signs cancel.
    pub fn neg(&mut self, a: Id) -> Id {
        match self.expr(a) {
            Expr::Const(x) => self.constant(-x),
            Expr::Neg(x) => x,
            _ => self.intern(Expr::Neg(a)),
        }
    }

    /// `sin a`; the sine of a constant is a constant.
    pub fn sin(&mut self, a: Id) -> Id {
        match self.expr(a) {
            Expr::Const(x) => self.constant(libm::sin(x)),
            Expr::Neg(x) => {
                let s = self.intern(Expr::Sin(x));
                self.neg(s)
            }
            _ => self.intern(Expr::Sin(a)),
        }
    }

    /// `cos a`; the cosine of a constant is a constant.
    pub fn cos(&mut self, a: Id) -> Id {
        match self.expr(a) {
            Expr::Const(x) => self.constant(libm::cos(x)),
            Expr::Neg(x) => self.intern(Expr::Cos(x)),
            _ => self.intern(Expr::Cos(a)),
        }
    }

    /// `a / b`; a constant `b` becomes a factor.
    pub fn div(&mut self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => return self.constant(x / y),
            (Some(0.0), _) => return self.constant(0.0),
            (_, Some(y)) => {
                let factor = self.constant(1.0 / y);
                return self.mul(factor, a);
            }
            _ => {}
        }
        match (self.expr(a), self.expr(b)) {
            (Expr::Neg(x), Expr::Neg(y)) => self.div(x, y),
            (Expr::Neg(x), _) => {
                let ratio = self.div(x, b);
                self.neg(ratio)
            }
            (_, Expr::Neg(y)) => {
                let ratio = self.div(a, y);
                self.neg(ratio)
            }
            _ => self.intern(Expr::Div(a, b)),
        }
    }

    /// The number in [-1, 1] nearest to `a`.
    pub fn clamp(&mut self, a: Id) -> Id {
        match self.expr(a) {
            Expr::Const(x) => self.constant(x.clamp(-1.0, 1.0)),
            Expr::Neg(x) => {
                let inside = self.clamp(x);
                self.neg(inside)
            }
            _ => self.intern(Expr::Clamp(a)),
        }
    }

    /// `a` to the power of `b`, for `a` not negative.
    pub fn pow(&mut self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => self.constant(libm::pow(x, y)),
            (_, Some(0.0)) => self.constant(1.0),
            (_, Some(1.0)) => a,
            _ => self.intern(Expr::Pow(a, b)),
        }
    }

    /// The larger of `a` and `b`; a constant stands second.
    pub fn max(&mut self, a: Id, b: Id) -> Id {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => self.constant(if x < y { y } else { x }),
            _ if a == b => a,
            (Some(_), None) => self.intern(Expr::Max(b, a)),
            _ => self.intern(Expr::Max(a, b)),
        }
    }

    /// The smaller of `a` and `b`.
    pub fn min(&mut self, a: Id, b: Id) -> Id {
        let (a, b) = (self.neg(a), self.neg(b));
        let larger = self.max(a, b);
        self.neg(larger)
    }

    /// `|a|`
    pub fn abs(&mut self, a: Id) -> Id {
        let a = match self.expr(a) {
            Expr::Neg(x) => x,
            _ => a,
        };
        let negative = self.neg(a);
        self.max(a, negative)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Argument;

    fn graph() -> (Graph, Id, Id) {
        let mut g = Graph::default();
        let (x, y) = (
            g.input(Argument::Positions, 0),
            g.input(Argument::Positions, 1),
        );
        (g, x, y)
    }

    #[test]
    fn equal_expressions_are_one_node() {
        let (mut g, x, y) = graph();
        assert_eq!(g.add(x, y), g.add(y, x));
        assert_eq!(g.mul(x, y), g.mul(y, x));
        assert_ne!(g.sub(x, y), g.sub(y, x));
    }

    #[test]
    fn zeros_ones_and_signs_vanish() {
        let (mut g, x, y) = graph();
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
        let (mut g, x, y) = graph();
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
