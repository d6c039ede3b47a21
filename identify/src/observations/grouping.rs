//! Which rows of a log are readings of one posture, also where rows come back to
//! it later.
//!
//! ```text
//! same posture    same `pose` and support,  max_j |q_j − q_j(first row)| ≤ 0.02 rad
//! ```
//!
//! Repeated readings tell the noise and belong to one fold. Two sessions that were
//! numbered alike share a `pose` and not the joint positions: they are postures of
//! their own. A posture needs some 100 bytes and 4 per joint here, and [`MOST`] of
//! them are known at a time; those of longer logs are one posture only as long as
//! their rows follow each other.
//!
//! A posture that is reached again under another number is known by its joint positions, where
//! the log itself shows how well they come back: by edges of the shortest tree that joins all
//! postures, d(a, b) = max_j |q̄_aj − q̄_bj|.
//!
//! ```text
//! within postures    d ≤ D        between them    d > A D        nothing between D and A D
//! ```
//!
//! Postures along a trajectory, on a grid or drawn at random have no such gap.

use std::collections::HashMap;
use std::f32::consts::TAU;

use super::criteria::repeats::{APART, FEWEST, REACHED};
use super::repeats::Group;
use crate::logs::Block;

/// Postures known at a time: some 45 MB for 20 joints, and 65 MB while lists grow to that.
pub(crate) const MOST: usize = 200_000;

/// Repeated readings are of one posture up to this, rad or m: servos jitter.
const JITTER: f32 = 0.02;

/// Gravity where a log does not give it.
pub(crate) const DOWN: [f64; 3] = [0.0, 0.0, -1.0];

/// Postures among which those are looked for that are reached again, at most: longer logs are
/// recordings.
const LOOKED: usize = 4000;

/// `pose` and the number of the support.
type Name = (i64, u32);

/// What is kept of a posture.
#[derive(Debug, Clone, PartialEq)]
pub struct Posture {
    /// What deals its rows to their fold.
    pub key: i64,
    /// How many postures began before it.
    pub number: usize,
    /// Its readings.
    pub group: Group,
    /// Times that rows came back to it, the first included.
    pub visits: u32,
    /// Number of its last row, less whole turns of its counter.
    last_row: u32,
    /// Its rows, and the number of their support.
    rows: u32,
    support: u32,
}

/// Postures that rows may come back to.
#[derive(Debug, Clone, PartialEq)]
pub struct Grouping {
    most: usize,
    /// Joint positions may be degrees that are taken for radians.
    any_unit: bool,
    /// The largest `pose` among them: beyond it no posture is known, and none is looked for.
    largest: i64,
    /// Those that are known in the order of their first rows, and the last one for which there was
    /// no room.
    postures: Vec<Posture>,
    /// Joints and the direction of gravity in the first row of each posture, rad or m.
    at: Vec<f32>,
    /// Their means over the rows of each of the first [`LOOKED`] postures.
    mean: Vec<f32>,
    /// The last posture for which there was no room: its number is one beyond the others'.
    last: Option<Name>,
    /// Links on the ground, each with the numbers of its postures by their `pose`.
    supports: Vec<(String, HashMap<i64, u32>)>,
    /// Postures that began, also those for which there was no room.
    begun: usize,
    /// Rows whose robot had moved although their `pose` was known.
    moved: u64,
    /// Rows so far, as [`Posture::last_row`].
    rows: u32,
}

impl Default for Grouping {
    fn default() -> Grouping {
        Grouping::up_to(MOST)
    }
}

impl Grouping {
    /// At most `most` known at a time.
    pub fn up_to(most: usize) -> Grouping {
        Grouping {
            most,
            any_unit: false,
            largest: i64::MIN,
            postures: Vec::new(),
            at: Vec::new(),
            mean: Vec::new(),
            last: None,
            supports: Vec::new(),
            begun: 0,
            moved: 0,
            rows: 0,
        }
    }

