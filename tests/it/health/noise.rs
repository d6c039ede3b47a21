//! Noise that is told wrongly, of recordings whose noise lasts.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose;
use sesc_test_support::moving::Swing;
use sesc_test_support::recording::{Kind, Noise};
use sesc_test_support::stage::{Platform, Stage};

use super::encoders::fitted;
use super::rows::only;
use super::stretches::looked_at;
use crate::asked::of_recording;

const STD_M: f64 = 2e-3;

/// Half a minute of a robot that swings, read with noise of 2 mm that lasts for `lasts_s`; the
/// noise is said to be `told_m`.
fn recorded(lasts_s: f64, told_m: f64, seed: u64) -> diagnose::Request {
    let stage = Stage::new(Platform::Plain);
    let noise = Noise::new(Kind::Ar1(lasts_s), STD_M);
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let swing = Swing::new(0.25, 0.15, 30.0);
    let recording = swing.record(&stage, stage.world(), noise, 20.0, random);
    let mut request = of_recording(&stage, &recording);
    request.noise = Some(told_m);
    request
}

/// The recording is worth fifteen independent samples an axis, fewer than a fit has unknowns: how
/// large the noise is shows in what CAD leaves.
#[test]
fn noise_that_lasts_and_is_overstated_is_said() {
    for seed in 1..5 {
        let told = recorded(1.0, 4.0 * STD_M, seed);
        assert_eq!(looked_at(&told), only("noise_overstated", "-"), "{seed}");
        assert_eq!(fitted(told), only("noise_overstated", "-"), "{seed}");
        let right = recorded(1.0, STD_M, seed);
        assert_eq!(looked_at(&right), [], "{seed}");
        assert_eq!(fitted(right), [], "{seed}");
    }
}

/// Noise that lasts as long as the recording is by chance less than half of itself in about one of
/// five (χ² of one sample an axis).
#[test]
fn a_log_of_few_independent_samples_says_nothing_of_its_noise() {
    for seed in 11..41 {
        assert_eq!(looked_at(&recorded(30.0, STD_M, seed)), [], "{seed}");
    }
}
