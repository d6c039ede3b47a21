//! Where the material of a link can be: the box around its collision geometry.
//!
//! ```text
//! half extent along axis a:   box  Σ_b |R_ab| s_b / 2      sphere  ρ
//! cylinder  ρ √(1 − R_az²) + |R_az| l / 2        capsule  ρ + |R_az| l / 2
//! ```
//!
//! R turns the shape into the link frame. The centre of mass of whatever fills
//! these shapes lies inside the box.

use nalgebra::{Matrix3, Rotation3, Vector3};
use roxmltree::Node;

use super::description::Description;
use super::error::Error;
use super::source::{Source, children, links};

/// A box along the axes of a link frame, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// The corner of the least coordinates.
    pub low: [f64; 3],
    /// The corner of the greatest coordinates.
    pub high: [f64; 3],
}

/// The box of each link in document order; `None` where the file gives no
/// collision geometry, or one of unknown size (a mesh).
///
/// # Errors
/// When the text of the description was changed and is no URDF any more.
pub fn extents(description: &Description) -> Result<Vec<Option<Extent>>, Error> {
    let source = Source::of(description)?;
    let document = source.document()?;
    Ok(links(&document).map(of_link).collect())
}

fn of_link(link: Node<'_, '_>) -> Option<Extent> {
    children(link, "collision")
        .map(of_collision)
        .reduce(|a, b| Some(a?.with(&b?)))
        .flatten()
}

fn of_collision(collision: Node<'_, '_>) -> Option<Extent> {
    let origin = children(collision, "origin").next();
    let triple = |name: &str| match origin.and_then(|origin| origin.attribute(name)) {
        Some(text) => numbers::<3>(text),
        None => Some([0.0; 3]),
    };
    let centre = Vector3::from(triple("xyz")?);
    let [roll, pitch, yaw] = triple("rpy")?;
    if origin.is_some_and(|origin| origin.has_attribute("quat_xyzw")) {
        return None;
    }
    let turn = Rotation3::from_euler_angles(roll, pitch, yaw).into_inner();
    let geometry = children(collision, "geometry").next()?;
    let shape = geometry.first_element_child()?;
    let half = half_extent(shape, &turn)?;
    Some(Extent {
        low: (centre - half).into(),
        high: (centre + half).into(),
    })
}

fn half_extent(shape: Node<'_, '_>, turn: &Matrix3<f64>) -> Option<Vector3<f64>> {
    let number = |name: &str| numbers::<1>(shape.attribute(name)?).map(|[x]| x.abs());
    let up = turn.column(2).map(f64::abs);
    Some(match shape.tag_name().name() {
        "box" => turn.abs() * Vector3::from(numbers::<3>(shape.attribute("size")?)?).abs() / 2.0,
        "sphere" => Vector3::repeat(number("radius")?),
        "cylinder" => {
            let (radius, length) = (number("radius")?, number("length")?);
            up.map(|a| radius * (1.0 - a * a).max(0.0).sqrt() + a * length / 2.0)
        }
        "capsule" => {
            let (radius, length) = (number("radius")?, number("length")?);
            up.map(|a| radius + a * length / 2.0)
        }
        _ => return None,
    })
}

fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let values: Option<Vec<f64>> = text
        .split_whitespace()
        .map(|word| word.parse().ok().filter(|x: &f64| x.is_finite()))
        .collect();
    values?.try_into().ok()
}

impl Extent {
    /// The box around both.
    fn with(&self, other: &Extent) -> Extent {
        Extent {
            low: [0, 1, 2].map(|a| self.low[a].min(other.low[a])),
            high: [0, 1, 2].map(|a| self.high[a].max(other.high[a])),
        }
    }

    /// The box widened to hold a point.
    pub fn holding(&self, point: [f64; 3]) -> Extent {
        self.with(&Extent {
            low: point,
            high: point,
        })
    }

    /// Whether a point is inside, up to `slack` m.
    pub fn holds(&self, point: [f64; 3], slack: f64) -> bool {
        (0..3).all(|a| self.low[a] - slack <= point[a] && point[a] <= self.high[a] + slack)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(collisions: &str) -> Option<Extent> {
        let text = format!(
            "<robot name='r'><link name='a'><inertial><mass value='1'/></inertial>{collisions}</link></robot>"
        );
        extents(&crate::urdf::parse(&text, "r.urdf").unwrap()).unwrap()[0]
    }

    #[test]
    fn shapes_turned_into_the_link_frame() {
        let near = |found: Option<Extent>, low: [f64; 3], high: [f64; 3]| {
            let found = found.unwrap();
            for a in 0..3 {
                assert!((found.low[a] - low[a]).abs() < 1e-12, "{found:?}");
                assert!((found.high[a] - high[a]).abs() < 1e-12, "{found:?}");
            }
        };
        let shape = |origin: &str, shape: &str| {
            format!("<collision><origin {origin}/><geometry>{shape}</geometry></collision>")
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        let brick = shape(
            &format!("xyz='1 0 0' rpy='0 0 {quarter}'"),
            "<box size='2 4 6'/>",
        );
        near(of(&brick), [-1.0, -1.0, -3.0], [3.0, 1.0, 3.0]);
        let lying = shape(
            &format!("rpy='{quarter} 0 0'"),
            "<cylinder radius='1' length='6'/>",
        );
        near(of(&lying), [-1.0, -3.0, -1.0], [1.0, 3.0, 1.0]);
        let ball = shape("xyz='0 0 5'", "<sphere radius='1'/>");
        near(of(&(lying + &ball)), [-1.0, -3.0, -1.0], [1.0, 3.0, 6.0]);
        let mesh = shape("", "<mesh filename='a.stl'/>");
        assert_eq!(of(&(ball + &mesh)), None);
        assert_eq!(of(""), None);
        assert_eq!(of(&shape("", "<box size='1 ${w} 1'/>")), None);
    }
}
