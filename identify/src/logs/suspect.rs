//! What a whole log looks like it got wrong: degrees for radians, two columns
//! swapped, millimetres, time running backwards, standing still or in another unit.
//!
//! ```text
//! v_j = max |Δq_j| / Δt ≪ v_limit        in rows that follow each other smoothly:
//! Σ |Δq|² ≪ 2 n Σ Var(q_j)
//! ```
//!
//! A robot that creeps for hours is logged slowly; one whose rows are smooth, seconds apart by
//! their stamps, and thousands of times slower than its joints can be was stamped in ms, µs
//! or ns, one that is faster than they can be in minutes or days.
//!
//! Each is a warning: the values are possible, only unlikely. Memory: some
//! numbers per joint.

use std::f64::consts::PI;

use sesc_model::tree::Dof;

use super::block::Block;
use super::columns::T;
use super::criteria::{CREEPS, FASTEST, FEW, GOES_ON, LOGGED, MOVES, SHARED, SLACK, SMOOTH, SOLE};
use super::settings::{Angles, IN_DEGREES, OR_SIDECAR};
use crate::{Message, Setting, message};

/// Statistics of a log.
#[derive(Default)]
pub(super) struct Suspicions {
    joints: Vec<Joint>,
    /// From rad back to the unit of the file.
    per_rad: f64,
    rows: u64,
    readings: u64,
    /// Sum of |CoP|, m.
    reach: f64,
    /// Least and largest time, s.
    ends: [f64; 2],
    last_t: f64,
    /// Line of the first row that is earlier than the one above it.
    backwards: Option<u64>,
    /// Rows that share the stamp of the row above.
    shared: u64,
}

/// What the column of a joint shows, rad or m.
#[derive(Default)]
struct Joint {
    name: String,
    prismatic: bool,
    continuous: bool,
    /// Speed that it is allowed, rad/s or m/s.
    speed: f64,
    /// Limits with their slack; infinite where none mean something.
    lower: f64,
    upper: f64,
    least: f64,
    most: f64,
    outside: u64,
    /// Values other than zero, and how many of them are whole in the file's unit.
    nonzero: u64,
    whole: u64,
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
    fn new(dof: &Dof) -> Joint {
        // A servo is beyond its limits by no more than the slack.
        let slack = match (dof.continuous, dof.prismatic) {
            (true, _) => f64::INFINITY,
            (_, true) => 0.0,
            _ => SLACK,
        };
        Joint {
            name: dof.joint.clone(),
            prismatic: dof.prismatic,
            continuous: dof.continuous,
            speed: dof.speed,
            lower: dof.lower - slack,
            upper: dof.upper + slack,
            least: f64::INFINITY,
            most: f64::NEG_INFINITY,
            ..Joint::default()
        }
    }

    /// A position in the next row, and as it stands in the file; `weight` is 1/rows so far, and
    /// `per_second` 1/Δt to the row above.
    fn see(&mut self, q: f64, written: f64, weight: f64, per_second: f64) {
        self.least = if q < self.least { q } else { self.least };
        self.most = if q > self.most { q } else { self.most };
        self.outside += u64::from((q < self.lower) | (q > self.upper));
        let is_whole = (written - written.round_ties_even()).abs() < 1e-9;
        self.nonzero += u64::from(q != 0.0);
        self.whole += u64::from((q != 0.0) & is_whole);
        let step = if weight < 1.0 { q - self.last } else { 0.0 };
        self.fastest = self.fastest.max(step.abs() * per_second);
        self.stepped += step * step;
        self.bent += (step - self.last_step) * (step - self.last_step);
        (self.last, self.last_step) = (q, step);
        let off = q - self.mean;
        self.mean += off * weight;
        self.about += off * (q - self.mean);
    }

    /// Whether the column of `other` respects the limits of this joint.
    fn fits(&self, other: &Joint) -> bool {
        let alike = other.prismatic == self.prismatic && !self.continuous;
        alike && other.least >= self.lower && other.most <= self.upper
    }
}

