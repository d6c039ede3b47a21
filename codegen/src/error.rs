//! What can go wrong between a URDF and its code.

use std::error::Error as _;
use std::{fmt, io};

/// A complaint with its remedy.
#[derive(thiserror::Error)]
pub enum Error {
    /// The robot, its support or its model file.
    #[error(transparent)]
    Model(#[from] sesc_model::Error),
    #[error("`{name}` is no name for a Rust module; `{suggestion}` would be")]
    BadName { name: String, suggestion: String },
    #[error("`{name}` is no prefix for C names; `{suggestion}` would be")]
    BadPrefix { name: String, suggestion: String },
    #[error("`{name}` means something else to {layout}; `{suggestion}` would do")]
    TakenName {
        name: String,
        layout: &'static str,
        suggestion: String,
    },
    #[error("{reason}")]
    Servos { reason: String },
    #[error("fixed32: {reason}; use f32 or f64, or give tighter joint limits")]
    Overflow { reason: String },
    #[error(
        "fixed32: {function} divides, clamps or raises to powers, which cannot be had in fixed \
         point; effects with divisions or clamps (cell_gain, backlash) need f32 or f64"
    )]
    NoFixedPoint { function: &'static str },
    #[error(
        "no bound can be proven for {function}: an effect divides by what may be zero, or raises \
         what may be negative to a power; give the effect tighter parameters"
    )]
    UnboundedEffect { function: String },
    #[error(
        "no bound can be proven for {function}: its angles may go beyond what sines are computed \
         for, 1024 rad in f32 and 2^20 rad in f64; give tighter joint limits, or more bits"
    )]
    Unbounded { function: String },
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
    #[error("no support link given; call .support(\"link\")")]
    NoSupport,
    #[error("{variable} is not set; call this from a build script, or use .out_dir(…)")]
    NotABuildScript { variable: &'static str },
    #[error("emitted code does not parse ({reason}); this is a defect of sesc, please report it")]
    Emitted { reason: String },
}

/// As a person reads it, causes below: a build script that ends in `?` shows this.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")?;
        let mut cause = self.source();
        while let Some(inner) = cause {
            write!(f, "\ncaused by: {inner}")?;
            cause = inner.source();
        }
        Ok(())
    }
}
