//! Drawn robots stand where the reference has them.

use sesc_model::Snapping;
use sesc_model::tree::Motion;

use super::*;
use crate::robot::{Robot, reference};
use crate::simulate::Simulator;

const OP2: &str = include_str!("../../../robots/op2/op2.urdf");
const LIFT: &str = include_str!("../../../robots/lift_base/lift_base.urdf");
const SKEW: &str = include_str!("../../../robots/skew_humanoid/skew_humanoid.urdf");

fn drawn(text: &str, support: &str) -> (Robot, Skeleton) {
    let robot = Robot::parse(text, "robot.urdf").unwrap();
    let model = robot.model(support, Snapping::Off, None).unwrap();
    let skeleton = Skeleton::of(&model, &robot.description, None);
    (robot, skeleton)
}

#[test]
fn joints_and_the_centre_of_mass_are_where_the_reference_has_them() {
    for (text, support) in [
        (OP2, "r_sole"),
        (OP2, "body_link"),
        (LIFT, "grasp_frame"),
        (SKEW, "right_sole"),
    ] {
        let (robot, skeleton) = drawn(text, support);
        let reference = reference(&robot, support);
        let names: Vec<&str> = robot.description.link_names().collect();
        let mut simulator = Simulator::new(&skeleton.dofs, None, 7);
        for _ in 0..10 {
            let q = simulator.posture();
            let (placed, poses) = (skeleton.place(&q), reference.link_poses(&q));
            for (k, body) in skeleton.bodies.iter().enumerate() {
                let Some(name) = &body.joint else { continue };
                let joint = robot.description.joints.iter().find(|j| j.name == *name);
                // A joint stands at the origin of its child link; a prismatic one walked
                // backwards leaves it.
                let child = names.iter().position(|n| *n == joint.unwrap().child);
                let theirs = poses[child.unwrap()].translation.vector;
                let off = Vector3::from(placed.joint(k)) - theirs;
                let backwards = matches!(body.motion, Motion::Prismatic { .. });
                assert!(off.norm() < 1e-12 || backwards, "{name}: {off}");
            }
            let off = Vector3::from(placed.com()) - reference.com(&q);
            assert!(off.norm() < 1e-12, "{off}");
        }
    }
}

#[test]
fn every_link_with_mass_has_a_capsule_around_its_centre_of_mass() {
    for (text, support) in [(OP2, "r_sole"), (LIFT, "grasp_frame"), (SKEW, "right_sole")] {
        let (robot, skeleton) = drawn(text, support);
        for link in &robot.description.links {
            let own: Vec<&Capsule> = (skeleton.capsules.iter())
                .filter(|c| c.link == link.name && c.part == Part::Link)
                .collect();
            let has_mass = link.inertial.mass_kg > 0.0;
            assert_eq!(own.len(), usize::from(has_mass), "{}", link.name);
            for capsule in own {
                let length = capsule.ends.iter().flatten().copied();
                assert!(capsule.radius > 0.0 && length.sum::<f64>().is_finite());
            }
        }
    }
}

/// A box of 0.2 × 0.1 × 0.02 m under the sole, and a link whose capsule is known in closed
/// form: a rod of uniform density and square section 2 r.
#[test]
fn collision_shapes_give_the_sole_and_inertia_the_thickness() {
    let (edge, length, mass) = (0.04_f64, 0.4_f64, 3.0);
    let along = mass / 12.0 * (edge * edge + edge * edge);
    let across = mass / 12.0 * (edge * edge + length * length);
    let text = format!(
        "<robot name='r'><link name='foot'><collision><origin xyz='0.03 0 0.01'/><geometry>\
         <box size='0.2 0.1 0.02'/></geometry></collision></link><link name='rod'><inertial>\
         <origin xyz='0 0 0.2'/><mass value='{mass}'/><inertia ixx='{across}' iyy='{across}' \
         izz='{along}' ixy='0' ixz='0' iyz='0'/></inertial></link>\
         <joint name='ankle' type='revolute'><origin xyz='0 0 1'/><parent link='foot'/>\
         <child link='rod'/><axis xyz='0 1 0'/><limit lower='-1' upper='1'/></joint></robot>"
    );
    let (_, skeleton) = drawn(&text, "foot");
    let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12;
    for corner in [[0.13, 0.05], [0.13, -0.05], [-0.07, 0.05], [-0.07, -0.05]] {
        let mut sole = skeleton.sole.iter();
        assert!(sole.any(|own| near(*own, corner)), "{corner:?}");
    }
    assert_eq!(skeleton.sole.len(), 4);
    let mut capsules = skeleton.capsules.iter();
    let rod = capsules.find(|c| c.link == "rod" && c.part == Part::Link);
    let rod = rod.unwrap();
    assert!((rod.radius - edge / 2.0).abs() < 1e-12);
    let mut heights = rod.ends.map(|end| end[2]);
    heights.sort_by(f64::total_cmp);
    assert!((heights[0] - edge / 2.0).abs() < 1e-12 && (heights[1] - 0.38).abs() < 1e-12);
    let mut capsules = skeleton.capsules.iter();
    assert!(capsules.any(|c| c.part == Part::Bone && c.body == 0));
}
