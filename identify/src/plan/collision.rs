//! Bodies that would run into each other, by their collision shapes.
//!
//! Neighbours (bodies that share a joint) are exempt, and so are pairs that
//! already touch at rest: their shapes are drawn larger than the parts.
//!
//! Spheres around the shapes are swept along the axis on which they are spread most; those that
//! overlap there are compared. A robot of more than [`MOST`] shapes is known by boxes around
//! neighbours on a body, so that what a posture costs does not grow with the square of its shapes.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;

use nalgebra::{Matrix3, Vector3};
use parry3d_f64::glamx::{DMat3, DQuat, DVec3};
use parry3d_f64::math::Pose as Placement;
use parry3d_f64::query::intersection_test;
use parry3d_f64::shape::{Ball, Capsule, Cuboid, Cylinder, Shape};
use sesc_model::Model;

use super::shapes::{Geometry, Solid};
use crate::poses::{self, Pose};

/// Shapes that are compared one by one; more are in boxes, so many for all bodies together.
const MOST: usize = 1024;

/// Pairs of bodies to watch.
pub struct Collisions {
    /// Collision shapes of the robot.
    shapes: usize,
    solids: Vec<Placed>,
    /// Pairs of bodies that are not compared, the smaller first: neighbours, and `exempt`.
    beside: BTreeSet<(usize, usize)>,
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
        let links = model.tree.links.iter().enumerate();
        let links: BTreeMap<&str, usize> = links.map(|(k, link)| (link.name.as_str(), k)).collect();
        let mut of_bodies: BTreeMap<usize, Vec<(Pose, Solid)>> = BTreeMap::new();
        for shape in &geometry.shapes {
            let link = links.get(shape.link.as_str());
            if let Some((body, place)) = link.and_then(|link| poses::of_link(model, *link)) {
                let solids = of_bodies.entry(body).or_default();
                solids.push((place.then(&shape.pose), shape.solid));
            }
        }
        if geometry.shapes.len() > MOST {
            let each = (MOST / of_bodies.len().max(1)).max(1);
            for solids in of_bodies.values_mut() {
                *solids = boxes(solids, each);
            }
        }
        let parents = model.chain.bodies.iter().enumerate();
        let neighbours = parents.filter_map(|(body, own)| Some(pair(body, own.parent?)));
        let mut all = Collisions {
            shapes: geometry.shapes.len(),
            beside: neighbours.collect(),
            exempt: Vec::new(),
            watched: 0,
            solids: Vec::new(),
        };
        for (body, solids) in &of_bodies {
            let solids = solids.iter();
            all.solids
                .extend(solids.map(|(pose, solid)| placed(*body, *pose, *solid)));
        }
        let mut bodies = Vec::new();
        poses::bodies(model, rest, &mut bodies);
        let mut touching = BTreeSet::new();
        let _: ControlFlow<()> = all.meetings(&bodies, |a, b| {
            touching.insert(pair(a, b));
            ControlFlow::Continue(())
        });
        let with_shapes =
            |(a, b): &&(usize, usize)| [a, b].iter().all(|x| of_bodies.contains_key(*x));
        let n = of_bodies.len();
        let of_neighbours = all.beside.iter().filter(with_shapes).count();
        all.watched = n * n.saturating_sub(1) / 2 - of_neighbours - touching.len();
        let name = |body: usize| model.chain.bodies[body].name.clone();
        all.exempt = touching.iter().map(|(a, b)| [name(*a), name(*b)]).collect();
        all.beside.extend(touching);
        all
    }

    /// Whether any bodies are watched.
    pub fn is_checked(&self) -> bool {
        self.shapes > 0
    }

    /// What is watched, in words.
    pub fn sentence(&self) -> String {
        let (shapes, pairs) = (self.shapes, self.watched);
        if shapes == 0 {
            return "not checked: the robot has no collision shapes".to_string();
        }
        let mut boxes = String::new();
        if self.solids.len() < shapes {
            boxes = format!("{} boxes around ", self.solids.len());
        }
        format!("{pairs} pairs of bodies by {boxes}{shapes} shapes; neighbours are exempt")
    }

    /// Two bodies that meet.
    pub fn first(&self, bodies: &[Pose]) -> Option<(usize, usize)> {
        if self.watched == 0 {
            return None;
        }
        self.meetings(bodies, |a, b| ControlFlow::Break(pair(a, b)))
            .break_value()
    }

    /// Pairs of bodies that meet and are compared, each as often as shapes of them do.
    fn meetings<B>(
        &self,
        bodies: &[Pose],
        mut met: impl FnMut(usize, usize) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let worlds = self.worlds(bodies);
        let spread = |axis: &usize| {
            let all = || worlds.iter().map(|(origin, _)| origin[*axis]);
            all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min)
        };
        let axis = (0..3)
            .max_by(|a, b| spread(a).total_cmp(&spread(b)))
            .unwrap_or(0);
        let from = |k: usize| worlds[k].0[axis] - self.solids[k].radius;
        let mut order: Vec<usize> = (0..worlds.len()).collect();
        order.sort_by(|a, b| from(*a).total_cmp(&from(*b)));
        let mut open: Vec<usize> = Vec::new();
        for b in order {
            open.retain(|a| worlds[*a].0[axis] + self.solids[*a].radius >= from(b));
            for &a in &open {
                let (x, y) = (self.solids[a].body, self.solids[b].body);
                let compared = x != y && !self.beside.contains(&pair(x, y));
                if compared && self.touch(a, b, &worlds) {
                    met(x, y)?;
                }
            }
            open.push(b);
        }
        ControlFlow::Continue(())
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

