//! Where a log is: a file, the bytes of one, a stream of them, or a table in memory.

use std::fmt;
use std::fs::File;
use std::hash::Hasher as _;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use sesc_model::files::Stamp;
use twox_hash::XxHash64;

use super::block::Block;
use super::settings::Sidecar;
use super::table::{Shared, Table};
use crate::{Error, Message};

/// A posture log that can be opened, as often as needed.
///
/// A path, or a path-like value, is a log on disk; its sidecar is looked for
/// beside it. A [`Table`], a stream or the bytes of a file have the sidecar they are given.
///
/// ```
/// use sesc_identify::logs::{LogSource, Sidecar, Table};
///
/// let on_disk = LogSource::from("run.csv");
/// let table = Table::new("run")
///     .integers("pose", vec![0, 1])
///     .numbers("hip", vec![0.1, 0.2])
///     .numbers("cop_x", vec![0.010, 0.012])
///     .numbers("cop_y", vec![0.001, 0.002]);
/// let in_memory = LogSource::from(table).with_sidecar(Sidecar {
///     support: Some("r_sole".into()),
///     ..Sidecar::default()
/// });
/// assert_eq!(in_memory.name(), "run");
/// assert_eq!(on_disk.path(), Some("run.csv".as_ref()));
/// ```
#[derive(Clone)]
pub struct LogSource {
    name: String,
    pub(super) place: Place,
    sidecar: Option<Arc<Sidecar>>,
    pub(super) screen: Option<Arc<dyn Screen>>,
    /// What its file has to be, where it was read already.
    was: Option<Stamp>,
}

/// Bytes of a pipe, at most.
const LONGEST_PIPE: u64 = 1 << 29;

/// Where the rows are.
#[derive(Clone)]
pub(super) enum Place {
    File(PathBuf),
    Bytes(Shared<u8>),
    /// Starts a stream from its first byte, as often as asked.
    Stream(Arc<dyn Fn() -> io::Result<Stream> + Send + Sync>),
    Table(Arc<Table>),
}

impl LogSource {
    /// The bytes of a log file of any format; `name` stands for the file in messages.
    pub fn bytes(
        name: impl Into<String>,
        bytes: impl AsRef<[u8]> + Send + Sync + 'static,
    ) -> LogSource {
        LogSource::at(name.into(), Place::Bytes(Shared::new(bytes)))
    }

    /// A log file of any format that comes from anything that can be read, such as a socket or
    /// an entry of an archive: it is read to its end now, into memory. `name` stands for the file
    /// in messages.
    ///
    /// # Errors
    /// Where reading fails.
    ///
    /// ```
    /// use sesc_identify::logs::LogSource;
    ///
    /// let csv = "pose,hip,cop_x,cop_y\n0,0.1,0.010,0.001\n";
    /// let log = LogSource::reader("run.csv", csv.as_bytes())?;
    /// assert!(log.can_be_read_again());
    /// # Ok::<(), sesc_identify::Error>(())
    /// ```
    pub fn reader(name: impl Into<String>, mut from: impl Read) -> Result<LogSource, Error> {
        let (name, mut bytes) = (name.into(), Vec::new());
        match from.read_to_end(&mut bytes) {
            Ok(_) => Ok(LogSource::bytes(name, bytes)),
            Err(source) => Err(Error::read(name, source)),
        }
    }

