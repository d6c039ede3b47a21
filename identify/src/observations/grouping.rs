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

/// What is kept of a posture.
#[derive(Debug, Clone, PartialEq)]
pub struct Posture<T> {
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
    /// Numbers of postures.
    known: HashMap<Name, u32>,
    /// The largest `pose` among them: beyond it no posture is known, and none is looked for.
    largest: i64,
    postures: Vec<Posture<T>>,
    /// Joints and the direction of gravity in the first row of each posture, rad or m.
    at: Vec<f32>,
    /// The last posture for which there was no room: its number is one beyond the others'.
    last: Option<Name>,
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
            largest: i64::MIN,
            postures: Vec::new(),
            at: Vec::new(),
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
        self.rows += 1;
        let row = self.rows;
        let down = direction(gravity);
        let values = || q.iter().chain(&down).map(|&x| x as f32);
        let width = q.len() + down.len();
        // A fold of its own: as good as drawn, and not that of the other posture.
        let key = |moves: u64| pose.wrapping_add((moves as i64).wrapping_mul(0x5851_f42d));
        let new = |key: i64| Posture {
            key,
            own: T::default(),
            visits: 1,
            last_row: row,
        };
        let most = self.most;
        let known = match pose > self.largest {
            true => None,
            false => self.known.get(&name).map(|number| *number as usize),
        };
        let number = known.or_else(|| self.last.filter(|last| *last == name).map(|_| most));
        let Some(number) = number else {
            let number = match self.known.len() < most {
                true => {
                    let number = self.postures.len();
                    self.known.insert(name, number as u32);
                    self.largest = self.largest.max(pose);
                    number
                }
                false => {
                    self.last = Some(name);
                    self.postures.truncate(most);
                    self.at.truncate(most * width);
                    most
                }
            };
            self.postures.push(new(key(0)));
            self.at.extend(values());
            return (&mut self.postures[number], Visit::Same);
        };
        let at = &mut self.at[number * width..(number + 1) * width];
        let degrees = self.any_unit && at.iter().any(|a| a.abs() > TAU);
        let jitter = if degrees { JITTER.to_degrees() } else { JITTER };
        let is_near = !at.iter().zip(values()).any(|(a, b)| (a - b).abs() > jitter);
        let posture = &mut self.postures[number];
        if is_near {
            posture.visits += u32::from(posture.last_row + 1 < row);
            posture.last_row = row;
            return (posture, Visit::Same);
        }
        self.moved += 1;
        at.iter_mut()
            .zip(values())
            .for_each(|(to, from)| *to = from);
        *posture = new(key(self.moved));
        (posture, Visit::Moved)
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
        let (same, moved) = (Visit::Same, Visit::Moved);
        let mut degrees = Grouping::of_any_unit();
        let visits = [5.0, 5.1, 8.0].map(|q| row(&mut degrees, q));
        assert_eq!(visits, [same, same, moved]);
        let mut turns = Grouping::default();
        assert_eq!([5.0, 5.1].map(|q| row(&mut turns, q)), [same, moved]);
    }
}
