//! Joint limits that postures keep: the URDF's, narrowed by a file.
//!
//! ```text
//! joint,lower_deg,upper_deg          or  lower_rad,upper_rad  and  lower_m,upper_m
//! l_knee,-130,6
//! ```
//!
//! The header names the units: revolute joints in degrees or radians, prismatic
//! ones in metres; a file may have several pairs of columns, a row fills one.
//! Lines that begin with `#` are comments.

use std::collections::HashMap;
use std::path::Path;

use csv::StringRecord;
use nalgebra::{SMatrix, SVector};
use sesc_model::files;
use sesc_model::spelling::nearest;
use sesc_model::tree::Dof;

use crate::logs::names::list;
use crate::{Error, Setting, message};

/// A range per independent joint, and what was noticed.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// Lower and upper limit of each joint, rad or m.
    pub ranges: Vec<(f64, f64)>,
    /// What was noticed about the file of limits.
    pub notes: Vec<String>,
}

/// A pair of columns: name of its unit, whether of prismatic joints, SI per unit.
const UNITS: [(&str, bool, f64); 3] = [
    ("deg", false, std::f64::consts::PI / 180.0),
    ("rad", false, 1.0),
    ("m", true, 1.0),
];

impl Limits {
    /// The limits of the URDF; ±180° where a joint has none.
    pub fn of_urdf(dofs: &[Dof]) -> Limits {
        Limits {
            ranges: dofs.iter().map(|dof| (dof.lower, dof.upper)).collect(),
            notes: Vec::new(),
        }
    }

    /// Those of the URDF, narrowed by the file at `path`.
    ///
    /// # Errors
    /// Names file, line, joint and remedy.
    pub fn read(path: &Path, dofs: &[Dof]) -> Result<Limits, Error> {
        let file = path.display().to_string();
        let failed = |source| Error::read(&file, source);
        let text = files::read_text(path, files::SETTINGS).map_err(failed)?;
        Limits::parse(&text, &file, dofs)
    }

    /// Those of the URDF, narrowed by `asked`: joints with lower and upper limit, rad or m.
    ///
    /// # Errors
    /// Names the joint and the remedy.
    pub fn of_joints<'a>(
        asked: impl IntoIterator<Item = (&'a str, (f64, f64))>,
        dofs: &[Dof],
    ) -> Result<Limits, Error> {
        let bad = |message: String| {
            let message = format!(": {message}");
            Error::request(message![Setting::Limits, message])
        };
        let mut limits = Limits::of_urdf(dofs);
        for (name, (lower, upper)) in asked {
            let joint = place(name, dofs).map_err(bad)?;
            if !(lower.is_finite() && upper.is_finite()) {
                let said = format!("joint `{name}`: {lower} to {upper} is no range; give numbers");
                return Err(bad(said));
            }
            let ordered = in_order(name, (lower, upper));
            let kept = ordered.and_then(|range| limits.narrow(joint, range, &dofs[joint]));
            kept.map_err(bad)?;
        }
        Ok(limits)
    }

    /// Narrow the range of a joint; gives whether `range` lies within it.
    fn narrow(&mut self, joint: usize, range: (f64, f64), dof: &Dof) -> Result<bool, String> {
        let (least, most) = self.ranges[joint];
        let kept = (range.0.max(least), range.1.min(most));
        if kept.0 > kept.1 {
            let (per, unit) = if dof.prismatic {
                (1.0, "m")
            } else {
                (UNITS[0].2, "°")
            };
            let [lower, upper, least, most] = [range.0, range.1, least, most].map(|x| x / per);
            return Err(format!(
                "joint `{}`: {lower:.4} to {upper:.4} {unit} lies outside the URDF's {least:.4} \
                 to {most:.4} {unit}; check sign and unit",
                dof.joint.trim()
            ));
        }
        self.ranges[joint] = kept;
        Ok(kept == range)
    }

    fn parse(text: &str, file: &str, dofs: &[Dof]) -> Result<Limits, Error> {
        let mut limits = Limits::of_urdf(dofs);
        let mut columns = None;
        let mut lines: HashMap<usize, u64> = HashMap::new();
        let mut wider = Vec::new();
        for (line, text) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
            let bad = |message: String| Error::log(file, Some(line), message);
            let Some(cells) = cells(text) else {
                continue;
            };
            let Some(columns) = &columns else {
                columns = Some(Columns::of(&cells).map_err(bad)?);
                continue;
            };
            let name = cells.get(columns.joint).unwrap_or("");
            let joint = place(name, dofs).map_err(bad)?;
            if let Some(before) = lines.insert(joint, line) {
                return Err(bad(format!(
                    "joint `{name}` already has limits on line {before}; keep one line"
                )));
            }
            let range = columns.range(&cells, &dofs[joint]).map_err(bad)?;
            if !limits.narrow(joint, range, &dofs[joint]).map_err(bad)? {
                wider.push(dofs[joint].joint.trim());
            }
        }
        if lines.is_empty() {
            let message = match columns {
                Some(_) => "holds no limits; add a line per joint",
                None => NO_HEADER,
            };
            return Err(Error::log(file, None, message));
        }
        if !wider.is_empty() {
            limits.notes.push(format!(
                "{file} reaches beyond the URDF for {}; the URDF's limits hold there",
                wider.join(", ")
            ));
        }
        let missing = dofs.len() - lines.len();
        if missing > 0 {
            let note = format!("{file} says nothing of {missing} joints: URDF limits");
            limits.notes.push(note);
        }
        Ok(limits)
    }

    /// The posture within the limits that is closest to zero.
    pub fn rest(&self) -> Vec<f64> {
        let rest = |&(lower, upper): &(f64, f64)| 0f64.clamp(lower, upper);
        self.ranges.iter().map(rest).collect()
    }
}

