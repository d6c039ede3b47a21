//! Force plates: a total force that weighs the robot, and wrenches of several sensors.
//!
//! ```text
//! F = (M + m) (g + c̈_z)        masses by the URDF, c̈_z by differences of the reference's CoM
//! ```

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Normal};
use sesc_identify::diagnose::{Diagnosis, Verdict, diagnose};
use sesc_identify::fit::Identification;
use sesc_identify::health::{Finding, Kind};
use sesc_identify::logs::{LogSource, Sidecar, Weight};
use sesc_model::Snapping;
use sesc_reference::{Reference, Track, World};
use sesc_test_support::command::{Folder, rows, says};
use sesc_test_support::contacts::{Contact, recording, soles};
use sesc_test_support::feet;
use sesc_test_support::recording::{Recording, normal};
use sesc_test_support::stage::{Platform, Stage};

use crate::asked::{self, fit_request, lists, request, table};

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
    Recording::still(stage, world, q.to_vec(), NOISE_M, random).columns(false)
}

/// Joints of a log, behind its readings.
fn columns(stage: &Stage, q: &[Vec<f64>], cop: Vec<[f64; 2]>) -> Columns {
    let recording = Recording {
        joints: stage.joint_names(),
        q: q.to_vec(),
        cop,
        ..Recording::default()
    };
    recording.columns(false)
}

fn joints(stage: &Stage, q: &[Vec<f64>]) -> Columns {
    columns(stage, q, vec![[0.0; 2]; q.len()]).split_off(2)
}

/// The same log with a total force, N, of so many kg in each row, and its scatter.
fn with_force(log: &Columns, kg: impl Fn(usize) -> f64, random: &mut ChaCha8Rng) -> Columns {
    let scatter = Normal::new(1.0, SCATTER).unwrap();
    let force = (0..log[0].1.len()).map(|k| GRAVITY * kg(k) * scatter.sample(random));
    let mut log = log.clone();
    log.push(("fz".into(), force.collect()));
    log
}

fn diagnosed(stage: &Stage, log: &Columns) -> Diagnosis {
    let mut request = request(stage, table(log.clone()));
    request.noise = Some(NOISE_M);
    asked::diagnosed(&request)
}

fn fitted(stage: &Stage, log: &Columns) -> Identification {
    let mut request = fit_request(stage, table(log.clone()));
    request.noise = Some(NOISE_M);
    asked::fitted(&request)
}

/// What is said of the data.
fn sentences(health: &[Finding]) -> Vec<&str> {
    health.iter().map(|own| own.sentence.as_str()).collect()
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
    let is_near = (mass.value - kg).abs() < 3.0 * mass.std;
    assert!(is_near && mass.std < 0.01 * kg, "{mass:?} of {kg}");
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
        holds(found.weight, kg);
        assert_eq!(found.indistinguishable, [["payload:body_link"]]);
        let (mass, std) = payload(&found);
        let is_near = (mass - BOX_KG).abs() < 3.0 * std;
        assert!(is_near && std < 0.03, "{mass} ± {std}");
        says(&found.sentence, &["kg more than the 2.925 kg of its URDF"]);
        assert!(found.health.is_empty(), "{:?}", found.health);
        let without = payload(&diagnosed(&stage, &log)).1;
        assert!(without > 3.0 * std, "{without} {std}");
    }
}

