//! Writing logs and recordings: the one place where the order of their columns is set.
//!
//! The end of the file's name tells the format: `.csv`, `.csv.gz` or
//! `.parquet`. Log and sidecar appear whole or not at all.
//!
//! Postures with points of the sole plane, in time, become a recording of ROS 2 that viewers show:
//!
//! ```text
//! posture k ─▶ JointState at t_k, and a point or a vector (x, y, 0) of each track at t_k
//! ```
//!
//! Its stamps are whole nanoseconds from 0 to 2^31 s. Times that reach beyond begin at zero.

use std::io::Write;
use std::path::{Path, PathBuf};

use sesc_model::tree::Dof;

use super::columns::{COP, COP_STD, Field, POSE, Row, SUPPORT, T, Written, check_joints, fields};
use super::settings::Sidecar;
use crate::Error;
use crate::files::{self, NewFile};

/// A log being written.
pub struct PostureWriter {
    path: PathBuf,
    columns: Written,
    sink: Sink,
    /// The row being put together.
    text: Vec<u8>,
}

/// Where rows go, in the format that it was begun in.
enum Sink {
    Plain(NewFile),
    /// CSV on a stream, which nobody renames.
    Stream(Box<dyn Write + Send>),
    Packed(flate2::write::GzEncoder<NewFile>),
    #[cfg(feature = "parquet")]
    Parquet(super::parquet::ParquetSink),
}

impl PostureWriter {
    /// Start a log of `dofs`; nothing is at `path` before [`finish`](Self::finish).
    ///
    /// # Errors
    ///
    /// Joints whose names a log cannot carry, ends of names that stand for
    /// something else, folders that cannot be written to.
    pub fn create(path: &Path, dofs: &[Dof], columns: Written) -> Result<PostureWriter, Error> {
        check_joints(dofs).map_err(Error::request)?;
        let header = header(dofs, columns);
        let sink = Sink::create(path, &header)?;
        Ok(PostureWriter::into_sink(path, columns, sink))
    }

    /// Start a log of `dofs` as CSV on a stream; `name` stands for it in messages.
    ///
    /// # Errors
    ///
    /// Joints whose names a log cannot carry, a stream that takes nothing.
    pub fn stream(
        name: &str,
        to: impl Write + Send + 'static,
        dofs: &[Dof],
        columns: Written,
    ) -> Result<PostureWriter, Error> {
        check_joints(dofs).map_err(Error::request)?;
        let path = Path::new(name);
        let mut sink = Sink::Stream(Box::new(to));
        sink.begin(path, &header(dofs, columns))?;
        Ok(PostureWriter::into_sink(path, columns, sink))
    }

    fn into_sink(path: &Path, columns: Written, sink: Sink) -> PostureWriter {
        PostureWriter {
            path: path.to_path_buf(),
            columns,
            sink,
            text: Vec::new(),
        }
    }

    /// Append a row.
    pub fn row(&mut self, row: &Row) -> Result<(), Error> {
        #[cfg(feature = "parquet")]
        if let Sink::Parquet(sink) = &mut self.sink {
            return sink.row(row, self.columns);
        }
        self.text.clear();
        let failed = |source| files::failed(&self.path, source);
        line(&mut self.text, row, self.columns).map_err(failed)?;
        Ok(self.sink.write(&self.text).map_err(failed)?)
    }

    /// Complete the log and write its sidecar, whose path is given back; a log on a stream has
    /// none.
    pub fn finish(self, sidecar: &Sidecar) -> Result<Option<PathBuf>, Error> {
        let text = toml::to_string(sidecar).map_err(Error::serialise)?;
        let Some(log) = self.sink.finish(&self.path)? else {
            return Ok(None);
        };
        let path = Sidecar::path(&self.path);
        // The sidecar first: a log is never there without what it means.
        files::finish_together(vec![files::begun(&path, &text)?, log])?;
        Ok(Some(path))
    }
}

impl Sink {
    /// Start a table with the columns `header`, of which `support` alone has text.
    ///
    /// # Errors
    /// Ends of names that stand for something else, folders that cannot be written to.
    fn create(path: &Path, header: &[String]) -> Result<Sink, Error> {
        let end = path.extension().and_then(|end| end.to_str()).unwrap_or("");
        let name = path.display();
        let wrong = |said: &str| Err(Error::request(format!("{name}{said}")));
        let mut sink = match end.to_ascii_lowercase().as_str() {
            "toml" => return wrong(" ends in .toml, which is the sidecar's; use .csv"),
            "mcap" => return wrong(": MCAP is only read; write .csv, .csv.gz or .parquet"),
            "gz" => Sink::Packed(flate2::write::GzEncoder::new(
                NewFile::create(path)?,
                // Digits hardly pack better for ten times the time.
                flate2::Compression::fast(),
            )),
            #[cfg(feature = "parquet")]
            "parquet" => {
                return super::parquet::ParquetSink::create(path, header).map(Sink::Parquet);
            }
            #[cfg(not(feature = "parquet"))]
            "parquet" => return Err(Error::without("parquet", "Parquet", &name.to_string())),
            "csv" | "" => Sink::Plain(NewFile::create(path)?),
            // A device or a pipe has no format in its name.
            _ if path.starts_with("/dev") => Sink::Plain(NewFile::create(path)?),
            other => {
                return wrong(&format!(
                    ": posture logs are written as .csv, .csv.gz or .parquet, not as .{other}"
                ));
            }
        };
        sink.begin(path, header)?;
        Ok(sink)
    }

