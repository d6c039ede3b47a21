//! What motion adds to the CoP of a robot that carries loads.
//!
//! ```text
//! λ = 1 + c̈_z/g        p = s + Δ                      of the bare robot: s standing, p moving
//! P = Σ μ (x + z tilt) + Σ b z_b        A = Σ μ z̈/g        D = Σ μ (x z̈ − z ẍ)/g
//! p' = (λ s' + ρ λ Δ + (1 − λ) P + D)/(ρ λ + 1 − ρ + A)        ρ = 1 − Σ μ
//! ```
//!
//! the moments of all that presses on the ground over its sum. `s'` is the CoP of the robot at
//! rest with its loads, of which `P` is what loads and pulls make; a load of share μ at x is
//! accelerated with its link, a force is not. With first moments m = μ a in a link whose frame is
//! at o with rotation R, `μ x = μ o + R m`, so that products of positions and accelerations are
//!
//! ```text
//! μ x z̈ = μ o_x ö_z + (R m)_x ö_z + o_x (R̈ m)_z + (R m)_x (R̈ m)_z/μ
//! ```
//!
//! of which the last has no size where μ has none.

use super::{CarriedLoad, Measured, PostureContext};
use crate::expr::Id;
use crate::functions::JointMotion;
use crate::inertia::GRAVITY;

/// `1/μ` is `μ/(μ² + ε²)` where μ is unknown: fits begin at no load.
const LEAST_SHARE: f64 = 3e-4;

/// Sums over loads, over what presses on the ground.
struct Loads {
    /// `1 − ρ`
    share: Id,
    /// `P` without pulls, m.
    pressed: [Id; 2],
    /// `A`
    lift: Id,
    /// `D`, m.
    moment: [Id; 2],
}

/// A point that moves, or a direction: where it is and how it is accelerated, m and m/s².
#[derive(Clone, Copy)]
struct Moving {
    at: [Id; 3],
    gain: [Id; 3],
}

