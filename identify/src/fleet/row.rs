//! The row of one robot on one day, and the table of all rows.
//!
//! The table is Parquet that pandas, Polars, DuckDB and Spark read, or CSV; the same rows give the
//! same bytes. Memory holds one group of rows.
//!
//! Lists are lists in Parquet and JSON texts in CSV; `effects` and `health` are JSON texts in
//! both.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::Path;

use nalgebra::DMatrix;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;
use sesc_model::effects::Fitted;

use crate::Error;
use crate::diagnose::{Quantity, Report, Score, Step, Verdict};
use crate::files::{self, NewFile};
use crate::fit::Identification;
use crate::health::{Finding, Kind};

/// What a parameter is where there is no effect.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Absent {
    /// Most are 0.
    #[default]
    Zero,
    /// A factor is 1.
    One,
    /// A stiffness is infinite.
    Infinite,
}

impl Absent {
    fn of(fitted: Fitted) -> Absent {
        match fitted {
            Fitted::LessOne => Absent::One,
            Fitted::WeightOver => Absent::Infinite,
            _ => Absent::Zero,
        }
    }

    /// How far from there a size is: a factor less one, the inverse of a stiffness.
    pub(super) fn away(self, size: Quantity) -> Quantity {
        self.moved(size, -1.0)
    }

    /// The size that is so far from there.
    pub(super) fn back(self, away: Quantity) -> Quantity {
        self.moved(away, 1.0)
    }

    fn moved(self, Quantity { value, std }: Quantity, by: f64) -> Quantity {
        let (value, std) = match self {
            Absent::Zero => (value, std),
            Absent::One => (value + by, std),
            Absent::Infinite => (1.0 / value, std / (value * value)),
        };
        Quantity { value, std }
    }
}

/// One effect of a row's explanation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct EffectFound {
    /// Name of the effect: `joint_offset`.
    pub effect: String,
    /// Joint, link or cell; `-` for the whole.
    pub target: String,
    /// Its parameters by name, which ends in the unit: `offset_rad`.
    pub parameters: BTreeMap<String, Quantity>,
    /// What those of them are without the effect that are not 0 then: `scale` is `one`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub absent: BTreeMap<String, Absent>,
    /// Rise of −2 log evidence without this effect.
    pub evidence: f64,
}

/// What a diagnosis says of effects.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct Effects {
    /// Those of the explanation.
    pub explanation: Vec<EffectFound>,
    /// The complete explanations that these data allow instead, effects with their targets.
    pub instead: Vec<Vec<String>>,
    /// Every effect as the whole explanation, the best first, at most [`SCORES`].
    pub scores: Vec<EffectFound>,
}

/// Most effects of a row that are fitted alone.
pub const SCORES: usize = 64;

impl EffectFound {
    fn of(
        (effect, target): (&str, &str),
        parameters: &BTreeMap<&'static str, Quantity>,
        fitted: &BTreeMap<&'static str, Fitted>,
        evidence: f64,
    ) -> EffectFound {
        let size = |(name, size): (&&str, &Quantity)| (name.to_string(), *size);
        let absent = |(name, fitted): (&&str, &Fitted)| {
            let absent = Absent::of(*fitted);
            (absent != Absent::Zero).then(|| (name.to_string(), absent))
        };
        EffectFound {
            effect: effect.to_string(),
            target: target.to_string(),
            parameters: parameters.iter().map(size).collect(),
            absent: fitted.iter().filter_map(absent).collect(),
            evidence,
        }
    }

    /// The same, no parameter better known than this fall of χ² tells it from no effect: where a
    /// search for a size ends at its bounds, slopes there say nothing of it.
    fn known_by(mut self, chi2: f64) -> EffectFound {
        for (name, size) in &mut self.parameters {
            let absent = self.absent.get(name).copied().unwrap_or_default();
            let away = absent.away(*size);
            let claimed = (away.value / away.std).abs();
            size.std *= (claimed / chi2.max(0.0).sqrt()).max(1.0);
        }
        self
    }

    /// What a parameter is without the effect.
    pub(super) fn absent(&self, parameter: &str) -> Absent {
        self.absent.get(parameter).copied().unwrap_or_default()
    }

