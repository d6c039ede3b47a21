//! Bodies that would run into each other, by their collision shapes.
//!
//! Neighbours (bodies that share a joint) are exempt, and so are pairs that
//! already touch at rest: their shapes are drawn larger than the parts.

use nalgebra::{Matrix3, Vector3};
use parry3d_f64::glamx::{DMat3, DQuat, DVec3};
use parry3d_f64::math::Pose as Placement;
use parry3d_f64::query::intersection_test;
use parry3d_f64::shape::{Ball, Capsule, Cuboid, Cylinder, Shape};
use sesc_model::Model;

use super::geometry::{Geometry, Solid};
use crate::poses::{self, Pose};

/// Pairs of bodies to watch.
pub struct Collisions {
    /// Collision shapes of the robot.
    shapes: usize,
    solids: Vec<Placed>,
    /// Indices into `solids`.
    pairs: Vec<(usize, usize)>,
    /// Pairs of bodies that touch at rest, by the names of their links.
    pub exempt: Vec<[String; 2]>,
    /// Pairs of bodies that are watched.
    pub watched: usize,
}

struct Placed {
    body: usize,
    pose: Pose,
    radius: f64,
    shape: Box<dyn Shape>,
}

impl Collisions {
    /// All pairs of bodies but neighbours and those that touch at `rest`.
    pub fn new(model: &Model, geometry: &Geometry, rest: &[f64]) -> Collisions {
        let mut solids = Vec::new();
        for shape in &geometry.shapes {
            let link = model.tree.links.iter().position(|l| l.name == shape.link);
            if let Some((body, place)) = link.and_then(|link| poses::of_link(model, link)) {
                solids.push(placed(body, place.then(&shape.pose), shape.solid));
            }
        }
        let parent = |body: usize| model.chain.bodies[body].parent;
        let mut all = Collisions {
            shapes: geometry.shapes.len(),
            pairs: Vec::new(),
            exempt: Vec::new(),
            watched: 0,
            solids,
        };
        let mut bodies = Vec::new();
        poses::bodies(model, rest, &mut bodies);
        let worlds = all.worlds(&bodies);
        let (mut touching, mut watched) = (Vec::new(), Vec::new());
        let mut pairs = Vec::new();
        for a in 0..all.solids.len() {
            for b in a + 1..all.solids.len() {
                let (x, y) = (all.solids[a].body, all.solids[b].body);
                if x == y || parent(x) == Some(y) || parent(y) == Some(x) {
                    continue;
                }
                let bodies = (x.min(y), x.max(y));
                pairs.push((a, b, bodies));
                if all.touch(a, b, &worlds) && !touching.contains(&bodies) {
                    touching.push(bodies);
                }
            }
        }
        for (a, b, bodies) in pairs {
            if !touching.contains(&bodies) {
                all.pairs.push((a, b));
                if !watched.contains(&bodies) {
                    watched.push(bodies);
                }
            }
        }
        let name = |body: usize| model.chain.bodies[body].name.clone();
        all.watched = watched.len();
        let names = touching.into_iter().map(|(a, b)| [name(a), name(b)]);
        all.exempt = names.collect();
        all
    }

    /// Whether any bodies are watched.
    pub fn is_checked(&self) -> bool {
        self.shapes > 0
    }

    /// What is watched, in words.
    pub fn sentence(&self) -> String {
        match (self.shapes, self.watched) {
            (0, _) => "not checked: the robot has no collision shapes".to_string(),
            (shapes, pairs) => {
                format!("{pairs} pairs of bodies by {shapes} shapes; neighbours are exempt")
            }
        }
    }

    /// The first two bodies that meet.
    pub fn first(&self, bodies: &[Pose]) -> Option<(usize, usize)> {
        if self.pairs.is_empty() {
            return None;
        }
        let worlds = self.worlds(bodies);
        let mut pairs = self.pairs.iter();
        let met = pairs.find(|(a, b)| self.touch(*a, *b, &worlds))?;
        Some((self.solids[met.0].body, self.solids[met.1].body))
    }

    fn worlds(&self, bodies: &[Pose]) -> Vec<(Vector3<f64>, Placement)> {
        let world = |solid: &Placed| {
            let pose = bodies[solid.body].then(&solid.pose);
            (pose.origin, placement(&pose))
        };
        self.solids.iter().map(world).collect()
    }

