//! What a whole log looks like it got wrong: degrees for radians, two columns
//! swapped, millimetres, time running backwards, standing still or in another unit.
//!
//! Each is a warning: the values are possible, only unlikely. Memory: some
//! numbers per joint.

use sesc_model::tree::Dof;

use super::block::Block;
use super::columns::T;
use super::criteria::{FEW, SLACK, SOLE};
use super::sidecar::{Angles, IN_DEGREES, OR_SIDECAR};
use super::stamps::Stamps;
use crate::{Message, Setting, message};

/// Statistics of a log, and what was said about it.
pub(super) struct Suspicions {
    file: String,
    joints: Vec<Joint>,
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
    said: [bool; 7],
}

/// What one joint did.
struct Joint {
    name: String,
    revolute: bool,
    /// Limits that mean something, rad or m.
    limits: Option<(f64, f64)>,
    count: u64,
    least: f64,
    most: f64,
    outside: u64,
    /// Values other than zero, and how many of them are whole in the file's unit.
    nonzero: u64,
    whole: u64,
}

/// What rows of all joints show, joint by joint: a row is taken note of by a few operations on
/// whole registers.
struct Seen {
    rows: u64,
    /// Limits with their slack, rad or m; infinite where none mean something.
    lower: Vec<f64>,
    upper: Vec<f64>,
    least: Vec<f64>,
    most: Vec<f64>,
    outside: Vec<u64>,
    nonzero: Vec<u64>,
    whole: Vec<u64>,
}

/// Adding and taking away this rounds what is much smaller to the next whole number.
const TO_WHOLE: f64 = 6_755_399_441_055_744.0;

