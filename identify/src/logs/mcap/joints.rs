//! Joint states that can be those of one robot, and the joints between them.
//!
//! ```text
//! q_k ← q_k + 2π n,  |q_k − q_(k−1)| ≤ π               joints that turn without end
//! |q_k − q_(k−1)|, |q_(k+1) − q_k| ≫ v_limit Δt,  q_(k+1) ≈ q_(k−1)      left out
//! q_j(t) = Σ_k q_jk Π_{i≠k} (t − t_i)/(t_k − t_i)        the two messages before t, the two after
//! ```
//!
//! A state in which a joint leaps faster than it can and is back in the next one is of another
//! sender on the same topic, or a glitch of the bus. It is told by the state after it, which is
//! why states are given out one later than they come.
//!
//! Of a robot that moves each reading has the joints between their messages. Each joint has the
//! stamps of its own messages: topics of arms and legs need not agree. Where messages on either
//! side of a reading are too far apart, the reading is left out; where there is but one beyond, the
//! polynomial is of lower order.
//!
//! Where two contacts are loaded, both are known at one moment:
//!
//! ```text
//! F₂(t), F₂ p₂(t)        on the line between the other contact's messages before t and after it
//! ```

use std::array;
use std::collections::{HashMap, VecDeque};
use std::f64::consts::TAU;

use sesc_model::tree::Dof;

use super::cdr::JointState;
use super::{LEAST_LOAD_N, centre};
use crate::logs::block::Share;
use crate::logs::criteria::{FASTER, FASTEST_RAD_S, LEAP, RETURNS};
use crate::logs::names::short;
use crate::logs::stillness::MOST;

/// Positions of the robot's joints in a message, rad or m.
pub(super) struct State {
    /// s
    pub t: f64,
    /// Joint by joint: its place, and where it is.
    pub q: Vec<(usize, f64)>,
    /// The fastest of their velocities, rad/s or m/s.
    pub speed: f64,
}

/// Joint states on their way.
pub(super) struct States {
    place: HashMap<String, usize>,
    joints: Vec<Joint>,
    /// The last state, which waits for the next one.
    pub held: Option<State>,
    /// Positions of the last state that was left out: one sender repeats itself.
    foreign: Vec<(usize, f64)>,
    /// Messages.
    pub seen: u64,
    left_out: u64,
    /// The first leap, in words.
    leap: String,
}

/// Where a joint was last, and what it can do.
struct Joint {
    name: String,
    endless: bool,
    /// rad/s or m/s
    limit: f64,
    t: f64,
    q: f64,
}

impl States {
    /// States of joints of these names, of a robot with these.
    pub(super) fn new(names: &[String], dofs: &[Dof]) -> States {
        let joint = |name: &String| {
            let dof = dofs.iter().find(|dof| dof.joint.trim() == name);
            let limit = dof.map_or(0.0, |dof| dof.speed);
            let is_limit = limit > 0.0 && limit.is_finite();
            Joint {
                name: name.clone(),
                endless: dof.is_some_and(|dof| dof.continuous),
                limit: if is_limit { limit } else { FASTEST_RAD_S },
                t: f64::NAN,
                q: f64::NAN,
            }
        };
        States {
            place: names.iter().cloned().zip(0..).collect(),
            joints: names.iter().map(joint).collect(),
            held: None,
            foreign: Vec::new(),
            seen: 0,
            left_out: 0,
            leap: String::new(),
        }
    }

    /// Take the next message; gives back the state before it, if it is the robot's.
    pub(super) fn push(&mut self, t: f64, message: &JointState) -> Option<State> {
        self.seen += 1;
        let (mut q, mut speed) = (Vec::with_capacity(message.joints.len()), 0.0_f64);
        for (name, position, velocity) in &message.joints {
            if let Some(place) = self.place.get(name.trim()) {
                q.push((*place, *position));
                speed = speed.max(velocity.abs());
            }
        }
        // The one before is where the joints are, unless it is left out.
        let held = self.held.take();
        let held = held.filter(|held| !self.is_foreign(held, t, &q));
        if let Some(held) = &held {
            for (place, q) in &held.q {
                (self.joints[*place].t, self.joints[*place].q) = (held.t, *q);
            }
        }
        for (place, q) in &mut q {
            *q = self.joints[*place].nearest(*q);
        }
        self.held = Some(State { t, q, speed });
        held
    }

