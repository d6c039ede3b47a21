//! Springs, dead bands and pulls on a stick that leans over its ankle, where
//! the answer is known: gravity's moment is `m g l sin φ`.

use crate::common::{LEANING_KG, LEANING_M, bushy, leaning, leaning_from_above, postures, stick};
use sesc_reference::{GRAVITY, Reference, World};

/// Gravity's moment on the ankle, N m.
fn moment(joint: f64) -> f64 {
    LEANING_KG * GRAVITY * LEANING_M * joint.sin()
}

fn near(found: f64, expected: f64, tolerance: f64) {
    crate::common::near([found], [expected], tolerance);
}

#[test]
fn moments_are_what_the_potential_energy_loses() {
    let robot = bushy();
    for support in ["sole", "torso", "piston"] {
        let reference = Reference::new(&robot, support).unwrap();
        let world = World::new(&robot, support).unwrap();
        let weight = reference.total_mass() * GRAVITY;
        for q in postures(&reference, 10) {
            let expected = reference.gravity_moments(&q) * weight;
            for (found, expected) in world.joint_moments(&q).iter().zip(&expected) {
                near(*found, *expected, 1e-9);
            }
        }
    }
}

#[test]
fn a_soft_ankle_leans_until_its_spring_holds() {
    for robot in [leaning(), leaning_from_above()] {
        let world = World::new(&robot, "foot").unwrap();
        let soft = world.clone().joint_compliance("ankle", 40.0).unwrap();
        let all = world.clone().joint_compliance_all(40.0).unwrap();
        let twice = world.joint_compliance("ankle", 80.0).unwrap();
        let twice = twice.joint_compliance("ankle", 80.0).unwrap();
        for q in [-0.4, -0.1, 0.0, 0.05, 0.3] {
            let joint = soft.true_posture(&[q])[0];
            near(joint, q + moment(joint) / 40.0, 1e-12);
            near(soft.cop(&[q])[0], LEANING_M * joint.sin(), 1e-12);
            near(all.true_posture(&[q])[0], joint, 1e-12);
            near(twice.true_posture(&[q])[0], joint, 1e-12);
        }
    }
}

#[test]
fn a_spring_softer_than_gravity_does_not_hold() {
    // It would take m g l = 9.8 N m/rad to stand upright.
    let fallen = stick().joint_compliance("ankle", 2.0).unwrap();
    assert!(fallen.true_posture(&[0.1])[0].is_nan());
    assert!(fallen.cop(&[0.1])[0].is_nan());
}

#[test]
fn payloads_and_pulls_bend_a_soft_ankle_and_only_a_soft_one() {
    let pulled = stick()
        .external_force_at("stick", [3.0, 0.0, 0.0], [0.0, 0.0, 0.4])
        .unwrap()
        .payload("stick", 0.5, [0.0, 0.0, 0.2])
        .unwrap();
    assert_eq!(pulled.true_posture(&[0.1]), [0.1]);
    let soft = pulled.joint_compliance("ankle", 60.0).unwrap();
    let joint = soft.true_posture(&[0.1])[0];
    let torque = moment(joint) + 0.5 * GRAVITY * 0.2 * joint.sin() + 3.0 * 0.4 * joint.cos();
    near(joint, 0.1 + torque / 60.0, 1e-12);
    near(soft.joint_moments(&[0.1])[0], torque, 1e-10);
}

#[test]
fn a_slope_loads_a_soft_ankle() {
    let world = stick().joint_compliance("ankle", 40.0).unwrap();
    let world = world.ground_slope([0.1, 0.0]).unwrap();
    let joint = world.true_posture(&[0.0])[0];
    // Gravity leans by atan 0.1 itself.
    near(joint, moment(joint + 0.1_f64.atan()) / 40.0, 1e-12);
}

#[test]
fn a_loose_ankle_falls_to_the_end_it_leans_to() {
    for robot in [leaning(), leaning_from_above()] {
        let world = World::new(&robot, "foot").unwrap();
        let loose = world.backlash("ankle", 0.04).unwrap();
        near(loose.true_posture(&[0.1])[0], 0.12, 1e-12);
        near(loose.true_posture(&[-0.001])[0], -0.021, 1e-12);
        // Exactly upright nothing pulls it.
        assert_eq!(loose.true_posture(&[0.0]), [0.0]);
        let soft = loose.joint_compliance("ankle", 40.0).unwrap();
        let joint = soft.true_posture(&[0.1])[0];
        near(joint, 0.12 + moment(joint) / 40.0, 1e-12);
    }
}

#[test]
fn a_loose_hanging_stick_comes_to_rest_at_the_bottom() {
    let loose = stick().backlash_all(0.04).unwrap();
    let down = std::f64::consts::PI;
    // The bottom lies within the band, or beyond its end.
    near(loose.true_posture(&[down + 0.015])[0], down, 1e-10);
    near(loose.true_posture(&[down - 0.05])[0], down - 0.03, 1e-12);
}
