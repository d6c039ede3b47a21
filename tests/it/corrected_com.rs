//! A diagnosed model corrects the CoM: one effect of the body hidden at clear size in the
//! OP2, its log diagnosed, the model written to its file and read back, and the CoM held
//! against the virtual robot's on postures that the log does not have.
//! `cargo xtask study com` asks at length.

use rayon::prelude::*;
use sesc_test_support::examine::com::{GOAL, MOVED_M, examine};
use sesc_test_support::hidden::{Effect, Hidden};
use sesc_test_support::stage::Platform;
use sesc_test_support::trial::{Choice, Trial};

#[test]
fn every_effect_of_the_body_is_corrected() {
    let hidden: [(Effect, &str, &[f64]); 6] = [
        (Effect::JointOffset, "r_knee", &[0.05]),
        (Effect::JointScale, "r_knee", &[-0.12]),
        (Effect::JointSwap, "l_knee,l_ank_pitch", &[]),
        (Effect::JointCompliance, "all", &[1.0 / 30.0]),
        (Effect::Backlash, "all", &[0.015]),
        (Effect::Payload, "r_el_link", &[0.2, 0.0, 0.0, -0.008]),
    ];
    hidden.par_iter().for_each(|(effect, target, values)| {
        let hidden = Hidden::new(*effect, target, values);
        let trial = Trial::of(vec![hidden], &Choice::on(Platform::Op2), 1).unwrap();
        let found = examine(&trial, tempfile::tempdir().unwrap().path()).unwrap();
        assert!(found.before_m > MOVED_M, "{found:?}");
        assert!(found.listed, "{found:?}");
        assert!(found.ratio() < GOAL, "{found:?}");
    });
}
