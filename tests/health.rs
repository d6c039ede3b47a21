//! Broken data are seen before any hypothesis; healthy ones are left alone.

use std::path::Path;
use std::sync::Arc;

use sesc_identify::diagnose::{Report, Request, Verdict, diagnose};
use sesc_identify::logs::Table;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::Snapping;
use sesc_reference::World;
use sesc_test_support::command::ROOT;

const POSTURES: usize = 80;
const NOISE_M: f64 = 3e-4;

/// A log of the OP2 while it is broken.
struct Log {
    robot: Arc<Robot>,
    joints: Vec<String>,
    q: Vec<Vec<f64>>,
    cop: Vec<[f64; 2]>,
}

impl Log {
    /// Postures of a world that stands on `foot`; `fixed` joints do not move.
    fn of(foot: &str, fixed: &[&str], hide: impl Fn(World) -> World, seed: u64) -> Log {
        let robot = Robot::read(Path::new(&format!("{ROOT}/robots/op2/op2.urdf"))).unwrap();
        let model = robot.model(foot, Snapping::default(), None).unwrap();
        let joints: Vec<String> = model.tree.dofs.iter().map(|d| d.joint.clone()).collect();
        let mut simulator = Simulator::new(&model.tree.dofs, Some(0.4), seed);
        let mut q: Vec<Vec<f64>> = (0..POSTURES).map(|_| simulator.posture()).collect();
        for q in &mut q {
            for (x, joint) in q.iter_mut().zip(&joints) {
                if fixed.contains(&joint.as_str()) {
                    *x = 0.2;
                }
            }
        }
        let described = sesc_reference::Robot::from_urdf(robot.text()).unwrap();
        let world = hide(World::new(&described, foot).unwrap());
        let cop = q
            .iter()
            .map(|q| world.cop(q).map(|y| y + simulator.gauss(NOISE_M)));
        Log {
            cop: cop.collect(),
            robot: Arc::new(robot),
            joints,
            q,
        }
    }

    fn diagnose(&self, support: &str) -> Report {
        let axis = |k: usize| -> Vec<f64> { self.cop.iter().map(|y| y[k]).collect() };
        let mut log = Table::new("log")
            .numbers("cop_x", axis(0))
            .numbers("cop_y", axis(1));
        for (j, joint) in self.joints.iter().enumerate() {
            let column: Vec<f64> = self.q.iter().map(|q| q[j]).collect();
            log = log.numbers(joint, column);
        }
        let mut request = Request::new(self.robot.clone(), log);
        request.support = Some(support.into());
        request.noise = Some(NOISE_M);
        diagnose(&request, &mut ()).unwrap()
    }
}

fn finds(log: &Log, support: &str, kind: &str, target: &str, usable: bool) {
    let found = log.diagnose(support).diagnosis;
    let kinds: Vec<(&str, &str)> = found.health.iter().map(|h| (h.kind, &*h.target)).collect();
    println!("{kinds:?}: {}", found.sentence);
    assert_eq!(kinds, [(kind, target)]);
    assert_eq!(found.verdict == Verdict::Unusable, !usable);
    assert!(usable || found.steps.is_empty() && found.indistinguishable.is_empty());
}

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
fn the_other_foot_and_a_turned_frame_are_named() {
    let log = Log::of("r_sole", &[], |w| w, 3);
    finds(&log, "l_sole", "other_foot", "r_sole", false);
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

#[test]
fn a_stuck_encoder_is_named_and_a_joint_that_stands_still_is_not() {
    for joint in ["r_knee", "r_ank_pitch", "r_hip_roll"] {
        let mut log = Log::of("r_sole", &[], |w| w, 5);
        let at = log.joints.iter().position(|name| name == joint).unwrap();
        log.q.iter_mut().for_each(|q| q[at] = 0.1);
        finds(&log, "r_sole", "encoder_stuck", joint, true);
    }
    // It really stands still; nothing, or another joint's offset, is to be found.
    let still = ["r_knee", "r_hip_pitch", "head_pan", "l_knee"];
    let log = Log::of("r_sole", &still, |w| w, 6);
    assert!(log.diagnose("r_sole").diagnosis.health.is_empty());
    let offset = |w: World| w.joint_offset("r_ank_pitch", 0.05).unwrap();
    let log = Log::of("r_sole", &still, offset, 7);
    let found = log.diagnose("r_sole").diagnosis;
    assert!(found.health.is_empty(), "{:?}", found.health);
}

#[test]
fn effects_are_no_broken_data() {
    let hidden: [fn(World) -> World; 6] = [
        |w| w.sensor_offset([0.03, -0.02]),
        |w| w.sensor_axes(true, [1.0, -1.0]),
        |w| w.sensor_gain([0.4, 0.4]),
        |w| w.joint_swap("r_knee", "l_knee").unwrap(),
        |w| w.joint_sign("r_hip_roll").unwrap(),
        |w| w.payload("body_link", 1.5, [0.05, 0.0, 0.1]).unwrap(),
    ];
    for (seed, hide) in hidden.into_iter().enumerate() {
        let found = Log::of("r_sole", &[], hide, 20 + seed as u64)
            .diagnose("r_sole")
            .diagnosis;
        assert!(found.health.is_empty(), "{seed}: {:?}", found.health);
    }
}
