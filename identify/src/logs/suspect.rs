//! What a whole log looks like it got wrong: times that stand still, are missing or are in another
//! unit.
//!
//! ```text
//! v_j = max |Δq_j| / Δt ≪ v_limit        in rows that follow each other smoothly:
//! Σ |Δq|² ≪ 2 n Σ Var(q_j)
//! ```
//!
//! A robot that creeps for hours is logged slowly; one whose rows are smooth, seconds apart by
//! their stamps, and thousands of times slower than its joints can be was stamped in ms, µs
//! or ns.
//!
//! Each is a warning: the values are possible, only unlikely. Memory: some
//! numbers per joint.

use sesc_model::tree::Dof;

use super::block::Block;
use super::columns::T;
use super::criteria::{CREEPS, FASTEST, FEW, GOES_ON, LOGGED, MOVES, SHARED, SMOOTH};

/// Statistics of a log.
pub(super) struct Suspicions {
    joints: Vec<Joint>,
    rows: u64,
    /// Least and largest time, s.
    ends: [f64; 2],
    last_t: f64,
    /// Rows that share the stamp of the row above.
    shared: u64,
}

/// What the column of a joint shows, rad or m.
#[derive(Default)]
struct Joint {
    /// Speed that it is allowed, rad/s or m/s.
    speed: f64,
    last: f64,
    /// Largest speed by the stamps, rad/s or m/s.
    fastest: f64,
    /// The last step, the sum of the squares of steps, and that of their changes.
    last_step: f64,
    stepped: f64,
    bent: f64,
    /// Mean of positions, and sum of squares about it.
    mean: f64,
    about: f64,
}

impl Joint {
    /// A position in the next row; `weight` is 1/rows so far, and `per_second` 1/Δt to the row
    /// above.
    fn see(&mut self, q: f64, weight: f64, per_second: f64) {
        let step = if weight < 1.0 { q - self.last } else { 0.0 };
        self.fastest = self.fastest.max(step.abs() * per_second);
        self.stepped += step * step;
        self.bent += (step - self.last_step) * (step - self.last_step);
        (self.last, self.last_step) = (q, step);
        let off = q - self.mean;
        self.mean += off * weight;
        self.about += off * (q - self.mean);
    }
}

impl Suspicions {
    pub fn new(dofs: &[Dof]) -> Suspicions {
        let joint = |dof: &Dof| Joint {
            speed: dof.speed,
            ..Joint::default()
        };
        Suspicions {
            joints: dofs.iter().map(joint).collect(),
            rows: 0,
            ends: [f64::INFINITY, f64::NEG_INFINITY],
            last_t: f64::NAN,
            shared: 0,
        }
    }

    /// Take note of some rows.
    pub fn see(&mut self, block: &Block) {
        let n = self.joints.len();
        for k in 0..block.len() {
            self.rows += 1;
            let t = block.t.as_ref().map_or(f64::NAN, |t| t[k]);
            self.ends = [self.ends[0].min(t), self.ends[1].max(t)];
            self.shared += u64::from(t == self.last_t);
            let apart = t > self.last_t;
            let per_second = if apart { 1.0 / (t - self.last_t) } else { 0.0 };
            self.last_t = t;
            let weight = 1.0 / self.rows as f64;
            for (joint, &q) in self.joints.iter_mut().zip(&block.q[k * n..]) {
                joint.see(q, weight, per_second);
            }
        }
    }

