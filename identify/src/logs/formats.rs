//! The formats of logs: what each delivers, and which one a file is of.
//!
//! A file's first bytes tell its format, whatever its name. Of one that is not read they tell what
//! it is, and the command that makes a log of it.

use std::cell::Cell;
use std::collections::HashSet;
use std::io::Read as _;
#[cfg(feature = "parquet")]
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;
use std::sync::Arc;

use sesc_model::tree::Dof;

use super::block::Share;
use super::columns::{Columns, POSE};
use super::csv::CsvSource;
use super::input::{LogSource, Metered, Place};
use super::settings::Sidecar;
use super::settings::{Options, Stays};
use super::table::{Shared, TableSource};
use crate::{Error, Message};

/// Rows of a file before anything is made of them.
#[derive(Debug, Clone, Default)]
pub(super) struct Raw {
    pub line: Vec<u64>,
    /// Empty where the log has no such column; [`MISSING`] where a row has no value.
    pub pose: Vec<i64>,
    /// Empty where the log has no such column.
    pub support: Vec<Arc<str>>,
    /// Row by row, in the order of [`Columns::numbers`]. Not yet known to be
    /// finite; a missing value is NaN.
    pub numbers: Vec<f64>,
    /// The other contact of rows of both feet; empty of other logs.
    pub other: Vec<Share>,
}

impl Raw {
    /// Number `k` of each row, of `width` a row.
    pub fn column(&mut self, k: usize, width: usize) -> impl Iterator<Item = &mut f64> {
        self.numbers.iter_mut().skip(k).step_by(width)
    }

    /// Forget all rows, keeping the room for them.
    pub fn clear(&mut self) {
        self.line.clear();
        self.pose.clear();
        self.support.clear();
        self.numbers.clear();
        self.other.clear();
    }
}

/// A file of some format, read row by row.
pub(super) trait RowSource: Send {
    /// Names of the columns, without blanks around them.
    fn header(&self) -> &[String];

    /// The line or row of these names.
    fn names_line(&self) -> u64 {
        1
    }

    /// Append up to `count` rows to `raw`; fewer only at the end of the file.
    fn fill(&mut self, columns: &Columns, count: usize, raw: &mut Raw) -> Result<(), Error>;

    /// Pass over about `rows` rows without a look at them.
    fn skip(&mut self, columns: &Columns, rows: u64) -> Result<(), Error>;

    /// Whether rows are of stretches in which the robot held still already.
    fn knows_stays(&self) -> bool {
        false
    }

    /// The support and the other link that stands, where each row has a contact of both.
    fn both(&self) -> Option<[String; 2]> {
        None
    }

    /// Whether it is text, whatever its name says.
    fn is_text(&self) -> bool {
        false
    }

    /// How much was read, and of how much if that is known: bytes or rows.
    fn progress(&self) -> (u64, Option<u64>);

    /// What is odd so far; drained by the call.
    fn warnings(&mut self) -> Vec<Message> {
        Vec::new()
    }

    /// 64-bit hash of the file's bytes, once all of them were read and none passed over.
    fn hash(&self) -> u64;
}

/// Repeated texts, each kept once.
#[derive(Debug, Default)]
pub(super) struct Interner(HashSet<Arc<str>>);

impl Interner {
    pub fn get(&mut self, text: &str) -> Arc<str> {
        if let Some(known) = self.0.get(text) {
            return known.clone();
        }
        let new: Arc<str> = text.into();
        // A log that names more than this names no links.
        if self.0.len() < 10_000 {
            self.0.insert(new.clone());
        }
        new
    }
}

/// The pose of a row that has no value there.
pub(super) const MISSING: i64 = i64::MIN;

/// A pose as a number; integers up to 2^53 come through floats unchanged.
pub(super) fn whole(value: f64) -> Result<i64, String> {
    if value.is_nan() {
        Ok(MISSING)
    } else if value.fract() == 0.0 && value.abs() <= 9_007_199_254_740_992.0 {
        Ok(value as i64)
    } else {
        Err(format!(
            "column `{POSE}`: {value} is no whole number below 2^53"
        ))
    }
}