    /// For a log whose unit is in question: beyond a whole turn, joint positions are
    /// compared as degrees.
    pub fn of_any_unit(any_unit: bool) -> Grouping {
        Grouping {
            any_unit,
            ..Grouping::default()
        }
    }

    /// Rows so far that shared the `pose` of an earlier row but not its joint
    /// positions.
    pub fn moved(&self) -> u64 {
        self.moved
    }

    /// Whether there were more postures than can be known.
    pub fn full(&self) -> bool {
        self.last.is_some()
    }

    /// Forget all postures: poses of another log are others.
    pub fn clear(&mut self) {
        *self = Grouping {
            any_unit: self.any_unit,
            moved: self.moved,
            ..Grouping::up_to(self.most)
        };
    }

    /// The posture of a row, which stands on `support` with joints `q` (rad or m), as many in
    /// every row, and gravity along the vector `gravity`.
    pub fn of_row(
        &mut self,
        (pose, support): (i64, &str),
        q: &[f64],
        gravity: [f64; 3],
    ) -> &mut Posture {
        let name = (pose, self.number(support));
        self.rows = self.rows.wrapping_add(1);
        let down = direction(gravity);
        let values = || q.iter().chain(&down).map(|&x| x as f32);
        let width = q.len() + down.len();
        let known = (pose <= self.largest).then(|| self.supports[name.1 as usize].1.get(&pose));
        let known = known.flatten().map(|number| *number as usize);
        let is_last = self.last == Some(name);
        let known = known.or_else(|| is_last.then_some(self.most));
        let mut key = pose;
        if let Some(known) = known {
            let first = &self.at[known * width..(known + 1) * width];
            let degrees = self.any_unit && first.iter().any(|a| a.abs() > TAU);
            let jitter = if degrees { JITTER.to_degrees() } else { JITTER };
            let mut pairs = first.iter().zip(values());
            if !pairs.any(|(a, b)| (a - b).abs() > jitter) {
                let posture = &mut self.postures[known];
                posture.visits += u32::from(posture.last_row.wrapping_add(1) != self.rows);
                posture.last_row = self.rows;
                posture.rows = posture.rows.saturating_add(1);
                let rows = posture.rows as f32;
                let mean = self.mean.iter_mut().skip(known * width).take(width);
                mean.zip(values()).for_each(|(m, x)| *m += (x - *m) / rows);
                return posture;
            }
            self.moved += 1;
            // A fold of its own: as good as drawn, and not that of the other posture.
            key = pose.wrapping_add((self.moved as i64).wrapping_mul(0x5851_f42d));
        }
        // Where there is no room it takes the place of the posture of its name, or of the last one.
        let is_full = self.postures.len() >= self.most;
        let place = known.filter(|_| is_full).unwrap_or_else(|| {
            let place = self.postures.len().min(self.most);
            match is_full {
                true => self.last = Some(name),
                false => {
                    self.supports[name.1 as usize].1.insert(pose, place as u32);
                    self.largest = self.largest.max(pose);
                }
            }
            if place < LOOKED.min(self.most) {
                self.mean.extend(values());
            }
            place
        });
        let new = Posture {
            key,
            number: self.begun,
            group: Group::default(),
            visits: 1,
            last_row: self.rows,
            rows: 1,
            support: name.1,
        };
        self.begun += 1;
        if place < self.postures.len() {
            self.postures[place] = new;
            let at = self.at[place * width..].iter_mut();
            at.zip(values()).for_each(|(to, from)| *to = from);
        } else {
            self.postures.push(new);
            self.at.extend(values());
        }
        &mut self.postures[place]
    }

    /// Supports are few, rows are many.
    fn number(&mut self, support: &str) -> u32 {
        let known = self.supports.iter().position(|(other, _)| other == support);
        let at = known.unwrap_or_else(|| {
            self.supports.push((support.to_string(), HashMap::new()));
            self.supports.len() - 1
        });
        at as u32
    }

