//! What can be wrong between encoder and joint, and with masses.

use crate::common::{bushy_on_sole, postures, stick};

const NAMES: [&str; 5] = ["hip", "knee", "ankle", "shoulder", "slide"];

#[test]
fn exchanged_plugs_exchange_angles_not_faults() {
    let (_, reference, plain) = bushy_on_sole();
    assert_eq!(reference.joint_names(), NAMES);
    let world = plain
        .clone()
        .joint_swap("hip", "ankle")
        .unwrap()
        .joint_offset("hip", 0.1)
        .unwrap()
        .joint_scale("ankle", 2.0)
        .unwrap();
    for q in postures(&reference, 10) {
        let bent = [q[2] + 0.1, q[1], 2.0 * q[0], q[3], q[4]];
        assert_eq!(world.true_posture(&q), bent);
    }
    // Exchanged twice is not at all.
    let again = plain.joint_swap("hip", "ankle").unwrap();
    let again = again.joint_swap("hip", "ankle").unwrap();
    let q = &postures(&reference, 1)[0];
    assert_eq!(&again.true_posture(q), q);
}

#[test]
fn degrees_are_read_as_radians() {
    let world = bushy_on_sole().2.joints_in_degrees();
    let joints = world.true_posture(&[180.0, 90.0, -45.0, 0.0, 12.0]);
    let expected = [180.0, 90.0, -45.0, 0.0].map(f64::to_radians);
    for (joint, expected) in joints.iter().zip(expected) {
        assert!((joint - expected).abs() < 1e-15);
    }
    // Prismatic positions are in millimetres.
    assert!((joints[4] - 0.012).abs() < 1e-17);
}

#[test]
fn a_gear_that_is_not_round_errs_with_its_angle() {
    let world = stick().gear_error("ankle", 0.02, 2.0, 0.3).unwrap();
    for q in [-1.0, 0.0, 0.4, 2.0_f64] {
        let joint = world.true_posture(&[q])[0];
        assert!((joint - (q + 0.02 * (2.0 * q + 0.3).sin())).abs() < 1e-15);
    }
}

#[test]
fn a_link_described_wrongly_moves_the_mean() {
    let world = stick();
    // Alone it is all there is: its mass does not show, its place does.
    let heavy = world.clone().link_mass("stick", 3.0, [0.0; 3]).unwrap();
    assert_eq!(heavy.com(&[0.2]), world.com(&[0.2]));
    let shifted = world.clone().link_mass("stick", 1.0, [0.01, 0.0, 0.1]);
    let shifted = shifted.unwrap();
    let (sin, cos) = 0.2_f64.sin_cos();
    assert!((shifted.com(&[0.2]).x - (0.6 * sin + 0.01 * cos)).abs() < 1e-15);
    // Beside another mass of its size it does.
    let beside = world.payload("foot", 2.0, [0.0; 3]).unwrap();
    let beside = beside.link_mass("stick", 0.5, [0.0; 3]).unwrap();
    assert!((beside.com(&[0.2]).x - 0.5 * sin / 3.0).abs() < 1e-15);
}
