//! `sesc diagnose` from outside: its JSON as the contract has it, and files that
//! agree with what it says, judged by the virtual robot.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use sesc_reference::{Reference, Robot, World};
use sesc_test_support::command::{folder, op2, refused, sesc, stdout, write};
use sesc_virtual::hidden::{Effect, Hidden, NOWHERE};
use sesc_virtual::stage::Platform;
use sesc_virtual::trial::{Choice, Question, Trial};

fn only(effect: Option<Effect>) -> Choice {
    Choice {
        platforms: vec![Platform::Op2],
        only: effect,
        body: false,
        long: false,
    }
}

fn hidden(effect: Effect, target: &str, values: &[f64]) -> Hidden {
    Hidden {
        effect,
        target: target.to_owned(),
        values: values.to_vec(),
        begins: 0.0,
        seed: 1,
    }
}

/// A log of 100 balanced postures of the OP2 with this hidden.
fn logged(folder: &Path, stem: &str, truth: Vec<Hidden>) -> String {
    let trial = Trial::of(truth, &only(None), 3).unwrap();
    trial.log.write(folder, stem).display().to_string()
}

/// By masses that are known well, unless `more` says otherwise.
fn diagnose(log: &str, more: &[&str]) -> Value {
    let urdf = op2();
    let mut arguments = vec!["diagnose", &urdf, "--data", log, "--json"];
    if !more.contains(&"--prior") {
        arguments.extend(["--prior", "tight"]);
    }
    arguments.extend(more);
    let output = sesc(&arguments);
    serde_json::from_str(&stdout(&output)).unwrap()
}

fn number(value: &Value) -> f64 {
    let number = value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"));
    assert!(number.is_finite());
    number
}

fn labels(said: &Value) -> Vec<String> {
    let steps = said["steps"].as_array().unwrap();
    steps
        .iter()
        .map(|step| {
            let (effect, target) = (step["effect"].as_str(), step["target"].as_str());
            match target.unwrap() {
                "-" => effect.unwrap().to_string(),
                target => format!("{}:{target}", effect.unwrap()),
            }
        })
        .collect()
}

/// Every key of the contract, with its type, and what they say of each other.
fn as_agreed(said: &Value) {
    let verdict = said["verdict"].as_str().unwrap();
    for key in ["rmse", "rmse_x", "rmse_y"] {
        assert!(number(&said["baseline"][key]) >= 0.0);
    }
    let bias = said["baseline"]["bias"].as_array().unwrap();
    assert_eq!(bias.iter().map(number).count(), 2);
    assert!(number(&said["noise_floor"]) > 0.0 && number(&said["final"]["rmse"]) > 0.0);
    assert!(
        said["next_postures"]["why"]
            .as_str()
            .is_some_and(|why| !why.is_empty())
    );
    let file = &said["next_postures"]["file"];
    assert!(file.is_null() || file.is_string());
    assert_eq!(
        said["unexplained"].as_bool(),
        Some(verdict == "unexplained")
    );
    let steps = said["steps"].as_array().unwrap();
    for step in steps {
        let keys: Vec<&str> = step
            .as_object()
            .unwrap()
            .keys()
            .map(String::as_str)
            .collect();
        let mut agreed = [
            "effect",
            "target",
            "parameters",
            "rmse_before",
            "rmse_after",
            "evidence",
            "sentence",
            "remedy",
        ];
        agreed.sort_unstable();
        let mut keys = keys;
        keys.sort_unstable();
        assert_eq!(keys, agreed);
        for quantity in step["parameters"].as_object().unwrap().values() {
            number(&quantity["value"]);
            assert!(number(&quantity["std"]) >= 0.0);
        }
        assert!(number(&step["rmse_after"]) < number(&step["rmse_before"]));
        number(&step["evidence"]);
        assert!(!step["sentence"].as_str().unwrap().is_empty());
    }
    if let Some(last) = steps.last() {
        assert_eq!(last["rmse_after"], said["final"]["rmse"]);
    }
    // Complete explanations, the reported one first.
    let groups = said["indistinguishable"].as_array().unwrap();
    let reported = labels(said);
    match groups.first() {
        None => assert!(reported.is_empty()),
        Some(first) => {
            let first = first.as_array().unwrap().iter();
            let mut first: Vec<&str> = first.map(|label| label.as_str().unwrap()).collect();
            let mut reported: Vec<&str> = reported.iter().map(String::as_str).collect();
            first.sort_unstable();
            reported.sort_unstable();
            assert_eq!(first, reported);
        }
    }
    let count = groups.len();
    match verdict {
        "none" | "absorbed" => assert!(reported.is_empty() && count == 0),
        "named" => assert_eq!(count, 1),
        "class" => assert!(count > 1),
        "unexplained" => assert!(count <= 1),
        other => panic!("`{other}` is no verdict"),
    }
}

