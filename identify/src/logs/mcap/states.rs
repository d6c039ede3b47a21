//! Joint states that can be those of one robot.
//!
//! ```text
//! q_k ← q_k + 2π n,  |q_k − q_(k−1)| ≤ π               joints that turn without end
//! |q_k − q_(k−1)|, |q_(k+1) − q_k| ≫ v_limit Δt,  q_(k+1) ≈ q_(k−1)      left out
//! ```
//!
//! A state in which a joint leaps faster than it can and is back in the next one is of another
//! sender on the same topic, or a glitch of the bus. It is told by the state after it, which is
//! why states are given out one later than they come.

use std::collections::HashMap;
use std::f64::consts::TAU;

use sesc_model::tree::Dof;

use super::cdr::JointState;
use crate::logs::criteria::{FASTER, FASTEST_RAD_S, LEAP, RETURNS};
use crate::logs::names::short;

/// Of more states left out than this part it cannot be told which are the robot's.
const MOST: f64 = 0.25;

/// Joint states on their way.
pub(super) struct States {
    place: HashMap<String, usize>,
    joints: Vec<Joint>,
    held: Option<(f64, JointState)>,
    /// Positions of the last state that was left out: one sender repeats itself.
    foreign: Vec<f64>,
    seen: u64,
    left_out: u64,
    /// The joint that leapt first, how far, and in what time, s.
    leap: Option<(String, f64, f64, f64)>,
}

/// Where a joint was last, and what it can do.
struct Joint {
    endless: bool,
    /// rad/s or m/s
    fastest: f64,
    t: f64,
    q: f64,
}

impl States {
    /// States of the joints that have a place, of a robot with these.
    pub fn new(place: HashMap<String, usize>, dofs: &[Dof]) -> States {
        let mut joints: Vec<Joint> = (0..place.len()).map(|_| Joint::new(None)).collect();
        for dof in dofs {
            if let Some(at) = place.get(dof.joint.trim()) {
                joints[*at] = Joint::new(Some(dof));
            }
        }
        States {
            place,
            joints,
            held: None,
            foreign: Vec::new(),
            seen: 0,
            left_out: 0,
            leap: None,
        }
    }

    /// Take the next state; gives back the one before it, if it is the robot's.
    pub fn push(&mut self, t: f64, mut state: JointState) -> Option<(f64, JointState)> {
        self.seen += 1;
        // The one before is where the joints are, unless it is left out.
        let held = self
            .held
            .take()
            .filter(|held| !self.is_foreign(held, (t, &state)));
        if let Some((at, held)) = &held {
            for (name, q) in held.name.iter().zip(&held.position) {
                if let Some(place) = self.place.get(name.trim()) {
                    (self.joints[*place].t, self.joints[*place].q) = (*at, *q);
                }
            }
        }
        for (name, q) in state.name.iter().zip(&mut state.position) {
            if let Some(place) = self.place.get(name.trim()) {
                *q = self.joints[*place].nearest(*q);
            }
        }
        self.held = Some((t, state));
        held
    }

    /// Whether a state waits for the next one.
    pub fn waits(&self) -> bool {
        self.held.is_some()
    }

    /// The last state, at the end.
    pub fn end(&mut self) -> Option<(f64, JointState)> {
        self.held.take()
    }

    /// What is said of states that were left out.
    ///
    /// # Errors
    /// Where they are too many to tell whose are whose.
    pub fn conclude(&self) -> Result<Option<String>, String> {
        let Some((joint, step, time, limit)) = &self.leap else {
            return Ok(None);
        };
        let said = format!(
            "{} of {} joint states are of another sender or a glitch (joint `{}` leaps by {step:.2} in \
             {:.1} ms and back, {limit} a second are its limit)",
            self.left_out,
            self.seen,
            short(joint),
            1e3 * time
        );
        match self.left_out as f64 > MOST * self.seen as f64 {
            true => Err(format!(
                "{said}: which are the robot's cannot be told; stop the other sender, as a \
                 joint_state_publisher, and record again"
            )),
            false => Ok(Some(format!("{said} and are left out"))),
        }
    }

    /// Whether a state is left out, by where the joints were before and are after it.
    fn is_foreign(
        &mut self,
        (at, held): &(f64, JointState),
        (t, next): (f64, &JointState),
    ) -> bool {
        let after: HashMap<&str, f64> = match next.name == held.name {
            // Mostly both name the same joints.
            true => HashMap::new(),
            false => next
                .name
                .iter()
                .map(String::as_str)
                .zip(next.position.iter().copied())
                .collect(),
        };
        let mut is_foreign = !self.foreign.is_empty() && held.position == self.foreign;
        for (k, (name, q)) in held.name.iter().zip(&held.position).enumerate() {
            let Some(place) = self.place.get(name.trim()) else {
                continue;
            };
            let next = match after.is_empty() {
                true => next.position.get(k).copied(),
                false => after.get(name.as_str()).copied(),
            };
            let joint = &self.joints[*place];
            let (before, Some(next)) = (joint.q, next) else {
                continue;
            };
            let next = joint.nearest(next);
            let (step, back) = ((q - before).abs(), (next - q).abs());
            let [there, on] = [at - joint.t, t - at].map(|dt| dt.max(1e-4));
            let leaps = step > LEAP && step > joint.fastest * there && back > joint.fastest * on;
            if leaps && (next - before).abs() < RETURNS * step {
                is_foreign = true;
                let leap = || (name.clone(), step, there, joint.fastest / FASTER);
                self.leap.get_or_insert_with(leap);
                break;
            }
        }
        if is_foreign {
            self.left_out += 1;
            self.foreign.clone_from(&held.position);
        }
        is_foreign
    }
}

impl Joint {
    fn new(dof: Option<&Dof>) -> Joint {
        let limit = dof.map_or(0.0, |dof| dof.speed);
        Joint {
            endless: dof.is_some_and(|dof| dof.continuous),
            fastest: match limit > 0.0 && limit.is_finite() {
                true => FASTER * limit,
                false => FASTER * FASTEST_RAD_S,
            },
            t: f64::NAN,
            q: f64::NAN,
        }
    }

    /// An angle on the branch that is nearest to where the joint was.
    fn nearest(&self, q: f64) -> f64 {
        match self.endless && self.q.is_finite() {
            true => q - TAU * ((q - self.q) / TAU).round(),
            false => q,
        }
    }
}
