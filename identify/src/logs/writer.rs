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
use sesc_model::files::{self, NewFile};

/// A log being written.
pub struct PostureWriter {
    path: PathBuf,
    columns: Written,
    sink: Sink,
    /// The row being put together.
    text: Vec<u8>,
}

enum Sink {
    Plain(NewFile),
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
        let end = path.extension().and_then(|end| end.to_str()).unwrap_or("");
        let header = header(dofs, columns);
        let mut text = Vec::new();
        for (k, name) in header.iter().enumerate() {
            text.extend(if k > 0 { "," } else { "" }.bytes());
            text.extend(quoted(name).bytes());
        }
        text.push(b'\n');
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
                let sink = super::parquet::ParquetSink::create(path, &header, columns.support)?;
                Sink::Parquet(sink)
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
        sink.write(&text)
            .map_err(|source| files::failed(path, source))?;
        Ok(PostureWriter {
            path: path.to_path_buf(),
            columns,
            sink,
            text,
        })
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

    /// Complete the log and write its sidecar, whose path is given back.
    pub fn finish(self, sidecar: &Sidecar) -> Result<PathBuf, Error> {
        let text = toml::to_string(sidecar).map_err(Error::serialise)?;
        let log = match self.sink {
            Sink::Plain(file) => file,
            Sink::Packed(file) => file
                .finish()
                .map_err(|source| files::failed(&self.path, source))?,
            #[cfg(feature = "parquet")]
            Sink::Parquet(sink) => sink.finish()?,
        };
        let path = Sidecar::path(&self.path);
        // The sidecar first: a log is never there without what it means.
        files::finish_together(vec![files::begun(&path, &text)?, log])?;
        Ok(path)
    }
}

impl Sink {
    fn write(&mut self, text: &[u8]) -> std::io::Result<()> {
        match self {
            Sink::Plain(file) => file.write_all(text),
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
