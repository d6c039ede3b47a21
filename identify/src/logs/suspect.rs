//! What a whole log looks like it got wrong: degrees for radians, two columns
//! swapped, millimetres, time running backwards, standing still or in another unit.
//!
//! Each is a warning: the values are possible, only unlikely. Memory: some
//! numbers per joint.

use sesc_model::tree::Dof;

use super::block::Block;
use super::columns::T;
use super::criteria::{CREEPS, FASTEST, FEW, GOES_ON, LOGGED, MOVES, SHARED, SLACK, SMOOTH, SOLE};
use super::sidecar::{Angles, IN_DEGREES, OR_SIDECAR};
use crate::{Message, Setting, message};

/// Statistics of a log, and what was said about it.
pub(super) struct Suspicions {
    file: String,
    joints: Vec<Dof>,
    seen: Seen,
    /// From rad back to the unit of the file.
    per_rad: f64,
    degrees: bool,
    readings: u64,
    /// Sum of |CoP|, m.
    reach: f64,
    last_t: f64,
    backwards: Option<u64>,
    stamps: Stamps,
    said: [bool; 8],
}

/// What the columns of all joints show: a row is taken note of by a few operations on whole
/// registers.
struct Seen {
    rows: u64,
    /// Limits with their slack, rad or m; infinite where none mean something.
    lower: Vec<f64>,
    upper: Vec<f64>,
    least: Vec<f64>,
    most: Vec<f64>,
    outside: Vec<u64>,
    /// Values other than zero, and how many of them are whole in the file's unit.
    nonzero: Vec<u64>,
    whole: Vec<u64>,
}

/// Adding and taking away this rounds what is much smaller to the next whole number.
const TO_WHOLE: f64 = 6_755_399_441_055_744.0;

impl Seen {
    fn new(dofs: &[Dof]) -> Seen {
        let n = dofs.len();
        // A servo is beyond its limits by no more than the slack.
        let limit = |limit: fn(&Dof) -> f64, side: f64| {
            let own = |dof: &Dof| match (dof.continuous, dof.prismatic) {
                (true, _) => side * f64::INFINITY,
                (_, true) => limit(dof),
                _ => limit(dof) + side * SLACK,
            };
            dofs.iter().map(own).collect()
        };
        Seen {
            rows: 0,
            lower: limit(|dof| dof.lower, -1.0),
            upper: limit(|dof| dof.upper, 1.0),
            least: vec![f64::INFINITY; n],
            most: vec![f64::NEG_INFINITY; n],
            outside: vec![0; n],
            nonzero: vec![0; n],
            whole: vec![0; n],
        }
    }

    /// Joints of a row, rad or m; `per_rad` makes them what the file says.
    fn row(&mut self, q: &[f64], per_rad: f64) {
        let n = q.len();
        let (lower, upper) = (&self.lower[..n], &self.upper[..n]);
        let (least, most) = (&mut self.least[..n], &mut self.most[..n]);
        let outside = &mut self.outside[..n];
        let (nonzero, whole) = (&mut self.nonzero[..n], &mut self.whole[..n]);
        self.rows += 1;
        for k in 0..n {
            let (q, written) = (q[k], q[k] * per_rad);
            least[k] = if q < least[k] { q } else { least[k] };
            most[k] = if q > most[k] { q } else { most[k] };
            outside[k] += u64::from((q < lower[k]) | (q > upper[k]));
            let is_whole = (written - ((written + TO_WHOLE) - TO_WHOLE)).abs() < 1e-9;
            nonzero[k] += u64::from(q != 0.0);
            whole[k] += u64::from((q != 0.0) & is_whole);
        }
    }

    /// Whether column `k` respects the limits of joint `joint`.
    fn fits(&self, k: usize, joint: usize) -> bool {
        self.least[k] >= self.lower[joint] && self.most[k] <= self.upper[joint]
    }