    fn touch(&self, a: usize, b: usize, worlds: &[(Vector3<f64>, Placement)]) -> bool {
        let (one, other) = (&self.solids[a], &self.solids[b]);
        let reach = one.radius + other.radius;
        if (worlds[a].0 - worlds[b].0).norm_squared() > reach * reach {
            return false;
        }
        let met = intersection_test(&worlds[a].1, &*one.shape, &worlds[b].1, &*other.shape);
        // All pairs of these shapes are supported.
        met.is_ok_and(|met| met.intersecting)
    }
}

fn placed(body: usize, pose: Pose, solid: Solid) -> Placed {
    // The library's cylinders stand along y.
    let upright = Pose {
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0),
        ..Pose::IDENTITY
    };
    let (shape, pose): (Box<dyn Shape>, Pose) = match solid {
        Solid::Box(half) => (
            Box::new(Cuboid::new(DVec3::new(half.x, half.y, half.z))),
            pose,
        ),
        Solid::Sphere { radius } => (Box::new(Ball::new(radius)), pose),
        Solid::Capsule { radius, half } => (Box::new(Capsule::new_z(half, radius)), pose),
        Solid::Cylinder { radius, half } => {
            (Box::new(Cylinder::new(half, radius)), pose.then(&upright))
        }
    };
    Placed {
        body,
        pose,
        radius: solid.radius(),
        shape,
    }
}

fn placement(pose: &Pose) -> Placement {
    let columns: [f64; 9] = pose
        .rotation
        .as_slice()
        .try_into()
        .expect("a rotation has 9 entries");
    let rotation = DQuat::from_mat3(&DMat3::from_cols_array(&columns));
    Placement::from_parts(
        DVec3::new(pose.origin.x, pose.origin.y, pose.origin.z),
        rotation,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Robot;

    /// Three bars of 1 m on end, a ball on the last; joints about y at their ends.
    fn arm() -> (Model, Geometry) {
        let bar = |name: &str, radius: f64| {
            format!(
                r#"<link name="{name}"><inertial><mass value="1"/></inertial><collision>
                <origin xyz="0 0 0.5"/><geometry><cylinder radius="{radius}" length="0.9"/></geometry>
                </collision></link>"#
            )
        };
        let joint = |parent: &str, child: &str| {
            format!(
                r#"<joint name="{child}_joint" type="continuous"><parent link="{parent}"/>
                <child link="{child}"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/></joint>"#
            )
        };
        let urdf = format!(
            "<robot name=\"arm\">{}{}{}{}{}{}{}</robot>",
            bar("a", 0.05),
            bar("b", 0.05),
            bar("c", 0.05),
            r#"<link name="d"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>"#,
            joint("a", "b"),
            joint("b", "c"),
            joint("c", "d"),
        );
        let robot = Robot::parse(&urdf, "arm.urdf").unwrap();
        let model = robot
            .model("a", sesc_model::Snapping::default(), None)
            .unwrap();
        (model, Geometry::read(&robot.description, None))
    }

    #[test]
    fn bars_that_fold_back_meet() {
        let (model, geometry) = arm();
        let collisions = Collisions::new(&model, &geometry, &[0.0; 3]);
        assert_eq!(
            collisions.sentence(),
            "3 pairs of bodies by 4 shapes; neighbours are exempt"
        );
        assert!(collisions.exempt.is_empty());
        let met = |q: [f64; 3]| {
            let mut bodies = Vec::new();
            poses::bodies(&model, &q, &mut bodies);
            collisions.first(&bodies)
        };
        assert_eq!(met([0.0; 3]), None);
        // A triangle: the tip of c comes back to a.
        let third = 2.0 * std::f64::consts::PI / 3.0;
        assert!(met([third, third, 0.0]).is_some());
        assert_eq!(met([1.0, 1.0, 0.0]), None);
        // Neighbours may overlap: b lies in a here, c beyond it.
        assert_eq!(met([3.1, 0.0, 0.0]), None);
    }

    #[test]
    fn pairs_that_touch_at_rest_are_exempt() {
        let (model, geometry) = arm();
        let third = 2.0 * std::f64::consts::PI / 3.0;
        let collisions = Collisions::new(&model, &geometry, &[third, third, 0.0]);
        assert!(!collisions.exempt.is_empty());
        let mut bodies = Vec::new();
        poses::bodies(&model, &[third, third, 0.0], &mut bodies);
        assert_eq!(collisions.first(&bodies), None);
    }
}