    /// How far a parameter is from what it is without the effect.
    pub(super) fn away(&self, parameter: &str) -> Option<Quantity> {
        let size = self.parameters.get(parameter)?;
        Some(self.absent(parameter).away(*size))
    }
}

/// The order of robots and days: runs of digits by their number, all else as text, so that
/// `day=9` is before `day=10`, and dates such as `2031-05-01` stay in their order.
pub(super) fn by_number(a: &str, b: &str) -> Ordering {
    // A number is its digits without leading zeros, of which more are more.
    fn run(run: &[u8]) -> (u8, usize, &[u8]) {
        let zeros = run.iter().take_while(|digit| **digit == b'0').count();
        match run[0] {
            b'0'..=b'9' => (b'0', run.len() - zeros, &run[zeros..]),
            other => (other, 0, &[]),
        }
    }
    let is_number = |x: &u8, y: &u8| x.is_ascii_digit() && y.is_ascii_digit();
    let [a_runs, b_runs] = [a, b].map(|text| text.as_bytes().chunk_by(is_number).map(run));
    // The same but for leading zeros are told apart by how they are written.
    a_runs.cmp(b_runs).then_with(|| a.cmp(b))
}

/// One row of the fleet's table: a robot on a day.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Row {
    /// The robot.
    pub robot: String,
    /// The day, or the week.
    pub day: String,
    /// Hash of the URDF, in hexadecimal.
    pub urdf_hash: String,
    /// Link on the ground; empty where nothing says it.
    pub support: String,
    /// Postures of the logs.
    pub postures: u64,
    /// Independent rows that they are worth.
    pub independent: u64,
    /// Noise of a posture on one axis, m.
    pub noise_floor: Option<f64>,
    /// Held-out RMS error of the whole explanation, m.
    pub held_out_rmse: Option<f64>,
    /// Verdict of the diagnosis, where there is one; in files its name, or empty.
    #[serde(
        serialize_with = "verdict_to_name",
        deserialize_with = "verdict_of_name"
    )]
    pub verdict: Option<Verdict>,
    /// The diagnosis in sentences.
    pub sentence: String,
    /// What the diagnosis says of effects.
    pub effects: Effects,
    /// What is wrong with the data themselves.
    pub health: Vec<Finding>,
    /// Base parameters as fitted without effects, m, in the model's order; empty where the
    /// fit failed.
    pub params: Vec<f64>,
    /// Their standard deviations; none where data and prior say nothing.
    pub std: Vec<Option<f64>>,
    /// Hashes of the logs' contents, sorted.
    pub inputs: Vec<String>,
    /// What went wrong with a log or a call.
    pub error: Option<String>,
    /// Version of this library.
    pub version: String,
    /// Names of the parameters; no column of the table.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<String>,
    /// Covariance of the parameters, m², lower triangle row by row; kept with a diagnosis, and
    /// where [`Options::information`](super::Options::information) asks for it; no column of
    /// the table.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub covariance: Vec<f64>,
}

/// What the sentence of a row says that was fitted alone.
const FITTED: &str = "Parameters alone were asked for: no diagnosis was made.";

/// What the sentence of a row says beside a stuck encoder.
const STUCK: &str = "No effect is named beside it: what explains angles that are wrong is not the \
                     robot's. A diagnosis of the log alone says what it looks like.";

impl Row {
    /// Whether numbers are such as data give: finite, of lists that belong together, deviations
    /// not negative. A file may hold others.
    pub(super) fn is_whole(&self) -> bool {
        // In any unit nothing is as large.
        let is_sound = |x: &f64| x.abs() < 1e100;
        let is_deviation = |x: &f64| (0.0..1e100).contains(x);
        let effects = self.effects.explanation.iter().chain(&self.effects.scores);
        let mut sizes = effects.clone().flat_map(|found| found.parameters.values());
        let n = self.params.len();
        let values = self.params.iter().chain(&self.covariance);
        let mut values = values.chain(effects.map(|found| &found.evidence));
        let floors = [&self.noise_floor, &self.held_out_rmse];
        let mut deviations = self.std.iter().chain(floors).flatten();
        self.std.len() == n
            && (self.covariance.is_empty() || self.covariance.len() == n * (n + 1) / 2)
            && values.all(is_sound)
            && deviations.all(is_deviation)
            && sizes.all(|size| is_sound(&size.value) && is_deviation(&size.std))
    }

