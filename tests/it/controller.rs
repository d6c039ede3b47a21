//! A controller builds with three lines of `build.rs`, runs, is left alone by a
//! second build and follows a change of the URDF. With a model file it predicts
//! readings with the robot's effects and inverts the effects of the sensor.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::SystemTime;

use sesc_identify::robot::Robot;
use sesc_model::{Information, ModelFile, Snapping};
use sesc_test_support::child::Child;
use sesc_test_support::command::ROOT;

/// What cargo does with these words, and what is said.
fn cargo(child: &Child, arguments: &[&str]) -> (Output, String) {
    let output = child.command(arguments).output().unwrap();
    let [stdout, stderr] = [&output.stdout, &output.stderr].map(|s| String::from_utf8_lossy(s));
    let said = stdout.into_owned() + &stderr;
    (output, said)
}

/// The module that the controller's `build.rs` wrote, and when; other crates share the folder.
fn module() -> (SystemTime, PathBuf) {
    let builds = fs::read_dir(Child::target().join("debug/build")).unwrap();
    let paths = builds.map(|entry| entry.unwrap().path());
    let is_own = |path: &PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy();
        name.starts_with("controller-")
    };
    let modules = paths.filter(is_own);
    let modules = modules.map(|path| path.join("out/op2_r_sole.rs"));
    let modules = modules.filter(|path| path.exists());
    let timed = modules.map(|path| (fs::metadata(&path).unwrap().modified().unwrap(), path));
    timed.max().expect("build.rs wrote a module")
}

/// Worst CoM error on new postures, with the identified parameters and with the CAD's.
fn com_errors_mm(text: &str) -> (f64, f64) {
    let line = text.lines().find(|line| line.starts_with("identified"));
    let mut within = line
        .into_iter()
        .flat_map(|line| line.split("within ").skip(1))
        .map(|rest| rest.split(' ').next().unwrap().parse().unwrap());
    (within.next().expect(text), within.next().expect(text))
}

#[test]
fn a_controller_builds_runs_and_follows_its_urdf() {
    let child = Child::controller("controller");
    for file in ["build.rs", "src/main.rs"] {
        let text = Child::example(file).replace("../../robots/op2/op2.urdf", "op2.urdf");
        child.write(file, &text.replace("../../", &format!("{ROOT}/")));
    }
    let (first, said) = cargo(&child, &["run", "--quiet"]);
    assert!(first.status.success() && said.contains("CoM ["), "{said}");
    let (identified, by_cad) = com_errors_mm(&said);
    // The noise of the readings is 1 mm; the height is seen only through their changes.
    assert!(identified < 2.0, "{said}");
    assert!(by_cad > 10.0 * identified, "{said}");
    let written = module();

    let (_, said) = cargo(&child, &["build", "-v"]);
    let is_fresh = said.contains("Fresh controller");
    assert!(is_fresh, "a second build must do nothing:\n{said}");
    assert_eq!(module(), written);

    // The same bytes with a new time: the script runs, the module is not touched.
    let urdf = child.path("op2.urdf");
    let text = fs::read_to_string(&urdf).unwrap();
    fs::write(&urdf, &text).unwrap();
    child.cargo(&["build"]).unwrap();
    assert_eq!(module(), written, "nothing changed, nothing to write");

    let heavier = text.replacen("<mass value=\"0.1", "<mass value=\"0.2", 1);
    assert_ne!(heavier, text);
    fs::write(&urdf, &heavier).unwrap();
    let third = child.cargo(&["run", "--quiet"]).unwrap();
    assert_ne!(third, first.stdout, "a heavier link moves the CoM");

    let broken = text.replacen("<mass value=\"0", "<mass value=\"-0", 1);
    fs::write(&urdf, broken).unwrap();
    let said = child.cargo(&["build"]).unwrap_err();
    let complaint = "Error: op2.urdf:15: link `body_link`: mass is -0.97559947 kg";
    assert!(said.contains(complaint), "{said}");
}

/// Predicts a reading and inverts the effects of the sensor.
const PREDICT: &str = r#"
#![deny(warnings)]
mod op2 {
    include!(concat!(env!("OUT_DIR"), "/effects.rs"));
}
use sesc_runtime::fit::Estimator;
use sesc_runtime::{CorrectCop, Sesc};

fn main() {
    let q = [0.1; op2::DOF];
    let reading = op2::Effects::cop(&q, &op2::MODEL_PARAMS);
    let cop = op2::Effects::correct_cop(&reading);
    assert_eq!(cop, op2::correct_cop(&reading));
    // The estimator goes on from the file, with the model's rows and its correction.
    let (params, factor) = (&op2::MODEL_PARAMS, &op2::MODEL_INFORMATION);
    let mut natural = Estimator::<f64, { op2::BASE_PARAMS }>::resume(params, factor).unwrap();
    assert_eq!(natural.deviations(), op2::MODEL_STD);
    let mut by_hand = natural.clone();
    natural.add_posture::<op2::Effects>(&q, &reading, &[1e-3; 2]).unwrap();
    by_hand.posture(&op2::regressor_cop(&q), &cop, &[1e-3; 2]).unwrap();
    assert_eq!(natural, by_hand);
    println!("{:?} {:?} {:?} {:?}", reading[0], reading[1], cop[0], cop[1]);
}
"#;