/// A torso whose CoM is elsewhere looks like a box; a robot that weighs what it should carries none.
#[test]
fn a_force_of_the_weight_refutes_a_payload() {
    let stage = Stage::new(Platform::Op2);
    let moved = stage.world().link_mass("body_link", 1.0, [0.01, 0.0, 0.03]);
    let world = moved.unwrap();
    let kg = mass_of(&stage);
    let mut random = seeded(7);
    let q = stage.balanced(60, &mut random);
    let log = at_rest(&stage, &world, &q, &mut random);
    let carries = |found: &Diagnosis| {
        let mut steps = found.steps.iter().filter(|step| step.effect == "payload");
        steps.any(|step| step.parameters["mass_kg"].value.abs() > 0.1)
    };
    let found = diagnosed(&stage, &log);
    let weighed = diagnosed(&stage, &with_force(&log, |_| kg, &mut random));
    assert!(carries(&found) && !carries(&weighed));
    holds(weighed.weight, kg);
    assert!(!weighed.sentence.contains("The total force"));
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
    let count = 0..(seconds * rate) as usize;
    let t: Vec<f64> = count.map(|k| k as f64 / rate).collect();
    let q: Vec<Vec<f64>> = t.iter().map(|t| at(*t)).collect();
    let height = |t: f64| world.com(&at(t)).z;
    let step = 1e-3;
    let gain = |t: f64| (height(t + step) - 2.0 * height(t) + height(t - step)) / (step * step);
    let moving = world.clone().unsettled();
    let readings = moving.readings(&Track::moving(t.clone(), at.clone()));
    let readings = readings.iter();
    let cop = readings.map(|own| own.cop.map(|x| x + NOISE_M * normal(random)));
    let mut log = columns(stage, &q, cop.collect());
    let force = t.iter().map(|t| kg * (GRAVITY + gain(*t)));
    log.push(("fz".into(), force.collect()));
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
    let weight = found.weight.unwrap();
    assert!((weight.mass_kg.value / kg - 1.0).abs() < 1e-3, "{weight:?}");
    assert!(found.health.is_empty(), "{:?}", found.health);
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
    log.iter_mut().for_each(|(_, all)| drop(all.drain(..2)));
    let without = fitted(&stage, &log);
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
    let n = log[0].1.len();
    for (name, values) in &mut log {
        let last = values[n - 50..].iter_mut();
        match name.as_str() {
            "fz" => last.for_each(|force| *force *= 0.8),
            "cop_x" => last.for_each(|x| *x += 0.03),
            _ => {}
        }
        if name == "fz" {
            values[n - 5..].fill(0.3);
        }
    }
    let found = fitted(&stage, &log);
    let said = sentences(&found.health);
    let mut health = found.health.iter();
    assert!(health.all(|own| own.kind == Kind::ContactLost), "{said:?}");
    let starts = |said: &&str| said.starts_with("In 5 rows");
    assert!(said.iter().any(starts), "{said:?}");
    let mut held = said
        .iter()
        .filter(|said| said.contains("less than the weight"));
    assert!(held.any(|said| said.contains("to 395")), "{said:?}");
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
        let mut health = found.health.iter();
        let levels = health.find(|own| own.kind == Kind::ForceUnlikeWeight);
        let said = &levels.expect("two levels").sentence;
        says(said, &["in rows 21 to 45", "split it there"]);
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
    let (world, random) = (stage.world(), &mut seeded(70));
    let bytes = recording(&stage, &world, 20, noise, &soles(), random);
    let log = LogSource::bytes("both.mcap", bytes);
    let found = asked::fitted(&fit_request(&stage, log));
    holds(found.weight, mass_of(&stage));
}

/// A robot on both feet, whose feet also push against each other along the floor.
struct BothFeet {
    stage: Stage,
    reference: Reference,
    /// The true joints, posture by posture, and the encoders'.
    joints: Vec<Vec<f64>>,
    q: Vec<Vec<f64>>,
    /// Force on each foot and where it acts on the floor, right then left, in the support frame.
    contacts: Vec<[(Vector3<f64>, Vector3<f64>); 2]>,
}

/// Scatter of where a force acts on each foot, m.
const ON_SOLE_M: f64 = 0.01;

