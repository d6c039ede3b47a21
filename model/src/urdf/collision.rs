//! Collision geometry of links, read leniently: what is not understood is told,
//! never a failure.
//!
//! ```text
//! <link><collision><origin xyz rpy/><geometry> box | cylinder | sphere | capsule | mesh
//! ```

use roxmltree::Node;

use super::description::{Description, Origin};
use super::error::Error;
use super::source::{Source, children, links};

/// Larger numbers are no part of a robot, m or rad.
const FAR: f64 = 1e4;

/// A shape about its own centre, m; cylinders and capsules along z.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Shape {
    /// A box.
    Box {
        /// Its edges.
        size: [f64; 3],
    },
    /// A cylinder.
    Cylinder {
        /// Radius of the circle, m.
        radius: f64,
        /// Length of the axis, m.
        length: f64,
    },
    /// A cylinder with half a sphere on each end.
    Capsule {
        /// Radius of the circle and of the spheres, m.
        radius: f64,
        /// Length of the axis without the spheres, m.
        length: f64,
    },
    /// A sphere.
    Sphere {
        /// Radius of the sphere, m.
        radius: f64,
    },
    /// The triangles of a file.
    Mesh {
        /// Its file name in the URDF.
        file: String,
        /// Along each axis.
        scale: [f64; 3],
    },
}

/// A `<collision>` of a link.
#[derive(Debug, Clone, PartialEq)]
pub struct Collision {
    /// In the link frame.
    pub origin: Origin,
    /// What is there.
    pub shape: Shape,
}

/// The collisions of each link in document order; where one cannot be used, why, in a
/// few words.
///
/// # Errors
/// When the text of the description was changed and is no URDF any more.
pub fn collisions(description: &Description) -> Result<Vec<Vec<Result<Collision, String>>>, Error> {
    let source = Source::of(description)?;
    let document = source.document()?;
    let of_link = |link| children(link, "collision").map(collision).collect();
    Ok(links(&document).map(of_link).collect())
}

fn collision(node: Node<'_, '_>) -> Result<Collision, String> {
    let origin = match children(node, "origin").next() {
        Some(origin) => read_origin(origin)?,
        None => Origin::default(),
    };
    let geometry = children(node, "geometry").next();
    let shape = geometry.and_then(|geometry| geometry.first_element_child());
    Ok(Collision {
        origin,
        shape: read_shape(shape.ok_or("no geometry")?)?,
    })
}

fn read_origin(origin: Node<'_, '_>) -> Result<Origin, String> {
    let vector = |name: &str| match origin.attribute(name) {
        None => Ok([0.0; 3]),
        text => numbers(text).ok_or_else(|| format!("an origin with an unreadable {name}")),
    };
    if origin.has_attribute("quat_xyzw") {
        return Err("an origin with a quaternion".to_string());
    }
    Ok(Origin {
        rpy: vector("rpy")?,
        xyz: vector("xyz")?,
    })
}

fn read_shape(shape: Node<'_, '_>) -> Result<Shape, String> {
    let name = shape.tag_name().name();
    let number = |attribute: &str| -> Result<f64, String> {
        numbers(shape.attribute(attribute))
            .filter(|[x]: &[f64; 1]| *x > 0.0)
            .map(|[x]| x)
            .ok_or_else(|| format!("{name} without a usable {attribute}"))
    };
    Ok(match name {
        "box" => {
            let usable = |size: &[f64; 3]| {
                size.iter().all(|edge| *edge >= 0.0) && size.iter().any(|edge| *edge > 0.0)
            };
            let size = numbers(shape.attribute("size")).filter(usable);
            Shape::Box {
                size: size.ok_or("box without a usable size")?,
            }
        }
        "sphere" => Shape::Sphere {
            radius: number("radius")?,
        },
        "cylinder" => Shape::Cylinder {
            radius: number("radius")?,
            length: number("length")?,
        },
        "capsule" => Shape::Capsule {
            radius: number("radius")?,
            length: number("length")?,
        },
        "mesh" => Shape::Mesh {
            file: (shape.attribute("filename"))
                .ok_or("mesh without a filename")?
                .to_string(),
            scale: match shape.attribute("scale") {
                None => [1.0; 3],
                text => numbers(text).ok_or("mesh with an unreadable scale")?,
            },
        },
        other => {
            let name: String = other.chars().take(40).collect();
            return Err(format!("`{name}` is not known"));
        }
    })
}

/// Exactly N finite numbers.
fn numbers<const N: usize>(text: Option<&str>) -> Option<[f64; N]> {
    let values: Option<Vec<f64>> = text?
        .split_whitespace()
        .map(|word| word.parse().ok().filter(|x: &f64| x.abs() < FAR))
        .collect();
    values?.try_into().ok()
}
