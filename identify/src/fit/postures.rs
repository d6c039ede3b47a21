//! Postures of one log by their `pose`, also where rows come back to them later.
//!
//! Rows that share `pose`, support and joint positions are readings of one
//! posture: repeats that tell the noise, dealt to one fold. A posture needs
//! about 80 bytes and 4 per joint here, and [`MOST`] of them are known at a
//! time; those of longer logs are one posture only as long as their rows
//! follow each other.

use std::collections::HashMap;

use super::noise::Group;

/// Postures known at a time: some 40 MB for 20 joints.
pub const MOST: usize = 200_000;

/// Repeated readings are of one posture up to this, rad or m: servos jitter.
const JITTER: f32 = 0.02;

/// `pose` and the number of the support.
type Name = (i64, u32);

/// A posture and what was read in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Posture {
    /// Joints and the direction of gravity in its first row, rad or m.
    at: Box<[f32]>,
    /// What deals its rows to their fold.
    pub key: i64,
    pub group: Group,
}

/// Postures that rows may come back to.
#[derive(Debug, Clone, PartialEq)]
pub struct Postures {
    most: usize,
    known: HashMap<Name, Posture>,
    /// The last posture for which there was no room.
    last: Option<(Name, Posture)>,
    supports: Vec<String>,
}

/// Whether a row belongs to a posture that is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Visit {
    /// Or the first one of its posture.
    Same,
    /// The `pose` is known, but the robot stood otherwise.
    Moved,
}

impl Default for Postures {
    fn default() -> Postures {
        Postures::up_to(MOST)
    }
}

impl Postures {
    /// At most `most` known at a time.
    pub fn up_to(most: usize) -> Postures {
        Postures {
            most,
            known: HashMap::new(),
            last: None,
            supports: Vec::new(),
        }
    }

    /// Whether there were more postures than can be known.
    pub fn full(&self) -> bool {
        self.last.is_some()
    }

    /// Forget all: poses of another log are others.
    pub fn clear(&mut self) {
        *self = Postures::up_to(self.most);
    }

    /// The posture of a row, which stands on `support` with joints `q` (rad or m)
    /// and gravity along (x, y, ·) of its direction; `moves` counts rows so far
    /// whose robot had moved.
    pub fn of_row(
        &mut self,
        (pose, support): (i64, &str),
        q: &[f64],
        gravity: [f64; 2],
        moves: u64,
    ) -> (&mut Posture, Visit) {
        let name = (pose, self.number(support));
        let values = || q.iter().chain(&gravity).map(|&x| x as f32);
        let near = |posture: &Posture| {
            let pairs = posture.at.iter().zip(values());
            !pairs.into_iter().any(|(a, b)| (a - b).abs() > JITTER)
        };
        let new = |moves: u64| Posture {
            at: values().collect(),
            // A fold of its own: as good as drawn, and not that of the other posture.
            key: pose.wrapping_add((moves as i64).wrapping_mul(0x5851_f42d)),
            group: Group::default(),
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
            true => (posture, Visit::Same),
            false => {
                *posture = new(moves + 1);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn visit(postures: &mut Postures, pose: i64, support: &str, q: f64) -> (i64, Visit) {
        let (posture, visit) = postures.of_row((pose, support), &[q], [0.0; 2], 0);
        (posture.key, visit)
    }

    #[test]
    fn a_pose_is_one_posture_until_the_robot_moves() {
        let mut postures = Postures::default();
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
        let (_, tilted) = postures.of_row((8, "l"), &[0.1], [0.1, 0.0], 0);
        assert_eq!(tilted, Visit::Moved);
        postures.clear();
        assert_eq!(visit(&mut postures, 7, "l", 0.9), (7, Visit::Same));
    }

    #[test]
    fn beyond_the_cap_only_rows_that_follow_each_other_are_one() {
        let mut postures = Postures::up_to(2);
        let mut count = |pose: i64| {
            let (posture, _) = postures.of_row((pose, ""), &[0.0], [0.0; 2], 0);
            posture.group.count += 1.0;
            posture.group.count
        };
        let seen = [1, 2, 3, 3, 1, 4, 3, 2].map(&mut count);
        assert_eq!(seen, [1.0, 1.0, 1.0, 2.0, 2.0, 1.0, 1.0, 2.0]);
        assert!(postures.full());
    }
}
