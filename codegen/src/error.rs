//! What can go wrong between a URDF and its code.

use std::error::Error as _;
use std::{fmt, io};

/// Why no code came of a robot: a sentence with its remedy, and what caused it.
///
/// ```
/// use sesc_codegen::{Builder, ErrorKind};
///
/// let error = Builder::new("no_such.urdf").support("foot").out_dir(".").emit().unwrap_err();
/// assert_eq!(error.kind(), ErrorKind::Model);
/// assert_eq!(error.to_string(), "no_such.urdf: no such file; give the path of a URDF");
/// ```
#[derive(thiserror::Error)]
#[error(transparent)]
pub struct Error(Box<Problem>);

/// What an [`Error`] is about.
///
/// ```
/// use sesc_codegen::{Builder, ErrorKind};
///
/// let error = Builder::new("op2.urdf").emit().unwrap_err();
/// assert_eq!(error.kind(), ErrorKind::NoSupport);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The robot, its support link or its model file.
    Model,
    /// A name that Rust, C or a build system does not take.
    Name,
    /// A servo file, or a setting in it.
    Servos,
    /// A quantity or an operation that 32-bit fixed point cannot have.
    FixedPoint,
    /// A number of lanes that there is not.
    Lanes,
    /// A function that there is not, or that another needs.
    Functions,
    /// A function whose rounding error has no proven bound.
    Unbounded,
    /// A file that cannot be read.
    Read,
    /// A file or folder that cannot be written.
    Write,
    /// No support link was given.
    NoSupport,
    /// There is no `OUT_DIR` to write into.
    NotABuildScript,
    /// A defect of this crate.
    Internal,
}

impl Error {
    /// What it is about.
    ///
    /// ```
    /// let error = sesc_codegen::Builder::new("op2.urdf").emit().unwrap_err();
    /// assert_eq!(error.kind(), sesc_codegen::ErrorKind::NoSupport);
    /// ```
    pub fn kind(&self) -> ErrorKind {
        match *self.0 {
            Problem::Model(ref error) => match error.kind() {
                sesc_model::ErrorKind::Write => ErrorKind::Write,
                _ => ErrorKind::Model,
            },
            Problem::BadName { .. }
            | Problem::BadPrefix { .. }
            | Problem::LongName { .. }
            | Problem::TakenName { .. } => ErrorKind::Name,
            Problem::Servos { .. } => ErrorKind::Servos,
            Problem::Overflow { .. }
            | Problem::NoFixedPoint { .. }
            | Problem::EstimatorInFixed
            | Problem::LanesInFixed => ErrorKind::FixedPoint,
            Problem::Lanes { .. } => ErrorKind::Lanes,
            Problem::NoFunction { .. } | Problem::EstimatorWithoutRows => ErrorKind::Functions,
            Problem::UnboundedEffect { .. }
            | Problem::Unbounded { .. }
            | Problem::NotFinite { .. } => ErrorKind::Unbounded,
            Problem::Read { .. } => ErrorKind::Read,
            Problem::NoSupport => ErrorKind::NoSupport,
            Problem::NotABuildScript { .. } => ErrorKind::NotABuildScript,
            Problem::Emitted { .. } => ErrorKind::Internal,
        }
    }
}

impl ErrorKind {
    /// One word, stable: for programs that read it.
    ///
    /// ```
    /// let error = sesc_codegen::Builder::new("op2.urdf").emit().unwrap_err();
    /// assert_eq!(error.kind().name(), "request");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            ErrorKind::Model => "model",
            ErrorKind::Name => "name",
            ErrorKind::Servos => "servos",
            ErrorKind::FixedPoint => "fixed_point",
            ErrorKind::Lanes
            | ErrorKind::Functions
            | ErrorKind::NoSupport
            | ErrorKind::NotABuildScript => "request",
            ErrorKind::Unbounded => "unbounded",
            ErrorKind::Read => "read",
            ErrorKind::Write => "write",
            ErrorKind::Internal => "internal",
        }
    }
}

impl Error {
    /// What is wrong with the robot or its model file, if it is that.
    ///
    /// ```
    /// use sesc_codegen::Builder;
    ///
    /// let missing = Builder::new("no_such.urdf").support("foot").out_dir(".").emit().unwrap_err();
    /// assert!(missing.model().is_some());
    /// let no_support = Builder::new("op2.urdf").emit().unwrap_err();
    /// assert!(no_support.model().is_none());
    /// ```
    pub fn model(&self) -> Option<&sesc_model::Error> {
        match &*self.0 {
            Problem::Model(error) => Some(error),
            _ => None,
        }
    }
}

impl From<Problem> for Error {
    fn from(problem: Problem) -> Error {
        Error(Box::new(problem))
    }
}

impl From<sesc_model::Error> for Error {
    fn from(error: sesc_model::Error) -> Error {
        Problem::Model(error).into()
    }
}

/// Shows the message and its causes as text: a build script that ends in `?` shows this.
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

/// What went wrong, with all that its sentence names.
#[derive(Debug, thiserror::Error)]
#[cfg_attr(not(feature = "c99"), allow(dead_code, reason = "some are of C alone"))]
pub(crate) enum Problem {
    /// The robot, its support or its model file.
    #[error(transparent)]
    Model(sesc_model::Error),
    #[error("`{name}` is no name for a Rust module; `{suggestion}` would be")]
    BadName { name: String, suggestion: String },
    #[error("`{name}` is no prefix for C names; `{suggestion}` would be")]
    BadPrefix { name: String, suggestion: String },
    #[error(
        "`{name}` has {length} characters, and {longest} are the most for the names of files; \
         give a name of your own, such as `{suggestion}`"
    )]
    LongName {
        name: String,
        length: usize,
        longest: usize,
        suggestion: String,
    },
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
        "fixed32: {function} divides or raises to powers, which cannot be had in fixed \
         point; effects that divide or raise to powers (those of cells) need f32 or f64"
    )]
    NoFixedPoint { function: &'static str },
    #[error(
        "a constant of {function} is not finite in this scalar: an effect of the model file, or \
         a length of the URDF, has a value that no robot has"
    )]
    NotFinite { function: &'static str },
    #[error("fixed32: the estimator needs the range of floats; use f32 or f64, or leave it out")]
    EstimatorInFixed,
    #[error(
        "there is no function `{name}`; known are {known}, and correct_cop comes along where the \
         model has effects of the sensor"
    )]
    NoFunction { name: String, known: String },
    #[error(
        "the estimator calls regressor_cop; name it among the functions, or leave the estimator out"
    )]
    EstimatorWithoutRows,
    #[error("functions of many postures have 4, 8 or 16 lanes at most, not {lanes}")]
    Lanes { lanes: u32 },
    #[error("fixed32: functions of many postures are of floats; use f32 or f64, or no lanes")]
    LanesInFixed,
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
    #[error("no support link given; call .support(\"link\")")]
    NoSupport,
    #[error("{variable} is not set; call this from a build script, or use .out_dir(…)")]
    NotABuildScript { variable: &'static str },
    #[error("emitted code does not parse ({reason}); this is a defect of sesc, please report it")]
    Emitted { reason: String },
}
