//! Encoders that do not move, of robots that do.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose;
use sesc_identify::fit::{self, MotionModel};
use sesc_virtual::moving::Swing;
use sesc_virtual::recording::{Kind, Noise, Recording};
use sesc_virtual::stage::{Platform, Stage};

use super::rows::only;
use super::stretches::{looked, request};

/// A robot that swings, read with white noise of `std` m.
fn swing(stage: &Stage, swing: Swing, std: f64, rate: f64, seed: u64) -> Recording {
    let noise = Noise {
        kind: Kind::White,
        std: [std; 2],
        visit_std: 0.0,
    };
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    swing.record(stage, stage.world(), noise, rate, random)
}

/// What a fit finds.
fn fitted(stage: &Stage, recording: &Recording) -> Vec<(String, String)> {
    let of_diagnosis = request(stage, recording);
    let mut request = fit::Request::default();
    request.robot = Some(of_diagnosis.robot);
    request.logs = vec![of_diagnosis.log];
    request.support = of_diagnosis.support;
    let found = fit::fit(&request, &mut ()).unwrap().identification.health;
    let named =
        |finding: sesc_identify::health::Finding| (finding.kind.name().to_string(), finding.target);
    found.into_iter().map(named).collect()
}

/// The sensor is quiet, says nothing of its noise, and the CoP is a millimetre or two off.
#[test]
fn small_motion_of_a_joint_is_seen_by_a_quiet_sensor() {
    let stage = Stage::new(Platform::Op2);
    for (seed, joint) in [(1, "l_hip_pitch"), (2, "r_hip_yaw"), (3, "r_knee")] {
        let mut recording = swing(&stage, Swing::new(0.25, 0.1, 40.0), 2e-4, 50.0, seed);
        let column = recording.joints.iter().position(|name| name == joint);
        let column = column.unwrap();
        let at = recording.q[0][column];
        recording.q.iter_mut().for_each(|q| q[column] = at);
        assert_eq!(looked(&stage, &recording), only("encoder_stuck", joint));
        assert_eq!(fitted(&stage, &recording), only("encoder_stuck", joint));
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
        let column = recording.joints.iter().position(|name| name == joint);
        let column = column.unwrap();
        let at = recording.q[0][column];
        recording.q.iter_mut().for_each(|q| q[column] = at);
        assert_eq!(looked(&stage, &recording), only("encoder_stuck", joint));
        assert_eq!(fitted(&stage, &recording), only("encoder_stuck", joint));
        // Who says that readings are static is not contradicted.
        let mut static_ones = request(&stage, &recording);
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