    /// A log file of any format as a stream, which `open` starts from its first byte, as often as
    /// a fit or a diagnosis goes over its rows: CSV, packed or not, and MCAP are never in memory
    /// as a whole, Parquet is, since it begins at its end. Every stream has to give the same
    /// bytes. `name` stands for the file in messages.
    ///
    /// ```
    /// use std::io::Read;
    /// use sesc_identify::logs::LogSource;
    ///
    /// let rows = |k| format!("{k},0.1,0.010,0.001\n").into_bytes();
    /// let log = LogSource::stream("run.csv", move || {
    ///     let header: &[u8] = b"pose,hip,cop_x,cop_y\n";
    ///     Ok(header.chain(std::io::Cursor::new(rows(0))).chain(std::io::Cursor::new(rows(1))))
    /// });
    /// assert_eq!(log.name(), "run.csv");
    /// ```
    pub fn stream<R: Read + Send + 'static>(
        name: impl Into<String>,
        open: impl Fn() -> io::Result<R> + Send + Sync + 'static,
    ) -> LogSource {
        let open = move || -> io::Result<Stream> { Ok(Box::new(open()?)) };
        LogSource::at(name.into(), Place::Stream(Arc::new(open)))
    }

    fn at(name: String, place: Place) -> LogSource {
        LogSource {
            name,
            place,
            sidecar: None,
            screen: None,
            was: None,
        }
    }

    /// The same log with this sidecar, instead of the one beside its file.
    pub fn with_sidecar(mut self, sidecar: Sidecar) -> LogSource {
        self.sidecar = Some(Arc::new(sidecar));
        self
    }

    /// The same log without what the screen leaves out.
    #[doc(hidden)]
    pub fn screened(mut self, screen: Arc<dyn Screen>) -> LogSource {
        self.screen = Some(screen);
        self
    }

    /// The same log, as several readings see it: a pipe is read to its end now, into memory; a file
    /// is refused from now on if it is not what it is now.
    ///
    /// # Errors
    /// When the file cannot be opened or read; a pipe of more than 512 MiB.
    #[doc(hidden)]
    pub fn unchanged(self) -> Result<LogSource, Error> {
        match &self.place {
            Place::File(path) if path.exists() && !path.is_file() && !path.is_dir() => {
                let (sidecar, _) = self.sidecar()?;
                let failed = |source| Error::read(self.name.clone(), source);
                let mut bytes = Vec::new();
                let pipe = File::open(path).map_err(failed)?.take(LONGEST_PIPE + 1);
                { pipe }.read_to_end(&mut bytes).map_err(failed)?;
                if bytes.len() as u64 > LONGEST_PIPE {
                    let message =
                        "a pipe of more than 512 MiB; write the log to a file, and give that";
                    return Err(Error::log(self.name.clone(), None, message));
                }
                let log = LogSource::bytes(self.name, bytes).with_sidecar(sidecar);
                Ok(log)
            }
            _ => {
                let was = self.watched()?.map(|(_, stamp)| stamp);
                Ok(LogSource { was, ..self })
            }
        }
    }

    /// The file, where the log is a regular one, and its stamp before it is read.
    pub(super) fn watched(&self) -> Result<Option<(File, Stamp)>, Error> {
        let Place::File(path) = &self.place else {
            return Ok(None);
        };
        if !self.can_be_read_again() {
            return Ok(None);
        }
        let failed = |source| Error::read(self.name.clone(), source);
        let file = File::open(path).map_err(failed)?;
        if let Some(was) = &self.was {
            was.check(&file).map_err(failed)?;
        }
        Ok(Stamp::of(&file).map(|stamp| (file, stamp)))
    }

    /// Whether it can be read more than once: a pipe cannot.
    pub fn can_be_read_again(&self) -> bool {
        match &self.place {
            Place::File(path) => path.metadata().is_ok_and(|about| about.is_file()),
            Place::Bytes(_) | Place::Stream(_) | Place::Table(_) => true,
        }
    }

    /// What messages call the log.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The last part of the name, free of folders.
    pub fn file_name(&self) -> &str {
        let last = Path::new(&self.name).file_name();
        last.and_then(|name| name.to_str()).unwrap_or(&self.name)
    }

    /// The file, if the log is one.
    pub fn path(&self) -> Option<&Path> {
        match &self.place {
            Place::File(path) => Some(path),
            _ => None,
        }
    }

    /// The table, if the log is one.
    pub fn table(&self) -> Option<&Table> {
        match &self.place {
            Place::Table(table) => Some(table),
            _ => None,
        }
    }

    /// The bytes of the file, if the log is given by them.
    #[doc(hidden)]
    pub fn content(&self) -> Option<&[u8]> {
        match &self.place {
            Place::Bytes(bytes) => Some(bytes.as_ref()),
            _ => None,
        }
    }

    /// The log's sidecar, empty where there is none, and what is odd about it.
    ///
    /// # Errors
    /// A sidecar that cannot be read or has wrong values.
    pub fn sidecar(&self) -> Result<(Sidecar, Vec<Message>), Error> {
        match (&self.sidecar, &self.place) {
            (Some(sidecar), _) => {
                sidecar.check().map_err(|message| {
                    Error::log(self.name.clone(), None, format!("sidecar: {message}"))
                })?;
                Ok((Sidecar::clone(sidecar), Vec::new()))
            }
            (None, Place::File(path)) => Sidecar::of(path),
            (None, _) => Ok(Default::default()),
        }
    }
}