impl Suspicions {
    pub(super) fn new(dofs: &[Dof], angles: Angles) -> Suspicions {
        Suspicions {
            joints: dofs.iter().map(Joint::new).collect(),
            per_rad: match angles {
                Angles::Deg => 180.0 / PI,
                Angles::Rad => 1.0,
            },
            ends: [f64::INFINITY, f64::NEG_INFINITY],
            last_t: f64::NAN,
            ..Suspicions::default()
        }
    }

    /// Take note of some rows.
    pub(super) fn see(&mut self, block: &Block) {
        for [x, y] in block.reading.iter().flatten() {
            self.readings += 1;
            self.reach += (x * x + y * y).sqrt();
        }
        let n = self.joints.len();
        for (k, line) in block.line.iter().enumerate() {
            self.rows += 1;
            let t = block.t.as_ref().map_or(f64::NAN, |t| t[k]);
            self.ends = [self.ends[0].min(t), self.ends[1].max(t)];
            self.shared += u64::from(t == self.last_t);
            if t < self.last_t {
                self.backwards.get_or_insert(*line);
            }
            let apart = t > self.last_t;
            let per_second = if apart { 1.0 / (t - self.last_t) } else { 0.0 };
            self.last_t = t;
            let weight = 1.0 / self.rows as f64;
            for (joint, &q) in self.joints.iter_mut().zip(&block.q[k * n..]) {
                joint.see(q, q * self.per_rad, weight, per_second);
            }
        }
    }

    /// What was noticed.
    pub(super) fn judge(&self) -> Vec<Message> {
        let backwards = self.backwards.map(|line| {
            format!("row {line}: `{T}` runs backwards; sort the log by time if it is one motion")
        });
        let of_time = [self.all_the_same(), self.other_unit(), self.unusable()];
        let of_time = of_time.into_iter().filter(|_| self.rows >= FEW);
        let of_columns = [self.swapped(), self.millimetres(), backwards];
        let said = of_columns.into_iter().chain(of_time).flatten();
        let of_angles = [self.degrees(), self.radians()].into_iter().flatten();
        of_angles.chain(said.map(Message::from)).collect()
    }

    fn revolute(&self) -> impl Iterator<Item = &Joint> {
        self.joints.iter().filter(|joint| !joint.prismatic)
    }

    /// Angles other than zero.
    fn nonzero(&self) -> u64 {
        self.revolute().map(|joint| joint.nonzero).sum()
    }

    /// Largest angle of a revolute joint, rad.
    fn largest(&self) -> f64 {
        let most = |joint: &Joint| joint.most.max(-joint.least);
        self.revolute().map(most).fold(0.0, f64::max)
    }

    /// Beyond its own limits mostly, as a column is that belongs to another.
    fn strays(&self, joint: &Joint) -> bool {
        self.rows >= FEW && 4 * joint.outside > self.rows
    }

    /// Radians that look like degrees: whole numbers, or far beyond the limits
    /// of most joints.
    fn degrees(&self) -> Option<Message> {
        let whole: u64 = self.revolute().map(|joint| joint.whole).sum();
        let straying = self.revolute().filter(|joint| self.strays(joint)).count();
        let nonzero = self.nonzero();
        let why = if nonzero >= FEW && 10 * whole > 9 * nonzero && self.largest() >= 2.0 {
            "nearly all angles are whole numbers"
        } else if straying > 2 && 2 * straying > self.revolute().count() {
            "most joints are far beyond their limits"
        } else {
            return None;
        };
        let why = format!("{why}; {IN_DEGREES}");
        (self.per_rad == 1.0).then(|| message![why, Setting::Angles, OR_SIDECAR])
    }

    /// Degrees that look like radians: no joint ever moves by more than π of them.
    fn radians(&self) -> Option<Message> {
        let most = self.largest() * self.per_rad;
        (self.per_rad != 1.0 && self.nonzero() >= FEW && most <= PI).then(|| {
            let said = format!(
                "read in degrees, no joint ever moves beyond {most:.2}°; if the log is in radians, \
                 leave out "
            );
            message![said, Setting::Angles, " and `angles = \"deg\"`"]
        })
    }