#[test]
fn every_verdict_has_the_keys_of_the_contract() {
    let folder = folder();
    let offset = || vec![hidden(Effect::SensorOffset, NOWHERE, &[0.005, -0.004])];
    for (verdict, truth, prior) in [
        ("none", vec![], "tight"),
        (
            "named",
            vec![hidden(Effect::SensorRotation, NOWHERE, &[0.1])],
            "tight",
        ),
        (
            "class",
            vec![hidden(Effect::JointOffset, "r_ank_roll", &[0.008])],
            "tight",
        ),
        ("absorbed", offset(), "free"),
        (
            "unexplained",
            vec![hidden(Effect::KneeSine, "r_knee", &[0.006])],
            "tight",
        ),
    ] {
        let log = logged(folder.path(), verdict, truth);
        let said = diagnose(&log, &["--prior", prior]);
        assert_eq!(said["verdict"], verdict, "{}", said["sentence"]);
        as_agreed(&said);
    }
}

/// Postures of a file, its columns in the order of the joints.
fn postures(path: &str, joints: &[String]) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let places: Vec<usize> = joints
        .iter()
        .map(|joint| header.iter().position(|name| name == joint).unwrap())
        .collect();
    lines
        .map(|line| {
            let cells: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
            places.iter().map(|&at| cells[at]).collect()
        })
        .collect()
}

/// CoP by `sesc predict`, angles of the URDF taken literally as the reference does.
fn predicted(urdf: &str, more: &[&str]) -> Vec<[f64; 2]> {
    let text = stdout(&sesc(&[&["predict", urdf, "--no-snap"][..], more].concat()));
    let rows = text.lines().skip(1).map(|line| {
        let cells: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        [cells[4], cells[5]]
    });
    rows.collect()
}

fn worst(found: &[[f64; 2]], truth: &[[f64; 2]]) -> f64 {
    assert_eq!(found.len(), truth.len());
    let gaps = found.iter().zip(truth);
    gaps.flat_map(|(a, b)| [a[0] - b[0], a[1] - b[1]])
        .fold(0.0, |worst: f64, gap| worst.max(gap.abs()))
}

/// A log with three effects, diagnosed with masses beyond doubt: the world of the
/// values in the model file is what every output has to agree with.
struct Told {
    folder: tempfile::TempDir,
    log: String,
    said: Value,
    world: World,
    q: Vec<Vec<f64>>,
}

impl Told {
    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }
}

fn told(truth: Vec<Hidden>) -> Told {
    let folder = folder();
    let log = logged(folder.path(), "log", truth);
    let prior = write(
        folder.path(),
        "prior.toml",
        "[default]\nmass = 0.0\ncom = 0.0\n",
    );
    let path = |name: &str| folder.path().join(name).display().to_string();
    let [model, urdf, report, next] =
        ["model.toml", "corrected.urdf", "report.html", "next.csv"].map(path);
    let outputs = [
        "--out", &model, "--urdf", &urdf, "--report", &report, "--next", &next,
    ];
    let said = diagnose(
        &log,
        &[&["--no-snap", "--prior", &prior][..], &outputs].concat(),
    );
    let file: toml::Table = fs::read_to_string(&model).unwrap().parse().unwrap();
    let robot = Robot::from_file(Path::new(&op2())).unwrap();
    let effects = file.get("effects").and_then(toml::Value::as_array).cloned();
    let world = World::new(&robot, "r_sole").unwrap();
    let world = effects
        .unwrap_or_default()
        .iter()
        .fold(world, |world, effect| {
            let value = |name: &str| effect["parameters"][name]["value"].as_float().unwrap();
            let target = effect["target"].as_str().unwrap();
            match effect["effect"].as_str().unwrap() {
                "joint_offset" => world.joint_offset(target, value("offset_rad")).unwrap(),
                "joint_scale" => world.joint_scale(target, value("scale")).unwrap(),
                "sensor_rotation" => world.sensor_rotation(value("yaw_rad")),
                other => panic!("{other} was not hidden"),
            }
        });
    let joints: Vec<String> = robot.movable_joints().map(|j| j.name.clone()).collect();
    let q = postures(&log, &joints);
    Told {
        log,
        said,
        world,
        q,
        folder,
    }
}

