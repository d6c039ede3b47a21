//! Joint limits that postures keep: the URDF's, narrowed by a file.
//!
//! ```text
//! joint,lower_deg,upper_deg          or  lower_rad,upper_rad  and  lower_m,upper_m
//! l_knee,-130,6
//! ```
//!
//! The header names the units: turning joints in degrees or radians, sliding
//! ones in metres; a file may have several pairs of columns, a row fills one.
//! Lines that begin with `#` are comments.

use std::collections::HashMap;
use std::path::Path;

use sesc_model::tree::Dof;

use crate::Error;

/// A range per independent joint, and what was noticed.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// rad or m
    pub ranges: Vec<(f64, f64)>,
    pub notes: Vec<String>,
}

/// Files of limits are a page.
const LONGEST: u64 = 1 << 22;

/// A pair of columns: name of its unit, whether for slides, SI per unit.
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
        let failed = |source| Error::read(file.clone(), source);
        let about = std::fs::metadata(path).map_err(failed)?;
        if about.len() > LONGEST {
            return Err(fault(
                &file,
                None,
                "larger than 4 MiB; limits are a line per joint",
            ));
        }
        let bytes = std::fs::read(path).map_err(failed)?;
        let text = String::from_utf8(bytes).map_err(|_| {
            fault(
                &file,
                None,
                "is no UTF-8 text; give CSV with a line per joint",
            )
        })?;
        Limits::parse(&text, &file, dofs)
    }

    fn parse(text: &str, file: &str, dofs: &[Dof]) -> Result<Limits, Error> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        // Line by line: the numbers of lines count comments and blank ones too.
        let lines = text
            .lines()
            .enumerate()
            .map(|(k, line)| (k as u64 + 1, line.trim()));
        let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let (line, header) = lines.next().unwrap_or((1, ""));
        let header = fields(header);
        let columns = Columns::of(&header, file, line)?;
        let mut limits = Limits::of_urdf(dofs);
        let index: HashMap<&str, usize> = dofs
            .iter()
            .enumerate()
            .map(|(k, dof)| (dof.joint.trim(), k))
            .collect();
        let mut seen: HashMap<usize, u64> = HashMap::new();
        let mut wider = Vec::new();
        for (line, text) in lines {
            let record = fields(text);
            let bad = |message: String| fault(file, Some(line), &message);
            let name = record.get(columns.joint).unwrap_or("");
            let Some(&joint) = index.get(name) else {
                return Err(bad(unknown(name, dofs)));
            };
            if let Some(before) = seen.insert(joint, line) {
                return Err(bad(format!(
                    "joint `{name}` already has limits on line {before}; keep one line"
                )));
            }
            let (lower, upper) = columns.range(&record, &dofs[joint]).map_err(&bad)?;
            let dof = &dofs[joint];
            let kept = (lower.max(dof.lower), upper.min(dof.upper));
            if kept.0 > kept.1 {
                let (per, unit) = if dof.prismatic {
                    (1.0, "m")
                } else {
                    (UNITS[0].2, "°")
                };
                return Err(bad(format!(
                    "joint `{name}`: {:.4} to {:.4} {unit} lies outside the URDF's {:.4} to {:.4} {unit}; \
                     check sign and unit",
                    lower / per,
                    upper / per,
                    dof.lower / per,
                    dof.upper / per
                )));
            }
            if kept != (lower, upper) {
                wider.push(name.to_string());
            }
            limits.ranges[joint] = kept;
        }
        if seen.is_empty() {
            return Err(fault(file, None, "holds no limits; add a line per joint"));
        }
        limits.note(&wider, dofs.len() - seen.len(), file);
        Ok(limits)
    }

    fn note(&mut self, wider: &[String], missing: usize, file: &str) {
        if !wider.is_empty() {
            self.notes.push(format!(
                "{file} reaches beyond the URDF for {}; the URDF's limits hold there",
                wider.join(", ")
            ));
        }
        if missing > 0 {
            self.notes.push(format!(
                "{file} says nothing of {missing} joints: URDF limits"
            ));
        }
    }

    /// The posture within the limits that is closest to zero.
    pub fn rest(&self) -> Vec<f64> {
        self.ranges
            .iter()
            .map(|&(lower, upper)| 0f64.clamp(lower, upper))
            .collect()
    }
}

/// Where things are in a row.
struct Columns {
    joint: usize,
    /// For each of [`UNITS`]: lower and upper.
    pairs: [Option<(usize, usize)>; 3],
}

impl Columns {
    fn of(header: &csv::StringRecord, file: &str, line: u64) -> Result<Columns, Error> {
        let at = |name: &str| header.iter().position(|h| h.eq_ignore_ascii_case(name));
        let pairs = UNITS.map(|(unit, _, _)| {
            Some((at(&format!("lower_{unit}"))?, at(&format!("upper_{unit}"))?))
        });
        match at("joint").filter(|_| pairs.iter().any(Option::is_some)) {
            Some(joint) => Ok(Columns { joint, pairs }),
            None => Err(fault(
                file,
                Some(line),
                "no header `joint,lower_deg,upper_deg` (or lower_rad,upper_rad; lower_m,upper_m \
                 for sliding joints); the header says the unit",
            )),
        }
    }

