//! A part of a log in which the sensor says nothing new.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{self, Verdict};
use sesc_test_support::command::says;
use sesc_test_support::moving::Swing;
use sesc_test_support::recording::Recording;
use sesc_test_support::stage::{Platform, Stage};

use super::log::{Log, NOISE_M, POSTURES};
use super::rows::{found_beside, hidden, only, owned};
use crate::asked::{diagnosed, fit_request, fitted, kinds, of_recording, white};

#[test]
fn a_frozen_cop_is_left_out() {
    let mut log = Log::of("r_sole", &[], hidden, 90);
    let last = log.cop[19];
    log.cop[20..34].fill(last);
    assert_eq!(found_beside(&log), only("cop_frozen", "-"));
    let found = log.diagnose();
    assert_eq!(found.postures, POSTURES - 15);
    let rows = "In 15 rows (19 %, one stretch; the longest is rows 20 to 34)";
    says(&found.health[0].sentence, &[rows]);
}

#[test]
fn a_frozen_axis_is_named() {
    let mut log = Log::of("r_sole", &[], hidden, 91);
    let last = log.cop[50][1];
    log.cop[50..70].iter_mut().for_each(|y| y[1] = last);
    assert_eq!(found_beside(&log), only("cop_frozen", "y"));
}

#[test]
fn a_sensor_that_died_early_leaves_nothing() {
    let mut log = Log::of("r_sole", &[], |w| w, 92);
    let last = log.cop[5];
    log.cop[5..].fill(last);
    let found = log.diagnose();
    assert_eq!(found.verdict, Verdict::Unusable);
    assert_eq!(found.health[0].kind.name(), "cop_constant");
}

fn op2() -> Stage {
    Stage::new(Platform::Op2)
}

/// An OP2 that swings at up to 0.4 Hz, read at 50 Hz with noise of 0.5 mm.
fn swing(seed: u64) -> Recording {
    let stage = op2();
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let swing = Swing::new(0.4, 0.15, 30.0);
    swing.record(&stage, stage.world(), white(5e-4), 50.0, random)
}

/// What a diagnosis finds wrong with the data of a recording.
pub(super) fn looked(stage: &Stage, recording: &Recording) -> Vec<(String, String)> {
    looked_at(&of_recording(stage, recording))
}

/// What a diagnosis finds wrong with the data that it is asked about.
pub(super) fn looked_at(request: &diagnose::Request) -> Vec<(String, String)> {
    owned(&diagnose::look(request, &mut ()).unwrap())
}

/// At a tenth of the joints' rate each reading comes ten times; that is no broken sensor, and
/// five times as long is.
#[test]
fn a_slow_sensor_is_not_frozen() {
    let mut recording = swing(93);
    assert_eq!(looked(&op2(), &recording), []);
    for k in 0..recording.cop.len() {
        recording.cop[k] = recording.cop[k - k % 10];
    }
    assert_eq!(looked(&op2(), &recording), []);
    let last = recording.cop[700];
    recording.cop[700..800].fill(last);
    assert_eq!(looked(&op2(), &recording), only("cop_frozen", "-"));
}

/// The encoder of a knee that stops after 20 of 30 s: those rows are left out and the rest is
/// diagnosed, in `fit`, too.
#[test]
fn an_encoder_that_stops_in_the_middle_is_named_and_its_rows_are_left_out() {
    let mut recording = swing(94);
    let knee = recording.joint("r_knee");
    let at = recording.q[1000][knee];
    recording.q[1000..].iter_mut().for_each(|q| q[knee] = at);
    assert_eq!(looked(&op2(), &recording), only("encoder_stuck", "r_knee"));
    let request = of_recording(&op2(), &recording);
    let found = diagnosed(&request);
    says(&found.health[0].sentence, &["rows 1001 to 1500"]);
    assert!(matches!(found.verdict, Verdict::None | Verdict::Absorbed));
    let kept = 900..=1000;
    assert!(kept.contains(&found.samples.rows), "{:?}", found.samples);
    let found = fitted(&fit_request(&op2(), request.log.clone()));
    assert_eq!(kinds(&found.health), [("encoder_stuck", "r_knee")]);
    assert!(kept.contains(&found.samples.rows), "{:?}", found.samples);
}

/// A knee that is really held for a third of the log is no finding, whatever is hidden in it.
#[test]
fn a_joint_that_is_held_for_a_while_is_no_stuck_encoder() {
    let stage = Stage::new(Platform::Op2);
    let joints = stage.joint_names();
    let knee = joints.iter().position(|joint| joint == "r_knee").unwrap();
    let plain = stage.world();
    let offset = stage.world().joint_offset("r_knee", 0.1).unwrap();
    let loaded = stage.world().payload("body_link", 0.4, [0.03, 0.02, 0.05]);
    let worlds = [plain, offset, loaded.unwrap()];
    for (k, world) in worlds.iter().enumerate() {
        let mut log = Log::of("r_sole", &[], |w| w, 95 + k as u64);
        let q = log.q.clone();
        log.q = (0..480).map(|row| q[row % q.len()].clone()).collect();
        log.q[160..320].iter_mut().for_each(|q| q[knee] = 0.3);
        // Each posture again and again, with noise of its own.
        let cop = log.q.iter().enumerate().map(|(row, q)| {
            let [x, y] = world.cop(q);
            let [a, b] = [(1.7 * row as f64).sin(), (2.3 * row as f64).cos()];
            [x + 1.4 * NOISE_M * a, y + 1.4 * NOISE_M * b]
        });
        log.cop = cop.collect();
        assert_eq!(kinds(&log.diagnose().health), [], "{k}");
    }
}