impl Measured<'_> {
    /// What motion adds joins the reading: that of the context, which is of the bare robot
    /// where loads are `moving`, and of all that moves otherwise. `pulled` is what pulls make of
    /// the reading, m.
    pub(super) fn set_in_motion(&mut self, pulled: [Id; 2], moving: bool) {
        let shift = [0, 1].map(|axis| self.shift(axis));
        if !moving || self.carried.is_empty() {
            self.reading = [0, 1].map(|axis| self.add(self.reading[axis], shift[axis]));
            return;
        }
        let lift = self.posture_context(PostureContext::of(self.robot()).lift());
        let loads = self.loads_in_motion();
        let one = self.constant(1.0);
        let bare = self.sub(one, loads.share);
        let carried = self.add(one, lift);
        let own = self.mul(bare, carried);
        let load = self.add(self.add(own, loads.share), loads.lift);
        self.reading = [0, 1].map(|axis| {
            let pressed = self.add(loads.pressed[axis], pulled[axis]);
            let unloaded = self.sub(self.reading[axis], pressed);
            // λ s' + (1 − λ) P
            let standing = self.add(self.reading[axis], self.mul(lift, unloaded));
            let sum = self.add(standing, self.mul(own, shift[axis]));
            self.div(self.add(sum, loads.moment[axis]), load)
        });
    }

    /// What motion adds to the CoP on an axis, at the joints and the time where the robot is:
    /// `Δ + Σ_j ∂Δ/∂q_j δq_j + Δ̇ δt + ½ Δ̈ δt²`.
    fn shift(&self, axis: usize) -> Id {
        let layout = PostureContext::of(self.robot());
        let mut shift = self.posture_context(layout.shift(axis));
        for dof in 0..self.joints.len() {
            let (joint, wired) = (self.joints[dof], self.wired[dof]);
            if joint != wired {
                let off = self.sub(joint, wired);
                let slope = self.posture_context(layout.shift_slope(dof, axis));
                shift = self.add(shift, self.mul(slope, off));
            }
        }
        for &late in &self.late {
            let by = [1, 2].map(|order| layout.shift_in_time(order, axis));
            let [rate, curve] = by.map(|index| self.posture_context(index));
            let half = self.mul(self.constant(0.5), late);
            let rate = self.add(rate, self.mul(half, curve));
            shift = self.add(shift, self.mul(rate, late));
        }
        shift
    }

    fn loads_in_motion(&mut self) -> Loads {
        let zero = self.constant(0.0);
        let mut sums = Loads {
            share: zero,
            pressed: [zero; 2],
            lift: zero,
            moment: [zero; 2],
        };
        let motion = self.motion_of_joints();
        let per_gravity = self.constant(1.0 / GRAVITY);
        for (k, load) in self.carried.clone().iter().enumerate() {
            let [place, arm] = self.moving_load(load, &motion, k);
            sums.share = self.add(sums.share, load.share);
            let weighed = |x: [Id; 3], arm: [Id; 3]| {
                [0, 1, 2].map(|axis| self.add(self.mul(load.share, x[axis]), arm[axis]))
            };
            let at = weighed(place.at, arm.at);
            for axis in 0..2 {
                let pressed = self.add(at[axis], self.mul(self.tilt[axis], at[2]));
                sums.pressed[axis] = self.add(sums.pressed[axis], pressed);
            }
            if !load.inert {
                continue;
            }
            let gain = weighed(place.gain, arm.gain);
            sums.lift = self.add(sums.lift, self.mul(per_gravity, gain[2]));
            let inverse = self.inverse_of(load.share);
            for axis in 0..2 {
                // μ x z̈ − μ z ẍ = (μ o + R m) × ö + o × R̈ m + R m × R̈ m/μ
                let by_place = self.turned_about(axis, at, place.gain);
                let by_arm = self.turned_about(axis, place.at, arm.gain);
                let own = self.turned_about(axis, arm.at, arm.gain);
                let own = self.mul(inverse, own);
                let sum = self.add(self.add(by_place, by_arm), own);
                let moment = self.mul(per_gravity, sum);
                sums.moment[axis] = self.add(sums.moment[axis], moment);
            }
        }
        sums
    }

    /// The frame of the link that a load is on, and the load's first moment, turned with it.
    fn moving_load(&mut self, load: &CarriedLoad, motion: &JointMotion, k: usize) -> [Moving; 2] {
        let map = self.robot().standard_map_of(load.link);
        let place: Vec<Id> = map.column(0).iter().map(|w| self.constant(*w)).collect();
        let arm = map.row_iter().map(|row| {
            let weights = [1, 2, 3].map(|column| self.constant(row[column]));
            self.g().dot(&weights, &load.moment)
        });
        let arm = arm.collect();
        self.at(self.joints.clone(), "");
        let before = std::mem::replace(&mut self.scratch.pass, format!("l{k}"));
        let own = self.scratch.masses.take();
        let found = [place, arm].map(|point| {
            self.scratch.masses = Some(point.into_iter().map(|x| (x, f64::INFINITY)).collect());
            let (at, gain, _) = self.scratch.accelerated_point(motion);
            Moving { at, gain }
        });
        self.scratch.masses = own;
        self.scratch.pass = before;
        found
    }

    /// Velocities and accelerations of the joints by those of the encoders in the context.
    /// Springs and dead bands are left out, which move by a small part of what they bend.
    fn motion_of_joints(&self) -> JointMotion {
        let layout = PostureContext::of(self.robot());
        let dof = self.robot().dof();
        let inputs = |place: fn(PostureContext, usize) -> usize| -> Vec<Id> {
            let places = (0..dof).map(|j| place(layout, j));
            places.map(|place| self.posture_context(place)).collect()
        };
        let rates = inputs(PostureContext::rate);
        let accelerations = inputs(PostureContext::acceleration);
        let columns = self.encoder_columns();
        JointMotion {
            rates: self.straight_rates(&columns, &rates),
            accelerations: self.straight_rates(&columns, &accelerations),
        }
    }

    /// `1/μ`; of an unknown μ nearly.
    fn inverse_of(&self, share: Id) -> Id {
        let one = self.constant(1.0);
        match self.g().value(share) {
            Some(x) if x != 0.0 => self.div(one, share),
            Some(_) => self.constant(0.0),
            None => {
                let square = self.mul(share, share);
                let least = self.constant(LEAST_SHARE * LEAST_SHARE);
                self.div(share, self.add(square, least))
            }
        }
    }

    /// `x a_z − z a_x` on an axis: the moment of a push `a` at x about the sole.
    fn turned_about(&self, axis: usize, x: [Id; 3], push: [Id; 3]) -> Id {
        self.sub(self.mul(x[axis], push[2]), self.mul(x[2], push[axis]))
    }
}