    /// Two joints, one or both beyond their limits, that would fit if exchanged.
    fn swapped(&self) -> Option<String> {
        let strays = self.joints.iter().filter(|joint| self.strays(joint));
        let pairs = strays.filter_map(|stray| {
            let exchanged = |other: &&Joint| {
                !std::ptr::eq(*other, stray) && other.fits(stray) && stray.fits(other)
            };
            let mut partners = self.joints.iter().filter(exchanged);
            // One candidate is a finding, several are a guess.
            let fits = match (partners.next()?, partners.next()) {
                (one, None) => format!(", but fits `{}`, and the other way round", one.name),
                _ => String::new(),
            };
            let own = &stray.name;
            Some(format!("column `{own}` is beyond its joint's limits{fits}"))
        });
        let pairs: Vec<String> = pairs.take(4).collect();
        (!pairs.is_empty()).then(|| format!("{}; are columns swapped?", pairs.join("; ")))
    }

    fn millimetres(&self) -> Option<String> {
        let typical = self.reach / self.readings as f64;
        (typical > SOLE).then(|| {
            format!(
                "the CoP is {typical:.2} m from the origin of the sole on average; is it given \
                 in metres?"
            )
        })
    }

    /// Said where all rows have one stamp.
    fn all_the_same(&self) -> Option<String> {
        (self.shared + 1 == self.rows).then(|| {
            format!(
                "`{T}` is {} in every row: the log says nothing of time, and motion and lasting \
                 noise are not seen; stamp each row, or leave the column out",
                self.ends[0]
            )
        })
    }

    /// The joints that move, and whether rows follow each other smoothly, and by steps that go on:
    /// postures that are put in order step back and forth.
    fn moving(&self) -> (Vec<&Joint>, bool, bool) {
        let moves = |joint: &&Joint| joint.about > MOVES * MOVES * self.rows as f64;
        let moving: Vec<&Joint> = self.joints.iter().filter(moves).collect();
        let sum = |of: fn(&Joint) -> f64| moving.iter().map(|joint| of(joint)).sum::<f64>();
        let stepped = sum(|joint| joint.stepped);
        let smooth = stepped < SMOOTH * 2.0 * sum(|joint| joint.about);
        let goes_on = sum(|joint| joint.bent) < GOES_ON * stepped;
        (moving, smooth, goes_on)
    }

    /// Said where rows are of a robot that moves and stamps do not say when: its motion is not
    /// counted.
    fn unusable(&self) -> Option<String> {
        let (_, smooth, goes_on) = self.moving();
        let timed = self.ends[0].is_finite();
        let coarse = timed && self.shared as f64 > SHARED * self.rows as f64;
        let told = timed && !coarse || self.shared + 1 == self.rows;
        if told || !goes_on || !smooth {
            return None;
        }
        let motion = "rows follow each other as those of a robot that moves do";
        Some(match timed {
            true => format!(
                "{} of {} rows share the stamp of the row above, and {motion}: `{T}` has too few \
                 digits, and motion is not counted; write times with at least three decimals",
                self.shared, self.rows
            ),
            false => format!(
                "{motion}, and the log has no column `{T}`: motion is not counted, and every row is \
                 taken for a robot that stands; add the time of each row, s"
            ),
        })
    }

    /// Said where stamps are hardly in seconds.
    fn other_unit(&self) -> Option<String> {
        let step = (self.ends[1] - self.ends[0]) / (self.rows as f64 - 1.0);
        let (moving, smooth, _) = self.moving();
        // Parts of their limits that joints reach.
        let reached = moving.iter().filter(|joint| joint.speed > 0.0);
        let reached = reached.map(|joint| joint.fastest / joint.speed);
        let reached = reached.fold(0.0, f64::max);
        // In minutes, rows come by the thousand a second, and joints move faster than they can.
        let rushes = step < LOGGED.0 && reached > FASTEST;
        if !smooth || reached == 0.0 || reached > CREEPS && !rushes {
            return None;
        }
        let fits = |unit: &&(&str, f64)| {
            let per_second = unit.1;
            let logged = (LOGGED.0..=LOGGED.1).contains(&(step / per_second));
            rushes == (per_second < 1.0) && logged && reached * per_second <= FASTEST
        };
        let (unit, per_second) = UNITS.iter().find(fits)?;
        let apart = step / per_second;
        Some(match rushes {
            true => format!(
                "rows are {step:.1e} s apart by `{T}`, and joints move {reached:.0} times as fast as \
                 they can: is `{T}` in {unit}? Rows would be {apart:.3} s apart then; give seconds"
            ),
            false => format!(
                "rows are {step:.3} s apart by `{T}`, and no joint moves faster than {:.4} % of its \
                 limit: is `{T}` in {unit}? Rows would be {apart:.3} s apart then; give seconds",
                100.0 * reached
            ),
        })
    }
}

