//! Which rows of a table in time are readings of one stay.
//!
//! ```text
//! waiting: │ decided rows │ rows of a stretch that has not ended │
//! ```
//!
//! Postures are found as in a recording ([`StillnessCutter`]); rows of one share its `pose`. Rows
//! wait until their stretch has ended, which the cutter ends after a bounded number of rows. The
//! others are of no stay: each is a posture of its own, or is left out.

use super::block::Block;
use super::options::StillnessLimits;
use super::stillness::{Posture, StillnessCutter};

/// What is a stay where nobody says: hardly more than a tick of an encoder (2π/4096) in a
/// whole second. Joints that turn back on a slow path are as still for less than that.
const STAYED: StillnessLimits = StillnessLimits {
    speed: 0.0016,
    duration: 1.0,
};

/// Rows on their way from the file to who reads them.
pub(super) struct Settling {
    dof: usize,
    cutter: StillnessCutter<usize>,
    /// Leave out rows of no stay.
    alone: bool,
    waiting: Block,
    /// Whether each of these is of a stay.
    held: Vec<bool>,
    /// Numbers of the first that waits and of the next to come.
    first: usize,
    next: usize,
    /// The stay of the last posture that was found, and the `pose` of its rows.
    last: Option<(i64, i64)>,
    /// Stays so far.
    pub stays: usize,
    /// Whether the log has ended.
    pub ended: bool,
}

impl Settling {
    /// Stays where nobody says what one is, in a log of `dof` joints.
    pub fn new(dof: usize) -> Settling {
        Settling::by(STAYED, false, dof)
    }

    /// The same of stays of at least `duration` seconds, without the rows between them.
    pub fn alone(duration: f64, dof: usize) -> Settling {
        let stillness = StillnessLimits {
            duration,
            ..StillnessLimits::default()
        };
        Settling::by(stillness, true, dof)
    }

    fn by(stillness: StillnessLimits, alone: bool, dof: usize) -> Settling {
        Settling {
            dof,
            cutter: StillnessCutter::new(stillness),
            alone,
            waiting: Block::default(),
            held: Vec::new(),
            first: 0,
            next: 0,
            last: None,
            stays: 0,
            ended: false,
        }
    }

    /// The next rows of the log.
    pub fn push(&mut self, block: Block) {
        let (from, dof) = (self.first, self.dof);
        self.held.resize(self.held.len() + block.len(), false);
        let rows = block.len();
        self.waiting.append(block);
        for _ in 0..rows {
            let at = self.next - from;
            let t = self.waiting.t.as_ref().map_or(0.0, |all| all[at]);
            let q = &self.waiting.q[at * dof..(at + 1) * dof];
            let ended = self.cutter.row(t, q, self.next);
            self.next += 1;
            self.keep(ended);
        }
    }

    /// The log has ended.
    pub fn end(&mut self) {
        let ended = self.cutter.end();
        self.keep(ended);
        self.ended = true;
    }

    /// Rows whose posture is known.
    pub fn decided(&self) -> usize {
        let open = self.cutter.first().filter(|_| !self.ended);
        open.copied().unwrap_or(self.next) - self.first
    }

    /// `count` of those at most.
    pub fn take(&mut self, count: usize) -> Block {
        let count = count.min(self.decided());
        let mut block = self.waiting.split_first(count);
        let held: Vec<bool> = self.held.drain(..count).collect();
        self.first += count;
        if self.alone {
            block.retain(&held);
        }
        block
    }

    fn keep(&mut self, posture: Option<Posture<usize>>) {
        let Some(posture) = posture else {
            return;
        };
        let Some(first) = posture.readings.first().map(|row| row - self.first) else {
            return;
        };
        let known = self.last.filter(|(stay, _)| *stay == posture.pose);
        let (_, pose) = known.unwrap_or((0, self.waiting.pose[first]));
        self.stays += usize::from(known.is_none());
        self.last = Some((posture.pose, pose));
        for row in posture.readings {
            let at = row - self.first;
            self.waiting.pose[at] = pose;
            self.held[at] = true;
            if self.alone {
                let q = &mut self.waiting.q[at * self.dof..(at + 1) * self.dof];
                q.copy_from_slice(&posture.q);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows every 10 ms of one joint at `angle`.
    fn log(rows: usize, angle: impl Fn(f64) -> f64) -> Block {
        let t: Vec<f64> = (0..rows).map(|k| k as f64 * 0.01).collect();
        Block {
            line: (2..rows as u64 + 2).collect(),
            pose: (0..rows as i64).collect(),
            q: t.iter().map(|t| angle(*t)).collect(),
            t: Some(t),
            ..Block::default()
        }
    }

    fn through(mut settling: Settling, log: Block, size: usize) -> Block {
        let (mut log, mut all) = (log, Block::default());
        while !log.is_empty() {
            settling.push(log.split_first(size));
            all.append(settling.take(usize::MAX));
        }
        settling.end();
        all.append(settling.take(usize::MAX));
        all
    }

    /// Moves for a second, stays for two, moves for one.
    fn stop(t: f64) -> f64 {
        match t {
            t if t < 1.0 => t - 1.0,
            t if t < 3.0 => 0.0004 * (31.0 * t).sin(),
            t => t - 3.0,
        }
    }

    #[test]
    fn rows_of_a_stay_share_its_pose_whatever_the_blocks() {
        for size in [1, 7, 64, 1000] {
            let found = through(Settling::new(1), log(400, stop), size);
            assert_eq!(found.line, (2..402).collect::<Vec<u64>>());
            let stay = found.pose.iter().filter(|pose| **pose == found.pose[200]);
            assert!((198..=202).contains(&stay.count()), "{:?}", found.pose);
            assert_eq!(found.pose[50], 50);
            assert_eq!(found.pose[350], 350);
            assert_eq!(found.q, log(400, stop).q);
        }
    }

    #[test]
    fn rows_of_a_slow_path_are_of_no_stay() {
        // Turns back every 5 s.
        let slow = |t: f64| 0.1 * (0.2 * std::f64::consts::PI * t).sin();
        let found = through(Settling::new(1), log(3000, slow), 512);
        assert_eq!(found, log(3000, slow));
    }

    #[test]
    fn alone_stays_are_given_out_with_the_mean_of_their_joints() {
        let found = through(Settling::alone(0.5, 1), log(400, stop), 100);
        assert!((198..=206).contains(&found.len()), "{}", found.len());
        let same = |all: &[f64]| all.iter().all(|q| *q == all[0]);
        assert!(same(&found.q) && found.q[0].abs() < 1e-3, "{}", found.q[0]);
        assert!(found.pose.iter().all(|pose| *pose == found.pose[0]));
        let none = through(Settling::alone(2.5, 1), log(400, stop), 100);
        assert_eq!(none.len(), 0);
    }
}
