//! Where every body is in the support frame.
//!
//! ```text
//! T_i = T_parent(i) · (anchor_i + axis θ,  R_i Rot(axis, θ))        θ = factor q + offset
//! ```

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use sesc_model::Model;
use sesc_model::chain::Body;
use sesc_model::tree::{Coordinate, Link, Motion};

/// Orientation and origin of a frame in the support frame, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pose {
    /// Its axes, as columns.
    pub rotation: Matrix3<f64>,
    /// Its origin, m.
    pub origin: Vector3<f64>,
}

impl Pose {
    /// The support frame itself.
    pub(crate) const IDENTITY: Pose = Pose {
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        origin: Vector3::new(0.0, 0.0, 0.0),
    };

    /// `inner`, given in this frame, in the frame this one is given in.
    pub(crate) fn then(&self, inner: &Pose) -> Pose {
        Pose {
            rotation: self.rotation * inner.rotation,
            origin: self.point(&inner.origin),
        }
    }

    /// A point, given in this frame, in the frame this one is given in.
    pub(crate) fn point(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.origin + self.rotation * point
    }
}

/// Poses of all `bodies` of a chain in posture `q`, rad or m.
pub(crate) fn bodies(chain: &[Body], q: &[f64]) -> Vec<Pose> {
    let mut poses: Vec<Pose> = Vec::with_capacity(chain.len());
    for body in chain {
        let own = moved(body, q);
        poses.push(match body.parent {
            Some(parent) => poses[parent].then(&own),
            None => own,
        });
    }
    poses
}

/// A body against its parent. A joint that `q` is too short for stands at zero.
fn moved(body: &Body, q: &[f64]) -> Pose {
    let theta = |by: Coordinate| by.factor * q.get(by.dof).copied().unwrap_or(0.0) + by.offset;
    let still = Pose {
        rotation: matrix(body.rotation()),
        origin: body.anchor().into(),
    };
    match body.motion {
        // A body without a joint of its own is the support's.
        Motion::Fixed => Pose::IDENTITY,
        Motion::Revolute { axis, by } => {
            let local = Rotation3::from_axis_angle(&unit(axis), theta(by));
            Pose {
                rotation: still.rotation * local.matrix(),
                ..still
            }
        }
        Motion::Prismatic { axis, by } => Pose {
            origin: still.origin + unit(axis).scale(theta(by)),
            ..still
        },
    }
}

fn unit(axis: Vector3<f64>) -> Unit<Vector3<f64>> {
    Unit::new_unchecked(axis)
}

fn matrix(rows: [[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from(rows).transpose()
}

/// A frame or point of a link, seen from its body; `None` beyond a cut.
pub(crate) fn of_link(model: &Model, link: usize) -> Option<(usize, Pose)> {
    let place = model.chain.places[link]?;
    let pose = Pose {
        rotation: matrix(place.orientation()),
        origin: place.origin().into(),
    };
    Some((place.body, pose))
}

/// Links by their index, each with its body and its frame there; those beyond a cut are left out.
pub(crate) fn links(model: &Model) -> impl Iterator<Item = (usize, &Link, usize, Pose)> {
    let links = model.tree.links.iter().enumerate();
    links.filter_map(|(k, link)| {
        let (body, place) = of_link(model, k)?;
        Some((k, link, body, place))
    })
}

/// Links that are fixed to the support, with their frames in its own.
pub(crate) fn on_ground(model: &Model) -> impl Iterator<Item = (&Link, Pose)> {
    let links = links(model).filter(|(_, _, body, _)| *body == 0);
    links.map(|(_, link, _, place)| (link, place))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Robot;
    use crate::simulate::Simulator;

    /// Against the reference's link poses, on robots with prismatic joints, mimics and rotated frames.
    #[test]
    fn links_stand_where_the_reference_has_them() {
        let robots = [
            (include_str!("../../robots/op2/op2.urdf"), "r_sole"),
            (
                include_str!("../../robots/lift_base/lift_base.urdf"),
                "grasp_frame",
            ),
            (
                include_str!("../../robots/skew_humanoid/skew_humanoid.urdf"),
                "right_sole",
            ),
        ];
        for (text, support) in robots {
            let robot = Robot::parse(text, "robot.urdf").unwrap();
            let model = robot
                .model(support, sesc_model::Snapping::Off, None)
                .unwrap();
            let reference = crate::robot::reference(&robot, support);
            let mut simulator = Simulator::new(&model.tree.dofs, None, 3);
            for _ in 0..20 {
                let q = simulator.posture();
                let poses = bodies(&model.chain.bodies, &q);
                for (link, theirs) in reference.link_poses(&q).iter().enumerate() {
                    let Some((body, place)) = of_link(&model, link) else {
                        continue;
                    };
                    let own = poses[body].then(&place);
                    let off = own.origin - theirs.translation.vector;
                    assert!(off.norm() < 1e-12, "{}: {off}", model.tree.links[link].name);
                    let difference = own.rotation - theirs.rotation.matrix();
                    assert!(difference.norm() < 1e-12);
                }
            }
        }
    }
}
