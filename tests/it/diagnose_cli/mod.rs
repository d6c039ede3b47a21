//! `sesc diagnose` from outside: its JSON as the contract has it, and files that
//! agree with what it says, judged by the virtual robot.

mod contract;
mod outputs;

use serde_json::Value;
use sesc_test_support::command::{Folder, list, number};
use sesc_test_support::hidden::{Effect, Hidden};
use sesc_test_support::stage::Platform;
use sesc_test_support::trial::{Choice, Trial};

/// A folder with the OP2 and `log.csv`: 100 balanced postures of it with these hidden.
fn logged(hidden: &[(Effect, &str, f64)]) -> Folder {
    let hidden = hidden.iter();
    let hidden = hidden.map(|(effect, target, size)| Hidden::new(*effect, target, &[*size]));
    logged_all(hidden.collect())
}

fn logged_all(hidden: Vec<Hidden>) -> Folder {
    let trial = Trial::of(hidden, &Choice::on(Platform::Op2), 3).unwrap();
    let folder = Folder::with("op2");
    trial.log.write(folder.path(), "log");
    folder
}

/// Diagnose with masses that are known well, unless `more` says otherwise.
fn diagnose(folder: &Folder, more: &str) -> Value {
    let prior = match more.contains("--prior") {
        true => "",
        false => "--prior tight",
    };
    folder.json(&format!("diagnose op2.urdf --data log.csv {prior} {more}"))
}

fn labels(said: &Value) -> Vec<String> {
    let step = |step: &Value| {
        let [effect, target] = ["effect", "target"].map(|key| step[key].as_str().unwrap());
        match target {
            "-" => effect.to_string(),
            target => format!("{effect}:{target}"),
        }
    };
    list(said, "/steps").iter().map(step).collect()
}

/// What to do next does not contradict itself: postures are offered where they tell something.
fn next_steps(said: &Value) {
    let mut commands = String::new();
    for step in list(said, "/next_steps") {
        for key in ["what", "why"] {
            assert!(step[key].as_str().is_some_and(|text| !text.is_empty()));
        }
        commands += step["command"].as_str().unwrap_or_default();
        commands += "\n";
    }
    let next = &said["next_postures"];
    let tells = next["experiments"][0]["splits"].as_u64().unwrap_or(0) > 0;
    let asked = commands.contains("--next") || commands.contains("NEXT_LOG");
    assert_eq!(asked, tells, "{commands}\n{next}");
    let why = next["why"].as_str().unwrap();
    assert!(!why.is_empty());
    assert!(!(why.starts_with("No experiment") && asked), "{next}");
    let file = &next["file"];
    assert!(file.is_null() || tells && file.is_string(), "{next}");
}

/// What the keys of the contract say of each other; `docs::keys` holds their types.
fn as_agreed(said: &Value) {
    let verdict = said["verdict"].as_str().unwrap();
    assert!(number(said, "/noise_floor") > 0.0 && number(said, "/final/rmse") > 0.0);
    for key in ["rmse", "rmse_x", "rmse_y"] {
        assert!(number(said, &format!("/baseline/{key}")) >= 0.0);
    }
    let bias = list(said, "/baseline/bias");
    assert!(bias.len() == 2 && bias.iter().all(Value::is_number));
    assert_eq!(said["unexplained"], verdict == "unexplained");
    next_steps(said);
    let steps = list(said, "/steps");
    for step in steps {
        let keys: Vec<&str> = step
            .as_object()
            .unwrap()
            .keys()
            .map(String::as_str)
            .collect();
        let agreed = "effect evidence function parameters remedy rmse_after rmse_before sentence \
                      site target";
        assert_eq!(keys.join(" "), agreed);
        for quantity in step["parameters"].as_object().unwrap().values() {
            assert!(number(quantity, "/value").is_finite() && number(quantity, "/std") >= 0.0);
        }
        assert!(number(step, "/rmse_after") < number(step, "/rmse_before"));
        assert!(number(step, "/evidence").is_finite());
        assert!(!step["sentence"].as_str().unwrap().is_empty());
    }
    if let Some(last) = steps.last() {
        assert_eq!(last["rmse_after"], said["final"]["rmse"]);
    }
    // Complete explanations, the reported one first.
    let groups = list(said, "/indistinguishable");
    let mut reported = labels(said);
    reported.sort_unstable();
    let mut first = groups.first().map_or(Vec::new(), |group| {
        let labels = group.as_array().unwrap().iter();
        labels
            .map(|label| label.as_str().unwrap().to_string())
            .collect()
    });
    first.sort_unstable();
    assert_eq!(first, reported);
    let count = groups.len();
    match verdict {
        "none" | "absorbed" => assert!(reported.is_empty() && count == 0),
        "named" => assert_eq!(count, 1),
        "class" => assert!(count > 1),
        "unexplained" => assert!(count <= 1),
        other => panic!("`{other}` is no verdict"),
    }
}