    /// A posture by the order of first rows.
    pub fn posture(&self, k: usize) -> &Posture {
        &self.postures[k]
    }

    /// Whether each posture has several rows, so that a log that is dense in time is one of stays
    /// alone.
    pub fn is_of_stays(&self) -> bool {
        self.postures.iter().all(|posture| posture.rows > 1)
    }

    /// Where the robot stands in each posture, of at most [`LOOKED`]: means of its joint positions,
    /// and the direction of gravity.
    pub fn stances(&self) -> Block {
        let width = self.width();
        let mut block = Block::default();
        let (mut supports, mut gravity) = (Vec::new(), Vec::new());
        for (mean, posture) in self.mean.chunks_exact(width).zip(&self.postures) {
            let mean = mean.iter().map(|x| f64::from(*x));
            block.line.push(0);
            block.q.extend(mean.clone().take(width - 2));
            supports.push(self.supports[posture.support as usize].0.as_str().into());
            let down: Vec<f64> = mean.skip(width - 2).collect();
            let [x, y] = [down[0], down[1]];
            gravity.push([x, y, -(1.0 - x * x - y * y).max(0.0).sqrt()]);
        }
        block.support = Some(supports);
        block.gravity = Some(gravity);
        block
    }

    /// Of each posture the first one that it is a visit of, itself where it was not reached
    /// before; none where none was, as far as their joint positions show. A posture that follows
    /// its like is not reached again.
    pub fn reached_again(&self) -> Option<Vec<usize>> {
        let n = self.postures.len();
        let in_degrees = self.any_unit && self.at.iter().any(|x| x.abs() > TAU);
        if n >= LOOKED.min(self.most) || in_degrees {
            return None;
        }
        let edges = self.shortest_tree();
        let fewest = FEWEST as usize / 2;
        // From the widest distance within postures to the least.
        (fewest..edges.len()).rev().find_map(|count| {
            let (within, between) = (edges[count - 1].0, edges[count].0);
            if within > REACHED || between <= APART * within {
                return None;
            }
            let mut first = joined(n, &edges[..count]);
            let mut visits = vec![Vec::new(); n];
            for (k, first) in first.iter().enumerate() {
                visits[*first].push(k);
            }
            let apart = |k: &usize, visits: &[usize]| {
                visits.iter().any(|other| {
                    let distance = self.distance(*k, *other, f32::INFINITY);
                    distance > REACHED || between <= APART * distance
                })
            };
            if visits.iter().any(|own| own.iter().any(|k| apart(k, own))) {
                return None;
            }
            for pair in (1..n).rev().map(|k| [k - 1, k]) {
                if first[pair[0]] == first[pair[1]] {
                    first[pair[1]] = pair[1];
                }
            }
            let again = (0..n).filter(|k| first[*k] < *k).count();
            (again >= fewest).then_some(first)
        })
    }

    fn width(&self) -> usize {
        (self.at.len() / self.postures.len().max(1)).max(1)
    }

    /// Largest difference of joint positions or of gravity, where it is below `most`; infinite
    /// elsewhere, and on different supports.
    fn distance(&self, a: usize, b: usize, most: f32) -> f32 {
        if self.postures[a].support != self.postures[b].support {
            return f32::INFINITY;
        }
        let width = self.width();
        let of = |k: usize| &self.mean[k * width..(k + 1) * width];
        let mut sizes = of(a).iter().zip(of(b)).map(|(a, b)| (a - b).abs());
        let below = |largest: f32, size: f32| (size < most).then_some(largest.max(size));
        sizes.try_fold(0.0, below).unwrap_or(f32::INFINITY)
    }

