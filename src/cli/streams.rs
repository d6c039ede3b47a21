//! `-`: standard input and output where a file could stand.
//!
//! Standard input is a URDF or a log, once; standard output takes a log, a table of predictions
//! or a model file. Elsewhere `-` is an error, and never a file of that name, which is `./-`.

use std::io::{self, BufWriter, Read as _, Stdout};
use std::path::Path;

use sesc_identify::logs::LogSource;

use crate::Error;

/// What messages call standard input.
const INPUT: &str = "standard input";
/// What messages call standard output.
pub(super) const OUTPUT: &str = "standard output";

/// Largest log that is taken from standard input, MiB: it is held in memory.
const MOST: u64 = 1024;

/// Whether a path stands for standard input or output.
pub(super) fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// The log at `path`: `-` is read whole, its format is told by its first bytes as that of a file,
/// and it has no sidecar.
///
/// # Errors
/// When standard input cannot be read, or is larger than [`MOST`].
pub(super) fn log(path: &Path) -> Result<LogSource, Error> {
    if !is_standard(path) {
        return Ok(LogSource::from(path));
    }
    let most = MOST << 20;
    let mut bytes = Vec::new();
    let read = io::stdin().lock().take(most + 1).read_to_end(&mut bytes);
    read.map_err(|source| Error::Usage(format!("{INPUT} cannot be read: {source}")))?;
    if bytes.len() as u64 > most {
        return Err(Error::Usage(format!(
            "{INPUT} has more than {} MiB; write the log to a file, which is read in blocks",
            MOST
        )));
    }
    Ok(LogSource::bytes(INPUT, bytes))
}

/// Standard output, for whole files.
pub(super) fn output() -> BufWriter<Stdout> {
    BufWriter::with_capacity(1 << 16, io::stdout())
}

/// Whether an error says that nobody reads standard output any more.
pub(super) fn is_closed(error: &Error) -> bool {
    let mut cause: Option<&(dyn std::error::Error + 'static)> = Some(error);
    let mut broken = false;
    while let Some(inner) = cause {
        let io = inner.downcast_ref::<io::Error>();
        broken |= io.is_some_and(|io| io.kind() == io::ErrorKind::BrokenPipe);
        cause = inner.source();
    }
    // A pipe that is written by its name is a file of the user's.
    broken && (matches!(error, Error::Stdout(_)) || error.to_string().contains(OUTPUT))
}
