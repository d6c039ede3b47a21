//! What programs read: the list of effects, errors as JSON, exit codes that judge.

use std::fs;

use serde_json::{Value, json};
use sesc_test_support::command::{
    Folder, ROOT, json as json_of, number, op2, refused, says, sesc, stderr, stdout, texts,
};

#[test]
fn effects_are_listed_and_explained() {
    let json = Folder::empty().json("effects");
    assert!(json["schema"].is_u64());
    let effects = json["effects"].as_array().unwrap();
    let named = |name: &str| effects.iter().find(|e| e["name"] == name).unwrap();
    let offset = named("joint_offset");
    assert_eq!(offset["target"], "joint");
    let parameter = json!({"name": "offset_rad", "unit": "rad"});
    assert_eq!(offset["parameters"][0], parameter);
    for name in "sensor_offset sensor_gain sensor_rotation sensor_drift cell_gain ground_slope \
                 payload joint_scale joint_sign joint_swap joint_compliance backlash \
                 external_force time_delay units cell_offset cell_exponent cell_saturation"
        .split_whitespace()
    {
        assert!(named(name)["sentence"].as_str().unwrap().ends_with('.'));
    }
    // In people's words, with the name of programs beside them.
    let table = stdout(&sesc(&["effects"]));
    let offset = "an offset of JOINT (joint_offset:JOINT)";
    let load = "an unknown mass on LINK (payload:LINK)";
    let slope = "a slope of the ground (ground_slope)";
    let others = [
        "(joint_swap:JOINT,JOINT)",
        "(units:degrees)",
        "backlash:JOINT",
        "Or of all.",
    ];
    says(table, &[&[offset, load, slope][..], &others].concat());
    let page = |name: &str| {
        let page = fs::read_to_string(format!("{ROOT}/docs/effects/{name}.md")).unwrap();
        page.replace("```text\n", "").replace("```\n", "")
    };
    let one = stdout(&sesc(&["effects", "backlash"]));
    let formula = "φ_j = q_j + (β/2) sign τ_j(φ)";
    says(
        &one,
        &[
            formula,
            "Parameters: width_rad (rad).",
            "joint_compliance:all",
        ],
    );
    assert!(!one.contains('|') && one.contains("─────"), "{one}");
    // What it does on the OP2 is computed, and the page of the book says the same, with tables
    // that are drawn otherwise.
    let words = |text: &str| {
        let words = text.split_whitespace();
        let words = words.filter(|word| word.contains(|c: char| !"|-─".contains(c)));
        words.collect::<Vec<_>>().join(" ")
    };
    let body = one.strip_prefix("backlash: ").unwrap();
    assert!(words(&page("backlash")).contains(&words(body)), "{one}");
    // What is no effect has a page, too.
    for name in ["mass_distribution", "cop_outliers"] {
        let said = stdout(&sesc(&["effects", name]));
        let said = said.strip_prefix(&format!("{name}: ")).unwrap();
        assert!(page(name).contains(said.trim_end()));
        let said = Folder::empty().json(&format!("effects {name}"));
        assert_eq!(said["effects"], json!([]));
        let other = &said["others"][0];
        assert_eq!(other["name"], name);
        assert!(other["sentence"].as_str().unwrap().ends_with('.'));
    }
    let words = ["no effect `backlsh`", "did you mean `backlash`?"];
    refused(&sesc(&["effects", "backlsh"]), &words);
}

/// What writes files tells programs which.
#[test]
fn commands_that_write_say_what_as_json() {
    let folder = Folder::with("op2");
    let found = folder.json("simulate op2.urdf --support r_sole --poses 5 --seed 3 --out log.csv");
    let expected = json!({
        "log": "log.csv", "sidecar": "log.csv.toml", "postures": 5, "seed": 3,
        "robot": "op2", "support": "r_sole",
    });
    for (key, value) in expected.as_object().unwrap() {
        assert_eq!(found[key], *value, "{key}");
    }
    assert!(found["schema"].is_u64());
    for changed in [true, false] {
        let found = folder.json("generate op2.urdf --support r_sole --name m --out .");
        assert!(found["schema"].is_u64());
        let file = &found["files"][0];
        assert_eq!(file["changed"], changed);
        assert!(file["file"].as_str().unwrap().ends_with("m.rs"));
    }
}

