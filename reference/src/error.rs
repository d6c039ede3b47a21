//! What can be wrong with a file or a request: each names the thing at fault
//! and, where there is one, the remedy.

use std::path::PathBuf;

/// Why a robot could not be read, stood on a link or bent: a sentence with its remedy.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct Error(Box<Problem>);

/// What an [`Error`] is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The file could not be opened or read.
    File,
    /// The text is not XML.
    Xml,
    /// The outermost element is not `<robot>`.
    NotARobot,
    /// There are no links.
    NoLinks,
    /// An attribute holds something else than the numbers it should.
    Number,
    /// urdf-rs gives up on the text.
    Urdf,
    /// A joint type that the reference does not move.
    Spherical,
    /// The axis of a moving joint has no direction.
    ZeroAxis,
    /// A quaternion is not four numbers, or zero.
    NoQuaternion,
    /// Both spellings of an orientation are present.
    TwoOrientations,
    /// A link's mass is negative or not finite.
    Mass,
    /// Two links or two joints share a name.
    Duplicate,
    /// A joint refers to a link that is not there.
    UnknownLinkOfJoint,
    /// Links and joints do not form one tree.
    NotATree,
    /// A mimic joint follows a joint that is not there.
    UnknownMaster,
    /// A mimic joint follows a joint without a single coordinate.
    FreeMaster,
    /// Mimic joints follow each other in a circle.
    MimicCircle,
    /// The link asked for is not in the robot.
    UnknownLink,
    /// The joint asked for is not one of the coordinates.
    UnknownJoint,
    /// Mass hangs on a joint whose position is not among the coordinates.
    MassBeyondFreeJoint,
    /// No link has any mass.
    NoMass,
    /// A payload takes away all of a link or more.
    Payload,
    /// Gravity does not press the robot onto its support plane.
    Gravity,
    /// A joint without an encoder was asked for as if it had one.
    HiddenJoint,
    /// A number that only makes sense above zero.
    Value,
    /// The cells of a sole cannot carry a load anywhere between them.
    Cells,
    /// A cell that is not there.
    UnknownCell,
    /// An imperfection that the virtual robot does not know, or not there or of such values.
    UnknownImperfection,
}

impl Error {
    /// What it is about.
    pub fn kind(&self) -> ErrorKind {
        match *self.0 {
            Problem::File { .. } => ErrorKind::File,
            Problem::Xml(_) => ErrorKind::Xml,
            Problem::NotARobot { .. } => ErrorKind::NotARobot,
            Problem::NoLinks => ErrorKind::NoLinks,
            Problem::Number { .. } => ErrorKind::Number,
            Problem::Urdf(_) => ErrorKind::Urdf,
            Problem::Spherical { .. } => ErrorKind::Spherical,
            Problem::ZeroAxis { .. } => ErrorKind::ZeroAxis,
            Problem::NoQuaternion { .. } => ErrorKind::NoQuaternion,
            Problem::TwoOrientations { .. } => ErrorKind::TwoOrientations,
            Problem::Mass { .. } => ErrorKind::Mass,
            Problem::Duplicate { .. } => ErrorKind::Duplicate,
            Problem::UnknownLinkOfJoint { .. } => ErrorKind::UnknownLinkOfJoint,
            Problem::NotATree { .. } => ErrorKind::NotATree,
            Problem::UnknownMaster { .. } => ErrorKind::UnknownMaster,
            Problem::FreeMaster { .. } => ErrorKind::FreeMaster,
            Problem::MimicCircle { .. } => ErrorKind::MimicCircle,
            Problem::UnknownLink { .. } => ErrorKind::UnknownLink,
            Problem::UnknownJoint { .. } => ErrorKind::UnknownJoint,
            Problem::MassBeyondFreeJoint { .. } => ErrorKind::MassBeyondFreeJoint,
            Problem::NoMass => ErrorKind::NoMass,
            Problem::Payload { .. } => ErrorKind::Payload,
            Problem::Gravity { .. } => ErrorKind::Gravity,
            Problem::HiddenJoint { .. } => ErrorKind::HiddenJoint,
            Problem::Value { .. } => ErrorKind::Value,
            Problem::Cells { .. } => ErrorKind::Cells,
            Problem::UnknownCell { .. } => ErrorKind::UnknownCell,
            Problem::UnknownImperfection { .. } => ErrorKind::UnknownImperfection,
        }
    }
}

impl From<Problem> for Error {
    fn from(problem: Problem) -> Error {
        Error(Box::new(problem))
    }
}

