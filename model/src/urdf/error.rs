//! Why a robot description cannot be used.

use super::limits;
use super::report::{Complaint, one_per_line};

/// A robot description that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// There is no such file.
    #[error("{file}: no such file; give the path of a URDF")]
    Missing {
        /// Its name.
        file: String,
    },
    /// The path is that of a directory.
    #[error("{file}: is a directory; give the path of a URDF file in it")]
    Directory {
        /// Its name.
        file: String,
    },
    /// The file is there, but cannot be read.
    #[error("{file}: cannot be read; check its permissions")]
    Unreadable {
        /// Its name.
        file: String,
        /// Why.
        source: std::io::Error,
    },
    /// All that is wrong with the text, in line order.
    #[error("{}", one_per_line(.0))]
    Faulty(Vec<Complaint>),
}

impl Error {
    /// The file, as the caller named it.
    pub fn file(&self) -> Option<&str> {
        match self {
            Error::Missing { file }
            | Error::Directory { file }
            | Error::Unreadable { file, .. } => Some(file),
            Error::Faulty(complaints) => complaints.first().map(|fault| fault.file.as_str()),
        }
    }

    /// The faults of the text; none when the file could not be read at all.
    pub fn complaints(&self) -> &[Complaint] {
        match self {
            Error::Faulty(complaints) => complaints,
            _ => &[],
        }
    }
}

impl From<Vec<Complaint>> for Error {
    fn from(complaints: Vec<Complaint>) -> Error {
        Error::Faulty(complaints)
    }
}

impl From<Complaint> for Error {
    fn from(complaint: Complaint) -> Error {
        Error::Faulty(vec![complaint])
    }
}

pub(super) fn unreadable(file: &str, source: std::io::Error) -> Error {
    let file = file.to_owned();
    match source.kind() {
        std::io::ErrorKind::NotFound => Error::Missing { file },
        _ => Error::Unreadable { file, source },
    }
}

pub(super) fn too_large(file: &str) -> Error {
    let mebibytes = limits::FILE_BYTES >> 20;
    Error::Faulty(vec![Complaint {
        file: file.to_owned(),
        line: None,
        message: format!(
            "larger than {mebibytes} MiB; a URDF names its meshes, it does not hold them"
        ),
    }])
}

pub(super) fn not_xml(file: &str, error: &roxmltree::Error) -> Error {
    let position = error.pos();
    let text = error.to_string();
    let text = text.replace(&format!(" at {position}"), "");
    Error::Faulty(vec![Complaint {
        file: file.to_owned(),
        line: Some(position.row),
        message: format!(
            "not well-formed XML (column {}): {text}; repair the tag",
            position.col
        ),
    }])
}
