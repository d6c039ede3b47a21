//! Recordings with a wrench of each foot, both loaded: a row is of both feet, and how the soles
//! lie is data on the joints.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{self, Diagnosis, Verdict};
use sesc_identify::fit::Identification;
use sesc_identify::logs::{LogSource, Sidecar};
use sesc_reference::World;
use sesc_test_support::command::{Folder, says, stderr, stdout};
use sesc_test_support::contacts::{recording, soles};
use sesc_test_support::feet::Noise;
use sesc_test_support::stage::{Platform, Stage};

use crate::asked::{self, fit_request, lists, request};

/// Encoders to a third of a tick, soles and floor flat to 0.08°.
const NOISE: Noise = Noise {
    cop_m: 5e-4,
    encoder_rad: 5e-4,
    flat_rad: 1.4e-3,
};
const POSTURES: usize = 40;
/// What is hidden, rad.
const OFFSET: f64 = 0.026;

fn bytes(stage: &Stage, world: &World, noise: Noise, seed: u64) -> Vec<u8> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    recording(stage, world, POSTURES, noise, &soles(), &mut random)
}

fn log(stage: &Stage, world: &World, noise: Noise, seed: u64) -> LogSource {
    LogSource::bytes("both.mcap", bytes(stage, world, noise, seed))
}

fn diagnosed(stage: &Stage, world: &World, noise: Noise, seed: u64) -> Diagnosis {
    asked::diagnosed(&request(stage, log(stage, world, noise, seed)))
}

fn fitted(stage: &Stage, world: &World, seed: u64) -> Identification {
    asked::fitted(&fit_request(stage, log(stage, world, NOISE, seed)))
}

#[test]
fn two_loaded_contacts_are_read_as_both_feet() {
    let stage = Stage::new(Platform::Op2);
    for seed in 0..3 {
        let found = diagnosed(&stage, &stage.world(), NOISE, seed);
        assert!(matches!(found.verdict, Verdict::None | Verdict::Absorbed));
        assert_eq!(found.postures, POSTURES);
        let closure = found.closure.unwrap();
        assert!(closure.closes, "{closure:?}");
        assert_eq!(closure.other_foot, "l_sole");
        // CAD's gap is noise alone: the other contact is where the robot has it.
        let gap = found.baseline.rmse;
        assert!(gap < 3.0 * NOISE.cop_m, "{gap}");
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
            lists(&found, &[&format!("joint_offset:{joint}")]);
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
    says(found.warnings.join("\n"), &["l_knee"]);
    let found = fitted(&stage, &stage.world(), 21);
    assert!(found.closure.unwrap().closes);
}

/// The sidecar's `topic`, or `both_feet = false`, asks for one foot alone.
#[test]
fn one_foot_alone_is_read_where_it_is_asked_for() {
    let stage = Stage::new(Platform::Op2);
    let log = |sidecar| log(&stage, &stage.world(), NOISE, 30).with_sidecar(sidecar);
    let one = log(Sidecar {
        topic: Some("/r_sole/wrench".into()),
        ..Sidecar::default()
    });
    assert_eq!(asked::diagnosed(&request(&stage, one)).closure, None);
    let none = log(Sidecar {
        both_feet: Some(false),
        ..Sidecar::default()
    });
    let refused = diagnose::diagnose(&request(&stage, none), &mut ()).unwrap_err();
    says(refused.to_string(), &["choose one by `topic"]);
}

#[test]
fn commands_say_that_both_contacts_are_read() {
    let folder = Folder::with("op2");
    let stage = Stage::new(Platform::Op2);
    let world = stage.world().joint_offset("l_knee", OFFSET).unwrap();
    folder.write("both.mcap", bytes(&stage, &world, NOISE, 40));
    let run = folder.run("diagnose op2.urdf --data both.mcap --support r_sole");
    says(
        stderr(&run),
        &["both contacts are loaded, `/r_sole/wrench` and"],
    );
    says(
        stdout(&run),
        &["soles            l_sole off that of r_sole by"],
    );
}
