//! Broken data are seen before any hypothesis; healthy ones are left alone.

use std::path::Path;
use std::sync::Arc;

use sesc_identify::diagnose::{FLOOR_M, Report, Request, Verdict, diagnose};
use sesc_identify::health::{self, Health};
use sesc_identify::logs::Table;
use sesc_identify::observations::postures::Postures;
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

    fn examine(&self, support: &str) -> Health {
        let model = self
            .robot
            .model(support, Snapping::default(), None)
            .unwrap();
        let (q, cop) = (self.q.concat(), self.cop.concat());
        let mut data = Postures::given(self.joints.len(), &q, &cop, NOISE_M, FLOOR_M);
        health::examine(&self.robot, &model, Snapping::default(), &mut data)
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
    let kinds: Vec<(&str, &str)> = found
        .health
        .iter()
        .map(|h| (h.kind.name(), &*h.target))
        .collect();
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
    finds_nothing(&log, 6);
    let offset = |w: World| w.joint_offset("r_ank_pitch", 0.05).unwrap();
    finds_nothing(&Log::of("r_sole", &still, offset, 7), 7);
}

fn finds_nothing(log: &Log, case: u64) {
    let found = log.examine("r_sole");
    assert!(found.findings.is_empty(), "{case}: {:?}", found.findings);
}

/// Each explains a gap that a finding asks about: readings that go with no posture, axes
/// that are silent, a sole that is elsewhere.
#[test]
fn effects_are_no_broken_data() {
    let hidden: [fn(World) -> World; 12] = [
        |w| w.sensor_offset([0.03, -0.02]),
        |w| w.sensor_offset([-0.02, 0.08]),
        |w| w.sensor_axes(true, [1.0, -1.0]),
        |w| w.sensor_axes(false, [-1.0, -1.0]),
        |w| w.sensor_gain([0.4, 0.4]),
        |w| w.sensor_rotation(1.2),
        |w| w.sensor_unit(1000.0),
        |w| w.joints_in_degrees(),
        |w| w.joint_swap("r_knee", "l_knee").unwrap(),
        |w| w.joint_swap("r_ank_roll", "r_ank_pitch").unwrap(),
        |w| w.joint_sign("r_hip_roll").unwrap(),
        |w| w.payload("body_link", 1.5, [0.05, 0.0, 0.1]).unwrap(),
    ];
    for (case, hide) in (0..).zip(hidden) {
        finds_nothing(&Log::of("r_sole", &[], hide, 20 + case), case);
    }
    let heavier = |mut w: World| {
        let links = [
            "r_hip_pitch_link",
            "l_hip_pitch_link",
            "body_link",
            "l_el_link",
        ];
        for (link, factor) in links.into_iter().zip([1.1, 0.9, 1.1, 0.9]) {
            w = w.link_mass(link, factor, [0.0; 3]).unwrap();
        }
        w
    };
    finds_nothing(&Log::of("r_sole", &[], heavier, 40), 40);
}

/// All that moves in the log is one joint; where two channels are exchanged CAD moves the
/// CoP by much, and a silent sensor is right.
#[test]
fn a_silent_sensor_under_a_swap_is_right() {
    let all = Log::of("r_sole", &[], |w| w, 50).joints;
    let moving = |joint: &str| -> Vec<String> {
        all.iter().filter(|name| *name != joint).cloned().collect()
    };
    let still = moving("r_ank_pitch");
    let still: Vec<&str> = still.iter().map(String::as_str).collect();
    // The encoder of the ankle shows how the head pans, which moves next to nothing.
    let swapped = |w: World| w.joint_swap("r_ank_pitch", "head_pan").unwrap();
    let log = Log::of("r_sole", &still, swapped, 51);
    let still: f64 = log
        .cop
        .iter()
        .map(|y| (y[0] - log.cop[0][0]).abs())
        .fold(0.0, f64::max);
    assert!(still < 3e-3, "{still}");
    finds_nothing(&log, 51);
}
