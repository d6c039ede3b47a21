//! One effect beyond the list of each family, from a log to the model that is written: its place is
//! right or of the class, its form is, and the gap on fresh postures shrinks to 6 %, or to what the
//! noise allows where that is more.

use rayon::prelude::*;
use sesc_test_support::examine::unlisted::{Kind, examine};
use sesc_test_support::stage::{Platform, Stage};

#[test]
fn the_gap_that_an_effect_beyond_the_list_leaves_shrinks() {
    let of_joints = [
        (Kind::Ripple, 1001),
        (Kind::Coupling, 2001),
        (Kind::Slip, 6003),
    ];
    let others = [
        (Kind::Softening, 9001),
        (Kind::Nonlinearity, 11001),
        (Kind::SoftGround, 15005),
    ];
    of_joints
        .into_par_iter()
        .chain(others)
        .for_each(|(kind, seed)| {
            let found = examine(&Stage::new(Platform::Op2), Some(kind), false, seed).unwrap();
            let said = &found.said;
            assert!(found.listed && found.form, "{said}");
            assert!(found.cop <= found.goal, "{said}");
            // A sensor and soft ground leave the CoM where it was.
            assert!(found.com.is_nan() || found.com <= found.goal, "{said}");
        });
}

/// Nothing is found in logs of sound robots, as CAD has them and as they are bought.
#[test]
fn a_sound_robot_is_left_alone() {
    for (seed, is_bought) in [(22_001, false), (22_002, true)] {
        let found = examine(&Stage::new(Platform::Op2), None, is_bought, seed).unwrap();
        assert!(found.silent, "{}", found.said);
    }
}