const NO_HEADER: &str = "no header `joint,lower_deg,upper_deg` (or lower_rad,upper_rad; \
                         lower_m,upper_m for prismatic joints); the header says the unit";

/// What a line holds; none of one that is empty or a comment.
fn cells(line: &str) -> Option<StringRecord> {
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .has_headers(false)
        .from_reader(line.as_bytes());
    let record = reader.records().next()?.ok();
    record.filter(|_| !line.starts_with('#'))
}

/// Where things are in a row.
struct Columns {
    joint: usize,
    /// For each of [`UNITS`]: lower and upper.
    pairs: [Option<[usize; 2]>; 3],
}

impl Columns {
    fn of(header: &StringRecord) -> Result<Columns, String> {
        let is = |name: &str, cell: &str| cell.eq_ignore_ascii_case(name);
        let at = |name: &str| header.iter().position(|cell| is(name, cell));
        let ends = |unit| Some([at(&format!("lower_{unit}"))?, at(&format!("upper_{unit}"))?]);
        let pairs = UNITS.map(|(unit, ..)| ends(unit));
        match at("joint").filter(|_| pairs.iter().any(Option::is_some)) {
            Some(joint) => Ok(Columns { joint, pairs }),
            None => Err(NO_HEADER.to_string()),
        }
    }

    /// Lower and upper limit of a row, rad or m.
    fn range(&self, row: &StringRecord, dof: &Dof) -> Result<(f64, f64), String> {
        let name = &dof.joint;
        let mut filled = self.pairs.iter().zip(UNITS).filter_map(|(pair, unit)| {
            let cells = (*pair)?.map(|k| row.get(k).unwrap_or(""));
            Some((cells, unit)).filter(|(cells, _)| cells.concat() != "")
        });
        let none = || format!("joint `{name}` has no limits on its line; give both");
        let (cells, (unit, prismatic, si)) = filled.next().ok_or_else(none)?;
        if filled.next().is_some() {
            return Err(format!("joint `{name}` has limits in two units; keep one"));
        }
        if prismatic != dof.prismatic {
            let (is, right) = if dof.prismatic {
                ("prismatic", "lower_m,upper_m")
            } else {
                ("revolute", "lower_deg,upper_deg or lower_rad,upper_rad")
            };
            return Err(format!(
                "joint `{name}` is {is}, its limits are in {unit}; use columns {right}"
            ));
        }
        let number = |cell: &str| {
            let number = cell.parse().ok().filter(|x: &f64| x.is_finite());
            number.ok_or_else(|| {
                format!("joint `{name}`: `{cell}` is no number; give both limits in {unit}")
            })
        };
        let (lower, upper) = in_order(name, (number(cells[0])?, number(cells[1])?))?;
        Ok((si * lower, si * upper))
    }
}

fn in_order(joint: &str, (lower, upper): (f64, f64)) -> Result<(f64, f64), String> {
    if lower <= upper {
        return Ok((lower, upper));
    }
    Err(format!(
        "joint `{joint}`: lower {lower} is above upper {upper}; swap them"
    ))
}

/// Place of a joint among those that move by themselves.
fn place(name: &str, dofs: &[Dof]) -> Result<usize, String> {
    let names: Vec<&str> = dofs.iter().map(|dof| dof.joint.trim()).collect();
    let found = names.iter().position(|own| *own == name.trim());
    found.ok_or_else(|| {
        let remedy = match nearest(name, "", names.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("those that do: {}", list(&names)),
        };
        format!("no joint `{name}` moves by itself; {remedy}")
    })
}

