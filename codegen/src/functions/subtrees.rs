//! Leaf to root: what each body carries, `v_i = r_i + Σ K_k t_k`, `t_k = Rz(θ_k) v_k`.

use super::{Known, Scratch};
use crate::expr::Id;
use crate::frames::Twist;
use crate::snap::tidy;
use crate::tree::Motion;

/// A body's subtree: what it carries, in three frames.
pub(super) struct Subtree {
    /// In its own canonical axes.
    pub(super) v: Known,
    /// Turned by its joint.
    pub(super) t: Known,
}
impl Scratch<'_> {
    /// `K x`, or with `transposed` the row `xᵀ K` (a reflection is symmetric).
    pub(super) fn twist(&mut self, twist: &Twist, x: [Id; 3], transposed: bool) -> [Id; 3] {
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
    pub(super) fn subtrees(&mut self) -> Vec<Subtree> {
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

    /// `v_i = r_i + Σ_children`, in the canonical axes of body `i`.
    pub(super) fn carried(&mut self, i: usize, built: &[Option<Subtree>]) -> Known {
        let m = self.m;
        let own = [0, 1, 2].map(|k| m.axis_param(i, k));
        let mut sum = own.map(|index| self.parameter(index));
        let squares = own.map(|k| self.parameter_limit(k) * self.parameter_limit(k));
        let mut norm = libm::sqrt(squares.iter().sum());
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
                extent += m.tree.stroke(&by) * self.parameter_limit(s);
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
}
