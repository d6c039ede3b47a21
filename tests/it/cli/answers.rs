//! What programs read: the list of effects, errors as JSON, exit codes that judge.

use std::fs;

use serde_json::Value;
use sesc_test_support::command::{ROOT, folder, in_words, op2, refused, sesc, stdout, write};

#[test]
fn effects_are_listed_and_explained() {
    let json: Value = serde_json::from_str(&stdout(&sesc(&["effects", "--json"]))).unwrap();
    assert!(json["schema"].is_u64());
    let effects = json["effects"].as_array().unwrap();
    let named = |name: &str| effects.iter().find(|e| e["name"] == name).unwrap();
    let offset = named("joint_offset");
    assert_eq!(offset["target"], "joint");
    assert_eq!(
        offset["parameters"][0],
        serde_json::json!({"name": "offset_rad", "unit": "rad"})
    );
    for name in "sensor_offset sensor_gain sensor_rotation sensor_drift cell_gain ground_slope \
                 payload joint_scale joint_sign joint_swap joint_compliance backlash \
                 external_force time_delay units cell_offset cell_exponent cell_saturation"
        .split_whitespace()
    {
        assert!(named(name)["sentence"].as_str().unwrap().ends_with('.'));
    }
    let table = stdout(&sesc(&["effects"]));
    assert!(table.contains("backlash") && table.contains("joint or all"));
    let one = stdout(&sesc(&["effects", "backlash"]));
    assert!(one.contains("φ_j = q_j + (β/2) sign τ_j(φ)"), "{one}");
    assert!(one.contains("Parameters: width_rad (rad)."), "{one}");
    // What it does on the OP2 is computed, and the page of the book says the same.
    let page = std::fs::read_to_string(format!("{ROOT}/docs/effects/backlash.md")).unwrap();
    let page = page.replace("```text\n", "").replace("```\n", "");
    let body = one.strip_prefix("backlash: ").unwrap();
    // Tables are drawn otherwise.
    let words = |text: &str| {
        let words = text.split_whitespace();
        let words = words.filter(|word| word.contains(|c: char| !"|-─".contains(c)));
        words.collect::<Vec<_>>().join(" ")
    };
    assert!(
        words(&page).contains(&words(body)) && body.contains("joint_compliance:all"),
        "{one}"
    );
    assert!(!one.contains('|') && one.contains("─────"), "{one}");
    // What is no effect has a page, too.
    for name in ["mass_distribution", "cop_outliers"] {
        let said = stdout(&sesc(&["effects", name]));
        let page = std::fs::read_to_string(format!("{ROOT}/docs/effects/{name}.md")).unwrap();
        let page = page.replace("```text\n", "").replace("```\n", "");
        assert!(page.contains(said.strip_prefix(&format!("{name}: ")).unwrap().trim_end()));
        let said: Value =
            serde_json::from_str(&stdout(&sesc(&["effects", name, "--json"]))).unwrap();
        assert_eq!(said["effects"], serde_json::json!([]));
        assert_eq!(said["others"][0]["name"], name);
        assert!(
            said["others"][0]["sentence"]
                .as_str()
                .unwrap()
                .ends_with('.')
        );
    }
    refused(
        &sesc(&["effects", "backlsh"]),
        &["no effect `backlsh`", "did you mean `backlash`?"],
    );
}

/// What writes files tells programs which.
#[test]
fn commands_that_write_say_what_as_json() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let json = |arguments: &[&str]| -> Value {
        let json: Value = serde_json::from_str(&stdout(&sesc(arguments))).unwrap();
        assert!(json["schema"].is_u64());
        json
    };
    let log = at("log.csv");
    let urdf = op2();
    let simulate = "simulate @ --support r_sole --poses 5 --json --seed 3 --out @";
    let found = json(&in_words(simulate, &[&urdf, &log]));
    assert_eq!(found["log"], log);
    assert_eq!(found["sidecar"], format!("{log}.toml"));
    assert_eq!((&found["postures"], &found["seed"]), (&5.into(), &3.into()));
    assert_eq!(
        (&found["robot"], &found["support"]),
        (&"op2".into(), &"r_sole".into())
    );
    let generate = "generate @ --support r_sole --name m --json --out @";
    for changed in [true, false] {
        let found = json(&in_words(generate, &[&urdf, &at("")]));
        assert_eq!(found["files"][0]["changed"], changed);
        assert!(
            found["files"][0]["file"]
                .as_str()
                .unwrap()
                .ends_with("m.rs")
        );
    }
}

