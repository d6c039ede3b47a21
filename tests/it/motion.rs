//! Logs of robots that move: readings are compared with the ZMP, whose truth is the virtual
//! robot's own numerics.

use std::sync::Arc;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{self, Diagnosis, Verdict};
use sesc_identify::evaluate::{InLog, MotionPredictor, ReadingPredictor};
use sesc_identify::fit::{Identification, MotionModel};
use sesc_identify::logs::{LogSource, Table};
use sesc_identify::predict;
use sesc_identify::robot::{Robot, Stance};
use sesc_identify::simulate::{self, hide};
use sesc_model::Snapping;
use sesc_reference::World;
use sesc_test_support::command::Folder;
use sesc_test_support::moving::Swing;
use sesc_test_support::recording::{Kind, Noise, Recording, draw, normal};
use sesc_test_support::stage::{Platform, Stage};

use crate::asked::{self, labels, lists};

const WHITE: Noise = Noise {
    kind: Kind::White,
    std: [5e-4; 2],
    visit_std: 0.0,
};

fn stage() -> Stage {
    Stage::new(Platform::Op2)
}

fn recorded(hide: impl Fn(World) -> World, swing: Swing, rate: f64, seed: u64) -> Recording {
    let stage = stage();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let world = hide(World::new(&stage.robot, stage.support).unwrap());
    swing.record(&stage, world, WHITE, rate, &mut random)
}

fn fitted(recording: &Recording, motion: MotionModel) -> Identification {
    let mut request = asked::fit_request(&stage(), recording.table(true));
    request.prior = "free".into();
    request.motion = motion;
    asked::fitted(&request)
}

/// All of what motion adds to readings is in them, and `beside` at most.
fn is_whole([share, std]: [f64; 2], beside: f64) {
    assert!((share - 1.0).abs() < 4.0 * std + beside, "{share} ± {std}");
}

/// Parts of parameters within ± 1.96 of their deviations.
fn held(found: &Identification) -> f64 {
    let all = found.parameters.iter();
    let told: Vec<bool> = all
        .filter_map(|p| p.std.map(|std| (p.value - p.cad).abs() < 1.96 * std))
        .collect();
    told.iter().filter(|held| **held).count() as f64 / told.len() as f64
}

#[test]
fn a_fit_knows_parameters_from_a_moving_log() {
    let mut parts = Vec::new();
    for seed in 0..4 {
        let log = recorded(|w| w, Swing::new(0.7, 0.15, 20.0), 100.0, seed);
        let found = fitted(&log, MotionModel::Auto);
        let still = fitted(&log, MotionModel::Off);
        assert!(found.motion.used && !still.motion.used);
        let share = found.motion.share.unwrap();
        is_whole([share.value, share.std], 0.01);
        assert!(found.held_out_rmse < 1.1 * WHITE.std[0]);
        assert!(still.held_out_rmse > 2.0 * WHITE.std[0]);
        parts.push(held(&found));
        // What is left lasts for all of the log, and tells no parameter.
        assert!(still.parameters.iter().all(|p| p.std.is_none()));
    }
    let mean = parts.iter().sum::<f64>() / parts.len() as f64;
    assert!((0.88..=1.0).contains(&mean), "{parts:?}");
}

/// Rows that do not know their accelerations count neither as readings nor in what averaging took
/// off their noise.
#[test]
fn a_part_of_a_moving_log_of_means_is_fitted() {
    let log = recorded(|w| w, Swing::new(0.7, 0.15, 10.0), 50.0, 1);
    let folder = Folder::with("op2");
    folder.write("log.csv", log.csv(true));
    let sidecar = "support = \"r_sole\"\nreadings_per_pose = 10000\n";
    folder.write("log.csv.toml", sidecar);
    folder.stdout("fit op2.urdf --data log.csv --partial log.part");
    let found = folder.json("fit log.part");
    assert_eq!(found["motion"]["used"], true);
    assert!(found["motion"]["rows_left_out"].as_u64() > Some(0));
}

fn diagnosed(recording: &Recording, motion: MotionModel) -> Diagnosis {
    let mut request = asked::of_recording(&stage(), recording);
    request.prior = "tight".into();
    request.noise = Some(WHITE.std[0]);
    request.motion = motion;
    asked::diagnosed(&request)
}

