//! Root to leaf: rows of orientations `b_i = b_p K_i Rz(θ_i)`, and what is made of
//! them: Jacobian, gravity moments, regressor rows.
//!
//! All rows of a body stand together, and beside what needs them: sines and
//! orientations are used up while they are still in registers.

use nalgebra::Vector3;

use super::subtrees::{Subtree, Wanted};
use super::{AXES, Known, Scratch};
use crate::base::Column;
use crate::expr::{Argument, Id};
use crate::interface::{Function, Given};
use crate::tree::Motion;

/// A direction `d` of the support frame.
pub(crate) struct Direction {
    pub(crate) entries: [Id; 3],
    /// Bound on its length.
    pub(crate) norm: f64,
    /// What names of its images hold.
    pub(crate) tag: &'static str,
}

/// A direction as a body sees it, in canonical axes.
#[derive(Clone, Copy)]
pub(super) struct Seen {
    /// `dᵀ B_p K_i`: before its joint rotates.
    pub(super) before: Known,
    /// `dᵀ B_i`.
    pub(super) after: Known,
}

impl Scratch<'_> {
    /// Those that the rows of `function` belong to: axes of the support frame, or the one
    /// that comes as an argument.
    pub(crate) fn directions(&self, function: Function) -> Vec<Direction> {
        if self.given != Given::Direction {
            return self.axes_of_support(function.axes());
        }
        let entries = [0, 1, 2].map(|k| self.g.input(Argument::Direction, k));
        vec![Direction {
            entries,
            norm: 1.0,
            tag: "",
        }]
    }

    /// The axes of the support frame.
    pub(crate) fn axes_of_support(&self, rows: &[usize]) -> Vec<Direction> {
        let unit = |row: &usize| Direction {
            entries: [0, 1, 2].map(|k| self.g.constant(if k == *row { 1.0 } else { 0.0 })),
            norm: 1.0,
            tag: AXES[*row],
        };
        rows.iter().map(unit).collect()
    }

    /// The directions as every body sees them.
    pub(super) fn seen(&mut self, directions: &[Direction]) -> Vec<Vec<Seen>> {
        let mut seen = Vec::with_capacity(self.m.chain.bodies.len());
        for i in 0..self.m.chain.bodies.len() {
            let here = self.seen_from(i, &seen, directions);
            seen.push(here);
        }
        seen
    }

    /// The directions as body `i` sees them, from what those before it do.
    fn seen_from(&mut self, i: usize, seen: &[Vec<Seen>], directions: &[Direction]) -> Vec<Seen> {
        let m = self.m;
        let Some(parent) = m.chain.bodies[i].parent else {
            let own = |direction: &Direction| {
                let Direction { entries, norm, .. } = *direction;
                let known = Known::within(&mut self.g, entries, norm, &[]);
                Seen {
                    before: known,
                    after: known,
                }
            };
            return directions.iter().map(own).collect();
        };
        let still = |seen: &Seen| Seen {
            before: seen.after,
            after: seen.after,
        };
        let Some(rotation) = &m.frames[i].rotation else {
            return seen[parent].iter().map(still).collect();
        };
        self.section(i);
        let mut here = Vec::with_capacity(directions.len());
        for (Direction { norm, tag, .. }, near) in directions.iter().zip(&seen[parent]) {
            let near = near.after;
            let [before, after] = self.rotated_back(i, rotation, near.entries);
            let before = Known::within(&mut self.g, before, *norm, &[near.fact]);
            self.name(&before.entries, &format!("k{tag}"), i);
            self.name(&after, &format!("b{tag}"), i);
            let after = Known::within(&mut self.g, after, *norm, &[before.fact]);
            here.push(Seen { before, after });
        }
        here
    }

    /// `dᵀ ∂CoM/∂φ` for each direction, row-major, from the subtrees that cost least;
    /// negated for gravity moments.
    pub(crate) fn slopes(&mut self, directions: &[Direction], negated: bool) -> Vec<Id> {
        // Axes of the support frame have zeros and ones, and the rows of its neighbours
        // still some: there the rotated vectors, seen from before the rotation, are cheaper.
        let wanted = match self.given {
            Given::Direction => Wanted::Sums,
            _ => Wanted::Rotated,
        };
        let subtrees = self.subtrees(wanted);
        self.slopes_along(directions, &subtrees, negated)
    }

    /// `dᵀ ∂CoM/∂q` for each direction, row-major.
    pub(crate) fn slopes_along(
        &mut self,
        directions: &[Direction],
        subtrees: &[Subtree],
        negated: bool,
    ) -> Vec<Id> {
        let m = self.m;
        let zero = self.g.constant(0.0);
        let mut jacobian = vec![zero; directions.len() * m.dof()];
        let mut seen: Vec<Vec<Seen>> = Vec::with_capacity(m.chain.bodies.len());
        for (i, body) in m.chain.bodies.iter().enumerate() {
            let here = self.seen_from(i, &seen, directions);
            seen.push(here);
            let (Some(parent), Motion::Revolute { by, .. } | Motion::Prismatic { by, .. }) =
                (body.parent, body.motion)
            else {
                continue;
            };
            self.section(i);
            for k in 0..directions.len() {
                let term = match (&m.frames[i].rotation, body.motion) {
                    (Some(rotation), _) => {
                        let arm = self.arm(&seen[i][k], &subtrees[i], rotation.mirrored);
                        self.g.mul(self.g.constant(rotation.angle.factor), arm)
                    }
                    (None, Motion::Prismatic { axis, .. }) => {
                        self.carried_along(i, parent, &seen[parent][k].after, &axis, by.factor)
                    }
                    (None, _) => zero,
                };
                let term = self.signed(term, negated);
                let entry = &mut jacobian[k * m.dof() + by.dof];
                *entry = self.g.add(*entry, term);
            }
        }
        jacobian
    }

    /// `dᵀ B_p K (e_z × t)`, or the same after the rotation: `dᵀ B (e_z × v)`, where a mirrored
    /// second coordinate changes the sign.
    fn arm(&mut self, seen: &Seen, subtree: &Subtree, mirrored: bool) -> Id {
        let (row, vector, opposite) = match subtree.t {
            Some(t) => (seen.before, t, false),
            None => (seen.after, subtree.v, mirrored),
        };
        let arm = self.across(&row, &vector);
        self.signed(arm, opposite)
    }

    /// `b · (e_z × t)`
    pub(super) fn across(&mut self, row: &Known, vector: &Known) -> Id {
        let ([x, y, _], [vx, vy, _]) = (row.entries, vector.entries);
        let across = self.g.sub(self.g.mul(y, vx), self.g.mul(x, vy));
        self.g.know_product(across, [row.fact, vector.fact]);
        across
    }

    /// What the mass on the prismatic joint of body `i` is moved by along a row of its parent.
    pub(super) fn carried_along(
        &mut self,
        i: usize,
        parent: usize,
        row: &Known,
        axis: &Vector3<f64>,
        factor: f64,
    ) -> Id {
        let along = self.along(row, parent, axis);
        let (mass, _) = self.parameter(self.m.prismatic_param(i));
        self.g.mul(along, self.g.mul(self.g.constant(factor), mass))
    }

    /// One row of `B_p a` for a prismatic joint on body `parent`.
    fn along(&mut self, row: &Known, parent: usize, axis: &Vector3<f64>) -> Id {
        let along = self.g.dot(&self.weights(parent, axis), &row.entries);
        // A unit vector's image: no longer than the row itself.
        self.g.know_sum(&[along], &[row.fact]);
        along
    }

    /// Rows of the base regressor, row-major.
    pub(crate) fn regressor(&mut self, directions: &[Direction]) -> Vec<Id> {
        let m = self.m;
        let seen = self.seen(directions);
        let mut regressor = Vec::with_capacity(directions.len() * m.base.params.len());
        for row in 0..directions.len() {
            for param in &m.base.params {
                let entry = match param.column {
                    Column::Axis { body, axis } => seen[body][row].after.entries[axis],
                    Column::Prismatic { body } => self.prismatic_column(&seen, row, body),
                };
                regressor.push(entry);
            }
        }
        regressor
    }

    fn prismatic_column(&mut self, seen: &[Vec<Seen>], row: usize, body: usize) -> Id {
        let (Motion::Prismatic { axis, by }, Some(parent)) = (
            self.m.chain.bodies[body].motion,
            self.m.chain.bodies[body].parent,
        ) else {
            return self.g.constant(0.0);
        };
        let along = self.along(&seen[parent][row].after, parent, &axis);
        let position = self.position(&by);
        self.g.mul(along, position)
    }

    /// Rows of the full regressor: orientations of the link frames themselves.
    pub(crate) fn regressor_full(&mut self, directions: &[Direction]) -> Vec<Id> {
        let m = self.m;
        let seen = self.seen(directions);
        let mut regressor = Vec::with_capacity(directions.len() * m.chain.full_params);
        for row in 0..directions.len() {
            for (i, body) in m.chain.bodies.iter().enumerate() {
                let b = seen[i][row].after;
                let entries = [0, 1, 2].map(|k| {
                    let weights = self.constants(&m.axes(i).row(k).transpose());
                    self.g.dot(&weights, &b.entries)
                });
                self.g.know(&entries, 1.0, &[b.fact]);
                regressor.extend(entries);
                if body.s.is_some() {
                    regressor.push(self.prismatic_column(&seen, row, i));
                }
            }
        }
        regressor
    }
}
