//! What is wrong with files of a fleet.

use serde::{Deserialize, Serialize};

use crate::robot::Robot;
use crate::{Error, ErrorKind};

/// A log, or a group, that came to nothing or to less than it should.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Failed {
    /// The file.
    pub input: String,
    /// What is wrong with it.
    pub error: String,
}

/// What rows and parts say of an error: the URDF by its hash and not by its path, on which nothing
/// of a row depends.
pub(super) fn without_path(error: &Error, robot: &Robot) -> String {
    let said = error.to_string();
    let about = &robot.description;
    match said.strip_prefix(&about.file) {
        Some(rest) if error.model().is_some() && !about.file.is_empty() => {
            format!("{}{rest}", name_of_urdf(&about.hash))
        }
        _ => said,
    }
}

/// What messages call the URDF of this hash: the same wherever the file is.
pub(super) fn name_of_urdf(hash: &str) -> String {
    format!("URDF {}", hash.get(..12).unwrap_or(hash))
}

/// An error of reading, with what the system says of it.
pub(super) fn with_cause(error: &Error) -> String {
    match std::error::Error::source(error) {
        Some(cause) if error.kind() == ErrorKind::Read => format!("{error}: {cause}"),
        _ => error.to_string(),
    }
}
