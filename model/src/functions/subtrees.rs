//! Leaf to root: what each body carries, `v_i = r_i + Σ K_k t_k`, `t_k = Rz(θ_k) v_k`.

use super::{Known, Scratch};
use crate::expr::{Id, VectorId};
use crate::frames::{Rotation, Twist};
use crate::tree::Motion;

/// What of the subtrees is asked for.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Wanted {
    /// The sums `v_i` alone.
    Sums,
    /// The rotated vectors `t_i` too.
    Rotated,
}

/// A body's subtree.
pub(crate) struct Subtree {
    /// In its own canonical axes.
    pub(crate) v: Known,
    /// Rotated by its joint, where that is wanted.
    pub(crate) t: Option<Known>,
}

impl Scratch<'_> {
    /// `K x`, or with `transposed` the row `xᵀ K` (a reflection is symmetric).
    pub(super) fn twist(&self, twist: &Twist, x: [Id; 3], transposed: bool) -> [Id; 3] {
        match twist {
            Twist::Sparse(k) => [0, 1, 2].map(|m| {
                let entry = |n| if transposed { k[(n, m)] } else { k[(m, n)] };
                let weights = [0, 1, 2].map(|n| self.g.constant(entry(n)));
                self.g.dot(&weights, &x)
            }),
            Twist::Reflection { u, k } => {
                // Where the entry that u weighs with one is absent, k joins the others.
                let free = (0..3).any(|n| u[n] == 1.0 && self.g.value(x[n]) != Some(0.0));
                let (inner, outer) = if free { (1.0, *k) } else { (*k, 1.0) };
                let weights = [0, 1, 2].map(|n| self.g.constant(inner * u[n]));
                let along = self.g.dot(&weights, &x);
                let along = self.g.mul(self.g.constant(outer), along);
                [0, 1, 2].map(|n| self.g.sub(x[n], self.g.mul(self.g.constant(u[n]), along)))
            }
        }
    }

    /// What every body carries, leaf to root.
    pub(crate) fn subtrees(&mut self, wanted: Wanted) -> Vec<Subtree> {
        let bodies = &self.m.chain.bodies;
        let mut built: Vec<Option<Subtree>> = bodies.iter().map(|_| None).collect();
        for i in (0..bodies.len()).rev() {
            self.section(i);
            let v = self.carried(i, &built);
            if self.m.frames[i].rotation.is_some() {
                self.rotation(i); // its sine and cosine belong under its own title
            }
            let t = match &self.m.frames[i].rotation {
                None => Some(v),
                Some(rotation) if wanted == Wanted::Rotated || !rotation.twist.is_permutation() => {
                    let entries = self.rotated(i, rotation, &v);
                    self.name(&entries, "t", i);
                    let norm = self.norm(v.fact);
                    Some(Known::within(&mut self.g, entries, norm, &[v.fact]))
                }
                Some(_) => None,
            };
            built[i] = Some(Subtree { v, t });
        }
        built.into_iter().flatten().collect()
    }

    /// `c x, s y, s x, c y` of a subtree on a revolute joint.
    pub(super) fn rotated_products(
        &mut self,
        body: usize,
        rotation: &Rotation,
        v: &Known,
    ) -> [Id; 4] {
        let (s, c) = self.rotation(body);
        let [x, y, _] = v.entries;
        let y = self.signed(y, rotation.mirrored);
        [(c, x), (s, y), (s, x), (c, y)].map(|(a, b)| self.g.mul(a, b))
    }

    /// `v_i = r_i + Σ_children`, in the canonical axes of body `i`.
    ///
    /// Where nothing else wants the rotated vector, its products join the sum one by one:
    /// `(r + c x) − s y` is two fused operations from child to parent. The child that
    /// carries the longest chain comes last, after those that did not have to wait.
    fn carried(&mut self, i: usize, built: &[Option<Subtree>]) -> Known {
        let m = self.m;
        let own = [0, 1, 2].map(|k| self.parameter(m.axis_param(i, k)));
        let mut sum = own.map(|(parameter, _)| parameter);
        let mut norm = libm::sqrt(own.iter().map(|(_, limit)| limit * limit).sum());
        let mut fact = self.g.know(&[], norm, &[]);
        for c in self.children[i].clone() {
            let child = built[c]
                .as_ref()
                .expect("children are built before parents");
            let (extent, from) = match child.t {
                Some(t) => self.join_rotated(i, c, t, &mut sum),
                None => (
                    self.norm(child.v.fact),
                    self.join_products(c, child.v, &mut sum),
                ),
            };
            norm += extent;
            fact = self.g.know(&sum, norm, &[fact, from]);
        }
        self.name(&sum, "v", i);
        Known { entries: sum, fact }
    }

    /// `sum += K t` (and what moves along an axis); how long it may be.
    fn join_rotated(&mut self, i: usize, c: usize, t: Known, sum: &mut [Id; 3]) -> (f64, VectorId) {
        let m = self.m;
        let mut entries = t.entries;
        let mut extent = self.norm(t.fact);
        if let Some(rotation) = &m.frames[c].rotation {
            entries = self.twist(&rotation.twist, entries, false);
            self.name(&entries, "w", c);
        }
        if let Motion::Prismatic { axis, by } = m.chain.bodies[c].motion {
            let position = self.position(&by);
            let (mass, limit) = self.parameter(m.prismatic_param(c));
            let moved = self.g.mul(position, mass);
            entries = self.displaced(entries, self.weights(i, &axis), moved);
            extent += m.tree.stroke(&by) * limit;
        }
        let fact = self.g.know(&entries, extent, &[t.fact]);
        *sum = self.added(*sum, entries);
        (extent, fact)
    }

    /// `x + a b`
    pub(super) fn displaced(&self, x: [Id; 3], a: [Id; 3], b: Id) -> [Id; 3] {
        [0, 1, 2].map(|k| self.g.add(x[k], self.g.mul(a[k], b)))
    }

    pub(super) fn added(&self, a: [Id; 3], b: [Id; 3]) -> [Id; 3] {
        [0, 1, 2].map(|k| self.g.add(a[k], b[k]))
    }

    /// `sum += K Rz(θ) v` product by product, for a twist that only permutes.
    fn join_products(&mut self, c: usize, v: Known, sum: &mut [Id; 3]) -> VectorId {
        let m = self.m;
        let rotation = m.frames[c]
            .rotation
            .as_ref()
            .expect("asked of revolute bodies");
        let Twist::Sparse(k) = &rotation.twist else {
            unreachable!("asked of permutations")
        };
        let [cx, sy, sx, cy] = self.rotated_products(c, rotation, &v);
        let less_sy = self.g.neg(sy);
        let terms = [vec![cx, less_sy], vec![sx, cy], vec![v.entries[2]]];
        for (row, sum) in sum.iter_mut().enumerate() {
            for (column, terms) in terms.iter().enumerate() {
                let sign = self.g.constant(k[(row, column)]);
                for &term in terms {
                    *sum = self.g.add(*sum, self.g.mul(sign, term));
                }
            }
        }
        v.fact
    }
}
