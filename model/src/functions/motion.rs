//! What the motion of the joints does to the ground: the zero-moment point.
//!
//! ```text
//! p = c − (c_z c̈ + L̇⊥/M)/(g + c̈_z)        L̇⊥ = (L̇_y, −L̇_x)        on the sole plane z = 0
//! ```
//!
//! Root to leaf, in the canonical axes of each body, its angular velocity and how that changes:
//!
//! ```text
//! ω_i = Rᵀω_p + θ̇ e_z        α_i = Rᵀα_p + Rᵀω_p × θ̇ e_z + θ̈ e_z        A_i = α̂_i + ω̂_i²
//! ```
//!
//! so that a point y of body i is accelerated by `A_i y` against the body's origin. Leaf to
//! root, with the [`Moments`] of each body over M, its origin o and children k at places
//! d_k (displaced by u_k, which is accelerated by a_k against o besides `A_i d_k`):
//!
//! ```text
//! S_i = h_i + Σ R S_k + m_k u_k        F_i = A_i h_i + Σ R F_k + m_k a_k
//! N_i = ∫ y × A_i y + Σ R N_k + (d_k + u_k) × (R F_k + m_k a_k) + (R S_k + m_k u_k) × A_i d_k
//!       + R S_k × a_k
//! ```
//!
//! F_0 is the acceleration of the CoM, N_0 the rate of angular momentum about the support
//! frame, and `L̇/M = N_0 − S_0 × F_0` that about the CoM. c and c̈ follow from r in the same
//! pass over the base parameters. A reflection in the axes of a body turns cross products
//! round: `det R` goes before ω, α and N.

use nalgebra::Vector3;

use super::rotations::Turn;
use super::{Known, Scratch};
use crate::base::Column;
use crate::expr::Id;
use crate::inertia::{self, GRAVITY, Moments, PointMass};
use crate::snap::tidy;
use crate::tree::Motion;

/// Bounds hold where the ground carries at least this share of the weight.
const LEAST_LOAD: f64 = 0.5;

/// Velocities and accelerations of the independent joints.
pub(crate) struct JointMotion {
    pub(crate) rates: Vec<Id>,
    pub(crate) accelerations: Vec<Id>,
}

/// How a body rotates: ω, α and the rows of A.
struct BodyRotation {
    rate: Known,
    change: Known,
    rows: [[Id; 3]; 3],
}

/// What a body passes on to its parent, in its own axes.
struct Wrench {
    first: Known,
    force: Known,
    moment: Known,
}

/// A body on a prismatic joint as its parent sees it: its displacement, and how that is
/// accelerated beside its place.
struct PrismaticShift {
    by: [Id; 3],
    acceleration: [Id; 3],
}

