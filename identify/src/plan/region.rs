//! Where the CoP may be, and how far it must stay away from the edge.
//!
//! ```text
//! the sole     n_e · c ≤ d_e                      every edge e, n_e of length one
//! balanced     n_e · c + margin + k √(n_eᵀ Σ n_e) ≤ d_e        Σ = φ S Sᵀ φᵀ
//! ```
//!
//! Σ is what CAD does not know about the CoP of this posture: the covariance S Sᵀ
//! of the parameters through the regressor rows φ. Along every edge's normal the
//! true CoP then keeps within it by k standard deviations.
//!
//! The outline of a sole is the hull of what the collision shapes of the body on the ground have near
//! their lowest point.

use std::path::Path;

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use sesc_model::urdf::Description;
use sesc_model::{Function, Model, files};

use super::shapes::{Geometry, Solid, at};
use crate::evaluate::Evaluator;
use crate::observations::postures::range;
use crate::{Error, Setting, message, poses};

/// A convex region of the sole plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Corners, counter-clockwise, m.
    pub corners: Vec<[f64; 2]>,
    /// Kept from the edge, m.
    pub margin: f64,
    /// Why it is so, where nobody said.
    pub source: Option<&'static str>,
    edges: Vec<(Vector2<f64>, f64)>,
}

impl Region {
    /// |x|, |y| ≤ `half`.
    ///
    /// # Errors
    /// A square too small to aim at.
    pub fn square(half: f64, margin: f64) -> Result<Region, Error> {
        let corners = [[half, half], [-half, half], [-half, -half], [half, -half]];
        let hull = Region::hull(corners.to_vec(), margin);
        hull.filter(|_| half.is_finite() && half > 0.0)
            .ok_or_else(|| {
                let small = format!(" {half}: too small for any foot; give metres, 0.0001 or more");
                Error::request(message![Setting::CopBox, small])
            })
    }

    /// The convex hull of a foot's points: `x,y; x,y; …`, or a file with a point a line.
    ///
    /// # Errors
    /// Points that are not numbers or enclose nothing.
    pub fn sole(given: &str, margin: f64) -> Result<Region, Error> {
        let path = Path::new(given);
        let inline = given.contains(';');
        let mut text = given.replace(';', "\n");
        if !inline {
            text = files::read_text(path, files::SETTINGS).map_err(|source| {
                let takes = " takes a file of points, or \"x,y; x,y; …\"";
                Error::read(given, source).saying(message![Setting::Sole, takes])
            })?;
        }
        let mut points = Vec::new();
        for (k, line) in text.lines().enumerate() {
            let line = line.trim();
            let heading = k == 0 && !inline && line.starts_with(|c: char| c.is_alphabetic());
            if line.is_empty() || line.starts_with('#') || heading {
                continue;
            }
            let cells = line.split([',', ' ', '\t']).filter(|cell| !cell.is_empty());
            // No foot is larger than 10 m.
            let metres = |cell: &str| cell.parse().ok().filter(|x: &f64| x.abs() <= 10.0);
            let numbers: Vec<Option<f64>> = cells.map(metres).collect();
            let [Some(x), Some(y)] = numbers[..] else {
                let point = format!(": point {} `{line}`", k + 1);
                let remedy = ": give x,y in metres in the support frame";
                return Err(Error::request(message![Setting::Sole, point, remedy]));
            };
            points.push([x, y]);
        }
        Region::hull(points, margin).ok_or_else(|| {
            let flat = ": the points enclose nothing; give three or more corners, x,y in metres";
            Error::request(message![Setting::Sole, flat])
        })
    }