#[test]
fn nothing_is_named_in_a_moving_log_unless_motion_is_off() {
    let log = recorded(|w| w, Swing::new(0.7, 0.15, 10.0), 50.0, 11);
    let found = diagnosed(&log, MotionModel::Auto);
    let off = diagnosed(&log, MotionModel::Off);
    assert_eq!(found.verdict, Verdict::None);
    assert!(found.motion.used);
    let share = found.motion.share.unwrap();
    is_whole([share.value, share.std], 0.01);
    assert!(off.verdict != Verdict::None && off.last.rmse > 2.0 * WHITE.std[0]);
}

/// Readings of a quasi-static robot, stamped faster than it moved: what motion would add is not
/// in them, and no offset of sensor or joints is blamed for that.
#[test]
fn readings_that_need_nothing_where_they_are_static_are_static() {
    let stage = stage();
    let world = World::new(&stage.robot, stage.support).unwrap();
    for seed in 1..=4 {
        let mut log = recorded(|w| w, Swing::new(0.5, 0.15, 15.0), 6.5, seed);
        let random = &mut ChaCha8Rng::seed_from_u64(100 + seed);
        for (q, cop) in log.q.iter().zip(&mut log.cop) {
            *cop = world
                .cop(q)
                .map(|truth| truth + WHITE.std[0] * normal(random));
        }
        let found = diagnosed(&log, MotionModel::Auto);
        assert_eq!(found.verdict, Verdict::None);
        assert!(!found.motion.used);
    }
}

#[test]
fn a_hidden_offset_is_named_in_a_moving_log() {
    let hide = |w: World| w.joint_offset("r_hip_roll", 0.05).unwrap();
    let log = recorded(hide, Swing::new(0.7, 0.15, 10.0), 50.0, 12);
    let found = diagnosed(&log, MotionModel::Auto);
    lists(&found, &["joint_offset:r_hip_roll"]);
}

/// Encoders that write ticks, noise that lasts as long as the motion, rows at 100, 50, 20 and
/// 10 Hz: nothing is missing, and none of these is taken for something that is.
#[test]
fn every_rate_gives_the_same_verdict() {
    const TICK: f64 = std::f64::consts::TAU / 4096.0;
    let slow = Noise {
        kind: Kind::Ar1(0.5),
        ..WHITE
    };
    for (hertz, amplitude, noise, seed) in [(0.7, 0.15, WHITE, 1), (0.2, 0.3, slow, 2)] {
        let swing = Swing {
            tick: TICK,
            ..Swing::new(hertz, amplitude, 20.0)
        };
        let stage = stage();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let world = World::new(&stage.robot, stage.support).unwrap();
        let recording = swing.record(&stage, world, noise, 100.0, &mut random);
        for nth in [1, 2, 5, 10] {
            let found = diagnosed(&recording.every(nth), MotionModel::Auto);
            assert_eq!(found.verdict, Verdict::None, "one in {nth}");
            assert!(found.motion.used);
            let share = found.motion.share.unwrap();
            is_whole([share.value, share.std], 0.0);
        }
    }
}

/// RMS of what predictions of a log are off from its readings, m, rows at its ends apart,
/// with `hidden` in the model file.
fn off(log: LogSource, readings: &[[f64; 2]], motion: MotionModel, hidden: &[&str]) -> f64 {
    let stance = Stance::new(asked::robot(&stage())).on("r_sole");
    let file = hide(stance.model().unwrap(), hidden).unwrap().file;
    let mut request = predict::Request::new(stance, log);
    request.stance.parameters = file.map(Arc::new);
    request.motion = motion;
    let found = predict::predict(&request, &mut ()).unwrap().cop_m;
    let rows = 20..readings.len() - 20;
    let gaps = rows
        .clone()
        .flat_map(|k| [0, 1].map(|axis| found[k][axis] - readings[k][axis]));
    (gaps.map(|gap| gap * gap).sum::<f64>() / (2 * rows.len()) as f64).sqrt()
}