impl BothFeet {
    /// Postures of the OP2, changed by `change`; where feet are loaded is off by `noise`, m.
    fn new(
        change: impl Fn(World) -> World,
        kg: f64,
        noise: f64,
        random: &mut ChaCha8Rng,
    ) -> BothFeet {
        let stage = Stage::new(Platform::Op2);
        let (feet, world) = (feet::TwoFeet::new(&stage), change(stage.world()));
        let reference = Reference::new(&stage.robot, stage.support).unwrap();
        let [spot, error] = [ON_SOLE_M, noise].map(|std| Normal::new(0.0, std).unwrap());
        let joints: Vec<Vec<f64>> = (0..40).map(|_| feet.draw([0.0; 2], random)).collect();
        let q: Vec<_> = joints
            .iter()
            .map(|own| feet::TwoFeet::encoders(&world, own))
            .collect();
        let contacts = joints.iter().zip(&q).map(|(joints, q)| {
            let cop = world.cop(q).map(|x| x + error.sample(random));
            let place = feet.place(joints);
            let square = place[0].powi(2) + place[1].powi(2);
            let share = ((cop[0] * place[0] + cop[1] * place[1]) / square).clamp(0.1, 0.9);
            let left = feet.seen(joints, [spot.sample(random), spot.sample(random)]);
            let right = [0, 1].map(|k| (cop[k] - share * left[k]) / (1.0 - share));
            let push = [spot, spot].map(|spot| 300.0 * spot.sample(random));
            let force = |sign: f64, share: f64| {
                Vector3::new(sign * push[0], sign * push[1], share * kg * GRAVITY)
            };
            let at = |[x, y]: [f64; 2]| Vector3::new(x, y, 0.0);
            [
                (force(1.0, 1.0 - share), at(right)),
                (force(-1.0, share), at(left)),
            ]
        });
        BothFeet {
            contacts: contacts.collect(),
            stage,
            reference,
            joints,
            q,
        }
    }

    /// Six columns of a sensor that feels foot `foot` in the frame of a link: f = Rᵀ F,
    /// τ = Rᵀ ((p − o) × F).
    fn wrench(&self, name: &str, foot: usize, frame: impl Fn(&[f64]) -> Isometry3<f64>) -> Columns {
        let rows = self.joints.iter().zip(&self.contacts);
        let rows = rows.map(|(joints, contacts)| {
            let (frame, (force, at)) = (frame(joints), contacts[foot]);
            let turned = frame.rotation.inverse();
            let moment = turned * (at - frame.translation.vector).cross(&force);
            let force = turned * force;
            [force.x, force.y, force.z, moment.x, moment.y, moment.z]
        });
        let rows: Vec<[f64; 6]> = rows.collect();
        let ends = ["fx", "fy", "fz", "mx", "my", "mz"].into_iter().enumerate();
        let column = |k: usize| rows.iter().map(|own| own[k]).collect();
        ends.map(|(k, end)| (format!("{name}_{end}"), column(k)))
            .collect()
    }

    /// The same in the frame of a link.
    fn at_link(&self, name: &str, foot: usize, link: &str) -> Columns {
        let link = self.stage.robot.link_index(link).unwrap();
        self.wrench(name, foot, |joints| {
            let pose = self.reference.link_poses(joints)[link];
            let turned = UnitQuaternion::from_rotation_matrix(&pose.rotation);
            Isometry3::from_parts(pose.translation, turned)
        })
    }

    fn joints(&self) -> Columns {
        joints(&self.stage, &self.q)
    }

    /// The log with a sensor in each sole.
    fn of_soles(&self) -> Columns {
        self.at_links(["r_sole", "l_sole"])
    }

    /// The log with a sensor in the frame of each of two links.
    fn at_links(&self, links: [&str; 2]) -> Columns {
        let right = self.at_link("r", 0, links[0]);
        [self.joints(), right, self.at_link("l", 1, links[1])].concat()
    }

    /// The log with the CoP of both feet and the total force, by the statics of both contacts.
    fn of_cop(&self) -> Columns {
        let sums = self.contacts.iter().map(|[(f, p), (g, q)]| {
            let total = f.z + g.z;
            ([0, 1].map(|k| (f.z * p[k] + g.z * q[k]) / total), total)
        });
        let (cop, force): (Vec<_>, Vec<_>) = sums.unzip();
        let mut log = columns(&self.stage, &self.q, cop);
        log.push(("fz".into(), force));
        log
    }
}

/// A sidecar with these lines.
fn sidecar(text: &str) -> Sidecar {
    toml::from_str(text).unwrap()
}

const OF_SOLES: &str = "[sensors.l]\nframe = 'l_sole'\n[sensors.r]\nframe = 'r_sole'\n";

/// A diagnosis of columns with a sidecar, and what is warned of.
fn read(stage: &Stage, log: &Columns, text: &str) -> Result<Diagnosis, String> {
    let log = LogSource::from(table(log.clone())).with_sidecar(sidecar(text));
    let mut request = request(stage, log);
    request.noise = Some(NOISE_M);
    // The reference takes right angles as they are written.
    request.snapping = Snapping::Off;
    let found = diagnose(&request, &mut ()).map_err(|error| error.to_string());
    found.map(|found| found.diagnosis)
}

