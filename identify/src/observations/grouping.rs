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

use super::criteria::repeats::{APART, FEWEST, REACHED};
use std::collections::HashMap;
use std::f32::consts::TAU;

use crate::logs::BLOCK;

/// Postures known at a time: some 45 MB for 20 joints.
pub const MOST: usize = 200_000;

/// Repeated readings are of one posture up to this, rad or m: servos jitter.
const JITTER: f32 = 0.02;

/// Gravity where a log does not give it.
pub const DOWN: [f64; 3] = [0.0, 0.0, -1.0];

/// Postures among which those are looked for that are reached again, at most: longer logs are
/// recordings.
const LOOKED: usize = 4000;

/// `pose` and the number of the support.
type Name = (i64, u32);

/// What is kept of a posture.
#[derive(Debug, Clone, PartialEq)]
pub struct Posture<T> {
    /// What deals its rows to their fold.
    pub key: i64,
    /// The caller's own; its default in the first row.
    pub own: T,
    /// Times that rows came back to it, the first included.
    pub visits: u32,
    /// Number of its last row, less whole turns of its counter.
    last_row: u32,
    /// Its rows, and the number of their support.
    rows: u32,
    support: u32,
}

/// Where a robot stands in a posture.
#[derive(Debug, Clone, PartialEq)]
pub struct Stance<'g> {
    /// Link on the ground; empty where the log does not say.
    pub support: &'g str,
    /// Mean of its joint positions, rad or m.
    pub q: Vec<f64>,
    /// Direction of gravity.
    pub gravity: [f64; 3],
}

/// Postures that rows may come back to.
#[derive(Debug, Clone, PartialEq)]
pub struct Grouping<T> {
    most: usize,
    /// Joint positions may be degrees that are taken for radians.
    any_unit: bool,
    /// The largest `pose` among them: beyond it no posture is known, and none is looked for.
    largest: i64,
    pieces: Vec<Piece<T>>,
    /// Their means over the rows of each of the first [`LOOKED`] postures.
    mean: Vec<f32>,
    /// The last posture for which there was no room: its number is one beyond the others'.
    last: Option<Name>,
    /// Links on the ground, each with the numbers of its postures by their `pose`.
    supports: Vec<(String, HashMap<i64, u32>)>,
    /// Rows whose robot had moved although their `pose` was known.
    moved: u64,
    /// Rows so far, as [`Posture::last_row`].
    rows: u32,
}

/// Some postures, in the order of their first rows.
#[derive(Debug, Clone, PartialEq)]
struct Piece<T> {
    postures: Vec<Posture<T>>,
    /// Joints and the direction of gravity in the first row of each posture, rad or m.
    at: Vec<f32>,
}

/// Whether a row belongs to a posture that is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Visit {
    /// Or the first one of its posture.
    Same,
    /// The `pose` is known, but the robot stood otherwise.
    Moved,
}

impl<T: Default> Default for Grouping<T> {
    fn default() -> Grouping<T> {
        Grouping::up_to(MOST)
    }
}

impl<T: Default> Grouping<T> {
    /// At most `most` known at a time.
    pub fn up_to(most: usize) -> Grouping<T> {
        Grouping {
            most,
            any_unit: false,
            largest: i64::MIN,
            pieces: Vec::new(),
            mean: Vec::new(),
            last: None,
            supports: Vec::new(),
            moved: 0,
            rows: 0,
        }
    }