    /// The order of rows by robot and day.
    pub(super) fn order(&self, other: &Row) -> Ordering {
        let day = || by_number(&self.day, &other.day);
        by_number(&self.robot, &other.robot).then_with(day)
    }

    /// Whether the row says something of the robot.
    pub fn is_usable(&self) -> bool {
        self.has_result() && self.verdict != Some(Verdict::Unusable)
    }

    /// Whether the logs could be read and something came of them.
    pub fn has_result(&self) -> bool {
        self.verdict.is_some() || !self.params.is_empty()
    }

    /// Covariance of the parameters, m²; none where it was not kept.
    pub(super) fn covariance(&self) -> Option<DMatrix<f64>> {
        let n = self.params.len();
        let at = |i: usize, j: usize| self.covariance[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];
        let is_whole = n > 0 && self.covariance.len() == n * (n + 1) / 2;
        is_whole.then(|| DMatrix::from_fn(n, n, at))
    }

    /// Say what went wrong, if anything did.
    pub(super) fn set_errors(&mut self, mut errors: Vec<String>) {
        // What is wrong with an option is wrong for every log.
        let mut said = BTreeSet::new();
        errors.retain(|error| said.insert(error.clone()));
        self.error = (!errors.is_empty()).then(|| errors.join("; "));
    }

    /// Take over what a fit or a diagnosis says of the data: postures, independent rows, noise and
    /// held-out error.
    fn set_data(&mut self, postures: u64, rows: usize, errors: [f64; 2], health: &[Finding]) {
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        (self.postures, self.independent) = (postures, rows as u64);
        [self.noise_floor, self.held_out_rmse] = errors.map(finite);
        // Pictures belong to a diagnosis' own page and are not kept.
        let plain = |f: &Finding| Finding::new(f.kind, &f.target, f.sentence.clone());
        self.health = health.iter().map(plain).collect();
    }

    /// Take over findings of single logs that are not told yet.
    pub(super) fn add_findings(&mut self, mut findings: Vec<Finding>) {
        findings.retain(|own| {
            let is_it = |told: &Finding| (told.kind, &told.target) == (own.kind, &own.target);
            !self.health.iter().any(is_it)
        });
        self.health.append(&mut findings);
    }

    fn stuck_encoder(&self) -> Option<&Finding> {
        self.health.iter().find(|f| f.kind == Kind::EncoderStuck)
    }

    /// Take over what a fit says of the data, where there is no diagnosis.
    pub(super) fn fitted(&mut self, found: &Identification) {
        let (postures, errors) = (found.postures, [found.noise_floor, found.held_out_rmse]);
        self.set_data(postures, found.samples.independent, errors, &found.health);
        self.sentence = FITTED.to_string();
        if !found.is_usable() || self.stuck_encoder().is_some() {
            self.verdict = Some(Verdict::Unusable);
        }
    }

    /// Take over what a diagnosis says.
    pub(super) fn diagnosed(&mut self, report: &Report) {
        let found = &report.diagnosis;
        let (postures, errors) = (found.postures as u64, [found.noise_floor, found.last.rmse]);
        self.set_data(postures, found.samples.independent, errors, &found.health);
        self.support.clone_from(&found.support);
        if let Some(finding) = self.stuck_encoder() {
            // One joint is not where the log says: whatever explains the rest makes up for it.
            self.sentence = format!("{} {STUCK}", finding.sentence);
            self.verdict = Some(Verdict::Unusable);
            return;
        }
        self.verdict = Some(found.verdict);
        self.sentence.clone_from(&found.sentence);
        let of = EffectFound::of;
        let step = |s: &Step| of((s.effect, &s.target), &s.parameters, &s.fitted, s.evidence);
        let score = |s: &Score| {
            let found = of((s.effect, &s.target), &s.parameters, &s.fitted, s.evidence);
            found.known_by(s.chi2)
        };
        // What a log says nothing of has no size.
        let is_known = |found: &EffectFound| {
            let mut sizes = found.parameters.values();
            sizes.all(|size| size.value.is_finite() && size.std.is_finite())
        };
        let others = found.indistinguishable.iter().skip(1);
        self.effects = Effects {
            explanation: found.steps.iter().map(step).collect(),
            instead: others.cloned().collect(),
            scores: report.scores.iter().map(score).filter(is_known).collect(),
        };
    }
}