    /// Beyond its own limits mostly, as a column is that belongs to another.
    fn strays(&self, k: usize) -> bool {
        self.rows >= FEW && 4 * self.outside[k] > self.rows
    }
}

impl Suspicions {
    pub fn new(file: &str, dofs: &[Dof], angles: Angles) -> Suspicions {
        let degrees = angles == Angles::Deg;
        Suspicions {
            file: file.to_string(),
            seen: Seen::new(dofs),
            joints: dofs.to_vec(),
            per_rad: if degrees {
                180.0 / std::f64::consts::PI
            } else {
                1.0
            },
            degrees,
            readings: 0,
            reach: 0.0,
            last_t: f64::NEG_INFINITY,
            backwards: None,
            stamps: Stamps::new(dofs),
            said: [false; 8],
        }
    }

    /// Take note of some rows.
    pub fn see(&mut self, block: &Block) {
        for row in block.q.chunks_exact(self.joints.len().max(1)) {
            self.seen.row(row, self.per_rad);
        }
        for [x, y] in block.reading.iter().flatten() {
            self.readings += 1;
            self.reach += (x * x + y * y).sqrt();
        }
        for (t, line) in block.t.iter().flatten().zip(&block.line) {
            if *t < self.last_t && self.backwards.is_none() {
                self.backwards = Some(*line);
            }
            self.last_t = *t;
        }
        match &block.t {
            Some(t) => self.stamps.see(t, &block.q),
            None => self.stamps.see(&vec![f64::NAN; block.len()], &block.q),
        }
    }

    /// Say what was noticed and not yet said.
    pub fn judge(&mut self, warnings: &mut Vec<Message>) {
        let found = [
            self.degrees(),
            self.radians(),
            self.swapped().map(Message::from),
            self.millimetres().map(Message::from),
            self.backwards.map(|line| {
                let remedy = "sort the log by time if it is one motion";
                Message::from(format!("row {line}: `{T}` runs backwards; {remedy}"))
            }),
            self.stamps.all_the_same().map(Message::from),
            self.stamps.other_unit().map(Message::from),
            self.stamps.unusable().map(Message::from),
        ];
        for (said, found) in self.said.iter_mut().zip(found) {
            if let (false, Some(found)) = (*said, found) {
                *said = true;
                warnings.push(found.after(&format!("{}: ", self.file)));
            }
        }
    }

    fn revolute(&self) -> impl Iterator<Item = usize> {
        (0..self.joints.len()).filter(|&k| !self.joints[k].prismatic)
    }

    /// Largest angle of a revolute joint, rad.
    fn largest(&self) -> f64 {
        let most = |k: usize| self.seen.most[k].max(-self.seen.least[k]);
        self.revolute().map(most).fold(0.0, f64::max)
    }

    /// Radians that look like degrees: whole numbers, or far beyond the limits
    /// of most joints.
    fn degrees(&self) -> Option<Message> {
        let seen = &self.seen;
        let nonzero: u64 = self.revolute().map(|k| seen.nonzero[k]).sum();
        let whole: u64 = self.revolute().map(|k| seen.whole[k]).sum();
        let count = self.revolute().count();
        let straying = self.revolute().filter(|&k| seen.strays(k)).count();
        let why = if nonzero >= FEW && 10 * whole > 9 * nonzero && self.largest() >= 2.0 {
            "nearly all angles are whole numbers"
        } else if straying > 2 && 2 * straying > count {
            "most joints are far beyond their limits"
        } else {
            return None;
        };
        let why = format!("{why}; {IN_DEGREES}");
        (!self.degrees).then(|| message![why, Setting::Angles, OR_SIDECAR])
    }

