//! Collision shapes of a robot as solids, and the region of the sole that they give: where the CoP
//! may be, and how far it must stay away from the edge.
//!
//! What is not understood of a shape is a note, never a failure. A mesh is taken as the box around
//! it where its file can be read: STL, binary or text.
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

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use nalgebra::{Matrix2, Matrix3, Rotation3, Vector2, Vector3};
use sesc_model::text::listed;
use sesc_model::urdf::{self, Collision, Description, Origin};
use sesc_model::{Function, Model, files};

use crate::evaluate::Evaluator;
use crate::observations::postures::range;
use crate::poses::{Pose, on_ground};
use crate::{Error, Setting, message};

/// A solid about its own centre, m; cylinders and capsules along z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Solid {
    /// Half the edges.
    Box(Vector3<f64>),
    /// A cylinder along z about its centre.
    Cylinder {
        /// m
        radius: f64,
        /// Half its height, m.
        half: f64,
    },
    /// A capsule along z about its centre.
    Capsule {
        /// m
        radius: f64,
        /// Half the height between the centres of its caps, m.
        half: f64,
    },
    /// A sphere about its centre.
    Sphere {
        /// m
        radius: f64,
    },
}

/// A solid somewhere on a link.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Shape {
    /// The link it belongs to.
    pub link: String,
    /// In the link frame.
    pub pose: Pose,
    /// What it is.
    pub solid: Solid,
}

/// All shapes of a robot.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Geometry {
    /// Collision shapes of all links.
    pub(crate) shapes: Vec<Shape>,
    /// What could not be read.
    pub notes: Vec<String>,
}

impl Solid {
    /// How far it reaches from its centre along the unit vector `along`, given in its frame.
    pub(crate) fn reach(&self, along: &Vector3<f64>) -> f64 {
        let across = along.x.hypot(along.y);
        match *self {
            Solid::Box(half) => half.dot(&along.abs()),
            Solid::Cylinder { radius, half } => half * along.z.abs() + radius * across,
            Solid::Capsule { radius, half } => half * along.z.abs() + radius,
            Solid::Sphere { radius } => radius,
        }
    }
}

impl Geometry {
    /// The collision elements of a URDF; `folder` is where its meshes may be.
    pub fn read(description: &Description, folder: Option<&Path>) -> Geometry {
        let mut geometry = Geometry::default();
        let found = urdf::collisions(description).unwrap_or_else(|error| {
            let note = format!("collision shapes cannot be read: {error}");
            geometry.notes.push(note);
            Vec::new()
        });
        // What is to be said, and of which links.
        let mut said: BTreeMap<String, Vec<&str>> = BTreeMap::new();
        for (link, collisions) in description.link_names().zip(found) {
            for collision in collisions {
                let is_mesh = |own: &Collision| matches!(own.shape, urdf::Shape::Mesh { .. });
                let boxed = collision.as_ref().is_ok_and(is_mesh);
                let note = match collision.and_then(|own| solid(&own, folder)) {
                    Ok((pose, solid)) => {
                        let link = link.to_string();
                        geometry.shapes.push(Shape { link, pose, solid });
                        boxed.then(|| "meshes taken as the boxes around them".to_string())
                    }
                    Err(why) => Some(format!("collision shape ignored ({why})")),
                };
                if let Some(note) = note {
                    said.entry(note).or_default().push(link);
                }
            }
        }
        for (what, mut links) in said {
            links.dedup();
            let links = listed(&links, 12);
            geometry.notes.push(format!("{what}: {links}"));
        }
        geometry
    }

    /// Solids of a link, in the frame of the body in which the link has its `place`.
    pub(crate) fn on<'g>(
        &'g self,
        link: &'g str,
        place: Pose,
    ) -> impl Iterator<Item = (Pose, Solid)> + 'g {
        let own = self.shapes.iter().filter(move |shape| shape.link == link);
        own.map(move |shape| (place.then(&shape.pose), shape.solid))
    }
}

/// What an `<origin>` says.
pub(crate) fn at(origin: &Origin) -> Pose {
    let [roll, pitch, yaw] = origin.rpy;
    Pose {
        rotation: *Rotation3::from_euler_angles(roll, pitch, yaw).matrix(),
        origin: Vector3::from(origin.xyz),
    }
}

