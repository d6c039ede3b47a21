//! Reading a log of any format in blocks.
//!
//! ```text
//! source ─▶ chunk of rows ─▶ assembler ─▶ stays ─▶ screen ─▶ block
//! ```

use std::io::Read as _;
use std::path::Path;
use std::sync::Arc;

use sesc_model::files::Stamp;
use sesc_model::tree::Dof;
use sesc_model::urdf::Description;

use super::assemble::Assembler;
use super::block::Block;
use super::columns::{Columns, no_names};
use super::csv::CsvSource;
use super::input::{LogSource, Metered, Place};
#[cfg(feature = "mcap")]
use super::mcap::McapSource;
use super::names;
#[cfg(feature = "parquet")]
use super::parquet;
use super::settings::{Angles, Options, Sidecar, Stays};
use super::source::{Raw, RowSource};
use super::stillness::Settling;
use super::suspect::Suspicions;
use super::table::TableSource;
use crate::{Error, Message};

/// Rows of a log that are taken at once, and of a file looked at before the first is given out.
pub(crate) const BLOCK: usize = 4096;

/// What was read, for the record.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Summary {
    /// 16 hex digits: XXH64 (seed 0) over the bytes of the file.
    pub hash: String,
    /// Rows of the log.
    pub rows: u64,
    /// Runs of rows that share a pose.
    pub postures: u64,
    /// Least and largest `t`, s; none where the log has none.
    pub times: Option<[f64; 2]>,
}

/// A log being read.
///
/// Memory: one chunk of rows and the block that was asked for, however long
/// the log is; each format adds a bounded buffer of its own.
pub struct PostureReader {
    origin: Origin,
    screening: Option<Screening>,
    /// What the log's sidecar says.
    pub sidecar: Sidecar,
    /// What is odd about the log so far, complete after the last block.
    pub warnings: Vec<Message>,
}

/// What becomes of each block, first row to last.
pub(crate) type Screening = Box<dyn FnMut(&mut Block) + Send>;

/// Where rows come from.
enum Origin {
    File(Box<FileReader>),
    /// Rows that were kept, the number of the next one, and how many were given out.
    Memory(Arc<Kept>, usize, u64),
}

/// All rows of a log, and what its reader says of them.
pub(super) struct Kept {
    pub rows: Block,
    pub summary: Option<Summary>,
    pub averaged: f64,
    pub warnings: Vec<Message>,
}

/// Rows on their way from a source to blocks.
struct FileReader {
    /// What messages call the log.
    file: String,
    source: Box<dyn RowSource>,
    assembler: Assembler,
    suspicions: Suspicions,
    raw: Raw,
    /// Rows of `raw` that were given out.
    given: usize,
    /// Rows that are taken from the file at once.
    chunk: usize,
    started: bool,
    ended: bool,
    /// All was said of the whole log.
    concluded: bool,
    last_pose: Option<i64>,
    settling: Option<Settling>,
    /// The file, where it is a regular one, and its stamp before anything was read.
    watched: Option<(std::fs::File, Stamp)>,
    /// Of the rows so far, without the hash.
    summary: Summary,
    /// What is odd about the log and has not yet been told.
    warnings: Vec<Message>,
}

impl PostureReader {
    /// Open a log of `robot`, with the joints that it has on the support that the options or the
    /// sidecar name: a log has no columns for a virtual base.
    ///
    /// # Errors
    ///
    /// As [`open`](Self::open).
    pub(crate) fn of_robot(
        log: &LogSource,
        robot: &Description,
        options: &Options,
    ) -> Result<PostureReader, Error> {
        let (sidecar, _) = log.sidecar()?;
        let support = options.support.as_deref().or(sidecar.support.as_deref());
        let dofs = joints(log, robot, options, support)?;
        PostureReader::open(log, &dofs, options)
    }