    /// Edges of the shortest tree that joins all postures, the shortest first (Prim 1957).
    fn shortest_tree(&self) -> Vec<(f32, usize, usize)> {
        let mut open: Vec<(f32, usize, usize)> = (1..self.postures.len())
            .map(|k| (self.distance(0, k, f32::INFINITY), 0, k))
            .collect();
        let mut edges = Vec::with_capacity(open.len());
        while let Some(next) = (0..open.len()).min_by(|a, b| open[*a].0.total_cmp(&open[*b].0)) {
            let edge = open.swap_remove(next);
            edges.push(edge);
            for other in &mut open {
                let distance = self.distance(edge.2, other.2, other.0);
                if distance < other.0 {
                    *other = (distance, edge.2, other.2);
                }
            }
        }
        edges.sort_by(|a, b| a.0.total_cmp(&b.0));
        edges
    }
}

/// The first of those that `edges` join, of each of `n`.
fn joined(n: usize, edges: &[(f32, usize, usize)]) -> Vec<usize> {
    let mut first: Vec<usize> = (0..n).collect();
    for (_, a, b) in edges {
        let (a, b) = (first[*a], first[*b]);
        let own = first.iter_mut().filter(|own| **own == a.max(b));
        own.for_each(|own| *own = a.min(b));
    }
    first
}

/// x and y of gravity's direction.
fn direction(gravity: [f64; 3]) -> [f64; 2] {
    let length = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    [gravity[0] / length, gravity[1] / length]
}