impl Seen {
    fn new(joints: &[Joint]) -> Seen {
        let n = joints.len();
        let limit = |of: fn((f64, f64), f64) -> f64, open: f64| {
            let own = |joint: &Joint| joint.limits.map_or(open, |own| of(own, joint.slack()));
            joints.iter().map(own).collect()
        };
        Seen {
            rows: 0,
            lower: limit(|(lower, _), slack| lower - slack, f64::NEG_INFINITY),
            upper: limit(|(_, upper), slack| upper + slack, f64::INFINITY),
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

    fn tell(&self, joints: &mut [Joint]) {
        for (k, joint) in joints.iter_mut().enumerate() {
            joint.count = self.rows;
            (joint.least, joint.most) = (self.least[k], self.most[k]);
            joint.outside = self.outside[k];
            (joint.nonzero, joint.whole) = (self.nonzero[k], self.whole[k]);
        }
    }
}

impl Joint {
    fn new(dof: &Dof) -> Joint {
        Joint {
            name: dof.joint.clone(),
            revolute: !dof.prismatic,
            limits: (!dof.continuous).then_some((dof.lower, dof.upper)),
            count: 0,
            least: f64::INFINITY,
            most: f64::NEG_INFINITY,
            outside: 0,
            nonzero: 0,
            whole: 0,
        }
    }

    /// A servo is beyond its limits by no more than this, rad.
    fn slack(&self) -> f64 {
        if self.revolute { SLACK } else { 0.0 }
    }

    /// Whether values from `least` to `most` respect the limits.
    fn allows(&self, least: f64, most: f64) -> bool {
        let slack = self.slack();
        self.limits
            .is_none_or(|(lower, upper)| least >= lower - slack && most <= upper + slack)
    }

    /// Beyond its own limits mostly, as a column is that belongs to another.
    fn strays(&self) -> bool {
        self.count >= FEW && 4 * self.outside > self.count
    }
}

impl Suspicions {
    pub fn new(file: &str, dofs: &[Dof], angles: Angles) -> Suspicions {
        let degrees = angles == Angles::Deg;
        let joints: Vec<Joint> = dofs.iter().map(Joint::new).collect();
        Suspicions {
            file: file.to_string(),
            seen: Seen::new(&joints),
            joints,
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
            said: [false; 7],
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
        if let Some(t) = &block.t {
            self.stamps.see(t, &block.q);
        }
    }

    /// Say what was noticed and not yet said.
    pub fn judge(&mut self, warnings: &mut Vec<Message>) {
        self.seen.tell(&mut self.joints);
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
        ];
        for (said, found) in self.said.iter_mut().zip(found) {
            if let (false, Some(found)) = (*said, found) {
                *said = true;
                warnings.push(found.after(&format!("{}: ", self.file)));
            }
        }
    }

    /// Radians that look like degrees: whole numbers, or far beyond the limits
    /// of most joints.
    fn degrees(&self) -> Option<Message> {
        let revolute = || self.joints.iter().filter(|joint| joint.revolute);
        let sum = |of: fn(&Joint) -> u64| revolute().map(of).sum::<u64>();
        let (count, nonzero) = (sum(|j| j.count), sum(|j| j.nonzero));
        let most = revolute().map(|j| j.most.max(-j.least)).fold(0.0, f64::max);
        let whole = nonzero >= FEW && 10 * sum(|j| j.whole) > 9 * nonzero && most >= 2.0;
        let straying = revolute().filter(|joint| joint.strays()).count();
        let beyond = count >= FEW && straying > 2 && 2 * straying > revolute().count();
        let why = match (whole, beyond) {
            _ if self.degrees => return None,
            (true, _) => "nearly all angles are whole numbers",
            (_, true) => "most joints are far beyond their limits",
            _ => return None,
        };
        let why = format!("{why}; {IN_DEGREES}");
        Some(message![why, Setting::Angles, OR_SIDECAR])
    }

    /// Degrees that look like radians: no joint ever moves by more than π of them.
    fn radians(&self) -> Option<Message> {
        let revolute = || self.joints.iter().filter(|joint| joint.revolute);
        let most = revolute().map(|j| j.most.max(-j.least)).fold(0.0, f64::max) * self.per_rad;
        let nonzero: u64 = revolute().map(|joint| joint.nonzero).sum();
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
        let fits = |column: &Joint, joint: &Joint| {
            column.revolute == joint.revolute
                && joint.limits.is_some()
                && joint.allows(column.least, column.most)
        };
        let pairs: Vec<String> = self
            .joints
            .iter()
            .filter(|stray| stray.strays())
            .filter_map(|stray| {
                let partner = |other: &&Joint| {
                    let itself = other.name == stray.name;
                    !itself && fits(stray, other) && fits(other, stray)
                };
                let mut partners = self.joints.iter().filter(partner);
                // One candidate is a finding, several are a guess.
                match (partners.next(), partners.next()) {
                    (Some(other), None) => Some(format!(
                        "column `{}` is beyond its joint's limits, but fits `{}`, and the other \
                         way round",
                        stray.name, other.name
                    )),
                    (Some(_), Some(_)) => Some(format!(
                        "column `{}` is beyond its joint's limits",
                        stray.name
                    )),
                    _ => None,
                }
            })
            .take(4)
            .collect();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::logs::tests::dofs;

    fn warnings(limits: &[(f64, f64)], angles: Angles, rows: &[Vec<f64>]) -> String {
        let mut joints = dofs(&["a", "b", "c"][..limits.len()]);
        for (dof, (lower, upper)) in joints.iter_mut().zip(limits) {
            (dof.lower, dof.upper) = (*lower, *upper);
        }
        let mut suspicions = Suspicions::new("f", &joints, angles);
        suspicions.see(&Block {
            line: vec![0; rows.len()],
            q: rows.concat(),
            ..Block::default()
        });
        let mut warnings = Vec::new();
        suspicions.judge(&mut warnings);
        suspicions.judge(&mut warnings);
        let said: Vec<String> = warnings.iter().map(Message::to_string).collect();
        said.join("\n")
    }

    #[test]
    fn whole_angles_look_like_degrees() {
        let rows: Vec<Vec<f64>> = (0..30).map(|k| vec![f64::from(k % 6)]).collect();
        let said = warnings(&[(-6.0, 6.0)], Angles::Rad, &rows);
        assert!(
            said.contains("whole numbers") && said.contains("give `angles` or"),
            "{said}"
        );
        let rows: Vec<Vec<f64>> = (0..30).map(|k| vec![f64::from(k) / 31.0]).collect();
        assert_eq!(warnings(&[(-6.0, 6.0)], Angles::Rad, &rows), "");
    }

    #[test]
    fn radians_read_in_degrees_are_noticed() {
        let rows: Vec<Vec<f64>> = (1..40)
            .map(|k| vec![(f64::from(k) / 20.0).to_radians()])
            .collect();
        let said = warnings(&[(-2.0, 2.0)], Angles::Deg, &rows);
        assert!(said.contains("radians"), "{said}");
    }

    #[test]
    fn swapped_columns_are_named_both() {
        let rows: Vec<Vec<f64>> = (0..40)
            .map(|k| vec![1.0 + f64::from(k) / 80.0, -0.1])
            .collect();
        let said = warnings(&[(-0.5, 0.5), (-0.5, 2.0)], Angles::Rad, &rows);
        assert!(said.contains("`a`") && said.contains("`b`"), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert_eq!(
            warnings(&[(-0.5, 2.0), (-0.5, 0.5)], Angles::Rad, &rows),
            ""
        );
    }
}
