//! The model file is what was diagnosed: on the log that it came from it predicts what
//! the diagnosis states, whatever masses and effects do together.

use std::path::Path;
use std::sync::Arc;

use sesc_identify::diagnose::{Report, Request, Verdict, diagnose};
use sesc_identify::fit::prior::PriorChoice;
use sesc_identify::logs::{LogSource, Table};
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::Snapping;
use sesc_reference::{Error, World};
use sesc_test_support::command::{ROOT, folder, sesc, stdout};
use sesc_test_support::examine::left_by_file;

const POSTURES: usize = 70;
const NOISE_M: f64 = 2e-4;

type Hide = fn(World) -> Result<World, Error>;

/// Effects at small and at large sizes.
const HIDDEN: [(&str, Hide); 13] = [
    ("nothing", Ok),
    ("offset 1.5°", |w| w.joint_offset("r_knee", 0.026)),
    ("offset 10°", |w| w.joint_offset("r_hip_roll", 0.17)),
    ("gain 1.05", |w| Ok(w.sensor_gain([1.05, 1.0]))),
    ("gain 1.3", |w| Ok(w.sensor_gain([1.3, 1.3]))),
    ("gain 2.1", |w| Ok(w.sensor_gain([2.1, 2.1]))),
    ("payload 50 g", |w| {
        w.payload("body_link", 0.05, [0.03, 0.02, 0.05])
    }),
    ("payload 1 kg", |w| {
        w.payload("body_link", 1.0, [0.03, 0.02, 0.05])
    }),
    ("slope 1°", |w| w.ground_slope([0.017, -0.01])),
    ("slope 8°", |w| w.ground_slope([0.14, 0.05])),
    ("scale 1.1", |w| w.joint_scale("r_hip_pitch", 1.1)),
    ("soft knee", |w| w.joint_compliance("r_knee", 60.0)),
    ("backlash 2°", |w| w.backlash_all(0.035)),
];

fn robot() -> Arc<Robot> {
    Arc::new(Robot::read(Path::new(&format!("{ROOT}/robots/op2/op2.urdf"))).unwrap())
}

/// An OP2 whose links weigh 10 % more or less than CAD says.
fn heavy_and_light(robot: &Robot) -> World {
    let described = sesc_reference::Robot::from_urdf(robot.text()).unwrap();
    let mut world = World::new(&described, "r_sole").unwrap();
    for (k, link) in described.links().iter().enumerate() {
        let factor = if k % 2 == 0 { 1.1 } else { 0.9 };
        world = world.link_mass(&link.name, factor, [0.0; 3]).unwrap();
    }
    world
}

/// What is diagnosed in random postures of a world, and their log.
fn report(robot: &Arc<Robot>, world: &World, prior: &str, seed: u64) -> (Report, LogSource) {
    let model = robot.model("r_sole", Snapping::default(), None).unwrap();
    let mut simulator = Simulator::new(&model.tree.dofs, Some(0.4), seed);
    let q: Vec<Vec<f64>> = (0..POSTURES).map(|_| simulator.posture()).collect();
    let readings: Vec<[f64; 2]> = q.iter().map(|q| world.cop(q)).collect();
    let mut axis = |axis: usize| -> Vec<f64> {
        let readings = readings.iter();
        readings
            .map(|y| y[axis] + simulator.gauss(NOISE_M))
            .collect()
    };
    let (x, y) = (axis(0), axis(1));
    let mut log = Table::new("log").numbers("cop_x", x).numbers("cop_y", y);
    for (j, dof) in model.tree.dofs.iter().enumerate() {
        let column: Vec<f64> = q.iter().map(|q| q[j]).collect();
        log = log.numbers(&dof.joint, column);
    }
    let log = LogSource::from(log);
    let mut request = Request::new(robot.clone(), log.clone());
    request.support = Some("r_sole".into());
    request.noise = Some(NOISE_M);
    request.prior = PriorChoice::from(prior);
    (diagnose(&request, &mut ()).unwrap(), log)
}

fn check(hidden: &[usize], prior: &str, seed: u64) {
    let robot = robot();
    let world = hidden.iter().fold(heavy_and_light(&robot), |world, &k| {
        HIDDEN[k].1(world).unwrap()
    });
    let names: Vec<&str> = hidden.iter().map(|&k| HIDDEN[k].0).collect();
    let (report, log) = report(&robot, &world, prior, seed);
    let predicted = left_by_file(&report, &robot, "r_sole", &log).unwrap();
    let found = report.diagnosis;
    let on_log = &found.model_on_log;
    let effects: Vec<String> = found
        .steps
        .iter()
        .map(|s| format!("{}:{}", s.effect, s.target))
        .collect();
    println!(
        "{names:?} {prior} {seed}: stated {:.3} mm, file {:.3} mm, {:?} {effects:?}",
        1e3 * on_log.stated_rmse,
        1e3 * predicted,
        found.verdict,
    );
    assert!(on_log.agrees, "{}", found.sentence);
    // What the command `predict` leaves with the written file, not what the diagnosis says of it.
    let apart = (predicted / on_log.stated_rmse - 1.0).abs();
    assert!(apart <= 0.01, "{names:?} {prior} {seed}: {on_log:?}");
    // Those that the fit itself puts on a side that only the log knows are among them.
    assert!(
        on_log.left_out.len() <= POSTURES / 4,
        "{names:?}: {on_log:?}"
    );
    assert!(found.verdict == Verdict::Unexplained || found.implausible.is_none());
}