    /// What is said of states that were left out.
    ///
    /// # Errors
    /// Where they are more than a quarter: which are the robot's cannot be told.
    pub(super) fn conclude(&self) -> Result<Option<String>, String> {
        if self.left_out == 0 {
            return Ok(None);
        }
        let said = format!(
            "{} of {} joint states are of another sender or a glitch ({})",
            self.left_out, self.seen, self.leap
        );
        if self.left_out as f64 > 0.25 * self.seen as f64 {
            return Err(format!(
                "{said}: which are the robot's cannot be told; stop the other sender, as a \
                 joint_state_publisher, and record again"
            ));
        }
        Ok(Some(format!("{said} and are left out")))
    }

    /// Whether a state is left out, by where the joints were before and are in the `next` message.
    fn is_foreign(&mut self, held: &State, next_t: f64, next: &[(usize, f64)]) -> bool {
        let mut is_foreign = !self.foreign.is_empty() && held.q == self.foreign;
        for (k, (place, q)) in held.q.iter().enumerate() {
            // Mostly both name the same joints.
            let same = next.get(k).filter(|(other, _)| other == place);
            let after = same.or_else(|| next.iter().find(|(other, _)| other == place));
            let Some((_, after)) = after else {
                continue;
            };
            let joint = &self.joints[*place];
            let (before, after) = (joint.q, joint.nearest(*after));
            let (step, back) = ((q - before).abs(), (after - q).abs());
            let [there, on] = [held.t - joint.t, next_t - held.t].map(|dt| dt.max(1e-4));
            let fastest = FASTER * joint.limit;
            let leaps = step > LEAP && step > fastest * there && back > fastest * on;
            if leaps && (after - before).abs() < RETURNS * step {
                is_foreign = true;
                if self.leap.is_empty() {
                    self.leap = format!(
                        "joint `{}` leaps by {step:.2} in {:.1} ms and back, {} a second are its \
                         limit",
                        short(&joint.name),
                        1e3 * there,
                        joint.limit
                    );
                }
                break;
            }
        }
        if is_foreign {
            self.left_out += 1;
            self.foreign.clone_from(&held.q);
        }
        is_foreign
    }
}

impl Joint {
    /// An angle on the branch that is nearest to where the joint was.
    fn nearest(&self, q: f64) -> f64 {
        if self.endless && self.q.is_finite() {
            q - TAU * ((q - self.q) / TAU).round()
        } else {
            q
        }
    }
}

/// Messages between which a reading may lie are no further apart, s. Closed form: the
/// cubic errs by `3/128 (ω Δt)⁴` of a sine of ω, 0.1 % at 0.7 Hz; at twice as much 1.4 %.
pub(super) const LONGEST_S: f64 = 0.1;
/// Positions of a joint that are kept, s: readings may arrive so much later than joints.
const KEPT_S: f64 = 2.0;
/// Messages on either side of a reading.
const SIDE: usize = 2;

/// What messages of one sender say, `N` numbers each, in the order of their stamps.
pub(super) struct Track<const N: usize>(pub VecDeque<(f64, [f64; N])>);

impl<const N: usize> Track<N> {
    /// Add a message, and forget those that no reading needs that comes after time `first`. Stamps
    /// that go back far begin anew, and one that is there already says nothing.
    fn push(&mut self, t: f64, values: [f64; N], first: f64) {
        let all = &mut self.0;
        let last = all.back().map_or(f64::NEG_INFINITY, |(last, _)| *last);
        if !t.is_finite() || t == last || (t < last && last - t < KEPT_S) {
            return;
        }
        if t < last {
            all.clear();
        }
        all.push_back((t, values));
        while all.len() > 2 * SIDE && (all[SIDE].0 < first || all.len() > MOST) {
            all.pop_front();
        }
    }