    /// For a log whose unit is in question: beyond a whole turn, joint positions are
    /// compared as degrees.
    pub fn of_any_unit() -> Grouping<T> {
        Grouping {
            any_unit: true,
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
    ) -> (&mut Posture<T>, Visit) {
        let name = (pose, self.number(support));
        self.rows = self.rows.wrapping_add(1);
        let row = self.rows;
        let down = direction(gravity);
        let values = || q.iter().chain(&down).map(|&x| x as f32);
        let width = q.len() + down.len();
        let most = self.most;
        let known = (pose <= self.largest).then(|| self.supports[name.1 as usize].1.get(&pose));
        let known = known.flatten().map(|number| *number as usize);
        let number = known.or_else(|| self.last.filter(|last| *last == name).map(|_| most));
        let mut new = Posture {
            key: pose,
            own: T::default(),
            visits: 1,
            last_row: row,
            rows: 1,
            support: name.1,
        };
        let mut visit = Visit::Same;
        if let Some(number) = number {
            let (at, k) = (number / BLOCK, number % BLOCK);
            let first = &self.pieces[at].at[k * width..(k + 1) * width];
            let degrees = self.any_unit && first.iter().any(|a| a.abs() > TAU);
            let jitter = if degrees { JITTER.to_degrees() } else { JITTER };
            if !first
                .iter()
                .zip(values())
                .any(|(a, b)| (a - b).abs() > jitter)
            {
                let posture = &mut self.pieces[at].postures[k];
                posture.visits += u32::from(posture.last_row.wrapping_add(1) != row);
                posture.last_row = row;
                posture.rows = posture.rows.saturating_add(1);
                let rows = posture.rows as f32;
                let mean = self.mean.iter_mut().skip(number * width).take(width);
                mean.zip(values()).for_each(|(m, x)| *m += (x - *m) / rows);
                return (posture, visit);
            }
            self.moved += 1;
            // A fold of its own: as good as drawn, and not that of the other posture.
            new.key = pose.wrapping_add((self.moved as i64).wrapping_mul(0x5851_f42d));
            visit = Visit::Moved;
            if self.len() >= most {
                let piece = &mut self.pieces[at];
                let pairs = piece.at[k * width..].iter_mut().zip(values());
                pairs.for_each(|(to, from)| *to = from);
                piece.postures[k] = new;
                return (&mut piece.postures[k], visit);
            }
        }
        let number = self.len().min(most);
        if number < most {
            self.supports[name.1 as usize].1.insert(pose, number as u32);
            self.largest = self.largest.max(pose);
        } else {
            self.last = Some(name);
        }
        if number < LOOKED.min(most) {
            self.mean.extend(values());
        }
        let k = number % BLOCK;
        if number / BLOCK == self.pieces.len() {
            self.pieces.push(Piece {
                postures: Vec::new(),
                at: Vec::new(),
            });
        }
        let piece = &mut self.pieces[number / BLOCK];
        // The last posture for which there was no room gives way to this one.
        piece.postures.truncate(k);
        piece.at.truncate(k * width);
        piece.at.extend(values());
        piece.postures.push(new);
        (&mut piece.postures[k], visit)
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
}

impl<T> Grouping<T> {
    /// Postures that are known, and the last one for which there was no room.
    fn len(&self) -> usize {
        let last = self.pieces.last();
        last.map_or(0, |last| {
            (self.pieces.len() - 1) * BLOCK + last.postures.len()
        })
    }

    /// A posture by the order of first rows.
    pub fn posture(&self, k: usize) -> &Posture<T> {
        &self.pieces[k / BLOCK].postures[k % BLOCK]
    }

    fn postures(&self) -> impl Iterator<Item = &Posture<T>> {
        self.pieces.iter().flat_map(|piece| &piece.postures)
    }

    /// Whether each posture has several rows, so that a log that is dense in time is one of stays
    /// alone.
    pub fn is_of_stays(&self) -> bool {
        self.postures().all(|posture| posture.rows > 1)
    }

    /// Where the robot stands in each posture, of at most [`LOOKED`].
    pub fn stances(&self) -> Vec<Stance<'_>> {
        let each = self.mean.chunks_exact(self.width()).zip(self.postures());
        each.map(|(mean, posture)| {
            let mean: Vec<f64> = mean.iter().map(|x| f64::from(*x)).collect();
            let (q, [x, y]) = mean.split_last_chunk().expect("gravity is there");
            Stance {
                support: &self.supports[posture.support as usize].0,
                q: q.to_vec(),
                gravity: [*x, *y, -(1.0 - x * x - y * y).max(0.0).sqrt()],
            }
        })
        .collect()
    }

    /// Of each posture the first one that it is a visit of, itself where it was not reached
    /// before; none where none was, as far as their joint positions show. A posture that follows
    /// its like is not reached again.
    pub fn reached_again(&self) -> Option<Vec<usize>> {
        let n = self.len();
        let mut at = self.pieces.iter().flat_map(|piece| &piece.at);
        let in_degrees = self.any_unit && at.any(|x| x.abs() > TAU);
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
        let first = self.pieces.first();
        first.map_or(1, |first| first.at.len() / first.postures.len().max(1))
    }

    /// Largest difference of joint positions or of gravity, where it is below `most`; infinite
    /// elsewhere, and on different supports.
    fn distance(&self, a: usize, b: usize, most: f32) -> f32 {
        if self.posture(a).support != self.posture(b).support {
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
        let mut open: Vec<(f32, usize, usize)> = (1..self.len())
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
pub fn moved_sentence(moved: u64) -> String {
    format!(
        "{moved} rows share the `pose` of an earlier row but not its joint positions: \
         taken as postures of their own"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn visit(postures: &mut Grouping<()>, pose: i64, support: &str, q: f64) -> (i64, Visit) {
        let (posture, visit) = postures.of_row((pose, support), &[q], DOWN);
        (posture.key, visit)
    }

    #[test]
    fn a_pose_is_one_posture_until_the_robot_moves() {
        let mut postures = Grouping::<()>::default();
        assert_eq!(visit(&mut postures, 7, "l", 0.5), (7, Visit::Same));
        assert_eq!(visit(&mut postures, 8, "l", 0.1), (8, Visit::Same));
        // On the other foot it is another one, in the same fold.
        assert_eq!(visit(&mut postures, 7, "r", 0.9), (7, Visit::Same));
        assert_eq!(visit(&mut postures, 7, "l", 0.515), (7, Visit::Same));
        let (key, moved) = visit(&mut postures, 7, "l", 0.53);
        assert_eq!(moved, Visit::Moved);
        assert_ne!(key, 7);
        assert_eq!(visit(&mut postures, 7, "l", 0.53), (key, Visit::Same));
        // Another tilt of the ground is another posture too.
        let (_, tilted) = postures.of_row((8, "l"), &[0.1], [0.1, 0.0, -1.0]);
        assert_eq!(tilted, Visit::Moved);
        postures.clear();
        assert_eq!(visit(&mut postures, 7, "l", 0.9), (7, Visit::Same));
    }

    #[test]
    fn rows_that_come_back_are_another_visit() {
        let mut postures = Grouping::<()>::default();
        let mut visits = |pose| postures.of_row((pose, ""), &[0.0], DOWN).0.visits;
        let counted = [1, 1, 2, 2, 1, 1, 2, 3].map(&mut visits);
        assert_eq!(counted, [1, 1, 1, 1, 2, 2, 2, 1]);
    }

    #[test]
    fn beyond_the_cap_only_rows_that_follow_each_other_are_one() {
        let mut postures = Grouping::<u32>::up_to(2);
        let mut count = |pose: i64| {
            let (posture, _) = postures.of_row((pose, ""), &[0.0], DOWN);
            posture.own += 1;
            posture.own
        };
        let seen = [1, 2, 3, 3, 1, 4, 3, 2].map(&mut count);
        assert_eq!(seen, [1, 1, 1, 2, 2, 1, 1, 2]);
        assert!(postures.full());
    }

    /// Servos jitter by a tenth of a degree, also where degrees are taken for radians.
    #[test]
    fn degrees_jitter_as_degrees() {
        let row =
            |postures: &mut Grouping<()>, q: f64| postures.of_row((1, ""), &[q, 30.0], DOWN).1;
        let (same, moved) = (Visit::Same, Visit::Moved);
        let mut degrees = Grouping::of_any_unit();
        let visits = [5.0, 5.1, 8.0].map(|q| row(&mut degrees, q));
        assert_eq!(visits, [same, same, moved]);
        let mut turns = Grouping::default();
        assert_eq!([5.0, 5.1].map(|q| row(&mut turns, q)), [same, moved]);
    }

    /// The first visits of postures that are all under numbers of their own.
    fn first_visits(postures: &[Vec<f64>]) -> Option<Vec<usize>> {
        let mut grouping = Grouping::<()>::default();
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
        let mut feet = Grouping::<()>::default();
        for (pose, q) in in_turn.iter().enumerate() {
            let support = ["l", "r", "l"][pose / 10];
            feet.of_row((pose as i64, support), q, DOWN);
        }
        let first = feet.reached_again().unwrap();
        assert_eq!((first[10], first[20]), (10, 0));
        assert_eq!(feet.stances()[10].support, "r");
        assert!((feet.stances()[29].q[0] - in_turn[29][0]).abs() < 1e-6);
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
