//! The equations of the soles against the reference, and what they tell by closed forms.

use sesc_model::Snapping;

use super::{Closure, Feet, ROWS};
use crate::logs::Sidecar;
use crate::robot::{Robot, reference};
use crate::simulate::Simulator;
use crate::tests::says;

const OP2: &str = include_str!("../../../robots/op2/op2.urdf");
const SKEW: &str = include_str!("../../../robots/skew_humanoid/skew_humanoid.urdf");

fn both() -> Sidecar {
    Sidecar {
        both_feet: Some(true),
        ..Sidecar::default()
    }
}

/// Height and tilt of the other sole are those of its transform, link by link; slopes are
/// differences of them.
#[test]
fn the_other_sole_lies_where_the_reference_has_it() {
    for (urdf, support, other) in [
        (OP2, "r_sole", "l_sole"),
        (OP2, "l_sole", "r_sole"),
        (SKEW, "right_sole", "left_sole"),
    ] {
        let robot = Robot::parse(urdf, "robot.urdf").unwrap();
        let model = robot.model(support, Snapping::Off, None).unwrap();
        let found = Feet::default().of(&both(), &model).unwrap().unwrap();
        assert_eq!(found.name, other);
        let q = Simulator::new(&model.tree.dofs, Some(0.6), 3).batch(4);
        let twin = reference(&robot, support);
        let link = twin.robot().link_index(other).unwrap();
        let lies = |q: &[f64]| {
            let pose = twin.link_poses(q)[link];
            let up = pose.rotation.matrix();
            [pose.translation.z, up[(2, 1)], -up[(2, 0)]]
        };
        let closure = Closure::of(&model, found, &q, None);
        assert_eq!(closure.len(), 4);
        assert_eq!(closure.joints.len(), 12);
        for (k, q) in q.chunks_exact(model.dof()).enumerate() {
            let here = lies(q);
            for (row, here) in here.iter().enumerate() {
                let off = closure.values[ROWS * k + row] - here;
                assert!(off.abs() < 1e-12, "{support} row {row}: {off:e}");
            }
            for (column, joint) in closure.joints.iter().enumerate() {
                let mut dofs = model.tree.dofs.iter();
                let place = dofs.position(|dof| dof.joint == joint.joint).unwrap();
                let [ahead, behind] = [1e-5, -1e-5].map(|by| {
                    let mut moved = q.to_vec();
                    moved[place] += by;
                    lies(&moved)
                });
                for row in 0..ROWS {
                    let slope = (ahead[row] - behind[row]) / 2e-5;
                    let off = closure.slopes[(ROWS * k + row, column)] - slope;
                    assert!(off.abs() < 1e-8, "{support} row {row}: {off:e}");
                }
            }
        }
    }
}

/// A sole that is given by its height lies as the point below its link does, and as a link in the
/// sole would: for the side that is named alike, and for one of another height.
#[test]
fn a_sole_by_its_height_lies_where_the_reference_has_it() {
    let robot = Robot::parse(OP2, "robot.urdf").unwrap();
    let support = "r_ank_roll_link@33.5mm";
    let model = robot.model(support, Snapping::Off, None).unwrap();
    let named = |other: &str| Feet {
        both: Some(true),
        other: Some(other.to_string()),
    };
    for (feet, below) in [
        (Feet::default(), 0.0335),
        (named("l_ank_roll_link@40mm"), 0.04),
        (named("l_ank_roll_link"), 0.0),
    ] {
        let found = feet.of(&both(), &model).unwrap().unwrap();
        assert_eq!(found.below_m, below);
        let q = Simulator::new(&model.tree.dofs, Some(0.6), 3).batch(4);
        let closure = Closure::of(&model, found, &q, None);
        // The same links without a sole, seen from the other sole's link.
        let twin = reference(&robot, "r_ank_roll_link");
        let link = twin.robot().link_index("l_ank_roll_link").unwrap();
        for (k, q) in q.chunks_exact(model.dof()).enumerate() {
            let pose = twin.link_poses(q)[link];
            let up = pose.rotation.matrix();
            let height = 0.0335 + pose.translation.z - below * up[(2, 2)];
            for (row, here) in [height, up[(2, 1)], -up[(2, 0)]].into_iter().enumerate() {
                let off = closure.values[ROWS * k + row] - here;
                assert!(off.abs() < 1e-12, "{below} row {row}: {off:e}");
            }
        }
    }
    for (other, words) in [
        ("l_ank_roll_link@40.0mm", "give `l_ank_roll_link@40mm`"),
        ("l_ank_rol_link@40mm", "did you mean `l_ank_roll_link`"),
        ("r_ank_roll_link@40mm", "does not move against the support"),
    ] {
        says(named(other).of(&both(), &model).unwrap_err(), &[words]);
    }
}