    /// Write the names of the columns.
    fn begin(&mut self, path: &Path, header: &[String]) -> Result<(), Error> {
        let names: Vec<String> = header.iter().map(|name| quoted(name)).collect();
        let text = names.join(",") + "\n";
        let written = self.write(text.as_bytes());
        Ok(written.map_err(|source| files::failed(path, source))?)
    }

    /// Write what is left; a file is yet to be moved to its place.
    fn finish(self, path: &Path) -> Result<Option<NewFile>, Error> {
        let failed = |source| files::failed(path, source);
        Ok(Some(match self {
            Sink::Plain(file) => file,
            Sink::Packed(file) => file.finish().map_err(failed)?,
            #[cfg(feature = "parquet")]
            Sink::Parquet(sink) => sink.finish()?,
            Sink::Stream(mut to) => {
                to.flush().map_err(failed)?;
                return Ok(None);
            }
        }))
    }

    fn write(&mut self, text: &[u8]) -> std::io::Result<()> {
        match self {
            Sink::Plain(file) => file.write_all(text),
            Sink::Stream(to) => to.write_all(text),
            Sink::Packed(file) => file.write_all(text),
            #[cfg(feature = "parquet")]
            Sink::Parquet(_) => Ok(()),
        }
    }
}

/// Names of the columns, in their order.
fn header(dofs: &[Dof], columns: Written) -> Vec<String> {
    let mut names = vec![POSE];
    names.extend(columns.t.then_some(T));
    names.extend(columns.support.then_some(SUPPORT));
    names.extend(dofs.iter().map(|dof| dof.joint.trim()));
    names.extend(columns.cop.then_some(COP).into_iter().flatten());
    names.extend(columns.cop_std.then_some(COP_STD).into_iter().flatten());
    names.into_iter().map(str::to_string).collect()
}

fn line(text: &mut Vec<u8>, row: &Row, columns: Written) -> std::io::Result<()> {
    for (k, field) in fields(row, columns).enumerate() {
        if k > 0 {
            text.push(b',');
        }
        match field {
            Field::Whole(x) => write!(text, "{x}")?,
            Field::Text(name) => text.extend(quoted(name).bytes()),
            Field::Number(x) => write!(text, "{x}")?,
        }
    }
    text.push(b'\n');
    Ok(())
}

/// A CSV field; names may hold delimiters and quotes.
fn quoted(name: &str) -> String {
    if name.contains([',', ';', '\t', '"', '\n', '\r']) || name.trim() != name {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_string()
    }
}

/// Names of the columns of predictions: m, support frame.
pub const PREDICTED: [&str; 6] = ["pose", "com_x", "com_y", "com_z", "cop_x", "cop_y"];

/// A table of predictions being written: the CoM and CoP of postures, in the formats of logs.
///
/// The end of the file's name tells the format: `.csv`, `.csv.gz` or `.parquet`. The table
/// appears whole or not at all.
pub struct PredictionWriter(PostureWriter);

impl PredictionWriter {
    /// Start a table; nothing is at `path` before [`finish`](Self::finish).
    ///
    /// # Errors
    /// Ends of names that stand for something else, folders that cannot be written to.
    pub fn create(path: &Path) -> Result<PredictionWriter, Error> {
        let sink = Sink::create(path, &PREDICTED.map(str::to_string))?;
        let columns = Written {
            cop: true,
            ..Written::default()
        };
        let writer = PostureWriter::into_sink(path, columns, sink);
        Ok(PredictionWriter(writer))
    }

    /// Append a posture: its CoM and CoP, m.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn row(&mut self, pose: i64, com_m: &[f64; 3], cop_m: [f64; 2]) -> Result<(), Error> {
        self.0.row(&Row {
            pose,
            q: com_m,
            cop: cop_m,
            ..Row::default()
        })
    }

    /// Complete the table and move it to its place.
    ///
    /// # Errors
    /// When it cannot be written to its end.
    pub fn finish(self) -> Result<(), Error> {
        if let Some(file) = self.0.sink.finish(&self.0.path)? {
            file.finish()?;
        }
        Ok(())
    }
}

#[cfg(not(feature = "mcap"))]
impl Recording {
    /// Whether this build can write one.
    ///
    /// # Errors
    /// Always, naming the file that was asked for: the format is left out.
    pub fn check_format(path: &Path) -> Result<(), Error> {
        Err(Error::without("mcap", "MCAP", &path.display().to_string()))
    }

