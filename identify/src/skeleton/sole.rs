//! Outline of the sole: the hull of what the collision shapes of the body on the ground
//! have near their lowest point.

use nalgebra::Vector3;
use sesc_model::Model;

use crate::plan::balance::Region;
use crate::plan::geometry::{Geometry, Solid};
use crate::plan::poses;

/// What is higher than this above the lowest point is not on the ground, m.
const NEAR: f64 = 0.01;
/// Corners that a circle is drawn with.
const CORNERS: usize = 16;

/// Counter-clockwise, in the support frame, m.
pub(super) fn outline(model: &Model, geometry: &Geometry) -> Vec<[f64; 2]> {
    let mut points: Vec<Vector3<f64>> = Vec::new();
    for (k, link) in model.tree.links.iter().enumerate() {
        let Some((0, place)) = poses::of_link(model, k) else {
            continue;
        };
        for shape in geometry.shapes.iter().filter(|s| s.link == link.name) {
            let pose = place.then(&shape.pose);
            points.extend(corners(&shape.solid).iter().map(|p| pose.point(p)));
        }
    }
    let lowest = points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let near = points.iter().filter(|p| p.z < lowest + NEAR);
    let near: Vec<[f64; 2]> = near.map(|p| [p.x, p.y]).collect();
    Region::hull(near, 0.0).map_or_else(Vec::new, |region| region.corners)
}

/// Points around a solid; the extremes among them.
fn corners(solid: &Solid) -> Vec<Vector3<f64>> {
    let circle = |radius: f64, height: f64| {
        (0..CORNERS).map(move |k| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / CORNERS as f64).sin_cos();
            Vector3::new(radius * cos, radius * sin, height)
        })
    };
    match *solid {
        Solid::Box(half) => (0..8)
            .map(|k| {
                let sign = |bit: usize| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
                Vector3::new(sign(0) * half.x, sign(1) * half.y, sign(2) * half.z)
            })
            .collect(),
        Solid::Cylinder { radius, half } => {
            circle(radius, -half).chain(circle(radius, half)).collect()
        }
        Solid::Capsule { radius, half } => [-half - radius, half + radius]
            .map(|z| Vector3::new(0.0, 0.0, z))
            .into_iter()
            .chain(circle(radius, -half))
            .chain(circle(radius, half))
            .collect(),
        Solid::Sphere { radius } => vec![Vector3::new(0.0, 0.0, -radius)],
    }
}
