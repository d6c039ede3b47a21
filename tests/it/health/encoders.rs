//! Encoders that do not move, of robots that do.

use std::sync::Arc;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose;
use sesc_identify::fit::{self, MotionModel};
use sesc_identify::robot::Robot;
use sesc_test_support::moving::Swing;
use sesc_test_support::recording::{Recording, normal};
use sesc_test_support::stage::{Platform, Stage};
use sesc_test_support::trees::Urdf;

use super::rows::{only, owned};
use super::stretches::looked;
use crate::asked::{self, of_recording, white};

/// A robot that swings, read with white noise of `std` m.
fn swing(stage: &Stage, swing: Swing, std: f64, rate: f64, seed: u64) -> Recording {
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    swing.record(stage, stage.world(), white(std), rate, random)
}

/// A diagnosis and a fit find this encoder stuck, and nothing else.
fn finds_stuck(stage: &Stage, recording: &Recording, joint: &str) {
    assert_eq!(looked(stage, recording), only("encoder_stuck", joint));
    let fitted = fitted(of_recording(stage, recording));
    assert_eq!(fitted, only("encoder_stuck", joint));
}

/// What a fit of the log of a diagnosis finds.
pub(super) fn fitted(of_diagnosis: diagnose::Request) -> Vec<(String, String)> {
    let mut request = fit::Request::default();
    request.robot = Some(of_diagnosis.robot);
    request.logs = vec![of_diagnosis.log];
    request.support = of_diagnosis.support;
    request.noise = of_diagnosis.noise;
    owned(&asked::fitted(&request).health)
}

/// The sensor is quiet, says nothing of its noise, and the CoP is a millimetre or two off.
#[test]
fn small_motion_of_a_joint_is_seen_by_a_quiet_sensor() {
    let stage = Stage::new(Platform::Op2);
    for (seed, joint) in [(1, "l_hip_pitch"), (2, "r_hip_yaw"), (3, "r_knee")] {
        let mut recording = swing(&stage, Swing::new(0.25, 0.1, 40.0), 2e-4, 50.0, seed);
        recording.stick(joint);
        finds_stuck(&stage, &recording, joint);
    }
}

/// What the joint hides is as large as what motion adds to readings, which then do not look like
/// those of a robot that moves.
#[test]
fn a_stuck_encoder_that_hides_that_the_robot_moves_is_named() {
    let stage = Stage::new(Platform::Skew);
    let joint = "right_hip_roll";
    for seed in [11, 12] {
        let mut recording = swing(&stage, Swing::new(0.29, 0.2, 37.0), 1.1e-3, 100.0, seed);
        recording.stick(joint);
        finds_stuck(&stage, &recording, joint);
        // Who says that readings are static is not contradicted.
        let mut static_ones = of_recording(&stage, &recording);
        static_ones.motion = MotionModel::Off;
        assert_eq!(diagnose::look(&static_ones, &mut ()).unwrap(), []);
    }
}

/// Readings that the motion of the other joints explains need none of theirs.
#[test]
fn joints_that_stand_still_while_others_move_are_not_stuck() {
    for seed in 21..29 {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let stage = Stage::new(Platform::Plain).holding(0.5, random);
        let recording = swing(&stage, Swing::new(0.36, 0.19, 50.0), 2.8e-3, 20.0, seed);
        assert_eq!(looked(&stage, &recording), [], "{seed}");
    }
}

/// A pole that leans and bends forward, with a small arm; masses of shank and trunk, kg.
fn pole(shank: f64, trunk: f64) -> String {
    Urdf::new("pole")
        .link("foot", 0.5, "0 0 0")
        .link("shank", shank, "0 0 0.2")
        .link("trunk", trunk, "0.05 0 0.2")
        .link("arm", 0.4, "0 0 0.25")
        .revolute("ankle", ["foot", "shank"], "0 0 0", "0 1 0", 3.0)
        .revolute("hip", ["shank", "trunk"], "0 0 0.4", "0 1 0", 3.0)
        .revolute("elbow", ["trunk", "arm"], "0 0 0.3", "0 1 0", 3.0)
        .text()
}

/// Readings of a pole while its ankle, hip and elbow are within these bounds, with noise of
/// 0.2 mm, as a question about one whose masses are CAD's.
fn of_pole(world: &sesc_reference::World, bounds: [[f64; 2]; 3], seed: u64) -> diagnose::Request {
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let within = |random: &mut ChaCha8Rng| {
        let q = bounds.map(|[low, high]| low + (high - low) * random.random::<f64>());
        q.to_vec()
    };
    let q: Vec<Vec<f64>> = (0..200).map(|_| within(random)).collect();
    let cop = q
        .iter()
        .map(|q| world.cop(q).map(|y| y + 2e-4 * normal(random)));
    let log = Recording {
        joints: ["ankle", "hip", "elbow"].map(String::from).to_vec(),
        cop: cop.collect(),
        q,
        ..Recording::default()
    };
    let robot = Arc::new(Robot::parse(&pole(2.0, 3.0), "pole.urdf").unwrap());
    let mut request = diagnose::Request::new(robot, log.table(false));
    request.support = Some("foot".into());
    request
}

fn world(shank: f64, trunk: f64) -> sesc_reference::World {
    let described = sesc_reference::Robot::from_urdf(&pole(shank, trunk)).unwrap();
    sesc_reference::World::new(&described, "foot").unwrap()
}

/// Motion of the arm would explain what masses that are a tenth off do, posture by posture: both
/// move the CoP forward alone. Nothing states the noise.
#[test]
fn masses_that_are_off_are_no_stuck_encoder_of_a_joint_that_stands_still() {
    let bounds = [[-0.8, 0.8], [-0.8, 0.8], [0.5, 0.5]];
    let request = of_pole(&world(2.2, 2.7), bounds, 31);
    assert_eq!(diagnose::look(&request, &mut ()).unwrap(), []);
}

/// The ankle leans as far back as its encoder says that it leans forward: the CoP is two thirds
/// of a metre from CAD's, and the sign of the joint is what a diagnosis is for.
#[test]
fn a_joint_that_is_wired_backwards_puts_no_reading_outside_the_sole() {
    let backwards = world(2.0, 3.0).joint_sign("ankle").unwrap();
    let request = of_pole(&backwards, [[0.9, 0.9], [-0.4, 0.4], [-0.4, 0.4]], 32);
    assert_eq!(diagnose::look(&request, &mut ()).unwrap(), []);
}