/// On stdout for programs, on stderr for people; with what is known of the place.
#[test]
fn errors_are_json_where_json_is_asked_for() {
    let error = |arguments: &[&str]| -> Value {
        let output = sesc(arguments);
        assert_eq!(output.status.code(), Some(2));
        let stderr = String::from_utf8(output.stderr).unwrap();
        // One sentence for programs, a line for each cause for people.
        let stderr = stderr.replace("\n  caused by: ", ": ");
        let json: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(json["schema"].is_u64());
        let message = json["error"]["message"].as_str().unwrap();
        assert!(stderr.contains(message), "{stderr}: {message}");
        json["error"].clone()
    };
    let folder = folder();
    let log = write(folder.path(), "log.csv", "pose,cop_x,cop_y\n0,1,2\n");
    let fit = "fit @ --support r_sole --data @ --json";
    let found = error(&in_words(fit, &[&op2(), &log]));
    assert_eq!(
        (&found["kind"], &found["file"]),
        (&"log".into(), &log.into())
    );
    let found = error(&["compare", "none.toml", "none.toml", "--json"]);
    let said = found["message"].as_str().unwrap();
    assert!(said.starts_with("cannot read none.toml: "), "{said}");
    let broken = write(
        folder.path(),
        "a.urdf",
        "<robot name='a'>\n<link name='b'>\n</robot>",
    );
    let found = error(&["inspect", &broken, "--support", "b", "--json"]);
    assert_eq!(found["kind"], "model");
    assert_eq!(
        (&found["file"], &found["line"]),
        (&broken.into(), &3.into())
    );
    let found = error(&["inspect", "--json", "--suport", "x"]);
    assert_eq!(found["kind"], "usage");
    let said = found["message"].as_str().unwrap();
    assert!(
        said.contains("similar argument exists") && !said.contains("For more"),
        "{said}"
    );
    places_in_toml(&error);
    // Without the flag stdout is empty.
    assert!(sesc(&["inspect", "none.urdf"]).stdout.is_empty());
}

/// A fault of a model file, of tolerances, of a sidecar and of `sesc.toml` has its file and line.
fn places_in_toml(error: &impl Fn(&[&str]) -> Value) {
    let folder = folder();
    let urdf = write(
        folder.path(),
        "op2.urdf",
        fs::read_to_string(op2()).unwrap(),
    );
    let log = folder.path().join("log.csv").display().to_string();
    let simulate = ["simulate", &urdf, "--support", "r_sole", "--poses", "60"];
    stdout(&sesc(&[&simulate[..], &["--out", &log]].concat()));
    let broken = "# a remark\nformat = 1\nx = [1,\n";
    let file = write(folder.path(), "m.toml", broken);
    let at = |arguments: &[&str], file: &str, line: u64| {
        let found = error(&[arguments, &["--json"]].concat());
        let place = (&found["file"], &found["line"]);
        assert_eq!(place, (&file.into(), &line.into()), "{found}");
    };
    at(&["compare", &file, &file], &file, 3);
    let fit = ["fit", &urdf, "--support", "r_sole", "--data", &log];
    at(&[&fit[..], &["--prior", &file]].concat(), &file, 3);
    let sidecar = write(
        folder.path(),
        "log.csv.toml",
        "support = 'r_sole'\nangles = 5\n",
    );
    at(&fit, &sidecar, 2);
    fs::remove_file(sidecar).unwrap();
    let settings = write(folder.path(), "sesc.toml", "\n\nnoise = 'much'\n");
    at(&fit, &settings, 3);
    write(folder.path(), "sesc.toml", "\nnoise = 5\n");
    at(&fit, &settings, 2);
    write(folder.path(), "sesc.toml", "\nnois = 5\n");
    at(&fit, &settings, 2);
    write(folder.path(), "sesc.toml", "\n\n\n= 5\n");
    at(&fit, &settings, 4);
}

