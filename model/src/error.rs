//! What can go wrong between a URDF and the functions of its CoM.

use std::error::Error as _;
use std::{fmt, io};

use crate::urdf;

/// Why no functions come of a robot: a sentence with its remedy, and what caused it.
///
/// ```
/// use sesc_model::{Error, ErrorKind, urdf};
///
/// let error = Error::from(urdf::parse("<robot name=\"r\"/>", "r.urdf").unwrap_err());
/// assert_eq!(error.kind(), ErrorKind::Urdf);
/// assert_eq!(error.file(), Some("r.urdf"));
/// ```
pub struct Error(Box<Problem>);

/// What an [`Error`] is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The robot description has faults, or cannot be read: [`Error::urdf`] says which.
    Urdf,
    /// The support link is none of the robot's.
    UnknownSupport,
    /// A planar or floating joint has mass on its far side.
    MassBeyondFreeJoint,
    /// No link has mass.
    NoMass,
    /// More joints move than functions can be generated for.
    TooManyJoints,
    /// A file cannot be read.
    Read,
    /// A file cannot be written.
    Write,
    /// A model file has faults, or belongs to another robot.
    ModelFile,
}

impl Error {
    /// What it is about.
    pub fn kind(&self) -> ErrorKind {
        match *self.0 {
            Problem::Urdf(_) => ErrorKind::Urdf,
            Problem::UnknownSupport { .. } | Problem::NoHeight { .. } => ErrorKind::UnknownSupport,
            Problem::MassBeyondFreeJoint { .. } => ErrorKind::MassBeyondFreeJoint,
            Problem::NoMass { .. } => ErrorKind::NoMass,
            Problem::TooManyJoints { .. } => ErrorKind::TooManyJoints,
            Problem::Read { .. } => ErrorKind::Read,
            Problem::Write { .. } => ErrorKind::Write,
            Problem::ModelFile { .. } => ErrorKind::ModelFile,
        }
    }

    /// What is wrong with the robot description, if it is that.
    pub fn urdf(&self) -> Option<&urdf::Error> {
        match &*self.0 {
            Problem::Urdf(error) => Some(error),
            _ => None,
        }
    }

    /// The file with the fault.
    pub fn file(&self) -> Option<&str> {
        match &*self.0 {
            Problem::Urdf(error) => error.file(),
            Problem::UnknownSupport { file, .. }
            | Problem::NoMass { file }
            | Problem::TooManyJoints { file, .. }
            | Problem::Read { file, .. }
            | Problem::Write { file, .. }
            | Problem::ModelFile { file, .. } => Some(file),
            Problem::NoHeight { .. } | Problem::MassBeyondFreeJoint { .. } => None,
        }
    }

    /// The line of the first fault, from 1.
    pub fn line(&self) -> Option<u64> {
        if let Problem::ModelFile { line, .. } = &*self.0 {
            return *line;
        }
        let faults = self.urdf()?.complaints();
        faults.iter().find_map(|fault| fault.line).map(u64::from)
    }

    /// What is wrong with the model file `file`.
    #[doc(hidden)]
    pub fn model_file(file: impl Into<String>, reason: impl Into<String>) -> Error {
        let (file, reason) = (file.into(), reason.into());
        let line = None;
        Problem::ModelFile { file, line, reason }.into()
    }
}

impl From<Problem> for Error {
    fn from(problem: Problem) -> Error {
        Error(Box::new(problem))
    }
}

impl From<urdf::Error> for Error {
    fn from(error: urdf::Error) -> Error {
        Problem::Urdf(error).into()
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.0.source()
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
pub(crate) enum Problem {
    /// The robot description has faults.
    #[error(transparent)]
    Urdf(urdf::Error),
    /// The support link is none of the robot's.
    #[error("{file}: no link `{name}` to stand on; the robot has {links}")]
    UnknownSupport {
        file: String,
        name: String,
        links: String,
    },
    /// The height of a sole is none, or has a shorter spelling.
    #[error(
        "`{support}` is no sole: write the height of the link's frame above it in mm, with the \
         digits it needs, such as `{meant}`"
    )]
    NoHeight { support: String, meant: String },
    /// A planar or floating joint has mass on its far side.
    #[error(
        "{kind} joint `{joint}` carries `{link}`, which has mass; a statically equivalent chain \
         needs revolute, continuous, prismatic or fixed joints: fix the joint, or choose a \
         support on the side of the mass"
    )]
    MassBeyondFreeJoint {
        joint: String,
        kind: &'static str,
        link: String,
    },
    /// No link has mass.
    #[error("{file}: the robot has no mass; give at least one link an <inertial> with a <mass>")]
    NoMass { file: String },
    /// More joints move than functions can be generated for.
    #[error(
        "{file}: {count} joints move (mimics included), more than {most}{}; fix those that do not \
         matter, or describe a part of the robot",
        if *tied { " for a robot in which joints follow others" } else { "" }
    )]
    TooManyJoints {
        file: String,
        count: usize,
        most: usize,
        tied: bool,
    },
    /// A file cannot be read.
    #[error("cannot read {file}")]
    Read {
        file: String,
        #[source]
        source: io::Error,
    },
    /// A file cannot be written.
    #[error("cannot write {file}")]
    Write {
        file: String,
        #[source]
        source: io::Error,
    },
    /// A model file has faults, or belongs to another robot.
    #[error("{file}: {reason}")]
    ModelFile {
        file: String,
        line: Option<u64>,
        reason: String,
    },
}
