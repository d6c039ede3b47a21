//! Logs of both feet on one floor: offsets of the legs show in how the soles lie.
//!
//! The virtual robot puts both soles on the floor by its own numerics. `SESC_SEEDS=200` asks
//! for more logs of each kind.

mod planned;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{self, Diagnosis, Verdict};
use sesc_identify::fit::Identification;
use sesc_identify::health::Kind;
use sesc_identify::logs::{LogSource, Sidecar};
use sesc_identify::predict;
use sesc_identify::robot::Stance;
use sesc_identify::{Message, Progress, Watch};
use sesc_model::ModelFile;
use sesc_reference::World;
use sesc_test_support::command::says;
use sesc_test_support::feet::{Noise, record};
use sesc_test_support::recording::Recording;
use sesc_test_support::stage::{Platform, Stage};

use crate::asked::{self, fit_request, is_listed, lists, robot};

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
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    on_soles(record(stage, world, POSTURES, noise, random), Some(true))
}

/// A log of the OP2 whose sidecar says whether it is of both feet.
fn on_soles(log: Recording, both_feet: Option<bool>) -> LogSource {
    LogSource::from(log.table(false)).with_sidecar(Sidecar {
        support: Some("r_sole".to_string()),
        both_feet,
        ..Sidecar::default()
    })
}

/// Postures of one foot, without noise.
fn on_one_foot(stage: &Stage) -> Recording {
    let random = &mut ChaCha8Rng::seed_from_u64(7);
    let q = stage.balanced(POSTURES, random);
    Recording::still(stage, &stage.world(), q, 0.0, random)
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
    let mut request = asked::request(stage, log(stage, world, noise, seed));
    request.noise = Some(noise.cop_m);
    request
}

fn diagnosed(stage: &Stage, world: &World, noise: Noise, seed: u64) -> Diagnosis {
    asked::diagnosed(&request(stage, world, noise, seed))
}

fn fitted(stage: &Stage, world: &World, noise: Noise, seed: u64) -> Identification {
    let mut request = fit_request(stage, log(stage, world, noise, seed));
    request.noise = Some(noise.cop_m);
    asked::fitted(&request)
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
            for seed in 0..seeds(1) {
                let degrees = [1.5_f64, -1.0][(seed as usize + at) % 2];
                let world = stage.world();
                let world = world.joint_offset(&joint, degrees.to_radians()).unwrap();
                let found = diagnosed(&stage, &world, COARSE, 1000 * at as u64 + seed);
                named += u64::from(found.verdict == Verdict::Named);
                let truth = format!("joint_offset:{joint}");
                held += u64::from(is_listed(&found, &[&truth]));
                all += 1;
                let closure = found.closure.unwrap();
                assert!(closure.closes, "{closure:?}");
                assert_eq!(closure.postures, POSTURES);
            }
        }
    }
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
            alarms += u64::from(!quiet || !closes);
        }
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
        lists(&found, &["ground_slope"]);
        let before = found.closure.as_ref().unwrap().before;
        assert!(before.roll_rad.max(before.pitch_rad) < 6e-3, "{before:?}");
        let bends = |effect: &String| effect.contains("joint_") || effect.contains("backlash");
        let bent = found.indistinguishable.iter().flatten().any(bends);
        assert!(!bent, "{}", found.sentence);
        // On one foot the same readings do not tell.
        let mut request = request(&stage, &world, FINE, 300 + seed);
        request.feet.both = Some(false);
        let alone = asked::diagnosed(&request).indistinguishable;
        assert!(alone.iter().flatten().any(bends), "{alone:?}");
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
        let both = ["joint_offset:r_ank_roll", "ground_slope"];
        held += u64::from(is_listed(&found, &both));
    }
    assert!(held * 4 >= n * 3, "{held} of {n}");
}

