//! What can go wrong on the command line, each with its remedy.

use std::io;

/// Bad input or usage (exit code 2).
#[derive(Debug, thiserror::Error)]
pub enum Error {
    #[error(transparent)]
    Model(#[from] sesc_model::Error),
    #[error(transparent)]
    Codegen(#[from] sesc_codegen::Error),
    #[error("{}", .0.worded(crate::words::option))]
    Identify(#[from] sesc_identify::Error),
    #[error("the reference cannot read the robot")]
    Reference(#[from] sesc_reference::Error),
    #[error("cannot write to standard output")]
    Stdout(#[source] io::Error),
    #[error("{0}")]
    Usage(String),
    #[error("cannot render the report")]
    Report(#[source] Box<dyn std::error::Error + Send + Sync>),
}