/// Against the virtual robot, whose numerics are its own, also with a weight on its trunk.
#[test]
fn predictions_are_those_of_the_moving_robot() {
    let stage = stage();
    let swing = Swing::new(0.7, 0.15, 10.0);
    let quiet = Noise {
        std: [0.0; 2],
        ..WHITE
    };
    let bare = || World::new(&stage.robot, stage.support).unwrap();
    let loaded = || bare().payload("body_link", 0.3, [0.0, 0.0, 0.03]).unwrap();
    for (rate, within) in [(100.0, 5e-5), (50.0, 5e-5), (20.0, 2e-4)] {
        for (world, hidden) in [
            (bare(), &[][..]),
            (loaded(), &["payload:body_link=0.3kg,0,0,0.03m"]),
        ] {
            let mut random = ChaCha8Rng::seed_from_u64(5);
            let log = swing.record(&stage, world, quiet, rate, &mut random);
            let of = |motion| off(log.table(true).into(), &log.cop, motion, hidden);
            let (moving, standing) = (of(MotionModel::Auto), of(MotionModel::Off));
            assert!(moving < within && standing > 2e-3, "{moving} {standing}");
        }
    }
}

/// A simulated motion, with what its model has hidden, is predicted by the same model.
#[test]
fn simulations_and_predictions_agree() {
    let stance = || Stance::new(asked::robot(&stage())).on("r_sole");
    let hidden = ["joint_offset:r_knee=2deg", "sensor_gain=1.1,0.9"];
    for effects in [&hidden[..0], &hidden[..]] {
        let model = hide(stance().model().unwrap(), effects).unwrap();
        let mut request = simulate::Request::new(model.clone(), 600);
        request.range = Some(0.4);
        request.rate = Some(50.0);
        let folder = Folder::empty();
        let path = folder.join("log.csv");
        simulate::write(&request, &path, &mut ()).unwrap();
        let log = folder.sheet("log.csv");
        assert!((log.numbers(&["t"])[50][0] - 1.0).abs() < 1e-12);
        let cop = log.cop();
        let mut asked = predict::Request::new(stance(), path.as_path());
        asked.stance.parameters = model.file.clone().map(Arc::new);
        let found = predict::predict(&asked, &mut ()).unwrap().cop_m;
        asked.motion = MotionModel::Off;
        let standing = predict::predict(&asked, &mut ()).unwrap().cop_m;
        let worst = |found: &[[f64; 2]]| {
            let rows = found.iter().zip(&cop).skip(10).take(580);
            rows.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]))
                .fold(0.0, f64::max)
        };
        assert!(worst(&found) < 2e-5 && worst(&standing) > 1e-3);
    }
}

/// Joints that are read 50 ms before the CoP, fast motion: the delay is found as long as it
/// is at 100 and at 20 Hz, what motion adds to the CoP being late like its static part.
#[test]
fn a_delay_is_found_as_long_as_it_is_at_every_rate() {
    let hide = |w: World| w.time_delay(0.05);
    let log = recorded(hide, Swing::new(0.7, 0.15, 10.0), 100.0, 13);
    for nth in [1, 5] {
        let found = diagnosed(&log.every(nth), MotionModel::Auto);
        assert_eq!(found.steps[0].effect, "time_delay");
        let delay = &found.steps[0].parameters["delay_s"];
        assert!((delay.value.abs() - 0.05).abs() < 0.001, "{}", delay.value);
        assert!(found.last.rmse < 1.15 * WHITE.std[0], "{}", found.last.rmse);
    }
}

/// A weight on the trunk of a robot in fast motion: it is found, of its mass, at 100, 50, 20
/// and 10 Hz, and nothing else is named.
#[test]
fn a_payload_in_motion_is_found_at_every_rate() {
    let hide = |w: World| w.payload("body_link", 0.3, [0.0, 0.0, 0.03]).unwrap();
    let log = recorded(hide, Swing::new(0.7, 0.15, 10.0), 100.0, 14);
    for nth in [1, 2, 5, 10] {
        let found = diagnosed(&log.every(nth), MotionModel::Auto);
        let [step] = &found.steps[..] else {
            panic!("{}", found.sentence)
        };
        assert_eq!(step.effect, "payload");
        // A head that nods little is as good a place in ten seconds.
        let mass = &step.parameters["mass_kg"];
        match step.target == "body_link" {
            true => assert!((mass.value - 0.3).abs() < 3.0 * mass.std, "{mass:?}"),
            false => lists(&found, &["payload:body_link"]),
        }
        assert!(found.last.rmse < 1.15 * WHITE.std[0], "{}", found.last.rmse);
        assert!(found.model_on_log.agrees);
    }
}