#[test]
fn a_controller_with_a_model_file_has_its_effects() {
    let child = Child::controller("with_effects");
    let build = Child::example("build.rs").replace("../../", &format!("{ROOT}/"));
    let emit = ".model(\"model.toml\").name(\"effects\").emit()";
    child.write("build.rs", &build.replace(".emit()", emit));
    child.write("src/main.rs", PREDICT);

    let robot = Robot::read(&child.path("op2.urdf")).unwrap();
    let model = robot.model("r_sole", Snapping::default(), None).unwrap();
    let (cad, count) = (model.cad_params(), model.base.params.len());
    let mut file = ModelFile::from_values(&model, &cad, Some(&vec![0.0; count]), "prior");
    let known = nalgebra::DMatrix::identity(count, count) * 64.0;
    file.inform(Information::of(&known));
    let effects = |offset: f64| {
        format!(
            "{}[[effects]]\neffect = \"sensor_offset\"\nparameters.offset_x_m = {{ value = \
             {offset} }}\nparameters.offset_y_m = {{ value = 0.002 }}\n[[effects]]\neffect = \
             \"joint_offset\"\ntarget = \"l_knee\"\nparameters.offset_rad = {{ value = 0.2 }}\n\
             [[effects]]\neffect = \"sensor_drift\"\nparameters.drift_x_m = {{ value = 1 }}\n\
             parameters.drift_y_m = {{ value = 1 }}\n",
            toml::to_string(&file).unwrap()
        )
    };
    let mut q = vec![0.1; model.dof()];
    let knee = model.tree.dofs.iter().position(|dof| dof.joint == "l_knee");
    q[knee.unwrap()] += 0.2;
    let bent = model.com_by_sum(&q);
    for offset in [0.003, -0.007] {
        child.write("model.toml", &effects(offset));
        let (output, said) = cargo(&child, &["run"]);
        assert!(output.status.success(), "{said}");
        let note = "sensor_drift` belongs to the log";
        assert!(said.contains(note), "{said}");
        let printed = String::from_utf8(output.stdout).unwrap();
        let values = printed.split_whitespace().map(|x| x.parse().unwrap());
        let values: Vec<f64> = values.collect();
        let expected = [bent[0] + offset, bent[1] + 0.002, bent[0], bent[1]];
        for (found, expected) in values.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-14, "{values:?} {expected}");
        }
    }
}

/// Calls the page's function with postures of the robot and readings that its CAD predicts.
const OF_LOG: &str = r#"
fn main() {
    let q: Vec<[f64; DOF]> = (0..100)
        .map(|k| std::array::from_fn(|j| 0.3 * (f64::from(k) * (1.0 + j as f64)).sin()))
        .collect();
    let cop: Vec<[f64; 2]> = q.iter().map(|q| op2::cop(q, &CAD_PARAMS)).collect();
    let (heights, params) = of_log(&q, &cop).unwrap();
    for (q, height) in q.iter().zip(&heights) {
        assert!((op2::com(q, &CAD_PARAMS)[2] - height).abs() < 1e-14);
    }
    for (found, cad) in params.iter().zip(&CAD_PARAMS) {
        assert!((found - cad).abs() < 1e-9, "{found} {cad}");
    }
}
"#;

/// The examples of `docs/controller.md`: generated text as it is, and a crate that runs.
#[test]
fn the_examples_of_the_page_are_a_controller_that_runs() {
    let page = fs::read_to_string(Path::new(ROOT).join("docs/controller.md")).unwrap();
    let fences = page.split("```rust\n").skip(1);
    let blocks: Vec<&str> = fences
        .map(|block| block.split("```").next().unwrap())
        .collect();
    let [generated, crate_text, holding, of_log, stand, _] = blocks[..] else {
        panic!("the page has {} examples in Rust", blocks.len())
    };
    assert!(
        !page.contains("```text"),
        "an example that nothing compiles"
    );
    let module = fs::read_to_string(Path::new(ROOT).join("generated/src/op2_r_sole.rs")).unwrap();
    assert!(module.contains(generated), "{generated}");

    let child = Child::controller("of_the_page");
    let (build, main) = crate_text.split_once("// src/main.rs\n").unwrap();
    child.write("build.rs", build);
    let hold = format!(
        "#[allow(dead_code)]\nfn hold(q: [f64; DOF], r: [f64; BASE_PARAMS]) -> [f64; DOF] {{\n{holding}feed_forward\n}}\n"
    );
    let text = format!("{main}{of_log}{hold}#[allow(dead_code)]\n{stand}{OF_LOG}");
    child.write("src/main.rs", &text);
    child.cargo(&["run", "--quiet"]).unwrap();
}