    /// Open a log, a file's format told by its first bytes, and match its columns
    /// with the joints `dofs`.
    ///
    /// # Errors
    ///
    /// Files that cannot be read or are no log, missing or doubled columns, a
    /// sidecar with wrong values.
    pub fn open(
        log: impl Into<LogSource>,
        dofs: &[Dof],
        options: &Options,
    ) -> Result<PostureReader, Error> {
        let log = log.into();
        let reader = PostureReader::of_log(&log, dofs, options);
        reader.map_err(|error| error.of_log(log.name()))
    }

    fn of_log(log: &LogSource, dofs: &[Dof], options: &Options) -> Result<PostureReader, Error> {
        let (mut sidecar, mut warnings) = log.sidecar()?;
        let watched = log.watched()?;
        let mut source = open_source(log, dofs, options, &sidecar)?;
        let line = source.names_line();
        let at = line.or(Some(1));
        let promised = promised(log.name()).filter(|format| *format != PACKED && line.is_some());
        let misnamed = promised.map_or(String::new(), |format| {
            format!("not {format} but text, which is read as CSV: ")
        });
        let bad = |message: Message| Error::row(at, message.after(&misnamed));
        let header = sidecar.renamed(source.header());
        let header = header.map_err(|said| bad(said.into()))?;
        let angles = options.angles.or(sidecar.angles).unwrap_or(Angles::Rad);
        // A recording has the CoP of its wrenches.
        let sensors = sidecar.sensors.clone().filter(|_| !source.knows_stays());
        let sensors = sensors.unwrap_or_default();
        let columns = Columns::of(&header, dofs, (options, angles), &sensors);
        let columns = columns.map_err(|said| bad(no_names(&header).map_or(said, Message::from)))?;
        let mut odd = source.warnings();
        odd.extend(columns.note.clone());
        if let (Some(given), Some(own)) = (&options.support, &sidecar.support)
            && given != own
        {
            odd.push(format!(
                "its sidecar has `{own}` on the ground; `{given}` is taken"
            ));
        }
        if !columns.ignored.is_empty() {
            let names = names::list(&columns.ignored);
            let (noun, verb) = match columns.ignored.len() {
                1 => ("column", "is no joint and is"),
                _ => ("columns", "are no joints and are"),
            };
            odd.push(format!("{noun} {names} {verb} ignored"));
        }
        let timed = columns.t.is_some() && !source.knows_stays() && !dofs.is_empty();
        let alone = match options.stays {
            Stays::Alone(_) if !timed && !source.knows_stays() => {
                let message = "has no column `t`: which rows are of one stay is not known";
                return Err(Error::row(Some(1), message));
            }
            Stays::Alone(duration) => Some(Some(duration)),
            Stays::Pooled if columns.pose.is_none() => Some(None),
            _ => None,
        };
        let settling = alone.filter(|_| timed);
        let settling = settling.map(|alone| Settling::new(dofs.len(), alone));
        let mut assembler = Assembler::new(columns, dofs, &sidecar, options)?;
        assembler.both = source.both();
        if let Some(links) = &assembler.both {
            sidecar.other_foot.get_or_insert_with(|| links[1].clone());
        } else if let Some(other) = assembler.other_sole() {
            sidecar.other_foot.get_or_insert(other);
            sidecar.both_feet = Some(true);
        }
        let mut reader = FileReader {
            file: log.name().to_string(),
            suspicions: Suspicions::new(dofs, angles),
            source,
            assembler,
            raw: Raw::default(),
            given: 0,
            chunk: BLOCK,
            started: false,
            ended: false,
            concluded: false,
            last_pose: None,
            settling,
            watched,
            summary: Summary::default(),
            warnings: Vec::new(),
        };
        reader.warn(odd);
        warnings.append(&mut reader.warnings);
        Ok(PostureReader {
            origin: Origin::File(Box::new(reader)),
            screening: None,
            sidecar,
            warnings,
        })
    }

    /// The reader of rows that were kept.
    pub(super) fn of_rows(kept: &Arc<Kept>, sidecar: &Sidecar) -> PostureReader {
        PostureReader {
            origin: Origin::Memory(Arc::clone(kept), 0, 0),
            screening: None,
            sidecar: sidecar.clone(),
            warnings: kept.warnings.clone(),
        }
    }

