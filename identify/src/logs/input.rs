//! Where a log is: a file, the bytes of one, or a table in memory.

use std::fs::File;
use std::hash::Hasher as _;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bytes::Bytes;
use sesc_model::files::Stamp;
use twox_hash::XxHash64;

use super::settings::Sidecar;
use super::table::Table;
use crate::{Error, Message};

/// A posture log that can be opened, as often as needed.
///
/// A path, or a path-like value, is a log on disk; its sidecar is looked for
/// beside it. A [`Table`] or the bytes of a file have the sidecar they are given.
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
#[derive(Debug, Clone)]
pub struct LogSource {
    name: String,
    pub(super) place: Place,
    sidecar: Option<Arc<Sidecar>>,
    /// What its file has to be, where it was read already.
    was: Option<Stamp>,
}

/// Bytes of a pipe, at most.
const LONGEST_PIPE: u64 = 1 << 29;

/// Where the rows are.
#[derive(Debug, Clone)]
pub(super) enum Place {
    File(PathBuf),
    Bytes(Bytes),
    Table(Arc<Table>),
}

impl LogSource {
    /// The bytes of a log file of any format; `name` stands for the file in messages.
    pub fn bytes(name: impl Into<String>, bytes: impl AsRef<[u8]> + Send + 'static) -> LogSource {
        LogSource::at(name.into(), Place::Bytes(Bytes::from_owner(bytes)))
    }

    fn at(name: String, place: Place) -> LogSource {
        LogSource {
            name,
            place,
            sidecar: None,
            was: None,
        }
    }

    /// The same log with this sidecar, instead of the one beside its file.
    pub fn with_sidecar(mut self, sidecar: Sidecar) -> LogSource {
        self.sidecar = Some(Arc::new(sidecar));
        self
    }

    /// The same log, as several readings see it: a pipe is read to its end now, into memory; a file
    /// is refused from now on if it is not what it is now.
    ///
    /// # Errors
    /// When the file cannot be opened or read; a pipe of more than 512 MiB.
    #[doc(hidden)]
    pub fn unchanged(self) -> Result<LogSource, Error> {
        if let Place::File(path) = &self.place
            && path.exists()
            && !path.is_file()
            && !path.is_dir()
        {
            let (sidecar, _) = self.sidecar()?;
            let failed = |source| Error::read(self.name.clone(), source);
            let mut bytes = Vec::new();
            let mut pipe = File::open(path).map_err(failed)?.take(LONGEST_PIPE + 1);
            pipe.read_to_end(&mut bytes).map_err(failed)?;
            if bytes.len() as u64 > LONGEST_PIPE {
                let message = "a pipe of more than 512 MiB; write the log to a file, and give that";
                return Err(Error::log(self.name.clone(), None, message));
            }
            return Ok(LogSource::bytes(self.name, bytes).with_sidecar(sidecar));
        }
        let was = self.watched()?.map(|(_, stamp)| stamp);
        Ok(LogSource { was, ..self })
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
            Place::Bytes(_) | Place::Table(_) => true,
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
            Place::Bytes(bytes) => Some(bytes),
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
        LogSource::at(table.name.clone(), Place::Table(Arc::new(table)))
    }
}

impl From<&LogSource> for LogSource {
    fn from(source: &LogSource) -> LogSource {
        source.clone()
    }
}

type Stream = Box<dyn Read + Send>;

/// A file that counts and hashes what is read from it; its clones see that from outside.
#[derive(Clone)]
pub(super) struct Metered {
    /// The file, and bytes that were read of it, with their hash.
    read: Arc<Mutex<(Stream, u64, XxHash64)>>,
    total: Option<u64>,
}

impl Metered {
    /// Start at the first byte of a log; of a pipe it is not known how many there are, and a table
    /// has none.
    ///
    /// # Errors
    /// A file that cannot be opened, as [`Error::of_log`] completes it.
    pub(super) fn open(place: &Place) -> Result<Metered, Error> {
        let (stream, total): (Stream, _) = match place {
            Place::File(path) => {
                let file = File::open(path).map_err(Error::unread)?;
                let about = file.metadata().ok().filter(|about| about.is_file());
                (Box::new(file), about.map(|about| about.len()))
            }
            Place::Bytes(bytes) => {
                let count = bytes.len() as u64;
                (Box::new(Cursor::new(bytes.clone())), Some(count))
            }
            Place::Table(_) => return Err(Error::unread(io::ErrorKind::Unsupported.into())),
        };
        let read = Arc::new(Mutex::new((stream, 0, XxHash64::with_seed(0))));
        Ok(Metered { read, total })
    }

    fn state(&self) -> MutexGuard<'_, (Stream, u64, XxHash64)> {
        self.read.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn progress(&self) -> (u64, Option<u64>) {
        (self.state().1, self.total)
    }

    pub(super) fn hash(&self) -> u64 {
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