impl Told {
    fn truth(&self) -> Vec<[f64; 2]> {
        self.q.iter().map(|q| self.world.cop(q)).collect()
    }
}

#[test]
fn the_model_file_predicts_what_was_diagnosed_here_and_in_c() {
    let told = told(vec![
        hidden(Effect::JointScale, "r_ank_roll", &[0.2]),
        hidden(Effect::SensorRotation, NOWHERE, &[0.15]),
    ]);
    // The file holds what was said, to the last digit.
    let file: toml::Table = fs::read_to_string(told.path("model.toml"))
        .unwrap()
        .parse()
        .unwrap();
    for step in told.said["steps"].as_array().unwrap() {
        let effects = file["effects"].as_array().unwrap();
        let mut effects = effects.iter();
        let own = effects
            .find(|e| e["effect"].as_str() == step["effect"].as_str())
            .unwrap();
        for (name, said) in step["parameters"].as_object().unwrap() {
            for key in ["value", "std"] {
                let held = own["parameters"][name.as_str()][key].as_float();
                assert_eq!(held, said[key].as_f64(), "{name}");
            }
        }
    }
    let mut labels = labels(&told.said);
    labels.sort();
    assert_eq!(labels, ["joint_scale:r_ank_roll", "sensor_rotation"]);
    let model = told.path("model.toml");
    let found = predicted(&op2(), &["--model", &model, "--data", &told.log]);
    let truth = told.truth();
    assert!(worst(&found, &truth) < 1e-12, "{:e}", worst(&found, &truth));
    // Judged by what the log reads, it leaves what was said.
    let header = fs::read_to_string(&told.log).unwrap();
    let header: Vec<String> = header
        .lines()
        .next()
        .unwrap()
        .split(',')
        .map(Into::into)
        .collect();
    assert!(header.contains(&"cop_x".to_string()));
    let read = postures(&told.log, &["cop_x".into(), "cop_y".into()]);
    let squares: f64 = read
        .iter()
        .zip(&found)
        .map(|(y, p)| (y[0] - p[0]).powi(2) + (y[1] - p[1]).powi(2))
        .sum();
    let rmse = (squares / (2.0 * read.len() as f64)).sqrt();
    // Held out it is a little more: two unknowns of 200 readings.
    let last = number(&told.said["final"]["rmse"]);
    assert!(last >= rmse && last < 1.04 * rmse, "{last:e} and {rmse:e}");
    let c = in_c(&told);
    assert!(worst(&c, &truth) < 1e-12, "{:e}", worst(&c, &truth));
}

/// `NAME_model_cop` of the generated C over the log's postures.
fn in_c(told: &Told) -> Vec<[f64; 2]> {
    let out = told.path("c");
    let model = told.path("model.toml");
    let urdf = op2();
    let name = ["--lang", "c", "--scalar", "f64", "--name", "told"];
    let files = ["--out", &out, "--model", &model];
    let robot = ["generate", &urdf, "--support", "r_sole", "--no-snap"];
    stdout(&sesc(&[&robot[..], &name, &files].concat()));
    let rows: Vec<String> = told
        .q
        .iter()
        .map(|q| {
            format!(
                "{{{}}}",
                q.iter()
                    .map(|x| format!("{x:?}"))
                    .collect::<Vec<_>>()
                    .join(",")
            )
        })
        .collect();
    let main = format!(
        "#include <stdio.h>\n#include \"told.h\"\nstatic const double q[][told_DOF] = {{{}}};\n\
         int main(void) {{ for (unsigned k = 0; k < sizeof q / sizeof *q; k++) {{ double cop[2]; \
         told_model_cop(q[k], cop); printf(\"%.17g %.17g\\n\", cop[0], cop[1]); }} return 0; }}\n",
        rows.join(",\n")
    );
    write(Path::new(&out), "main.c", main);
    let program = PathBuf::from(&out).join("main");
    let built = Command::new("cc")
        .args(["-O1", "-o"])
        .arg(&program)
        .args([format!("{out}/main.c"), format!("{out}/told.c")])
        .arg("-lm")
        .status()
        .unwrap();
    assert!(built.success());
    let said = Command::new(program).output().unwrap();
    let text = String::from_utf8(said.stdout).unwrap();
    text.lines()
        .map(|line| {
            let (x, y) = line.split_once(' ').unwrap();
            [x.parse().unwrap(), y.parse().unwrap()]
        })
        .collect()
}