/// Least motion, in parts of the ranges, that changes N equations by `wanted`; `slopes` has a row
/// of each, joint by joint. So much `damping` holds what no joint moves.
pub(super) fn move_by<const N: usize>(
    q: &mut [f64],
    wanted: [f64; N],
    slopes: [&[f64]; N],
    damping: f64,
    ranges: &[(f64, f64)],
) {
    let squares = ranges.iter().map(|(lower, upper)| (upper - lower).powi(2));
    let mut weights: Vec<f64> = squares.collect();
    let mut steps = vec![0.0; q.len()];
    // Joints at a limit that would go further stay; the others do their part.
    for _ in 0..2 {
        let column = |j: usize| SVector::<f64, N>::from_fn(|row, _| slopes[row][j]);
        let mut gram = SMatrix::<f64, N, N>::zeros();
        for (j, weight) in weights.iter().enumerate() {
            gram += column(j) * column(j).transpose() * *weight;
        }
        let damping = damping * gram.trace() + f64::MIN_POSITIVE;
        let Some(factor) = (gram + SMatrix::identity() * damping).cholesky() else {
            return;
        };
        let pull = factor.solve(&SVector::from(wanted));
        for (j, &(lower, upper)) in ranges.iter().enumerate() {
            steps[j] = weights[j] * column(j).dot(&pull);
            let stuck = (q[j] <= lower && steps[j] < 0.0) || (q[j] >= upper && steps[j] > 0.0);
            if stuck || !steps[j].is_finite() {
                weights[j] = 0.0;
            }
        }
    }
    // Steps shrink together where one is too long, so that the direction stays.
    let parts = steps.iter().zip(ranges);
    let parts = parts.map(|(step, (lower, upper))| step.abs() / (upper - lower));
    let longest = parts.filter(|part| part.is_finite()).fold(0.0, f64::max);
    // A quarter of its range is the farthest a joint moves.
    let scale = if longest > 0.25 { 0.25 / longest } else { 1.0 };
    for ((q, step), &(lower, upper)) in q.iter_mut().zip(steps).zip(ranges) {
        if step.is_finite() {
            *q = (*q + scale * step).clamp(lower, upper);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dofs() -> Vec<Dof> {
        let dof = |joint: &str, prismatic, lower, upper| Dof {
            joint: joint.to_string(),
            prismatic,
            continuous: false,
            lower,
            upper,
            speed: 1.0,
        };
        vec![
            dof("knee", false, -1.0, 2.0),
            dof("lift", true, 0.0, 0.4),
            dof("hip", false, -1.0, 1.0),
        ]
    }

    fn parse(text: &str) -> Result<Limits, Error> {
        Limits::parse(text, "l.csv", &dofs())
    }

    #[test]
    fn units_are_those_of_the_header() {
        let text = "# a comment\njoint,lower_deg,upper_deg,lower_m,upper_m\nknee,-30,180,,\nlift,,,0.1,0.2\n";
        let limits = parse(text).unwrap();
        assert!((limits.ranges[0].0 + 30f64.to_radians()).abs() < 1e-15);
        assert_eq!(limits.ranges[0].1, 2.0);
        assert_eq!(limits.ranges[1], (0.1, 0.2));
        assert_eq!(limits.ranges[2], (-1.0, 1.0));
        assert_eq!(limits.notes.len(), 2, "{:?}", limits.notes);
        let text = "joint,lower_rad,upper_rad\nknee,-0.5,0.5\n";
        assert_eq!(parse(text).unwrap().ranges[0], (-0.5, 0.5));
    }

    #[test]
    fn ranges_of_joints_by_name_have_the_faults_of_a_file() {
        let limits = Limits::of_joints([("knee", (-0.5, 9.0)), ("lift", (0.1, 0.2))], &dofs());
        let ranges = [(-0.5, 2.0), (0.1, 0.2), (-1.0, 1.0)];
        assert_eq!(limits.unwrap().ranges, ranges);
        let cases = [
            ("kne", (0.0, 1.0), "no joint `kne`"),
            ("knee", (1.0, -1.0), "`knee`: lower 1 is above upper -1"),
            ("knee", (f64::NAN, 1.0), "`knee`: NaN to 1 is no range"),
            ("knee", (3.0, 4.0), "outside the URDF's"),
        ];
        for (joint, range, expected) in cases {
            let error = Limits::of_joints([(joint, range)], &dofs()).unwrap_err();
            assert!(error.to_string().contains(expected), "{error}");
        }
    }

    #[test]
    fn faults_name_file_line_and_joint() {
        let degrees = [
            ("kne,0,1", "l.csv:2: no joint `kne`"),
            ("#\nknee,2,1", "l.csv:3: joint `knee`: lower 2"),
            ("knee,NaN,1", "l.csv:2: joint `knee`: `NaN`"),
            ("knee,1", "l.csv:2: joint `knee`: ``"),
            ("knee,0,1\nknee,0,1", "l.csv:3: joint `knee` already"),
            ("lift,0,1", "lower_m,upper_m"),
            ("knee,170,175", "outside the URDF's"),
            ("", "no limits"),
        ];
        let line = |(rows, expected): (&str, &'static str)| {
            (format!("joint,lower_deg,upper_deg\n{rows}\n"), expected)
        };
        let other = [
            ("joint,lower,upper\nknee,0,1\n", "the header says the unit"),
            ("", "l.csv"),
        ];
        let other = other.map(|(text, expected)| (text.to_string(), expected));
        for (text, expected) in degrees.map(line).into_iter().chain(other) {
            let error = parse(&text).unwrap_err().to_string();
            assert!(error.contains(expected), "{text:?}: {error}");
        }
    }
}