    /// As [`check_format`](Self::check_format).
    pub fn begun(&self, path: &Path, _: &mut dyn crate::Watch) -> Result<NewFile, Error> {
        self.stamps()?;
        Recording::check_format(path)?;
        Ok(NewFile::create(path)?)
    }
}

/// Stamps of ROS 2 count seconds in a signed number of 32 bits.
const LARGEST_S: f64 = 2_147_483_648.0;

/// Postures and what is shown of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// The link in whose frame points are.
    pub frame: String,
    /// Names of the joints, in the order of `q`.
    pub joints: Vec<String>,
    /// Time of each posture, s; one posture a second from 0 unless given.
    pub t: Option<Vec<f64>>,
    /// Posture by posture, joint by joint, rad or m.
    pub q: Vec<f64>,
    /// What is shown of every posture; readings come first.
    pub tracks: Vec<Track>,
}

/// Points or vectors in the sole plane, one for each posture.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Its topic.
    pub topic: &'static str,
    /// What they are.
    pub kind: TrackKind,
    /// x and y of each, m.
    pub xy: Vec<[f64; 2]>,
}

/// What a track is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum TrackKind {
    /// The CoP that was read: a log that is read from the recording has it.
    Reading,
    /// Points.
    Point,
    /// Differences of points.
    Difference,
}

impl Recording {
    /// Stamp of each posture, ns.
    ///
    /// # Errors
    /// Times that stamps do not hold.
    pub(super) fn stamps(&self) -> Result<Vec<u64>, Error> {
        let Some(t) = &self.t else {
            let n = self.tracks.first().map_or(0, |track| track.xy.len());
            return Ok((0..n as u64).map(|k| k * 1_000_000_000).collect());
        };
        let first = t.iter().copied().fold(f64::INFINITY, f64::min);
        let last = t.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let origin = match first >= 0.0 && last < LARGEST_S {
            true => 0.0,
            false => first,
        };
        if last - origin >= LARGEST_S {
            return Err(Error::request(format!(
                "the times of the log span {:.3e} s, and stamps of ROS 2 hold 2^31 s; give the \
                 log its column `t` in seconds",
                last - first
            )));
        }
        let stamp = |t: &f64| ((t - origin) * 1e9).round() as u64;
        Ok(t.iter().map(stamp).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::logs::{LogSource, column_names};
    use crate::tests::says;

    /// Numbers come back to the last digit.
    #[test]
    fn tables_have_the_columns_that_are_promised() {
        let folder = tempfile::tempdir().unwrap();
        let mut names = vec!["a.csv", "a.csv.gz"];
        names.extend(cfg!(feature = "parquet").then_some("a.parquet"));
        for name in names {
            let path = folder.path().join(name);
            let mut writer = PredictionWriter::create(&path).unwrap();
            writer.row(7, &[0.1, -0.2, 0.3], [1e-17, 0.5]).unwrap();
            assert!(!path.exists());
            writer.finish().unwrap();
            assert_eq!(column_names(&LogSource::from(&path)).unwrap(), PREDICTED);
        }
        let text = std::fs::read_to_string(folder.path().join("a.csv")).unwrap();
        let expected =
            "pose,com_x,com_y,com_z,cop_x,cop_y\n7,0.1,-0.2,0.3,0.00000000000000001,0.5\n";
        assert_eq!(text, expected);
        let wrong = PredictionWriter::create(&folder.path().join("a.txt"));
        let said = wrong.err().unwrap().to_string();
        assert!(said.contains(".csv, .csv.gz or .parquet"), "{said}");
    }

    fn at(t: Option<Vec<f64>>) -> Recording {
        let track = Track {
            topic: "/cop",
            kind: TrackKind::Reading,
            xy: vec![[0.0; 2]; 3],
        };
        Recording {
            frame: "foot".into(),
            joints: vec!["hip".into()],
            t,
            q: vec![0.0; 3],
            tracks: vec![track],
        }
    }

    #[test]
    fn stamps_are_those_of_the_log_where_they_can_be() {
        const SECOND: u64 = 1_000_000_000;
        let stamps = |t: [f64; 3]| at(Some(t.to_vec())).stamps();
        assert_eq!(at(None).stamps().unwrap(), [0, SECOND, 2 * SECOND]);
        let today = stamps([1.7e9, 1.7e9 + 0.5, 1.7e9 + 1.0]).unwrap();
        assert_eq!(today[1], 1_700_000_000_500_000_000);
        let early = stamps([-2.0, 0.0, 0.5]).unwrap();
        assert_eq!(early, [0, 2 * SECOND, 5 * SECOND / 2]);
        // Milliseconds since 1970: the day is lost, the order is not.
        let milli = stamps([1.7e12, 1.7e12 + 5.0, 1.7e12]).unwrap();
        assert_eq!(milli[1], 5 * SECOND);
        let said = stamps([0.0, 1.0, 3e9]).unwrap_err().to_string();
        says(said, &["3.000e9 s", "`t` in seconds"]);
    }
}
