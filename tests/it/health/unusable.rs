//! Data that nothing can be done with, and a stuck encoder.

use std::sync::Arc;

use sesc_identify::diagnose::Verdict;
use sesc_identify::robot::Robot;
use sesc_reference::World;

use super::log::{Log, POSTURES, finds, finds_nothing};
use crate::asked::lists;

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
    for (seed, rpy) in [(8, "0 1.5707963267948966 0"), (9, "1.5707963267948966 0 0")] {
        let more = format!(
            "<link name='turned'/><joint name='turn' type='fixed'><parent link='r_sole'/>\
             <child link='turned'/><origin xyz='0 0 0' rpy='{rpy}'/></joint></robot>"
        );
        let mut log = Log::of("r_sole", &[], |w| w, seed);
        let text = log.robot.text().replace("</robot>", &more);
        log.robot = Arc::new(Robot::parse(&text, "op2.urdf").unwrap());
        finds(&log, "turned", "frame_turned", "turned", false);
        finds_nothing(&log, seed);
    }
}

#[test]
fn shuffled_rows_are_seen() {
    let mut log = Log::of("r_sole", &[], |w| w, 4);
    // A fixed permutation without a fixed point.
    let shuffled = (0..POSTURES).map(|k| log.cop[(37 * k + 11) % POSTURES]);
    log.cop = shuffled.collect();
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
    let log = Log::of("r_sole", &[], |w| w, 5);
    // Last it says a place far from most where the joint is.
    let [knee, ankle, hip] = ["r_knee", "r_ank_pitch", "r_hip_roll"];
    for (joint, at) in [(knee, 0.1), (ankle, 0.1), (hip, 0.1), (knee, 0.8)] {
        let stuck = log.clone().stuck(joint, at);
        finds(&stuck, "r_sole", "encoder_stuck", joint, true);
    }
    // It really stands still; nothing, or another joint's offset, is to be found.
    let still = ["r_knee", "r_hip_pitch", "head_pan", "l_knee"];
    let hidden: [fn(World) -> World; 5] = [
        |w| w,
        |w| w.joint_offset("r_ank_pitch", 0.05).unwrap(),
        |w| w.joint_offset("r_knee", 0.2).unwrap(),
        |w| w.joint_offset("r_ank_pitch", 0.2).unwrap(),
        |w| w.sensor_drift([0.02, 0.0]),
    ];
    for (hide, seed) in hidden.into_iter().zip([6, 7, 9, 8, 9]) {
        finds_nothing(&Log::of("r_sole", &still, hide, seed), seed);
    }
}

/// Whoever states the noise: each posture spends a reading on where the joint is.
#[test]
fn beside_a_stuck_encoder_nothing_false_is_named() {
    for (case, joint) in (60..).zip(["r_knee", "r_ank_pitch", "r_hip_roll"]) {
        for noise_is_given in [true, false] {
            let mut log = Log::of("r_sole", &[], |w| w, case).stuck(joint, 0.1);
            log.noise_is_given = noise_is_given;
            let found = log.diagnose();
            assert_eq!(found.health[0].kind.name(), "encoder_stuck");
            assert_eq!(found.verdict, Verdict::None, "{joint}");
        }
    }
}

#[test]
fn what_else_is_wrong_is_found_beside_a_stuck_encoder() {
    let offset = |w: World| w.joint_offset("r_hip_roll", 0.03).unwrap();
    let found = Log::of("r_sole", &[], offset, 70)
        .stuck("r_knee", 0.1)
        .diagnose();
    assert_eq!(found.health[0].kind.name(), "encoder_stuck");
    lists(&found, &["joint_offset:r_hip_roll"]);
}
