//! Stamps that stand still, and stamps in another unit than seconds.
//!
//! ```text
//! v_j = max |Δq_j| / Δt ≪ v_limit        in rows that follow each other smoothly:
//! Σ |Δq|² ≪ 2 n Σ Var(q_j)
//! ```
//!
//! A robot that creeps for hours is logged slowly; one whose rows are smooth, seconds apart by
//! their stamps, and thousands of times slower than its joints can be was stamped in ms, µs
//! or ns. Memory: some numbers per joint.

use sesc_model::tree::Dof;

use super::columns::T;
use super::criteria::{CREEPS, FASTEST, FEW, LOGGED, MOVES, SMOOTH};

/// Units that stamps come in, and how many of them are a second.
const UNITS: [(&str, f64); 3] = [("ms", 1e3), ("µs", 1e6), ("ns", 1e9)];

/// What stamps and joints of a log say of each other.
pub(super) struct Stamps {
    /// Speed that each joint is allowed, rad/s or m/s.
    limits: Vec<f64>,
    rows: u64,
    ends: [f64; 2],
    last_t: f64,
    last_q: Vec<f64>,
    /// Largest speed of each joint by the stamps.
    fastest: Vec<f64>,
    /// Sum of the squares of its steps.
    stepped: Vec<f64>,
    /// Mean of its positions, and sum of squares about it.
    mean: Vec<f64>,
    about: Vec<f64>,
}

impl Stamps {
    pub fn new(dofs: &[Dof]) -> Stamps {
        let zeros = vec![0.0; dofs.len()];
        Stamps {
            limits: dofs.iter().map(|dof| dof.speed).collect(),
            rows: 0,
            ends: [f64::INFINITY, f64::NEG_INFINITY],
            last_t: f64::NAN,
            last_q: zeros.clone(),
            fastest: zeros.clone(),
            stepped: zeros.clone(),
            mean: zeros.clone(),
            about: zeros,
        }
    }

    /// Take note of rows at times `t` with joints `q`, row after row.
    pub fn see(&mut self, t: &[f64], q: &[f64]) {
        let n = self.limits.len();
        if n == 0 {
            return;
        }
        for (&t, q) in t.iter().zip(q.chunks_exact(n)) {
            self.rows += 1;
            self.ends = [self.ends[0].min(t), self.ends[1].max(t)];
            let follows = self.rows > 1;
            let per_second = match follows && t > self.last_t {
                true => 1.0 / (t - self.last_t),
                false => 0.0,
            };
            let weight = 1.0 / self.rows as f64;
            let (last, fastest) = (&mut self.last_q[..n], &mut self.fastest[..n]);
            let (stepped, mean) = (&mut self.stepped[..n], &mut self.mean[..n]);
            let about = &mut self.about[..n];
            for j in 0..n {
                let step = if follows { q[j] - last[j] } else { 0.0 };
                let speed = step.abs() * per_second;
                fastest[j] = if speed > fastest[j] {
                    speed
                } else {
                    fastest[j]
                };
                stepped[j] += step * step;
                let off = q[j] - mean[j];
                mean[j] += off * weight;
                about[j] += off * (q[j] - mean[j]);
                last[j] = q[j];
            }
            self.last_t = t;
        }
    }

    /// Said where all rows have one stamp.
    pub fn all_the_same(&self) -> Option<String> {
        (self.rows >= FEW && self.ends[0] == self.ends[1]).then(|| {
            format!(
                "`{T}` is {} in every row: the log says nothing of time, and motion and lasting \
                 noise are not seen; stamp each row, or leave the column out",
                self.ends[0]
            )
        })
    }

    /// Said where stamps are hardly in seconds.
    pub fn other_unit(&self) -> Option<String> {
        if self.rows < FEW {
            return None;
        }
        let rows = self.rows as f64;
        let step = (self.ends[1] - self.ends[0]) / (rows - 1.0);
        let moves = |j: &usize| self.about[*j] > MOVES * MOVES * rows;
        let moving: Vec<usize> = (0..self.limits.len()).filter(moves).collect();
        let sum = |of: &[f64]| moving.iter().map(|&j| of[j]).sum::<f64>();
        let smooth = sum(&self.stepped) < SMOOTH * 2.0 * sum(&self.about);
        // Parts of their limits that joints reach.
        let reached = moving.iter().filter(|&&j| self.limits[j] > 0.0);
        let reached = reached.map(|&j| self.fastest[j] / self.limits[j]);
        let reached = reached.fold(0.0, f64::max);
        if !smooth || reached == 0.0 || reached > CREEPS {
            return None;
        }
        let fits = |unit: &&(&str, f64)| {
            let per_second = unit.1;
            let logged = (LOGGED.0..=LOGGED.1).contains(&(step / per_second));
            logged && reached * per_second <= FASTEST
        };
        let (unit, per_second) = UNITS.iter().find(fits)?;
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
    use super::super::tests::dofs;
    use super::*;

    /// Two joints that swing at 0.4 and 0.3 Hz, rows `step` seconds apart, stamped in units of
    /// which `per_second` are a second.
    fn said(step: f64, slower: f64, per_second: f64) -> Option<String> {
        let mut stamps = Stamps::new(&dofs(&["a", "b"]));
        for k in 0..400 {
            let now = f64::from(k) * step;
            let wave = |hz: f64| 0.1 * (std::f64::consts::TAU * hz / slower * now).sin();
            stamps.see(&[per_second * now], &[wave(0.4), wave(0.3)]);
        }
        stamps.other_unit()
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
        let mut stamps = Stamps::new(&dofs(&["a", "b"]));
        for k in 0..400 {
            let at = |rate: f64| (f64::from(k * k) * rate).sin();
            stamps.see(&[f64::from(k) * 3600.0], &[at(0.7), at(1.1)]);
        }
        assert_eq!(stamps.other_unit(), None);
        assert_eq!(stamps.all_the_same(), None);
    }

    #[test]
    fn one_stamp_for_all_rows_is_said() {
        let mut stamps = Stamps::new(&dofs(&["a"]));
        for k in 0..40 {
            stamps.see(&[7.0], &[f64::from(k)]);
        }
        assert!(stamps.all_the_same().unwrap().contains("7 in every row"));
    }
}
