//! The command line as its users meet it: contracts of the JSON, files that
//! appear whole or not at all, what the commands say.

mod answers;
mod compare;
mod defaults;
mod ignored;
mod manners;
mod model_files;
mod next;
mod pipes;
mod processors;
mod sole;
mod streams;
mod unfinished;
mod words;

use std::fs;

use serde_json::json;
use sesc_test_support::command::{Folder, ROOT, Sheet, list, number, says, sesc, stdout};
use sesc_test_support::trees::Urdf;

#[test]
fn inspect_reports_what_the_contract_says() {
    let folder = Folder::with("op2");
    let json = folder.json("inspect op2.urdf --support r_sole");
    for (place, value) in [
        ("/dof", json!(20)),
        ("/bodies", json!(21)),
        ("/full_params", json!(63)),
        ("/base_params", json!(43)),
        ("/rank", json!({"xyz": 43, "cop": 42})),
        ("/numeric_rank", json!({"xyz": 43, "cop": 42})),
        ("/rank_check", json!("agrees")),
        ("/operations/com/mul", json!(80)),
        ("/operations/com/sin_cos", json!(20)),
    ] {
        assert_eq!(json.pointer(place), Some(&value), "{place}");
    }
    assert_eq!(list(&json, "/joints").len(), 20);
    // Femtometres in f64, micrometres in f32.
    assert!(number(&json, "/rounding_bound/com/f64") < 1e-14);
    assert!(number(&json, "/rounding_bound/com/f32") < 3e-6);
    let knee = "along the axis of `l_knee` moves to its parent";
    says(json["unobservable"].to_string(), &[knee]);
    // 63 columns lose 20 joint axes, and flat CoP the height.
    assert_eq!(list(&json, "/unobservable").len(), 21);
    // The elbows are written as 1.57079633.
    assert_eq!(list(&json, "/snaps").len(), 2);
    let literal = folder.json("inspect op2.urdf --support r_sole --no-snap");
    assert_eq!(literal["snaps"], json!([]));
}

#[test]
fn verify_reports_errors_and_bounds() {
    let json = Folder::with("op2").json("verify op2.urdf --support l_sole --samples 200");
    assert_eq!(json["pass"], true);
    assert!(json["samples"].as_u64().unwrap() >= 200);
    for function in "com com_jacobian gravity_moments regressor regressor_cop cop zmp".split(' ') {
        let [error, bound] = ["worst_error", "bound"].map(|key| format!("/{key}/{function}"));
        assert!(number(&json, &error) <= number(&json, &bound), "{function}");
    }
}

#[test]
fn generate_writes_once_and_leaves_the_same_bytes_alone() {
    let folder = Folder::with("op2");
    let generate = "generate op2.urdf --support r_sole --name op2_r_sole --out new/src --functions \
        com_jacobian,com_velocity,gravity_moments,regressor,regressor_cop,regressor_full,cop,zmp";
    assert_eq!(folder.stdout(generate).trim(), "new/src/op2_r_sole.rs");
    let path = folder.join("new/src/op2_r_sole.rs");
    let shipped = fs::read_to_string(format!("{ROOT}/generated/src/op2_r_sole.rs")).unwrap();
    assert_eq!(folder.read("new/src/op2_r_sole.rs"), shipped);
    let before = fs::metadata(&path).unwrap().modified().unwrap();
    folder.stdout(generate);
    assert_eq!(fs::metadata(&path).unwrap().modified().unwrap(), before);
    let written = fs::read_dir(folder.join("new/src")).unwrap().count();
    assert_eq!(written, 1, "no leftovers");
}

/// simulate → predict: a noise-free log is what predict says, to the last digit.
#[test]
fn predict_reads_back_what_simulate_wrote() {
    let folder = Folder::with_log("--poses 50 --range 30");
    let first = folder.read("log.csv");
    folder.simulate("--poses 50 --range 30 --out log.csv");
    assert_eq!(first, folder.read("log.csv"), "same seed, same log");
    // The support comes from the sidecar.
    let predicted = Sheet::read(&folder.stdout("predict op2.urdf --data log.csv"));
    let names = ["pose", "com_x", "com_y", "com_z", "cop_x", "cop_y"];
    assert_eq!(predicted.names, names);
    assert_eq!(predicted.rows.len(), 50);
    for (row, logged) in predicted.rows.iter().zip(Sheet::read(&first).rows) {
        assert_eq!(row[4..], logged[21..]);
        // On level ground the CoP is below the CoM.
        assert_eq!(row[1..3], row[4..]);
    }
}

#[test]
fn predict_follows_gravity_supports_and_degrees() {
    let folder = Folder::empty();
    let pole = Urdf::new("pole")
        .link("foot", 2.0, "0 0 0")
        .link("top", 2.0, "0 0 0");
    let pole = pole.revolute("hip", ["foot", "top"], "0 0 1", "0 1 0", 1.0);
    folder.write("pole.urdf", pole.text());
    folder.write("a.csv", "hip,pose,support\n90,7,foot\n0,9,top\n");
    // Gravity leans 0.1 to the front: the CoP runs ahead by 0.1 m per metre of height.
    folder.write("a.toml", "gravity = [0.980665, 0.0, -9.80665]\n");
    let predicted = folder.stdout("predict pole.urdf --data a.csv --degrees");
    assert_eq!(predicted.lines().nth(1), Some("7,0,0,0.5,0.05,0"));
    assert_eq!(predicted.lines().nth(2), Some("9,0,0,-0.5,-0.05,0"));
    folder.refuses_each("predict pole.urdf --data a.csv | a.csv:2 | `hip` | --degrees");
}

#[test]
fn every_command_helps_with_an_example() {
    for command in "inspect generate verify simulate plan predict fit diagnose demo".split(' ') {
        let text = stdout(&sesc(&[command, "--help"]));
        let is_shown = |title| text.contains(&format!("{title}:\n  sesc {command}"));
        assert!(is_shown("Example") || is_shown("Examples"), "{text}");
        if ["predict", "fit", "diagnose"].contains(&command) {
            let columns = sesc::cli::columns_text();
            assert!(text.contains(&columns), "{text}");
            assert!(columns.lines().all(|line| line.chars().count() <= 98));
            // Lines are broken where a meaning is long.
            let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
            for column in sesc_identify::logs::COLUMNS {
                let names = column.names.join(", ");
                let said = format!("{names} {} {}", column.unit, column.meaning);
                assert!(words(&columns).contains(&words(&said)), "{said}");
            }
        }
    }
}

#[test]
fn the_demo_finds_what_the_paper_and_theory_say() {
    let folder = Folder::empty();
    let text = folder.stdout("demo --out demo.html");
    let number = |line: &str| -> f64 {
        let line = text.lines().find(|l| l.contains(line));
        let mut words = line.unwrap_or_else(|| panic!("{text}")).split_whitespace();
        words.find_map(|word| word.parse().ok()).unwrap()
    };
    let noisy = number("against noisy readings");
    let clean = number("against the true CoP");
    assert!((3.9..=4.02).contains(&noisy), "{text}");
    assert!((0.6..=0.85).contains(&clean), "{text}");
    let html = folder.read("demo.html");
    assert!(html.contains("<svg") && !html.contains("src=\"http"));
}
