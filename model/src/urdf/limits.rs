//! Bounds on what is read: far above any robot, far below what could exhaust
//! memory, time or the stack.

/// Size of a file in bytes.
pub const FILE_BYTES: u64 = 64 << 20;
/// XML elements nested in each other.
pub const DEPTH: usize = 64;
/// XML elements in a file.
pub const ELEMENTS: usize = 1_000_000;
/// XML nodes of any kind; elements and the text between them.
pub const XML_NODES: u32 = 4_000_000;
/// Attributes of one element; XML readers compare each with each.
pub const ATTRIBUTES: usize = 256;
/// Links, and likewise joints, of a robot.
pub const LINKS: usize = 10_000;
/// Joints of a robot that move: parameters and generated Jacobians grow with the square of it.
pub const MOVING: usize = 2000;
/// The same where one of them follows another: what is tied is found with the cube of it.
pub const MOVING_WITH_MIMICS: usize = 1000;
/// Bytes of one name.
pub const NAME_BYTES: usize = 1024;

/// Largest offset between two frames, in metres.
pub const OFFSET_M: f64 = 1e6;
/// Largest mass of one link, in kilograms.
pub const MASS_KG: f64 = 1e9;
/// Largest entry of one link's inertia, in kg m²: a million tonnes at a kilometre.
pub const INERTIA_KGM2: f64 = 1e15;
/// An axis shorter than this, or longer than its inverse, has no direction.
pub const AXIS: f64 = 1e-9;
/// A revolute limit beyond this, in radians, was probably meant in degrees.
pub const TURN_RAD: f64 = 50.0;
/// A revolute limit beyond this, in radians, was meant as none at all.
pub const UNLIMITED_RAD: f64 = 1e4;
/// A fixed angle beyond this, in radians, means nothing: sines are computed up to it.
pub const TURNS_RAD: f64 = 1_048_576.0;
/// Largest factor and offset between a revolute joint and the one that it follows in the
/// end, over all mimics between them: no gear has a ratio beyond it.
pub const MIMIC: f64 = 1e4;
/// The same of a prismatic joint, which turns nothing: metres, or metres per radian.
pub const MIMIC_M: f64 = 1e7;
/// A robot lighter than this, in kilograms, has no mass.
pub const LEAST_KG: f64 = 1e-9;
/// A fixed angle beyond this (a full turn), in radians, was probably meant in degrees.
pub const ANGLE_RAD: f64 = 6.3;
