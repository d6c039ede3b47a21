//! What a whole log looks like it got wrong: degrees for radians, two columns
//! swapped, millimetres, time running backwards.
//!
//! Each is a warning: the values are possible, only unlikely. Memory: some
//! numbers per joint.

use sesc_model::tree::Dof;

use super::block::Block;
use super::columns::T;
use super::criteria::{FEW, SLACK, SOLE};
use super::sidecar::{Angles, IN_DEGREES, OR_SIDECAR};
use crate::{Message, Setting, message};

/// Statistics of a log, and what was said about it.
pub(super) struct Suspicions {
    file: String,
    joints: Vec<Joint>,
    /// From rad back to the unit of the file.
    per_rad: f64,
    degrees: bool,
    readings: u64,
    /// Sum of |CoP|, m.
    reach: f64,
    last_t: f64,
    backwards: Option<u64>,
    said: [bool; 5],
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

    fn see(&mut self, q: f64, written: f64) {
        self.count += 1;
        self.least = self.least.min(q);
        self.most = self.most.max(q);
        self.outside += u64::from(!self.allows(q, q));
        if q != 0.0 {
            self.nonzero += 1;
            self.whole += u64::from((written - written.round()).abs() < 1e-9);
        }
    }

    /// Whether values from `least` to `most` respect the limits.
    fn allows(&self, least: f64, most: f64) -> bool {
        let slack = if self.revolute { SLACK } else { 0.0 };
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
        Suspicions {
            file: file.to_string(),
            joints: dofs.iter().map(Joint::new).collect(),
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
            said: [false; 5],
        }
    }

    /// Take note of some rows.
    pub fn see(&mut self, block: &Block) {
        for row in block.q.chunks_exact(self.joints.len().max(1)) {
            for (joint, q) in self.joints.iter_mut().zip(row) {
                joint.see(*q, q * self.per_rad);
            }
        }
        for [x, y] in block.reading.iter().flatten() {
            self.readings += 1;
            self.reach += x.hypot(*y);
        }
        for (t, line) in block.t.iter().flatten().zip(&block.line) {
            if *t < self.last_t && self.backwards.is_none() {
                self.backwards = Some(*line);
            }
            self.last_t = *t;
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
