//! The model file is what was diagnosed: on the log that it came from it predicts what
//! the diagnosis states, whatever masses and effects do together.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{Report, Verdict, diagnose};
use sesc_identify::fit::prior::PriorChoice;
use sesc_identify::logs::LogSource;
use sesc_identify::simulate::Simulator;
use sesc_model::Snapping;
use sesc_reference::{Error, World};
use sesc_test_support::command::{Folder, list, says};
use sesc_test_support::examine::left_by_file;
use sesc_test_support::recording::Recording;
use sesc_test_support::stage::{Platform, Stage};

use crate::asked::{request, robot};

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

/// An OP2 whose links weigh 10 % more or less than CAD says.
fn heavy_and_light(stage: &Stage) -> World {
    let links = stage.robot.links().iter().enumerate();
    links.fold(stage.world(), |world, (k, link)| {
        let factor = if k % 2 == 0 { 1.1 } else { 0.9 };
        world.link_mass(&link.name, factor, [0.0; 3]).unwrap()
    })
}

/// What is diagnosed in random postures of a world, and their log.
fn report(stage: &Stage, world: &World, prior: &str, seed: u64) -> (Report, LogSource) {
    let model = robot(stage)
        .model("r_sole", Snapping::default(), None)
        .unwrap();
    let mut simulator = Simulator::new(&model.tree.dofs, Some(0.4), seed);
    let q = (0..POSTURES).map(|_| simulator.posture()).collect();
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let log = Recording::still(stage, world, q, NOISE_M, random).table(false);
    let mut request = request(stage, log);
    request.noise = Some(NOISE_M);
    request.prior = PriorChoice::from(prior);
    (diagnose(&request, &mut ()).unwrap(), request.log)
}

fn check(hidden: &[usize], prior: &str, seed: u64) {
    let stage = Stage::new(Platform::Op2);
    let hide = |world, k: &usize| HIDDEN[*k].1(world).unwrap();
    let world = hidden.iter().fold(heavy_and_light(&stage), hide);
    let names: Vec<&str> = hidden.iter().map(|&k| HIDDEN[k].0).collect();
    let (report, log) = report(&stage, &world, prior, seed);
    let predicted = left_by_file(&report, &robot(&stage), "r_sole", &log).unwrap();
    let found = report.diagnosis;
    let on_log = &found.model_on_log;
    assert!(on_log.agrees, "{}", found.sentence);
    // What the command `predict` leaves with the written file, not what the diagnosis says of it.
    let apart = (predicted / on_log.stated_rmse - 1.0).abs();
    assert!(apart <= 0.01, "{names:?} {prior} {seed}: {on_log:?}");
    // Those that the fit itself puts on a side that only the log knows are among them.
    assert!(on_log.left_out.len() <= POSTURES / 4, "{on_log:?}");
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
    let stage = Stage::new(Platform::Op2);
    // Two ropes that carry the robot would show such a gain, too.
    let gain = stage.world().sensor_gain([8.0, 8.0]);
    let slope = stage.world().ground_slope([0.7, 0.0]).unwrap();
    let scale = stage.world().joint_scale("r_hip_pitch", 2.6).unwrap();
    for (world, reason) in [
        (gain, "implausible"),
        (slope, "20°"),
        (scale, "factor of 2"),
    ] {
        let (report, _) = report(&stage, &world, "tight", 5);
        let found = &report.diagnosis;
        assert_eq!(found.verdict, Verdict::Unexplained, "{reason}");
        says(found.implausible.as_deref().unwrap_or_default(), &[reason]);
        let written = report.model_file.effects.iter();
        for record in written {
            let of = |name: &str| record.parameters.get(name).map_or(1.0, |p| p.value);
            assert!((0.2..5.0).contains(&of("gain_x")), "{record:?}");
            let flat = of("slope_x").abs() < 0.36 || of("slope_x") == 1.0;
            assert!(flat, "{record:?}");
            assert!((0.5..2.0).contains(&of("scale").abs()), "{record:?}");
        }
    }
}

/// Three effects on a robot whose masses settle far from CAD's: the explanation that fits best
/// before they settle has a spring that pushes, and no file may hold such a one.
#[test]
fn a_spring_that_pushes_once_masses_settle_is_passed_over() {
    let folder = Folder::with("skew_humanoid");
    folder.stdout(
        "simulate skew_humanoid.urdf --support right_sole --poses 500 --range 30 --noise 0.0005 \
         --seed 1 --hide joint_offset:right_knee=2deg --hide payload:chest=0.5,0,0,0.1 \
         --hide joint_compliance:right_ankle_pitch=2000 --out log.csv",
    );
    let found = folder.json("diagnose skew_humanoid.urdf --data log.csv");
    // Offset and spring are there, and masses take what the load of 0.5 kg does.
    assert_eq!(found["unexplained"], false, "{}", found["sentence"]);
    for step in list(&found, "/steps") {
        let stiffness = &step["parameters"]["stiffness_nm_per_rad"]["value"];
        assert!(stiffness.as_f64().is_none_or(|k| k > 0.0), "{step}");
    }
}
