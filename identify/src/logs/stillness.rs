//! Postures in rows or messages in time: the stretches in which the robot holds still.
//!
//! A joint is slow if the velocity in its message is, where there is one, and
//! if it moved less than `speed · duration` within the last `duration`. The
//! second is a difference over the shortest posture, not between neighbouring
//! messages: there a single encoder tick would look like a leap.
//!
//! Rows of a table in time that are of one posture share its `pose`:
//!
//! ```text
//! waiting: │ decided rows │ rows of a stretch that has not ended │
//! ```
//!
//! Rows wait until their stretch has ended, which the cutter ends after a bounded number of rows.
//! The others are of no stay: each is a posture of its own, or is left out.

use super::block::Block;
use super::settings::StillnessLimits;

/// Readings of one posture that are given out together; a longer posture is
/// given out in parts, each with its own mean of the joints.
pub(super) const MOST: usize = 65_536;

/// A posture, or a part of a long one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Posture<R> {
    pub pose: i64,
    /// First moment, s.
    pub t: f64,
    /// Means, rad or m.
    pub q: Vec<f64>,
    pub readings: Vec<R>,
}

/// Cuts a stream of joint states and readings of kind `R` into postures.
pub(super) struct StillnessCutter<R> {
    pub stillness: StillnessLimits,
    now: Option<Current<R>>,
    next_pose: i64,
}

/// The posture that is being held.
struct Current<R> {
    pose: i64,
    start: f64,
    last: f64,
    sum: Vec<f64>,
    states: usize,
    /// Where the joints were at `reference_t`.
    reference: Vec<f64>,
    reference_t: f64,
    readings: Vec<R>,
    /// Readings before the last state in which the robot was seen to hold still.
    confirmed: usize,
}

impl<R> StillnessCutter<R> {
    pub(super) fn new(stillness: StillnessLimits) -> StillnessCutter<R> {
        StillnessCutter {
            stillness,
            now: None,
            next_pose: 0,
        }
    }

    /// All joints at time `t`, and the fastest velocity that was measured;
    /// gives back the posture that ended.
    pub(super) fn state(&mut self, t: f64, q: &[f64], speed: f64) -> Option<Posture<R>> {
        let StillnessLimits {
            speed: limit,
            duration,
        } = self.stillness;
        let slow = speed <= limit && q.iter().all(|q| q.is_finite());
        if let Some(now) = self.now.as_mut().filter(|_| slow) {
            let near = |(q, r): (&f64, &f64)| (q - r).abs() <= limit * duration;
            if t >= now.last && q.iter().zip(&now.reference).all(near) {
                now.see(t, q);
                if t - now.reference_t >= duration {
                    now.reference.copy_from_slice(q);
                    now.reference_t = t;
                }
                return None;
            }
        }
        let ended = self.end();
        self.now = (slow && t.is_finite()).then(|| Current::begun(self.next_pose, t, q));
        ended
    }

    /// Joints and a reading of one moment; gives back the posture that ended, or a part of one
    /// that has grown long.
    pub(super) fn row(&mut self, t: f64, q: &[f64], reading: R) -> Option<Posture<R>> {
        let ended = self.state(t, q, 0.0);
        let part = self.reading(reading);
        if let Some(now) = &mut self.now {
            now.confirmed = now.readings.len();
        }
        ended.or(part)
    }

    /// The first reading of the stretch that has not ended.
    pub(super) fn first(&self) -> Option<&R> {
        self.now.as_ref()?.readings.first()
    }

    /// A reading; gives back a part of a posture that has grown long.
    pub(super) fn reading(&mut self, reading: R) -> Option<Posture<R>> {
        let now = self.now.as_mut()?;
        now.readings.push(reading);
        if now.readings.len() < MOST {
            return None;
        }
        let long = now.is_held(self.stillness) && now.confirmed > 0;
        let part = now.part();
        now.confirmed = 0;
        long.then(|| {
            self.next_pose = part.pose + 1;
            part
        })
    }

    /// The recording or the posture ends.
    pub(super) fn end(&mut self) -> Option<Posture<R>> {
        let mut now = self.now.take()?;
        now.is_held(self.stillness).then(|| {
            self.next_pose = now.pose + 1;
            now.part()
        })
    }
}

impl<R> Current<R> {
    fn begun(pose: i64, t: f64, q: &[f64]) -> Current<R> {
        let mut now = Current {
            pose,
            start: t,
            last: t,
            sum: vec![0.0; q.len()],
            states: 0,
            reference: q.to_vec(),
            reference_t: t,
            readings: Vec::new(),
            confirmed: 0,
        };
        now.see(t, q);
        now
    }

    /// Whether it was held for so long that it is a posture.
    fn is_held(&self, stillness: StillnessLimits) -> bool {
        self.last - self.start >= stillness.duration
    }

    fn see(&mut self, t: f64, q: &[f64]) {
        self.sum.iter_mut().zip(q).for_each(|(sum, q)| *sum += q);
        self.states += 1;
        self.last = t;
        self.confirmed = self.readings.len();
    }

