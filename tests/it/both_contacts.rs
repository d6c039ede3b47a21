//! Recordings with a wrench of each foot, both loaded: a row is of both feet, and how the soles
//! lie is data on the joints.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{self, Diagnosis, Verdict};
use sesc_identify::fit::{self, Identification};
use sesc_identify::logs::{LogSource, Sidecar};
use sesc_reference::World;
use sesc_test_support::command::{folder, op2, sesc, stdout};
use sesc_test_support::contacts::{Contact, recording};
use sesc_test_support::feet::Noise;
use sesc_test_support::stage::{Platform, Stage};

use crate::asked::{fit_request, request};

/// Encoders to a third of a tick, soles and floor flat to 0.08°.
const NOISE: Noise = Noise {
    cop_m: 5e-4,
    encoder_rad: 5e-4,
    flat_rad: 1.4e-3,
};
const POSTURES: usize = 40;
/// What is hidden, rad.
const OFFSET: f64 = 0.026;

fn contacts() -> [Contact; 2] {
    ["r_sole", "l_sole"].map(|link| Contact {
        topic: format!("/{link}/wrench"),
        frame: link.to_string(),
    })
}

fn bytes(stage: &Stage, world: &World, noise: Noise, seed: u64) -> Vec<u8> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    recording(stage, world, POSTURES, noise, &contacts(), &mut random)
}

fn diagnosed(stage: &Stage, world: &World, noise: Noise, seed: u64) -> Diagnosis {
    let log = LogSource::bytes("both.mcap", bytes(stage, world, noise, seed));
    let found = diagnose::diagnose(&request(stage, log), &mut ());
    found.unwrap().diagnosis
}

fn fitted(stage: &Stage, world: &World, seed: u64) -> Identification {
    let log = LogSource::bytes("both.mcap", bytes(stage, world, NOISE, seed));
    fit::fit(&fit_request(stage, log), &mut ())
        .unwrap()
        .identification
}

#[test]
fn two_loaded_contacts_are_read_as_both_feet() {
    let stage = Stage::new(Platform::Op2);
    for seed in 0..3 {
        let found = diagnosed(&stage, &stage.world(), NOISE, seed);
        println!("{}", found.sentence);
        let quiet = matches!(found.verdict, Verdict::None | Verdict::Absorbed);
        assert!(quiet, "{}", found.sentence);
        assert_eq!(found.postures, POSTURES);
        let closure = found.closure.unwrap();
        assert!(
            closure.closes && closure.other_foot == "l_sole",
            "{closure:?}"
        );
        // CAD's gap is noise alone: the other contact is where the robot has it.
        assert!(
            found.baseline.rmse < 3.0 * NOISE.cop_m,
            "{:?}",
            found.baseline
        );
    }
}

/// The other sole is where joints have it, and encoders that are off have it elsewhere: by 2 mm
/// for 1.5° of a knee. The offset is named all the same.
#[test]
fn an_offset_that_opens_the_soles_is_named() {
    let stage = Stage::new(Platform::Op2);
    let coarse = Noise {
        cop_m: 5e-3,
        ..NOISE
    };
    for noise in [NOISE, coarse] {
        for (seed, joint) in ["l_knee", "r_knee", "l_ank_roll"].into_iter().enumerate() {
            let world = stage.world().joint_offset(joint, OFFSET).unwrap();
            let found = diagnosed(&stage, &world, noise, 10 + seed as u64);
            println!("{joint} {}: {}", noise.cop_m, found.sentence);
            let truth = [format!("joint_offset:{joint}")];
            assert!(
                found.indistinguishable.iter().any(|all| all == &truth),
                "{joint} {}: {:?}",
                noise.cop_m,
                found.indistinguishable
            );
            let closure = found.closure.unwrap();
            assert!(closure.closes && closure.before.pitch_rad.max(closure.before.roll_rad) > 0.01);
        }
    }
}

#[test]
fn a_fit_warns_of_soles_that_two_contacts_show_open() {
    let stage = Stage::new(Platform::Op2);
    let world = stage.world().joint_offset("l_knee", OFFSET).unwrap();
    let found = fitted(&stage, &world, 20);
    let closure = found.closure.unwrap();
    assert!(!closure.closes, "{closure:?}");
    assert!(closure.explained_by.iter().any(|o| o.joint == "l_knee"));
    assert!(
        found
            .warnings
            .iter()
            .any(|warning| warning.contains("l_knee"))
    );
    let found = fitted(&stage, &stage.world(), 21);
    assert!(found.closure.unwrap().closes);
}

/// The sidecar's `topic`, or `both_feet = false`, asks for one foot alone.
#[test]
fn one_foot_alone_is_read_where_it_is_asked_for() {
    let stage = Stage::new(Platform::Op2);
    let log = |sidecar: Sidecar| {
        let bytes = bytes(&stage, &stage.world(), NOISE, 30);
        LogSource::bytes("both.mcap", bytes).with_sidecar(sidecar)
    };
    let one = log(Sidecar {
        topic: Some("/r_sole/wrench".into()),
        ..Sidecar::default()
    });
    let found = diagnose::diagnose(&request(&stage, one), &mut ()).unwrap();
    assert_eq!(found.diagnosis.closure, None);
    let none = log(Sidecar {
        both_feet: Some(false),
        ..Sidecar::default()
    });
    let refused = diagnose::diagnose(&request(&stage, none), &mut ()).unwrap_err();
    assert!(
        refused.to_string().contains("choose one by `topic"),
        "{refused}"
    );
}

#[test]
fn commands_say_that_both_contacts_are_read() {
    let folder = folder();
    let log = folder.path().join("both.mcap");
    let stage = Stage::new(Platform::Op2);
    let world = stage.world().joint_offset("l_knee", OFFSET).unwrap();
    std::fs::write(&log, bytes(&stage, &world, NOISE, 40)).unwrap();
    let (urdf, log) = (op2(), log.display().to_string());
    let run = sesc(&["diagnose", &urdf, "--data", &log, "--support", "r_sole"]);
    let said = String::from_utf8_lossy(&run.stderr).into_owned();
    assert!(
        said.contains("both contacts are loaded, `/r_sole/wrench` and"),
        "{said}"
    );
    assert!(stdout(&run).contains("soles            l_sole off that of r_sole by"));
}
