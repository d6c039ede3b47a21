//! What a fleet says of the next robot: its intervals hold the truth, and are shorter.

use sesc_identify::robot::Robot;
use sesc_model::Snapping;
use sesc_test_support::command::{Folder, list};
use sesc_test_support::fleet::Fleet;

use super::table::{folder, log};

/// Robots of the fleet, and those that come after it.
const ROBOTS: usize = 60;
const NEXT: usize = 12;
/// Postures of the latter.
const POSTURES: usize = 10;

/// Values and deviations of a fit.
fn fit(folder: &Folder, log: &str, prior: &str) -> Vec<(f64, f64)> {
    let json = folder.json(&format!("fit op2.urdf --data {log} {prior}"));
    let of = |p: &serde_json::Value| (p["value"].as_f64().unwrap(), p["std"].as_f64().unwrap());
    list(&json, "/parameters").iter().map(of).collect()
}

/// What the base parameters of a robot really are.
fn truth(urdf: &str) -> Vec<f64> {
    let robot = Robot::parse(urdf, "body").unwrap();
    let model = robot.model("r_sole", Snapping::default(), None).unwrap();
    model.cad_params()
}

/// Masses of links differ by 3 % and centres of mass by 1.5 mm, and CAD is only known to 10 %
/// and 5 mm: sixty robots of thirty postures tell the first of every robot that comes after
/// them, in ten postures.
#[test]
fn the_next_robot_is_known_better_by_the_fleet_and_as_well_as_is_said() {
    let all = Fleet {
        spread: Some((0.03, 0.0015)),
        postures: 30,
        ..Fleet::sound(ROBOTS + NEXT, 1, 21)
    };
    let folder = folder(&all);
    let log = |robot: usize| log((robot, 1));
    let logs: Vec<String> = (0..ROBOTS).map(log).collect();
    folder.write("fleet.txt", logs.join("\n"));
    let outputs = "--out fleet.csv --prior-out population.toml";
    let json = folder.json(&format!(
        "fleet op2.urdf --data fleet.txt --only parameters {outputs}"
    ));
    // The file and the JSON have the same numbers.
    let file = &folder.toml("population.toml")["population"];
    assert_eq!(serde_json::to_value(file).unwrap(), json["population"]);
    assert_eq!(json["population"]["robots"], ROBOTS);

    for robot in ROBOTS..ROBOTS + NEXT {
        let mut few = folder.sheet(&log(robot));
        few.rows.truncate(POSTURES);
        folder.write(&log(robot), few.to_string());
    }
    let text = folder.read("op2.urdf");
    let (mut held, mut shorter, mut nearer, mut count) = (0.0, 0.0, 0.0, 0.0);
    for robot in ROBOTS..ROBOTS + NEXT {
        let truth = truth(&all.body(&text, robot));
        let before = fit(&folder, &log(robot), "");
        let after = fit(&folder, &log(robot), "--prior population.toml");
        for ((truth, before), after) in truth.iter().zip(&before).zip(&after) {
            held += f64::from((after.0 - truth).abs() <= 1.96 * after.1);
            shorter += after.1 / before.1;
            nearer += (after.0 - truth).powi(2) - (before.0 - truth).powi(2);
            count += 1.0;
        }
    }
    assert!((0.92..=1.0).contains(&(held / count)), "{}", held / count);
    assert!(shorter / count < 0.8, "{}", shorter / count);
    assert!(nearer < 0.0);

    // Diagnoses take the same file, and nothing else does by mistake.
    let with = format!("op2.urdf --data {} --prior population.toml", log(ROBOTS));
    let found = folder.json(&format!("diagnose {with}"));
    let verdict = found["verdict"].as_str().unwrap();
    assert!(matches!(verdict, "none" | "absorbed"), "{verdict}");
    folder.refuses_each(&format!(
        "fit {with} --support l_sole | population.toml | r_sole | l_sole
         fit {with} --physical | --physical | --prior cad"
    ));
}

/// A prior of too few robots is refused, and neither table nor prior is written: four robots
/// before their logs are read, five of which one has no postures when that is known.
#[test]
fn few_robots_make_no_prior_and_no_table() {
    for (robots, words) in [(4, "logs are of 4 robots"), (5, "4 robots")] {
        let folder = folder(&Fleet::sound(robots, 1, 22));
        if robots == 5 {
            folder.write(&log((0, 1)), "cop_x,cop_y\n");
        }
        let before = folder.names();
        let outputs = "--store store --out fleet.csv --report fleet.html --prior-out prior.toml";
        let command = format!("fleet op2.urdf --data logs --only parameters {outputs}");
        folder.refuses(&command, &[words, "needs 5"]);
        // Rows that were made are kept: the next run need not make them.
        let mut now = folder.names();
        let kept = now.iter().position(|name| name == "store");
        assert_eq!(kept.is_some(), robots == 5);
        kept.map(|at| now.remove(at));
        assert_eq!(now, before);
    }
}
