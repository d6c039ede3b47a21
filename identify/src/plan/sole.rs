//! Outline of the sole: the hull of what the collision shapes of the body on the ground
//! have near their lowest point; and where the CoP of planned postures stays within it.

use std::path::Path;

use nalgebra::{Matrix3, Vector3};
use sesc_model::urdf::Description;
use sesc_model::{Function, Model};

use super::balance::Region;
use super::geometry::{self, Geometry, Solid};
use crate::evaluate::Evaluator;
use crate::poses;
use crate::{Error, Setting, message};

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
    /// where the URDF has no such shapes, in a square within the box that has the inertia of
    /// the support. `folder` is where meshes may be.
    ///
    /// # Errors
    /// A support of which the URDF has neither; a square that is too small.
    pub fn of_support(
        model: &Model,
        description: &Description,
        folder: Option<&Path>,
        margin: f64,
    ) -> Result<Region, Error> {
        let outline = outline(model, &Geometry::read(description, folder));
        Ok(match Region::hull(outline, 0.0) {
            Some(mut sole) => {
                let sides = sole.bounds().map(|(low, high)| high - low);
                let narrower = sides[0].min(sides[1]);
                sole.margin = margin.max(0.5 * (1.0 - INNER) * narrower);
                sole.source = Some("by the collision shapes of the support");
                sole
            }
            None => {
                let half = of_inertia(model, description).ok_or_else(|| unknown(model))?;
                let mut square = Region::square(half, margin)?;
                square.source = Some("by the inertia of the support, which has no shape");
                square
            }
        })
    }
}

/// Half the side of a square on the support, whole mm: the inner part of the narrower side of a
/// homogeneous box with the inertia of its heaviest link.
///
/// ```text
/// ∫ ρ x_a² dV = tr I / 2 − I_aa = m s_a² / 3        s_a: half the side along axis a
/// ```
///
/// None of a link without inertia, or with one that no link of this robot has: beyond the height
/// of its CoM.
fn of_inertia(model: &Model, description: &Description) -> Option<f64> {
    let on_ground = model.tree.links.iter().enumerate().filter_map(|(k, link)| {
        let (_, place) = poses::of_link(model, k).filter(|(body, _)| *body == 0)?;
        let own = description.links.iter().find(|own| own.name == link.name)?;
        Some((place, own.inertial))
    });
    let (place, inertial) = on_ground.max_by(|a, b| a.1.mass_kg.total_cmp(&b.1.mass_kg))?;
    let [ixx, ixy, ixz, iyy, iyz, izz] = inertial.inertia;
    let own = Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
    let turned = place.then(&geometry::at(&inertial.origin)).rotation;
    let inertia = turned * own * turned.transpose();
    let half = |axis: usize| {
        let spread = inertia.trace() / 2.0 - inertia[(axis, axis)];
        (3.0 * spread / inertial.mass_kg).sqrt()
    };
    let height = com_height(model);
    let half = half(0).min(half(1));
    // NaN of no mass, and of moments that no body has.
    let half = Some(half).filter(|half| *half > 0.0 && *half < height)?;
    let whole = (1e3 * INNER * half).round() / 1e3;
    (whole > 0.0).then_some(whole)
}

/// Height of the robot's CoM with all joints at zero, m.
fn com_height(model: &Model) -> f64 {
    let zero = vec![0.0; model.dof()];
    Evaluator::new(model, Function::Com).run(&zero, 1)[2].abs()
}

/// What is missing, and what to give.
fn unknown(model: &Model) -> Error {
    // As the OP2's 23 mm to the height of its CoM.
    let height = com_height(model);
    let sensible = (1e2 * height / 10.0).ceil().max(1.0) / 1e2;
    let why = format!(
        "the URDF has neither a collision shape nor a likely inertia of `{}`, which would tell how \
         large its sole is: give half of it by ",
        model.support()
    );
    let size = format!(" (such as {sensible}), or its corners by ");
    Error::request(message![why, Setting::CopBox, size, Setting::Sole])
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