/// Pose and solid of a collision.
fn solid(collision: &Collision, folder: Option<&Path>) -> Result<(Pose, Solid), String> {
    let pose = at(&collision.origin);
    let solid = match &collision.shape {
        urdf::Shape::Box { size } => Solid::Box(Vector3::from(*size) / 2.0),
        &urdf::Shape::Sphere { radius } => Solid::Sphere { radius },
        &urdf::Shape::Cylinder { radius, length } => Solid::Cylinder {
            radius,
            half: length / 2.0,
        },
        &urdf::Shape::Capsule { radius, length } => Solid::Capsule {
            radius,
            half: length / 2.0,
        },
        urdf::Shape::Mesh { file, scale } => {
            let scale = Vector3::from(*scale);
            let (low, high) = mesh_bounds(file, folder)?;
            let (a, b) = (low.component_mul(&scale), high.component_mul(&scale));
            let centre = Pose {
                origin: (a + b) / 2.0,
                ..Pose::IDENTITY
            };
            return Ok((pose.then(&centre), Solid::Box((b - a).abs() / 2.0)));
        }
        _ => return Err("a shape that is not known".to_string()),
    };
    Ok((pose, solid))
}

/// Lowest and highest corner of the mesh, m, before scaling.
///
/// # Errors
/// Why the mesh is left out, in a few words.
fn mesh_bounds(name: &str, folder: Option<&Path>) -> Result<(Vector3<f64>, Vector3<f64>), String> {
    if !name.to_ascii_lowercase().ends_with(".stl") {
        return Err("a mesh that is no STL file".to_string());
    }
    let path = find(name, folder).ok_or("a mesh whose file is not found")?;
    let bytes = files::read_found(&path, 64)
        .map_err(|_| "a mesh whose file cannot be read, or is larger than 64 MiB")?;
    let box_around = binary(&bytes).or_else(|| text(&bytes));
    box_around.ok_or_else(|| "a mesh that is no valid STL".to_string())
}

/// A file named as ROS does it, looked for beside the URDF and above.
fn find(name: &str, folder: Option<&Path>) -> Option<PathBuf> {
    let is_file = |path: &PathBuf| path.is_file();
    if let Some(path) = name.strip_prefix("file://") {
        return Some(PathBuf::from(path)).filter(is_file);
    }
    // An empty path is the folder that the program runs in.
    let folder = Path::new(".").join(folder?).canonicalize().ok()?;
    if let Some(path) = name.strip_prefix("package://") {
        let mut above = folder.ancestors().map(|above| above.join(path));
        return above.find(is_file);
    }
    Some(folder.join(name)).filter(is_file)
}

fn binary(bytes: &[u8]) -> Option<(Vector3<f64>, Vector3<f64>)> {
    // A title and the number of triangles: each a normal, three corners, an attribute.
    let (head, triangles) = bytes.split_at_checked(84)?;
    let count = u32::from_le_bytes(head[80..].try_into().ok()?) as usize;
    if triangles.len() != count.checked_mul(50)? {
        return None;
    }
    let float = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let corners = triangles
        .chunks_exact(50)
        .flat_map(|t| t[12..48].chunks_exact(12));
    box_around(corners.map(|c| Vector3::new(float(c), float(&c[4..]), float(&c[8..]))))
}

fn text(bytes: &[u8]) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let text = std::str::from_utf8(bytes).ok()?;
    let mut words = text.split_whitespace();
    let mut corners = Vec::new();
    while words.any(|word| word == "vertex") {
        let mut next = || words.next()?.parse::<f64>().ok();
        corners.push(Vector3::new(next()?, next()?, next()?));
    }
    box_around(corners.into_iter())
}

fn box_around(corners: impl Iterator<Item = Vector3<f64>>) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let none = (
        Vector3::repeat(f64::INFINITY),
        Vector3::repeat(f64::NEG_INFINITY),
    );
    let (low, high) = corners.fold(none, |(low, high), c| (low.inf(&c), high.sup(&c)));
    let sound = |v: &Vector3<f64>| v.iter().all(|x| x.abs() < 1e6);
    (sound(&low) && sound(&high)).then_some((low, high))
}

