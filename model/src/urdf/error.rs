//! Why a robot description cannot be used.

use super::limits;
use super::report::{Complaint, one_per_line};

/// A robot description that cannot be used.
///
/// ```
/// use sesc_model::urdf::{ErrorKind, parse};
///
/// let text = r#"<robot name="r">
///   <link name="foot"><inertial><mass value="much"/></inertial></link>
/// </robot>"#;
/// let error = parse(text, "r.urdf").unwrap_err();
/// assert_eq!(error.kind(), ErrorKind::Faulty);
/// assert_eq!(error.complaints()[0].line, Some(2));
/// ```
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct Error(Problem);

/// What an [`Error`] is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// There is no such file.
    Missing,
    /// The path is that of a directory.
    Directory,
    /// The file is there, but cannot be read.
    Unreadable,
    /// The text has faults: [`Error::complaints`] lists them.
    Faulty,
}

#[derive(Debug, thiserror::Error)]
enum Problem {
    #[error("{file}: no such file; give the path of a URDF")]
    Missing { file: String },
    #[error("{file}: is a directory; give the path of a URDF file in it")]
    Directory { file: String },
    #[error("{file}: cannot be read; check its permissions")]
    Unreadable {
        file: String,
        source: std::io::Error,
    },
    /// All that is wrong with the text, in line order.
    #[error("{}", one_per_line(.0))]
    Faulty(Vec<Complaint>),
}

impl Error {
    /// What it is about.
    pub fn kind(&self) -> ErrorKind {
        match self.0 {
            Problem::Missing { .. } => ErrorKind::Missing,
            Problem::Directory { .. } => ErrorKind::Directory,
            Problem::Unreadable { .. } => ErrorKind::Unreadable,
            Problem::Faulty(_) => ErrorKind::Faulty,
        }
    }

    /// The file, as the caller named it.
    pub fn file(&self) -> Option<&str> {
        match &self.0 {
            Problem::Missing { file }
            | Problem::Directory { file }
            | Problem::Unreadable { file, .. } => Some(file),
            Problem::Faulty(complaints) => complaints.first().map(|fault| fault.file.as_str()),
        }
    }

    /// The faults of the text in line order; none when the file could not be read at all.
    pub fn complaints(&self) -> &[Complaint] {
        match &self.0 {
            Problem::Faulty(complaints) => complaints,
            _ => &[],
        }
    }
}

#[doc(hidden)]
impl From<Vec<Complaint>> for Error {
    fn from(complaints: Vec<Complaint>) -> Error {
        Error(Problem::Faulty(complaints))
    }
}

#[doc(hidden)]
impl From<Complaint> for Error {
    fn from(complaint: Complaint) -> Error {
        Error::from(vec![complaint])
    }
}

pub(super) fn directory(file: String) -> Error {
    Error(Problem::Directory { file })
}

pub(super) fn unreadable(file: &str, source: std::io::Error) -> Error {
    let file = file.to_owned();
    Error(match source.kind() {
        std::io::ErrorKind::NotFound => Problem::Missing { file },
        _ => Problem::Unreadable { file, source },
    })
}

pub(super) fn too_large(file: &str) -> Error {
    let mebibytes = limits::FILE_BYTES >> 20;
    Error::from(Complaint {
        file: file.to_owned(),
        line: None,
        message: format!(
            "larger than {mebibytes} MiB; a URDF names its meshes, it does not hold them"
        ),
    })
}

pub(super) fn not_xml(file: &str, error: &roxmltree::Error) -> Error {
    let position = error.pos();
    let text = error.to_string();
    let text = text.replace(&format!(" at {position}"), "");
    Error::from(Complaint {
        file: file.to_owned(),
        line: Some(position.row),
        message: format!(
            "not well-formed XML (column {}): {text}; repair the tag",
            position.col
        ),
    })
}