    /// Its numbers at time `t`: of the message of that stamp, else on the polynomial of `side`
    /// messages before and as many after, as far as they are close; none between messages that are
    /// not.
    fn at(&self, t: f64, side: usize) -> Option<[f64; N]> {
        let all = &self.0;
        let after = all.partition_point(|(at, _)| *at < t);
        if all.get(after)?.0 == t {
            return Some(all[after].1);
        }
        let is_near = |before: usize| all[before + 1].0 - all[before].0 <= LONGEST_S;
        let before = after.checked_sub(1)?;
        let (mut first, mut last) = is_near(before).then_some((before, after))?;
        for _ in 1..side {
            first -= usize::from(first > 0 && is_near(first - 1));
            last += usize::from(last + 1 < all.len() && is_near(last));
        }
        let weight = |k: usize| -> f64 {
            let others = (first..=last).filter(|i| *i != k);
            let parts = others.map(|i| (t - all[i].0) / (all[k].0 - all[i].0));
            parts.product()
        };
        let sum = |n: usize| (first..=last).map(|k| weight(k) * all[k].1[n]).sum();
        Some(array::from_fn(sum))
    }
}

/// Readings that wait for the messages of other senders, each in the order of their stamps.
pub(super) struct Waiting<R, const N: usize> {
    pub tracks: Vec<Track<N>>,
    readings: VecDeque<(f64, R)>,
    /// Messages on either side of a reading, and how long messages are kept, s.
    side: usize,
    kept: f64,
    /// Readings that lie between no messages that are close enough.
    pub left_out: u64,
}

impl<R> Waiting<R, 1> {
    /// Readings that wait for the positions of `dof` joints.
    pub(super) fn for_joints(dof: usize) -> Waiting<R, 1> {
        Waiting::new(dof, SIDE, KEPT_S)
    }
}

impl<R, const N: usize> Waiting<R, N> {
    pub(super) fn new(senders: usize, side: usize, kept: f64) -> Waiting<R, N> {
        Waiting {
            tracks: (0..senders).map(|_| Track(VecDeque::new())).collect(),
            readings: VecDeque::new(),
            side,
            kept,
            left_out: 0,
        }
    }

    /// A reading at time `t`.
    pub(super) fn reading(&mut self, t: f64, reading: R) {
        if t.is_finite() && self.readings.len() < MOST {
            self.readings.push_back((t, reading));
        } else {
            self.left_out += 1;
        }
    }

    /// What a sender says at time `t`.
    pub(super) fn message(&mut self, sender: usize, t: f64, values: [f64; N]) {
        let first = self.readings.front().map_or(t, |(at, _)| at.min(t));
        self.tracks[sender].push(t, values, first - self.kept);
    }

    /// The next reading for which all is known, with what each sender says at its time; of the last
    /// ones where the recording has `ended`.
    pub(super) fn next(&mut self, ended: bool) -> Option<(R, Vec<[f64; N]>)> {
        let side = self.side;
        while let Some((t, reading)) = self.readings.pop_front() {
            let is_past = |own: &Track<N>| {
                let after = own.0.len().checked_sub(side);
                after.is_some_and(|k| k + 1 >= side && own.0[k].0 >= t)
            };
            if !ended && !self.tracks.iter().all(is_past) {
                self.readings.push_front((t, reading));
                return None;
            }
            match self.tracks.iter().map(|own| own.at(t, side)).collect() {
                Some(found) => return Some((reading, found)),
                None => self.left_out += 1,
            }
        }
        None
    }
}

/// Readings of the support that wait for the other contact.
pub(super) struct Contacts<R> {
    /// Readings with the force that they are under, N; force of the other contact, N, and its CoP
    /// times that, N m.
    waiting: Waiting<(f64, R), 3>,
    /// Readings in which the other foot was in the air.
    lifted: u64,
}

impl<R> Contacts<R> {
    pub(super) fn new() -> Contacts<R> {
        Contacts {
            waiting: Waiting::new(1, 1, LONGEST_S),
            lifted: 0,
        }
    }

