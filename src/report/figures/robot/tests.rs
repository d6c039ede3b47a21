//! Drawings of robots: where the reference has them, sound, and marked.

use super::{Marks, Pictured, sheet};
use crate::OP2_URDF;
use crate::report::svg::tests::sound;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_identify::skeleton::Skeleton;
use sesc_model::Snapping;

const LIFT: &str = include_str!("../../../../robots/lift_base/lift_base.urdf");
/// A drawing is written to a tenth of a pixel.
const PIXEL: f64 = 0.06;

fn skeleton(text: &str, support: &str) -> Skeleton {
    let robot = Robot::parse(text, "robot.urdf").unwrap();
    let model = robot.model(support, Snapping::Off, None).unwrap();
    Skeleton::of(&model, &robot.description, None)
}

fn postures(skeleton: &Skeleton, count: usize) -> Vec<Vec<f64>> {
    let mut simulator = Simulator::new(&skeleton.dofs, Some(0.6), 5);
    (0..count).map(|_| simulator.posture()).collect()
}

fn pictured<'s>(skeleton: &'s Skeleton, q: &'s [Vec<f64>], marks: Marks) -> Pictured<'s> {
    Pictured {
        skeleton,
        postures: q.iter().map(Vec::as_slice).collect(),
        shown: 1,
        cop: vec![[0.01, 0.02], [f64::NAN, 0.0]],
        marks,
    }
}

/// Joints in the drawing against the link poses of the reference, through the camera that the
/// drawing states.
#[test]
fn drawn_joints_are_where_the_reference_has_them() {
    for (text, support) in [
        (OP2_URDF, "r_sole"),
        (OP2_URDF, "body_link"),
        (LIFT, "base_link"),
    ] {
        let skeleton = skeleton(text, support);
        let q = postures(&skeleton, 4);
        let robot = sesc_reference::Robot::from_urdf(text).unwrap();
        let reference = sesc_reference::Reference::new(&robot, support).unwrap();
        let poses = reference.link_poses(&q[1]);
        let description = Robot::parse(text, "robot.urdf").unwrap().description;
        let links: Vec<&str> = description.link_names().collect();
        for svg in pictured(&skeleton, &q, Marks::default()).views() {
            let tree = roxmltree::Document::parse(&svg).unwrap();
            let mut nodes = tree.descendants();
            let view = nodes.find_map(|node| node.attribute("data-view")).unwrap();
            let view = view.split(' ').map(|x| x.parse().unwrap());
            let view: Vec<f64> = view.collect();
            let along = |from: usize, at: [f64; 3]| -> f64 {
                (0..3).map(|i| view[from + i] * at[i]).sum::<f64>() * view[9]
            };
            let mut compared = 0;
            for joint in tree.descendants().filter(|n| n.has_attribute("data-j")) {
                let title = joint.first_element_child().unwrap();
                let name = title.text().unwrap();
                let own = description.joints.iter().find(|j| j.name == name).unwrap();
                let child = links.iter().position(|link| *link == own.child).unwrap();
                let at = poses[child].translation.vector.into();
                let disc = joint.last_element_child().unwrap();
                let read = |name: &str| disc.attribute(name).unwrap().parse::<f64>().unwrap();
                let off = [
                    read("cx") - view[10] - along(0, at),
                    read("cy") - view[11] + along(3, at),
                ];
                assert!(off.iter().all(|x| x.abs() < PIXEL), "{name}: {off:?}");
                compared += 1;
            }
            assert_eq!(compared, skeleton.bodies.len() - 1);
        }
    }
}

#[test]
fn what_is_suspected_is_marked_and_named() {
    let skeleton = skeleton(OP2_URDF, "r_sole");
    let q = postures(&skeleton, 3);
    let knee = skeleton.carried_by("r_hip_pitch").unwrap();
    let marks = Marks {
        joints: vec![
            (knee, "r_hip_pitch".to_string()),
            (knee, "<and> another".to_string()),
        ],
        links: vec!["head_tilt_link".to_string()],
        moved: vec![("body_link".to_string(), 2.0)],
        arrows: vec![(knee, [[0.0; 3], [0.0, 0.001, 0.0]])],
        every_joint: false,
    };
    for svg in pictured(&skeleton, &q, marks).views() {
        let texts = sound(&svg);
        for name in ["r_hip_pitch", "<and> another", "head_tilt_link"] {
            assert!(texts.iter().any(|text| text == name), "{name}");
        }
        assert_eq!(svg.matches("class=\"orange\" cx").count(), 1, "one joint");
        let orange = svg.matches("class=\"orange\" d").count();
        let blue = svg.matches("class=\"blue\" d").count();
        // A link, an arrow.
        assert!((1..=2).contains(&orange) && blue == 1, "{orange}, {blue}");
    }
    let all = Marks {
        every_joint: true,
        ..Marks::default()
    };
    let [front, _] = pictured(&skeleton, &q, all).views();
    let marked = front.matches("class=\"orange\" cx").count();
    assert_eq!(marked, skeleton.bodies.len() - 1);
}

#[test]
fn a_contact_sheet_has_a_picture_of_each_posture() {
    let skeleton = skeleton(OP2_URDF, "r_sole");
    let q = postures(&skeleton, 7);
    let rows: Vec<&[f64]> = q.iter().map(Vec::as_slice).collect();
    let pictures = sheet(&skeleton, &rows);
    assert_eq!(pictures.len(), 7);
    for (k, svg) in pictures.iter().enumerate() {
        assert!(roxmltree::Document::parse(svg).is_ok() && !svg.contains("NaN"));
        assert!(svg.contains(&format!("aria-label=\"posture {}\"", k + 1)));
        assert!(pictures[..k].iter().all(|other| other != svg));
    }
    assert!(sheet(&skeleton, &[]).is_empty());
}

/// Postures that are too short or no numbers, and a robot that is a point.
#[test]
fn odd_robots_give_sound_drawings() {
    let point = "<robot name='&lt;p&gt;'><link name='a'><inertial><mass value='1'/></inertial></link></robot>";
    for (text, support) in [(point, "a"), (OP2_URDF, "r_sole")] {
        let skeleton = skeleton(text, support);
        let q = vec![vec![], vec![f64::NAN; 20], vec![1e300; 3]];
        for svg in pictured(&skeleton, &q, Marks::default()).views() {
            sound(&svg);
        }
        let none = Pictured {
            postures: Vec::new(),
            ..pictured(&skeleton, &[], Marks::default())
        };
        none.views().iter().for_each(|svg| drop(sound(svg)));
    }
}