/// What went wrong, with all that its sentence names.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Problem {
    /// The file could not be opened or read.
    #[error("cannot read `{}`", path.display())]
    File {
        path: PathBuf,
        source: std::io::Error,
    },
    /// The text is not XML.
    #[error("the URDF is not well-formed XML")]
    Xml(#[source] roxmltree::Error),
    /// The outermost element is not `<robot>`.
    #[error("the outermost element is <{root}>, not <robot>: this is no URDF")]
    NotARobot { root: String },
    /// There are no links.
    #[error("the robot has no links")]
    NoLinks,
    /// An attribute holds something else than the numbers it should.
    #[error("{place}: {attribute}=\"{text}\" does not hold the numbers that it should")]
    Number {
        place: String,
        attribute: &'static str,
        text: String,
    },
    /// urdf-rs gives up on the text.
    #[error("urdf-rs cannot read the URDF")]
    Urdf(#[source] urdf_rs::UrdfError),
    /// A joint type that the reference does not move.
    #[error("joint `{joint}`: type `spherical` is not supported")]
    Spherical { joint: String },
    /// The axis of a moving joint has no direction.
    #[error("joint `{joint}`: axis has no direction; give <axis xyz> a finite one other than zero")]
    ZeroAxis { joint: String },
    /// A quaternion is not four numbers, or zero.
    #[error("{place}: quat_xyzw names no orientation; give four numbers, not all zero")]
    NoQuaternion { place: String },
    /// Both spellings of an orientation are present.
    #[error("{place}: both rpy and quat_xyzw are given; keep one")]
    TwoOrientations { place: String },
    /// A link's mass is negative or not finite.
    #[error("link `{link}`: mass {mass_kg} kg is negative or not finite")]
    Mass { link: String, mass_kg: f64 },
    /// Two links or two joints share a name.
    #[error("{place} appears twice")]
    Duplicate { place: String },
    /// A joint refers to a link that is not there.
    #[error("joint `{joint}`: there is no link `{link}`")]
    UnknownLinkOfJoint { joint: String, link: String },
    /// Links and joints do not form one tree.
    #[error("the links do not form one tree: {why}")]
    NotATree { why: String },
    /// A mimic joint follows a joint that is not there.
    #[error("joint `{joint}` mimics `{master}`, which does not exist")]
    UnknownMaster { joint: String, master: String },
    /// A mimic joint follows a joint without a single coordinate.
    #[error("joint `{joint}` mimics `{master}`, which has more than one coordinate")]
    FreeMaster { joint: String, master: String },
    /// Mimic joints follow each other in a circle.
    #[error("joint `{joint}` mimics itself, directly or through others")]
    MimicCircle { joint: String },
    /// The link asked for is not in the robot.
    #[error("no link `{name}`; the robot has {links}")]
    UnknownLink { name: String, links: String },
    /// The joint asked for is not one of the coordinates.
    #[error("no movable joint `{name}` of its own coordinate; the robot has {joints}")]
    UnknownJoint { name: String, joints: String },
    /// Mass hangs on a joint whose position is not among the coordinates.
    #[error(
        "link `{link}` has mass but lies beyond the {kind} joint `{joint}` as seen from `{support}`; support a link on its side, or make the joint fixed"
    )]
    MassBeyondFreeJoint {
        link: String,
        joint: String,
        kind: &'static str,
        support: String,
    },
    /// No link has any mass.
    #[error("the robot has no mass, so it has no centre of mass")]
    NoMass,
    /// A payload takes away all of a link or more.
    #[error(
        "payload of {payload_kg} kg leaves link `{link}` with {left_kg} kg; it must stay positive"
    )]
    Payload {
        link: String,
        payload_kg: f64,
        left_kg: f64,
    },
    /// Gravity does not press the robot onto its support plane.
    #[error("gravity {direction:?} must be finite and point down: z < 0 in the support frame")]
    Gravity { direction: [f64; 3] },
    /// A joint without an encoder was asked for as if it had one.
    #[error("joint `{joint}` has no encoder")]
    HiddenJoint { joint: String },
    /// A number that only makes sense above zero.
    #[error("{what} of {value} must be finite and above zero")]
    Value { what: &'static str, value: f64 },
    /// The cells of a sole cannot carry a load anywhere between them.
    #[error("{count} cells cannot carry a load between them; give at least three, not in one line")]
    Cells { count: usize },
    /// A cell that is not there.
    #[error("there is no cell fsr_{cell}; the sole has {count}, counted from 1")]
    UnknownCell { cell: usize, count: usize },
    /// An imperfection that the virtual robot does not know, or not there or of such values.
    #[error("the virtual robot has no imperfection `{name}` of such a place and so many values")]
    UnknownImperfection { name: String },
}
