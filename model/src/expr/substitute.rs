//! Expressions with other expressions in the place of variables.

use super::graph::{Expr, Graph, Id};

impl Graph {
    /// `of` with each of the input nodes `variables` replaced by the entry of
    /// `values` at its place.
    ///
    /// One forward pass; what does not depend on a variable stays the same node.
    pub fn substitute(&self, of: &[Id], variables: &[Id], values: &[Id]) -> Vec<Id> {
        let last = of.iter().map(|id| id.index() + 1).max().unwrap_or(0);
        let mut to: Vec<Id> = (0..last as u32).map(Id).collect();
        for k in 0..last {
            let id = to[k];
            let expr = self.expr(id);
            if let Some(which) = variables.iter().position(|variable| *variable == id) {
                to[k] = values[which];
                continue;
            }
            let at = |x: Id| to[x.index()];
            let moved = |x: Id| at(x) != x;
            to[k] = match expr {
                Expr::Const(_) | Expr::Input { .. } => id,
                Expr::Add(a, b) if moved(a) || moved(b) => self.add(at(a), at(b)),
                Expr::Sub(a, b) if moved(a) || moved(b) => self.sub(at(a), at(b)),
                Expr::Mul(a, b) if moved(a) || moved(b) => self.mul(at(a), at(b)),
                Expr::Div(a, b) if moved(a) || moved(b) => self.div(at(a), at(b)),
                Expr::Pow(a, b) if moved(a) || moved(b) => self.pow(at(a), at(b)),
                Expr::Max(a, b) if moved(a) || moved(b) => self.max(at(a), at(b)),
                Expr::Neg(a) if moved(a) => self.neg(at(a)),
                Expr::Sin(a) if moved(a) => self.sin(at(a)),
                Expr::Cos(a) if moved(a) => self.cos(at(a)),
                Expr::Clamp(a) if moved(a) => self.clamp(at(a)),
                _ => id,
            };
        }
        of.iter().map(|id| to[id.index()]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Argument;

    #[test]
    fn variables_give_way_to_expressions_and_constants_fold() {
        let g = Graph::default();
        let [x, y, z] = [0, 1, 2].map(|k| g.input(Argument::Positions, k));
        // f = x sin(y) + z
        let s = g.sin(y);
        let product = g.mul(x, s);
        let f = g.add(product, z);
        let sum = g.add(x, z);
        let expected = {
            let s = g.sin(sum);
            let product = g.mul(z, s);
            g.add(product, z)
        };
        assert_eq!(g.substitute(&[f, z], &[x, y], &[z, sum]), [expected, z]);
        let zero = g.constant(0.0);
        assert_eq!(g.substitute(&[f], &[x], &[zero]), [z]);
    }
}
