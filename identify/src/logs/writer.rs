//! Writing logs: the one place where the order of their columns is set.
//!
//! The end of the file's name tells the format: `.csv`, `.csv.gz` or
//! `.parquet`. Log and sidecar appear whole or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};

use sesc_model::tree::Dof;

use super::columns::{COP, COP_STD, POSE, SUPPORT, T, check_joints};
use super::row::{Row, Written, numbers};
use super::sidecar::Sidecar;
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
pub(super) enum Sink {
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
        let sink = Sink::stream(path, Box::new(to), &header(dofs, columns))?;
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
        self.sink.row(&self.path, row, self.columns, &mut self.text)
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
    pub(super) fn create(path: &Path, header: &[String]) -> Result<Sink, Error> {
        let end = path.extension().and_then(|end| end.to_str()).unwrap_or("");
        let mut sink = match end.to_ascii_lowercase().as_str() {
            "toml" => {
                return Err(Error::request(format!(
                    "{} ends in .toml, which is the sidecar's; use .csv",
                    path.display()
                )));
            }
            "mcap" => {
                return Err(Error::request(format!(
                    "{}: MCAP is only read; write .csv, .csv.gz or .parquet",
                    path.display()
                )));
            }
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
            "parquet" => {
                return Err(Error::without(
                    "parquet",
                    "Parquet",
                    &path.display().to_string(),
                ));
            }
            "csv" | "" => Sink::Plain(NewFile::create(path)?),
            // A device or a pipe has no format in its name.
            _ if path.starts_with("/dev") => Sink::Plain(NewFile::create(path)?),
            other => {
                return Err(Error::request(format!(
                    "{}: posture logs are written as .csv, .csv.gz or .parquet, not as .{other}",
                    path.display()
                )));
            }
        };
        sink.begin(path, header)?;
        Ok(sink)
    }

    /// Start a table as CSV on a stream; `name` stands for it in messages.
    fn stream(name: &Path, to: Box<dyn Write + Send>, header: &[String]) -> Result<Sink, Error> {
        let mut sink = Sink::Stream(to);
        sink.begin(name, header)?;
        Ok(sink)
    }

    /// Write the names of the columns.
    fn begin(&mut self, path: &Path, header: &[String]) -> Result<(), Error> {
        let names: Vec<String> = header.iter().map(|name| quoted(name)).collect();
        let text = names.join(",") + "\n";
        let written = self.write(text.as_bytes());
        Ok(written.map_err(|source| files::failed(path, source))?)
    }

    /// Append a row; `text` is room for it.
    pub(super) fn row(
        &mut self,
        path: &Path,
        row: &Row,
        columns: Written,
        text: &mut Vec<u8>,
    ) -> Result<(), Error> {
        #[cfg(feature = "parquet")]
        if let Sink::Parquet(sink) = self {
            return sink.row(row, columns);
        }
        text.clear();
        let failed = |source| files::failed(path, source);
        line(text, row, columns).map_err(failed)?;
        Ok(self.write(text).map_err(failed)?)
    }

    /// Write what is left; a file is yet to be moved to its place.
    pub(super) fn finish(self, path: &Path) -> Result<Option<NewFile>, Error> {
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
    write!(text, "{}", row.pose)?;
    if columns.t {
        write!(text, ",{}", row.t)?;
    }
    if columns.support {
        write!(text, ",{}", quoted(row.support))?;
    }
    for x in numbers(row, columns) {
        write!(text, ",{x}")?;
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