#[test]
fn it_predicts_what_is_stated_under_each_effect_and_prior() {
    for (k, _) in HIDDEN.iter().enumerate() {
        for (seed, prior) in ["tight", "cad", "free"].into_iter().enumerate() {
            check(&[k], prior, 10 + 3 * k as u64 + seed as u64);
        }
    }
}

/// On which side of its dead band a joint rests, the file decides by its own masses, however
/// little the log says of them.
#[test]
fn it_predicts_what_is_stated_where_joints_are_loose() {
    let beside: [&[usize]; 4] = [&[12], &[12, 1], &[12, 7], &[12, 11]];
    for (k, hidden) in beside.into_iter().enumerate() {
        check(hidden, "cad", 203 - k as u64);
        check(hidden, "free", 200 + k as u64);
    }
}

#[test]
fn it_predicts_what_is_stated_under_two_effects() {
    let pairs = [[2, 4], [5, 7], [1, 9], [6, 11], [10, 3], [8, 12]];
    for (k, pair) in pairs.iter().enumerate() {
        let prior = ["tight", "cad", "free"][k % 3];
        check(pair, prior, 100 + k as u64);
    }
}

/// What no robot has is never named, and never written.
#[test]
fn what_is_physically_impossible_is_unexplained_and_not_written() {
    let robot = robot();
    let described = sesc_reference::Robot::from_urdf(robot.text()).unwrap();
    let world = || World::new(&described, "r_sole").unwrap();
    let cases: [(&str, World, &str); 3] = [
        // Two ropes that carry the robot would show this, too.
        (
            "a gain of 8",
            world().sensor_gain([8.0, 8.0]),
            "implausible",
        ),
        (
            "a slope of 35°",
            world().ground_slope([0.7, 0.0]).unwrap(),
            "20°",
        ),
        (
            "a scale of 2.6",
            world().joint_scale("r_hip_pitch", 2.6).unwrap(),
            "factor of 2",
        ),
    ];
    for (name, world, reason) in cases {
        let (report, _) = report(&robot, &world, "tight", 5);
        let found = &report.diagnosis;
        println!("{name}: {:?} {}", found.verdict, found.sentence);
        assert_eq!(found.verdict, Verdict::Unexplained, "{name}");
        let why = found.implausible.as_deref().unwrap_or_default();
        assert!(why.contains(reason), "{name}: {why}");
        let written = report.model_file.effects.iter();
        for record in written {
            let of = |name: &str| record.parameters.get(name).map_or(1.0, |p| p.value);
            assert!((0.2..5.0).contains(&of("gain_x")), "{record:?}");
            assert!(
                of("slope_x").abs() < 0.36 || of("slope_x") == 1.0,
                "{record:?}"
            );
            assert!((0.5..2.0).contains(&of("scale").abs()), "{record:?}");
        }
    }
}

/// Three effects on a robot whose masses settle far from CAD's: the explanation that fits best
/// before they settle has a spring that pushes, and no file may hold such a one.
#[test]
fn a_spring_that_pushes_once_masses_settle_is_passed_over() {
    let folder = folder();
    let urdf = format!("{ROOT}/robots/skew_humanoid/skew_humanoid.urdf");
    let log = folder.path().join("log.csv");
    let simulated = sesc(&[
        "simulate",
        &urdf,
        "--support",
        "right_sole",
        "--poses",
        "500",
        "--range",
        "30",
        "--noise",
        "0.0005",
        "--seed",
        "1",
        "--hide",
        "joint_offset:right_knee=2deg",
        "--hide",
        "payload:chest=0.5,0,0,0.1",
        "--hide",
        "joint_compliance:right_ankle_pitch=2000",
        "--out",
        log.to_str().unwrap(),
    ]);
    assert!(simulated.status.success());
    let answered = sesc(&["diagnose", &urdf, "--data", log.to_str().unwrap(), "--json"]);
    let text = stdout(&answered);
    let found: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(found["error"], serde_json::Value::Null, "{text}");
    // Offset and spring are there, and masses take what the load of 0.5 kg does.
    assert_eq!(found["unexplained"], false, "{}", found["sentence"]);
    let steps = found["steps"].as_array().unwrap();
    let springs = steps
        .iter()
        .map(|step| &step["parameters"]["stiffness_nm_per_rad"]["value"]);
    let stiffness: Vec<f64> = springs.filter_map(serde_json::Value::as_f64).collect();
    assert!(stiffness.iter().all(|k| *k > 0.0), "{stiffness:?}");
}
