//! Which rows of a log are readings of one posture, also where rows come back to
//! it later.
//!
//! ```text
//! same posture    same `pose` and support,  max_j |q_j − q_j(first row)| ≤ 0.02 rad
//! ```
//!
//! Repeated readings tell the noise and belong to one fold. Two sessions that were
//! numbered alike share a `pose` and not the joint positions: they are postures of
//! their own. A posture needs about 80 bytes and 4 per joint here, and [`MOST`] of
//! them are known at a time; those of longer logs are one posture only as long as
//! their rows follow each other.

use std::collections::HashMap;
use std::f32::consts::TAU;

/// Postures known at a time: some 40 MB for 20 joints.
pub const MOST: usize = 200_000;

/// Repeated readings are of one posture up to this, rad or m: servos jitter.
const JITTER: f32 = 0.02;

/// Gravity where a log does not give it.
pub const DOWN: [f64; 3] = [0.0, 0.0, -1.0];

/// `pose` and the number of the support.
type Name = (i64, u32);

/// A posture and what is kept of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Posture<T> {
    /// Joints and the direction of gravity in its first row, rad or m.
    at: Box<[f32]>,
    /// What deals its rows to their fold.
    pub key: i64,
    /// The caller's own; its default in the first row.
    pub own: T,
    /// Times that rows came back to it, the first included.
    pub visits: u32,
    /// Number of its last row.
    last_row: u64,
}

/// Postures that rows may come back to.
#[derive(Debug, Clone, PartialEq)]
pub struct Grouping<T> {
    most: usize,
    /// Joint positions may be degrees that are taken for radians.
    any_unit: bool,
    known: HashMap<Name, Posture<T>>,
    /// The last posture for which there was no room.
    last: Option<(Name, Posture<T>)>,
    supports: Vec<String>,
    /// Rows whose robot had moved although their `pose` was known.
    moved: u64,
    /// Rows so far.
    rows: u64,
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
            known: HashMap::new(),
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

    /// The posture of a row, which stands on `support` with joints `q` (rad or m)
    /// and gravity along the vector `gravity`.
    pub fn of_row(
        &mut self,
        (pose, support): (i64, &str),
        q: &[f64],
        gravity: [f64; 3],
    ) -> (&mut Posture<T>, Visit) {
        let name = (pose, self.number(support));
        self.rows += 1;
        let row = self.rows;
        let down = direction(gravity);
        let values = || q.iter().chain(&down).map(|&x| x as f32);
        let any_unit = self.any_unit;
        let near = |posture: &Posture<T>| {
            let degrees = any_unit && posture.at.iter().any(|a| a.abs() > TAU);
            let jitter = if degrees { JITTER.to_degrees() } else { JITTER };
            let pairs = posture.at.iter().zip(values());
            !pairs.into_iter().any(|(a, b)| (a - b).abs() > jitter)
        };
        let new = |moves: u64| Posture {
            at: values().collect(),
            // A fold of its own: as good as drawn, and not that of the other posture.
            key: pose.wrapping_add((moves as i64).wrapping_mul(0x5851_f42d)),
            own: T::default(),
            visits: 1,
            last_row: row,
        };
        let room = self.known.len() < self.most;
        let place = match self.known.contains_key(&name) {
            true => self.known.get_mut(&name),
            false if room => {
                let first = self.known.entry(name).or_insert_with(|| new(0));
                return (first, Visit::Same);
            }
            false => {
                if self.last.as_ref().is_none_or(|(last, _)| *last != name) {
                    self.last = Some((name, new(0)));
                }
                self.last.as_mut().map(|(_, posture)| posture)
            }
        };
        let posture = place.expect("a posture is known, or the last for which there was no room");
        match near(posture) {
            true => {
                posture.visits += u32::from(posture.last_row + 1 < row);
                posture.last_row = row;
                (posture, Visit::Same)
            }
            false => {
                self.moved += 1;
                *posture = new(self.moved);
                (posture, Visit::Moved)
            }
        }
    }

    /// Supports are few, rows are many.
    fn number(&mut self, support: &str) -> u32 {
        let known = self.supports.iter().position(|other| other == support);
        let at = known.unwrap_or_else(|| {
            self.supports.push(support.to_string());
            self.supports.len() - 1
        });
        at as u32
    }
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
        let mut degrees = Grouping::of_any_unit();
        assert_eq!(
            [5.0, 5.1, 8.0].map(|q| row(&mut degrees, q)),
            [Visit::Same, Visit::Same, Visit::Moved]
        );
        let mut turns = Grouping::default();
        assert_eq!(
            [5.0, 5.1].map(|q| row(&mut turns, q)),
            [Visit::Same, Visit::Moved]
        );
    }
}