fn pair(a: usize, b: usize) -> (usize, usize) {
    (a.min(b), a.max(b))
}

/// At most `most` boxes around the solids of a body, each around neighbours on the axis on which
/// they are spread most.
fn boxes(solids: &[(Pose, Solid)], most: usize) -> Vec<(Pose, Solid)> {
    if solids.len() <= most {
        return solids.to_vec();
    }
    let bounds = |(pose, solid): &(Pose, Solid)| {
        let reach = Vector3::from_fn(|axis, _| solid.reach(&pose.rotation.row(axis).transpose()));
        (pose.origin - reach, pose.origin + reach)
    };
    let around = |all: &[(Vector3<f64>, Vector3<f64>)]| {
        let all = all.iter().copied();
        let whole = all.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)));
        whole.unwrap_or_default()
    };
    let mut all: Vec<_> = solids.iter().map(bounds).collect();
    let (low, high) = around(&all);
    let axis = (high - low).imax();
    let middle = |of: &(Vector3<f64>, Vector3<f64>)| of.0[axis] + of.1[axis];
    all.sort_by(|a, b| middle(a).partial_cmp(&middle(b)).unwrap_or(Ordering::Equal));
    let groups = all.chunks(all.len().div_ceil(most)).map(around);
    let boxed = groups.map(|(low, high)| {
        let pose = Pose {
            origin: (low + high) / 2.0,
            ..Pose::IDENTITY
        };
        (pose, Solid::Box((high - low) / 2.0))
    });
    boxed.collect()
}

fn placed(body: usize, pose: Pose, solid: Solid) -> Placed {
    // The library's cylinders stand along y.
    let upright = Pose {
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0),
        ..Pose::IDENTITY
    };
    let is_cylinder = matches!(solid, Solid::Cylinder { .. });
    let shape: Box<dyn Shape> = match solid {
        Solid::Box(half) => Box::new(Cuboid::new(DVec3::new(half.x, half.y, half.z))),
        Solid::Sphere { radius } => Box::new(Ball::new(radius)),
        Solid::Capsule { radius, half } => Box::new(Capsule::new_z(half, radius)),
        Solid::Cylinder { radius, half } => Box::new(Cylinder::new(half, radius)),
    };
    Placed {
        body,
        pose: if is_cylinder {
            pose.then(&upright)
        } else {
            pose
        },
        radius: solid.radius(),
        shape,
    }
}

fn placement(pose: &Pose) -> Placement {
    let columns: [[f64; 3]; 3] = pose.rotation.into();
    let rotation = DQuat::from_mat3(&DMat3::from_cols_array_2d(&columns));
    let origin: [f64; 3] = pose.origin.into();
    Placement::from_parts(DVec3::from_array(origin), rotation)
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

    /// A box for each bar, and a thousand slices of it, meet in the same postures.
    #[test]
    fn many_shapes_are_boxes_around_them() {
        let (model, mut whole) = arm();
        let mut slices = Geometry::default();
        for shape in &mut whole.shapes {
            let half = Vector3::from_fn(|axis, _| shape.solid.reach(&Vector3::ith(axis, 1.0)));
            shape.solid = Solid::Box(half);
            let long = half.imax();
            for k in 0..1000 {
                let mut slice = shape.clone();
                let (mut centre, mut thin) = (Vector3::zeros(), half);
                centre[long] = half[long] * (2.0 * (f64::from(k) + 0.5) / 1000.0 - 1.0);
                thin[long] /= 1000.0;
                slice.pose.origin = shape.pose.point(&centre);
                slice.solid = Solid::Box(thin);
                slices.shapes.push(slice);
            }
        }
        let [few, many] = [&whole, &slices].map(|of| Collisions::new(&model, of, &[0.0; 3]));
        assert_eq!((few.solids.len(), many.solids.len()), (4, 1000));
        assert_eq!(
            many.sentence(),
            "3 pairs of bodies by 1000 boxes around 4000 shapes; neighbours are exempt"
        );
        let mut met = 0;
        for k in 0..200 {
            let q = [0.37, 0.91, 1.73].map(|step| 3.0 * (step * f64::from(k)).sin());
            let mut bodies = Vec::new();
            poses::bodies(&model, &q, &mut bodies);
            let [one, other] = [&few, &many].map(|all| all.first(&bodies).is_some());
            assert_eq!(one, other, "{q:?}");
            met += usize::from(one);
        }
        assert!((20..180).contains(&met), "{met}");
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
