//! Readings of a robot that moves, with the joints between their messages.
//!
//! ```text
//! q_j(t) = Σ_k q_jk Π_{i≠k} (t − t_i)/(t_k − t_i)        the two messages before t, the two after
//! ```
//!
//! Each joint has the stamps of its own messages: topics of arms and legs need not agree. Where
//! messages on either side of a reading are too far apart, the reading is left out; where there is
//! but one beyond, the polynomial is of lower order.

use std::collections::VecDeque;

/// Messages of a joint between which a reading may lie are no further apart, s. Closed form: the
/// cubic errs by `3/128 (ω Δt)⁴` of a sine of ω, 0.1 % at 0.7 Hz; at twice as much 1.4 %.
pub(super) const LONGEST_S: f64 = 0.1;
/// Messages of a joint that are kept, s: readings may arrive so much later than joints.
const KEPT_S: f64 = 2.0;
/// Messages of a joint, and readings that wait for them, at most.
const MOST: usize = 65_536;
/// Messages on either side of a reading.
const SIDE: usize = 2;

/// A reading at time `t` with the joints there.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Row<R> {
    pub q: Vec<f64>,
    pub reading: R,
}

/// Joints and readings, each in the order of their stamps.
pub(super) struct Moving<R> {
    /// Stamps and positions of each joint.
    joints: Vec<VecDeque<[f64; 2]>>,
    waiting: VecDeque<(f64, R)>,
    /// Readings that lie between no messages that are close enough.
    pub left_out: u64,
}

impl<R> Moving<R> {
    pub fn new(dof: usize) -> Moving<R> {
        Moving {
            joints: vec![VecDeque::new(); dof],
            waiting: VecDeque::new(),
            left_out: 0,
        }
    }

    /// A position of a joint at time `t`. Stamps that go back begin anew, and one that is there
    /// already says nothing.
    pub fn position(&mut self, joint: usize, t: f64, q: f64) {
        let all = &mut self.joints[joint];
        let last = all.back().map_or(f64::NEG_INFINITY, |[last, _]| *last);
        if !(t.is_finite() && q.is_finite()) || t == last {
            return;
        }
        if t < last {
            if last - t < KEPT_S {
                return;
            }
            all.clear();
        }
        all.push_back([t, q]);
        let before = self.waiting.front().map_or(t, |(at, _)| at.min(t)) - KEPT_S;
        while all.len() > 2 * SIDE && (all[SIDE][0] < before || all.len() > MOST) {
            all.pop_front();
        }
    }

    /// A reading at time `t`.
    pub fn reading(&mut self, t: f64, reading: R) {
        if !t.is_finite() || self.waiting.len() >= MOST {
            self.left_out += 1;
            return;
        }
        self.waiting.push_back((t, reading));
    }

    /// The next reading whose joints are known; of the last ones where the recording has `ended`.
    pub fn next(&mut self, ended: bool) -> Option<Row<R>> {
        while let Some((t, _)) = self.waiting.front() {
            let t = *t;
            let past = |all: &VecDeque<[f64; 2]>| all.len() > SIDE && all[all.len() - SIDE][0] >= t;
            if !ended && !self.joints.iter().all(past) {
                return None;
            }
            let q: Option<Vec<f64>> = self.joints.iter().map(|all| between(all, t)).collect();
            let (_, reading) = self.waiting.pop_front()?;
            match q {
                Some(q) => return Some(Row { q, reading }),
                None => self.left_out += 1,
            }
        }
        None
    }
}

/// The position at time `t` between messages of a joint; none where they are too far apart.
fn between(all: &VecDeque<[f64; 2]>, t: f64) -> Option<f64> {
    let after = all.partition_point(|[at, _]| *at < t);
    let [next, q] = *all.get(after)?;
    if next == t {
        return Some(q);
    }
    let before = after.checked_sub(1)?;
    let near = |a: usize, b: usize| all[b][0] - all[a][0] <= LONGEST_S;
    if !near(before, after) {
        return None;
    }
    let first = match before.checked_sub(1) {
        Some(first) if near(first, before) => first,
        _ => before,
    };
    let last = match after + 1 < all.len() && near(after, after + 1) {
        true => after + 1,
        false => after,
    };
    let weight = |k: usize| -> f64 {
        let others = (first..=last).filter(|i| *i != k);
        others
            .map(|i| (t - all[i][0]) / (all[k][0] - all[i][0]))
            .product()
    };
    Some((first..=last).map(|k| weight(k) * all[k][1]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn q(t: f64) -> f64 {
        0.3 - t + 0.5 * t * t - 2.0 * t * t * t
    }

    fn rows(moving: &mut Moving<f64>, ended: bool) -> Vec<Row<f64>> {
        std::iter::from_fn(|| moving.next(ended)).collect()
    }

    /// A cubic comes back between messages at uneven stamps, and each joint has stamps of its own.
    #[test]
    fn joints_between_messages_are_those_of_a_cubic() {
        let mut moving = Moving::new(2);
        let mut found = Vec::new();
        for k in 0..100 {
            let t = 0.02 * f64::from(k) + 0.006 * f64::from(k % 3);
            moving.position(0, t, q(t));
            moving.position(1, t + 0.007, -q(t + 0.007));
            moving.reading(0.0201 * f64::from(k), 0.0201 * f64::from(k));
            found.extend(rows(&mut moving, false));
        }
        assert!(found.len() > 90, "{}", found.len());
        found.extend(rows(&mut moving, true));
        for Row { q: own, reading: t } in &found[2..found.len() - 2] {
            assert!((own[0] - q(*t)).abs() < 1e-12, "{t}: {own:?}");
            assert!((own[1] + q(*t)).abs() < 1e-12, "{t}: {own:?}");
        }
        // At the first message of the later joint there is none before it.
        assert_eq!(found.len() as u64 + moving.left_out, 100);
    }

    #[test]
    fn a_reading_at_the_stamp_of_its_joints_has_them_to_the_last_digit() {
        let mut moving = Moving::new(1);
        for k in 0..5 {
            let t = 1.7e9 + 0.01 * f64::from(k);
            moving.position(0, t, 0.1 + f64::from(k));
            moving.reading(t, t);
        }
        let found = rows(&mut moving, true);
        let joints: Vec<f64> = found.iter().map(|row| row.q[0]).collect();
        assert_eq!(joints, [0.1, 1.1, 2.1, 3.1, 4.1]);
    }

    #[test]
    fn readings_in_a_gap_and_beyond_the_ends_are_left_out() {
        let mut moving = Moving::new(1);
        for (t, at) in [(0.0, 0.05), (0.1, 0.5), (0.9, 0.95), (1.0, 1.2)] {
            moving.position(0, t, t);
            moving.reading(at, at);
        }
        let found = rows(&mut moving, true);
        let kept: Vec<f64> = found.iter().map(|row| row.reading).collect();
        assert_eq!((kept, moving.left_out), (vec![0.05, 0.95], 2));
        assert!((found[1].q[0] - 0.95).abs() < 1e-12);
    }

    /// Readings without joints, and joints without readings, do not pile up.
    #[test]
    fn memory_does_not_grow_with_what_lacks_its_other_half() {
        let mut moving = Moving::new(1);
        for k in 0..2 * MOST {
            moving.reading(k as f64, 0.0);
        }
        assert_eq!(moving.left_out, MOST as u64);
        let mut moving: Moving<f64> = Moving::new(1);
        for k in 0..2 * MOST {
            moving.position(0, 0.001 * k as f64, 0.0);
        }
        assert!(moving.joints[0].len() < 3000, "{}", moving.joints[0].len());
    }
}