/// Feet on one pelvis, each by a roll and a pitch joint 0.3 m above its sole.
const LEGS: &str = "<robot name='legs'><link name='pelvis'><inertial><mass value='1'/></inertial>\
    </link>\
    <joint name='l_roll' type='revolute'><parent link='pelvis'/><child link='l_leg'/>\
    <origin xyz='0 0.1 0'/><axis xyz='1 0 0'/><limit lower='-1' upper='1'/></joint>\
    <link name='l_leg'><inertial><mass value='1'/></inertial></link>\
    <joint name='l_pitch' type='revolute'><parent link='l_leg'/><child link='l_sole'/>\
    <origin xyz='0 0 -0.3'/><axis xyz='0 1 0'/><limit lower='-1' upper='1'/></joint>\
    <link name='l_sole'/>\
    <joint name='r_roll' type='revolute'><parent link='pelvis'/><child link='r_leg'/>\
    <origin xyz='0 -0.1 0'/><axis xyz='1 0 0'/><limit lower='-1' upper='1'/></joint>\
    <link name='r_leg'><inertial><mass value='1'/></inertial></link>\
    <joint name='r_pitch' type='revolute'><parent link='r_leg'/><child link='r_sole'/>\
    <origin xyz='0 0 -0.3'/><axis xyz='0 1 0'/><limit lower='-1' upper='1'/></joint>\
    <link name='r_sole'/></robot>";

/// Columns of readings lose of a constant what the tolerance allows: n w² of 1 + n w².
#[test]
fn what_is_common_to_all_postures_counts_for_little() {
    let robot = Robot::parse(LEGS, "legs.urdf").unwrap();
    let model = robot.model("r_sole", Snapping::default(), None).unwrap();
    let other = Feet::default().of(&both(), &model).unwrap().unwrap();
    let n = 50;
    let mut closure = Closure::of(&model, other, &vec![0.0; n * model.dof()], None);
    closure.std = [1e-3, 2e-3, 2e-3];
    closure.common = [1e-3, 4e-3, 0.0];
    // 3 mm in all postures, 0.1 rad of roll in one of them, 0.01 rad of pitch in all.
    let mut values = vec![0.0; ROWS * n];
    for k in 0..n {
        values[ROWS * k] = 3e-3;
        values[ROWS * k + 2] = 0.01;
    }
    values[1] = 0.1;
    let residual = closure.whitened(values.into_iter());
    let left = closure.without_common_of(&residual);
    let of = |row: usize| -> f64 {
        let own = left.iter().zip(&residual).skip(row).step_by(ROWS);
        own.map(|(s, e)| s * e).sum()
    };
    let count = n as f64;
    // Σ e² − (Σ e w)² / (1 + n w²)
    let height = count * 9.0 - (count * 3.0).powi(2) / (1.0 + count);
    let roll = 2500.0 - (50.0 * 2.0_f64).powi(2) / (1.0 + count * 4.0);
    let pitch = count * 25.0;
    for (found, expected) in [(of(0), height), (of(1), roll), (of(2), pitch)] {
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    }
}

/// An offset of the left pitch joint turns its sole and nothing else.
#[test]
fn an_offset_is_told_by_the_soles_alone() {
    let robot = Robot::parse(LEGS, "legs.urdf").unwrap();
    let model = robot.model("r_sole", Snapping::default(), None).unwrap();
    let other = || Feet::default().of(&both(), &model).unwrap().unwrap();
    let place = |name: &str| {
        let mut dofs = model.tree.dofs.iter();
        dofs.position(|dof| dof.joint == name).unwrap()
    };
    // Soles on one floor: both pitch alike, no roll.
    let posture = |k: usize, off: f64| {
        let mut q = vec![0.0; model.dof()];
        let pitch = 0.3 * (0.7 * k as f64).sin();
        q[place("r_pitch")] = pitch;
        q[place("l_pitch")] = pitch - off;
        q
    };
    let log = |off: f64| -> Vec<f64> { (0..40).flat_map(|k| posture(k, off)).collect() };
    let found = Closure::of(&model, other(), &log(0.0), None).found();
    assert!(found.closes && found.explained_by.is_empty(), "{found:?}");
    let found = Closure::of(&model, other(), &log(0.03), None).found();
    assert!(!found.closes, "{found:?}");
    assert!((found.before.pitch_rad - 0.03).abs() < 1e-4, "{found:?}");
    assert!(found.before.roll_rad < 1e-12, "{found:?}");
    let is_named = |joint: &str| found.explained_by.iter().any(|o| o.joint == joint);
    assert!(is_named("l_pitch") && !is_named("l_roll"), "{found:?}");
    let size = found.explained_by[0].offset_rad.unwrap().abs();
    // The tolerance of 0.0025 rad takes (0.001/0.0025)²/40 of it.
    assert!((size - 0.03).abs() < 3e-4, "{found:?}");
    says(&found.sentence, &["an offset of"]);
}
