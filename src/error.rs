//! What can go wrong on the command line, each with its remedy.

use std::io;

/// Bad input or usage (exit code 2).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A URDF or model file that cannot be used.
    #[error(transparent)]
    Model(#[from] sesc_model::Error),
    /// Code that cannot be generated.
    #[error(transparent)]
    Codegen(#[from] sesc_codegen::Error),
    /// Logs or settings that cannot be used.
    #[error("{}", .0.worded(crate::words::option))]
    Identify(#[from] sesc_identify::Error),
    /// The independent reader refuses the URDF.
    #[error("the reference cannot read the robot")]
    Reference(#[from] sesc_reference::Error),
    /// Standard output is closed or full.
    #[error("cannot write to standard output")]
    Stdout(#[source] io::Error),
    /// Options that do not go together, in a sentence with the remedy.
    #[error("{0}")]
    Usage(String),
    /// A fault of the file of a robot's own settings, with the remedy.
    #[error("{file}{}: {reason}", .line.map_or(String::new(), |line| format!(":{line}")))]
    Settings {
        /// The file.
        file: String,
        /// The line, from 1.
        line: Option<u64>,
        /// What is wrong.
        reason: String,
    },
    /// A page that cannot be made of its template.
    #[error("cannot render the report")]
    Report(#[source] Box<dyn std::error::Error + Send + Sync>),
}

impl From<minijinja::Error> for Error {
    fn from(error: minijinja::Error) -> Error {
        Error::Report(Box::new(error))
    }
}

impl Error {
    /// One word for programs: `usage`, `model`, `log`, `read`, `write` and the other kinds of
    /// the libraries.
    pub fn kind(&self) -> &'static str {
        match self {
            Error::Model(error) => match error.kind() {
                sesc_model::ErrorKind::Read => "read",
                sesc_model::ErrorKind::Write => "write",
                _ => "model",
            },
            Error::Stdout(_) => "write",
            Error::Reference(_) => "model",
            Error::Codegen(error) => error.kind().name(),
            Error::Identify(error) => error.kind().name(),
            Error::Usage(_) | Error::Settings { .. } => "usage",
            Error::Report(_) => "internal",
        }
    }

    /// The file with the fault.
    pub fn file(&self) -> Option<&str> {
        match self {
            Error::Identify(error) => error.file(),
            Error::Settings { file, .. } => Some(file),
            _ => self.model()?.file(),
        }
    }

    /// The line or row with the fault, from 1.
    pub fn line(&self) -> Option<u64> {
        match self {
            Error::Identify(error) => error.line(),
            Error::Settings { line, .. } => *line,
            _ => self.model()?.line(),
        }
    }

    fn model(&self) -> Option<&sesc_model::Error> {
        match self {
            Error::Model(error) => Some(error),
            Error::Codegen(error) => error.model(),
            _ => None,
        }
    }
}
