//! What a URDF says of a robot, in types of our own.

/// A robot description that passed every check.
///
/// Links and joints stand in document order. Visual and collision elements
/// are left in the text; a `quat_xyzw` has become roll, pitch, yaw; axes are as
/// written (not zero, not normalised).
#[derive(Debug, Clone)]
pub struct Description {
    /// Name of the robot.
    pub name: String,
    /// In document order.
    #[doc(hidden)]
    pub links: Vec<Link>,
    /// In document order.
    #[doc(hidden)]
    pub joints: Vec<Joint>,
    /// What was ignored or assumed, each `file:line: what`, in line order.
    pub notes: Vec<String>,
    /// 16 hex digits: FNV-1a (64 bits) over the bytes of the text, without a
    /// leading byte order mark and without carriage returns, so that a
    /// checkout with other line ends is the same robot.
    pub hash: String,
    /// The file as the caller named it; messages start with it.
    pub file: String,
    /// The box around the collision shapes of each link, where the file gives it.
    #[doc(hidden)]
    pub shapes: Vec<Option<Extent>>,
    /// The text that was read.
    #[doc(hidden)]
    pub text: String,
}

impl Description {
    /// The last part of [`Description::file`], free of directories.
    pub fn file_name(&self) -> &str {
        self.file.rsplit(['/', '\\']).next().unwrap_or(&self.file)
    }

    /// Names of the links in document order.
    pub fn link_names(&self) -> impl Iterator<Item = &str> {
        self.links.iter().map(|link| link.name.as_str())
    }
}

/// A box along the axes of a link frame, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// The corner of the least coordinates.
    pub low: [f64; 3],
    /// The corner of the greatest coordinates.
    pub high: [f64; 3],
}

/// A link: its name and its mass.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Unique among links.
    pub name: String,
    /// All zero for a link without `<inertial>`.
    pub inertial: Inertial,
}

/// Mass of a link.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Inertial {
    /// kg
    pub mass_kg: f64,
    /// Centre of mass and axes of the inertia, in the link frame.
    pub origin: Origin,
    /// `ixx, ixy, ixz, iyy, iyz, izz` about the centre of mass, kg m².
    pub inertia: [f64; 6],
}

/// Attributes of `<inertia>`, in the order of [`Inertial::inertia`].
pub(super) const INERTIA: [&str; 6] = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];

/// Place and orientation of a frame in another one.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Origin {
    /// m
    pub xyz: [f64; 3],
    /// Roll, pitch, yaw of `Rz(yaw) Ry(pitch) Rx(roll)`, rad.
    pub rpy: [f64; 3],
}

/// A joint between two links.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Unique among joints.
    pub name: String,
    /// How it moves.
    pub joint_type: JointType,
    /// The joint's frame in the parent link.
    pub origin: Origin,
    /// Name of the link that carries it.
    pub parent: String,
    /// Name of the link that it moves.
    pub child: String,
    /// In the joint's frame, of any length but zero.
    pub axis: [f64; 3],
    /// Where it may stand.
    pub limit: Limit,
    /// The joint that it follows.
    pub mimic: Option<Mimic>,
}

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum JointType {
    /// About an axis, within limits.
    Revolute,
    /// About an axis, without end.
    Continuous,
    /// Along an axis.
    Prismatic,
    /// Not at all.
    Fixed,
    /// In six coordinates.
    Floating,
    /// In a plane.
    Planar,
}

impl JointType {
    pub(super) const ALL: [JointType; 6] = [
        JointType::Revolute,
        JointType::Continuous,
        JointType::Prismatic,
        JointType::Fixed,
        JointType::Floating,
        JointType::Planar,
    ];

    /// Its name in a URDF.
    pub fn name(self) -> &'static str {
        match self {
            JointType::Revolute => "revolute",
            JointType::Continuous => "continuous",
            JointType::Prismatic => "prismatic",
            JointType::Fixed => "fixed",
            JointType::Floating => "floating",
            JointType::Planar => "planar",
        }
    }

    /// Whether it has one coordinate, and so may mimic and be mimicked.
    pub fn is_single(self) -> bool {
        matches!(
            self,
            JointType::Revolute | JointType::Continuous | JointType::Prismatic
        )
    }

    pub(super) fn has_axis(self) -> bool {
        !matches!(self, JointType::Fixed | JointType::Floating)
    }

    pub(super) fn has_limits(self) -> bool {
        matches!(self, JointType::Revolute | JointType::Prismatic)
    }
}

/// Limits of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// rad or m; `-inf` without a limit.
    pub lower: f64,
    /// rad or m; `inf` without a limit.
    pub upper: f64,
    /// N m or N; 0 where it is not given.
    pub effort: f64,
    /// rad/s or m/s; 0 where it is not given.
    pub velocity: f64,
}

impl Limit {
    pub(crate) const NONE: Limit = Limit {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        effort: 0.0,
        velocity: 0.0,
    };
}

/// `q = multiplier · q_joint + offset`
#[derive(Debug, Clone, PartialEq)]
pub struct Mimic {
    /// Name of the joint that is followed.
    pub joint: String,
    /// 1 unless given.
    pub multiplier: f64,
    /// 0 unless given; rad or m.
    pub offset: f64,
}