#[test]
fn the_corrected_urdf_needs_no_effect_and_the_next_postures_stand() {
    let told = told(vec![hidden(Effect::JointOffset, "r_ank_pitch", &[-0.01])]);
    as_agreed(&told.said);
    let truth = told.truth();
    let file = fs::read_to_string(told.path("model.toml")).unwrap();
    assert!(file.contains("joint_offset"), "{}", told.said["sentence"]);
    let corrected = told.path("corrected.urdf");
    let found = predicted(&corrected, &["--support", "r_sole", "--data", &told.log]);
    assert!(worst(&found, &truth) < 1e-9, "{:e}", worst(&found, &truth));
    // The postures that would tell more.
    assert_eq!(told.said["verdict"], "class");
    let next = told.path("next.csv");
    assert_eq!(told.said["next_postures"]["file"], next.as_str());
    let side: toml::Table = fs::read_to_string(told.path("next.toml"))
        .unwrap()
        .parse()
        .unwrap();
    let support = side["support"].as_str().unwrap();
    let robot = Robot::from_file(Path::new(&op2())).unwrap();
    let joints: Vec<String> = robot.movable_joints().map(|j| j.name.clone()).collect();
    let reference = Reference::new(&robot, support).unwrap();
    let limits: Vec<(f64, f64)> = robot.movable_joints().map(|j| j.range()).collect();
    let asked = postures(&next, &joints);
    assert!(asked.len() >= 30);
    let found = predicted(&op2(), &["--data", &next]);
    for (q, found) in asked.iter().zip(&found) {
        let com = reference.com(q);
        assert!((com.x - found[0]).abs() < 1e-12 && (com.y - found[1]).abs() < 1e-12);
        // The sole of the OP2 reaches 52 mm forward, 33 mm aside.
        assert!(com.x.abs() < 0.052 && com.y.abs() < 0.04, "{com}");
        for (q, (low, high)) in q.iter().zip(&limits) {
            assert!((low - 1e-9..=high + 1e-9).contains(q));
        }
    }
    let page = fs::read_to_string(told.path("report.html")).unwrap();
    for word in [
        "src=\"http",
        "href=\"http",
        "@import",
        "url(http",
        "<script src",
        "<link",
    ] {
        assert!(!page.contains(word), "{word}");
    }
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    assert!(page.contains("r_ank_pitch"));
}

#[test]
fn the_same_command_gives_the_same_bytes() {
    let folder = folder();
    let log = logged(
        folder.path(),
        "log",
        vec![hidden(Effect::JointOffset, "r_knee", &[0.015])],
    );
    let names = [
        "model.toml",
        "corrected.urdf",
        "report.html",
        "next.csv",
        "next.toml",
    ];
    let run = || {
        let paths = names.map(|name| folder.path().join(name).display().to_string());
        let [model, urdf, report, next, _] = &paths;
        let arguments = [
            "diagnose",
            &op2(),
            "--data",
            &log,
            "--out",
            model,
            "--urdf",
            urdf,
            "--report",
            report,
            "--next",
            next,
            "--prior",
            "tight",
            "--json",
        ];
        let said = stdout(&sesc(&arguments));
        let files = paths.each_ref().map(|path| fs::read(path).unwrap());
        paths.iter().for_each(|path| fs::remove_file(path).unwrap());
        (said, files)
    };
    let (once, again) = (run(), run());
    assert_eq!(once.0, again.0);
    for (name, (a, b)) in names.iter().zip(once.1.iter().zip(&again.1)) {
        assert!(!a.is_empty() && a == b, "{name}");
    }
}