    /// Degrees that look like radians: no joint ever moves by more than π of them.
    fn radians(&self) -> Option<Message> {
        let most = self.largest() * self.per_rad;
        let nonzero: u64 = self.revolute().map(|k| self.seen.nonzero[k]).sum();
        (self.degrees && nonzero >= FEW && most <= std::f64::consts::PI).then(|| {
            let said = format!("read in degrees, no joint ever moves beyond {most:.2}°");
            message![
                format!("{said}; if the log is in radians, leave out "),
                Setting::Angles,
                " and `angles = \"deg\"`"
            ]
        })
    }

    /// Two joints, one or both beyond their limits, that would fit if exchanged.
    fn swapped(&self) -> Option<String> {
        let (joints, seen) = (&self.joints, &self.seen);
        let could_be = |column: usize, joint: usize| {
            let alike = joints[column].prismatic == joints[joint].prismatic;
            alike && !joints[joint].continuous && seen.fits(column, joint)
        };
        let strays = (0..joints.len()).filter(|&stray| seen.strays(stray));
        let pairs = strays.filter_map(|stray| {
            let exchanged =
                |&other: &usize| other != stray && could_be(stray, other) && could_be(other, stray);
            let mut partners = (0..joints.len()).filter(exchanged);
            let first = partners.next()?;
            let own = &joints[stray].joint;
            let mut said = format!("column `{own}` is beyond its joint's limits");
            // One candidate is a finding, several are a guess.
            if partners.next().is_none() {
                let fits = &joints[first].joint;
                said += &format!(", but fits `{fits}`, and the other way round");
            }
            Some(said)
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

/// What stamps and joints of a log say of each other: stamps that stand still, and stamps in
/// another unit than seconds.
///
/// ```text
/// v_j = max |Δq_j| / Δt ≪ v_limit        in rows that follow each other smoothly:
/// Σ |Δq|² ≪ 2 n Σ Var(q_j)
/// ```
///
/// A robot that creeps for hours is logged slowly; one whose rows are smooth, seconds apart by
/// their stamps, and thousands of times slower than its joints can be was stamped in ms, µs
/// or ns, one that is faster than they can be in minutes or days.
struct Stamps {
    /// Speed that each joint is allowed, rad/s or m/s.
    limits: Vec<f64>,
    rows: u64,
    ends: [f64; 2],
    /// Rows that share the stamp of the row above.
    shared: u64,
    last_t: f64,
    last_q: Vec<f64>,
    /// Largest speed of each joint by the stamps.
    fastest: Vec<f64>,
    /// Its last step, the sum of the squares of its steps, and that of their changes.
    last_step: Vec<f64>,
    stepped: Vec<f64>,
    bent: Vec<f64>,
    /// Mean of its positions, and sum of squares about it.
    mean: Vec<f64>,
    about: Vec<f64>,
}

impl Stamps {
    fn new(dofs: &[Dof]) -> Stamps {
        let zeros = vec![0.0; dofs.len()];
        Stamps {
            limits: dofs.iter().map(|dof| dof.speed).collect(),
            rows: 0,
            ends: [f64::INFINITY, f64::NEG_INFINITY],
            shared: 0,
            last_t: f64::NAN,
            last_q: zeros.clone(),
            fastest: zeros.clone(),
            last_step: zeros.clone(),
            stepped: zeros.clone(),
            bent: zeros.clone(),
            mean: zeros.clone(),
            about: zeros,
        }
    }

    /// Take note of rows at times `t` with joints `q`, row after row.
    fn see(&mut self, t: &[f64], q: &[f64]) {
        let n = self.limits.len();
        if n == 0 {
            return;
        }
        for (&t, q) in t.iter().zip(q.chunks_exact(n)) {
            self.rows += 1;
            self.ends = [self.ends[0].min(t), self.ends[1].max(t)];
            let follows = self.rows > 1;
            self.shared += u64::from(t == self.last_t);
            let per_second = match follows && t > self.last_t {
                true => 1.0 / (t - self.last_t),
                false => 0.0,
            };
            let weight = 1.0 / self.rows as f64;
            let (last, fastest) = (&mut self.last_q[..n], &mut self.fastest[..n]);
            let (stepped, mean) = (&mut self.stepped[..n], &mut self.mean[..n]);
            let about = &mut self.about[..n];
            let (last_step, bent) = (&mut self.last_step[..n], &mut self.bent[..n]);
            for j in 0..n {
                let step = if follows { q[j] - last[j] } else { 0.0 };
                let speed = step.abs() * per_second;
                fastest[j] = if speed > fastest[j] {
                    speed
                } else {
                    fastest[j]
                };
                stepped[j] += step * step;
                bent[j] += (step - last_step[j]) * (step - last_step[j]);
                last_step[j] = step;
                let off = q[j] - mean[j];
                mean[j] += off * weight;
                about[j] += off * (q[j] - mean[j]);
                last[j] = q[j];
            }
            self.last_t = t;
        }
    }

    /// Said where all rows have one stamp.
    fn all_the_same(&self) -> Option<String> {
        (self.rows >= FEW && self.shared + 1 == self.rows).then(|| {
            format!(
                "`{T}` is {} in every row: the log says nothing of time, and motion and lasting \
                 noise are not seen; stamp each row, or leave the column out",
                self.ends[0]
            )
        })
    }

    /// The joints that move.
    fn moving(&self) -> Vec<usize> {
        let moves = |j: &usize| self.about[*j] > MOVES * MOVES * self.rows as f64;
        (0..self.limits.len()).filter(moves).collect()
    }

    /// Whether rows follow each other as those of a robot that moves do.
    fn is_smooth(&self, moving: &[usize]) -> bool {
        let sum = |of: &[f64]| moving.iter().map(|&j| of[j]).sum::<f64>();
        sum(&self.stepped) < SMOOTH * 2.0 * sum(&self.about)
    }

    /// Said where rows are of a robot that moves and stamps do not say when: its motion is not
    /// counted.
    fn unusable(&self) -> Option<String> {
        let moving = self.moving();
        let timed = self.ends[0].is_finite();
        let coarse = timed && self.shared as f64 > SHARED * self.rows as f64;
        // Postures that are put in order step back and forth; a joint that moves goes on.
        let sum = |of: &[f64]| moving.iter().map(|&j| of[j]).sum::<f64>();
        let goes_on = sum(&self.bent) < GOES_ON * sum(&self.stepped);
        let told = timed && !coarse || self.shared + 1 == self.rows;
        if self.rows < FEW || told || !goes_on || !self.is_smooth(&moving) {
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
        if self.rows < FEW {
            return None;
        }
        let rows = self.rows as f64;
        let step = (self.ends[1] - self.ends[0]) / (rows - 1.0);
        let moving = self.moving();
        let smooth = self.is_smooth(&moving);
        // Parts of their limits that joints reach.
        let reached = moving.iter().filter(|&&j| self.limits[j] > 0.0);
        let reached = reached.map(|&j| self.fastest[j] / self.limits[j]);
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
        let mut suspicions = Suspicions::new("f", &joints, angles);
        suspicions.see(&Block {
            line: vec![0; rows.len()],
            q: rows
                .iter()
                .flat_map(|row| &row[..limits.len()])
                .copied()
                .collect(),
            ..Block::default()
        });
        let mut warnings = Vec::new();
        suspicions.judge(&mut warnings);
        suspicions.judge(&mut warnings);
        let said = warnings.iter().map(Message::to_string);
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
        assert!(said(0.01, 1.0, 1.0 / 60.0).unwrap().contains("in minutes?"));
        assert!(
            said(0.01, 1.0, 1.0 / 86_400.0)
                .unwrap()
                .contains("in days?")
        );
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
        // One stamp for all rows.
        let mut stamps = Stamps::new(&dofs(&["a"]));
        for k in 0..40 {
            stamps.see(&[7.0], &[f64::from(k)]);
        }
        assert!(stamps.all_the_same().unwrap().contains("7 in every row"));
    }
}
