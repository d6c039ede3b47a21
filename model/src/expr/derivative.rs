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
    pub fn derivative(&mut self, of: &[Id], with_respect_to: Id) -> Vec<Id> {
        let one = self.constant(1.0);
        self.forward(
            of,
            &HashMap::from([(with_respect_to, one)]),
            Corner::Crossed,
        )
    }

    /// The rates of each of `of` as input nodes change at `rates`, where no clamp leaves
    /// the side that it is on.
    pub fn rates(&mut self, of: &[Id], rates: &HashMap<Id, Id>) -> Vec<Id> {
        self.forward(of, rates, Corner::Held)
    }

    fn forward(&mut self, of: &[Id], inputs: &HashMap<Id, Id>, corner: Corner) -> Vec<Id> {
        let zero = self.constant(0.0);
        let last = of.iter().map(|id| id.index() + 1).max().unwrap_or(0);
        let mut d = vec![zero; last];
        for k in 0..last {
            let id = Id(k as u32);
            d[k] = match self.expr(id) {
                Expr::Const(_) => zero,
                Expr::Input { .. } => inputs.get(&id).copied().unwrap_or(zero),
                Expr::Add(a, b) => self.add(d[a.index()], d[b.index()]),
                Expr::Sub(a, b) => self.sub(d[a.index()], d[b.index()]),
                Expr::Mul(a, b) => {
                    let left = self.mul(d[a.index()], b);
                    let right = self.mul(a, d[b.index()]);
                    self.add(left, right)
                }
                Expr::Neg(a) => self.neg(d[a.index()]),
                Expr::Sin(a) => {
                    let c = self.cos(a);
                    self.mul(c, d[a.index()])
                }
                Expr::Cos(a) => {
                    let s = self.sin(a);
                    let product = self.mul(s, d[a.index()]);
                    self.neg(product)
                }
                Expr::Div(a, b) => {
                    let carried = self.mul(id, d[b.index()]);
                    let rest = self.sub(d[a.index()], carried);
                    self.div(rest, b)
                }
                Expr::Clamp(_) if corner == Corner::Held => zero,
                Expr::Clamp(a) => {
                    let inner = d[a.index()];
                    self.chain(inner, CLAMP_STEP, |g, h| {
                        let moved = g.add(a, h);
                        g.clamp(moved)
                    })
                }
                Expr::Max(a, b) => {
                    let (first, second) = (d[a.index()], d[b.index()]);
                    let difference = self.sub(first, second);
                    let by_side = match self.value(difference) {
                        Some(0.0) => zero,
                        _ => {
                            let side = self.side(a, b);
                            self.mul(side, difference)
                        }
                    };
                    self.add(second, by_side)
                }
                Expr::Pow(a, b) => {
                    let (base, exponent) = (d[a.index()], d[b.index()]);
                    // (a^b)' = b a^(b-1) a' + slope in b
                    let one = self.constant(1.0);
                    let lower = self.sub(b, one);
                    let power = self.pow(a, lower);
                    let slope = self.mul(b, power);
                    let left = self.mul(slope, base);
                    let right = self.chain(exponent, POWER_STEP, |g, h| {
                        let moved = g.add(b, h);
                        g.pow(a, moved)
                    });
                    self.add(left, right)
                }
            };
        }
        of.iter().map(|id| d[id.index()]).collect()
    }

    /// 1 where `a` is the larger, 0 where `b` is.
    fn side(&mut self, a: Id, b: Id) -> Id {
        let difference = self.sub(a, b);
        let sign = self.sign(difference);
        let half = self.constant(0.5);
        let scaled = self.mul(half, sign);
        self.add(scaled, half)
    }

    /// The sign of `a`; what is next to zero lies between.
    pub fn sign(&mut self, a: Id) -> Id {
        let steep = self.constant(STEEP);
        let scaled = self.mul(steep, a);
        self.clamp(scaled)
    }

    /// `inner` times the slope of `f`, a central difference over ±`step`.
    fn chain(&mut self, inner: Id, step: f64, f: impl Fn(&mut Graph, Id) -> Id) -> Id {
        if self.value(inner) == Some(0.0) {
            return inner;
        }
        let (h, minus_h) = (self.constant(step), self.constant(-step));
        let (ahead, behind) = (f(self, h), f(self, minus_h));
        let difference = self.sub(ahead, behind);
        let scale = self.constant(0.5 / step);
        let slope = self.mul(scale, difference);
        self.mul(slope, inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Argument;

    #[test]
    fn product_and_chain_rule() {
        let mut g = Graph::default();
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