    /// A reading of the support at time `t`, s, under a force, N.
    pub(super) fn reading(&mut self, t: f64, force: f64, reading: R) {
        self.waiting.reading(t, (force.abs(), reading));
    }

    /// Whether the other contact never came.
    pub(super) fn has_no_other(&self) -> bool {
        self.waiting.tracks[0].0.is_empty()
    }

    /// A wrench of the other contact.
    pub(super) fn other(&mut self, t: f64, wrench: [[f64; 3]; 2]) {
        let cop = centre(wrench).filter(|cop| cop.iter().all(|x| x.is_finite()));
        let force = cop.map_or(0.0, |_| wrench[0][2].abs());
        let [x, y] = cop.unwrap_or([0.0; 2]).map(|x| force * x);
        self.waiting.message(0, t, [force, x, y]);
    }

    /// The next reading with what the other contact has; of the last ones where the recording has
    /// `ended`.
    pub(super) fn next(&mut self, ended: bool) -> Option<(R, Share)> {
        while let Some(((own, reading), other)) = self.waiting.next(ended) {
            let [force, x, y] = other[0];
            if force >= LEAST_LOAD_N {
                let share = Share {
                    share: force / (own + force),
                    cop: [x, y].map(|moment| moment / force),
                };
                return Some((reading, share));
            }
            self.lifted += 1;
        }
        None
    }