/// The right source for what `log` holds.
pub(super) fn open(
    log: &LogSource,
    dofs: &[Dof],
    options: &Options,
    sidecar: &Sidecar,
) -> Result<Box<dyn RowSource>, Error> {
    let file = log.name();
    let failed = |source| Error::read(file.to_string(), source);
    let place = &log.place;
    if let Place::Table(table) = place {
        return Ok(Box::new(TableSource::open(table)?));
    }
    let wrong = |message: String| Error::log(file.to_string(), None, message);
    if let Place::File(path) = place
        && path.is_dir()
    {
        return Err(wrong(folder(path)));
    }
    let mut input = Metered::open(place, file)?;
    let mut head = Vec::new();
    let begun = (&mut input).take(8).read_to_end(&mut head);
    begun.map_err(failed)?;
    if head.starts_with(b"PAR1") || head.starts_with(b"PARE") {
        return match place {
            // What its columns are stands at the end.
            Place::Stream(_) => {
                let mut bytes = head;
                input.read_to_end(&mut bytes).map_err(failed)?;
                open_parquet(&Place::Bytes(Shared::new(bytes)), file)
            }
            _ => open_parquet(place, file),
        };
    }
    if head.starts_with(b"\x89MCAP") {
        return open_mcap(place, file, dofs, options, sidecar);
    }
    if let Some(message) = foreign(file, &head).or_else(|| damaged_from_the_start(file, &head)) {
        return Err(wrong(message));
    }
    Ok(Box::new(CsvSource::open(file, head, input)?))
}

/// What is said before a complaint about columns of a file that its name promises to be of
/// another format than text.
pub(super) fn misnamed(log: &LogSource, source: &dyn RowSource) -> &'static str {
    match ending(log.name()).as_deref().filter(|_| source.is_text()) {
        Some("parquet") => "not a Parquet file but text, which is read as CSV: ",
        Some("mcap") => "not an MCAP recording but text, which is read as CSV: ",
        _ => "",
    }
}

/// What the name of a file ends in, in small letters.
fn ending(file: &str) -> Option<String> {
    let end = Path::new(file).extension()?.to_str()?;
    Some(end.to_ascii_lowercase())
}

/// What is wrong with a file that by its name is no CSV, and by its first bytes no text.
fn damaged_from_the_start(file: &str, head: &[u8]) -> Option<String> {
    let format = match ending(file)?.as_str() {
        "parquet" => "a Parquet file",
        "mcap" => "an MCAP recording",
        "gz" if !head.starts_with(b"\x1f\x8b") => "packed with gzip",
        _ => return None,
    };
    // Text of any name is read as CSV.
    let text = head.utf8_chunks().next().is_some_and(|chunk| {
        // The last character may be cut by the eight bytes looked at.
        !chunk.valid().is_empty() && !chunk.valid().contains('\0') && chunk.invalid().is_empty()
    });
    (!text).then(|| match head.is_empty() {
        true => "empty; copy it again".to_string(),
        false => format!(
            "by its name {format}, but it does not start like one: damaged, or of another format; \
             copy it again, or rename it"
        ),
    })
}

#[cfg(feature = "parquet")]
fn open_parquet(place: &Place, file: &str) -> Result<Box<dyn RowSource>, Error> {
    Ok(Box::new(super::parquet::ParquetSource::open(place, file)?))
}

#[cfg(not(feature = "parquet"))]
fn open_parquet(_: &Place, file: &str) -> Result<Box<dyn RowSource>, Error> {
    Err(Error::without("parquet", "Parquet", file))
}

#[cfg(feature = "mcap")]
fn open_mcap(
    place: &Place,
    file: &str,
    dofs: &[Dof],
    options: &Options,
    sidecar: &Sidecar,
) -> Result<Box<dyn RowSource>, Error> {
    let topic = options.topic.as_deref().or(sidecar.topic.as_deref());
    let topics = (topic, sidecar.joints_topic.as_deref());
    let mut options = options.clone();
    options.support = options.support.or_else(|| sidecar.support.clone());
    options.both_feet = options.both_feet.or(sidecar.both_feet);
    if let Stays::Alone(duration) = options.stays {
        options.stillness.duration = duration;
    }
    let options = &options;
    let source = super::mcap::McapSource::open(place, file, dofs, options, topics)?;
    Ok(Box::new(source))
}

#[cfg(not(feature = "mcap"))]
fn open_mcap(
    _: &Place,
    file: &str,
    _: &[Dof],
    _: &Options,
    _: &Sidecar,
) -> Result<Box<dyn RowSource>, Error> {
    Err(Error::without("mcap", "MCAP", file))
}