/// The CoP stays so far within the sole unless somebody says, as a part of half its narrower
/// side: as the seed paper's 23 mm in the 33 mm of the OP2's sole.
const INNER: f64 = 0.7;

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
        let [(x0, x1), (y0, y1)] = self.bounds().map(|(low, high)| (1e3 * low, 1e3 * high));
        let (count, margin) = (self.corners.len(), 1e3 * self.margin);
        let mut said = format!("|x|, |y| <= {x1:.1} mm");
        if count != 4 || x0 != -x1 || y0 != -y1 || x1 != y1 {
            said = format!(
                "a sole of {count} corners, x {x0:.1} to {x1:.1} mm, y {y0:.1} to {y1:.1} mm"
            );
        }
        if margin != 0.0 {
            said += &format!(", {margin:.1} mm from its edge");
        }
        let source = self.source.map(|why| format!(", {why}"));
        said + &source.unwrap_or_default()
    }

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
    let with_inertia = on_ground(model).filter_map(|(link, place)| {
        let own = description.links.iter().find(|own| own.name == link.name)?;
        Some((place, own.inertial))
    });
    let (place, inertial) = with_inertia.max_by(|a, b| a.1.mass_kg.total_cmp(&b.1.mass_kg))?;
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
    let solids = on_ground(model).flat_map(|(link, place)| geometry.on(&link.name, place));
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

    const URDF: &str = r#"<robot name="r">
      <link name="a"><inertial><mass value="1"/></inertial><collision><origin xyz="1 2 3" rpy="0 1.5707963267948966 0"/>
        <geometry><box size="0.2 0.4 0.6"/></geometry></collision>
        <collision><geometry><sphere radius="0.1"/></geometry></collision></link>
      <link name="b"><collision><geometry><cylinder radius="0.1" length="2"/></geometry></collision>
        <collision><geometry><cone angle="1"/></geometry></collision></link>
      <link name="c"><collision><geometry><box size="1 1"/></geometry></collision></link>
      <link name="d"><collision><geometry><mesh filename="package://no/such.stl"/></geometry></collision></link>
      <link name="e"><collision/></link>
      <joint name="1" type="fixed"><parent link="a"/><child link="b"/></joint>
      <joint name="2" type="fixed"><parent link="a"/><child link="c"/></joint>
      <joint name="3" type="fixed"><parent link="a"/><child link="d"/></joint>
      <joint name="4" type="fixed"><parent link="a"/><child link="e"/></joint>
    </robot>"#;

    fn description() -> Description {
        urdf::parse(URDF, "r.urdf").unwrap()
    }

    #[test]
    fn known_shapes_are_read_and_others_noted() {
        let geometry = Geometry::read(&description(), None);
        let links: Vec<&str> = geometry.shapes.iter().map(|s| s.link.as_str()).collect();
        assert_eq!(links, ["a", "a", "b"]);
        // Turned a quarter about y, the box is as high as it is long.
        let first = &geometry.shapes[0];
        let down = first.pose.rotation.transpose() * Vector3::new(0.0, 0.0, -1.0);
        assert!((first.solid.reach(&down) - 0.1).abs() < 1e-15);
        assert_eq!(first.pose.origin, Vector3::new(1.0, 2.0, 3.0));
        for link in ["b", "c", "d", "e"] {
            let named = |note: &String| note.ends_with(&format!(": {link}"));
            assert!(geometry.notes.iter().any(named), "{link}");
        }
    }

    #[test]
    fn reach_is_that_of_the_solid() {
        let slanted = Vector3::new(0.6, 0.0, 0.8);
        let (radius, half) = (0.1, 0.5);
        let cylinder = Solid::Cylinder { radius, half };
        assert!((cylinder.reach(&slanted) - (0.06 + 0.4)).abs() < 1e-15);
        let capsule = Solid::Capsule { radius, half };
        assert!((capsule.reach(&slanted) - 0.5).abs() < 1e-15);
        let mut cut = description();
        cut.text.truncate(20);
        assert_eq!(Geometry::read(&cut, None).shapes, []);
        assert_eq!(Geometry::read(&cut, None).notes.len(), 1);
    }

    #[test]
    fn both_kinds_of_stl_are_boxed() {
        let folder = tempfile::tempdir().unwrap();
        let text = "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 -2\n\
                    vertex 0 3e0 0\nendloop\nendfacet\nendsolid x\n";
        std::fs::write(folder.path().join("a.stl"), text).unwrap();
        let mut bytes = vec![b'x'; 80];
        bytes.extend(1u32.to_le_bytes());
        for x in [
            0.0f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, -2.0, 0.0, 3.0, 0.0,
        ] {
            bytes.extend(x.to_le_bytes());
        }
        bytes.extend([0, 0]);
        std::fs::create_dir(folder.path().join("meshes")).unwrap();
        std::fs::write(folder.path().join("meshes/B.STL"), &bytes).unwrap();
        let expected = (Vector3::new(0.0, 0.0, -2.0), Vector3::new(1.0, 3.0, 0.0));
        let here = Some(folder.path());
        assert_eq!(mesh_bounds("a.stl", here), Ok(expected));
        let below = folder.path().join("meshes");
        assert_eq!(
            mesh_bounds("package://meshes/B.STL", Some(&below)),
            Ok(expected)
        );
        std::fs::write(folder.path().join("cut.stl"), &bytes[..100]).unwrap();
        for bad in ["cut.stl", "gone.stl", "a.dae"] {
            assert!(mesh_bounds(bad, here).is_err(), "{bad}");
        }
    }

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
