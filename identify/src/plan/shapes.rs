//! Collision shapes of a robot as solids: what is not understood is a note, never a
//! failure.
//!
//! A mesh is taken as the box around it where its file can be read: STL, binary or text.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use nalgebra::{Rotation3, Vector3};
use sesc_model::files;
use sesc_model::text::listed;
use sesc_model::urdf::{self, Collision, Description, Origin};

use crate::poses::Pose;

/// A solid about its own centre, m; cylinders and capsules along z.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Solid {
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
pub struct Shape {
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
    pub shapes: Vec<Shape>,
    /// What could not be read.
    pub notes: Vec<String>,
}

impl Solid {
    /// How far it reaches from its centre along the unit vector `along`, given in its frame.
    pub fn reach(&self, along: &Vector3<f64>) -> f64 {
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
        // What is wrong, and with which links.
        let mut ignored: BTreeMap<String, Vec<String>> = BTreeMap::new();
        let mut boxed: Vec<String> = Vec::new();
        for (name, collisions) in description.link_names().zip(found) {
            for collision in collisions {
                match collision.and_then(|collision| solid(&collision, folder)) {
                    Ok((pose, solid, is_mesh)) => {
                        let link = name.to_string();
                        if is_mesh {
                            boxed.push(link.clone());
                        }
                        geometry.shapes.push(Shape { link, pose, solid });
                    }
                    Err(reason) => ignored.entry(reason).or_default().push(name.to_string()),
                }
            }
        }
        let boxed = ("meshes taken as the boxes around them".to_string(), boxed);
        let ignored = ignored.into_iter();
        let ignored =
            ignored.map(|(why, links)| (format!("collision shape ignored ({why})"), links));
        for (what, mut links) in [boxed].into_iter().chain(ignored) {
            links.dedup();
            if !links.is_empty() {
                let note = format!("{what}: {}", listed(&links, 12));
                geometry.notes.push(note);
            }
        }
        geometry
    }

    /// Solids of a link, in the frame of the body in which the link has its `place`.
    pub fn on<'g>(
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

/// Pose and solid of a collision, and whether it is a mesh.
fn solid(collision: &Collision, folder: Option<&Path>) -> Result<(Pose, Solid, bool), String> {
    let pose = at(&collision.origin);
    let plain = match &collision.shape {
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
            return Ok((pose.then(&centre), Solid::Box((b - a).abs() / 2.0), true));
        }
        _ => return Err("a shape that is not known".to_string()),
    };
    Ok((pose, plain, false))
}

/// Lowest and highest corner of the mesh, m, before scaling.
///
/// # Errors
/// Why the mesh is left out, in a few words.
pub fn mesh_bounds(
    name: &str,
    folder: Option<&Path>,
) -> Result<(Vector3<f64>, Vector3<f64>), String> {
    let stl = name.to_ascii_lowercase().ends_with(".stl");
    if !stl {
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
        return folder
            .ancestors()
            .map(|above| above.join(path))
            .find(is_file);
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
}