    /// What was seen up to now, which is forgotten.
    fn part(&mut self) -> Posture<R> {
        let mut readings = std::mem::take(&mut self.readings);
        readings.truncate(self.confirmed);
        let q = match self.states {
            0 => self.reference.clone(),
            states => self.sum.iter().map(|sum| sum / states as f64).collect(),
        };
        self.sum.fill(0.0);
        self.states = 0;
        Posture {
            pose: self.pose,
            t: self.start,
            q,
            readings,
        }
    }
}

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
    /// Leave out rows of no stay, which lasts so many seconds.
    alone: Option<f64>,
    /// Rows that wait, and whether each is of a stay.
    waiting: Block,
    held: Vec<bool>,
    /// Number of the first of them, and how many were given out.
    first: usize,
    given: usize,
    /// The stay of the last posture that was found, and the `pose` of its rows.
    last: Option<(i64, i64)>,
    /// Stays so far.
    stays: usize,
    /// Whether the log has ended.
    ended: bool,
}

impl Settling {
    /// Stays in a log of `dof` joints; where `alone` says of how many seconds at least, without the
    /// rows between them.
    pub(super) fn new(dof: usize, alone: Option<f64>) -> Settling {
        let limits = alone.map_or(STAYED, StillnessLimits::lasting);
        Settling {
            dof,
            cutter: StillnessCutter::new(limits),
            alone,
            waiting: Block::default(),
            held: Vec::new(),
            first: 0,
            given: 0,
            last: None,
            stays: 0,
            ended: false,
        }
    }

    /// The next rows of the log, which has ended where there are none.
    pub(super) fn push(&mut self, block: Block) {
        if block.is_empty() {
            let ended = self.cutter.end();
            self.keep(ended);
            self.ended = true;
            return;
        }
        if self.given > 0 {
            self.waiting = self.waiting.select(self.given..self.held.len());
            self.held.drain(..self.given);
            self.first += std::mem::take(&mut self.given);
        }
        let (t, q) = (block.t.clone().unwrap_or_default(), block.q.clone());
        let next = self.first + self.held.len();
        self.held.resize(self.held.len() + block.len(), false);
        self.waiting.append(block);
        for (row, (t, q)) in (next..).zip(t.iter().zip(q.chunks_exact(self.dof))) {
            let ended = self.cutter.row(*t, q, row);
            self.keep(ended);
        }
    }

    /// The next `count` rows, once it is known of each whether it is of a stay; fewer are the last
    /// ones, none the end of the log. Who reads looks ahead by one block: a short one in mid-log
    /// would hide what follows it.
    ///
    /// # Errors
    /// What is said of a log without stays, where they alone were asked for.
    pub(super) fn take(&mut self, count: usize) -> Result<Option<Block>, String> {
        let open = self.cutter.first().filter(|_| !self.ended);
        let decided = open.map_or(self.held.len(), |open| open - self.first);
        while self.given < decided && (self.ended || decided - self.given >= count) {
            let end = decided.min(self.given.saturating_add(count));
            let is_kept = |row: &usize| self.alone.is_none() || self.held[*row];
            let block = self.waiting.select((self.given..end).filter(is_kept));
            self.given = end;
            if !block.is_empty() {
                return Ok(Some(block));
            }
        }
        match self.alone.filter(|_| self.stays == 0) {
            _ if !self.ended => Ok(None),
            Some(duration) => Err(StillnessLimits::lasting(duration).nothing()),
            None => Ok(Some(Block::default())),
        }
    }