/// Units that stamps come in, and how many of them are a second.
const UNITS: [(&str, f64); 6] = [
    ("ms", 1e3),
    ("µs", 1e6),
    ("ns", 1e9),
    ("minutes", 1.0 / 60.0),
    ("hours", 1.0 / 3600.0),
    ("days", 1.0 / 86_400.0),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::logs::tests::dofs;
    use crate::tests::says;

    fn warnings(limits: &[(f64, f64)], angles: Angles, rows: &[Vec<f64>]) -> String {
        let mut joints = dofs(&["a", "b", "c"][..limits.len()]);
        for (dof, (lower, upper)) in joints.iter_mut().zip(limits) {
            (dof.lower, dof.upper) = (*lower, *upper);
        }
        let mut suspicions = Suspicions::new(&joints, angles);
        suspicions.see(&Block {
            line: vec![0; rows.len()],
            q: rows
                .iter()
                .flat_map(|row| &row[..limits.len()])
                .copied()
                .collect(),
            ..Block::default()
        });
        let said = suspicions.judge().into_iter().map(|said| said.to_string());
        // Rows of these tests follow each other and have no times.
        let said = said.filter(|said| !said.contains("motion is not counted"));
        said.collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn angles_in_another_unit_and_swapped_columns_are_noticed() {
        let column = |q: &dyn Fn(f64) -> f64| -> Vec<Vec<f64>> {
            (1..40).map(|k| vec![q(f64::from(k)), -0.1]).collect()
        };
        let wide = [(-6.0, 6.0), (-0.5, 0.5)];
        let of = |limits, angles, q: &dyn Fn(f64) -> f64| warnings(limits, angles, &column(q));
        let whole = of(&wide[..1], Angles::Rad, &|k| k % 6.0);
        says(whole, &["whole numbers", "give `angles` or"]);
        assert_eq!(of(&wide[..1], Angles::Rad, &|k| k / 41.0), "");
        let radians = of(&[(-2.0, 2.0)], Angles::Deg, &|k| (k / 20.0).to_radians());
        says(radians, &["radians"]);
        let beyond = |k: f64| 1.0 + k / 80.0;
        let swapped = of(&[(-0.5, 0.5), (-0.5, 2.0)], Angles::Rad, &beyond);
        says(&swapped, &["`a`", "`b`"]);
        assert_eq!(swapped.lines().count(), 1, "{swapped}");
        assert_eq!(of(&[(-0.5, 2.0), (-0.5, 0.5)], Angles::Rad, &beyond), "");
    }

    /// A log of the joints without any rows yet.
    fn stamps(joints: &[&str]) -> Suspicions {
        Suspicions::new(&dofs(joints), Angles::Rad)
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
        for (unit, seconds) in [("minutes", 60.0), ("hours", 3600.0), ("days", 86_400.0)] {
            let said = said(0.01, 1.0, 1.0 / seconds).unwrap();
            assert!(said.contains(&format!("in {unit}?")), "{said}");
        }
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
        assert_eq!(stamps.other_unit(), None);
        assert_eq!(stamps.all_the_same(), None);
        // One stamp for all rows.
        let mut stamps = self::stamps(&["a"]);
        for k in 0..40 {
            stamps.see(&row(7.0, &[f64::from(k)]));
        }
        assert!(stamps.all_the_same().unwrap().contains("7 in every row"));
    }
}
