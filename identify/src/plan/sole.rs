//! Outline of the sole: the hull of what the collision shapes of the body on the ground
//! have near their lowest point; and where the CoP of planned postures stays within it.

use std::path::Path;

use nalgebra::Vector3;
use sesc_model::Model;
use sesc_model::urdf::Description;

use super::balance::Region;
use super::geometry::{Geometry, Solid};
use super::request::COP_BOX;
use crate::Error;
use crate::poses;

/// What is higher than this above the lowest point is not on the ground, m.
const NEAR: f64 = 0.01;
/// The CoP stays so far within the sole unless somebody says, as a part of half its narrower
/// side: as the seed paper's 23 mm in the 33 mm of the OP2's sole.
const INNER: f64 = 0.7;
/// Corners that a circle is drawn with.
const CORNERS: usize = 16;

impl Region {
    /// Where the CoP of a robot stays unless somebody says: within the sole, as the collision
    /// shapes of its support have it, and well away from its edge (at least `margin`, m);
    /// where the URDF has no such shapes, in the square of [`COP_BOX`]. `folder` is where
    /// meshes may be.
    ///
    /// # Errors
    /// A square that is too small.
    pub fn of_support(
        model: &Model,
        description: &Description,
        folder: Option<&Path>,
        margin: f64,
    ) -> Result<Region, Error> {
        let outline = outline(model, &Geometry::read(description, folder));
        let region = match Region::hull(outline, 0.0) {
            Some(mut sole) => {
                let sides = sole.bounds().map(|(low, high)| high - low);
                let narrower = sides[0].min(sides[1]);
                sole.margin = margin.max(0.5 * (1.0 - INNER) * narrower);
                sole.source = Some("by the collision shapes of the support");
                sole
            }
            None => {
                let mut square = Region::square(COP_BOX, margin)?;
                square.source = Some("for the URDF has no shape of the sole");
                square
            }
        };
        Ok(region)
    }
}

/// Counter-clockwise, in the support frame, m.
pub(crate) fn outline(model: &Model, geometry: &Geometry) -> Vec<[f64; 2]> {
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
