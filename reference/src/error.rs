//! What can be wrong with a file or a request: each names the thing at fault
//! and, where there is one, the remedy.

use std::path::PathBuf;

/// Why a robot could not be read, stood on a link or bent.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file could not be opened or read.
    #[error("cannot read `{}`", path.display())]
    File {
        /// The file asked for.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The text is not XML.
    #[error("the URDF is not well-formed XML")]
    Xml(#[from] roxmltree::Error),
    /// The outermost element is not `<robot>`.
    #[error("the outermost element is <{root}>, not <robot>: this is no URDF")]
    NotARobot {
        /// The element found instead.
        root: String,
    },
    /// There are no links.
    #[error("the robot has no links")]
    NoLinks,
    /// An element or attribute without a sensible default is absent.
    #[error("{place}: {what} is missing")]
    Missing {
        /// The link or joint.
        place: String,
        /// The element or attribute.
        what: &'static str,
    },
    /// An attribute holds something else than the numbers it should.
    #[error("{place}: {attribute}=\"{text}\" should hold {expected}")]
    Number {
        /// The link or joint.
        place: String,
        /// The attribute.
        attribute: &'static str,
        /// Its text.
        text: String,
        /// What it should hold.
        expected: &'static str,
    },
    /// A macro expression is left in an attribute that matters.
    #[error("{place}: `{text}` is an unexpanded xacro expression; run xacro over the file first")]
    Xacro {
        /// The link or joint.
        place: String,
        /// The attribute's text.
        text: String,
    },
    /// A joint type outside the URDF vocabulary.
    #[error("joint `{joint}`: type `{kind}` is unknown")]
    UnknownJointKind {
        /// The joint.
        joint: String,
        /// The type as written.
        kind: String,
    },
    /// The axis of a moving joint has no direction.
    #[error("joint `{joint}`: axis has no direction; give <axis xyz> a finite one other than zero")]
    ZeroAxis {
        /// The joint.
        joint: String,
    },
    /// A quaternion has no direction.
    #[error("{place}: quat_xyzw is zero and names no orientation")]
    ZeroQuaternion {
        /// The link or joint.
        place: String,
    },
    /// Both spellings of an orientation are present.
    #[error("{place}: both rpy and quat_xyzw are given; keep one")]
    TwoOrientations {
        /// The link or joint.
        place: String,
    },
    /// A link's mass is negative.
    #[error("link `{link}`: mass {mass_kg} kg is negative")]
    NegativeMass {
        /// The link.
        link: String,
        /// Its mass, kg.
        mass_kg: f64,
    },
    /// Two links or two joints share a name.
    #[error("{place} appears twice")]
    Duplicate {
        /// The link or joint.
        place: String,
    },
    /// A joint refers to a link that is not there.
    #[error("joint `{joint}`: there is no link `{link}`")]
    UnknownLinkOfJoint {
        /// The joint.
        joint: String,
        /// The link it names.
        link: String,
    },
    /// Links and joints do not form one tree.
    #[error("the links do not form one tree: {why}")]
    NotATree {
        /// Which link or joint breaks it.
        why: String,
    },
    /// A mimic joint follows a joint that is not there.
    #[error("joint `{joint}` mimics `{master}`, which does not exist")]
    UnknownMaster {
        /// The follower.
        joint: String,
        /// The joint it names.
        master: String,
    },
    /// A mimic joint follows a joint without a single coordinate.
    #[error("joint `{joint}` mimics `{master}`, which has more than one coordinate")]
    FreeMaster {
        /// The follower.
        joint: String,
        /// The floating or planar joint it names.
        master: String,
    },
    /// Mimic joints follow each other in a circle.
    #[error("joint `{joint}` mimics itself, directly or through others")]
    MimicCircle {
        /// One joint of the circle.
        joint: String,
    },
    /// The link asked for is not in the robot.
    #[error("no link `{name}`; the robot has {links}")]
    UnknownLink {
        /// The name asked for.
        name: String,
        /// The names there are.
        links: String,
    },
    /// The joint asked for is not one of the coordinates.
    #[error("no movable joint `{name}` of its own coordinate; the robot has {joints}")]
    UnknownJoint {
        /// The name asked for.
        name: String,
        /// The names there are.
        joints: String,
    },
    /// Mass hangs on a joint whose position is not among the coordinates.
    #[error(
        "link `{link}` has mass but lies beyond the {kind} joint `{joint}` as seen from `{support}`; support a link on its side, or make the joint fixed"
    )]
    MassBeyondFreeJoint {
        /// The massive link.
        link: String,
        /// The floating or planar joint.
        joint: String,
        /// Its kind.
        kind: &'static str,
        /// The support link.
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
        /// The link.
        link: String,
        /// The payload, kg.
        payload_kg: f64,
        /// What remains, kg.
        left_kg: f64,
    },
    /// Gravity does not press the robot onto its support plane.
    #[error("gravity {direction:?} must be finite and point down: z < 0 in the support frame")]
    Gravity {
        /// The direction asked for, in the support frame.
        direction: [f64; 3],
    },
    /// A joint without an encoder was asked for as if it had one.
    #[error("joint `{joint}` has no encoder")]
    HiddenJoint {
        /// The joint.
        joint: String,
    },
    /// A number that only makes sense above zero.
    #[error("{what} of {value} must be finite and above zero")]
    Value {
        /// What it stands for.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// The cells of a sole cannot carry a load anywhere between them.
    #[error("{count} cells cannot carry a load between them; give at least three, not in one line")]
    Cells {
        /// How many there are.
        count: usize,
    },
    /// A cell that is not there.
    #[error("there is no cell fsr_{cell}; the sole has {count}, counted from 1")]
    UnknownCell {
        /// The cell asked for.
        cell: usize,
        /// How many there are.
        count: usize,
    },
    /// An imperfection that the virtual robot does not know, or not there or of such values.
    #[error("the virtual robot has no imperfection `{name}` of such a place and so many values")]
    UnknownImperfection {
        /// The name asked for.
        name: String,
    },
}
