//! What to do next stands in every answer, for people and for programs alike.

use sesc_test_support::command::{Folder, stderr, stdout};

/// Every command says it; the command of a step is one that runs.
#[test]
fn every_command_says_what_to_do_next() {
    let folder = Folder::with("op2");
    for (log, seed) in [("monday.csv", 1), ("friday.csv", 2)] {
        folder.simulate(&format!(
            "--poses 60 --noise 0.0005 --seed {seed} --out {log}"
        ));
    }
    let diagnose = "diagnose op2.urdf --data monday.csv";
    for line in [
        "demo --out demo.html",
        "inspect op2.urdf --support r_sole",
        "verify op2.urdf --support r_sole --samples 20",
        "simulate op2.urdf --support r_sole --poses 5 --out table.csv",
        "generate op2.urdf --support r_sole --out .",
        "predict op2.urdf --data monday.csv --out predicted.csv",
        "compare monday.csv friday.csv --urdf op2.urdf",
        // Nothing is missing from this log.
        diagnose,
    ] {
        let said = folder.run(line);
        let text = stdout(&said) + &stderr(&said);
        let json = folder.json(line);
        let steps = json["next_steps"].as_array().unwrap();
        assert!(!steps.is_empty(), "{line:?}");
        for step in steps {
            let first = step["what"].as_str().unwrap().split(' ').next().unwrap();
            let line = format!("next             {first}");
            assert!(text.contains(&line), "{text}");
            if let Some(command) = step["command"].as_str() {
                assert!(text.contains(command), "{text}\n{command}");
            }
        }
    }
    // A robot as simulated is compared with a later log.
    let found = folder.json(diagnose);
    assert_eq!(found["verdict"], "none", "{}", found["sentence"]);
    let command = found["next_steps"][0]["command"].as_str().unwrap();
    let later = command.replace("LATER_LOG", "friday.csv");
    let compare = "compare monday.csv friday.csv --urdf op2.urdf";
    assert_eq!(later, format!("sesc {compare}"));
    let said = folder.stdout(compare);
    assert!(said.contains("Go on with "), "{said}");
}