/// Without noise CAD's CoP is that of the wrenches to rounding, wherever sensors are: in soles, in
/// ankles above them, on the floor.
#[test]
fn wrenches_give_the_cop_of_both_feet_to_rounding() {
    let mut random = seeded(80);
    let kg = mass_of(&Stage::new(Platform::Op2));
    let robot = BothFeet::new(|world| world, kg, 0.0, &mut random);
    let stage = &robot.stage;
    let exact = |found: Diagnosis| {
        assert!(found.baseline.rmse < 1e-12, "{:?}", found.baseline);
        let mut health = found.health.iter();
        assert!(health.all(|own| own.kind == Kind::NoiseOverstated));
        let mass = found.weight.unwrap().mass_kg.value;
        assert!((mass / kg - 1.0).abs() < 1e-12, "{mass}");
        found
    };
    let of_soles = exact(read(stage, &robot.of_soles(), OF_SOLES).unwrap());
    let closure = of_soles.closure.expect("both feet stand");
    assert!(closure.closes && closure.other_foot == "l_sole");
    let links = ["r_ank_roll_link", "l_ank_roll_link"];
    let ankles = format!(
        "other_foot = 'l_sole'\n[sensors.l]\nframe = '{}'\n[sensors.r]\nframe = '{}'\n",
        links[1], links[0]
    );
    exact(read(stage, &robot.at_links(links), &ankles).unwrap());
    // Plates below the floor: one turned, one with its z axis down.
    let (one, other) = (
        [0.1, -0.2, -0.03, 0.0, 0.0, 0.7],
        [-0.2, 0.3, -0.05, PI, 0.1, -0.4],
    );
    let posed = |[x, y, z, roll, pitch, yaw]: [f64; 6]| {
        let turned = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        Isometry3::from_parts(Translation3::new(x, y, z), turned)
    };
    let a = robot.wrench("a", 0, |_| posed(one));
    let b = robot.wrench("b", 1, |_| posed(other));
    let plates =
        format!("both_feet = true\n[sensors.a]\npose = {one:?}\n[sensors.b]\npose = {other:?}\n");
    let found = exact(read(stage, &[robot.joints(), a, b].concat(), &plates).unwrap());
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
}

/// The same log as CoP and as wrenches: the same result.
#[test]
fn wrenches_are_explained_as_the_cop_is() {
    let stage = Stage::new(Platform::Op2);
    let mut random = seeded(81);
    let kg = mass_of(&stage) + BOX_KG;
    let change = |world: World| world.payload("body_link", BOX_KG, BOX_AT).unwrap();
    let robot = BothFeet::new(change, kg, NOISE_M, &mut random);
    let one = read(&stage, &robot.of_soles(), OF_SOLES).unwrap();
    let other = read(&stage, &robot.of_cop(), "other_foot = 'l_sole'").unwrap();
    assert_eq!(one.indistinguishable, other.indistinguishable);
    assert!(one.indistinguishable[0].contains(&"payload:body_link".to_string()));
    for (one, other) in one.steps.iter().zip(&other.steps) {
        for (name, value) in &one.parameters {
            let other = other.parameters[name];
            let off = (value.value - other.value).abs() / value.std;
            assert!(off < 1e-3, "{name}");
            assert!((value.std / other.std - 1.0).abs() < 1e-3, "{name}");
        }
    }
    holds(one.weight, kg);
    let fits = [
        (robot.of_soles(), OF_SOLES),
        (robot.of_cop(), "other_foot = 'l_sole'"),
    ];
    let [one, other] = fits.map(|(log, text)| {
        let log = LogSource::from(table(log)).with_sidecar(sidecar(text));
        asked::fitted(&fit_request(&stage, log))
    });
    for (one, other) in one.parameters.iter().zip(&other.parameters) {
        assert!((one.value - other.value).abs() < 1e-9, "{one:?} {other:?}");
    }
    let [one, other] = [one, other].map(|own| own.weight.unwrap().mass_kg);
    assert!((one.value - other.value).abs() < 1e-9 && (one.std - other.std).abs() < 1e-9);
}

