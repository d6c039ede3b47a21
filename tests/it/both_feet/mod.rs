//! Logs of both feet on one floor: offsets of the legs show in how the soles lie.
//!
//! The virtual robot puts both soles on the floor by its own numerics. `SESC_SEEDS=200` asks
//! for more logs of each kind.

mod planned;

use std::sync::Arc;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::Diagnosis;
use sesc_identify::diagnose::{self, Verdict};
use sesc_identify::fit::{self, Identification};
use sesc_identify::health::Kind;
use sesc_identify::logs::{LogSource, Sidecar, Table};
use sesc_identify::robot::Robot;
use sesc_identify::{Message, Progress, Watch};
use sesc_reference::World;
use sesc_test_support::feet::{Noise, TwoFootLog};
use sesc_test_support::stage::{Platform, Stage};

/// Encoders to a third of a tick, a CoP that shows little, soles and floor flat to 0.08°.
const COARSE: Noise = Noise {
    cop_m: 5e-3,
    encoder_rad: 5e-4,
    flat_rad: 1.4e-3,
};
/// The same with a CoP that shows what it usually does.
const FINE: Noise = Noise {
    cop_m: 5e-4,
    ..COARSE
};
const POSTURES: usize = 40;
pub(crate) const LEG: [&str; 6] = [
    "hip_yaw",
    "hip_roll",
    "hip_pitch",
    "knee",
    "ank_pitch",
    "ank_roll",
];

