//! Each imperfection against its own formula.

use crate::common::{bushy_on_sole, kind, near, postures, stick};
use nalgebra::{Point3, Rotation3, Vector3};
use sesc_reference::ErrorKind;

#[test]
fn joints_are_scaled_then_shifted() {
    let (_, reference, plain) = bushy_on_sole();
    let world = plain
        .clone()
        .joint_offset("shoulder", 0.1)
        .unwrap()
        .joint_scale("shoulder", 1.2)
        .unwrap()
        .joint_offset("knee", -0.05)
        .unwrap();
    let index = |joint: &str| reference.robot().dof_index(joint).unwrap();
    for q in postures(&reference, 20) {
        // A world without faults reads the CoM.
        let com = reference.com(&q);
        assert_eq!((plain.com(&q), plain.cop(&q)), (com, [com.x, com.y]));
        let mut bent = q.clone();
        bent[index("shoulder")] *= 1.2;
        bent[index("shoulder")] += 0.1;
        bent[index("knee")] -= 0.05;
        assert_eq!(world.true_posture(&q), bent);
        assert_eq!(world.com(&q), reference.com(&bent));
    }
}

#[test]
fn a_payload_is_one_more_mass() {
    let (robot, reference, plain) = bushy_on_sole();
    let arm = robot.link_index("arm").unwrap();
    let at = [0.1, -0.2, 0.05];
    for mass in [0.4, -0.1] {
        let world = plain.clone().payload("arm", mass, at).unwrap();
        for q in postures(&reference, 20) {
            let place = reference.link_poses(&q)[arm] * Point3::from(at);
            let total = reference.total_mass();
            let expected = (reference.com(&q) * total + place.coords * mass) / (total + mass);
            assert!((world.com(&q) - expected).norm() < 1e-15);
        }
    }
    // A payload on the massless sole, then another one, then none.
    let world = plain.payload("sole", 0.0, at).unwrap();
    let world = world.payload("sole", 0.2, [0.0; 3]).unwrap();
    let world = world.payload("sole", 0.2, [0.1, 0.0, 0.0]).unwrap();
    let sole = &world.robot().links()[robot.link_index("sole").unwrap()];
    assert_eq!(sole.mass_kg, 0.4);
    assert!((sole.com_m.x - 0.05).abs() < 1e-15);
}

#[test]
fn slope_shifts_by_height() {
    let (_, reference, world) = bushy_on_sole();
    let slope = [0.05, -0.02];
    let world = world.ground_slope(slope).unwrap();
    // The same by turning the whole scene level: gravity straight down meets
    // the tilted sole plane through the origin.
    let gravity = Vector3::new(slope[0], slope[1], -1.0);
    let level = Rotation3::rotation_between(&gravity, &-Vector3::z()).unwrap();
    let normal = level * Vector3::z();
    for q in postures(&reference, 20) {
        let com = reference.com(&q);
        let cop = world.cop(&q);
        let shifted = [com.x + com.z * slope[0], com.y + com.z * slope[1]];
        near(cop, shifted, 1e-15);
        let turned = level * com;
        let drop = normal.dot(&turned) / normal.z;
        let ground = level.inverse() * (turned - Vector3::z() * drop);
        assert!((ground - Vector3::new(cop[0], cop[1], 0.0)).norm() < 1e-14);
    }
}

#[test]
fn mistakes_are_named() {
    let (_, _, world) = bushy_on_sole();
    let on = || world.clone();
    let error = on().joint_offset("curl", 0.1).unwrap_err();
    assert!(error.to_string().contains("`curl`"), "{error}");
    let error = on().link_mass("arm", 0.0, [0.0; 3]).unwrap_err();
    assert!(error.to_string().contains("mass factor"), "{error}");
    let bent = || {
        stick()
            .bending_link("ankle", [1.0, 0.0, 0.0], 50.0)
            .unwrap()
    };
    for (wrong, expected) in [
        (on().joint_scale("flange", 1.1), ErrorKind::UnknownJoint),
        (on().joint_sign("flange"), ErrorKind::UnknownJoint),
        (on().joint_swap("hip", "curl"), ErrorKind::UnknownJoint),
        (
            on().gear_error("tail", 0.1, 1.0, 0.0),
            ErrorKind::UnknownJoint,
        ),
        (on().payload("hand", 0.1, [0.0; 3]), ErrorKind::UnknownLink),
        (
            on().external_force("hand", [0.0; 3]),
            ErrorKind::UnknownLink,
        ),
        (on().payload("arm", -0.5, [0.0; 3]), ErrorKind::Payload),
        (on().gravity([0.0, 1.0, 0.0]), ErrorKind::Gravity),
        (on().ground_slope([f64::NAN, 0.0]), ErrorKind::Gravity),
        (
            bent().joint_offset("ankle hinge", 0.1),
            ErrorKind::HiddenJoint,
        ),
        (
            bent().bending_link("ankle", [0.0, 1.0, 0.0], 50.0),
            ErrorKind::Duplicate,
        ),
        (
            stick().bending_link("ankle", [0.0; 3], 50.0),
            ErrorKind::Value,
        ),
        (stick().joint_compliance("ankle", 0.0), ErrorKind::Value),
        (stick().joint_compliance_all(-3.0), ErrorKind::Value),
        (stick().backlash("ankle", f64::NAN), ErrorKind::Value),
        (stick().backlash_all(f64::INFINITY), ErrorKind::Value),
        (stick().cable("ankle", 0.0, 0.1), ErrorKind::Value),
        (
            stick().hanging_load("stick", -0.1, [0.0; 3], 0.1),
            ErrorKind::Value,
        ),
        (
            stick().loose_mass("stick", 0.1, [0.0; 3], [0.0; 3], 0.1),
            ErrorKind::Value,
        ),
    ] {
        assert_eq!(kind(wrong), expected);
    }
}