impl Scratch<'_> {
    /// The zero-moment point as joints move, of the robot with point masses `loads`.
    pub(crate) fn zmp(&mut self, joints: &JointMotion, loads: &[PointMass]) -> [Id; 2] {
        let moments = inertia::moments(self.m, loads);
        let com = self.subtrees(super::Wanted::Sums)[0].v.entries;
        let body_rotations = self.body_rotations(joints);
        let prismatic_shifts = self.prismatic_shifts(&body_rotations, joints);
        let acceleration = self.acceleration(&body_rotations, &prismatic_shifts);
        let whole = self.wrench(&moments, &body_rotations, &prismatic_shifts);
        self.g.section("ZMP");
        let spin = self.cross(whole.first.entries, whole.force.entries);
        let spin = [0, 1].map(|k| self.g.sub(whole.moment.entries[k], spin[k]));
        let gravity = self.g.constant(GRAVITY);
        let load = self.g.add(gravity, acceleration[2]);
        self.g.name(load, || "load".to_string());
        self.g.assume_least(load, LEAST_LOAD * GRAVITY);
        let one = self.g.constant(1.0);
        let inverse = self.g.div(one, load);
        // L̇⊥ = (L̇_y, −L̇_x)
        let spin = [spin[1], self.g.neg(spin[0])];
        [0, 1].map(|k| {
            let pushed = self.g.mul(com[2], acceleration[k]);
            let moment = self.g.add(pushed, spin[k]);
            let shift = self.g.mul(moment, inverse);
            self.g.sub(com[k], shift)
        })
    }

    /// What the ZMP of CAD's masses is made of: the CoM, its acceleration, then L̇⊥/M.
    pub(crate) fn motion_parts(&mut self, joints: &JointMotion) -> Vec<Id> {
        let (com, acceleration) = self.accelerated_point(joints);
        let body_rotations = self.body_rotations(joints);
        let prismatic_shifts = self.prismatic_shifts(&body_rotations, joints);
        let mut outputs = [com, acceleration].concat();
        outputs.extend(self.spin(&body_rotations, &prismatic_shifts));
        outputs
    }

    /// L̇⊥/M of the URDF: (L̇_y, −L̇_x)/M about the CoM.
    fn spin(
        &mut self,
        body_rotations: &[BodyRotation],
        prismatic_shifts: &[Option<PrismaticShift>],
    ) -> [Id; 2] {
        let moments = inertia::moments(self.m, &[]);
        let whole = self.wrench(&moments, body_rotations, prismatic_shifts);
        let spin = self.cross(whole.first.entries, whole.force.entries);
        let spin = [0, 1].map(|k| self.g.sub(whole.moment.entries[k], spin[k]));
        [spin[1], self.g.neg(spin[0])]
    }

    /// What the ZMP is made of, for fits: rows of the CoM and of its acceleration by the base
    /// parameters, 3 each, then L̇⊥/M of the URDF.
    pub(crate) fn motion_rows(&mut self, joints: &JointMotion) -> Vec<Id> {
        let m = self.m;
        let axes = self.axes_of_support(&[0, 1, 2]);
        let mut outputs = self.regressor(&axes);
        let seen = self.seen(&axes);
        let body_rotations = self.body_rotations(joints);
        let prismatic_shifts = self.prismatic_shifts(&body_rotations, joints);
        for row in [0, 1, 2] {
            for param in &m.base.params {
                let (body, acceleration) = match param.column {
                    Column::Axis { body, axis } => {
                        (body, body_rotations[body].rows.map(|entries| entries[axis]))
                    }
                    Column::Prismatic { body } => {
                        let prismatic_shift = prismatic_shifts[body].as_ref();
                        let acceleration =
                            prismatic_shift.map(|prismatic_shift| prismatic_shift.acceleration);
                        let zero = self.g.constant(0.0);
                        let parent = m.chain.bodies[body].parent.unwrap_or(body);
                        (parent, acceleration.unwrap_or([zero; 3]))
                    }
                };
                let b = seen[body][row].after.entries;
                outputs.push(self.g.dot(&b, &acceleration));
            }
        }
        outputs.extend(self.spin(&body_rotations, &prismatic_shifts));
        outputs
    }

    /// Where the point is that the parameters stand for, and how it is accelerated as joints
    /// move.
    pub(crate) fn accelerated_point(&mut self, joints: &JointMotion) -> ([Id; 3], [Id; 3]) {
        let at = self.subtrees(super::Wanted::Sums)[0].v.entries;
        let body_rotations = self.body_rotations(joints);
        let prismatic_shifts = self.prismatic_shifts(&body_rotations, joints);
        (at, self.acceleration(&body_rotations, &prismatic_shifts))
    }

    /// How every body turns, root to leaf.
    fn body_rotations(&mut self, joints: &JointMotion) -> Vec<BodyRotation> {
        let mut body_rotations: Vec<BodyRotation> = Vec::with_capacity(self.m.chain.bodies.len());
        for i in 0..self.m.chain.bodies.len() {
            let parent = self.m.chain.bodies[i].parent;
            let body_rotation = match (parent, self.m.frames[i].rotation.is_some()) {
                (None, _) => self.still(),
                (Some(parent), false) => BodyRotation {
                    ..body_rotations[parent]
                },
                (Some(parent), true) => self.body_rotation(i, &body_rotations[parent], joints),
            };
            body_rotations.push(body_rotation);
        }
        body_rotations
    }

    fn still(&mut self) -> BodyRotation {
        let zero = self.g.constant(0.0);
        let entries = [zero; 3];
        let fact = self.g.know(&entries, 0.0, &[]);
        let rest = Known { entries, fact };
        BodyRotation {
            rate: rest,
            change: rest,
            rows: [entries; 3],
        }
    }

    fn body_rotation(
        &mut self,
        i: usize,
        parent: &BodyRotation,
        joints: &JointMotion,
    ) -> BodyRotation {
        self.section(i);
        let turn = self.turn(i);
        let zero = self.g.constant(0.0);
        let own = |scratch: &mut Self, of: &[Id]| {
            let x = scratch.rate_of(i, of);
            if turn.mirrored { scratch.g.neg(x) } else { x }
        };
        let speed = own(self, &joints.rates);
        let gain = own(self, &joints.accelerations);
        let (speed_fact, gain_fact) = (self.g.know_entries(&[speed]), self.g.know_entries(&[gain]));
        let near = self.turned_back(i, &turn, &parent.rate, true);
        let [x, y, z] = near.entries;
        let entries = [x, y, self.g.add(z, speed)];
        let rate = Known {
            entries,
            fact: self.g.know_sum(&entries, &[near.fact, speed_fact]),
        };
        self.name(&rate.entries, "o", i);
        // ω × θ̇ e_z
        let (along_x, along_y) = (self.g.mul(y, speed), self.g.mul(x, speed));
        let along_y = self.g.neg(along_y);
        let swept = self.g.know_scaled(&[along_x, along_y], speed, near.fact);
        let near = self.turned_back(i, &turn, &parent.change, true);
        let [x, y, z] = near.entries;
        let entries = [
            self.g.add(x, along_x),
            self.g.add(y, along_y),
            self.g.add(z, gain),
        ];
        let change = Known {
            entries,
            fact: self.g.know_sum(&entries, &[near.fact, swept, gain_fact]),
        };
        self.name(&change.entries, "a", i);
        let rows = match self.g.value(entries[2]) == Some(0.0) && rate.entries == [zero; 3] {
            true => [[zero; 3]; 3],
            false => self.accelerated(&rate, &change),
        };
        BodyRotation { rate, change, rows }
    }

    /// The rows of `A = α̂ + ω̂²`.
    fn accelerated(&mut self, rate: &Known, change: &Known) -> [[Id; 3]; 3] {
        let ([x, y, z], [ax, ay, az]) = (rate.entries, change.entries);
        let g = &mut self.g;
        let (xx, yy, zz) = (g.mul(x, x), g.mul(y, y), g.mul(z, z));
        let (xy, xz, yz) = (g.mul(x, y), g.mul(x, z), g.mul(y, z));
        let mut square = |a: Id, b: Id| {
            let sum = g.add(a, b);
            g.neg(sum)
        };
        let diagonal = [square(yy, zz), square(xx, zz), square(xx, yy)];
        [
            [diagonal[0], g.sub(xy, az), g.add(xz, ay)],
            [g.add(xy, az), diagonal[1], g.sub(yz, ax)],
            [g.sub(xz, ay), g.add(yz, ax), diagonal[2]],
        ]
    }

    /// Displacements of bodies on prismatic joints in the axes of their parents.
    fn prismatic_shifts(
        &mut self,
        body_rotations: &[BodyRotation],
        joints: &JointMotion,
    ) -> Vec<Option<PrismaticShift>> {
        let bodies = &self.m.chain.bodies;
        (0..bodies.len())
            .map(|i| match (bodies[i].parent, bodies[i].motion) {
                (Some(parent), Motion::Prismatic { axis, by }) => {
                    self.section(i);
                    let axis = (self.m.axes(parent).transpose() * axis.0).map(tidy);
                    let along = |scratch: &mut Self, x: Id| {
                        [0, 1, 2].map(|k| {
                            let weight = scratch.g.constant(axis[k]);
                            scratch.g.mul(weight, x)
                        })
                    };
                    let position = self.position(&by);
                    let by = along(self, position);
                    let rate = self.rate_of(i, &joints.rates);
                    let gain = self.rate_of(i, &joints.accelerations);
                    let (rate, gain) = (along(self, rate), along(self, gain));
                    let two = self.g.constant(2.0);
                    let body_rotation = &body_rotations[parent];
                    let swept = self.cross(body_rotation.rate.entries, rate);
                    let carried = self.times(&body_rotation.rows, by);
                    let acceleration = [0, 1, 2].map(|k| {
                        let swept = self.g.mul(two, swept[k]);
                        let sum = self.g.add(swept, gain[k]);
                        self.g.add(carried[k], sum)
                    });
                    Some(PrismaticShift { by, acceleration })
                }
                _ => None,
            })
            .collect()
    }

    /// c̈ by the parameters r, leaf to root.
    fn acceleration(
        &mut self,
        body_rotations: &[BodyRotation],
        prismatic_shifts: &[Option<PrismaticShift>],
    ) -> [Id; 3] {
        let m = self.m;
        let mut sums: Vec<Option<Known>> = m.chain.bodies.iter().map(|_| None).collect();
        for i in (0..m.chain.bodies.len()).rev() {
            self.section(i);
            let own = [0, 1, 2].map(|k| self.parameter(m.axis_param(i, k)));
            let pushed = self.times(&body_rotations[i].rows, own);
            let mut sum = Known {
                entries: pushed,
                fact: self.g.know_entries(&pushed),
            };
            for c in self.children[i].clone() {
                let child = sums[c].take().expect("children are built before parents");
                let turn = self.turn(c);
                let child = self.turned(c, &turn, &child, false);
                sum = self.joined(&sum, &child);
                if let Some(prismatic_shift) = &prismatic_shifts[c] {
                    let mass = self.parameter(m.prismatic_param(c));
                    let moved = prismatic_shift.acceleration.map(|x| self.g.mul(mass, x));
                    let fact = self.g.know_entries(&moved);
                    let moved = Known {
                        entries: moved,
                        fact,
                    };
                    sum = self.joined(&sum, &moved);
                }
            }
            self.name(&sum.entries, "f", i);
            sums[i] = Some(sum);
        }
        sums[0]
            .take()
            .map_or_else(|| self.still().rate.entries, |sum| sum.entries)
    }

    /// S_0, F_0 and N_0 by the URDF's masses and inertias.
    fn wrench(
        &mut self,
        moments: &[Moments],
        body_rotations: &[BodyRotation],
        prismatic_shifts: &[Option<PrismaticShift>],
    ) -> Wrench {
        let count = self.m.chain.bodies.len();
        let mut built: Vec<Option<Wrench>> = (0..count).map(|_| None).collect();
        for i in (0..count).rev() {
            self.section(i);
            let mut sum = self.own_wrench(&moments[i], &body_rotations[i]);
            for c in self.children[i].clone() {
                let child = built[c].take().expect("children are built before parents");
                let prismatic_shift = prismatic_shifts[c].as_ref();
                let child =
                    self.passed_on(c, &child, &moments[c], &body_rotations[i], prismatic_shift);
                sum = Wrench {
                    first: self.joined(&sum.first, &child.first),
                    force: self.joined(&sum.force, &child.force),
                    moment: self.joined(&sum.moment, &child.moment),
                };
            }
            self.name(&sum.first.entries, "h", i);
            self.name(&sum.force.entries, "g", i);
            self.name(&sum.moment.entries, "n", i);
            built[i] = Some(sum);
        }
        built.swap_remove(0).expect("body 0 is built last")
    }

    fn own_wrench(&mut self, moments: &Moments, body_rotation: &BodyRotation) -> Wrench {
        let first = self.constants(&moments.first);
        let force = self.times(&body_rotation.rows, first);
        // ∫ y × A y: rows of J against rows of A.
        let second = [0, 1, 2].map(|k| self.constants(&moments.second.column(k).into_owned()));
        let moment = [(1, 2), (2, 0), (0, 1)].map(|(a, b)| {
            let plus = self.g.dot(&second[a], &body_rotation.rows[b]);
            let minus = self.g.dot(&second[b], &body_rotation.rows[a]);
            self.g.sub(plus, minus)
        });
        Wrench {
            first: self.known(first),
            force: self.known(force),
            moment: self.known(moment),
        }
    }

    /// What body `c` gives its parent, in the axes of that.
    fn passed_on(
        &mut self,
        c: usize,
        child: &Wrench,
        moments: &Moments,
        parent: &BodyRotation,
        prismatic_shift: Option<&PrismaticShift>,
    ) -> Wrench {
        let turn = self.turn(c);
        let mut first = self.turned(c, &turn, &child.first, false);
        let mut force = self.turned(c, &turn, &child.force, false);
        let mut moment = self.turned(c, &turn, &child.moment, true);
        let mut place = self.constants(&moments.place);
        let carried = self.times(&parent.rows, place);
        let mut add = |scratch: &mut Self, arm: [Id; 3], push: [Id; 3]| {
            let crossed = scratch.cross(arm, push);
            let crossed = scratch.known(crossed);
            moment = scratch.joined(&moment, &crossed);
        };
        if let Some(prismatic_shift) = prismatic_shift {
            add(self, first.entries, prismatic_shift.acceleration);
            let mass = self.g.constant(moments.mass);
            let weighed = |scratch: &mut Self, x: [Id; 3]| {
                let entries = x.map(|x| scratch.g.mul(mass, x));
                scratch.known(entries)
            };
            let (moved, pushed) = (
                weighed(self, prismatic_shift.by),
                weighed(self, prismatic_shift.acceleration),
            );
            first = self.joined(&first, &moved);
            force = self.joined(&force, &pushed);
            place = [0, 1, 2].map(|k| self.g.add(place[k], prismatic_shift.by[k]));
        }
        add(self, place, force.entries);
        add(self, first.entries, carried);
        Wrench {
            first,
            force,
            moment,
        }
    }

    /// A vector of body `c` in the axes of its parent; `axial` ones turn with `det R`.
    fn turned(&mut self, c: usize, turn: &Turn, x: &Known, axial: bool) -> Known {
        let Some(rotation) = &self.m.frames[c].rotation else {
            return *x;
        };
        let [cx, sy, sx, cy] = self.rotated_products(c, rotation, x);
        let entries = [self.g.sub(cx, sy), self.g.add(sx, cy), x.entries[2]];
        let entries = self.twist(&rotation.twist, entries, false);
        self.signed(entries, axial && turn.reflects, x)
    }

    /// A vector of the parent of body `c` in the axes of `c`.
    fn turned_back(&mut self, c: usize, turn: &Turn, x: &Known, axial: bool) -> Known {
        let Some(rotation) = &self.m.frames[c].rotation else {
            return *x;
        };
        let (sin, cos) = self.rotation(c);
        let [a, b, z] = self.twist(&rotation.twist, x.entries, true);
        let first = self.g.dot(&[a, b], &[cos, sin]);
        let (bc, az) = (self.g.mul(b, cos), self.g.mul(a, sin));
        let mut second = self.g.sub(bc, az);
        if turn.mirrored {
            second = self.g.neg(second);
        }
        self.signed([first, second, z], axial && turn.reflects, x)
    }

    fn signed(&mut self, mut entries: [Id; 3], minus: bool, from: &Known) -> Known {
        if minus {
            entries = entries.map(|x| self.g.neg(x));
        }
        Known {
            entries,
            fact: self.g.know_sum(&entries, &[from.fact]),
        }
    }

    fn joined(&mut self, a: &Known, b: &Known) -> Known {
        let entries = [0, 1, 2].map(|k| self.g.add(a.entries[k], b.entries[k]));
        Known {
            entries,
            fact: self.g.know_sum(&entries, &[a.fact, b.fact]),
        }
    }

    fn known(&mut self, entries: [Id; 3]) -> Known {
        Known {
            entries,
            fact: self.g.know_entries(&entries),
        }
    }

    fn constants(&mut self, x: &Vector3<f64>) -> [Id; 3] {
        [0, 1, 2].map(|k| self.g.constant(x[k]))
    }

    fn times(&mut self, rows: &[[Id; 3]; 3], x: [Id; 3]) -> [Id; 3] {
        [0, 1, 2].map(|k| self.g.dot(&x, &rows[k]))
    }

    fn cross(&mut self, a: [Id; 3], b: [Id; 3]) -> [Id; 3] {
        [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
            let (ahead, behind) = (self.g.mul(a[i], b[j]), self.g.mul(a[j], b[i]));
            self.g.sub(ahead, behind)
        })
    }
}