/// Whether nothing is said of a robot by data with this finding: where an encoder is stuck,
/// whatever explains the rest makes up for a joint that is not where the log says.
pub(super) fn is_spoiling(finding: &Finding) -> bool {
    finding.kind == Kind::EncoderStuck || finding.kind.makes_unusable()
}

fn verdict_to_name<S: Serializer>(
    verdict: &Option<Verdict>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(verdict.map_or("", Verdict::name))
}

fn verdict_of_name<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<Verdict>, D::Error> {
    let name = String::deserialize(deserializer)?;
    let verdict = (!name.is_empty()).then(|| serde_json::from_value(Value::from(&*name)));
    let unknown = |_| D::Error::custom(format!("`{name}` is no verdict"));
    verdict.transpose().map_err(unknown)
}

/// The columns, in their order.
pub const COLUMNS: [&str; 17] = [
    "robot",
    "day",
    "urdf_hash",
    "support",
    "postures",
    "independent",
    "noise_floor",
    "held_out_rmse",
    "verdict",
    "sentence",
    "effects",
    "health",
    "params",
    "std",
    "inputs",
    "error",
    "version",
];

/// A row's values in the order of [`COLUMNS`]: lists, numbers and texts, `effects` and `health` as
/// JSON texts.
#[must_use]
pub fn cells(row: &Row) -> [Value; COLUMNS.len()] {
    let mut all = serde_json::to_value(row).unwrap_or_default();
    let text = |list: serde_json::Result<String>| list.unwrap_or_default().into();
    COLUMNS.map(|column| match column {
        "effects" => text(serde_json::to_string(&row.effects)),
        "health" => text(serde_json::to_string(&row.health)),
        _ => all[column].take(),
    })
}

/// The rows sorted by robot and day, URDF and support; a robot that has several URDFs is told so
/// in a sentence of its rows.
pub(super) fn assembled(mut rows: Vec<Row>) -> Vec<Row> {
    rows.sort_by(|a, b| {
        let model = (&a.urdf_hash, &a.support).cmp(&(&b.urdf_hash, &b.support));
        a.order(b).then(model)
    });
    for days in rows.chunk_by_mut(|a, b| a.robot == b.robot) {
        let hashes = days.iter().map(|row| row.urdf_hash.clone());
        let urdfs: BTreeSet<String> = hashes.filter(|hash| !hash.is_empty()).collect();
        for row in days.iter_mut().filter(|_| urdfs.len() > 1) {
            let space = if row.sentence.is_empty() { "" } else { " " };
            row.sentence += &format!(
                "{space}This robot has {} URDFs among its days; this row is of URDF {}, and rows \
                 of different URDFs are not compared.",
                urdfs.len(),
                row.urdf_hash
            );
        }
    }
    rows
}

/// Whether a table can be written under this name, before long work.
///
/// # Errors
/// When its end is neither `.parquet` nor `.csv`, or this build has no Parquet.
pub fn check_table(path: &Path) -> Result<(), Error> {
    let file = path.display();
    match path.extension().and_then(|end| end.to_str()) {
        Some("csv") => Ok(()),
        #[cfg(feature = "parquet")]
        Some("parquet") => Ok(()),
        #[cfg(not(feature = "parquet"))]
        Some("parquet") => Err(Error::without("parquet", "Parquet", &file.to_string())),
        _ => Err(Error::request(format!(
            "{file}: the fleet's table is written as .parquet or .csv"
        ))),
    }
}

