//! Links and joints: what a robot is made of.
//!
//! ```text
//! X_j(q)  = Rot(a_j, q)     revolute, continuous
//!           Trans(a_j q)    prismatic
//!           1               fixed; floating and planar at their origin
//! ```

use std::f64::consts::PI;

use nalgebra::{IsometryMatrix3, Matrix3, Point3, Rotation3, Translation3, Unit, Vector3};

/// A rigid transform: rotation matrix and translation, metres.
pub type Pose = IsometryMatrix3<f64>;

/// A link: a frame, with or without mass.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Its name.
    pub name: String,
    /// Its mass, kg; zero where the file gives no `<inertial>`.
    pub mass_kg: f64,
    /// Its centre of mass in its own frame, m.
    pub com_m: Point3<f64>,
    /// Its inertia about the centre of mass in the axes of its own frame, kg m²; zero where
    /// the file gives none that can be read.
    pub inertia_kg_m2: Matrix3<f64>,
}

impl Link {
    /// With a point mass (kg) at `at_m` more.
    pub(crate) fn with_point(&self, mass_kg: f64, at_m: Vector3<f64>) -> Link {
        let whole_kg = self.mass_kg + mass_kg;
        let com = (self.com_m.coords * self.mass_kg + at_m * mass_kg) / whole_kg;
        // Steiner, for both parts.
        let moved = |mass_kg: f64, arm: Vector3<f64>| {
            (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()) * mass_kg
        };
        Link {
            name: self.name.clone(),
            mass_kg: whole_kg,
            com_m: Point3::from(com),
            inertia_kg_m2: self.inertia_kg_m2
                + moved(self.mass_kg, self.com_m.coords - com)
                + moved(mass_kg, at_m - com),
        }
    }
}

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum JointKind {
    /// Not at all.
    Fixed,
    /// Rotates about its axis, within limits.
    Revolute,
    /// Rotates about its axis, without end.
    Continuous,
    /// Moves along its axis.
    Prismatic,
    /// Moves freely; its six coordinates are not among the robot's.
    Floating,
    /// Moves freely in a plane; its coordinates are not among the robot's.
    Planar,
}

impl JointKind {
    /// True where one number gives the joint's position.
    pub fn has_coordinate(self) -> bool {
        matches!(self, Self::Revolute | Self::Continuous | Self::Prismatic)
    }

    /// True where the joint's position is not known to the robot.
    pub fn is_free(self) -> bool {
        matches!(self, Self::Floating | Self::Planar)
    }

    /// The URDF's word for it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Revolute => "revolute",
            Self::Continuous => "continuous",
            Self::Prismatic => "prismatic",
            Self::Floating => "floating",
            Self::Planar => "planar",
        }
    }
}

/// A joint that follows another.
#[derive(Debug, Clone, PartialEq)]
pub struct Mimic {
    /// The joint followed.
    pub master: String,
    /// Its factor.
    pub multiplier: f64,
    /// Added after the factor, rad or m.
    pub offset: f64,
}

/// A joint: where the child link sits on its parent, and how it moves there.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Index of the parent link.
    pub parent: usize,
    /// Index of the child link.
    pub child: usize,
    /// Pose of the joint frame in the parent link's frame.
    pub origin: Pose,
    /// Unit axis in the joint frame.
    pub axis: Unit<Vector3<f64>>,
    /// Lower and upper limit as the file states them, rad or m; 0 where it states none.
    pub limits: (f64, f64),
    /// The joint it follows; always none where `kind` has no coordinate.
    pub mimic: Option<Mimic>,
}

impl Joint {
    /// The motion `X_j` at joint position `q` (rad or m).
    pub fn motion(&self, q: f64) -> Pose {
        match self.kind {
            JointKind::Revolute | JointKind::Continuous => Pose::from_parts(
                Translation3::identity(),
                Rotation3::from_axis_angle(&self.axis, q),
            ),
            JointKind::Prismatic => Pose::from_parts(
                Translation3::from(self.axis.into_inner() * q),
                Rotation3::identity(),
            ),
            JointKind::Fixed | JointKind::Floating | JointKind::Planar => Pose::identity(),
        }
    }

    /// A range with some width to draw positions from, rad or m.
    ///
    /// The default is ±π for revolute joints and ±1 for prismatic ones. A
    /// continuous joint always has it; another joint has it in place of an
    /// infinite end, and altogether where its own limits leave no width.
    pub fn range(&self) -> (f64, f64) {
        let width = if self.kind == JointKind::Prismatic {
            1.0
        } else {
            PI
        };
        if self.kind == JointKind::Continuous {
            return (-width, width);
        }
        let end = |limit: f64, default| if limit.is_finite() { limit } else { default };
        let (lower, upper) = (end(self.limits.0, -width), end(self.limits.1, width));
        if lower < upper {
            (lower, upper)
        } else {
            (-width, width)
        }
    }
}
