//! What is wrong with files of a fleet.

use serde::{Deserialize, Serialize};

use crate::{Error, ErrorKind};

/// A log, or a group, that came to nothing or to less than it should.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Failed {
    /// The file.
    pub input: String,
    /// What is wrong with it.
    pub error: String,
}

/// An error of reading, with what the system says of it.
pub(super) fn with_cause(error: &Error) -> String {
    match std::error::Error::source(error) {
        Some(cause) if error.kind() == ErrorKind::Read => format!("{error}: {cause}"),
        _ => error.to_string(),
    }
}
