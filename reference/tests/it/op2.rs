//! The OP2 against reference values from two independent rigid-body libraries,
//! printed to a micrometre.

use crate::common::postures;
use nalgebra::Vector3;
use sesc_reference::{Reference, Robot, numeric_rank};

/// Joints that are not at zero, degrees; CoM seen from the trunk and from the
/// right sole, m.
type Case = (&'static [(&'static str, f64)], [f64; 3], [f64; 3]);

const CASES: [Case; 3] = [
    (
        &[],
        [-0.009057, -0.001024, -0.113469],
        [-0.004057, 0.046476, 0.228231],
    ),
    (
        &[
            ("r_hip_pitch", -30.0),
            ("l_hip_pitch", 30.0),
            ("r_knee", 60.0),
            ("l_knee", -60.0),
            ("r_ank_pitch", 30.0),
            ("l_ank_pitch", -30.0),
        ],
        [-0.005248, -0.001024, -0.107861],
        [-0.000248, 0.046476, 0.208920],
    ),
    (
        &[
            ("r_sho_pitch", -48.345),
            ("l_sho_pitch", 41.313),
            ("r_sho_roll", -17.873),
            ("l_sho_roll", 17.580),
            ("r_el", 29.300),
            ("l_el", -29.593),
            ("head_tilt", 40.0),
        ],
        [-0.015976, -0.001012, -0.113098],
        [-0.010976, 0.046488, 0.228602],
    ),
];

fn op2() -> Robot {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/op2/op2.urdf");
    Robot::from_file(path).expect("the OP2's URDF reads")
}

fn posture(robot: &Robot, angles: &[(&str, f64)]) -> Vec<f64> {
    let mut q = vec![0.0; robot.movable_joints().len()];
    for (joint, degrees) in angles {
        q[robot.dof_index(joint).unwrap()] = degrees.to_radians();
    }
    q
}

#[test]
fn com_matches_the_published_poses() {
    let robot = op2();
    for (support, column) in [("body_link", 0), ("r_sole", 1)] {
        let reference = Reference::new(&robot, support).unwrap();
        assert_eq!(reference.dof(), 20);
        assert!((reference.total_mass() - 2.925325).abs() < 1e-6);
        for (angles, from_body, from_sole) in &CASES {
            let expected = Vector3::from([from_body, from_sole][column].to_owned());
            let com = reference.com(&posture(&robot, angles));
            assert!((com - expected).amax() < 1e-6, "{support}: {com}");
        }
    }
}

#[test]
fn the_left_sole_stands_beside_the_right_one() {
    let robot = op2();
    let reference = Reference::new(&robot, "r_sole").unwrap();
    let left = robot.link_index("l_sole").unwrap();
    for (angles, ..) in &CASES {
        let pose = reference.link_poses(&posture(&robot, angles))[left];
        let error = pose.translation.vector - Vector3::new(0.0, 0.095, 0.0);
        assert!(error.norm() < 1e-6, "{pose}");
        assert!(pose.rotation.angle() < 1e-6, "{pose}");
    }
}

/// Twenty revolute joints: 3 + 2 · 20 parameters, one unseen on flat ground.
#[test]
fn rank_is_43_and_42_from_flat_cop() {
    let reference = Reference::new(&op2(), "r_sole").unwrap();
    let postures: Vec<Vec<f64>> = postures(&reference, 80)
        .into_iter()
        .map(|q| q.into_iter().map(|angle| angle / 5.0).collect())
        .collect();
    let rank = |axes| numeric_rank(&reference.stacked_columns(&postures, axes), 1e-9);
    assert_eq!(rank(&[0, 1, 2]), 43);
    assert_eq!(rank(&[0, 1]), 42);
}
