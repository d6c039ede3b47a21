//! Collision shapes of a URDF, read leniently: what is not understood is a
//! note, never a failure.
//!
//! ```text
//! <link><collision><origin xyz rpy/><geometry> box | cylinder | sphere | capsule | mesh
//! ```
//!
//! A mesh is taken as the box around it where its file can be read, see
//! `super::mesh`.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{Rotation3, Vector3};
use roxmltree::{Document, Node};
use sesc_model::text::listed;

use super::mesh;
use super::poses::Pose;

/// A solid about its own centre, m; cylinders and capsules along z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Solid {
    /// Half the edges.
    Box(Vector3<f64>),
    Cylinder {
        radius: f64,
        half: f64,
    },
    Capsule {
        radius: f64,
        half: f64,
    },
    Sphere {
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

    /// Radius of the sphere around it.
    pub fn radius(&self) -> f64 {
        match *self {
            Solid::Box(half) => half.norm(),
            Solid::Cylinder { radius, half } => radius.hypot(half),
            Solid::Capsule { radius, half } => radius + half,
            Solid::Sphere { radius } => radius,
        }
    }
}

impl Geometry {
    /// Read the collision elements of a URDF; `folder` is where its meshes may be.
    pub fn read(urdf: &str, folder: Option<&Path>) -> Geometry {
        let mut geometry = Geometry::default();
        let document = match Document::parse(urdf.trim_start_matches('\u{feff}')) {
            Ok(document) => document,
            Err(error) => {
                geometry
                    .notes
                    .push(format!("collision shapes cannot be read: {error}"));
                return geometry;
            }
        };
        // What is wrong, and with which links.
        let mut ignored: BTreeMap<String, Vec<String>> = BTreeMap::new();
        let mut boxed: Vec<String> = Vec::new();
        for link in children(document.root_element(), "link") {
            let name = link.attribute("name").unwrap_or("").trim();
            for collision in children(link, "collision") {
                match shape(collision, folder) {
                    Ok((pose, solid, is_mesh)) => {
                        geometry.shapes.push(Shape {
                            link: name.to_string(),
                            pose,
                            solid,
                        });
                        if is_mesh && !boxed.iter().any(|link| link == name) {
                            boxed.push(name.to_string());
                        }
                    }
                    Err(reason) => ignored.entry(reason).or_default().push(name.to_string()),
                }
            }
        }
        if !boxed.is_empty() {
            let note = format!(
                "meshes taken as the boxes around them: {}",
                listed(&boxed, 12)
            );
            geometry.notes.push(note);
        }
        for (reason, mut links) in ignored {
            links.dedup();
            geometry.notes.push(format!(
                "collision shape ignored ({reason}): {}",
                listed(&links, 12)
            ));
        }
        geometry
    }
}

fn children<'a, 'd: 'a>(
    node: Node<'a, 'd>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'd>> {
    node.children()
        .filter(move |child| child.tag_name().name() == name)
}

/// Pose and solid of a `<collision>`, and whether it is a mesh.
fn shape(collision: Node, folder: Option<&Path>) -> Result<(Pose, Solid, bool), String> {
    let origin = match children(collision, "origin").next() {
        Some(origin) => pose(origin)?,
        None => Pose::IDENTITY,
    };
    let geometry = children(collision, "geometry").next();
    let solid = geometry.and_then(|g| g.children().find(Node::is_element));
    let solid = solid.ok_or("no geometry")?;
    let length = |attribute: &str| -> Result<f64, String> {
        numbers(solid.attribute(attribute))
            .filter(|[x]: &[f64; 1]| *x > 0.0)
            .map(|[x]| x)
            .ok_or_else(|| format!("{} without a usable {attribute}", solid.tag_name().name()))
    };
    let plain = |solid| Ok((origin, solid, false));
    match solid.tag_name().name() {
        "box" => {
            let size = numbers(solid.attribute("size")).map(Vector3::from);
            let size = size.filter(|size| size.min() >= 0.0 && size.max() > 0.0);
            plain(Solid::Box(size.ok_or("box without a usable size")? / 2.0))
        }
        "sphere" => plain(Solid::Sphere {
            radius: length("radius")?,
        }),
        "cylinder" => plain(Solid::Cylinder {
            radius: length("radius")?,
            half: length("length")? / 2.0,
        }),
        "capsule" => plain(Solid::Capsule {
            radius: length("radius")?,
            half: length("length")? / 2.0,
        }),
        "mesh" => {
            let file = solid
                .attribute("filename")
                .ok_or("mesh without a filename")?;
            let scale = solid
                .attribute("scale")
                .map_or(Some([1.0; 3]), |s| numbers(Some(s)));
            let scale = Vector3::from(scale.ok_or("mesh with an unreadable scale")?);
            let (low, high) = mesh::bounds(file, folder)?;
            let (a, b) = (low.component_mul(&scale), high.component_mul(&scale));
            let centre = Pose {
                origin: (a + b) / 2.0,
                ..Pose::IDENTITY
            };
            Ok((origin.then(&centre), Solid::Box((b - a).abs() / 2.0), true))
        }
        other => Err(format!(
            "`{}` is not known",
            other.chars().take(40).collect::<String>()
        )),
    }
}

