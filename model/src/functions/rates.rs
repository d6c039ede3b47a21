//! What moves when joints move, without a derivative of any expression.
//!
//! A body that turns at the rate `ω_k` of its joint carries its vector along; leaf to
//! root, in the canonical axes of each body and with `t_k` its turned subtree vector,
//!
//! ```text
//! v̇_i = Σ_children K_k ṫ_k        ṫ_k = Rz(θ_k) v̇_k + ω_k e_z × t_k        v̇_0 = J q̇
//! ```
//!
//! which is the velocity of the CoM in as many operations as its place. A direction d,
//! seen from body i, changes root to leaf by
//!
//! ```text
//! ḃ_i = (ḃ_p K_i) Rz(θ_i) + ω_i b_i × e_z
//! ```
//!
//! and both together give how the slope `dᵀ ∂CoM/∂φ_j` of every joint changes: for
//! gravity's direction this is the Hessian of the potential times the rates, `H ω`.

use super::rows::Direction;
use super::subtrees::Subtree;
use super::{Known, Scratch};
use crate::expr::Id;
use crate::frames::Rotation;
use crate::tree::Motion;

/// Rates of a body that moves: the rate of its vector, and of the same turned by its joint.
pub(crate) struct SubtreeRate {
    pub(crate) v: Known,
    t: Known,
}

/// How a direction changes as a body sees it: before its joint turns it, and after.
#[derive(Clone, Copy)]
struct SeenRate {
    before: Known,
    after: Known,
}

