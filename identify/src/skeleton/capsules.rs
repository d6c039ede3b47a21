//! Capsules of links: around their collision shapes, else as thick as their inertia says.
//!
//! ```text
//! half edges of the box of the same inertia    h_i² = 3/(2 m) (I_j + I_k − I_i)
//! capsule of half edges h_1 ≥ h_2 ≥ h_3        radius √(h_2 h_3),  along h_1
//! ```

use nalgebra::{Matrix3, Rotation3, Vector3};
use sesc_model::Model;
use sesc_model::urdf::{Description, Inertial};

use super::{Capsule, Part, Segment};
use crate::plan::shapes::{Geometry, Solid};
use crate::poses::{self, Pose};

/// Density of bodies for which the URDF gives no inertia, kg/m³.
const DENSITY: f64 = 1500.0;
/// No inertia makes a link thicker or longer than this part of the robot.
const LARGEST: f64 = 0.2;
/// What stands is not thinner than this part of what its inertia says.
const THINNEST: f64 = 0.4;
/// Radius of a bone as a part of the robot, and shortest bone that is drawn.
const BONE: f64 = 0.013;
const SHORTEST: f64 = 0.01;

/// All capsules of a robot.
pub(super) fn of(
    model: &Model,
    description: &Description,
    geometry: &Geometry,
    bodies: &[Segment],
) -> Vec<Capsule> {
    let size = size(bodies);
    let mut capsules = Vec::new();
    for (child, body) in bodies.iter().enumerate() {
        let length = Vector3::from(body.anchor).norm();
        let parent = body.parent.filter(|_| length > SHORTEST * size);
        if let Some(parent) = parent {
            capsules.push(Capsule {
                link: model.chain.bodies[child].name.clone(),
                body: parent,
                part: Part::Bone,
                ends: [[0.0; 3], body.anchor],
                radius: BONE * size,
            });
        }
    }
    for (k, link) in description.links.iter().enumerate() {
        let Some((body, place)) = poses::of_link(model, k) else {
            continue;
        };
        let shapes = geometry.shapes.iter().filter(|s| s.link == link.name);
        let mut found: Vec<([Vector3<f64>; 2], f64)> = shapes
            .map(|shape| of_solid(&shape.pose, &shape.solid))
            .collect();
        if found.is_empty() && link.inertial.mass_kg > 0.0 {
            found.push(of_inertia(&link.inertial, LARGEST * size));
        }
        for (ends, radius) in found {
            let ends = ends.map(|end| place.point(&end));
            capsules.push(Capsule {
                link: link.name.clone(),
                body,
                part: Part::Link,
                radius: match body {
                    0 => above_ground(ends, radius),
                    _ => radius,
                },
                ends: ends.map(Into::into),
            });
        }
    }
    capsules
}

/// A thinner radius for what stands, where a box of the same inertia would reach into the
/// ground.
fn above_ground(ends: [Vector3<f64>; 2], radius: f64) -> f64 {
    let lowest = ends[0].z.min(ends[1].z);
    radius.min(lowest.max(THINNEST * radius))
}

/// How far joints are apart at most, along the chain, m.
fn size(bodies: &[Segment]) -> f64 {
    let mut reach: Vec<f64> = Vec::new();
    for body in bodies {
        let before = body.parent.map_or(0.0, |parent| reach[parent]);
        reach.push(before + Vector3::from(body.anchor).norm());
    }
    let longest = reach.iter().copied().fold(0.0, f64::max);
    if longest > 0.0 { longest } else { 0.1 }
}

fn of_solid(pose: &Pose, solid: &Solid) -> ([Vector3<f64>; 2], f64) {
    match *solid {
        Solid::Box(half) => along(pose, half),
        Solid::Cylinder { radius, half } => {
            let line = (half - radius).max(0.0);
            (line_along(pose, Vector3::z() * line), radius)
        }
        Solid::Capsule { radius, half } => (line_along(pose, Vector3::z() * half), radius),
        Solid::Sphere { radius } => ([pose.origin; 2], radius),
    }
}

/// A capsule as long as a box, and as thick on average.
fn along(pose: &Pose, half: Vector3<f64>) -> ([Vector3<f64>; 2], f64) {
    let longest = half.imax();
    let others = half.product() / half[longest].max(f64::MIN_POSITIVE);
    let radius = others.max(0.0).sqrt();
    let mut line = Vector3::zeros();
    line[longest] = (half[longest] - radius).max(0.0);
    (line_along(pose, line), radius)
}

fn line_along(pose: &Pose, half: Vector3<f64>) -> [Vector3<f64>; 2] {
    [pose.point(&-half), pose.point(&half)]
}

fn of_inertia(inertial: &Inertial, most: f64) -> ([Vector3<f64>; 2], f64) {
    let mass = inertial.mass_kg;
    let [roll, pitch, yaw] = inertial.origin.rpy;
    let frame = *Rotation3::from_euler_angles(roll, pitch, yaw).matrix();
    let [xx, xy, xz, yy, yz, zz] = inertial.inertia;
    let eigen = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).symmetric_eigen();
    let total = eigen.eigenvalues.sum();
    let half = eigen
        .eigenvalues
        .map(|own| (1.5 / mass * (total - 2.0 * own)).max(0.0).sqrt().min(most));
    let pose = Pose {
        rotation: frame * eigen.eigenvectors,
        origin: inertial.origin.xyz.into(),
    };
    let (ends, radius) = along(&pose, half);
    if radius > 0.0 && radius.is_finite() {
        return (ends, radius);
    }
    // No inertia, or one of a rod or a point: a ball of the same mass.
    let ball = (0.75 * mass / (std::f64::consts::PI * DENSITY)).cbrt();
    ([pose.origin; 2], ball.min(most))
}