impl<P: AsRef<Path>> From<P> for LogSource {
    fn from(path: P) -> LogSource {
        let path = path.as_ref();
        LogSource::at(path.display().to_string(), Place::File(path.to_path_buf()))
    }
}

impl From<Table> for LogSource {
    fn from(table: Table) -> LogSource {
        LogSource::at(table.name().to_string(), Place::Table(Arc::new(table)))
    }
}

impl From<&LogSource> for LogSource {
    fn from(source: &LogSource) -> LogSource {
        source.clone()
    }
}

impl fmt::Debug for LogSource {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_tuple("LogSource").field(&self.name).finish()
    }
}

/// Bytes of a log file, on disk, in memory or on their way.
pub(super) type Stream = Box<dyn Read + Send>;

impl Place {
    /// Start at the first byte, and how many there are, which is not known of a pipe or a stream;
    /// nothing to read of a table.
    fn open(&self) -> io::Result<(Stream, Option<u64>)> {
        match self {
            Place::File(path) => {
                let file = File::open(path)?;
                let about = file.metadata().ok().filter(|about| about.is_file());
                Ok((Box::new(file), about.map(|about| about.len())))
            }
            Place::Bytes(bytes) => {
                let count = bytes.as_ref().len() as u64;
                Ok((Box::new(Cursor::new(bytes.clone())), Some(count)))
            }
            Place::Stream(open) => Ok((open()?, None)),
            Place::Table(_) => Err(io::ErrorKind::Unsupported.into()),
        }
    }
}

/// A file that counts and hashes what is read from it; its clones see that from outside.
#[derive(Clone)]
pub(super) struct Metered {
    /// The file, and bytes that were read of it, with their hash.
    read: Arc<Mutex<(Stream, u64, XxHash64)>>,
    total: Option<u64>,
}

impl Metered {
    /// Start at the first byte of the log called `file`.
    pub fn open(place: &Place, file: &str) -> Result<Metered, Error> {
        let opened = place.open();
        let (stream, total) = opened.map_err(|source| Error::read(file.to_string(), source))?;
        let read = Arc::new(Mutex::new((stream, 0, XxHash64::with_seed(0))));
        Ok(Metered { read, total })
    }

    fn state(&self) -> MutexGuard<'_, (Stream, u64, XxHash64)> {
        self.read.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn progress(&self) -> (u64, Option<u64>) {
        (self.state().1, self.total)
    }

    pub fn hash(&self) -> u64 {
        self.state().2.finish()
    }
}

impl Read for Metered {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let (file, done, hash) = &mut *self.state();
        let n = file.read(buffer)?;
        *done += n as u64;
        hash.write(&buffer[..n]);
        Ok(n)
    }
}

/// Leaves nothing out, also no rows without load on the foot cells.
#[derive(Debug)]
pub(super) struct AllRows;

impl Screen for AllRows {
    fn start(&self) -> Screening {
        Box::new(|_| {})
    }
}

/// What becomes of each block, first row to last.
pub type Screening = Box<dyn FnMut(&mut Block) + Send>;

/// Leaves rows out of a log, or says less of them, whenever it is read.
///
/// A log with a screen may have rows in which nothing stands on the foot cells: their
/// reading is zero, and the screen is to take them out.
pub trait Screen: fmt::Debug + Send + Sync {
    /// Begin a reading of the log.
    fn start(&self) -> Screening;
}
