//! What `sesc diagnose` writes besides the model file: the corrected URDF, read back by
//! the reference, against a virtual robot with the same imperfections.

use sesc::OP2_URDF;
use sesc_identify::diagnose::remedy::{CorrectedUrdf, of_model_file};
use sesc_identify::fit::prior::{Prior, Tolerances};
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::effects::Catalog;
use sesc_model::{EffectRecord, ModelFile, Quantity, Snapping};
use sesc_reference::{Place, Reference, World};
use sesc_test_support::command::{Folder, list, says};
use sesc_test_support::trees::{Kind, tree};

const LIFT_BASE: &str = include_str!("../../robots/lift_base/lift_base.urdf");
/// Both sides sum the same masses in another order, m.
const AGREES: f64 = 1e-12;

fn effect(name: &str, target: &str, values: &[(&str, f64)]) -> EffectRecord {
    let quantity = |&(name, value): &(&str, f64)| {
        let quantity = Quantity { value, std: None };
        (name.to_string(), quantity)
    };
    EffectRecord {
        effect: name.to_string(),
        target: target.to_string(),
        parameters: values.iter().map(quantity).collect(),
        ..EffectRecord::default()
    }
}

fn offset(joint: &str, by: f64) -> EffectRecord {
    effect("joint_offset", joint, &[("offset_rad", by)])
}

fn payload(link: &str, mass_kg: f64, [x, y, z]: [f64; 3]) -> EffectRecord {
    let values = [("mass_kg", mass_kg), ("x_m", x), ("y_m", y), ("z_m", z)];
    effect("payload", link, &values)
}

/// The corrected text of a robot that has these effects, and CAD's parameters unless
/// others are given.
fn corrected(
    text: &str,
    support: &str,
    effects: Vec<EffectRecord>,
    params: Option<&[f64]>,
) -> CorrectedUrdf {
    let robot = Robot::parse(text, "r.urdf").unwrap();
    let model = robot.model(support, Snapping::Off, None).unwrap();
    let cad = model.cad_params();
    let mut file = ModelFile::from_values(&model, params.unwrap_or(&cad), None, "data");
    file.effects = effects;
    let (catalog, prior) = (Catalog::standard(), Prior::Cad(Tolerances::usual()));
    let snapping = Snapping::Off;
    of_model_file(&file, &robot, &model, &catalog, snapping, &prior, None).unwrap()
}

/// `text` as the reference reads it, with the joints that the robot of `original` has on `support`.
fn read(text: &str, original: &str, support: &str) -> sesc_reference::Robot {
    let model = Robot::parse(original, "r.urdf").unwrap();
    let model = model.model(support, Snapping::Off, None).unwrap();
    let joints: Vec<&str> = model.tree.dofs.iter().map(|dof| &*dof.joint).collect();
    let robot = sesc_reference::Robot::from_urdf(text).unwrap();
    robot.moved_by(&joints).unwrap()
}

/// The same effects in the virtual robot.
fn world(text: &str, support: &str, effects: &[EffectRecord]) -> World {
    let robot = read(text, text, support);
    let world = World::new(&robot, support).unwrap();
    effects.iter().fold(world, |world, record| {
        let values: Vec<f64> = record.parameters.values().map(|x| x.value).collect();
        let is_link = robot.links().iter().any(|link| link.name == record.target);
        let place = match is_link {
            true => Place::Link(&record.target),
            false => Place::Joint(&record.target),
        };
        world.named(&record.effect, place, &values).unwrap()
    })
}

/// How far the CoM of the corrected text is from the world's, over random postures, m.
fn worst(text: &str, support: &str, world: &World, original: &str) -> f64 {
    let reference = Reference::new(&read(text, original, support), support).unwrap();
    assert_eq!(reference.dof(), world.dof());
    let model = Robot::parse(original, "r.urdf").unwrap();
    let model = model.model(support, Snapping::Off, None).unwrap();
    let mut postures = Simulator::new(&model.tree.dofs, None, 5);
    (0..300)
        .map(|_| postures.posture())
        .map(|q| (reference.com(&q) - world.com(&q)).amax())
        .fold(0.0, f64::max)
}

/// Lines of `old` that `new` lacks, and lines of `new` that `old` lacks.
fn differing<'t>(old: &'t str, new: &'t str) -> [Vec<&'t str>; 2] {
    // Left and right legs have lines in common: each line there stands for one here.
    let lacking = |a: &'t str, b: &'t str| {
        let mut there: Vec<&str> = b.lines().collect();
        let mut lines: Vec<&str> = a.lines().collect();
        lines.retain(|line| match there.iter().position(|other| other == line) {
            Some(k) => {
                there.swap_remove(k);
                false
            }
            None => true,
        });
        lines.into_iter().map(str::trim).collect::<Vec<_>>()
    };
    [lacking(old, new), lacking(new, old)]
}

