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

use super::{Known, Scratch, Wanted};
use crate::base::Column;
use crate::expr::{Graph, Id};
use crate::inertia::{self, GRAVITY, Moments, PointMass};
use crate::tree::Motion;

/// Bounds hold where the ground carries at least this share of the weight.
const LEAST_LOAD: f64 = 0.5;

/// Velocities and accelerations of the independent joints.
pub(crate) struct JointMotion {
    pub(crate) rates: Vec<Id>,
    pub(crate) accelerations: Vec<Id>,
}

/// How the bodies move as the joints do.
pub(crate) struct BodyMotion {
    rotations: Vec<BodyRotation>,
    /// Of bodies on prismatic joints.
    shifts: Vec<Option<PrismaticShift>>,
}

/// How a body rotates: ω, α and the rows of A.
#[derive(Clone, Copy)]
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
#[derive(Clone, Copy)]
struct PrismaticShift {
    by: [Id; 3],
    acceleration: [Id; 3],
}

impl Scratch<'_> {
    /// The zero-moment point as joints move, of the robot with point masses `loads`.
    pub(crate) fn zmp(&mut self, joints: &JointMotion, loads: &[PointMass]) -> [Id; 2] {
        let (com, acceleration, motion) = self.accelerated_point(joints);
        let spin = self.spin(&motion, loads);
        let load = self.g.add(self.g.constant(GRAVITY), acceleration[2]);
        self.g.name(load, || "load".to_string());
        self.g.assume_least(load, LEAST_LOAD * GRAVITY);
        let inverse = self.g.div(self.g.constant(1.0), load);
        [0, 1].map(|k| {
            let pushed = self.g.mul(com[2], acceleration[k]);
            let moment = self.g.add(pushed, spin[k]);
            self.g.sub(com[k], self.g.mul(moment, inverse))
        })
    }

    /// What the ZMP of CAD's masses is made of: the CoM, its acceleration, then L̇⊥/M.
    pub(crate) fn motion_parts(&mut self, joints: &JointMotion) -> Vec<Id> {
        let (com, acceleration, motion) = self.accelerated_point(joints);
        let spin = self.spin(&motion, &[]);
        [&com[..], &acceleration, &spin].concat()
    }

    /// L̇⊥/M of the URDF: (L̇_y, −L̇_x)/M about the CoM.
    fn spin(&mut self, motion: &BodyMotion, loads: &[PointMass]) -> [Id; 2] {
        let moments = inertia::moments(self.m, loads);
        let whole = self.wrench(&moments, motion);
        self.g.section("ZMP");
        let spin = cross(&self.g, whole.first.entries, whole.force.entries);
        let [x, y] = [0, 1].map(|k| self.g.sub(whole.moment.entries[k], spin[k]));
        [y, self.g.neg(x)]
    }

    /// What the ZMP is made of, for fits: rows of the CoM and of its acceleration by the base
    /// parameters, 3 each, then L̇⊥/M of the URDF.
    pub(crate) fn motion_rows(&mut self, joints: &JointMotion) -> Vec<Id> {
        let m = self.m;
        let axes = self.axes_of_support(&[0, 1, 2]);
        let mut outputs = self.regressor(&axes);
        let seen = self.seen(&axes);
        let motion = self.body_motion(joints);
        for row in [0, 1, 2] {
            for param in &m.base.params {
                let (body, acceleration) = match param.column {
                    Column::Axis { body, axis } => {
                        let rows = motion.rotations[body].rows;
                        (body, rows.map(|entries| entries[axis]))
                    }
                    Column::Prismatic { body } => {
                        let still = [self.g.constant(0.0); 3];
                        let acceleration = motion.shifts[body].map(|shift| shift.acceleration);
                        let parent = m.chain.bodies[body].parent.unwrap_or(body);
                        (parent, acceleration.unwrap_or(still))
                    }
                };
                let b = seen[body][row].after.entries;
                outputs.push(self.g.dot(&b, &acceleration));
            }
        }
        outputs.extend(self.spin(&motion, &[]));
        outputs
    }

    /// Where the point is that the parameters stand for, how it is accelerated as joints move, and
    /// how the bodies move.
    pub(crate) fn accelerated_point(
        &mut self,
        joints: &JointMotion,
    ) -> ([Id; 3], [Id; 3], BodyMotion) {
        let at = self.subtrees(Wanted::Sums)[0].v.entries;
        let motion = self.body_motion(joints);
        (at, self.acceleration(&motion), motion)
    }

    fn body_motion(&mut self, joints: &JointMotion) -> BodyMotion {
        let bodies = 0..self.m.chain.bodies.len();
        let mut rotations: Vec<BodyRotation> = Vec::with_capacity(bodies.len());
        for i in bodies.clone() {
            let parent = self.m.chain.bodies[i]
                .parent
                .map(|parent| rotations[parent]);
            let rotation = self.body_rotation(i, parent, joints);
            rotations.push(rotation);
        }
        let shifts = bodies.map(|i| self.prismatic_shift(i, &rotations, joints));
        BodyMotion {
            shifts: shifts.collect(),
            rotations,
        }
    }

    /// How body `i` turns, from how its parent does.
    fn body_rotation(
        &mut self,
        i: usize,
        parent: Option<BodyRotation>,
        joints: &JointMotion,
    ) -> BodyRotation {
        let zero = self.g.constant(0.0);
        let still = [zero; 3];
        let (parent, rotation) = match (parent, &self.m.frames[i].rotation) {
            (None, _) => {
                let rest = Known::within(&mut self.g, still, 0.0, &[]);
                return BodyRotation {
                    rate: rest,
                    change: rest,
                    rows: [still; 3],
                };
            }
            (Some(parent), None) => return parent,
            (Some(parent), Some(rotation)) => (parent, rotation),
        };
        self.section(i);
        let own = |of: &[Id]| self.signed(self.rate_of(i, of), rotation.mirrored);
        let [speed, gain] = [&joints.rates, &joints.accelerations].map(|of| own(of));
        let [speed_fact, gain_fact] = [speed, gain].map(|x| self.g.know_entries(&[x]));
        let near = self.turned_back(i, &parent.rate);
        let [x, y, z] = near.entries;
        let entries = [x, y, self.g.add(z, speed)];
        let rate = Known::sum(&mut self.g, entries, &[near.fact, speed_fact]);
        self.name(&rate.entries, "o", i);
        // ω × θ̇ e_z
        let (along_x, along_y) = (self.g.mul(y, speed), self.g.mul(x, speed));
        let swept = [along_x, self.g.neg(along_y), zero];
        let swept_fact = self.g.know_scaled(&swept[..2], speed, near.fact);
        let near = self.turned_back(i, &parent.change);
        let [x, y, z] = self.added(near.entries, swept);
        let entries = [x, y, self.g.add(z, gain)];
        let facts = [near.fact, swept_fact, gain_fact];
        let change = Known::sum(&mut self.g, entries, &facts);
        self.name(&change.entries, "a", i);
        let rows = match self.g.value(entries[2]) == Some(0.0) && rate.entries == still {
            true => [still; 3],
            false => acceleration_rows(&self.g, rate.entries, change.entries),
        };
        BodyRotation { rate, change, rows }
    }

    /// The displacement of a body on a prismatic joint in the axes of its parent.
    fn prismatic_shift(
        &mut self,
        i: usize,
        rotations: &[BodyRotation],
        joints: &JointMotion,
    ) -> Option<PrismaticShift> {
        let body = &self.m.chain.bodies[i];
        let (Some(parent), Motion::Prismatic { axis, by }) = (body.parent, body.motion) else {
            return None;
        };
        self.section(i);
        let axis = self.weights(parent, &axis);
        let along = |x: Id| axis.map(|weight| self.g.mul(weight, x));
        let by = along(self.position(&by));
        let [rate, gain] =
            [&joints.rates, &joints.accelerations].map(|of| along(self.rate_of(i, of)));
        let two = self.g.constant(2.0);
        let swept = cross(&self.g, rotations[parent].rate.entries, rate);
        let carried = times(&self.g, &rotations[parent].rows, by);
        let acceleration = [0, 1, 2].map(|k| {
            let own = self.g.add(self.g.mul(two, swept[k]), gain[k]);
            self.g.add(carried[k], own)
        });
        Some(PrismaticShift { by, acceleration })
    }

    /// c̈ by the parameters r, leaf to root.
    fn acceleration(&mut self, motion: &BodyMotion) -> [Id; 3] {
        let m = self.m;
        let mut sums: Vec<Option<Known>> = vec![None; m.chain.bodies.len()];
        for i in (0..m.chain.bodies.len()).rev() {
            self.section(i);
            let own = [0, 1, 2].map(|k| self.parameter(m.axis_param(i, k)).0);
            let pushed = times(&self.g, &motion.rotations[i].rows, own);
            let mut sum = Known::of_entries(&mut self.g, pushed);
            for c in self.children[i].clone() {
                let child = sums[c].expect("children are built before parents");
                let child = self.turned(c, &child, false);
                sum = self.joined(&sum, &child);
                if let Some(shift) = &motion.shifts[c] {
                    let (mass, _) = self.parameter(m.prismatic_param(c));
                    let moved = shift.acceleration.map(|x| self.g.mul(mass, x));
                    let moved = Known::of_entries(&mut self.g, moved);
                    sum = self.joined(&sum, &moved);
                }
            }
            self.name(&sum.entries, "f", i);
            sums[i] = Some(sum);
        }
        sums[0].expect("body 0 is built last").entries
    }

    /// S_0, F_0 and N_0 by the URDF's masses and inertias.
    fn wrench(&mut self, moments: &[Moments], motion: &BodyMotion) -> Wrench {
        let count = self.m.chain.bodies.len();
        let mut built: Vec<Option<Wrench>> = (0..count).map(|_| None).collect();
        for i in (0..count).rev() {
            self.section(i);
            let rows = &motion.rotations[i].rows;
            let mut sum = self.own_wrench(&moments[i], rows);
            for c in self.children[i].clone() {
                let child = built[c].take().expect("children are built before parents");
                let child = self.passed_on(c, &child, &moments[c], rows, &motion.shifts[c]);
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

    fn own_wrench(&mut self, moments: &Moments, rows: &[[Id; 3]; 3]) -> Wrench {
        let first = self.constants(&moments.first);
        let force = times(&self.g, rows, first);
        // ∫ y × A y: rows of J against rows of A.
        let second = [0, 1, 2].map(|k| self.constants(&moments.second.column(k).into_owned()));
        let moment = [(1, 2), (2, 0), (0, 1)].map(|(a, b)| {
            let plus = self.g.dot(&second[a], &rows[b]);
            self.g.sub(plus, self.g.dot(&second[b], &rows[a]))
        });
        let [first, force, moment] =
            [first, force, moment].map(|entries| Known::of_entries(&mut self.g, entries));
        Wrench {
            first,
            force,
            moment,
        }
    }

    /// What body `c` gives its parent, in the axes of that, of which A has these rows.
    fn passed_on(
        &mut self,
        c: usize,
        child: &Wrench,
        moments: &Moments,
        rows: &[[Id; 3]; 3],
        shift: &Option<PrismaticShift>,
    ) -> Wrench {
        let mut first = self.turned(c, &child.first, false);
        let mut force = self.turned(c, &child.force, false);
        let mut moment = self.turned(c, &child.moment, true);
        let mut place = self.constants(&moments.place);
        let carried = times(&self.g, rows, place);
        let mut add = |scratch: &mut Self, arm: [Id; 3], push: [Id; 3]| {
            let crossed = cross(&scratch.g, arm, push);
            let crossed = Known::of_entries(&mut scratch.g, crossed);
            moment = scratch.joined(&moment, &crossed);
        };
        if let Some(shift) = shift {
            add(self, first.entries, shift.acceleration);
            let mass = self.g.constant(moments.mass);
            let [moved, pushed] = [shift.by, shift.acceleration].map(|x| {
                let entries = x.map(|x| self.g.mul(mass, x));
                Known::of_entries(&mut self.g, entries)
            });
            first = self.joined(&first, &moved);
            force = self.joined(&force, &pushed);
            place = self.added(place, shift.by);
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
    fn turned(&mut self, c: usize, x: &Known, axial: bool) -> Known {
        let Some(rotation) = &self.m.frames[c].rotation else {
            return *x;
        };
        let entries = self.rotated(c, rotation, x);
        let entries = self.twist(&rotation.twist, entries, false);
        let entries = entries.map(|x| self.signed(x, axial && self.reflects(c)));
        Known::sum(&mut self.g, entries, &[x.fact])
    }

    /// An axial vector of the parent of body `c` in the axes of `c`.
    fn turned_back(&mut self, c: usize, x: &Known) -> Known {
        let Some(rotation) = &self.m.frames[c].rotation else {
            return *x;
        };
        let [_, entries] = self.rotated_back(c, rotation, x.entries);
        let entries = entries.map(|x| self.signed(x, self.reflects(c)));
        Known::sum(&mut self.g, entries, &[x.fact])
    }

    fn joined(&mut self, a: &Known, b: &Known) -> Known {
        let entries = self.added(a.entries, b.entries);
        Known::sum(&mut self.g, entries, &[a.fact, b.fact])
    }
}

/// The rows of `A = α̂ + ω̂²`.
fn acceleration_rows(g: &Graph, [x, y, z]: [Id; 3], [ax, ay, az]: [Id; 3]) -> [[Id; 3]; 3] {
    let (xx, yy, zz) = (g.mul(x, x), g.mul(y, y), g.mul(z, z));
    let (xy, xz, yz) = (g.mul(x, y), g.mul(x, z), g.mul(y, z));
    let diagonal = [(yy, zz), (xx, zz), (xx, yy)].map(|(a, b)| g.neg(g.add(a, b)));
    [
        [diagonal[0], g.sub(xy, az), g.add(xz, ay)],
        [g.add(xy, az), diagonal[1], g.sub(yz, ax)],
        [g.sub(xz, ay), g.add(yz, ax), diagonal[2]],
    ]
}

fn times(g: &Graph, rows: &[[Id; 3]; 3], x: [Id; 3]) -> [Id; 3] {
    [0, 1, 2].map(|k| g.dot(&x, &rows[k]))
}

fn cross(g: &Graph, a: [Id; 3], b: [Id; 3]) -> [Id; 3] {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
        let ahead = g.mul(a[i], b[j]);
        g.sub(ahead, g.mul(a[j], b[i]))
    })
}