/// Write the table, as the end of its name says. It appears whole or not at all.
///
/// # Errors
/// As [`check_table`], and when the file cannot be written.
pub fn write(path: &Path, rows: &[Row]) -> Result<(), Error> {
    check_table(path)?;
    #[cfg(feature = "parquet")]
    if path.extension().is_some_and(|end| end == "parquet") {
        return parquet::write(path, rows);
    }
    let failed = |error: csv::Error| files::failed(path, io::Error::other(error));
    let mut writer = csv::Writer::from_writer(NewFile::create(path)?);
    writer.write_record(COLUMNS).map_err(failed)?;
    for row in rows {
        let record = cells(row).map(|cell| match cell {
            Value::Null => String::new(),
            Value::String(text) => text,
            // Without an exponent, as numbers of CSV logs.
            Value::Number(x) if x.is_f64() => x.as_f64().unwrap_or(f64::NAN).to_string(),
            other => other.to_string(),
        });
        writer.write_record(record).map_err(failed)?;
    }
    let file = writer.into_inner();
    let file = file.map_err(|error| files::failed(path, io::Error::other(error.to_string())))?;
    Ok(file.finish()?)
}

#[cfg(feature = "parquet")]
mod parquet {
    use std::sync::Arc;

    use ::parquet::basic::Compression;
    use ::parquet::column::writer::ColumnWriter;
    use ::parquet::data_type::ByteArray;
    use ::parquet::errors::ParquetError;
    use ::parquet::file::properties::WriterProperties;
    use ::parquet::file::writer::SerializedFileWriter;
    use ::parquet::schema::parser::parse_message_type;
    use ::parquet::schema::types::ColumnDescriptor;

    use super::*;

    /// Rows of a group.
    const GROUP: usize = 10_000;

    fn schema() -> String {
        let list = |name: &str, element: &str| {
            format!("REQUIRED GROUP {name} (LIST) {{ REPEATED GROUP list {{ {element}; }} }}")
        };
        let columns = COLUMNS.map(|name| match name {
            "postures" | "independent" => format!("REQUIRED INT64 {name};"),
            "noise_floor" | "held_out_rmse" => format!("OPTIONAL DOUBLE {name};"),
            "params" | "std" => list(name, "OPTIONAL DOUBLE element"),
            "inputs" => list(name, "REQUIRED BYTE_ARRAY element (UTF8)"),
            "error" => format!("OPTIONAL BYTE_ARRAY {name} (UTF8);"),
            _ => format!("REQUIRED BYTE_ARRAY {name} (UTF8);"),
        });
        format!("message fleet {{ {} }}", columns.concat())
    }

    pub(super) fn write(path: &Path, rows: &[Row]) -> Result<(), Error> {
        let file = filled(NewFile::create(path)?, rows);
        let unwritten = |error| files::failed(path, io::Error::other(error));
        Ok(file.map_err(unwritten)?.finish()?)
    }

    fn filled(file: NewFile, rows: &[Row]) -> Result<NewFile, ParquetError> {
        let schema = parse_message_type(&schema())?;
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .build();
        let mut writer = SerializedFileWriter::new(file, Arc::new(schema), properties.into())?;
        let columns = writer.schema_descr().columns().to_vec();
        for rows in rows.chunks(GROUP) {
            let rows: Vec<_> = rows.iter().map(cells).collect();
            let mut group = writer.next_row_group()?;
            for (at, about) in columns.iter().enumerate() {
                if let Some(mut column) = group.next_column()? {
                    fill(column.untyped(), about, rows.iter().map(|row| &row[at]))?;
                    column.close()?;
                }
            }
            group.close()?;
        }
        writer.into_inner()
    }