/// The other sole is where the joints have it: an encoder that is off shows in both, as it does in a
/// recording.
#[test]
fn an_offset_of_a_knee_is_named_from_wrenches() {
    let stage = Stage::new(Platform::Op2);
    let mut random = seeded(82);
    let change = |world: World| world.joint_offset("l_knee", 0.026).unwrap();
    let robot = BothFeet::new(change, mass_of(&stage), NOISE_M, &mut random);
    let found = read(&stage, &robot.of_soles(), OF_SOLES).unwrap();
    lists(&found, &["joint_offset:l_knee"]);
}

/// Forces of the robot on the ground are turned with a word; a foot in the air and a missing value
/// cost their rows.
#[test]
fn signs_are_turned_and_rows_without_a_foot_or_a_value_are_left_out() {
    let stage = Stage::new(Platform::Op2);
    let mut random = seeded(83);
    let kg = mass_of(&stage);
    let robot = BothFeet::new(|world| world, kg, NOISE_M, &mut random);
    let right = read(&stage, &robot.of_soles(), OF_SOLES).unwrap();
    let mut log = robot.of_soles();
    for (name, values) in &mut log {
        if name.starts_with("l_f") || name.starts_with("l_m") {
            values.iter_mut().for_each(|x| *x = -*x);
        }
    }
    let turned = read(&stage, &log, OF_SOLES).unwrap();
    assert_eq!(turned.weight, right.weight);
    assert_eq!(turned.baseline, right.baseline);
    let said = turned.warnings.join("\n");
    says(said, &["sensor `l` points down", "its sign is turned"]);
    // Two rows on the right foot alone, and one without a moment.
    for (name, values) in &mut log {
        if name.starts_with("l_f") || name.starts_with("l_m") {
            values[10..12].fill(0.0);
        }
        if name == "r_mx" {
            values[20] = f64::NAN;
        }
    }
    let found = read(&stage, &log, OF_SOLES).unwrap();
    let lost = sentences(&found.health)[0];
    assert!(lost.starts_with("In 2 rows"), "{lost}");
    says(lost, &["one of the sensors"]);
    assert_eq!(found.postures, 37);
    says(found.warnings.join("\n"), &["`r_mx` in 1"]);
}

/// One sensor in the sole of a robot on one foot.
#[test]
fn one_sensor_alone_is_read() {
    let stage = Stage::new(Platform::Op2);
    let mut random = seeded(84);
    let (kg, world) = (mass_of(&stage), stage.world());
    let q = stage.balanced(40, &mut random);
    let mut log = joints(&stage, &q);
    let force = kg * GRAVITY;
    let moments = |axis: usize, sign: f64| {
        let moments = q.iter().map(|q| sign * force * world.cop(q)[axis]);
        moments.collect()
    };
    let zeros = vec![0.0; q.len()];
    for (name, values) in [
        ("s_fx", zeros.clone()),
        ("s_fy", zeros.clone()),
        ("s_fz [kN]", vec![1e-3 * force; q.len()]),
        ("s_mx", moments(1, 1.0)),
        ("s_my", moments(0, -1.0)),
        ("s_mz [N m]", zeros.clone()),
    ] {
        log.push((name.into(), values));
    }
    let found = read(&stage, &log, "[sensors.s]\nframe = 'r_sole'").unwrap();
    assert!(found.baseline.rmse < 1e-12, "{:?}", found.baseline);
    assert!(found.closure.is_none());
    assert!((found.weight.unwrap().mass_kg.value / kg - 1.0).abs() < 1e-12);
}