#[test]
fn the_corrected_op2_stands_as_the_real_one() {
    let effects = vec![
        offset("l_knee", 0.031),
        offset("head_tilt", -0.02),
        payload("body_link", 0.25, [-0.04, 0.01, 0.03]),
        payload("l_hip_pitch_link", -0.04, [0.01, 0.0, -0.02]),
    ];
    let found = corrected(OP2_URDF, "r_sole", effects.clone(), None);
    assert!(found.left_out.is_empty());
    for support in ["r_sole", "l_sole"] {
        let world = world(OP2_URDF, support, &effects);
        let off = worst(&found.text, support, &world, OP2_URDF);
        assert!(off < AGREES, "{support}: {off:e}");
    }
    // Two origins, and one link's inertial; the payload's own lines.
    let [gone, new] = differing(OP2_URDF, &found.text);
    assert_eq!(gone.len(), 5, "{gone:#?}");
    let origins = gone.iter().filter(|line| line.starts_with("<origin"));
    assert_eq!(origins.count(), 3);
    let added = new.iter().filter(|line| line.contains("payload_body_link"));
    assert_eq!(added.count(), 3, "{new:#?}");
}

#[test]
fn followers_and_slides_follow_in_lift_base() {
    let robot = sesc_reference::Robot::from_urdf(LIFT_BASE).unwrap();
    let joints: Vec<String> = robot.movable_joints().map(|j| j.name.clone()).collect();
    let offsets = joints.iter().enumerate();
    let offsets = offsets.map(|(k, joint)| offset(joint, 0.01 + 0.003 * k as f64));
    let mut effects: Vec<EffectRecord> = offsets.collect();
    let links = robot.links().iter();
    let heaviest = links.max_by(|a, b| a.mass_kg.total_cmp(&b.mass_kg));
    let base = heaviest.unwrap().name.clone();
    effects.push(payload(&base, -1.5, [0.1, -0.05, 0.2]));
    let last = robot.links().last().unwrap().name.clone();
    effects.push(payload(&last, 0.2, [0.0, 0.03, 0.01]));
    let found = corrected(LIFT_BASE, "base_link", effects.clone(), None);
    let world = world(LIFT_BASE, "base_link", &effects);
    let off = worst(&found.text, "base_link", &world, LIFT_BASE);
    assert!(off < AGREES, "{off:e}");
    let comments = |text: &str| text.matches("<!--").count();
    assert_eq!(comments(&found.text), comments(LIFT_BASE));
}

#[test]
fn random_robots_stand_as_they_really_do() {
    for seed in 0..40 {
        let kind = Kind {
            joints: 3 + seed as usize % 9,
            canonical: seed % 3 == 0,
            revolute: false,
            chained: 0.6,
        };
        let (text, _) = tree(seed, kind);
        let robot = read(&text, &text, "link-1");
        let joints = robot.movable_joints().enumerate();
        let offsets = joints.map(|(k, joint)| offset(&joint.name, 0.3 - 0.1 * k as f64));
        let mut effects: Vec<EffectRecord> = offsets.collect();
        effects.push(payload("link-1", 0.4, [0.1, 0.2, -0.3]));
        let found = corrected(&text, "link-1", effects.clone(), None);
        let world = world(&text, "link-1", &effects);
        let off = worst(&found.text, "link-1", &world, &text);
        assert!(off < AGREES, "seed {seed}: {off:e}\n{text}\n{}", found.text);
    }
}

#[test]
fn masses_come_along_and_what_no_urdf_holds_is_named() {
    let heavier = sesc_reference::Robot::from_urdf(OP2_URDF).unwrap();
    let heavier = World::new(&heavier, "r_sole")
        .and_then(|world| world.link_mass("body_link", 1.05, [0.002, -0.001, 0.003]))
        .and_then(|world| world.joint_offset("r_knee", 0.02))
        .unwrap();
    // What data would tell of that robot: its base parameters.
    let mut links = heavier.robot().links().iter();
    let link = links.find(|l| l.name == "body_link").unwrap();
    let weight = sesc_model::urdf::Weight {
        mass_kg: link.mass_kg,
        com_m: link.com_m.coords.into(),
    };
    let cad = Robot::parse(OP2_URDF, "op2.urdf").unwrap();
    let links = cad.description.links.iter();
    let weights = links.map(|l| (l.name == "body_link").then_some(weight));
    let weights: Vec<_> = weights.collect();
    let text = sesc_model::urdf::edit_masses(&cad.description, &weights).unwrap();
    let params = Robot::parse(&text, "op2.urdf").unwrap();
    let params = params.model("r_sole", Snapping::Off, None).unwrap();
    let params = params.cad_params();
    let sensor = [("offset_x_m", 0.001), ("offset_y_m", 0.0)];
    let effects = vec![
        offset("r_knee", 0.02),
        effect("sensor_offset", "-", &sensor),
        effect("joint_scale", "l_knee", &[("scale", 1.02)]),
        payload("l_ank_roll_link", -50.0, [0.0; 3]),
    ];
    let found = corrected(OP2_URDF, "r_sole", effects, Some(&params));
    let off = worst(&found.text, "r_sole", &heavier, OP2_URDF);
    assert!(off < 1e-10, "{off:e}");
    let said = found.left_out.join("\n");
    for effect in [
        "sensor_offset",
        "joint_scale:l_knee",
        "payload:l_ank_roll_link",
    ] {
        says(&said, &[&format!("{effect} stays in the model file")]);
    }
    assert_eq!(found.left_out.len(), 3, "{said}");
}

