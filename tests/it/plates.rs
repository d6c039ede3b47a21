//! Force plates: a total force that weighs the robot, and wrenches of several sensors.
//!
//! ```text
//! F = (M + m) (g + c̈_z)        masses by the URDF, c̈_z by differences of the reference's CoM
//! ```

use std::f64::consts::TAU;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Normal};
use sesc_identify::diagnose::{Diagnosis, Verdict, diagnose};
use sesc_identify::fit::{Identification, fit};
use sesc_identify::health::Kind;
use sesc_identify::logs::{LogSource, Weight};
use sesc_reference::World;
use sesc_test_support::contacts::{Contact, recording};
use sesc_test_support::feet;
use sesc_test_support::stage::{Platform, Stage};

use crate::asked::{fit_request, request, table};

/// Standard gravity, m/s².
const GRAVITY: f64 = 9.80665;
/// Noise of the CoP, m.
const NOISE_M: f64 = 1e-3;
/// What the box weighs, kg.
const BOX_KG: f64 = 0.6;
/// Where it is on the torso, m.
const BOX_AT: [f64; 3] = [0.03, 0.01, 0.05];
/// Scatter of a total force as a part of it, row by row.
const SCATTER: f64 = 0.002;

/// Columns of a log, by name.
type Columns = Vec<(String, Vec<f64>)>;

