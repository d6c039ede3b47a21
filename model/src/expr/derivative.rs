//! Symbolic derivatives.
//!
//! ```text
//! (a b)' = a' b + a b'      sin(a)' = cos(a) a'      cos(a)' = −sin(a) a'
//! (a/b)' = (a' − (a/b) b')/b
//! ```
//!
//! A clamp's slope (one inside, zero outside) and a power's in its exponent are
//! central differences of the function itself, written as expressions: no
//! further operation is needed, and steps are small enough (2^-20, 2^-17) that
//! they are exact to 1e-9 but at the clamp's corners, where they lie between.
//! Of the larger of two it is the slope of that one, chosen by a steep clamp:
//!
//! ```text
//! max(a, b)' = b' + s (a' − b')        s = ½ + ½ clamp(2^20 (a − b))
//! ```

use std::collections::HashMap;

use super::graph::{Expr, Graph, Id};

/// Steps of the differences that stand for a slope, powers of two.
const CLAMP_STEP: f64 = 1.0 / 1_048_576.0;
const POWER_STEP: f64 = 1.0 / 131_072.0;
/// How steeply a side is chosen: a power of two, so that it is no rounded number.
const STEEP: f64 = 1_048_576.0;

/// What a change does to a clamp.
#[derive(Clone, Copy, PartialEq)]
enum Corner {
    /// The change may take the clamped value across a corner.
    Crossed,
    /// The change leaves the clamped value on its side of every corner.
    Held,
}

impl Graph {
    /// ∂`of`/∂`with_respect_to` for each of `of`; the variable is an input node.
    ///
    /// One forward pass over the nodes: nothing is derived twice.
    pub fn derivative(&self, of: &[Id], with_respect_to: Id) -> Vec<Id> {
        let rates = HashMap::from([(with_respect_to, self.constant(1.0))]);
        self.forward(of, &rates, Corner::Crossed)
    }

    /// The rates of each of `of` as input nodes change at `rates`, where no clamp leaves
    /// the side that it is on.
    pub fn rates(&self, of: &[Id], rates: &HashMap<Id, Id>) -> Vec<Id> {
        self.forward(of, rates, Corner::Held)
    }

    fn forward(&self, of: &[Id], inputs: &HashMap<Id, Id>, corner: Corner) -> Vec<Id> {
        let zero = self.constant(0.0);
        let last = of.iter().map(|id| id.index() + 1).max().unwrap_or(0);
        let mut d = vec![zero; last];
        for k in 0..last {
            let id = Id(k as u32);
            let rate = |x: Id| d[x.index()];
            d[k] = match self.expr(id) {
                Expr::Const(_) => zero,
                Expr::Input { .. } => inputs.get(&id).copied().unwrap_or(zero),
                Expr::Add(a, b) => self.add(rate(a), rate(b)),
                Expr::Sub(a, b) => self.sub(rate(a), rate(b)),
                Expr::Mul(a, b) => self.add(self.mul(rate(a), b), self.mul(a, rate(b))),
                Expr::Neg(a) => self.neg(rate(a)),
                Expr::Sin(a) => self.mul(self.cos(a), rate(a)),
                Expr::Cos(a) => self.neg(self.mul(self.sin(a), rate(a))),
                Expr::Div(a, b) => {
                    let carried = self.mul(id, rate(b));
                    self.div(self.sub(rate(a), carried), b)
                }
                Expr::Clamp(_) if corner == Corner::Held => zero,
                Expr::Clamp(a) => self.chain(rate(a), CLAMP_STEP, |h| self.clamp(self.add(a, h))),
                Expr::Max(a, b) => {
                    let difference = self.sub(rate(a), rate(b));
                    let by_side = match self.value(difference) {
                        Some(0.0) => zero,
                        _ => self.mul(self.side(a, b), difference),
                    };
                    self.add(rate(b), by_side)
                }
                Expr::Pow(a, b) => {
                    // (a^b)' = b a^(b-1) a' + slope in b
                    let power = self.pow(a, self.sub(b, self.constant(1.0)));
                    let left = self.mul(self.mul(b, power), rate(a));
                    let by_exponent = |h| self.pow(a, self.add(b, h));
                    self.add(left, self.chain(rate(b), POWER_STEP, by_exponent))
                }
            };
        }
        of.iter().map(|id| d[id.index()]).collect()
    }

    /// 1 where `a` is the larger, 0 where `b` is.
    fn side(&self, a: Id, b: Id) -> Id {
        let sign = self.sign(self.sub(a, b));
        let half = self.constant(0.5);
        self.add(self.mul(half, sign), half)
    }

    /// The sign of `a`; what is next to zero lies between.
    pub fn sign(&self, a: Id) -> Id {
        self.clamp(self.mul(self.constant(STEEP), a))
    }

    /// `inner` times the slope of `f`, a central difference over ±`step`.
    fn chain(&self, inner: Id, step: f64, f: impl Fn(Id) -> Id) -> Id {
        if self.value(inner) == Some(0.0) {
            return inner;
        }
        let [ahead, behind] = [step, -step].map(|h| self.constant(h)).map(f);
        let difference = self.sub(ahead, behind);
        let slope = self.mul(self.constant(0.5 / step), difference);
        self.mul(slope, inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Argument;

    #[test]
    fn product_and_chain_rule() {
        let g = Graph::default();
        let (x, y) = (
            g.input(Argument::Positions, 0),
            g.input(Argument::Positions, 1),
        );
        // f = x sin(2 x) + y
        let two = g.constant(2.0);
        let angle = g.mul(two, x);
        let (s, c) = (g.sin(angle), g.cos(angle));
        let product = g.mul(x, s);
        let f = g.add(product, y);
        // f' = sin(2 x) + x (cos(2 x) 2)
        let inner = g.mul(c, two);
        let right = g.mul(x, inner);
        let expected = g.add(s, right);
        assert_eq!(g.derivative(&[f], x), vec![expected]);
        assert_eq!(g.derivative(&[f], y), vec![g.constant(1.0)]);
    }
}
