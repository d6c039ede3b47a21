//! Root to leaf: rows of orientations `b_i = b_p K_i Rz(θ_i)`, and what is made of
//! them: Jacobian, gravity moments, regressor rows.

use super::subtrees::Subtree;
use super::{AXES, Known, Scratch};
use crate::base::Column;
use crate::expr::Id;
use crate::snap::tidy;
use crate::tree::Motion;

impl Scratch<'_> {
    /// Row `row` of `B_p K_i` and of `B_i`, in canonical axes, for every body.
    pub(super) fn orientations(&mut self, row: usize) -> Vec<(Known, Known)> {
        let unit = [0, 1, 2].map(|k| self.g.constant(if k == row { 1.0 } else { 0.0 }));
        self.directions(unit, 1.0, AXES[row])
    }

    /// `dᵀ B_p K_i` and `dᵀ B_i` for every body: a direction `d` of the support
    /// frame (of length `norm` at most) seen from the bodies.
    pub(super) fn directions(&mut self, d: [Id; 3], norm: f64, tag: &str) -> Vec<(Known, Known)> {
        let m = self.m;
        let mut rows: Vec<(Known, Known)> = Vec::with_capacity(m.chain.bodies.len());
        for (i, body) in m.chain.bodies.iter().enumerate() {
            let Some(parent) = body.parent else {
                let entries = d;
                let fact = self.g.know(&entries, norm, &[]);
                rows.push((Known { entries, fact }, Known { entries, fact }));
                continue;
            };
            let near = rows[parent].1;
            let Some(turn) = &m.frames[i].turn else {
                rows.push((near, near));
                continue;
            };
            self.section(i);
            let (s, c) = self.turn(i);
            let [x, y, z] = self.twist(&turn.twist, near.entries, true);
            let before = Known {
                entries: [x, y, z],
                fact: self.g.know(&[x, y, z], norm, &[near.fact]),
            };
            let first = self.g.dot(&[x, y], &[c, s]);
            let (yc, xs) = (self.g.mul(y, c), self.g.mul(x, s));
            let mut second = self.g.sub(yc, xs);
            if turn.mirrored {
                second = self.g.neg(second);
            }
            let entries = [first, second, z];
            self.name(&before.entries, &format!("k{tag}"), i);
            self.name(&entries, &format!("b{tag}"), i);
            let after = Known {
                entries,
                fact: self.g.know(&entries, norm, &[before.fact]),
            };
            rows.push((before, after));
        }
        rows
    }

    /// Rows of ∂CoM/∂q, row-major; negated for gravity moments.
    pub(super) fn jacobian(&mut self, rows: &[usize], negated: bool) -> Vec<Id> {
        let subtrees = self.subtrees();
        let orientations: Vec<_> = rows.iter().map(|&row| self.orientations(row)).collect();
        self.turned(&subtrees, &orientations, negated)
    }

    /// `dᵀ ∂CoM/∂q` for each of the directions that `orientations` come from.
    pub(super) fn turned(
        &mut self,
        subtrees: &[Subtree],
        orientations: &[Vec<(Known, Known)>],
        negated: bool,
    ) -> Vec<Id> {
        let m = self.m;
        let zero = self.g.constant(0.0);
        let mut jacobian = vec![zero; orientations.len() * m.dof()];
        for (i, body) in m.chain.bodies.iter().enumerate() {
            let (Some(parent), Motion::Turn { by, .. } | Motion::Slide { by, .. }) =
                (body.parent, body.motion)
            else {
                continue;
            };
            self.section(i);
            for (k, row) in orientations.iter().enumerate() {
                let mut term = match (&m.frames[i].turn, body.motion) {
                    (Some(turn), _) => {
                        let ([x, y, _], t) = (row[i].0.entries, subtrees[i].t);
                        let (up, down) = (self.g.mul(y, t.entries[0]), self.g.mul(x, t.entries[1]));
                        let arm = self.g.sub(up, down);
                        self.g.know_product(arm, [row[i].0.fact, t.fact]);
                        let factor = self.g.constant(turn.angle.factor);
                        self.g.mul(factor, arm)
                    }
                    (None, Motion::Slide { axis, .. }) => {
                        let along = self.along(&row[parent].1, parent, &axis);
                        let mass = self.parameter(m.slide_param(i));
                        let factor = self.g.constant(by.factor);
                        let scaled = self.g.mul(factor, mass);
                        self.g.mul(along, scaled)
                    }
                    (None, _) => zero,
                };
                if negated {
                    term = self.g.neg(term);
                }
                let entry = &mut jacobian[k * m.dof() + by.dof];
                *entry = self.g.add(*entry, term);
            }
        }
        jacobian
    }

    /// One row of `B_p a` for a slide on body `parent`.
    fn along(&mut self, row: &Known, parent: usize, axis: &nalgebra::Vector3<f64>) -> Id {
        let axis = (self.m.axes(parent).transpose() * axis).map(tidy);
        let weights = [0, 1, 2].map(|k| self.g.constant(axis[k]));
        let along = self.g.dot(&weights, &row.entries);
        // A unit vector's image: no longer than the direction itself.
        let norm = self.norm(row.fact);
        self.g.know(&[along], norm, &[row.fact]);
        along
    }

    /// Rows of the base regressor, row-major.
    pub(super) fn regressor(&mut self, rows: &[usize]) -> Vec<Id> {
        let m = self.m;
        let mut regressor = Vec::with_capacity(rows.len() * m.base.params.len());
        for &row in rows {
            let b = self.orientations(row);
            for param in &m.base.params {
                let entry = match param.column {
                    Column::Axis { body, axis } => b[body].1.entries[axis],
                    Column::Slide { body } => self.slide_column(&b, body),
                };
                regressor.push(entry);
            }
        }
        regressor
    }

    pub(super) fn slide_column(&mut self, b: &[(Known, Known)], body: usize) -> Id {
        let (Motion::Slide { axis, by }, Some(parent)) = (
            self.m.chain.bodies[body].motion,
            self.m.chain.bodies[body].parent,
        ) else {
            return self.g.constant(0.0);
        };
        let along = self.along(&b[parent].1, parent, &axis);
        let position = self.position(&by);
        self.g.mul(along, position)
    }

    /// Three rows of the full regressor: orientations of the link frames themselves.
    pub(super) fn regressor_full(&mut self) -> Vec<Id> {
        let m = self.m;
        let mut regressor = Vec::with_capacity(3 * m.chain.full_params);
        for row in 0..3 {
            let b = self.orientations(row);
            for (i, body) in m.chain.bodies.iter().enumerate() {
                let entries = [0, 1, 2].map(|k| {
                    let weights = [0, 1, 2].map(|n| self.g.constant(m.axes(i)[(k, n)]));
                    self.g.dot(&weights, &b[i].1.entries)
                });
                self.g.know(&entries, 1.0, &[b[i].1.fact]);
                regressor.extend(entries);
                if body.s.is_some() {
                    regressor.push(self.slide_column(&b, i));
                }
            }
        }
        regressor
    }
}
