//! Data that nothing can be done with, and a stuck encoder.

use std::path::Path;
use std::sync::Arc;

use sesc_identify::diagnose::Verdict;
use sesc_identify::robot::Robot;
use sesc_reference::World;
use sesc_test_support::command::ROOT;

use super::log::{Log, POSTURES, finds, finds_nothing};

#[test]
fn dead_sensors_are_named_and_nothing_is_fitted_to_them() {
    let mut log = Log::of("r_sole", &[], |w| w, 1);
    log.cop.iter_mut().for_each(|y| *y = [0.01, -0.02]);
    finds(&log, "r_sole", "cop_constant", "-", false);
    let mut log = Log::of("r_sole", &[], |w| w, 2);
    log.cop.iter_mut().for_each(|y| y[1] = 0.0);
    finds(&log, "r_sole", "cop_axis_dead", "y", false);
}

#[test]
fn the_other_foot_is_named() {
    let log = Log::of("r_sole", &[], |w| w, 3);
    finds(&log, "l_sole", "other_foot", "r_sole", false);
}

/// A frame on the sole whose x axis, or y axis, is its normal.
#[test]
fn a_turned_frame_is_named() {
    let robot = Robot::read(Path::new(&format!("{ROOT}/robots/op2/op2.urdf"))).unwrap();
    for (seed, rpy) in [(8, "0 1.5707963267948966 0"), (9, "1.5707963267948966 0 0")] {
        let more = format!(
            "<link name='turned'/><joint name='turn' type='fixed'><parent link='r_sole'/>\
             <child link='turned'/><origin xyz='0 0 0' rpy='{rpy}'/></joint></robot>"
        );
        let text = robot.text().replace("</robot>", &more);
        let mut log = Log::of("r_sole", &[], |w| w, seed);
        log.robot = Arc::new(Robot::parse(&text, "op2.urdf").unwrap());
        finds(&log, "turned", "frame_turned", "turned", false);
        finds_nothing(&log, seed);
    }
}

#[test]
fn shuffled_rows_are_seen() {
    let mut log = Log::of("r_sole", &[], |w| w, 4);
    // A fixed permutation without a fixed point.
    let shuffled: Vec<[f64; 2]> = (0..POSTURES)
        .map(|k| log.cop[(37 * k + 11) % POSTURES])
        .collect();
    log.cop = shuffled;
    finds(&log, "r_sole", "rows_shuffled", "-", false);
}

/// Twenty readings a posture, and none beside its own: readings scatter within postures as CAD
/// has them scatter between.
#[test]
fn shuffled_repeats_are_seen() {
    let mut log = Log::of("r_sole", &[], |w| w, 10);
    let (q, cop) = (log.q.clone(), log.cop.clone());
    let rows: Vec<usize> = (0..20 * POSTURES).map(|k| k / 20).collect();
    log.q = rows.iter().map(|&k| q[k].clone()).collect();
    let jitter = |k: usize| 1e-4 * (1.7 * k as f64).sin();
    // 20 · 80 and 617 have no common divisor.
    let of = |k: usize| cop[rows[(617 * k + 11) % rows.len()]].map(|x| x + jitter(k));
    log.cop = (0..rows.len()).map(of).collect();
    log.noise_is_given = false;
    finds(&log, "r_sole", "rows_shuffled", "-", false);
}

/// An amplifier without its sensor has noise of its own.
#[test]
fn a_dead_axis_may_be_noisy() {
    for noise in [3e-4, 2e-3] {
        let mut log = Log::of("r_sole", &[], |w| w, 11);
        let rows = log.cop.iter_mut().enumerate();
        rows.for_each(|(k, y)| y[0] = 0.01 + noise * (2.3 * k as f64).sin());
        finds(&log, "r_sole", "cop_axis_dead", "x", false);
    }
}

#[test]
fn a_stuck_encoder_is_named_and_a_joint_that_stands_still_is_not() {
    for joint in ["r_knee", "r_ank_pitch", "r_hip_roll"] {
        let mut log = Log::of("r_sole", &[], |w| w, 5);
        let at = log.joints.iter().position(|name| name == joint).unwrap();
        log.q.iter_mut().for_each(|q| q[at] = 0.1);
        finds(&log, "r_sole", "encoder_stuck", joint, true);
    }
    // It says a place far from most where the joint is.
    let mut log = Log::of("r_sole", &[], |w| w, 5);
    let at = log.joints.iter().position(|name| name == "r_knee").unwrap();
    log.q.iter_mut().for_each(|q| q[at] = 0.8);
    finds(&log, "r_sole", "encoder_stuck", "r_knee", true);
    // It really stands still; nothing, or another joint's offset, is to be found.
    let still = ["r_knee", "r_hip_pitch", "head_pan", "l_knee"];
    let log = Log::of("r_sole", &still, |w| w, 6);
    finds_nothing(&log, 6);
    let offset = |w: World| w.joint_offset("r_ank_pitch", 0.05).unwrap();
    finds_nothing(&Log::of("r_sole", &still, offset, 7), 7);
    let own = |w: World| w.joint_offset("r_knee", 0.2).unwrap();
    finds_nothing(&Log::of("r_sole", &still, own, 9), 9);
    let large = |w: World| w.joint_offset("r_ank_pitch", 0.2).unwrap();
    finds_nothing(&Log::of("r_sole", &still, large, 8), 8);
    let drift = |w: World| w.sensor_drift([0.02, 0.0]);
    finds_nothing(&Log::of("r_sole", &still, drift, 9), 9);
}

/// A log in which the encoder of a joint is stuck.
fn stuck(joint: &str, hide: impl Fn(World) -> World, seed: u64) -> Log {
    let mut log = Log::of("r_sole", &[], hide, seed);
    let at = log.joints.iter().position(|name| name == joint).unwrap();
    log.q.iter_mut().for_each(|q| q[at] = 0.1);
    log
}

/// Whoever states the noise: each posture spends a reading on where the joint is.
#[test]
fn beside_a_stuck_encoder_nothing_false_is_named() {
    for (case, joint) in (60..).zip(["r_knee", "r_ank_pitch", "r_hip_roll"]) {
        for noise_is_given in [true, false] {
            let mut log = stuck(joint, |w| w, case);
            log.noise_is_given = noise_is_given;
            let found = log.diagnose("r_sole").diagnosis;
            println!("{joint}, {noise_is_given}: {}", found.sentence);
            assert_eq!(found.health[0].kind.name(), "encoder_stuck");
            assert_eq!(found.verdict, Verdict::None);
        }
    }
}

#[test]
fn what_else_is_wrong_is_found_beside_a_stuck_encoder() {
    let offset = |w: World| w.joint_offset("r_hip_roll", 0.03).unwrap();
    let found = stuck("r_knee", offset, 70).diagnose("r_sole").diagnosis;
    println!("{}", found.sentence);
    assert_eq!(found.health[0].kind.name(), "encoder_stuck");
    let members = &found.indistinguishable;
    let is = |member: &Vec<String>| *member == ["joint_offset:r_hip_roll"];
    assert!(members.iter().any(is), "{members:?}");
}