    /// Write the cells of a column: of a list, each element and which of them begins it.
    fn fill<'r>(
        column: &mut ColumnWriter,
        about: &ColumnDescriptor,
        cells: impl Iterator<Item = &'r Value>,
    ) -> Result<(), ParquetError> {
        let (mut values, mut defined, mut repeated) = (Vec::new(), Vec::new(), Vec::new());
        for cell in cells {
            let list = match cell {
                Value::Array(list) => list.as_slice(),
                value => std::slice::from_ref(value),
            };
            if list.is_empty() {
                defined.push(0);
                repeated.push(0);
            }
            for (k, value) in list.iter().enumerate() {
                defined.push(about.max_def_level() - i16::from(value.is_null()));
                repeated.push(i16::from(k > 0));
                values.extend((!value.is_null()).then_some(value));
            }
        }
        let defined = (about.max_def_level() > 0).then_some(defined.as_slice());
        let repeated = (about.max_rep_level() > 0).then_some(repeated.as_slice());
        let values = values.into_iter();
        match column {
            ColumnWriter::ByteArrayColumnWriter(to) => {
                let texts = values.map(|text| text.as_str().unwrap_or_default().into());
                to.write_batch(&texts.collect::<Vec<ByteArray>>(), defined, repeated)?
            }
            ColumnWriter::DoubleColumnWriter(to) => {
                let numbers = values.map(|x| x.as_f64().unwrap_or(f64::NAN));
                to.write_batch(&numbers.collect::<Vec<f64>>(), defined, repeated)?
            }
            ColumnWriter::Int64ColumnWriter(to) => {
                let counts = values.map(|count| count.as_i64().unwrap_or(i64::MAX));
                to.write_batch(&counts.collect::<Vec<i64>>(), defined, repeated)?
            }
            _ => return Err(ParquetError::General("a column of another type".into())),
        };
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_in_the_order_of_their_numbers() {
        let of = |days: &[&str]| {
            let mut sorted = days.to_vec();
            sorted.sort_by(|a, b| by_number(a, b));
            sorted.join(" ")
        };
        assert_eq!(of(&["10", "9", "1", "12", "2"]), "1 2 9 10 12");
        let days = of(&["2031-05-10", "2030-12-31", "2031-05-09"]);
        assert_eq!(days, "2030-12-31 2031-05-09 2031-05-10");
        let weeks = of(&["week 10", "week 9b", "week 9"]);
        assert_eq!(weeks, "week 9 week 9b week 10");
        // Equal numbers are told apart by how they are written, whatever comes first.
        assert_eq!(of(&["01", "1", "001", ""]), of(&["1", "", "001", "01"]));
    }

    #[test]
    fn a_verdict_is_its_name_in_files_and_another_name_is_refused() {
        let mut row = Row::default();
        let names = [None, Some(Verdict::Absorbed)].map(|verdict| {
            row.verdict = verdict;
            let written = serde_json::to_value(&row).unwrap();
            let read: Row = serde_json::from_value(written.clone()).unwrap();
            assert_eq!(read, row);
            written["verdict"].clone()
        });
        assert_eq!(names, ["", "absorbed"]);
        let mut other = serde_json::to_value(&row).unwrap();
        other["verdict"] = "maybe".into();
        let said = serde_json::from_value::<Row>(other).unwrap_err();
        assert!(said.to_string().contains("`maybe` is no verdict"), "{said}");
    }

    #[cfg(feature = "parquet")]
    #[test]
    fn lists_and_missing_values_are_read_back() {
        use super::*;
        use ::parquet::file::reader::{FileReader as _, SerializedFileReader};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fleet.parquet");
        let full = Row {
            robot: "a".into(),
            postures: 60,
            noise_floor: Some(1e-4),
            params: vec![0.5, 0.25],
            std: vec![None, Some(0.125)],
            inputs: vec!["11".into(), "22".into()],
            ..Row::default()
        };
        let empty = Row {
            robot: "b".into(),
            error: Some("broken".into()),
            ..Row::default()
        };
        write(&path, &[full, empty]).unwrap();
        let reader = SerializedFileReader::new(std::fs::File::open(&path).unwrap()).unwrap();
        let rows = reader.get_row_iter(None).unwrap();
        let rows: Vec<String> = rows.map(|row| row.unwrap().to_string()).collect();
        for (row, words) in rows.iter().zip([
            "robot: \"a\"|postures: 60|[0.5, 0.25]|[null, 0.125]|[\"11\", \"22\"]|error: null",
            "robot: \"b\"|postures: 0|params: []|inputs: []|noise_floor: null|error: \"broken\"",
        ]) {
            for word in words.split('|') {
                assert!(row.contains(word), "{word}: {row}");
            }
        }
        assert_eq!(rows.len(), 2);
    }
}
