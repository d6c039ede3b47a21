//! CSV posture logs, streamed in blocks.
//!
//! Columns: `pose` (integer, optional), `t`, `support`, the joints by their
//! URDF names, then readings. Rows are checked as they are read; a fault names
//! file, line, column and remedy.

use std::collections::HashMap;
use std::fs::File;
use std::path::Path;

use csv::StringRecord;
use sesc_codegen::tree::Dof;

use super::sidecar::Angles;
use crate::Error;

/// Columns that are not joints but have a meaning.
const KNOWN: [&str; 7] = [
    "pose",
    "t",
    "support",
    "cop_x",
    "cop_y",
    "cop_x_std",
    "cop_y_std",
];

/// A turning joint further out than this was hardly logged in radians.
const FULL_TURN: f64 = 6.3;

/// One row of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Line in the file, from 1.
    pub line: u64,
    pub pose: i64,
    /// Link on the ground, where the log has a column for it.
    pub support: Option<String>,
}

/// A log being read.
pub struct PostureReader {
    file: String,
    reader: csv::Reader<File>,
    record: StringRecord,
    pose: Option<usize>,
    support: Option<usize>,
    /// Column of each joint, and its unit in rad or m.
    joints: Vec<(usize, f64)>,
    dofs: Vec<Dof>,
    next_pose: i64,
    /// Columns nobody asked for.
    pub ignored: Vec<String>,
}

impl PostureReader {
    /// Open `path` and match its header with the robot's joints.
    pub fn open(path: &Path, dofs: &[Dof], angles: Angles) -> Result<PostureReader, Error> {
        let name = path.display().to_string();
        let file = File::open(path).map_err(|source| Error::Read {
            file: name.clone(),
            source,
        })?;
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .from_reader(file);
        let header = match reader.headers() {
            Ok(header) => header.clone(),
            Err(error) => return Err(fault(&name, error)),
        };
        let bad = |message: String| Error::Log {
            file: name.clone(),
            line: Some(1),
            message,
        };
        if header.iter().all(str::is_empty) {
            return Err(bad(
                "no header row; a log starts with the names of its columns".into(),
            ));
        }
        let mut columns: HashMap<&str, usize> = HashMap::new();
        for (k, column) in header.iter().enumerate() {
            let column = column.trim_start_matches('\u{feff}');
            if columns.insert(column, k).is_some() {
                return Err(bad(format!("column `{column}` appears twice; remove one")));
            }
        }
        let missing: Vec<&str> = dofs
            .iter()
            .map(|dof| dof.joint.as_str())
            .filter(|joint| !columns.contains_key(joint))
            .collect();
        if !missing.is_empty() {
            return Err(bad(format!(
                "no column for joint {}; columns carry the URDF's joint names",
                list(&missing)
            )));
        }
        let scale = |dof: &Dof| match angles {
            Angles::Deg if !dof.prismatic => std::f64::consts::PI / 180.0,
            _ => 1.0,
        };
        let joints = dofs
            .iter()
            .map(|dof| (columns[dof.joint.as_str()], scale(dof)))
            .collect();
        let known = |column: &str| {
            KNOWN.contains(&column)
                || column.starts_with("fsr_")
                || dofs.iter().any(|dof| dof.joint == column)
        };
        let ignored = header
            .iter()
            .map(|column| column.trim_start_matches('\u{feff}'))
            .filter(|column| !known(column))
            .map(str::to_string)
            .collect();
        Ok(PostureReader {
            pose: columns.get("pose").copied(),
            support: columns.get("support").copied(),
            joints,
            dofs: dofs.to_vec(),
            record: StringRecord::new(),
            next_pose: 0,
            ignored,
            reader,
            file: name,
        })
    }

    /// Read up to `count` rows: their descriptions, and `q` row by row, rad or m.
    pub fn block(&mut self, count: usize) -> Result<(Vec<Row>, Vec<f64>), Error> {
        let mut rows = Vec::new();
        let mut q = Vec::new();
        while rows.len() < count {
            match self.reader.read_record(&mut self.record) {
                Ok(true) => {}
                Ok(false) => break,
                Err(error) => return Err(fault(&self.file, error)),
            }
            let line = self.record.position().map_or(0, csv::Position::line);
            rows.push(self.row(line, &mut q)?);
        }
        Ok((rows, q))
    }

    fn row(&mut self, line: u64, q: &mut Vec<f64>) -> Result<Row, Error> {
        let bad = |message: String| Error::Log {
            file: self.file.clone(),
            line: Some(line),
            message,
        };
        let pose = match self.pose {
            None => self.next_pose,
            Some(k) => self.record[k].parse().map_err(|_| {
                bad(format!(
                    "column `pose`: `{}` is no whole number",
                    &self.record[k]
                ))
            })?,
        };
        self.next_pose = pose.saturating_add(1);
        for (&(k, scale), dof) in self.joints.iter().zip(&self.dofs) {
            let (joint, text) = (&dof.joint, &self.record[k]);
            let value: f64 = text
                .parse()
                .map_err(|_| bad(format!("column `{joint}`: `{text}` is no number")))?;
            if !value.is_finite() {
                return Err(bad(format!(
                    "column `{joint}`: `{text}` is not finite; remove the row or mend the value"
                )));
            }
            let value = value * scale;
            let reach = FULL_TURN.max(dof.lower.abs()).max(dof.upper.abs());
            if !dof.prismatic && !dof.continuous && value.abs() > reach {
                return Err(bad(format!(
                    "column `{joint}`: {value} rad is more than a full turn; \
                     if the log is in degrees, pass --degrees or put `angles = \"deg\"` in its sidecar"
                )));
            }
            q.push(value);
        }
        Ok(Row {
            line,
            pose,
            support: self.support.map(|k| self.record[k].to_string()),
        })
    }
}

/// A fault that the CSV reader found.
fn fault(file: &str, error: csv::Error) -> Error {
    let line = error.position().map(csv::Position::line);
    let message = match error.kind() {
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => format!(
            "{len} fields where the header has {expected_len}; the row is ragged or cut off"
        ),
        csv::ErrorKind::Utf8 { .. } => "not text; is this a CSV file?".to_string(),
        _ => error.to_string(),
    };
    Error::Log {
        file: file.to_string(),
        line,
        message,
    }
}

/// Names for a message, a dozen at most.
fn list(names: &[&str]) -> String {
    let shown: Vec<String> = names
        .iter()
        .take(12)
        .map(|name| format!("`{name}`"))
        .collect();
    let more = names.len() - shown.len();
    match more {
        0 => shown.join(", "),
        _ => format!("{} and {more} more", shown.join(", ")),
    }
}