    /// What is said of `readings` that were left out.
    pub(super) fn conclude(&self, readings: u64) -> Option<String> {
        let (lifted, alone) = (self.lifted, self.waiting.left_out);
        (lifted + alone > 0).then(|| {
            format!(
                "of {readings} readings {lifted} have the other foot in the air, {alone} no \
                 message of it within {LONGEST_S} s; they are left out"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn q(t: f64) -> f64 {
        0.3 - t + 0.5 * t * t - 2.0 * t * t * t
    }

    fn rows(moving: &mut Waiting<f64, 1>, ended: bool) -> Vec<(f64, Vec<f64>)> {
        let rows = std::iter::from_fn(|| moving.next(ended));
        rows.map(|(reading, q)| (reading, q.into_flattened()))
            .collect()
    }

    /// A cubic comes back between messages at uneven stamps, and each joint has stamps of its own.
    #[test]
    fn joints_between_messages_are_those_of_a_cubic() {
        let mut moving = Waiting::for_joints(2);
        let mut found = Vec::new();
        for k in 0..100 {
            let t = 0.02 * f64::from(k) + 0.006 * f64::from(k % 3);
            moving.message(0, t, [q(t)]);
            moving.message(1, t + 0.007, [-q(t + 0.007)]);
            moving.reading(0.0201 * f64::from(k), 0.0201 * f64::from(k));
            found.extend(rows(&mut moving, false));
        }
        assert!(found.len() > 90, "{}", found.len());
        found.extend(rows(&mut moving, true));
        for (t, own) in &found[2..found.len() - 2] {
            assert!((own[0] - q(*t)).abs() < 1e-12, "{t}: {own:?}");
            assert!((own[1] + q(*t)).abs() < 1e-12, "{t}: {own:?}");
        }
        // At the first message of the later joint there is none before it.
        assert_eq!(found.len() as u64 + moving.left_out, 100);
    }

    #[test]
    fn a_reading_at_the_stamp_of_its_joints_has_them_to_the_last_digit() {
        let mut moving = Waiting::for_joints(1);
        for k in 0..5 {
            let t = 1.7e9 + 0.01 * f64::from(k);
            moving.message(0, t, [0.1 + f64::from(k)]);
            moving.reading(t, t);
        }
        let found = rows(&mut moving, true);
        let joints: Vec<f64> = found.iter().map(|row| row.1[0]).collect();
        assert_eq!(joints, [0.1, 1.1, 2.1, 3.1, 4.1]);
    }

    #[test]
    fn readings_in_a_gap_and_beyond_the_ends_are_left_out() {
        let mut moving = Waiting::for_joints(1);
        for (t, at) in [(0.0, 0.05), (0.1, 0.5), (0.9, 0.95), (1.0, 1.2)] {
            moving.message(0, t, [t]);
            moving.reading(at, at);
        }
        let found = rows(&mut moving, true);
        let kept: Vec<f64> = found.iter().map(|row| row.0).collect();
        assert_eq!((kept, moving.left_out), (vec![0.05, 0.95], 2));
        assert!((found[1].1[0] - 0.95).abs() < 1e-12);
    }

    /// Readings without joints, and joints without readings, do not pile up.
    #[test]
    fn memory_does_not_grow_with_what_lacks_its_other_half() {
        let mut moving = Waiting::for_joints(1);
        for k in 0..2 * MOST {
            moving.reading(k as f64, 0.0);
        }
        assert_eq!(moving.left_out, MOST as u64);
        let mut moving: Waiting<f64, 1> = Waiting::for_joints(1);
        for k in 0..2 * MOST {
            moving.message(0, 0.001 * k as f64, [0.0]);
        }
        assert!(
            moving.tracks[0].0.len() < 3000,
            "{}",
            moving.tracks[0].0.len()
        );
    }

    /// A force along z at a point.
    fn at(force: f64, [x, y]: [f64; 2]) -> ([f64; 3], [f64; 3]) {
        ([0.0, 0.0, force], [y * force, -x * force, 0.0])
    }

    /// Half way between 10 N at x = 0.02 m and 30 N at x = 0.06 m there are 20 N, whose moment is
    /// (0.2 + 1.8)/2 = 1 N m: x = 0.05 m.
    #[test]
    fn the_other_contact_is_on_the_line_between_its_messages() {
        let mut contacts = Contacts::new();
        for (t, force, x) in [(1.0, 10.0, 0.02), (1.02, 30.0, 0.06)] {
            let (force, torque) = at(force, [x, -x]);
            contacts.other(t, [force, torque]);
        }
        contacts.reading(1.01, -60.0, "own");
        let (own, other) = contacts.next(false).unwrap();
        assert_eq!(own, "own");
        assert!((other.share - 0.25).abs() < 1e-12, "{other:?}");
        let off = [other.cop[0] - 0.05, other.cop[1] + 0.05];
        assert!(off.iter().all(|x| x.abs() < 1e-12), "{other:?}");
    }

    #[test]
    fn readings_wait_and_those_of_one_foot_are_left_out_and_counted() {
        let mut contacts = Contacts::new();
        contacts.reading(1.0, 50.0, 0);
        assert_eq!(contacts.next(false), None);
        let (force, torque) = at(50.0, [0.0; 2]);
        contacts.other(1.0, [force, torque]);
        assert!(contacts.next(false).is_some());
        // In the air, and between messages that are half a second apart.
        contacts.reading(1.5, 50.0, 1);
        contacts.other(1.5, [[0.0; 3]; 2]);
        contacts.reading(1.75, 50.0, 2);
        contacts.other(2.0, [force, torque]);
        assert_eq!(contacts.next(false), None);
        contacts.reading(2.5, 50.0, 3);
        assert_eq!(contacts.next(true), None);
        assert_eq!((contacts.lifted, contacts.waiting.left_out), (1, 2));
        let said = contacts.conclude(4).unwrap();
        assert!(said.contains("of 4 readings 1 have the other foot in the air, 2 no"));
    }

    #[test]
    fn contacts_without_readings_do_not_pile_up() {
        let mut contacts = Contacts::new();
        let (force, torque) = at(50.0, [0.0; 2]);
        for k in 0..2 * MOST {
            contacts.other(0.001 * k as f64, [force, torque]);
        }
        assert!(
            contacts.waiting.tracks[0].0.len() < 200,
            "{}",
            contacts.waiting.tracks[0].0.len()
        );
        for k in 0..2 * MOST {
            contacts.reading(1e3 + k as f64, 50.0, 0);
        }
        assert_eq!(contacts.waiting.left_out, MOST as u64);
    }
}