/// A foot, a leg that leans to the side, and a trunk that bows.
const BOWER: &str = r#"<robot name="bower">
  <link name="foot"><inertial><origin xyz="0.02 0 0.03"/><mass value="1"/></inertial></link>
  <link name="leg"><inertial><origin xyz="0 0.01 0.25"/><mass value="3"/>
    <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.04" iyz="0" izz="0.01"/></inertial></link>
  <link name="trunk"><inertial><origin xyz="0.02 0 0.2"/><mass value="5"/>
    <inertia ixx="0.2" ixy="0" ixz="0" iyy="0.15" iyz="0" izz="0.05"/></inertial></link>
  <joint name="ankle" type="revolute"><parent link="foot"/><child link="leg"/>
    <origin xyz="0 0 0.1"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="9" velocity="9"/></joint>
  <joint name="hip" type="revolute"><parent link="leg"/><child link="trunk"/>
    <origin xyz="0 0 0.4"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="9" velocity="9"/></joint>
</robot>"#;

/// Eight minutes at 100 Hz, of which one row in sixteen is kept: how late joints are is found
/// in fast motion as it is in ten seconds of it.
#[test]
fn a_delay_is_found_in_a_long_log() {
    const DELAY_S: f64 = 0.05;
    let robot = Arc::new(Robot::parse(BOWER, "bower.urdf").unwrap());
    let rows = 48_000;
    let waves = [[3.1, 0.3], [4.3, 1.1], [3.7, 2.0], [4.4, 0.5]];
    // Positions, velocities and accelerations of both joints.
    let at = |t: f64, order: i32| -> Vec<f64> {
        let quarter = f64::from(order) * std::f64::consts::FRAC_PI_2;
        let of = |[w, p]: &[f64; 2]| 0.12 * w.powi(order) * (w * t + p + quarter).sin();
        let joints = waves.chunks(2);
        joints.map(|own| own.iter().map(of).sum()).collect()
    };
    let times: Vec<f64> = (0..rows).map(|k| 0.01 * f64::from(k)).collect();
    let all = |order: i32, late: f64| -> Vec<f64> {
        times.iter().flat_map(|t| at(t + late, order)).collect()
    };
    let model = robot.model("foot", Snapping::Off, None).unwrap();
    let moving = MotionPredictor::new(&model);
    let [q, rates, gains] = [0, 1, 2].map(|order| all(order, DELAY_S));
    let shifts = moving.shifts(&q, rows as usize, (&rates, &gains));
    let asked = (&q[..], rows as usize);
    let cop = ReadingPredictor::new(&model)
        .run(asked, &InLog::default(), &[], &shifts)
        .1;
    let mut random = ChaCha8Rng::seed_from_u64(21);
    let noise = [5e-4; 2].map(|std| draw(Kind::White, std, &times, &mut random));
    let seen = all(0, 0.0);
    let column =
        |of: &[f64], k: usize| -> Vec<f64> { of.iter().skip(k).step_by(2).copied().collect() };
    let reading = |axis: usize| -> Vec<f64> {
        let own = column(&cop, axis).into_iter().zip(&noise[axis]);
        own.map(|(y, e)| y + e).collect()
    };
    let log = Table::new("long")
        .numbers("t", times.clone())
        .numbers("ankle", column(&seen, 0))
        .numbers("hip", column(&seen, 1))
        .numbers("cop_x", reading(0))
        .numbers("cop_y", reading(1));
    let mut request = diagnose::Request::new(robot, log);
    request.support = Some("foot".to_string());
    request.prior = "tight".into();
    request.noise = Some(5e-4);
    let found = asked::diagnosed(&request);
    assert_eq!(labels(&found), ["time_delay:-"]);
    let delay = found.steps[0].parameters["delay_s"].value;
    assert!((delay.abs() - DELAY_S).abs() < 0.001, "{delay}");
    assert!(found.last.rmse < 1.15 * 5e-4, "{}", found.last.rmse);
}