/// First bytes of files that are not read, what they are, and what makes a log of them; `@` stands
/// for the path, `$` for the path without its ending.
#[rustfmt::skip]
const FOREIGN: [(&[u8], &str); 15] = [
    (b"SQLite f", "a recording of ROS 2 in SQLite; convert it by `mcap convert @ $.mcap`"),
    (b"#ROSBAG ", "a recording of ROS 1; convert it by `mcap convert @ $.mcap`"),
    (b"\x28\xb5\x2f\xfd", "compressed by zstd; unpack it by `zstd -d @`"),
    (b"BZh", "compressed by bzip2; unpack it by `bunzip2 @`"),
    (b"\xfd7zXZ", "compressed by xz; unpack it by `unxz @`"),
    (b"\x04\x22\x4d\x18", "compressed by lz4; unpack it by `unlz4 @`"),
    (b"PK\x03\x04", "a packed folder or a spreadsheet; unpack it, or save the sheet as CSV"),
    (b"7z\xbc\xaf", "a packed folder; unpack it by `7z x @`"),
    (b"\xd0\xcf\x11\xe0", "a spreadsheet of Excel; save it as CSV"),
    (b"\x89HDF", "an HDF5 file, as MATLAB and h5py write them; \
        write a table: `writetable(T, '$.csv')`, or `DataFrame.to_parquet`"),
    (b"MATLAB 5", "a MAT-file; write a table in MATLAB: `writetable(T, '$.csv')`"),
    (b"\x93NUMPY", "an array of NumPy, without names of columns; write it by \
        `numpy.savetxt('$.csv', a, delimiter=',', header='pose,…', comments='')`"),
    (b"ARROW1", "an Arrow or Feather file; \
        write it as Parquet: `pandas.read_feather('@').to_parquet('$.parquet')`"),
    (b"\x80\x04\x95", PICKLE),
    (b"\x80\x05\x95", PICKLE),
];
const PICKLE: &str = "a pickle of Python; write the data frame by `to_parquet` or `to_csv`";

/// What is said of a file that begins as one of another format does.
fn foreign(name: &str, head: &[u8]) -> Option<String> {
    let (_, said) = FOREIGN.iter().find(|(first, _)| head.starts_with(first))?;
    let stem = Path::new(name).with_extension("");
    let said = said.replace('$', &stem.display().to_string());
    Some(said.replace('@', name))
}

/// What is said of a folder, which may be a recording of ROS 2.
fn folder(path: &Path) -> String {
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    let files = entries.filter_map(|entry| entry.file_name().into_string().ok());
    let mut files: Vec<String> = files.collect();
    files.sort();
    let first = |end: &str| files.iter().find(|name| name.ends_with(end));
    if let Some(own) = first(".mcap") {
        format!("a folder; give the recording in it, `{own}`")
    } else if let Some(own) = first(".db3") {
        let stem = own.trim_end_matches(".db3");
        format!(
            "a folder with a recording of ROS 2 in SQLite, `{own}`; convert it by `mcap convert {} \
             {stem}.mcap`",
            path.join(own).display()
        )
    } else {
        "a folder; give a log, or the folder to `fleet`".to_string()
    }
}

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Whether a panic on this thread becomes an error of the log that is being read.
///
/// The Parquet library meets some damaged files with a panic, which is caught. The panic
/// hook runs before that and by default prints a message; it belongs to the application, so
/// this library leaves it alone. An application may set one that is silent where this
/// is true, as the command line does:
///
/// ```
/// let usual = std::panic::take_hook();
/// std::panic::set_hook(Box::new(move |about| {
///     if !sesc_identify::logs::panic_becomes_error() {
///         usual(about);
///     }
/// }));
/// ```
pub fn panic_becomes_error() -> bool {
    GUARDED.get()
}

/// What `step` gives; none where it panics.
#[cfg(feature = "parquet")]
pub(super) fn catch_panic<T>(step: impl FnOnce() -> T) -> Option<T> {
    GUARDED.set(true);
    let done = panic::catch_unwind(AssertUnwindSafe(step));
    GUARDED.set(false);
    done.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_texts_are_kept_once() {
        let mut interner = Interner::default();
        assert!(Arc::ptr_eq(&interner.get("a"), &interner.get("a")));
    }

    #[test]
    fn a_command_converts_what_is_not_read() {
        let said = foreign("run/a.bag", b"#ROSBAG V2.0\n").unwrap();
        assert!(
            said.ends_with("`mcap convert run/a.bag run/a.mcap`"),
            "{said}"
        );
        assert_eq!(foreign("a.csv", b"pose,hip"), None);
        assert_eq!(foreign("a.csv", b"# pose,h"), None);
    }

    #[test]
    fn a_folder_of_ros_2_names_its_recording() {
        let at = tempfile::tempdir().unwrap();
        assert!(folder(at.path()).contains("`fleet`"));
        std::fs::write(at.path().join("r_0.db3"), "").unwrap();
        assert!(folder(at.path()).contains("r_0.db3 r_0.mcap`"));
        std::fs::write(at.path().join("r_0.mcap"), "").unwrap();
        assert!(folder(at.path()).ends_with("`r_0.mcap`"));
    }
}