    /// Lower and upper limit of a row, SI.
    fn range(&self, row: &csv::StringRecord, dof: &Dof) -> Result<(f64, f64), String> {
        let name = &dof.joint;
        let mut found = None;
        for (pair, (unit, slides, si)) in self.pairs.iter().zip(UNITS) {
            let Some((lower, upper)) = *pair else {
                continue;
            };
            let cells = [lower, upper].map(|k| row.get(k).unwrap_or(""));
            if cells.iter().all(|cell| cell.is_empty()) {
                continue;
            }
            if slides != dof.prismatic {
                let (is, right) = match dof.prismatic {
                    true => ("slides", "lower_m,upper_m"),
                    false => ("turns", "lower_deg,upper_deg or lower_rad,upper_rad"),
                };
                return Err(format!(
                    "joint `{name}` {is}, its limits are in {unit}; use columns {right}"
                ));
            }
            if found.is_some() {
                return Err(format!("joint `{name}` has limits in two units; keep one"));
            }
            let mut values = [0.0; 2];
            for (value, cell) in values.iter_mut().zip(cells) {
                *value = cell
                    .parse()
                    .ok()
                    .filter(|x: &f64| x.is_finite())
                    .ok_or_else(|| {
                        format!("joint `{name}`: `{cell}` is no number; give both limits in {unit}")
                    })?;
            }
            let [lower, upper] = values;
            if lower > upper {
                return Err(format!(
                    "joint `{name}`: lower {lower} is above upper {upper}; swap them"
                ));
            }
            found = Some((si * lower, si * upper));
        }
        found.ok_or_else(|| format!("joint `{name}` has no limits on its line; give both"))
    }
}

/// The cells of a line.
fn fields(line: &str) -> csv::StringRecord {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .trim(csv::Trim::All)
        .from_reader(line.as_bytes());
    let first = reader.records().next();
    first.and_then(Result::ok).unwrap_or_default()
}

fn unknown(name: &str, dofs: &[Dof]) -> String {
    let near = dofs
        .iter()
        .map(|dof| {
            (
                strsim::damerau_levenshtein(name, &dof.joint),
                dof.joint.as_str(),
            )
        })
        .min()
        .filter(|(distance, _)| *distance <= 3);
    match near {
        Some((_, near)) => format!("no joint `{name}` moves by itself; did you mean `{near}`?"),
        None => {
            let some: Vec<&str> = dofs.iter().take(12).map(|dof| dof.joint.as_str()).collect();
            let more = if dofs.len() > some.len() { ", …" } else { "" };
            format!(
                "no joint `{name}` moves by itself; those that do: {}{more}",
                some.join(", ")
            )
        }
    }
}

fn fault(file: &str, line: Option<u64>, message: &str) -> Error {
    Error::log(file.to_string(), line, message.to_string())
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
        };
        vec![
            dof("knee", false, -1.0, 2.0),
            dof("lift", true, 0.0, 0.4),
            dof("hip", false, -1.0, 1.0),
        ]
    }

    #[test]
    fn units_are_those_of_the_header() {
        let text = "# a comment\njoint,lower_deg,upper_deg,lower_m,upper_m\nknee,-30,180,,\nlift,,,0.1,0.2\n";
        let limits = Limits::parse(text, "l.csv", &dofs()).unwrap();
        assert!((limits.ranges[0].0 + 30f64.to_radians()).abs() < 1e-15);
        assert_eq!(limits.ranges[0].1, 2.0);
        assert_eq!(limits.ranges[1], (0.1, 0.2));
        assert_eq!(limits.ranges[2], (-1.0, 1.0));
        assert_eq!(limits.notes.len(), 2, "{:?}", limits.notes);
        let text = "joint,lower_rad,upper_rad\nknee,-0.5,0.5\n";
        assert_eq!(
            Limits::parse(text, "l.csv", &dofs()).unwrap().ranges[0],
            (-0.5, 0.5)
        );
    }

    #[test]
    fn faults_name_file_line_and_joint() {
        let cases = [
            (
                "joint,lower_deg,upper_deg\nkne,0,1\n",
                "l.csv:2: no joint `kne`",
            ),
            (
                "joint,lower_deg,upper_deg\n#\nknee,2,1\n",
                "l.csv:3: joint `knee`: lower 2",
            ),
            (
                "joint,lower_deg,upper_deg\nknee,NaN,1\n",
                "l.csv:2: joint `knee`: `NaN`",
            ),
            (
                "joint,lower_deg,upper_deg\nknee,1\n",
                "l.csv:2: joint `knee`: ``",
            ),
            (
                "joint,lower_deg,upper_deg\nknee,0,1\nknee,0,1\n",
                "l.csv:3: joint `knee` already",
            ),
            ("joint,lower_deg,upper_deg\nlift,0,1\n", "lower_m,upper_m"),
            (
                "joint,lower_deg,upper_deg\nknee,170,175\n",
                "outside the URDF's",
            ),
            ("joint,lower,upper\nknee,0,1\n", "the header says the unit"),
            ("joint,lower_deg,upper_deg\n", "no limits"),
            ("", "l.csv"),
        ];
        for (text, expected) in cases {
            let error = Limits::parse(text, "l.csv", &dofs())
                .unwrap_err()
                .to_string();
            assert!(error.contains(expected), "{text:?}: {error}");
        }
    }
}