    /// The same rows as the screening leaves them. Rows in which nothing stands on the foot cells
    /// have a reading of zero, and it is to take them out.
    pub(super) fn screened(mut self, screening: Screening) -> PostureReader {
        if let Origin::File(reader) = &mut self.origin {
            reader.assembler.no_load = true;
        }
        self.screening = Some(screening);
        self
    }

    /// The next rows, `count` at most; an empty block is the end of the log.
    ///
    /// # Errors
    ///
    /// The first faulty row, by its place in the file; a file that changed since it was
    /// opened. A log without rows is an error too.
    pub fn block(&mut self, count: usize) -> Result<Block, Error> {
        loop {
            let mut block = match &mut self.origin {
                Origin::File(reader) => {
                    let block = reader.block(count);
                    self.warnings.append(&mut reader.warnings);
                    block?
                }
                Origin::Memory(kept, next, given) => {
                    let rows = *next..kept.rows.len().min(*next + count);
                    *given += rows.len() as u64;
                    *next = rows.end;
                    kept.rows.select(rows)
                }
            };
            let ended = block.is_empty();
            if let Some(screening) = &mut self.screening {
                screening(&mut block);
            }
            // A block of which nothing is left is not the end of the log.
            if ended || !block.is_empty() {
                return Ok(block);
            }
        }
    }

    /// Pass over about `rows` rows without a look at them, and take `then` at once from there on;
    /// false at the end of the log. What is said of the whole
    /// log afterwards does not know of these rows.
    ///
    /// # Errors
    /// A file that cannot be read there.
    pub(crate) fn skip(&mut self, rows: u64, then: usize) -> Result<bool, Error> {
        match &mut self.origin {
            Origin::File(reader) => {
                let skipped = reader.skip(rows, then);
                skipped.map_err(|error| error.of_log(&reader.file))
            }
            Origin::Memory(kept, next, _) => {
                *next = kept.rows.len().min(*next + rows as usize);
                Ok(*next < kept.rows.len())
            }
        }
    }

    /// Rows that were taken from the file so far, those that were passed over not among them.
    pub(crate) fn taken(&self) -> u64 {
        match &self.origin {
            Origin::File(reader) => {
                reader.summary.rows + (reader.raw.line.len() - reader.given) as u64
            }
            Origin::Memory(_, _, given) => *given,
        }
    }

    /// What the first row of a log that is read no further stands on; without a column of its
    /// own in the log that is known before any row is read.
    pub(crate) fn first_support(mut self) -> Result<Option<Arc<str>>, Error> {
        if let Origin::File(reader) = &self.origin
            && let Some(support) = reader.assembler.support_of_all()
        {
            return Ok(Some(support));
        }
        let block = self.block(1)?;
        Ok(block.support.and_then(|all| all.first().cloned()))
    }

    /// Whether it is a recording, whose readings name their frames.
    pub(crate) fn is_recording(&self) -> bool {
        matches!(&self.origin, Origin::File(reader) if reader.source.knows_stays())
    }

    /// Names of columns that mean nothing to a robot of these joints.
    pub(crate) fn unknown_columns(&self) -> &[String] {
        match &self.origin {
            Origin::File(reader) => &reader.assembler.columns.ignored,
            Origin::Memory(..) => &[],
        }
    }

    /// What averaging took off the variance of a single reading, as a part of it, once a
    /// block was read: 0 where every reading is a row, 0.99 where rows are means of 100.
    pub fn averaged(&self) -> f64 {
        match &self.origin {
            Origin::File(reader) => reader.assembler.averaged(),
            Origin::Memory(kept, ..) => kept.averaged,
        }
    }

    /// How much of the log was read, and of how much, in bytes of the file or in rows of
    /// a Parquet file or a table; the whole of a pipe is not known.
    pub fn progress(&self) -> (u64, Option<u64>) {
        match &self.origin {
            Origin::File(reader) => reader.source.progress(),
            Origin::Memory(kept, next, _) => (*next as u64, Some(kept.rows.len() as u64)),
        }
    }