    /// The convex hull of points, by the monotone chain.
    pub(crate) fn hull(mut points: Vec<[f64; 2]>, margin: f64) -> Option<Region> {
        points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        points.dedup();
        let cross = |o: [f64; 2], a: [f64; 2], b: [f64; 2]| {
            (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
        };
        let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
            let mut chain: Vec<[f64; 2]> = Vec::new();
            for p in points {
                while chain.len() >= 2
                    && cross(chain[chain.len() - 2], chain[chain.len() - 1], p) <= 0.0
                {
                    chain.pop();
                }
                chain.push(p);
            }
            chain.pop();
            chain
        };
        let mut corners = half(&mut points.iter().copied());
        corners.extend(half(&mut points.iter().rev().copied()));
        let n = corners.len();
        let triangles = (0..n).map(|k| cross([0.0; 2], corners[k], corners[(k + 1) % n]));
        let area: f64 = triangles.sum();
        if n < 3 || area < 1e-8 {
            return None;
        }
        let edge = |k: usize| {
            let [a, b] = [corners[k], corners[(k + 1) % n]].map(Vector2::from);
            let along = (b - a).normalize();
            let normal = Vector2::new(along.y, -along.x);
            (normal, normal.dot(&a))
        };
        let edges = (0..n).map(edge).collect();
        Some(Region {
            corners,
            margin,
            source: None,
            edges,
        })
    }

    /// How far the CoP is beyond what is allowed, m; negative when balanced.
    pub(crate) fn violation(
        &self,
        cop: Vector2<f64>,
        covariance: &Matrix2<f64>,
        sigmas: f64,
    ) -> f64 {
        let beyond = |(normal, distance): &(Vector2<f64>, f64)| {
            let std = normal.dot(&(covariance * normal)).max(0.0).sqrt();
            normal.dot(&cop) + self.margin + sigmas * std - distance
        };
        range(self.edges.iter().map(beyond)).1
    }

    /// The mean of the corners.
    pub(crate) fn centre(&self) -> Vector2<f64> {
        let sum: Vector2<f64> = self.corners.iter().map(|&c| Vector2::from(c)).sum();
        sum / self.corners.len() as f64
    }

    /// Smallest and largest x and y.
    pub fn bounds(&self) -> [(f64, f64); 2] {
        [0, 1].map(|axis| range(self.corners.iter().map(|c| c[axis])))
    }

    /// In a few words.
    pub fn sentence(&self) -> String {
        let [(x0, x1), (y0, y1)] = self.bounds();
        let margin = match self.margin {
            0.0 => String::new(),
            m => format!(", {:.1} mm from its edge", 1e3 * m),
        };
        let source = self.source.map(|why| format!(", {why}"));
        let source = source.unwrap_or_default();
        let square = self.corners.len() == 4 && x0 == -x1 && y0 == -y1 && x1 == y1;
        let [x0, x1, y0, y1] = [x0, x1, y0, y1].map(|x| 1e3 * x);
        if square {
            return format!("|x|, |y| <= {x1:.1} mm{margin}{source}");
        }
        format!(
            "a sole of {} corners, x {x0:.1} to {x1:.1} mm, y {y0:.1} to {y1:.1} mm{margin}{source}",
            self.corners.len()
        )
    }
}