/// What is said of `moved` rows.
pub(crate) fn moved_sentence(moved: u64) -> String {
    format!(
        "{moved} rows share the `pose` of an earlier row but not its joint positions: \
         taken as postures of their own"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAME: u64 = 0;
    const MOVED: u64 = 1;

    /// How many postures a row moves from that one knows.
    fn moved(postures: &mut Grouping, name: (i64, &str), q: &[f64], gravity: [f64; 3]) -> u64 {
        let before = postures.moved();
        postures.of_row(name, q, gravity);
        postures.moved() - before
    }

    fn visit(postures: &mut Grouping, pose: i64, support: &str, q: f64) -> (i64, u64) {
        let moved = moved(postures, (pose, support), &[q], DOWN);
        (postures.of_row((pose, support), &[q], DOWN).key, moved)
    }

    #[test]
    fn a_pose_is_one_posture_until_the_robot_moves() {
        let mut postures = Grouping::default();
        assert_eq!(visit(&mut postures, 7, "l", 0.5), (7, SAME));
        assert_eq!(visit(&mut postures, 8, "l", 0.1), (8, SAME));
        // On the other foot it is another one, in the same fold.
        assert_eq!(visit(&mut postures, 7, "r", 0.9), (7, SAME));
        assert_eq!(visit(&mut postures, 7, "l", 0.515), (7, SAME));
        let (key, is_moved) = visit(&mut postures, 7, "l", 0.53);
        assert_eq!(is_moved, MOVED);
        assert_ne!(key, 7);
        assert_eq!(visit(&mut postures, 7, "l", 0.53), (key, SAME));
        // Another tilt of the ground is another posture too.
        let tilted = moved(&mut postures, (8, "l"), &[0.1], [0.1, 0.0, -1.0]);
        assert_eq!(tilted, MOVED);
        postures.clear();
        assert_eq!(visit(&mut postures, 7, "l", 0.9), (7, SAME));
    }

    #[test]
    fn rows_that_come_back_are_another_visit() {
        let mut postures = Grouping::default();
        let mut visits = |pose| postures.of_row((pose, ""), &[0.0], DOWN).visits;
        let counted = [1, 1, 2, 2, 1, 1, 2, 3].map(&mut visits);
        assert_eq!(counted, [1, 1, 1, 1, 2, 2, 2, 1]);
    }

    #[test]
    fn beyond_the_cap_only_rows_that_follow_each_other_are_one() {
        let mut postures = Grouping::up_to(2);
        let mut count = |pose: i64| postures.of_row((pose, ""), &[0.0], DOWN).rows;
        let seen = [1, 2, 3, 3, 1, 4, 3, 2].map(&mut count);
        assert_eq!(seen, [1, 1, 1, 2, 2, 1, 1, 2]);
        assert!(postures.full());
    }

    /// Servos jitter by a tenth of a degree, also where degrees are taken for radians.
    #[test]
    fn degrees_jitter_as_degrees() {
        let row = |postures: &mut Grouping, q: f64| moved(postures, (1, ""), &[q, 30.0], DOWN);
        let mut degrees = Grouping::of_any_unit(true);
        let visits = [5.0, 5.1, 8.0].map(|q| row(&mut degrees, q));
        assert_eq!(visits, [SAME, SAME, MOVED]);
        let mut turns = Grouping::default();
        assert_eq!([5.0, 5.1].map(|q| row(&mut turns, q)), [SAME, MOVED]);
    }

    /// The first visits of postures that are all under numbers of their own.
    fn first_visits(postures: &[Vec<f64>]) -> Option<Vec<usize>> {
        let mut grouping = Grouping::default();
        for (pose, q) in postures.iter().enumerate() {
            grouping.of_row((pose as i64, ""), q, DOWN);
        }
        grouping.reached_again()
    }

    /// As good as drawn, over ±1.
    fn drawn(k: usize, joint: usize) -> f64 {
        ((1 + k) as f64 * [0.618_034, 0.754_878, 0.569_840][joint]).fract() * 2.0 - 1.0
    }

    #[test]
    fn postures_reached_again_are_known_by_their_joints() {
        // Three joints that come back to 0.01, three visits in turn, or each posture twice on end.
        let posture = |k: usize, visit: usize| -> Vec<f64> {
            let off = |joint: usize| 0.005 * drawn(3 * k + visit + 7, joint);
            (0..3).map(|joint| drawn(k, joint) + off(joint)).collect()
        };
        let in_turn = (0..30).map(|k| posture(k % 10, k / 10)).collect::<Vec<_>>();
        let first = first_visits(&in_turn).unwrap();
        assert_eq!(first, (0..30).map(|k| k % 10).collect::<Vec<_>>());
        let on_end = (0..20).map(|k| posture(k / 2, k % 2)).collect::<Vec<_>>();
        assert_eq!(first_visits(&on_end), None);
        // Four postures again are too few to say how well joints come back.
        assert_eq!(first_visits(&in_turn[..14]), None);
        assert!(first_visits(&in_turn[..15]).is_some());
        // Elsewhere on another foot.
        let mut feet = Grouping::default();
        for (pose, q) in in_turn.iter().enumerate() {
            let support = ["l", "r", "l"][pose / 10];
            feet.of_row((pose as i64, support), q, DOWN);
        }
        let first = feet.reached_again().unwrap();
        assert_eq!((first[10], first[20]), (10, 0));
        let stances = feet.stances();
        assert_eq!(&*stances.support.as_ref().unwrap()[10], "r");
        assert!((stances.joints(29)[0] - in_turn[29][0]).abs() < 1e-6);
    }

    /// A swing sampled so densely that it passes by itself, a grid, sweeps apart, and postures as
    /// good as drawn, at random distances from each other.
    #[test]
    fn trajectories_and_dense_plans_are_not_reached_again() {
        let swing = |k: usize| vec![(0.013 * k as f64).sin(), (0.029 * k as f64).sin()];
        assert_eq!(first_visits(&(0..900).map(swing).collect::<Vec<_>>()), None);
        let grid = |k: usize| vec![0.01 * (k % 20) as f64, 0.01 * (k / 20) as f64];
        assert_eq!(first_visits(&(0..400).map(grid).collect::<Vec<_>>()), None);
        let sweep = |k: usize| vec![0.002 * (k % 20) as f64 + 0.5 * (k / 20) as f64];
        assert_eq!(first_visits(&(0..60).map(sweep).collect::<Vec<_>>()), None);
        for joints in 1..=3 {
            let posture = |k| (0..joints).map(|joint| drawn(k, joint)).collect();
            let all: Vec<_> = (0..500).map(posture).collect();
            assert_eq!(first_visits(&all), None, "{joints}");
        }
    }
}