fn pose(origin: Node) -> Result<Pose, String> {
    let vector = |name: &str| match origin.attribute(name) {
        None => Ok([0.0; 3]),
        text => numbers(text).ok_or_else(|| format!("an origin with an unreadable {name}")),
    };
    if origin.attribute("quat_xyzw").is_some() {
        return Err("an origin with a quaternion".to_string());
    }
    let [roll, pitch, yaw] = vector("rpy")?;
    Ok(Pose {
        rotation: *Rotation3::from_euler_angles(roll, pitch, yaw).matrix(),
        origin: Vector3::from(vector("xyz")?),
    })
}

/// Exactly N finite numbers.
fn numbers<const N: usize>(text: Option<&str>) -> Option<[f64; N]> {
    let values: Vec<f64> = text?
        .split_whitespace()
        .map(|x| x.parse().ok())
        .collect::<Option<_>>()?;
    let values: [f64; N] = values.try_into().ok()?;
    values
        .iter()
        .all(|x| x.is_finite() && x.abs() < 1e4)
        .then_some(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    const URDF: &str = r#"<robot name="r">
      <link name="a"><collision><origin xyz="1 2 3" rpy="0 1.5707963267948966 0"/>
        <geometry><box size="0.2 0.4 0.6"/></geometry></collision>
        <collision><geometry><sphere radius="0.1"/></geometry></collision></link>
      <link name="b"><collision><geometry><cylinder radius="0.1" length="2"/></geometry></collision>
        <collision><geometry><cone angle="1"/></geometry></collision></link>
      <link name="c"><collision><geometry><box size="1 1"/></geometry></collision></link>
      <link name="d"><collision><geometry><mesh filename="package://no/such.stl"/></geometry></collision></link>
      <link name="e"><collision/></link>
    </robot>"#;

    #[test]
    fn known_shapes_are_read_and_others_noted() {
        let geometry = Geometry::read(URDF, None);
        let links: Vec<&str> = geometry.shapes.iter().map(|s| s.link.as_str()).collect();
        assert_eq!(links, ["a", "a", "b"]);
        // Turned a quarter about y, the box is as high as it is long.
        let first = &geometry.shapes[0];
        let down = first.pose.rotation.transpose() * Vector3::new(0.0, 0.0, -1.0);
        assert!((first.solid.reach(&down) - 0.1).abs() < 1e-15);
        assert_eq!(first.pose.origin, Vector3::new(1.0, 2.0, 3.0));
        for link in ["b", "c", "d", "e"] {
            let named = |note: &String| note.ends_with(&format!(": {link}"));
            assert!(
                geometry.notes.iter().any(named),
                "{link}: {:?}",
                geometry.notes
            );
        }
    }

    #[test]
    fn reach_is_that_of_the_solid() {
        let slanted = Vector3::new(0.6, 0.0, 0.8);
        let cylinder = Solid::Cylinder {
            radius: 0.1,
            half: 0.5,
        };
        assert!((cylinder.reach(&slanted) - (0.06 + 0.4)).abs() < 1e-15);
        let capsule = Solid::Capsule {
            radius: 0.1,
            half: 0.5,
        };
        assert!((capsule.reach(&slanted) - 0.5).abs() < 1e-15);
        assert_eq!(Geometry::read("<robot", None).shapes, []);
        assert_eq!(Geometry::read("<robot", None).notes.len(), 1);
    }
}