/// A fit of masses can do nothing about it, and says which joints explain it.
#[test]
fn a_fit_warns_of_offsets_that_bend_the_legs() {
    let stage = Stage::new(Platform::Op2);
    let joints = ["l_knee", "l_ank_roll", "r_hip_pitch"].into_iter();
    for (seed, joint) in joints.enumerate() {
        let world = stage.world().joint_offset(joint, 0.026).unwrap();
        let found = fitted(&stage, &world, COARSE, 500 + seed as u64);
        let closure = found.closure.clone().unwrap();
        assert!(!closure.closes, "{closure:?}");
        let own = closure.explained_by.iter().find(|o| o.joint == joint);
        let own = own.unwrap_or_else(|| panic!("{joint}: {closure:?}"));
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
    let log = LogSource::from(on_one_foot(&stage).table(false)).with_sidecar(Sidecar {
        other_foot: Some("l_sole".into()),
        ..Sidecar::default()
    });
    let mut request = asked::request(&stage, log);
    request.noise = Some(5e-4);
    let mut heard = Heard::default();
    let found = diagnose::diagnose(&request, &mut heard).unwrap().diagnosis;
    assert_eq!(found.verdict, Verdict::Unexplained);
    let words = ["check that both soles are flat on one floor"];
    says(heard.0.join("\n"), &words);
    says(found.sentence, &words);
    // Without it, the log is what it is.
    request.feet.both = Some(false);
    let found = asked::diagnosed(&request);
    assert_eq!(found.verdict, Verdict::None);
    assert_eq!(found.closure, None);
}

/// A log of both feet that says nothing of them is asked about; one of one foot is not.
#[test]
fn soles_that_are_flat_though_nobody_said_so_are_a_finding() {
    let stage = Stage::new(Platform::Op2);
    let flat = |log: LogSource| -> Vec<String> {
        let mut request = asked::request(&stage, log);
        request.noise = Some(5e-4);
        let health = diagnose::look(&request, &mut ()).unwrap();
        let flat = health.into_iter().filter(|f| f.kind == Kind::BothFeetFlat);
        flat.map(|f| f.target).collect()
    };
    let random = || ChaCha8Rng::seed_from_u64(9);
    let on_both = record(&stage, &stage.world(), POSTURES, FINE, &mut random());
    assert_eq!(flat(on_soles(on_both.clone(), None)), ["l_sole"]);
    assert_eq!(flat(on_soles(on_both.clone(), Some(false))), [""; 0]);
    assert_eq!(flat(on_soles(on_both, Some(true))), [""; 0]);
    assert_eq!(flat(on_soles(on_one_foot(&stage), None)), [""; 0]);
}

/// A prediction takes encoders at their word: it says where the soles do not close then, and not
/// where a model file has what they are off by.
#[test]
fn a_prediction_warns_of_soles_that_do_not_close() {
    let stage = Stage::new(Platform::Op2);
    let world = stage.world().joint_offset("l_knee", 0.026).unwrap();
    let warned = |world: &World, file: Option<ModelFile>| {
        let mut stance = Stance::new(robot(&stage)).on("r_sole");
        if let Some(file) = file {
            stance = stance.with_parameters(file).unwrap();
        }
        let request = predict::Request::new(stance, log(&stage, world, FINE, 11));
        let mut heard = Heard::default();
        predict::predict(&request, &mut heard).unwrap();
        heard.0.join("\n")
    };
    says(
        warned(&world, None),
        &["By CAD the sole of l_sole", "l_knee"],
    );
    assert_eq!(warned(&stage.world(), None), "");
    let request = request(&stage, &world, FINE, 11);
    let found = diagnose::diagnose(&request, &mut ()).unwrap();
    assert_eq!(warned(&world, Some(found.model_file.clone())), "");
    // The other way round the file is what opens them.
    let open = warned(&stage.world(), Some(found.model_file));
    says(open, &["By the model file the sole of l_sole"]);
}

/// The CoP of the right foot alone, which stays under it while the CoM moves away.
#[test]
fn the_cop_of_one_foot_alone_is_warned_of() {
    let stage = Stage::new(Platform::Op2);
    let mut request = request(&stage, &stage.world(), FINE, 9);
    let mut heard = Heard::default();
    diagnose::diagnose(&request, &mut heard).unwrap();
    let said = heard.0.join("\n");
    assert!(!said.contains("one foot"), "{said}");
    let alone = stage.world().sensor_gain([0.1, 0.1]);
    request.log = log(&stage, &alone, FINE, 9);
    diagnose::diagnose(&request, &mut heard).unwrap();
    says(heard.0.join("\n"), &["`l_sole`, like those of one foot"]);
}