    /// Stamps that say nothing of time, or are hardly in seconds.
    pub fn times(&self) -> Option<String> {
        if self.rows < FEW {
            return None;
        }
        if self.shared + 1 == self.rows {
            return Some(format!(
                "`{T}` is {} in every row: the log says nothing of time, and motion and lasting \
                 noise are not seen; stamp each row, or leave the column out",
                self.ends[0]
            ));
        }
        // The joints that move, in rows that follow each other smoothly.
        let rows = self.rows as f64;
        let moves = |joint: &&Joint| joint.about > MOVES * MOVES * rows;
        let moving: Vec<&Joint> = self.joints.iter().filter(moves).collect();
        let sum = |of: fn(&Joint) -> f64| moving.iter().map(|joint| of(joint)).sum::<f64>();
        let stepped = sum(|joint| joint.stepped);
        if stepped >= SMOOTH * 2.0 * sum(|joint| joint.about) {
            return None;
        }
        // Postures that are put in order step back and forth; a joint that moves goes on.
        let goes_on = sum(|joint| joint.bent) < GOES_ON * stepped;
        let motion = "rows follow each other as those of a robot that moves do";
        if !self.ends[0].is_finite() {
            return goes_on.then(|| {
                format!(
                    "{motion}, and the log has no column `{T}`: motion is not counted, and every \
                     row is taken for a robot that stands; add the time of each row, s"
                )
            });
        }
        let coarse = self.shared as f64 > SHARED * rows;
        if coarse && goes_on {
            return Some(format!(
                "{} of {} rows share the stamp of the row above, and {motion}: `{T}` has too few \
                 digits, and motion is not counted; write times with at least three decimals",
                self.shared, self.rows
            ));
        }
        let step = (self.ends[1] - self.ends[0]) / (rows - 1.0);
        // Parts of their limits that joints reach.
        let reached = moving.iter().filter(|joint| joint.speed > 0.0);
        let reached = reached.map(|joint| joint.fastest / joint.speed);
        let reached = reached.fold(0.0, f64::max);
        if reached == 0.0 || reached > CREEPS {
            return None;
        }
        let fits = |unit: &&(&str, f64)| {
            let per_second = unit.1;
            let logged = (LOGGED.0..=LOGGED.1).contains(&(step / per_second));
            logged && reached * per_second <= FASTEST
        };
        let units = [("ms", 1e3), ("µs", 1e6), ("ns", 1e9)];
        let (unit, per_second) = units.iter().find(fits)?;
        Some(format!(
            "rows are {step:.3} s apart by `{T}`, and no joint moves faster than {:.4} % of its \
             limit: is `{T}` in {unit}? Rows would be {:.3} s apart then; give seconds",
            100.0 * reached,
            step / per_second
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::logs::tests::dofs;

    /// A log of the joints without any rows yet.
    fn stamps(joints: &[&str]) -> Suspicions {
        Suspicions::new(&dofs(joints))
    }

    /// A row of a log.
    fn row(t: f64, q: &[f64]) -> Block {
        Block {
            line: vec![0],
            t: Some(vec![t]),
            q: q.to_vec(),
            ..Block::default()
        }
    }

    /// Two joints that swing at 0.4 and 0.3 Hz, rows `step` seconds apart, stamped in units of
    /// which `per_second` are a second.
    fn said(step: f64, slower: f64, per_second: f64) -> Option<String> {
        let mut stamps = stamps(&["a", "b"]);
        for k in 0..400 {
            let now = f64::from(k) * step;
            let wave = |hz: f64| 0.1 * (std::f64::consts::TAU * hz / slower * now).sin();
            stamps.see(&row(per_second * now, &[wave(0.4), wave(0.3)]));
        }
        stamps.times()
    }

    #[test]
    fn stamps_in_milliseconds_are_told_from_a_slow_robot() {
        assert_eq!(said(0.01, 1.0, 1.0), None);
        for step in [0.001, 0.01, 0.1] {
            let said = said(step, 1.0, 1e3).unwrap();
            assert!(said.contains("in ms?"), "{said}");
        }
        assert!(said(0.01, 1.0, 1e6).unwrap().contains("in µs?"));
        assert!(said(0.01, 1.0, 1e9).unwrap().contains("in ns?"));
        // A swing of a minute, and one of ten, logged every second.
        assert_eq!(said(1.0, 24.0, 1.0), None);
        assert_eq!(said(1.0, 240.0, 1.0), None);
    }

    #[test]
    fn postures_that_are_hours_apart_are_in_seconds() {
        let mut stamps = stamps(&["a", "b"]);
        for k in 0..400 {
            let at = |rate: f64| (f64::from(k * k) * rate).sin();
            stamps.see(&row(f64::from(k) * 3600.0, &[at(0.7), at(1.1)]));
        }
        assert_eq!(stamps.times(), None);
        // One stamp for all rows.
        let mut stamps = self::stamps(&["a"]);
        for k in 0..40 {
            stamps.see(&row(7.0, &[f64::from(k)]));
        }
        assert!(stamps.times().unwrap().contains("7 in every row"));
    }
}