impl Scratch<'_> {
    /// Rates of what every body carries, from those of the joints (rad/s or m/s).
    pub(crate) fn subtree_rates(&mut self, subtrees: &[Subtree], rates: &[Id]) -> Vec<SubtreeRate> {
        let bodies = &self.m.chain.bodies;
        let mut built: Vec<Option<SubtreeRate>> = bodies.iter().map(|_| None).collect();
        for i in (0..bodies.len()).rev() {
            self.section(i);
            let mut sum = [self.g.constant(0.0); 3];
            let mut from = Vec::new();
            for c in self.children[i].clone() {
                let child = built[c]
                    .as_ref()
                    .expect("children are built before parents");
                let moved = self.moved(i, c, child.t, rates);
                sum = self.added(sum, moved.entries);
                from.push(moved.fact);
            }
            self.name(&sum, "dv", i);
            let v = Known::sum(&mut self.g, sum, &from);
            let t = match &self.m.frames[i].rotation {
                None => v,
                Some(rotation) => self.rotated_rate(i, rotation, &v, &subtrees[i], rates),
            };
            built[i] = Some(SubtreeRate { v, t });
        }
        built.into_iter().flatten().collect()
    }

    /// `ṫ = Rz(θ) v̇ + ω e_z × t`
    fn rotated_rate(
        &mut self,
        i: usize,
        rotation: &Rotation,
        v: &Known,
        subtree: &Subtree,
        rates: &[Id],
    ) -> Known {
        let turned = self.rotated(i, rotation, v);
        let turned = Known::sum(&mut self.g, turned, &[v.fact]);
        let t = subtree.t.expect("rates are asked of turned subtrees");
        let [x, y, _] = t.entries;
        let carried = self.scaled_by_rate(i, [self.g.neg(y), x], &t, rates);
        let entries = self.added(turned.entries, carried.entries);
        self.name(&entries, "dt", i);
        Known::sum(&mut self.g, entries, &[turned.fact, carried.fact])
    }

    /// `ω` of body `i` times two coordinates of a vector; the third is zero.
    fn scaled_by_rate(&mut self, i: usize, pair: [Id; 2], of: &Known, rates: &[Id]) -> Known {
        let rate = self.rate_of(i, rates);
        let [x, y] = pair.map(|x| self.g.mul(rate, x));
        let entries = [x, y, self.g.constant(0.0)];
        let fact = self.g.know_scaled(&entries, rate, of.fact);
        Known { entries, fact }
    }

    /// How fast the joint of body `i` moves: factor times the rate of its coordinate.
    pub(super) fn rate_of(&self, i: usize, rates: &[Id]) -> Id {
        let Some(by) = self.m.chain.bodies[i].motion.coordinate() else {
            return self.g.constant(0.0);
        };
        // A canonical axis may point against that of the joint.
        let factor = match &self.m.frames[i].rotation {
            Some(rotation) => rotation.angle.factor,
            None => by.factor,
        };
        self.g.mul(self.g.constant(factor), rates[by.dof])
    }

    /// The rate of child `c` in the axes of its parent `i`: `K ṫ`, and its displacement.
    fn moved(&mut self, i: usize, c: usize, t: Known, rates: &[Id]) -> Known {
        let m = self.m;
        let mut entries = t.entries;
        if let Some(rotation) = &m.frames[c].rotation {
            entries = self.twist(&rotation.twist, entries, false);
        }
        let mut from = vec![self.g.know_sum(&entries, &[t.fact])];
        if let Motion::Prismatic { axis, .. } = m.chain.bodies[c].motion {
            let (mass, limit) = self.parameter(m.prismatic_param(c));
            let carried = self.g.know(&[mass], limit, &[]);
            let rate = self.rate_of(c, rates);
            let moved = self.g.mul(rate, mass);
            from.push(self.g.know_scaled(&[moved], rate, carried));
            entries = self.displaced(entries, self.weights(i, &axis), moved);
        }
        Known::sum(&mut self.g, entries, &from)
    }

    /// `d/dt dᵀ ∂CoM/∂φ_j` of every joint as joints move at `rates`.
    pub(crate) fn slope_rates(
        &mut self,
        direction: &Direction,
        subtrees: &[Subtree],
        rates: &[Id],
    ) -> Vec<Id> {
        let m = self.m;
        let moving = self.subtree_rates(subtrees, rates);
        let seen = self.seen(std::slice::from_ref(direction));
        let zero = self.g.constant(0.0);
        let mut slopes = vec![zero; m.dof()];
        let mut seen_rates: Vec<SeenRate> = Vec::with_capacity(m.chain.bodies.len());
        for (i, body) in m.chain.bodies.iter().enumerate() {
            let rate = self.seen_rate(i, &seen_rates, &seen[i][0], direction.tag, rates);
            seen_rates.push(rate);
            let (Some(parent), Motion::Revolute { by, .. } | Motion::Prismatic { by, .. }) =
                (body.parent, body.motion)
            else {
                continue;
            };
            self.section(i);
            let term = match (&m.frames[i].rotation, body.motion) {
                (Some(rotation), _) => {
                    let t = subtrees[i].t.expect("rates are asked of turned subtrees");
                    let rotating = self.across(&rate.before, &t);
                    let moving = self.across(&seen[i][0].before, &moving[i].t);
                    let sum = self.g.add(rotating, moving);
                    self.g.mul(self.g.constant(rotation.angle.factor), sum)
                }
                (None, Motion::Prismatic { axis, .. }) => {
                    self.carried_along(i, parent, &seen_rates[parent].after, &axis, by.factor)
                }
                (None, _) => zero,
            };
            slopes[by.dof] = self.g.add(slopes[by.dof], term);
        }
        slopes
    }

    /// How the direction changes as body `i` sees it, from its parent's view.
    fn seen_rate(
        &mut self,
        i: usize,
        before: &[SeenRate],
        seen: &super::rows::Seen,
        tag: &str,
        rates: &[Id],
    ) -> SeenRate {
        let m = self.m;
        let Some(parent) = m.chain.bodies[i].parent else {
            let entries = [self.g.constant(0.0); 3];
            let still = Known::within(&mut self.g, entries, 0.0, &[]);
            return SeenRate {
                before: still,
                after: still,
            };
        };
        let near = before[parent].after;
        let Some(rotation) = &m.frames[i].rotation else {
            return SeenRate {
                before: near,
                after: near,
            };
        };
        self.section(i);
        let [before, turned] = self.rotated_back(i, rotation, near.entries);
        let before = Known::sum(&mut self.g, before, &[near.fact]);
        let turned = Known::sum(&mut self.g, turned, &[before.fact]);
        // b × e_z = (b_y, −b_x, 0), where mirrored axes turn the other way.
        let [x, y, _] = seen.after.entries;
        let pair = match rotation.mirrored {
            true => [self.g.neg(y), x],
            false => [y, self.g.neg(x)],
        };
        let carried = self.scaled_by_rate(i, pair, &seen.after, rates);
        let entries = self.added(turned.entries, carried.entries);
        self.name(&entries, &format!("db{tag}"), i);
        SeenRate {
            before,
            after: Known::sum(&mut self.g, entries, &[turned.fact, carried.fact]),
        }
    }
}