    /// What was read; nothing before the end was reached.
    pub fn summary(&self) -> Option<Summary> {
        match &self.origin {
            Origin::File(reader) => reader.ended.then(|| Summary {
                hash: format!("{:016x}", reader.source.hash()),
                ..reader.summary.clone()
            }),
            Origin::Memory(kept, ..) => kept.summary.clone(),
        }
    }
}

impl FileReader {
    /// The next rows, before any is screened.
    fn block(&mut self, count: usize) -> Result<Block, Error> {
        let read = self.settled(count);
        let read = read.map_err(|error| error.of_log(&self.file));
        // What is wrong with a file that is being written is not its fault.
        if read.as_ref().map_or(true, Block::is_empty)
            && let Some((file, stamp)) = &self.watched
        {
            let unchanged = stamp.check(file);
            unchanged.map_err(|source| Error::read(&self.file, source))?;
        }
        for pose in read.iter().flat_map(|block| &block.pose) {
            let last = self.last_pose.replace(*pose);
            self.summary.postures += u64::from(last != Some(*pose));
        }
        read
    }

    /// The next rows, where stays count those of which it is known whether they are of one.
    fn settled(&mut self, count: usize) -> Result<Block, Error> {
        while let Some(settling) = &mut self.settling {
            let decided = settling.take(count);
            if let Some(block) = decided.map_err(|said| Error::row(None, said))? {
                return Ok(block);
            }
            let block = self.rows(count)?;
            match &mut self.settling {
                Some(settling) => settling.push(block),
                None => return Ok(block),
            }
        }
        self.rows(count)
    }

    /// Take note of what is odd about the log.
    fn warn(&mut self, odd: Vec<impl Into<Message>>) {
        let file = format!("{}: ", self.file);
        let odd = odd.into_iter().map(|said| said.into().after(&file));
        self.warnings.extend(odd);
    }

    /// See [`PostureReader::skip`].
    fn skip(&mut self, rows: u64, then: usize) -> Result<bool, Error> {
        let waiting = self.raw.line.len() - self.given;
        let beyond = rows.saturating_sub(waiting as u64);
        if self.ended {
            return Ok(false);
        }
        self.source.skip(&self.assembler.columns, beyond)?;
        self.given = self.raw.line.len();
        self.chunk = then.max(1);
        Ok(true)
    }

    /// The next rows as they are in the log.
    fn rows(&mut self, count: usize) -> Result<Block, Error> {
        if !self.started {
            self.refill()?;
        }
        let mut block = Block::default();
        while block.len() < count {
            if self.given == self.raw.line.len() && !self.refill()? {
                break;
            }
            let end = (self.given + count - block.len()).min(self.raw.line.len());
            self.assembler
                .append(&self.raw, self.given..end, &mut block)?;
            self.given = end;
        }
        let summary = &mut self.summary;
        summary.rows += block.len() as u64;
        for &t in block.t.iter().flatten() {
            let [first, last] = summary.times.get_or_insert([t; 2]);
            (*first, *last) = (first.min(t), last.max(t));
        }
        self.suspicions.see(&block);
        if block.len() < count && !std::mem::replace(&mut self.concluded, true) {
            self.warn(self.suspicions.judge());
            self.warn(self.assembler.conclude(self.summary.rows)?);
        }
        Ok(block)
    }

    /// Take the next chunk from the file; false at its end.
    fn refill(&mut self) -> Result<bool, Error> {
        let first = !std::mem::replace(&mut self.started, true);
        self.raw = Raw::new(&self.assembler.columns);
        self.given = 0;
        if !self.ended {
            let columns = &self.assembler.columns;
            let filled = self.source.fill(columns, self.chunk, &mut self.raw);
            if let Err(error) = filled {
                // A faulty row is the end.
                self.raw = Raw::default();
                self.ended = true;
                return Err(error);
            }
            self.ended = self.raw.line.len() < self.chunk;
            self.assembler.scale(&mut self.raw);
            let said = self.source.warnings();
            self.warn(said);
        }
        if first {
            if self.raw.line.is_empty() {
                return Err(Error::row(None, "no postures below the header"));
            }
            let said = self.assembler.look(&self.raw)?;
            self.warn(said);
            self.settling
                .take_if(|_| self.assembler.columns.t.is_none());
        }
        Ok(!self.raw.line.is_empty())
    }
}

