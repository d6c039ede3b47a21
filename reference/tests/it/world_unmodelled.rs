//! Imperfections outside the library, each against its own formula.

use crate::common::{
    LEANING_KG, LEANING_M, bushy_on_sole, leaning, leaning_from_above, postures, stick,
};
use sesc_reference::{GRAVITY, World};

fn near(found: f64, expected: f64) {
    crate::common::near([found], [expected], 1e-12);
}

#[test]
fn a_hanging_load_cannot_be_told_from_a_payload_at_its_hinge() {
    let (_, reference, world) = bushy_on_sole();
    let world = world.ground_slope([0.05, -0.03]).unwrap();
    let at = [0.1, -0.02, 0.03];
    let hanging = world.clone().hanging_load("arm", 0.4, at, 0.2).unwrap();
    let fixed = world.payload("arm", 0.4, at).unwrap();
    for q in postures(&reference, 10) {
        let (hanging_cop, fixed_cop) = (hanging.cop(&q), fixed.cop(&q));
        near(hanging_cop[0], fixed_cop[0]);
        near(hanging_cop[1], fixed_cop[1]);
        assert!(hanging.com(&q).z < fixed.com(&q).z, "but it hangs lower");
        let moments = [&hanging, &fixed].map(|world| world.joint_moments(&q));
        for (a, b) in moments[0].iter().zip(&moments[1]) {
            near(*a, *b);
        }
    }
}

#[test]
fn a_loose_mass_slides_down_its_rod() {
    let (at, along) = ([0.0, 0.0, 0.3], [2.0, 0.0, 0.0]);
    let loose = stick().loose_mass("stick", 1.0, at, along, 0.06).unwrap();
    for q in [-0.5, -0.02, 0.0, 0.1, 0.4_f64] {
        // The rod leans with the stick: its far end is lower by sin q.
        let (sin, cos) = q.sin_cos();
        let slid = 0.06 * (sin / 0.17).tanh();
        let expected = (LEANING_KG * LEANING_M * sin + 0.3 * sin + slid * cos) / 3.0;
        near(loose.cop(&[q])[0], expected);
    }
}

#[test]
fn a_cable_pulls_back_once_it_is_taut() {
    let soft = stick().joint_compliance("ankle", 60.0).unwrap();
    let held = soft.clone().cable("ankle", 30.0, 0.1).unwrap();
    assert_eq!(held.true_posture(&[0.02]), soft.true_posture(&[0.02]));
    let joint = held.true_posture(&[0.3])[0];
    let gravity = LEANING_KG * GRAVITY * LEANING_M * joint.sin();
    near(joint, 0.3 + (gravity - 30.0 * (joint - 0.1)) / 60.0);
    let pulled = gravity - 30.0 * (joint - 0.1);
    near(held.joint_moments(&[0.3])[0], pulled);
    // A cable far stiffer than its joint holds it at the end.
    let stopped = soft.clone().cable("ankle", 1e9, 0.1).unwrap();
    assert!((stopped.true_posture(&[0.3])[0] - 0.1).abs() < 1e-6);
    // A loose ankle falls into its cable until that holds.
    let loose = stick().backlash("ankle", 0.2).unwrap();
    let loose = loose.cable("ankle", 200.0, 0.12).unwrap();
    let joint = loose.true_posture(&[0.1])[0];
    assert!((loose.joint_moments(&[0.1])[0]).abs() < 1e-7);
    assert!(joint > 0.12 && joint < 0.15, "{joint}");
}

#[test]
fn a_link_that_bends_along_its_joint_is_a_soft_joint() {
    for robot in [leaning(), leaning_from_above()] {
        let world = World::new(&robot, "foot").unwrap();
        let bending = world.clone().bending_link("ankle", [0.0, 1.0, 0.0], 50.0);
        let bending = bending.unwrap();
        let soft = world.joint_compliance("ankle", 50.0).unwrap();
        assert_eq!(bending.dof(), 1);
        for q in [-0.3, 0.0, 0.1] {
            assert!((bending.cop(&[q])[0] - soft.cop(&[q])[0]).abs() < 1e-12);
            assert_eq!(bending.true_posture(&[q]), [q], "the joint itself is stiff");
        }
    }
}

#[test]
fn a_link_that_bends_across_its_joint_leaves_the_plane() {
    // A mass beside the stick bends it sideways by m g y / k.
    let world = stick().link_mass("stick", 1.0, [0.0, 0.05, 0.0]).unwrap();
    let bending = world.bending_link("ankle", [1.0, 0.0, 0.0], 80.0).unwrap();
    let y = bending.cop(&[0.0])[1];
    // At bend b: y = 0.05 cos b - 0.5 sin b, and gravity bends towards +y.
    let bend = -LEANING_KG * GRAVITY * y / 80.0;
    near(y, 0.05 * bend.cos() - 0.5 * bend.sin());
    assert!(y > 0.05);
}

#[test]
fn a_sine_of_a_joint_comes_on_top() {
    let world = stick();
    let wrong = world
        .clone()
        .cop_sine("ankle", 3.0, [0.004, -0.002])
        .unwrap();
    for q in [-0.4, 0.0, 0.3] {
        let sine = f64::sin(3.0 * q);
        near(wrong.cop(&[q])[0] - world.cop(&[q])[0], 0.004 * sine);
        near(wrong.cop(&[q])[1], -0.002 * sine);
    }
}