/// `--fail-above` counts noise floors; the answer is printed all the same.
#[test]
fn an_error_above_the_callers_limit_is_exit_code_1() {
    let folder = folder();
    let log = folder.path().join("log.csv").display().to_string();
    let simulate = ["simulate", &op2(), "--support", "r_sole", "--poses", "120"];
    stdout(&sesc(
        &[&simulate[..], &["--noise", "0.0005", "--out", &log]].concat(),
    ));
    for command in ["fit", "diagnose"] {
        let plain = [command, &op2(), "--data", &log, "--json"];
        let at = |floors: &str| sesc(&[&plain[..], &["--fail-above", floors]].concat());
        assert_eq!(at("3").status.code(), Some(0), "{command}");
        let failed = at("0.2");
        assert_eq!(failed.status.code(), Some(1), "{command}");
        let stderr = String::from_utf8(failed.stderr).unwrap();
        assert!(stderr.contains("more than 0.2 noise floors"), "{stderr}");
        let json: Value = serde_json::from_slice(&failed.stdout).unwrap();
        assert!(json["noise_floor"].as_f64().unwrap() > 0.0);
        refused(
            &sesc(&[command, &op2(), "--data", &log, "--fail-above", "-1"]),
            &["above 0"],
        );
    }
}

/// A gap that an effect explains is still a gap between simulation and robot.
#[test]
fn a_diagnosis_is_judged_by_the_uncorrected_model() {
    let folder = folder();
    let log = folder.path().join("log.csv").display().to_string();
    let simulate = ["simulate", &op2(), "--support", "r_sole", "--poses", "120"];
    let knee = ["--hide", "joint_offset:r_knee=3deg", "--noise", "0.0005"];
    stdout(&sesc(&[&simulate[..], &knee, &["--out", &log]].concat()));
    let judged = sesc(&in_words(
        "diagnose @ --data @ --fail-above 1.5 --json",
        &[&op2(), &log],
    ));
    assert_eq!(judged.status.code(), Some(1));
    let said = String::from_utf8(judged.stderr).unwrap();
    assert!(
        said.contains("the error of the uncorrected model is"),
        "{said}"
    );
    let found: Value = serde_json::from_slice(&judged.stdout).unwrap();
    assert_eq!(found["verdict"], "named", "{}", found["sentence"]);
    let number = |place: &str| found.pointer(place).and_then(Value::as_f64).unwrap();
    assert!(number("/final/rmse") < 1.5 * number("/noise_floor"));
}

/// A robot and logs to play with; what is not theirs stays.
#[test]
fn the_demo_keeps_samples() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let (page, kept) = (at("demo.html"), at("new/samples"));
    let [page, kept] = [page, kept].map(|path| path.display().to_string());
    let demo = || sesc(&["demo", "--out", &page, "--keep", &kept]);
    stdout(&demo());
    let urdf = format!("{kept}/op2.urdf");
    assert_eq!(std::fs::read(&urdf).unwrap(), std::fs::read(op2()).unwrap());
    for (log, verdict) in [("clean.csv", "none"), ("knee.csv", "named")] {
        let log = format!("{kept}/{log}");
        let found = sesc(&["diagnose", &urdf, "--data", &log, "--json"]);
        let found: Value = serde_json::from_str(&stdout(&found)).unwrap();
        assert_eq!(found["verdict"], verdict, "{}", found["sentence"]);
    }
    std::fs::write(&urdf, "<robot/>").unwrap();
    refused(&demo(), &["op2.urdf", "--keep another folder"]);
    assert_eq!(std::fs::read(&urdf).unwrap(), b"<robot/>");
}

/// Before any log is taken, it is said which logs a robot with four feet can be used with.
#[test]
fn a_robot_with_four_feet_is_told_on_which_it_can_stand() {
    let urdf = format!("{ROOT}/robots/quadruped/quadruped.urdf");
    let words = [
        "4 feet (lf_foot, rf_foot, lh_foot, rh_foot)",
        "`both_feet = true`",
        "recorded on more than two feet cannot be used",
    ];
    let inspect = ["inspect", &urdf, "--support", "lf_foot", "--json"];
    let output = sesc(&inspect);
    let said: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let note = said["notes"].as_array().unwrap().last().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    for word in words {
        assert!(note.as_str().unwrap().contains(word), "{note}");
        assert!(stderr.contains(word), "{stderr}");
    }
    let folder = folder();
    let log = folder.path().join("log.csv").display().to_string();
    let stand = in_words("simulate @ --support lf_foot --noise 0.001", &[&urdf]);
    stdout(&sesc(
        &[&stand[..], &["--poses", "3", "--out", &log]].concat(),
    ));
    std::fs::remove_file(format!("{log}.toml")).unwrap();
    for command in ["fit", "diagnose"] {
        let output = sesc(&[command, &urdf, "--data", &log]);
        refused(
            &output,
            &[&["no support link", "--support LINK"][..], &words].concat(),
        );
    }
    let two = sesc(&["inspect", &op2(), "--support", "r_sole", "--json"]);
    assert!(!stdout(&two).contains("feet"));
}
