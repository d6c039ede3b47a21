//! Writing logs: the one place where the order of their columns is set.
//!
//! The end of the file's name tells the format: `.csv`, `.csv.gz` or
//! `.parquet`. Log and sidecar appear whole or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};

use sesc_model::tree::Dof;

use super::columns::{COP, COP_STD, Field, POSE, Row, SUPPORT, T, Written, check_joints, fields};
use super::settings::Sidecar;
use crate::Error;
use crate::files::{self, NewFile};

/// Names of the columns of predictions: m, support frame.
pub const PREDICTED: [&str; 6] = ["pose", "com_x", "com_y", "com_z", "cop_x", "cop_y"];

/// A log being written, or a table of predictions.
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
        PostureWriter::begin(path, columns, Sink::create(path, &header)?, &header)
    }

    /// Start a table with the columns [`PREDICTED`], whose rows have a CoM in place of joints;
    /// nothing is at `path` before [`finish_alone`](Self::finish_alone).
    ///
    /// # Errors
    /// Ends of names that stand for something else, folders that cannot be written to.
    pub fn predictions(path: &Path) -> Result<PostureWriter, Error> {
        let header = PREDICTED.map(str::to_string);
        let columns = Written {
            cop: true,
            ..Written::default()
        };
        PostureWriter::begin(path, columns, Sink::create(path, &header)?, &header)
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
        let sink = Sink::Stream(Box::new(to));
        PostureWriter::begin(Path::new(name), columns, sink, &header(dofs, columns))
    }

    /// Complete a table that has no sidecar.
    ///
    /// # Errors
    /// When it cannot be written to its end.
    pub fn finish_alone(self) -> Result<(), Error> {
        let file = self.sink.finish(&self.path)?;
        Ok(file.map_or(Ok(()), NewFile::finish)?)
    }

    /// Write the names of the columns; a Parquet file has them already.
    fn begin(
        path: &Path,
        columns: Written,
        mut sink: Sink,
        header: &[String],
    ) -> Result<PostureWriter, Error> {
        let names: Vec<String> = header.iter().map(|name| quoted(name)).collect();
        let text = names.join(",") + "\n";
        let written = sink.write(text.as_bytes());
        written.map_err(|source| files::failed(path, source))?;
        Ok(PostureWriter {
            path: path.to_path_buf(),
            columns,
            sink,
            text: Vec::new(),
        })
    }

    /// Append a row.
    pub fn row(&mut self, row: &Row) -> Result<(), Error> {
        let written = match &mut self.sink {
            #[cfg(feature = "parquet")]
            Sink::Parquet(sink) => sink.row(row, self.columns),
            sink => {
                self.text.clear();
                let text = &mut self.text;
                line(text, row, self.columns).and_then(|()| sink.write(text))
            }
        };
        Ok(written.map_err(|source| files::failed(&self.path, source))?)
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
        Ok(match end.to_ascii_lowercase().as_str() {
            "toml" => return wrong(" ends in .toml, which is the sidecar's; use .csv"),
            "mcap" => return wrong(": MCAP is only read; write .csv, .csv.gz or .parquet"),
            "gz" => Sink::Packed(flate2::write::GzEncoder::new(
                NewFile::create(path)?,
                // Digits hardly pack better for ten times the time.
                flate2::Compression::fast(),
            )),
            #[cfg(feature = "parquet")]
            "parquet" => {
                let sink = super::parquet::ParquetSink::new(NewFile::create(path)?, header);
                Sink::Parquet(sink.map_err(|source| files::failed(path, source))?)
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
        })
    }

    /// Write what is left; a file is yet to be moved to its place.
    fn finish(self, path: &Path) -> Result<Option<NewFile>, Error> {
        let failed = |source| files::failed(path, source);
        Ok(Some(match self {
            Sink::Plain(file) => file,
            Sink::Packed(file) => file.finish().map_err(failed)?,
            #[cfg(feature = "parquet")]
            Sink::Parquet(sink) => sink.finish().map_err(failed)?,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::logs::{LogSource, column_names};

    /// Numbers come back to the last digit.
    #[test]
    fn tables_have_the_columns_that_are_promised() {
        let folder = tempfile::tempdir().unwrap();
        let mut names = vec!["a.csv", "a.csv.gz"];
        names.extend(cfg!(feature = "parquet").then_some("a.parquet"));
        for name in names {
            let path = folder.path().join(name);
            let mut writer = PostureWriter::predictions(&path).unwrap();
            let row = Row {
                pose: 7,
                q: &[0.1, -0.2, 0.3],
                cop: [1e-17, 0.5],
                ..Row::default()
            };
            writer.row(&row).unwrap();
            assert!(!path.exists());
            writer.finish_alone().unwrap();
            assert_eq!(column_names(&LogSource::from(&path)).unwrap(), PREDICTED);
        }
        let text = std::fs::read_to_string(folder.path().join("a.csv")).unwrap();
        let expected =
            "pose,com_x,com_y,com_z,cop_x,cop_y\n7,0.1,-0.2,0.3,0.00000000000000001,0.5\n";
        assert_eq!(text, expected);
        let wrong = PostureWriter::predictions(&folder.path().join("a.txt"));
        let said = wrong.err().unwrap().to_string();
        assert!(said.contains(".csv, .csv.gz or .parquet"), "{said}");
    }
}
