//! Symbolic derivatives.
//!
//! ```text
//! (a b)' = a' b + a b'      sin(a)' = cos(a) a'      cos(a)' = −sin(a) a'
//! ```

use super::graph::{Expr, Graph, Id};

impl Graph {
    /// ∂`of`/∂`with_respect_to` for each of `of`; the variable is an input node.
    ///
    /// One forward pass over the nodes: nothing is derived twice.
    pub fn derivative(&mut self, of: &[Id], with_respect_to: Id) -> Vec<Id> {
        let zero = self.constant(0.0);
        let one = self.constant(1.0);
        let last = of.iter().map(|id| id.index() + 1).max().unwrap_or(0);
        let mut d = vec![zero; last];
        for k in 0..last {
            let id = Id(k as u32);
            d[k] = match self.expr(id) {
                _ if id == with_respect_to => one,
                Expr::Const(_) | Expr::Input { .. } => zero,
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
            };
        }
        of.iter().map(|id| d[id.index()]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn product_and_chain_rule() {
        let mut g = Graph::default();
        let (x, y) = (g.input(0, 0), g.input(0, 1));
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