/// What `--next` asked for, taken and given back with `--then`.
#[test]
fn the_log_of_the_next_experiment_is_taken_with_the_first() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let log = logged(
        folder.path(),
        "log",
        vec![hidden(Effect::JointOffset, "r_ank_roll", &[0.01])],
    );
    let [next, model] = ["next.csv", "model.toml"].map(path);
    let before = diagnose(&log, &["--next", &next]);
    assert_eq!(before["verdict"], "class");
    let side: toml::Table = fs::read_to_string(path("next.toml"))
        .unwrap()
        .parse()
        .unwrap();
    let (support, turned) = (side["support"].as_str().unwrap(), "turned");
    assert_eq!(side["experiment"].as_str(), Some(turned));
    let robot = Robot::from_file(Path::new(&op2())).unwrap();
    let world = World::new(&robot, support).unwrap();
    let world = world.joint_offset("r_ank_roll", 0.01).unwrap();
    let joints: Vec<String> = robot.movable_joints().map(|j| j.name.clone()).collect();
    let mut text = format!(
        "pose,{},cop_x,cop_y,cop_x_std,cop_y_std\n",
        joints.join(",")
    );
    for (k, q) in postures(&next, &joints).iter().enumerate() {
        // Any numbers of the size of the noise.
        let noise = [7.1, 3.3].map(|step| 5e-4 * 1.4 * (step * k as f64).sin());
        let cop = world.cop(q);
        let angles: Vec<String> = q.iter().map(f64::to_string).collect();
        let [x, y] = [0, 1].map(|axis| cop[axis] + noise[axis]);
        text += &format!("{k},{},{x},{y},0.0005,0.0005\n", angles.join(","));
    }
    let second = write(folder.path(), "second.csv", &text);
    fs::copy(path("next.toml"), path("second.toml")).unwrap();
    let after = diagnose(&log, &["--then", &second, "--out", &model]);
    as_agreed(&after);
    let holds = |said: &Value, label: &str| {
        let groups = said["indistinguishable"].as_array().unwrap();
        groups.contains(&serde_json::json!([label]))
    };
    assert!(holds(&before, "ground_slope"));
    assert!(!holds(&after, "ground_slope"), "{}", after["sentence"]);
    assert!(
        holds(&after, "joint_offset:r_ank_roll"),
        "{}",
        after["sentence"]
    );
    assert_eq!(after["log"], "log.csv + second.csv");
    let file: toml::Table = fs::read_to_string(&model).unwrap().parse().unwrap();
    let used = file["data"].as_array().unwrap();
    assert_eq!(used[0]["file"].as_str(), Some("log.csv"));
    assert_eq!(used[1]["file"].as_str(), Some("second.csv"));
    // What no log can say is refused, and so is another foot that is none.
    for (experiment, words) in [
        ("known_weight", ["known_weight", "Diagnose it alone"]),
        ("other_foot", ["other_foot", "mend"]),
    ] {
        let side = format!("support = \"r_sole\"\nexperiment = \"{experiment}\"\n");
        write(folder.path(), "second.toml", side);
        let urdf = op2();
        let output = sesc(&["diagnose", &urdf, "--data", &log, "--then", &second]);
        refused(&output, &words);
    }
}

/// The first draw of this effect that is clear beyond doubt and logged as wanted.
fn clear(effect: Effect, wanted: &str) -> Trial {
    (0..)
        .map(|seed| Trial::draw(Question::Library(1), &only(Some(effect)), seed))
        .find(|trial| {
            let folder = folder();
            let csv = trial.log.write(folder.path(), "log");
            let text = fs::read_to_string(csv).unwrap();
            trial.chi2 > 1500.0 && text.lines().next().unwrap().contains(wanted)
        })
        .unwrap()
}

#[test]
fn faulty_cells_and_late_angles_are_named() {
    let folder = folder();
    for (effect, wanted) in [(Effect::CellGain, "fsr_4"), (Effect::TimeDelay, ",t,")] {
        let trial = clear(effect, wanted);
        let csv = trial.log.write(folder.path(), effect.name());
        let said = diagnose(&csv.display().to_string(), &[]);
        assert_eq!(
            labels(&said),
            [trial.hidden[0].label()],
            "{}",
            said["sentence"]
        );
        let truth = trial.hidden[0].values[0];
        let (name, truth) = match effect {
            Effect::CellGain => ("gain", 1.0 + truth),
            _ => ("delay_s", truth),
        };
        let found = &said["steps"][0]["parameters"][name];
        let pull = (number(&found["value"]) - truth) / number(&found["std"]);
        // A motion known by its samples alone is not known exactly.
        assert!(pull.abs() < 5.0, "{found} is not {truth}");
        as_agreed(&said);
    }
}