fn seeded(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// Mass of the URDF, kg.
fn mass_of(stage: &Stage) -> f64 {
    stage.robot.links().iter().map(|link| link.mass_kg).sum()
}

fn with_box(stage: &Stage) -> World {
    let world = stage.world();
    world.payload("body_link", BOX_KG, BOX_AT).unwrap()
}

/// A log of postures `q` of `world` at rest.
fn at_rest(stage: &Stage, world: &World, q: &[Vec<f64>], random: &mut ChaCha8Rng) -> Columns {
    let noise = Normal::new(0.0, NOISE_M).unwrap();
    let cop = q
        .iter()
        .map(|q| world.cop(q).map(|x| x + noise.sample(random)));
    columns(stage, q, &cop.collect::<Vec<_>>())
}

fn columns(stage: &Stage, q: &[Vec<f64>], cop: &[[f64; 2]]) -> Columns {
    let names = stage.joint_names().into_iter().enumerate();
    let mut columns: Columns = names
        .map(|(k, name)| (name, q.iter().map(|q| q[k]).collect()))
        .collect();
    columns.push(("cop_x".into(), cop.iter().map(|p| p[0]).collect()));
    columns.push(("cop_y".into(), cop.iter().map(|p| p[1]).collect()));
    columns
}

fn rows(columns: &Columns) -> usize {
    columns[0].1.len()
}

/// The same log with a total force, N, of so many kg in each row, and its scatter.
fn with_force(log: &Columns, kg: impl Fn(usize) -> f64, random: &mut ChaCha8Rng) -> Columns {
    let scatter = Normal::new(1.0, SCATTER).unwrap();
    let force = (0..rows(log)).map(|k| GRAVITY * kg(k) * scatter.sample(random));
    let mut log = log.clone();
    log.push(("fz".into(), force.collect()));
    log
}

fn diagnosed(stage: &Stage, log: &Columns) -> Diagnosis {
    let mut request = request(stage, table(log.clone()));
    request.noise = Some(NOISE_M);
    diagnose(&request, &mut ()).unwrap().diagnosis
}

fn fitted(stage: &Stage, log: &Columns) -> Identification {
    let mut request = fit_request(stage, table(log.clone()));
    request.noise = Some(NOISE_M);
    fit(&request, &mut ()).unwrap().identification
}

/// Mass of a payload that a diagnosis names, with its deviation, kg.
fn payload(found: &Diagnosis) -> (f64, f64) {
    let mut steps = found.steps.iter();
    let step = steps.find(|step| step.effect == "payload");
    let mass = step.expect("a payload").parameters["mass_kg"];
    (mass.value, mass.std)
}

fn holds(weight: Option<Weight>, kg: f64) {
    let mass = weight.expect("a total force").mass_kg;
    let off = (mass.value - kg).abs();
    assert!(
        off < 3.0 * mass.std && mass.std < 0.01 * kg,
        "{mass:?} of {kg}"
    );
}

/// The force knows what the CoP only hints at: without it the box weighs by four of its deviations
/// more, and a shoulder may carry it.
#[test]
fn a_box_is_weighed_to_within_its_deviation() {
    let stage = Stage::new(Platform::Op2);
    let (world, kg) = (with_box(&stage), mass_of(&stage) + BOX_KG);
    for seed in 0..3 {
        let mut random = seeded(seed);
        let q = stage.balanced(60, &mut random);
        let log = at_rest(&stage, &world, &q, &mut random);
        let found = diagnosed(&stage, &with_force(&log, |_| kg, &mut random));
        println!("{}", found.sentence);
        holds(found.weight, kg);
        assert_eq!(found.indistinguishable, [["payload:body_link"]]);
        let (mass, std) = payload(&found);
        assert!(
            (mass - BOX_KG).abs() < 3.0 * std && std < 0.03,
            "{mass} ± {std}"
        );
        assert!(
            found
                .sentence
                .contains("kg more than the 2.925 kg of its URDF")
        );
        assert!(found.health.is_empty(), "{:?}", found.health);
        let without = payload(&diagnosed(&stage, &log)).1;
        assert!(without > 3.0 * std, "{without} {std}");
    }
}

/// A torso whose CoM is elsewhere looks like a box; a robot that weighs what it should carries none.
#[test]
fn a_force_of_the_weight_refutes_a_payload() {
    let stage = Stage::new(Platform::Op2);
    let world = stage.world();
    let world = world
        .link_mass("body_link", 1.0, [0.01, 0.0, 0.03])
        .unwrap();
    let kg = mass_of(&stage);
    let mut random = seeded(7);
    let q = stage.balanced(60, &mut random);
    let log = at_rest(&stage, &world, &q, &mut random);
    let carries = |found: &Diagnosis| {
        let mut steps = found.steps.iter().filter(|step| step.effect == "payload");
        steps.any(|step| step.parameters["mass_kg"].value.abs() > 0.1)
    };
    let found = diagnosed(&stage, &log);
    println!("{:?} {}", found.indistinguishable, found.sentence);
    let weighed = diagnosed(&stage, &with_force(&log, |_| kg, &mut random));
    println!("{:?} {}", weighed.indistinguishable, weighed.sentence);
    assert!(carries(&found) && !carries(&weighed));
    holds(weighed.weight, kg);
    assert!(
        !weighed.sentence.contains("The total force"),
        "{}",
        weighed.sentence
    );
}

/// Without effects the force changes nothing and is not spoken of.
#[test]
fn a_sound_log_stays_sound() {
    let stage = Stage::new(Platform::Op2);
    let kg = mass_of(&stage);
    for seed in 0..3 {
        let mut random = seeded(20 + seed);
        let q = stage.balanced(50, &mut random);
        let log = at_rest(&stage, &stage.world(), &q, &mut random);
        let log = with_force(&log, |_| kg, &mut random);
        let found = diagnosed(&stage, &log);
        assert_eq!(found.verdict, Verdict::None, "{}", found.sentence);
        assert!(found.health.is_empty() && !found.sentence.contains("force"));
        holds(found.weight, kg);
        let found = fitted(&stage, &log);
        assert!(found.health.is_empty() && found.warnings.is_empty());
        holds(found.weight, kg);
    }
}

/// Squats a second.
const SQUATS_HZ: f64 = 1.2;

/// A log in time of a robot that bends its knees, with its total force.
fn squats(stage: &Stage, seconds: f64, random: &mut ChaCha8Rng) -> Columns {
    let (world, kg, rate) = (stage.world(), mass_of(stage), 50.0);
    let still = stage.balanced(1, random).concat();
    let names = stage.joint_names();
    let at = move |t: f64| -> Vec<f64> {
        let bend = 0.35 * (1.0 - (SQUATS_HZ * TAU * t).cos());
        let by = |name: &String| match &name[2..] {
            "knee" => 2.0 * bend,
            "hip_pitch" | "ank_pitch" => bend,
            _ => 0.0,
        };
        // Legs of the OP2 have opposite axes.
        let sign = |name: &String| match (name.starts_with("r_"), name.ends_with("hip_pitch")) {
            (true, true) | (false, false) => -1.0,
            _ => 1.0,
        };
        let own = names.iter().zip(&still);
        own.map(|(name, q)| q + sign(name) * by(name)).collect()
    };
    let t: Vec<f64> = (0..(seconds * rate) as usize)
        .map(|k| k as f64 / rate)
        .collect();
    let q: Vec<Vec<f64>> = t.iter().map(|t| at(*t)).collect();
    let height = |t: f64| world.com(&at(t)).z;
    let step = 1e-3;
    let gain = |t: f64| (height(t + step) - 2.0 * height(t) + height(t - step)) / (step * step);
    let noise = Normal::new(0.0, NOISE_M).unwrap();
    let readings = world
        .clone()
        .unsettled()
        .readings(&sesc_reference::Track::moving(t.clone(), at.clone()));
    let cop = readings
        .iter()
        .map(|own| own.cop.map(|x| x + noise.sample(random)));
    let mut log = columns(stage, &q, &cop.collect::<Vec<_>>());
    log.push((
        "fz".into(),
        t.iter().map(|t| kg * (GRAVITY + gain(*t))).collect(),
    ));
    log.push(("t".into(), t));
    log
}

/// c̈_z by CAD is taken from the force: over two squats and a quarter the robot weighs less by what
/// it is falling with at the end, and is weighed as one that stands.
#[test]
fn a_robot_that_moves_is_weighed_without_its_acceleration() {
    let stage = Stage::new(Platform::Op2);
    let (kg, mut random) = (mass_of(&stage), seeded(30));
    let log = squats(&stage, 2.25 / SQUATS_HZ, &mut random);
    let force = &log.iter().find(|(name, _)| name == "fz").unwrap().1;
    let part = |force: f64| force / (kg * GRAVITY);
    let least = force.iter().copied().fold(f64::INFINITY, f64::min);
    let mean = force.iter().sum::<f64>() / force.len() as f64;
    assert!(part(least) < 0.92 && part(mean) < 0.995, "{least} {mean}");
    let found = fitted(&stage, &log);
    println!("{} {} {:?}", part(least), part(mean), found.weight);
    let weight = found.weight.unwrap();
    assert!((weight.mass_kg.value / kg - 1.0).abs() < 1e-3, "{weight:?}");
    assert!(found.health.is_empty(), "{:?}", found.health);
}

/// A part of a log, by rows.
fn some(log: &Columns, from: usize) -> Columns {
    let own = log
        .iter()
        .map(|(name, all)| (name.clone(), all[from..].to_vec()));
    own.collect()
}

#[test]
fn rows_before_a_plate_starts_are_left_out_and_said() {
    let stage = Stage::new(Platform::Op2);
    let mut random = seeded(40);
    let mut log = squats(&stage, 8.0, &mut random);
    for (name, values) in &mut log {
        if ["cop_x", "cop_y", "fz"].contains(&name.as_str()) {
            values[..2].fill(0.0);
        }
    }
    let found = fitted(&stage, &log);
    let [lost] = &found.health[..] else {
        panic!("{:?}", found.health)
    };
    assert_eq!(lost.kind, Kind::ContactLost);
    assert!(lost.sentence.starts_with("In 2 rows"), "{}", lost.sentence);
    let without = fitted(&stage, &some(&log, 2));
    for (own, other) in found.parameters.iter().zip(&without.parameters) {
        assert!((own.value - other.value).abs() < 1e-9, "{own:?} {other:?}");
    }
}

/// In the last second a hand takes a fifth of the weight; then nothing stands on the plate.
#[test]
fn a_fall_is_left_out_and_said() {
    let stage = Stage::new(Platform::Op2);
    let mut random = seeded(50);
    let mut log = squats(&stage, 8.0, &mut random);
    let n = rows(&log);
    for (name, values) in &mut log {
        match name.as_str() {
            "fz" => values[n - 50..].iter_mut().for_each(|force| *force *= 0.8),
            "cop_x" => values[n - 50..].iter_mut().for_each(|x| *x += 0.03),
            _ => continue,
        }
        if name == "fz" {
            values[n - 5..].fill(0.3);
        }
    }
    let found = fitted(&stage, &log);
    let said: Vec<&str> = found
        .health
        .iter()
        .map(|own| own.sentence.as_str())
        .collect();
    println!("{said:?}");
    assert!(
        found.health.iter().all(|own| own.kind == Kind::ContactLost),
        "{said:?}"
    );
    assert!(
        said.iter().any(|said| said.starts_with("In 5 rows")),
        "{said:?}"
    );
    let held = said
        .iter()
        .find(|said| said.contains("less than the weight"));
    assert!(held.is_some_and(|said| said.contains("to 395")), "{said:?}");
    // Under a triangle of ± 25 rows, 0.4 of which bears 0.8: 2.6 rows before the hand. Rows at both
    // ends do not know their motion.
    let kept = n as u64 - 53;
    let few = kept - 15..=kept + 1;
    assert!(few.contains(&found.readings), "{} {kept}", found.readings);
}

/// A box in the middle of a log is no contact that is lost, and asks for the log to be split.
#[test]
fn a_load_that_is_put_on_and_off_is_said_with_its_rows() {
    let stage = Stage::new(Platform::Op2);
    let kg = mass_of(&stage);
    for seed in 60..63 {
        let mut random = seeded(seed);
        let q = stage.balanced(60, &mut random);
        let of = |world: World, random: &mut ChaCha8Rng| at_rest(&stage, &world, &q, random);
        let mut log = of(stage.world(), &mut random);
        let loaded = of(with_box(&stage), &mut random);
        for ((_, values), (_, loaded)) in log.iter_mut().zip(&loaded) {
            values[20..45].copy_from_slice(&loaded[20..45]);
        }
        let carried = |k: usize| kg + if (20..45).contains(&k) { BOX_KG } else { 0.0 };
        let found = diagnosed(&stage, &with_force(&log, carried, &mut random));
        let levels = found
            .health
            .iter()
            .find(|own| own.kind == Kind::ForceUnlikeWeight);
        let said = &levels.expect("two levels").sentence;
        println!("{said}");
        assert!(said.contains("in rows 21 to 45") && said.contains("split it there"));
        assert!(found.health.iter().all(|own| own.kind != Kind::ContactLost));
        assert!(found.weight.unwrap().mass_kg.std > 0.25 * BOX_KG);
    }
}

/// Wrenches of a recording weigh the robot, too.
#[test]
fn wrenches_of_a_recording_weigh_the_robot() {
    let stage = Stage::new(Platform::Op2);
    let noise = feet::Noise {
        cop_m: 5e-4,
        encoder_rad: 5e-4,
        flat_rad: 1.4e-3,
    };
    let contacts = ["r_sole", "l_sole"].map(|link| Contact {
        topic: format!("/{link}/wrench"),
        frame: link.to_string(),
    });
    let bytes = recording(
        &stage,
        &stage.world(),
        20,
        noise,
        &contacts,
        &mut seeded(70),
    );
    let log = LogSource::bytes("both.mcap", bytes);
    let found = fit(&fit_request(&stage, log), &mut ()).unwrap();
    holds(found.identification.weight, mass_of(&stage));
}