/// The CoP stays so far within the sole unless somebody says, as a part of half its narrower
/// side: as the seed paper's 23 mm in the 33 mm of the OP2's sole.
const INNER: f64 = 0.7;

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
        if let Some(mut sole) = Region::hull(outline, 0.0) {
            let sides = sole.bounds().map(|(low, high)| high - low);
            let narrower = sides[0].min(sides[1]);
            sole.margin = margin.max(0.5 * (1.0 - INNER) * narrower);
            sole.source = Some("by the collision shapes of the support");
            return Ok(sole);
        }
        let half = of_inertia(model, description).ok_or_else(|| unknown(model))?;
        let mut square = Region::square(half, margin)?;
        square.source = Some("by the inertia of the support, which has no shape");
        Ok(square)
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
    let on_ground = poses::links(model).filter(|(_, _, body, _)| *body == 0);
    let on_ground = on_ground.filter_map(|(_, link, _, place)| {
        let own = description.links.iter().find(|own| own.name == link.name)?;
        Some((place, own.inertial))
    });
    let (place, inertial) = on_ground.max_by(|a, b| a.1.mass_kg.total_cmp(&b.1.mass_kg))?;
    let [ixx, ixy, ixz, iyy, iyz, izz] = inertial.inertia;
    let own = Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
    let turned = place.then(&at(&inertial.origin)).rotation;
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
    let on_ground = poses::links(model).filter(|(_, _, body, _)| *body == 0);
    let solids = on_ground.flat_map(|(_, link, _, place)| geometry.on(&link.name, place));
    let points =
        solids.flat_map(|(pose, solid)| corners(&solid).into_iter().map(move |p| pose.point(&p)));
    let points: Vec<Vector3<f64>> = points.collect();
    let lowest = points.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    // What is a centimetre higher is not on the ground.
    let near = points.iter().filter(|p| p.z < lowest + 0.01);
    let near: Vec<[f64; 2]> = near.map(|p| [p.x, p.y]).collect();
    Region::hull(near, 0.0).map_or_else(Vec::new, |region| region.corners)
}

/// Points around a solid; the extremes among them.
fn corners(solid: &Solid) -> Vec<Vector3<f64>> {
    let circles = |radius: f64, half: f64| {
        (0..32).map(move |k| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k / 2) / 16.0).sin_cos();
            let height = if k % 2 == 0 { -half } else { half };
            Vector3::new(radius * cos, radius * sin, height)
        })
    };
    match *solid {
        Solid::Box(half) => (0..8)
            .map(|k| Vector3::from_fn(|axis, _| half[axis] * f64::from(2 * (k >> axis & 1) - 1)))
            .collect(),
        Solid::Cylinder { radius, half } => circles(radius, half).collect(),
        Solid::Capsule { radius, half } => {
            let ends = [-half - radius, half + radius].map(|z| Vector3::new(0.0, 0.0, z));
            ends.into_iter().chain(circles(radius, half)).collect()
        }
        Solid::Sphere { radius } => vec![Vector3::new(0.0, 0.0, -radius)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_is_what_it_says() {
        let square = Region::square(0.02, 0.001).unwrap();
        let zero = Matrix2::zeros();
        assert!((square.violation(Vector2::new(0.015, -0.018), &zero, 2.0) + 0.001).abs() < 1e-15);
        let std = Matrix2::from_diagonal(&Vector2::new(1e-6, 4e-6));
        // Edges at 20 mm; 15 + 1 + 2 · 1 mm along x, 12 + 1 + 2 · 2 mm along y.
        assert!((square.violation(Vector2::new(0.015, 0.012), &std, 2.0) + 0.002).abs() < 1e-12);
        let said = "|x|, |y| <= 20.0 mm, 1.0 mm from its edge";
        assert_eq!(square.sentence(), said);
    }

    #[test]
    fn a_sole_is_the_hull_of_its_points() {
        let sole = Region::sole("0,0; 0.1,0; 0.05,0.02; 0.1,0.05; 0,0.05", 0.0).unwrap();
        let corners = [[0.0, 0.0], [0.1, 0.0], [0.1, 0.05], [0.0, 0.05]];
        assert_eq!(sole.corners, corners);
        assert_eq!(sole.bounds(), [(0.0, 0.1), (0.0, 0.05)]);
        let outside = sole.violation(Vector2::new(0.12, 0.02), &Matrix2::zeros(), 2.0);
        assert!((outside - 0.02).abs() < 1e-15);
        let flat = ["0,0; 1,0", "0,0; 1,0; 2,0"];
        let odd = ["0,0; 1,x; 1,1", "0,0; NaN,1; 1,1", "0;1;2"];
        for bad in odd.into_iter().chain(flat) {
            assert!(Region::sole(bad, 0.0).is_err(), "{bad}");
        }
        let said = Region::sole("gone.csv", 0.0).unwrap_err().to_string();
        assert!(said.contains("gone.csv"), "{said}");
    }
}
