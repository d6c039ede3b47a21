//! What can go wrong on the command line, each with its remedy.

use std::io;

/// Bad input or usage (exit code 2).
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error(transparent)]
    Codegen(#[from] sesc_codegen::Error),
    #[error("the reference cannot read the robot")]
    Reference(#[from] sesc_reference::Error),
    #[error("cannot read {file}")]
    Read {
        file: String,
        #[source]
        source: io::Error,
    },
    #[error("cannot write {file}")]
    Write {
        file: String,
        #[source]
        source: io::Error,
    },
    #[error("cannot write to standard output")]
    Stdout(#[source] io::Error),
    /// A fault in a posture log or its sidecar.
    #[error("{file}{}: {message}", .line.map(|line| format!(":{line}")).unwrap_or_default())]
    Log {
        file: String,
        line: Option<u64>,
        message: String,
    },
    /// A fault in a file of tolerances.
    #[error("{reason}")]
    Prior { reason: String },
    #[error("{0}")]
    Usage(String),
    #[error("cannot render the report")]
    Report(#[source] Box<dyn std::error::Error + Send + Sync>),
}

impl Error {
    /// `file` is of a format that this build leaves out.
    #[cfg(not(all(feature = "parquet", feature = "mcap")))]
    pub(crate) fn without(feature: &str, format: &str, file: &str) -> Error {
        Error::Usage(format!(
            "{file}: built without {format}; `cargo install --features {feature}` adds it"
        ))
    }
}