/// Logs of each kind.
fn seeds(usual: u64) -> u64 {
    let asked = std::env::var("SESC_SEEDS").ok();
    asked.and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// A log of `stage` on both feet.
fn log(stage: &Stage, world: &World, noise: Noise, seed: u64) -> LogSource {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let log = TwoFootLog::take(stage, world, POSTURES, noise, &mut random);
    let columns = log.columns().into_iter();
    let table = columns.fold(Table::new("two_feet.csv"), |table, (name, values)| {
        table.numbers(&name, values)
    });
    LogSource::from(table).with_sidecar(Sidecar {
        support: Some(stage.support.to_string()),
        both_feet: Some(true),
        ..Sidecar::default()
    })
}

/// Keeps warnings.
#[derive(Default)]
struct Heard(Vec<String>);

impl Watch for Heard {
    fn progress(&mut self, _: Progress) -> std::ops::ControlFlow<()> {
        std::ops::ControlFlow::Continue(())
    }

    fn warning(&mut self, warning: &Message) {
        self.0.push(warning.to_string());
    }
}

fn request(stage: &Stage, world: &World, noise: Noise, seed: u64) -> diagnose::Request {
    let robot = Arc::new(Robot::read(&stage.urdf).unwrap());
    let mut request = diagnose::Request::new(robot, log(stage, world, noise, seed));
    request.noise = Some(noise.cop_m);
    request
}

fn diagnosed(stage: &Stage, world: &World, noise: Noise, seed: u64) -> Diagnosis {
    let request = request(stage, world, noise, seed);
    diagnose::diagnose(&request, &mut ()).unwrap().diagnosis
}

fn fitted(stage: &Stage, world: &World, noise: Noise, seed: u64) -> Identification {
    let mut request = fit::Request::default();
    request.robot = Some(Arc::new(Robot::read(&stage.urdf).unwrap()));
    request.logs = vec![log(stage, world, noise, seed)];
    request.noise = Some(noise.cop_m);
    fit::fit(&request, &mut ()).unwrap().identification
}

/// Whether an explanation of the class is the truth.
fn holds(found: &Diagnosis, truth: &[&str]) -> bool {
    let same = |all: &Vec<String>| {
        all.len() == truth.len() && truth.iter().all(|one| all.iter().any(|x| x == one))
    };
    found.indistinguishable.iter().any(same)
}

/// 1.5° or −1° on each joint of either leg, with noise of 5 mm, where a CoP alone shows next
/// to nothing: named, or in a class of few.
#[test]
fn an_offset_of_a_leg_is_named_from_the_soles_where_the_cop_is_noise() {
    let stage = Stage::new(Platform::Op2);
    let (mut named, mut held, mut all) = (0, 0, 0);
    for (at, joint) in LEG.iter().enumerate() {
        // A hip's yaw turns the foot on the floor and lifts nothing.
        if *joint == "hip_yaw" {
            continue;
        }
        for side in ["l", "r"] {
            let joint = format!("{side}_{joint}");
            let (mut own_named, mut own_held) = (0, 0);
            for seed in 0..seeds(1) {
                let degrees: f64 = if (seed + at as u64).is_multiple_of(2) {
                    1.5
                } else {
                    -1.0
                };
                let world = stage.world();
                let world = world.joint_offset(&joint, degrees.to_radians()).unwrap();
                let found = diagnosed(&stage, &world, COARSE, 1000 * at as u64 + seed);
                own_named += u64::from(found.verdict == Verdict::Named);
                let truth = format!("joint_offset:{joint}");
                own_held += u64::from(holds(&found, &[&truth]));
                if !holds(&found, &[&truth]) {
                    println!("{joint} {degrees} {seed}: {:?}", found.indistinguishable);
                }
                all += 1;
                let closure = found.closure.unwrap();
                assert!(
                    closure.closes && closure.postures == POSTURES,
                    "{closure:?}"
                );
            }
            println!("{joint}: {own_named} named, {own_held} hold the truth");
            named += own_named;
            held += own_held;
        }
    }
    println!("{named} named, {held} hold the truth, of {all}");
    assert!(held * 100 >= all * 95, "{held} of {all}");
    assert!(named * 100 >= all * 50, "{named} of {all}");
}

#[test]
fn nothing_hidden_is_nothing_found() {
    for noise in [COARSE, FINE] {
        let stage = Stage::new(Platform::Op2);
        let (mut alarms, n) = (0, seeds(10));
        for seed in 0..n {
            let found = diagnosed(&stage, &stage.world(), noise, 100 + seed);
            let quiet = matches!(found.verdict, Verdict::None | Verdict::Absorbed);
            let fit = fitted(&stage, &stage.world(), noise, 100 + seed);
            let closes = fit.closure.is_some_and(|closure| closure.closes);
            if !quiet || !closes {
                println!("{seed}: {}", found.sentence);
            }
            alarms += u64::from(!quiet || !closes);
        }
        println!("{noise:?}: {alarms} false alarms of {n}");
        assert!(alarms * 100 <= n, "{alarms} of {n}");
    }
}

/// A floor of 1.5°: both soles lie on it. An ankle's offset, which one foot cannot tell from
/// it, would lift the other sole; what the CoM's height hardly shows stays in its class.
#[test]
fn a_slope_of_the_floor_is_no_offset() {
    let stage = Stage::new(Platform::Op2);
    for seed in 0..seeds(4) {
        let slope = [0.0, 0.026];
        let world = stage.world().ground_slope(slope).unwrap();
        let found = diagnosed(&stage, &world, FINE, 300 + seed);
        println!("{seed}: {:?} {:?}", found.verdict, found.indistinguishable);
        assert!(holds(&found, &["ground_slope"]), "{}", found.sentence);
        let before = found.closure.as_ref().unwrap().before;
        assert!(before.roll_rad.max(before.pitch_rad) < 6e-3, "{before:?}");
        let bends = |effect: &String| effect.contains("joint_") || effect.contains("backlash");
        let bent = found.indistinguishable.iter().flatten().any(bends);
        assert!(!bent, "{}", found.sentence);
        // On one foot the same readings do not tell.
        let mut request = request(&stage, &world, FINE, 300 + seed);
        request.feet.both = Some(false);
        let alone = diagnose::diagnose(&request, &mut ()).unwrap().diagnosis;
        println!("   on one foot {:?}", alone.indistinguishable);
        assert!(
            alone.indistinguishable.iter().flatten().any(bends),
            "{}",
            alone.sentence
        );
    }
}

#[test]
fn a_slope_and_an_offset_are_told_apart() {
    let stage = Stage::new(Platform::Op2);
    let (mut held, n) = (0, seeds(4));
    for seed in 0..n {
        let world = stage.world().ground_slope([0.02, 0.026]).unwrap();
        let world = world.joint_offset("r_ank_roll", 0.03).unwrap();
        let found = diagnosed(&stage, &world, FINE, 400 + seed);
        println!("{seed}: {:?} {:?}", found.verdict, found.indistinguishable);
        held += u64::from(holds(&found, &["joint_offset:r_ank_roll", "ground_slope"]));
    }
    println!("{held} of {n}");
    assert!(held * 4 >= n * 3, "{held} of {n}");
}

/// A fit of masses can do nothing about it, and says which joints explain it.
#[test]
fn a_fit_warns_of_offsets_that_bend_the_legs() {
    let stage = Stage::new(Platform::Op2);
    for (seed, joint) in ["l_knee", "l_ank_roll", "r_hip_pitch"]
        .into_iter()
        .enumerate()
    {
        let world = stage.world().joint_offset(joint, 0.026).unwrap();
        let found = fitted(&stage, &world, COARSE, 500 + seed as u64);
        let closure = found.closure.clone().unwrap();
        assert!(!closure.closes, "{closure:?}");
        let joints: Vec<&str> = closure
            .explained_by
            .iter()
            .map(|o| o.joint.as_str())
            .collect();
        println!("{joint}: {joints:?}; {}", closure.sentence);
        assert!(joints.contains(&joint), "{joint}: {closure:?}");
        let own = closure
            .explained_by
            .iter()
            .find(|o| o.joint == joint)
            .unwrap();
        let off = own.offset_rad.unwrap() - 0.026;
        assert!(off.abs() < 4.0 * own.std, "{own:?}");
        assert!(found.misses_something());
        let warned = found.warnings.iter().any(|warning| warning.contains(joint));
        assert!(warned, "{:?}", found.warnings);
    }
}

/// Logs of one foot that are said to be of both: the soles are degrees apart.
#[test]
fn feet_that_are_not_on_one_floor_are_said_to_be_elsewhere() {
    let stage = Stage::new(Platform::Op2);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let postures = stage.balanced(POSTURES, &mut random);
    let world = stage.world();
    let mut table = Table::new("one_foot.csv");
    for (j, joint) in stage.joint_names().iter().enumerate() {
        let column: Vec<f64> = postures.iter().map(|q| q[j]).collect();
        table = table.numbers(joint, column);
    }
    for (axis, name) in ["cop_x", "cop_y"].into_iter().enumerate() {
        let column: Vec<f64> = postures.iter().map(|q| world.cop(q)[axis]).collect();
        table = table.numbers(name, column);
    }
    let log = LogSource::from(table).with_sidecar(Sidecar {
        support: Some("r_sole".into()),
        other_foot: Some("l_sole".into()),
        ..Sidecar::default()
    });
    let robot = Arc::new(Robot::read(&stage.urdf).unwrap());
    let mut request = diagnose::Request::new(robot, log);
    request.noise = Some(5e-4);
    let mut heard = Heard::default();
    let found = diagnose::diagnose(&request, &mut heard).unwrap().diagnosis;
    assert_eq!(found.verdict, Verdict::Unexplained);
    let warned = |said: &String| said.contains("check that both soles are flat on one floor");
    assert!(heard.0.iter().any(warned), "{:?}", heard.0);
    let said = &found.sentence;
    assert!(
        said.contains("check that both soles are flat on one floor"),
        "{said}"
    );
    // Without it, the log is what it is.
    request.feet.both = Some(false);
    let found = diagnose::diagnose(&request, &mut ()).unwrap().diagnosis;
    assert_eq!(found.verdict, Verdict::None, "{}", found.sentence);
    assert_eq!(found.closure, None);
}

/// A log of both feet that says nothing of them is asked about; one of one foot is not.
#[test]
fn soles_that_are_flat_though_nobody_said_so_are_a_finding() {
    let stage = Stage::new(Platform::Op2);
    let robot = Arc::new(Robot::read(&stage.urdf).unwrap());
    let kinds = |log: LogSource, both: Option<bool>| -> Vec<(String, String)> {
        let log = log.with_sidecar(Sidecar {
            support: Some("r_sole".into()),
            both_feet: both,
            ..Sidecar::default()
        });
        let mut request = diagnose::Request::new(Arc::clone(&robot), log);
        request.noise = Some(5e-4);
        let health = diagnose::look(&request, &mut ()).unwrap();
        let name = |kind: Kind| kind.name().to_string();
        let health = health.into_iter().filter(|f| f.kind == Kind::BothFeetFlat);
        health.map(|f| (name(f.kind), f.target)).collect()
    };
    let flat = [("both_feet_flat".to_string(), "l_sole".to_string())];
    let on_both = || log(&stage, &stage.world(), FINE, 9);
    assert_eq!(kinds(on_both(), None), flat);
    assert_eq!(kinds(on_both(), Some(false)), []);
    assert_eq!(kinds(on_both(), Some(true)), []);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let postures = stage.balanced(POSTURES, &mut random);
    let world = stage.world();
    let mut table = Table::new("one_foot.csv");
    for (j, joint) in stage.joint_names().iter().enumerate() {
        let column: Vec<f64> = postures.iter().map(|q| q[j]).collect();
        table = table.numbers(joint, column);
    }
    for (axis, name) in ["cop_x", "cop_y"].into_iter().enumerate() {
        let column: Vec<f64> = postures.iter().map(|q| world.cop(q)[axis]).collect();
        table = table.numbers(name, column);
    }
    assert_eq!(kinds(LogSource::from(table), None), []);
}

/// The CoP of the right foot alone, which stays under it while the CoM moves away.
#[test]
fn the_cop_of_one_foot_alone_is_warned_of() {
    let stage = Stage::new(Platform::Op2);
    let mut request = request(&stage, &stage.world(), FINE, 9);
    let mut heard = Heard::default();
    diagnose::diagnose(&request, &mut heard).unwrap();
    assert!(
        heard.0.iter().all(|said| !said.contains("one foot")),
        "{:?}",
        heard.0
    );
    let alone = stage.world().sensor_gain([0.1, 0.1]);
    request.log = log(&stage, &alone, FINE, 9);
    diagnose::diagnose(&request, &mut heard).unwrap();
    let said = heard
        .0
        .iter()
        .find(|said| said.contains("like those of one foot"));
    assert!(
        said.is_some_and(|said| said.contains("`l_sole`")),
        "{:?}",
        heard.0
    );
}
