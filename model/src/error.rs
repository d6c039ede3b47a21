//! What can go wrong between a URDF and the functions of its CoM.

use std::error::Error as _;
use std::{fmt, io};

/// What went wrong, with its remedy.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The robot description has faults.
    #[error(transparent)]
    Urdf(#[from] crate::urdf::Error),
    /// The support link is none of the robot's.
    #[error("{file}: no link `{name}` to stand on; the robot has {links}")]
    UnknownSupport {
        /// The URDF.
        file: String,
        /// The name that was asked for.
        name: String,
        /// Names of the robot's links.
        links: String,
    },
    /// A planar or floating joint has mass on its far side.
    #[error(
        "{kind} joint `{joint}` carries `{link}`, which has mass; a statically equivalent chain \
         needs revolute, continuous, prismatic or fixed joints: fix the joint, or choose a \
         support on the side of the mass"
    )]
    MassBeyondFreeJoint {
        /// The joint.
        joint: String,
        /// `planar` or `floating`.
        kind: &'static str,
        /// A link with mass that it carries.
        link: String,
    },
    /// No link has mass.
    #[error("{file}: the robot has no mass; give at least one link an <inertial> with a <mass>")]
    NoMass {
        /// The URDF.
        file: String,
    },
    /// More joints move than functions can be generated for.
    #[error(
        "{file}: {count} joints move (mimics included), more than {most}; fix those that do not \
         matter, or describe a part of the robot"
    )]
    TooManyJoints {
        /// The URDF.
        file: String,
        /// Joints that move.
        count: usize,
        /// The most that are taken.
        most: usize,
    },
    /// A file cannot be read.
    #[error("cannot read {file}")]
    Read {
        /// The file.
        file: String,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// A file cannot be written.
    #[error("cannot write {file}")]
    Write {
        /// The file.
        file: String,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// A model file has faults, or belongs to another robot.
    #[error("{file}: {reason}")]
    ModelFile {
        /// The model file.
        file: String,
        /// What is wrong with it and what to do.
        reason: String,
    },
}

impl Error {
    /// The file with the fault.
    pub fn file(&self) -> Option<&str> {
        match self {
            Error::Urdf(error) => error.file(),
            Error::UnknownSupport { file, .. }
            | Error::NoMass { file }
            | Error::TooManyJoints { file, .. }
            | Error::Read { file, .. }
            | Error::Write { file, .. }
            | Error::ModelFile { file, .. } => Some(file),
            Error::MassBeyondFreeJoint { .. } => None,
        }
    }

    /// The line of the first fault, from 1.
    pub fn line(&self) -> Option<u64> {
        match self {
            Error::Urdf(error) => {
                let lines = error.complaints().iter().find_map(|fault| fault.line);
                lines.map(u64::from)
            }
            _ => None,
        }
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
