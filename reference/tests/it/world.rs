//! Each imperfection against its own formula.

use std::f64::consts::FRAC_PI_2;

use crate::common::{bushy, kind, postures};
use nalgebra::{Point3, Rotation3, Vector3};
use sesc_reference::{ErrorKind, Reference, World};

fn assert_near(found: [f64; 2], expected: [f64; 2]) {
    let error = (found[0] - expected[0]).hypot(found[1] - expected[1]);
    assert!(error < 1e-15, "{found:?} is not {expected:?}");
}

#[test]
fn a_true_world_reads_the_com() {
    let robot = bushy();
    let world = World::new(&robot, "sole").unwrap();
    let reference = Reference::new(&robot, "sole").unwrap();
    for q in postures(&reference, 20) {
        let com = reference.com(&q);
        assert_eq!(world.com(&q), com);
        assert_eq!(world.cop(&q), [com.x, com.y]);
    }
}

#[test]
fn joints_are_scaled_then_shifted() {
    let robot = bushy();
    let reference = Reference::new(&robot, "sole").unwrap();
    let world = World::new(&robot, "sole")
        .unwrap()
        .joint_offset("shoulder", 0.1)
        .unwrap()
        .joint_scale("shoulder", 1.2)
        .unwrap()
        .joint_offset("knee", -0.05)
        .unwrap();
    for q in postures(&reference, 20) {
        let mut bent = q.clone();
        bent[reference.robot().dof_index("shoulder").unwrap()] *= 1.2;
        bent[reference.robot().dof_index("shoulder").unwrap()] += 0.1;
        bent[reference.robot().dof_index("knee").unwrap()] -= 0.05;
        assert_eq!(world.true_posture(&q), bent);
        assert_eq!(world.com(&q), reference.com(&bent));
    }
}

#[test]
fn a_payload_is_one_more_mass() {
    let robot = bushy();
    let reference = Reference::new(&robot, "sole").unwrap();
    let arm = robot.link_index("arm").unwrap();
    let at = [0.1, -0.2, 0.05];
    for mass in [0.4, -0.1] {
        let world = World::new(&robot, "sole").unwrap();
        let world = world.payload("arm", mass, at).unwrap();
        for q in postures(&reference, 20) {
            let place = reference.link_poses(&q)[arm] * Point3::from(at);
            let total = reference.total_mass();
            let expected = (reference.com(&q) * total + place.coords * mass) / (total + mass);
            assert!((world.com(&q) - expected).norm() < 1e-15);
        }
    }
    // A payload on the massless sole, then another one, then none.
    let world = World::new(&robot, "sole").unwrap();
    let world = world.payload("sole", 0.0, at).unwrap();
    let world = world.payload("sole", 0.2, [0.0; 3]).unwrap();
    let world = world.payload("sole", 0.2, [0.1, 0.0, 0.0]).unwrap();
    let sole = &world.robot().links()[robot.link_index("sole").unwrap()];
    assert_eq!(sole.mass_kg, 0.4);
    assert!((sole.com_m.x - 0.05).abs() < 1e-15);
}

#[test]
fn slope_shifts_by_height() {
    let robot = bushy();
    let reference = Reference::new(&robot, "sole").unwrap();
    let slope = [0.05, -0.02];
    let world = World::new(&robot, "sole")
        .unwrap()
        .ground_slope(slope)
        .unwrap();
    // The same by turning the whole scene level: gravity straight down meets
    // the tilted sole plane through the origin.
    let gravity = Vector3::new(slope[0], slope[1], -1.0);
    let level = Rotation3::rotation_between(&gravity, &-Vector3::z()).unwrap();
    let normal = level * Vector3::z();
    for q in postures(&reference, 20) {
        let com = reference.com(&q);
        let cop = world.cop(&q);
        assert_near(cop, [com.x + com.z * slope[0], com.y + com.z * slope[1]]);
        let turned = level * com;
        let drop = normal.dot(&turned) / normal.z;
        let ground = level.inverse() * (turned - Vector3::z() * drop);
        assert!((ground - Vector3::new(cop[0], cop[1], 0.0)).norm() < 1e-14);
    }
}

#[test]
fn the_sensor_turns_then_shifts() {
    let robot = bushy();
    let world = World::new(&robot, "sole").unwrap();
    let bent = world
        .clone()
        .sensor_offset([0.01, 0.02])
        .sensor_rotation(FRAC_PI_2);
    for q in postures(&Reference::new(&robot, "sole").unwrap(), 20) {
        let [x, y] = world.cop(&q);
        assert_near(bent.cop(&q), [-y + 0.01, x + 0.02]);
    }
}

#[test]
fn mistakes_are_named() {
    let world = World::new(&bushy(), "sole").unwrap();
    let error = world.clone().joint_offset("curl", 0.1).unwrap_err();
    assert!(error.to_string().contains("`curl`"), "{error}");
    assert_eq!(
        kind(world.clone().joint_scale("flange", 1.1)),
        ErrorKind::UnknownJoint
    );
    assert_eq!(
        kind(world.clone().payload("hand", 0.1, [0.0; 3])),
        ErrorKind::UnknownLink
    );
    assert_eq!(
        kind(world.clone().payload("arm", -0.5, [0.0; 3])),
        ErrorKind::Payload
    );
    assert_eq!(
        kind(world.clone().gravity([0.0, 1.0, 0.0])),
        ErrorKind::Gravity
    );
    assert_eq!(
        kind(world.ground_slope([f64::NAN, 0.0])),
        ErrorKind::Gravity
    );
}
