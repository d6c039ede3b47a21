//! Bodies that would run into each other, by their collision shapes.
//!
//! Neighbours (bodies that share a joint) are exempt, and so are pairs that
//! already touch at rest: their shapes are drawn larger than the parts.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Matrix3;
use parry3d_f64::bounding_volume::BoundingVolume as _;
use parry3d_f64::glamx::{DMat3, DQuat, DVec3};
use parry3d_f64::math::Pose as Placement;
use parry3d_f64::query::intersection_test;
use parry3d_f64::shape::{Compound, Shape as _, SharedShape};
use sesc_model::Model;

use super::shapes::{Geometry, Solid};
use crate::poses::{self, Pose};

/// Pairs of bodies to watch.
pub(super) struct Collisions {
    /// The collision shapes of each body that has any.
    bodies: BTreeMap<usize, Compound>,
    /// Pairs of bodies that are not compared, the smaller first: neighbours, and `exempt`.
    beside: BTreeSet<(usize, usize)>,
    /// Pairs of bodies that touch at rest, by the names of their links.
    pub(super) exempt: Vec<[String; 2]>,
    /// Pairs of bodies that are watched.
    watched: usize,
    /// Whether any are.
    pub(super) is_checked: bool,
    /// What is watched, in words.
    pub(super) sentence: String,
}

impl Collisions {
    /// All pairs of bodies but neighbours and those that touch at `rest`.
    pub(super) fn new(model: &Model, geometry: &Geometry, rest: &[f64]) -> Collisions {
        let mut parts: BTreeMap<usize, Vec<(Placement, SharedShape)>> = BTreeMap::new();
        for (_, link, body, place) in poses::links(model) {
            for (pose, solid) in geometry.on(&link.name, place) {
                parts.entry(body).or_default().push(part(&pose, solid));
            }
        }
        let parents = model.chain.bodies.iter().enumerate();
        let neighbours = parents.filter_map(|(body, own)| Some(pair(body, own.parent?)));
        let with_shapes = |(a, b): &(usize, usize)| parts.contains_key(a) && parts.contains_key(b);
        let beside: BTreeSet<(usize, usize)> = neighbours.filter(with_shapes).collect();
        let n = parts.len();
        let compounds = parts.into_iter();
        let mut all = Collisions {
            watched: n * n.saturating_sub(1) / 2 - beside.len(),
            bodies: compounds.map(|(k, own)| (k, Compound::new(own))).collect(),
            beside,
            exempt: Vec::new(),
            is_checked: !geometry.shapes.is_empty(),
            sentence: "not checked: the robot has no collision shapes".to_string(),
        };
        let bodies = poses::bodies(&model.chain.bodies, rest);
        let name = |body: usize| model.chain.bodies[body].name.clone();
        let mut touching = BTreeSet::new();
        while let Some(pair) = all.first(&bodies) {
            all.watched -= 1;
            all.beside.insert(pair);
            touching.insert(pair);
        }
        all.exempt = touching.iter().map(|(a, b)| [name(*a), name(*b)]).collect();
        if all.is_checked {
            let (pairs, shapes) = (all.watched, geometry.shapes.len());
            all.sentence =
                format!("{pairs} pairs of bodies by {shapes} shapes; neighbours are exempt");
        }
        all
    }

    /// Two bodies that meet: of those whose boxes overlap from the ground up.
    pub(super) fn first(&self, bodies: &[Pose]) -> Option<(usize, usize)> {
        if self.watched == 0 {
            return None;
        }
        let all = self.bodies.iter().map(|(&body, compound)| {
            let place = placement(&bodies[body]);
            (body, compound, place, compound.compute_aabb(&place))
        });
        let mut all: Vec<_> = all.collect();
        all.sort_by(|a, b| a.3.mins.z.total_cmp(&b.3.mins.z));
        for (k, (a, one, at, around)) in all.iter().enumerate() {
            let above = all[k + 1..].iter();
            for (b, other, there, of_other) in above.take_while(|b| b.3.mins.z <= around.maxs.z) {
                let pair = pair(*a, *b);
                if around.intersects(of_other)
                    && !self.beside.contains(&pair)
                    // All pairs of these shapes are supported.
                    && intersection_test(at, *one, there, *other).is_ok_and(|met| met.intersecting)
                {
                    return Some(pair);
                }
            }
        }
        None
    }
}

fn pair(a: usize, b: usize) -> (usize, usize) {
    (a.min(b), a.max(b))
}

/// A solid of a body, as the library has it.
fn part(pose: &Pose, solid: Solid) -> (Placement, SharedShape) {
    let shape = match solid {
        Solid::Box(half) => SharedShape::cuboid(half.x, half.y, half.z),
        Solid::Sphere { radius } => SharedShape::ball(radius),
        Solid::Capsule { radius, half } => SharedShape::capsule_z(half, radius),
        Solid::Cylinder { radius, half } => {
            // The library's cylinders stand along y.
            let upright = Pose {
                rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0),
                ..Pose::IDENTITY
            };
            let pose = placement(&pose.then(&upright));
            return (pose, SharedShape::cylinder(half, radius));
        }
    };
    (placement(pose), shape)
}

fn placement(pose: &Pose) -> Placement {
    let columns: [[f64; 3]; 3] = pose.rotation.into();
    let rotation = DQuat::from_mat3(&DMat3::from_cols_array_2d(&columns));
    let origin: [f64; 3] = pose.origin.into();
    Placement::from_parts(DVec3::from_array(origin), rotation)
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

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
            collisions.sentence,
            "3 pairs of bodies by 4 shapes; neighbours are exempt"
        );
        assert!(collisions.exempt.is_empty());
        let met = |q: [f64; 3]| {
            let bodies = poses::bodies(&model.chain.bodies, &q);
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
    fn many_shapes_meet_as_the_one_they_make_up() {
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
        assert_eq!(
            many.sentence,
            "3 pairs of bodies by 4000 shapes; neighbours are exempt"
        );
        let mut met = 0;
        for k in 0..200 {
            let q = [0.37, 0.91, 1.73].map(|step| 3.0 * (step * f64::from(k)).sin());
            let bodies = poses::bodies(&model.chain.bodies, &q);
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
        let bodies = poses::bodies(&model.chain.bodies, &[third, third, 0.0]);
        assert_eq!(collisions.first(&bodies), None);
    }
}