#[test]
fn the_command_says_what_to_change() {
    let folder = Folder::with("two_link");
    let robot = Robot::read(&folder.join("two_link.urdf")).unwrap();
    let support = robot.description.links[0].name.clone();
    let model = robot.model(&support, Snapping::default(), None).unwrap();
    let mut file = ModelFile::from_values(&model, &model.cad_params(), None, "data");
    let joint = model.tree.dofs.last().unwrap().joint.clone();
    let sensor = [("offset_x_m", 0.02), ("offset_y_m", -0.01)];
    file.effects = vec![offset(&joint, 0.05), effect("sensor_offset", "-", &sensor)];
    folder.write("truth.toml", toml::to_string(&file).unwrap());
    let on = format!("two_link.urdf --support {support}");
    let log = "--poses 80 --noise 0.0005 --seed 3 --model truth.toml --out log.csv";
    folder.stdout(&format!("simulate {on} {log}"));
    // Ticks fall as the angle rises, 1024 a turn: 0.05 rad are 8.1 ticks.
    let servos = format!("[joints.{joint}]\nzero = 500\nsign = -1\nresolution = 1024\n");
    folder.write("servos.toml", servos);
    let diagnose = format!("diagnose {on} --data {} --out", folder.at("log.csv"));
    let [model_file, page] = ["model.toml", "page.html"].map(|name| folder.at(name));
    let said = folder.stdout(&format!(
        "{diagnose} {model_file} --servos servos.toml --report {page}"
    ));
    let angle = format!("true angle of {joint} = reading + 2.8");
    let model_com = "NAME_model_com(q, com);";
    let lines = ["zero 500 → 508", "URDF line ", "  becomes        <origin "];
    let sensor = [
        "true CoP = reading − ",
        "not in a URDF  a URDF describes no CoP sensor",
    ];
    says(said, &[&lines[..], &sensor, &[&angle, model_com]].concat());
    let page = folder.read("page.html");
    says(
        &page,
        &["zero 500 → 508", "URDF line ", "not in a URDF", "model_com"],
    );
    assert!(!page.contains(&folder.path().display().to_string()));

    let json = folder.json(&format!("{diagnose} model.toml --urdf corrected.urdf"));
    Robot::read(&folder.join("corrected.urdf")).unwrap();
    let remedy = |name: &str| {
        let mut steps = list(&json, "/steps").iter();
        &steps.find(|step| step["effect"] == name).unwrap()["remedy"]
    };
    let of_joint = remedy("joint_offset");
    // No servos were given here.
    assert!(of_joint.get("servo_zero").is_none());
    // The line that is named holds what stands there before.
    let line = of_joint["urdf"]["line"].as_u64().unwrap() as usize;
    let text = folder.read("two_link.urdf");
    let before = of_joint["urdf"]["before"].as_str().unwrap();
    says(text.lines().nth(line - 1).unwrap(), &[before]);
    assert!(of_joint.get("not_in_urdf").is_none());
    let sensor = remedy("sensor_offset");
    assert!(sensor.get("urdf").is_none() && sensor.get("servo_zero").is_none());
    let left_out = json["left_out_of_urdf"][0].as_str().unwrap();
    assert!(left_out.starts_with("sensor_offset stays in the model file: a URDF describes no"));
    // The C call is one that the command generates.
    folder.stdout(&format!(
        "generate {on} --lang c --name arm --model model.toml --out c"
    ));
    let call = json["use"]["c"].as_str().unwrap().replace("NAME", "arm");
    let function = call.split('(').next().unwrap();
    says(
        folder.read("c/arm.h"),
        &[&format!("void {function}(const ")],
    );
    assert_eq!(json["use"]["build_rs"], ".model(\"model.toml\")");
    let generate = format!("sesc generate {on} --lang c --model model.toml");
    assert_eq!(json["use"]["generate"], generate);

    folder.write("stray.toml", "[joints.kne]\n");
    let stray = "diagnose two_link.urdf --data log.csv --servos stray.toml";
    folder.refuses(stray, &["kne", &joint]);
}
