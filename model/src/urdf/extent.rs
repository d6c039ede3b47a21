//! Where the material of a link can be: the box around its collision geometry.
//!
//! ```text
//! half extent along axis a:   box  Σ_b |R_ab| s_b / 2      sphere  ρ
//! cylinder  ρ √(1 − R_az²) + |R_az| l / 2        capsule  ρ + |R_az| l / 2
//! ```
//!
//! R rotates the shape into the link frame. The centre of mass of whatever fills
//! these shapes lies inside the box.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::collision::{Collision, Shape, collisions};
use super::description::{Description, Extent};
use super::error::Error;

/// The box of each link in document order; `None` where the file gives no
/// collision geometry, or one of unknown size (a mesh).
///
/// # Errors
/// When the text of the description was changed and is no URDF any more.
pub fn extents(description: &Description) -> Result<Vec<Option<Extent>>, Error> {
    let of_link = |found: Vec<Result<Collision, String>>| {
        let boxes = found.into_iter().map(|one| of_collision(&one.ok()?));
        boxes.reduce(|a, b| Some(a?.with(&b?))).flatten()
    };
    Ok(collisions(description)?.into_iter().map(of_link).collect())
}

fn of_collision(collision: &Collision) -> Option<Extent> {
    let centre = Vector3::from(collision.origin.xyz);
    let [roll, pitch, yaw] = collision.origin.rpy;
    let rotation = Rotation3::from_euler_angles(roll, pitch, yaw).into_inner();
    let half = half_extent(&collision.shape, &rotation)?;
    Some(Extent {
        low: (centre - half).into(),
        high: (centre + half).into(),
    })
}

fn half_extent(shape: &Shape, rotation: &Matrix3<f64>) -> Option<Vector3<f64>> {
    let up = rotation.column(2).map(f64::abs);
    Some(match *shape {
        Shape::Box { size } => rotation.abs() * Vector3::from(size) / 2.0,
        Shape::Sphere { radius } => Vector3::repeat(radius),
        Shape::Cylinder { radius, length } => {
            up.map(|a| radius * (1.0 - a * a).max(0.0).sqrt() + a * length / 2.0)
        }
        Shape::Capsule { radius, length } => up.map(|a| radius + a * length / 2.0),
        Shape::Mesh { .. } => return None,
    })
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
    fn shapes_are_rotated_into_the_link_frame() {
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
