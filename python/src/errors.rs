//! The library's errors as exceptions of the package.
//!
//! ```text
//! kind of the error, and what was being done ─▶ class     sentence, file, line, complaints ─▶ fields
//! ```

use std::path::Path;

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use sesc_identify::{Error, ErrorKind, Setting};
use sesc_model::{Error as ModelError, ErrorKind as ModelErrorKind, urdf};

/// What was being done: it names the class of errors that say nothing of their own, `Log` that of
/// a `LogError`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Doing {
    Urdf,
    Support,
    Log,
    Prior,
    ModelFile,
    Fit,
    Plan,
    Part,
    /// Everything else.
    Sesc,
    /// An argument cannot be.
    Argument,
    /// An argument is of another type.
    ArgumentType,
    /// A defect of the package.
    Internal,
}

/// Results of the libraries whose errors become exceptions.
pub(crate) trait During<T> {
    /// The result of a call that was `doing` something.
    fn during(self, doing: Doing) -> Result<T, Failure>;
}

impl<T, E: Into<sesc::Error>> During<T> for Result<T, E> {
    fn during(self, doing: Doing) -> Result<T, Failure> {
        self.map_err(|error| Failure::of(error, doing))
    }
}

/// An error on its way to Python.
#[derive(Debug)]
pub struct Failure(Box<About>);

#[derive(Debug)]
struct About {
    class: Doing,
    message: String,
    file: Option<String>,
    line: Option<u64>,
    column: Option<String>,
    /// Name of the exception that Python has for it, and its `errno`.
    system: Option<i32>,
    complaints: Vec<(Option<u32>, String)>,
}

impl Failure {
    /// An error while `doing` something.
    pub fn of(error: impl Into<sesc::Error>, doing: Doing) -> Failure {
        match error.into() {
            sesc::Error::Identify(error) => Failure::of_library(&error, doing),
            sesc::Error::Model(error) => Failure::of_library(&error.into(), doing),
            sesc::Error::Codegen(error) => Failure::caused(Doing::Sesc, &error),
            sesc::Error::Reference(error) => Failure::caused(Doing::Urdf, &error),
            other => Failure::plain(doing, other.to_string()),
        }
    }

    /// An error that has no place, with its causes.
    fn caused(doing: Doing, error: &dyn std::error::Error) -> Failure {
        Failure::plain(doing, sentence(error.to_string(), error.source()))
    }

    fn of_library(error: &Error, doing: Doing) -> Failure {
        let class = match (error.kind(), error.model()) {
            (_, Some(model)) => class_of_model(model, doing),
            (ErrorKind::Log, _) if doing != Doing::Part => Doing::Log,
            (ErrorKind::Prior, _) => Doing::Prior,
            (ErrorKind::Read | ErrorKind::Unsupported, _) if doing == Doing::Fit => Doing::Log,
            (ErrorKind::Write, _) => Doing::Sesc,
            (ErrorKind::Serialise, _) => Doing::Internal,
            _ => doing,
        };
        Failure(Box::new(About {
            class,
            message: sentence(error.worded(keyword), std::error::Error::source(error)),
            file: error.file().map(str::to_string),
            line: error.line(),
            column: error.column().map(str::to_string),
            system: system_of(error),
            complaints: error.model().map(complaints).unwrap_or_default(),
        }))
    }

    /// A defect of the package.
    pub fn internal(message: impl std::fmt::Display) -> Failure {
        Failure::plain(Doing::Internal, message.to_string())
    }

    /// `path` cannot be read.
    pub fn unreadable(doing: Doing, path: &Path, error: &std::io::Error) -> Failure {
        let file = path.display().to_string();
        let mut failure = Failure::plain(doing, format!("cannot read {file}: {error}"));
        failure.0.system = error.raw_os_error();
        failure.0.file = Some(file);
        failure
    }

    /// A sentence without a place.
    pub fn plain(doing: Doing, message: impl Into<String>) -> Failure {
        Failure(Box::new(About {
            class: doing,
            message: message.into(),
            file: None,
            line: None,
            column: None,
            system: None,
            complaints: Vec::new(),
        }))
    }

    /// The exception.
    pub fn raise(self, py: Python<'_>) -> PyErr {
        static MAKE: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        let make = MAKE.import(py, "sesc._errors", "make");
        let made = make.and_then(|make| {
            let of = *self.0;
            let class = format!("{:?}Error", of.class);
            let place = (of.file, of.line, of.column);
            make.call1((class, of.message, place, of.system, of.complaints))
        });
        made.map_or_else(|error| error, PyErr::from_value)
    }
}

fn class_of_model(error: &ModelError, doing: Doing) -> Doing {
    match error.kind() {
        ModelErrorKind::Urdf | ModelErrorKind::NoMass => Doing::Urdf,
        ModelErrorKind::UnknownSupport | ModelErrorKind::MassBeyondFreeJoint => Doing::Support,
        ModelErrorKind::ModelFile => Doing::ModelFile,
        _ => doing,
    }
}

fn complaints(error: &ModelError) -> Vec<(Option<u32>, String)> {
    let complaints = error.urdf().map_or(&[][..], urdf::Error::complaints);
    let of = |complaint: &urdf::Complaint| (complaint.line, complaint.message.clone());
    complaints.iter().map(of).collect()
}

/// A sentence and what caused it, which a person has to read together.
fn sentence(mut text: String, mut cause: Option<&(dyn std::error::Error + 'static)>) -> String {
    while let Some(inner) = cause {
        let said = inner.to_string();
        if !text.contains(&said) {
            text = format!("{text}: {said}");
        }
        cause = inner.source();
    }
    text
}

/// The number that the system gives to why a file cannot be read or written.
fn system_of(error: &Error) -> Option<i32> {
    let urdf = error.model().and_then(ModelError::urdf);
    if urdf.is_some_and(|error| error.kind() == urdf::ErrorKind::Missing) {
        return Some(NO_SUCH_FILE);
    }
    let mut cause = std::error::Error::source(error);
    while let Some(inner) = cause {
        if let Some(io) = inner.downcast_ref::<std::io::Error>() {
            return io.raw_os_error().or(match io.kind() {
                std::io::ErrorKind::NotFound => Some(NO_SUCH_FILE),
                _ => None,
            });
        }
        cause = inner.source();
    }
    None
}

/// `errno.ENOENT` on every system that Python runs on.
const NO_SUCH_FILE: i32 = 2;

/// What Python's users call a setting.
pub(crate) fn keyword(setting: Setting) -> String {
    match setting {
        Setting::Angles => "`angles=\"deg\"`".to_string(),
        Setting::Columns => "give `columns=` these pairs:".to_string(),
        Setting::Snapping => "`snap=False`".to_string(),
        Setting::Data => "`sesc.Log`".to_string(),
        Setting::Partial => "`sesc.gather`".to_string(),
        Setting::Feature(name) => format!("a build with the feature `{name}`"),
        other => format!("`{}`", other.name()),
    }
}