/// On stdout for programs, on stderr for people; with what is known of the place.
#[test]
fn errors_are_json_where_json_is_asked_for() {
    let folder = Folder::with("op2");
    let error = |line: &str| -> Value {
        let output = folder.run(&format!("{line} --json"));
        assert_eq!(output.status.code(), Some(2));
        // One sentence for programs, a line for each cause for people.
        let stderr = stderr(&output).replace("\n  caused by: ", ": ");
        let json = json_of(&output);
        assert!(json["schema"].is_u64());
        says(stderr, &[json["error"]["message"].as_str().unwrap()]);
        json["error"].clone()
    };
    let broken = "<robot name='a'>\n<link name='b'>\n</robot>";
    folder.write("a.urdf", broken);
    folder.write("none.csv", "pose,cop_x,cop_y\n0,1,2\n");
    let found = error("fit op2.urdf --support r_sole --data none.csv");
    assert_eq!([&found["kind"], &found["file"]], ["log", "none.csv"]);
    let found = error("compare none.toml none.toml");
    let said = found["message"].as_str().unwrap();
    assert!(said.starts_with("cannot read none.toml: "), "{said}");
    let found = error("inspect a.urdf --support b");
    assert_eq!([&found["kind"], &found["file"]], ["model", "a.urdf"]);
    assert_eq!(found["line"], 3);
    let found = error("inspect --suport x");
    assert_eq!(found["kind"], "usage");
    let said = found["message"].as_str().unwrap();
    assert!(said.contains("similar argument exists"), "{said}");
    assert!(!said.contains("For more"), "{said}");
    // Without the flag stdout is empty.
    assert!(folder.run("inspect none.urdf").stdout.is_empty());

    // A fault of a model file, of tolerances, a sidecar and `sesc.toml` has its file and line.
    folder.simulate("--poses 60 --out log.csv");
    let fit = "fit op2.urdf --support r_sole --data log.csv";
    let of_toml = "# a remark\nformat = 1\nx = [1,\n";
    let sidecar = "support = 'r_sole'\nangles = 5\n";
    for (line, file, text, place) in [
        ("compare m.toml m.toml", "m.toml", of_toml, 3),
        (&format!("{fit} --prior m.toml"), "m.toml", of_toml, 3),
        (fit, "log.csv.toml", sidecar, 2),
        (fit, "sesc.toml", "\n\nnoise = 'much'\n", 3),
        (fit, "sesc.toml", "\nnoise = 5\n", 2),
        (fit, "sesc.toml", "\nnois = 5\n", 2),
        (fit, "sesc.toml", "\n\n\n= 5\n", 4),
    ] {
        folder.write(file, text);
        let found = error(line);
        assert_eq!(found["file"], file);
        assert_eq!(found["line"], place);
        fs::remove_file(folder.join(file)).unwrap();
    }
}

/// `--fail-above` counts noise floors of the error before any correction; the answer is printed
/// all the same. A gap that an effect explains is still a gap between simulation and robot.
#[test]
fn an_error_above_the_callers_limit_is_exit_code_1() {
    let folder = Folder::with_log("--poses 120 --noise 0.0005");
    let judged = |command: &str, log: &str, floors: &str| {
        let line = format!("{command} op2.urdf --data {log} --json --fail-above {floors}");
        folder.run(&line)
    };
    for command in ["fit", "diagnose"] {
        assert_eq!(judged(command, "log.csv", "3").status.code(), Some(0));
        let failed = judged(command, "log.csv", "0.2");
        assert_eq!(failed.status.code(), Some(1), "{command}");
        says(stderr(&failed), &["more than 0.2 noise floors"]);
        assert!(number(&json_of(&failed), "/noise_floor") > 0.0);
        refused(&judged(command, "log.csv", "-1"), &["above 0"]);
    }
    folder.simulate("--poses 120 --hide joint_offset:r_knee=3deg --noise 0.0005 --out bent.csv");
    let judged = judged("diagnose", "bent.csv", "1.5");
    assert_eq!(judged.status.code(), Some(1));
    says(stderr(&judged), &["the error of the uncorrected model is"]);
    let found = json_of(&judged);
    assert_eq!(found["verdict"], "named", "{}", found["sentence"]);
    assert!(number(&found, "/final/rmse") < 1.5 * number(&found, "/noise_floor"));
}

/// A robot and logs to play with; what is not theirs stays.
#[test]
fn the_demo_keeps_samples() {
    let folder = Folder::empty();
    let demo = "demo --out demo.html --keep new/samples";
    folder.stdout(demo);
    let urdf = folder.join("new/samples/op2.urdf");
    assert_eq!(fs::read(&urdf).unwrap(), fs::read(op2()).unwrap());
    for (log, verdict) in [("clean", "none"), ("knee", "named")] {
        let files = format!("new/samples/op2.urdf --data new/samples/{log}.csv");
        let found = folder.json(&format!("diagnose {files}"));
        assert_eq!(found["verdict"], verdict, "{}", found["sentence"]);
    }
    fs::write(&urdf, "<robot/>").unwrap();
    folder.refuses(demo, &["op2.urdf", "--keep another folder"]);
    assert_eq!(fs::read(&urdf).unwrap(), b"<robot/>");
}

/// Before any log is taken, it is said which logs a robot with four feet can be used with.
#[test]
fn a_robot_with_four_feet_is_told_on_which_it_can_stand() {
    let folder = Folder::with("quadruped");
    let words = [
        "4 feet (lf_foot, rf_foot, lh_foot, rh_foot)",
        "`both_feet = true`",
        "recorded on more than two feet cannot be used",
    ];
    let output = folder.run("inspect quadruped.urdf --support lf_foot --json");
    let said: Value = serde_json::from_str(&stdout(&output)).unwrap();
    says(texts(&said, "/notes").last().unwrap(), &words);
    says(stderr(&output), &words);
    folder
        .stdout("simulate quadruped.urdf --support lf_foot --noise 0.001 --poses 3 --out log.csv");
    fs::remove_file(folder.join("log.csv.toml")).unwrap();
    for command in ["fit", "diagnose"] {
        let remedy = ["no support link", "--support LINK"];
        let line = format!("{command} quadruped.urdf --data log.csv");
        folder.refuses(&line, &[&remedy[..], &words].concat());
    }
    let two = sesc(&["inspect", &op2(), "--support", "r_sole", "--json"]);
    assert!(!stdout(&two).contains("feet"));
}
