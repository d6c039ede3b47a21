//! What can go wrong from logs to findings, each with its remedy.

use std::io;

/// Bad input or usage (exit code 2).
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error(transparent)]
    Model(#[from] sesc_model::Error),
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
    /// A result cannot be written down.
    #[error("cannot serialise the result")]
    Serialise(#[source] Box<dyn std::error::Error + Send + Sync>),
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