/// Names of a log's columns as they stand in it, also of a table that is no log.
///
/// # Errors
/// Files that cannot be read or are no table.
pub fn column_names(log: &LogSource) -> Result<Vec<String>, Error> {
    let source = open_source(log, &[], &Options::default(), &Sidecar::default());
    let source = source.map_err(|error| error.of_log(log.name()))?;
    Ok(source.header().to_vec())
}

/// The joints that `robot` has on `support`, else on what the first row of the log stands on: only a
/// robot with a virtual base has others elsewhere.
pub(crate) fn joints(
    log: &LogSource,
    robot: &Description,
    options: &Options,
    support: Option<&str>,
) -> Result<Vec<Dof>, Error> {
    let dofs = robot.dofs_on(support);
    if support.is_some() || !robot.has_virtual_base() || !log.can_be_read_again() {
        return Ok(dofs);
    }
    let first = PostureReader::open(log, &dofs, options)?.first_support()?;
    let first = first.filter(|link| !link.is_empty());
    Ok(robot.dofs_on(first.as_deref()))
}

/// The right source for what `log` holds.
fn open_source(
    log: &LogSource,
    dofs: &[Dof],
    options: &Options,
    sidecar: &Sidecar,
) -> Result<Box<dyn RowSource>, Error> {
    let file = log.name();
    let place = &log.place;
    if let Place::Table(table) = place {
        return Ok(Box::new(TableSource::open(table)?));
    }
    if let Place::File(path) = place
        && path.is_dir()
    {
        return Err(Error::row(None, folder(path)));
    }
    let mut input = Metered::open(place)?;
    let mut head = Vec::new();
    let begun = (&mut input).take(8).read_to_end(&mut head);
    begun.map_err(Error::unread)?;
    if head.starts_with(b"PAR1") || head.starts_with(b"PARE") {
        #[cfg(not(feature = "parquet"))]
        return Err(Error::without("parquet", "Parquet", file));
        #[cfg(feature = "parquet")]
        return parquet::open(place);
    }
    if head.starts_with(b"\x89MCAP") {
        #[cfg(not(feature = "mcap"))]
        let _ = (dofs, options, sidecar);
        #[cfg(not(feature = "mcap"))]
        return Err(Error::without("mcap", "MCAP", file));
        #[cfg(feature = "mcap")]
        return Ok(Box::new(McapSource::open(place, dofs, options, sidecar)?));
    }
    if let Some(message) = foreign(file, &head).or_else(|| damaged_from_the_start(file, &head)) {
        return Err(Error::row(None, message));
    }
    Ok(Box::new(CsvSource::open(head, input)?))
}

/// The format that the name of a file promises, if it is another one than text.
fn promised(file: &str) -> Option<&'static str> {
    let end = Path::new(file).extension()?.to_str()?;
    match end.to_ascii_lowercase().as_str() {
        "parquet" => Some("a Parquet file"),
        "mcap" => Some("an MCAP recording"),
        "gz" => Some(PACKED),
        _ => None,
    }
}
const PACKED: &str = "packed with gzip";

/// What is wrong with a file that by its name is no CSV, and by its first bytes no text.
fn damaged_from_the_start(file: &str, head: &[u8]) -> Option<String> {
    let format = promised(file)?;
    // Text of any name is read as CSV.
    let is_text = head.utf8_chunks().next().is_some_and(|chunk| {
        // The last character may be cut by the eight bytes looked at.
        !chunk.valid().is_empty() && !chunk.valid().contains('\0') && chunk.invalid().is_empty()
    });
    if is_text || (format == PACKED && head.starts_with(b"\x1f\x8b")) {
        return None;
    }
    Some(match head.is_empty() {
        true => "empty; copy it again".to_string(),
        false => format!(
            "by its name {format}, but it does not start like one: damaged, or of another format; \
             copy it again, or rename it"
        ),
    })
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

#[cfg(test)]
mod tests {
    use super::*;

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
