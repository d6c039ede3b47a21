//! A joint as an edge of the tree, walked away from the support: what moves its far link, and by
//! which independent joint.

use nalgebra::{Matrix3, Vector3};

use crate::snap::{self, Snapping};
use crate::urdf::{self, JointType};

/// A joint's position as a function of one independent joint: `factor·q[dof] + offset`.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coordinate {
    /// Index in [`Tree::dofs`](super::Tree::dofs).
    pub dof: usize,
    /// 1 but for mimic joints and joints walked backwards.
    pub factor: f64,
    /// rad or m
    pub offset: f64,
}

/// How an edge moves.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// Not at all.
    Fixed,
    /// A revolute joint.
    Revolute {
        /// A unit vector in the far link.
        axis: Vector3<f64>,
        /// rad
        by: Coordinate,
    },
    /// A prismatic joint.
    Prismatic {
        /// A unit vector in the near link.
        axis: Vector3<f64>,
        /// m
        by: Coordinate,
    },
}

impl Motion {
    /// What moves it, where anything does.
    pub fn coordinate(self) -> Option<Coordinate> {
        match self {
            Motion::Fixed => None,
            Motion::Revolute { by, .. } | Motion::Prismatic { by, .. } => Some(by),
        }
    }
}

/// A joint, walked away from the support.
#[doc(hidden)]
#[derive(Debug, Clone)]
pub struct Edge {
    /// Name of the joint.
    pub joint: String,
    /// Index of the near link.
    pub near: usize,
    /// Index of the far link.
    pub far: usize,
    /// Walked against the URDF's direction.
    pub reversed: bool,
    /// Orientation of the far link in the near one at θ = 0.
    pub(crate) rotation: Matrix3<f64>,
    /// The joint's point in the near link, m.
    pub(crate) anchor: Vector3<f64>,
    /// The joint's point in the far link, m.
    pub(crate) offset: Vector3<f64>,
    /// How the far link moves.
    pub motion: Motion,
}

impl Edge {
    /// The joint's point in the near link, m.
    pub fn anchor(&self) -> [f64; 3] {
        self.anchor.into()
    }

    /// The joint's point in the far link, m.
    pub fn offset(&self) -> [f64; 3] {
        self.offset.into()
    }
}

/// One joint as an edge, the rotation error that snapping left in it, rad, and what is odd about
/// its rotation.
pub(super) fn edge(
    joint: &urdf::Joint,
    near: usize,
    far: usize,
    reversed: bool,
    coordinate: Option<Coordinate>,
    snapping: Snapping,
) -> (Edge, f64, Option<String>) {
    let origin = snap::rotation(joint.origin.rpy, snapping);
    let odd = origin.nearly.map(|off| {
        format!(
            "joint `{}`: a rotation is {off:.1e} rad off a right angle, too far to snap; \
             taken as written (write more digits if a right angle is meant)",
            joint.name
        )
    });
    let point = Vector3::from(joint.origin.xyz);
    let axis = snap::direction(Vector3::from(joint.axis), snapping);
    let outward = |m: Matrix3<f64>| if reversed { m.transpose() } else { m };
    let mut rotation = outward(origin.value);
    let mut error = origin.error;
    let sign = if reversed { -1.0 } else { 1.0 };
    let motion = match (coordinate, joint.joint_type) {
        (None, _) => Motion::Fixed,
        (Some(by), JointType::Prismatic) => {
            error += axis.error;
            let along = if reversed {
                -axis.value
            } else {
                origin.value * axis.value
            };
            Motion::Prismatic {
                axis: along.map(snap::tidy),
                by,
            }
        }
        (Some(by), _) => {
            // The axis of a revolute body sweeps up to twice its own error.
            error += 2.0 * axis.error;
            let by = Coordinate {
                factor: sign * by.factor,
                offset: sign * by.offset,
                ..by
            };
            let axis = if reversed {
                (origin.value * axis.value).map(snap::tidy)
            } else {
                axis.value
            };
            Motion::Revolute { axis, by }
        }
    };
    let (mut anchor, offset) = if reversed {
        (Vector3::zeros(), point)
    } else {
        (point, Vector3::zeros())
    };
    // A tied joint that cannot move (multiplier 0, or a fixed master) is a fixed one.
    let motion = match motion {
        Motion::Revolute { axis, by } if by.factor == 0.0 => {
            rotation = (rotation * snap::about(&axis, by.offset)).map(snap::tidy);
            Motion::Fixed
        }
        Motion::Prismatic { axis, by } if by.factor == 0.0 => {
            anchor += axis * by.offset;
            Motion::Fixed
        }
        moving => moving,
    };
    let edge = Edge {
        joint: joint.name.clone(),
        near,
        far,
        reversed,
        rotation,
        anchor,
        offset,
        motion,
    };
    (edge, error, odd)
}