#[test]
fn what_is_wrong_with_sensors_is_said_with_its_remedy() {
    let stage = Stage::new(Platform::Op2);
    let robot = BothFeet::new(|world| world, 3.0, 0.0, &mut seeded(85));
    let whole = robot.of_soles();
    let without = |name: &str| {
        let is_one = |own: &str| own.starts_with(name) && ["f", "m"].contains(&&own[2..3]);
        let kept = whole.iter().filter(|(own, _)| !is_one(own));
        kept.cloned().collect::<Columns>()
    };
    let mut with_cop = whole.clone();
    with_cop.extend_from_slice(&robot.of_cop()[..2]);
    let mut with_fz = whole.clone();
    with_fz.push(("fz".into(), vec![30.0; 40]));
    let frames =
        |l: &str, r: &str| format!("[sensors.l]\nframe = '{l}'\n[sensors.r]\nframe = '{r}'");
    let one_more = format!("{OF_SOLES}[sensors.x]\nframe = 'body_link'");
    let refusals = rows(
        "no column `l_mz`; sensor `l` needs all | write zeros
        no columns `l_fx` | sensor `l` | remove `[sensors.l]`
        `l_fx`, `l_fy` | are a wrench | `[sensors.l]` with `frame = \"LINK\"`
        sensor `l` is in the frame `l_sola`, which is no link: did you mean `l_sole`? | `pose = [
        sensor `l` is in the frame `world` | `pose = [
        `cop_x` and `cop_y` beside the wrenches of `l`, `r` | remove one
        `fz` beside the wrenches
        no columns `x_fx`
        sensor `r` is in `body_link`, which is fixed neither to `r_sole` nor to | `other_foot",
    );
    let wrong = [
        (&without("l_mz"), OF_SOLES.to_string()),
        (&without("l_"), OF_SOLES.to_string()),
        (&whole, String::new()),
        (&whole, frames("l_sola", "r_sole")),
        (&whole, frames("world", "r_sole")),
        (&with_cop, OF_SOLES.to_string()),
        (&with_fz, OF_SOLES.to_string()),
        (&whole, one_more),
        (&whole, frames("l_sole", "body_link")),
    ];
    assert_eq!(refusals.len(), wrong.len());
    for ((log, text), words) in wrong.into_iter().zip(refusals) {
        let said = read(&stage, log, &text).expect_err(&text);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        says(said, &words);
    }
    // A file names itself, its sidecar and the key.
    let folder = Folder::with("op2");
    folder.write("log.csv", "pose\n0\n");
    for (text, word) in [
        (
            "frame = 'l_sole'\npose = [0, 0, 0, 0, 0, 0]",
            "sensor `l`: give either `frame",
        ),
        ("frmae = 'l_sole'", "frmae"),
        ("", "sensor `l`: give either `frame"),
    ] {
        folder.write("log.csv.toml", format!("[sensors.l]\n{text}\n"));
        let fit = "fit op2.urdf --data log.csv --support r_sole";
        folder.refuses(fit, &["log.csv.toml", word]);
    }
}

/// Topics and frames of a recording that the sidecar names win over what messages say.
#[test]
fn a_recording_is_read_by_the_topics_that_the_sidecar_names() {
    let stage = Stage::new(Platform::Op2);
    let noise = feet::Noise {
        cop_m: 0.0,
        encoder_rad: 0.0,
        flat_rad: 0.0,
    };
    let log = |frames: [&str; 2], text: &str| {
        let contacts = [("/a", frames[0]), ("/b", frames[1])].map(|(topic, frame)| Contact {
            topic: topic.to_string(),
            frame: frame.to_string(),
        });
        let (world, random) = (stage.world(), &mut seeded(86));
        let bytes = recording(&stage, &world, 12, noise, &contacts, random);
        let log = LogSource::bytes("both.mcap", bytes).with_sidecar(sidecar(text));
        let mut request = request(&stage, log);
        request.noise = Some(NOISE_M);
        diagnose(&request, &mut ()).map(|found| found.diagnosis)
    };
    let named =
        "[sensors.l]\nframe = 'l_sole'\ntopic = '/b'\n[sensors.r]\nframe = 'r_sole'\ntopic = '/a'";
    let found = log(["ft_right", "ft_left"], named).unwrap();
    let usual = log(["r_sole", "l_sole"], "").unwrap();
    assert_eq!(found.baseline, usual.baseline);
    assert_eq!(found.weight, usual.weight);
    assert!(found.closure.is_some_and(|own| own.closes));
    let no_topic = "sensor `l` of the sidecar: a recording needs its `topic`";
    for (topic, other, words) in [
        ("/b", "/c", "no wrench on topic `/c`"),
        ("topic = '/b'\n", "", no_topic),
    ] {
        let said = log(["ft_right", "ft_left"], &named.replace(topic, other));
        says(said.unwrap_err().to_string(), &[words]);
    }
}
