//! One effect beyond the list of each family, from a log to the model that is written: its place is
//! right or of the class, its form is, and the gap on fresh postures shrinks to 6 %, or to what the
//! noise allows where that is more.

use sesc_test_support::examine::unlisted::{Kind, examine};
use sesc_test_support::stage::{Platform, Stage};

fn shrinks(kind: Kind, seed: u64) {
    let found = examine(&Stage::new(Platform::Op2), Some(kind), false, seed).unwrap();
    assert!(found.listed && found.form, "{}", found.said);
    assert!(found.cop <= found.goal, "{}", found.said);
    // A sensor and soft ground leave the CoM where it was.
    assert!(
        found.com.is_nan() || found.com <= found.goal,
        "{}",
        found.said
    );
}

#[test]
fn an_encoder_that_errs_in_waves() {
    shrinks(Kind::Ripple, 1001);
}

#[test]
fn a_joint_that_follows_another() {
    shrinks(Kind::Coupling, 2001);
}

#[test]
fn a_joint_that_slips_during_the_log() {
    shrinks(Kind::Slip, 6003);
}

#[test]
fn a_spring_that_softens() {
    shrinks(Kind::Softening, 9001);
}

#[test]
fn a_sensor_that_is_curved() {
    shrinks(Kind::Nonlinearity, 11001);
}

#[test]
fn ground_that_gives_way() {
    shrinks(Kind::SoftGround, 15005);
}

/// Nothing is found in logs of sound robots, as CAD has them and as they are bought.
#[test]
fn a_sound_robot_is_left_alone() {
    for (seed, is_bought) in [(22_001, false), (22_002, true)] {
        let found = examine(&Stage::new(Platform::Op2), None, is_bought, seed).unwrap();
        assert!(found.silent, "{}", found.said);
    }
}
