//! Nothing states the noise of a log, no posture was repeated: what the best explanation and
//! free masses leave is the noise, and evidence is about that of a log that states it.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{Diagnosis, Verdict};
use sesc_reference::World;
use sesc_test_support::recording::Recording;
use sesc_test_support::stage::{Platform, Stage};

use crate::asked::{diagnosed, request};

const NOISE_M: f64 = 5e-4;

/// What is said of 200 balanced postures of the OP2, with white noise of 0.50 mm on each axis, which
/// is stated and which is not.
fn diagnoses(hide: impl Fn(World) -> World, seed: u64) -> [Diagnosis; 2] {
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let stage = Stage::new(Platform::Op2);
    let (world, q) = (hide(stage.world()), stage.balanced(200, random));
    let log = Recording::still(&stage, &world, q, NOISE_M, random);
    let std = || vec![NOISE_M; 200];
    let stated = log
        .table(false)
        .numbers("cop_x_std", std())
        .numbers("cop_y_std", std());
    [stated, log.table(false)].map(|log| diagnosed(&request(&stage, log)))
}

/// Tests the mean over several logs, for an estimate from 360 degrees of freedom scatters by 4 %.
#[test]
fn noise_and_evidence_are_those_of_a_log_that_states_it() {
    let hide = |w: World| w.joint_offset("r_hip_roll", 0.05).unwrap();
    let (mut noise, mut evidence) = (Vec::new(), Vec::new());
    for seed in 1..=3 {
        let [with, without] = diagnoses(hide, seed);
        let sum = |d: &Diagnosis| d.steps.iter().map(|s| s.evidence).sum::<f64>();
        assert_eq!(with.verdict, without.verdict);
        noise.push(without.noise / NOISE_M);
        evidence.push(sum(&without) / sum(&with));
    }
    assert!(noise.iter().all(|r| (r - 1.0).abs() < 0.1), "{noise:?}");
    assert!(
        evidence.iter().all(|r| (r - 1.0).abs() < 0.15),
        "{evidence:?}"
    );
}

/// A knee whose gear errs by a sine: no effect of the list is that, and no stated noise is
/// needed to see it.
#[test]
fn what_nothing_explains_is_unexplained_without_a_stated_noise() {
    let hide = |w: World| w.cop_sine("r_knee", 7.0, [0.008, 0.004]).unwrap();
    for found in diagnoses(hide, 5) {
        assert_eq!(found.verdict, Verdict::Unexplained);
        assert!(found.unexplained);
    }
}