    fn keep(&mut self, posture: Option<Posture<usize>>) {
        let Some(posture) = posture else {
            return;
        };
        let known = self.last.filter(|(stay, _)| *stay == posture.pose);
        self.stays += usize::from(known.is_none());
        let mut pose = known.map(|(_, pose)| pose);
        for row in posture.readings {
            let at = row - self.first;
            self.waiting.pose[at] = *pose.get_or_insert(self.waiting.pose[at]);
            self.held[at] = true;
            if self.alone.is_some() {
                self.waiting.q[at * self.dof..(at + 1) * self.dof].copy_from_slice(&posture.q);
            }
        }
        self.last = pose.map(|pose| (posture.pose, pose));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Postures of one joint that is recorded every 10 ms, with a reading each.
    fn postures(angle: impl Fn(f64) -> f64, speed: f64) -> Vec<Posture<f64>> {
        let mut cutter = StillnessCutter::new(StillnessLimits::lasting(0.3));
        let mut found = Vec::new();
        for k in 0..300 {
            let t = f64::from(k) * 0.01;
            found.extend(cutter.state(t, &[angle(t)], speed));
            found.extend(cutter.reading(t));
        }
        found.extend(cutter.end());
        found
    }

    #[test]
    fn a_stop_between_two_motions_is_a_posture() {
        // At 1 rad from 1 s to 2 s.
        let found = postures(|t| t.min(1.0) + (t - 2.0).max(0.0), 0.0);
        assert_eq!(found.len(), 1, "{found:?}");
        let posture = &found[0];
        assert!((posture.q[0] - 1.0).abs() < 1e-3);
        assert!((posture.t - 1.0).abs() < 0.02);
        assert!(posture.readings.len() >= 98 && posture.readings.len() <= 102);
        assert_eq!(posture.pose, 0);
    }

    #[test]
    fn encoder_ticks_are_still_and_creeping_is_not() {
        let tick = 0.0015;
        let odd = |t: f64| f64::from(u8::from((t * 50.0).rem_euclid(2.0) >= 1.0));
        let ticking = postures(|t| tick * odd(t), 0.0);
        assert_eq!(ticking.len(), 1);
        assert!((ticking[0].q[0] - tick / 2.0).abs() < 1e-4);
        assert_eq!(postures(|t| 0.1 * t, 0.0), []);
        let slow = postures(|t| 0.01 * t, 0.0);
        assert_eq!(slow.len(), 1, "slower than the threshold");
        assert_eq!(postures(|_| 0.0, 0.03), [], "the message says it moves");
    }

    #[test]
    fn a_long_posture_is_given_out_in_parts_of_one_pose() {
        let mut cutter = StillnessCutter::new(StillnessLimits::lasting(0.3));
        let (mut found, mut readings) = (Vec::new(), 0);
        for k in 0..2 * MOST {
            found.extend(cutter.state(k as f64 * 0.01, &[0.5], 0.0));
            found.extend(cutter.reading(k));
        }
        found.extend(cutter.end());
        for part in &found {
            assert_eq!((part.pose, &part.q[..]), (0, &[0.5][..]));
            assert!(part.readings.len() <= MOST);
            readings += part.readings.len();
        }
        assert!(found.len() > 1 && readings > 2 * MOST - 4);
    }

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

    /// The blocks of `count` rows of which it is known by now.
    fn decided(settling: &mut Settling, count: usize) -> Vec<Block> {
        let next = || settling.take(count).ok().flatten();
        let next = std::iter::from_fn(next);
        next.take_while(|block| !block.is_empty()).collect()
    }

    /// The blocks that come of a log which is given in blocks of a size.
    fn blocks(mut settling: Settling, log: &Block, size: usize) -> Vec<Block> {
        let mut blocks = Vec::new();
        for start in (0..log.len()).step_by(size) {
            let mut block = log.clone();
            let rows = 0..log.len();
            let keep: Vec<bool> = rows.map(|k| (start..start + size).contains(&k)).collect();
            block.retain(&keep);
            settling.push(block);
            blocks.extend(decided(&mut settling, size));
        }
        settling.push(Block::default());
        blocks.extend(decided(&mut settling, size));
        blocks
    }

    /// The same as one.
    fn through(settling: Settling, log: &Block, size: usize) -> Block {
        let mut all = Block::default();
        for block in blocks(settling, log, size) {
            all.line.extend(block.line);
            all.pose.extend(block.pose);
            all.q.extend(block.q);
            all.t.get_or_insert_default().extend(block.t.unwrap());
        }
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
            let found = through(Settling::new(1, None), &log(400, stop), size);
            assert_eq!(found.line, (2..402).collect::<Vec<u64>>());
            let stay = found.pose.iter().filter(|pose| **pose == found.pose[200]);
            assert!((198..=202).contains(&stay.count()), "{:?}", found.pose);
            assert_eq!(found.pose[50], 50);
            assert_eq!(found.pose[350], 350);
            assert_eq!(found.q, log(400, stop).q);
        }
    }

    #[test]
    fn blocks_are_whole_until_the_log_ends() {
        // A row that moves is known by the next one, those of the stay at its end.
        for (size, whole) in [(64, 6), (150, 2), (7, 57)] {
            let blocks = blocks(Settling::new(1, None), &log(400, stop), size);
            let sizes: Vec<usize> = blocks.iter().map(Block::len).collect();
            assert_eq!(
                sizes,
                [&vec![size; whole][..], &[400 - whole * size]].concat()
            );
        }
    }

    #[test]
    fn rows_of_a_slow_path_are_of_no_stay() {
        // Turns back every 5 s.
        let slow = |t: f64| 0.1 * (0.2 * std::f64::consts::PI * t).sin();
        let found = through(Settling::new(1, None), &log(3000, slow), 512);
        assert_eq!(found, log(3000, slow));
    }

    #[test]
    fn alone_stays_are_given_out_with_the_mean_of_their_joints() {
        let found = through(Settling::new(1, Some(0.5)), &log(400, stop), 100);
        assert!((198..=206).contains(&found.len()), "{}", found.len());
        let same = |all: &[f64]| all.iter().all(|q| *q == all[0]);
        assert!(same(&found.q) && found.q[0].abs() < 1e-3, "{}", found.q[0]);
        assert!(found.pose.iter().all(|pose| *pose == found.pose[0]));
        let none = through(Settling::new(1, Some(2.5)), &log(400, stop), 100);
        assert_eq!(none.len(), 0);
    }
}
