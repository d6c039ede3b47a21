//! What a fleet says of the next robot: its intervals hold the truth, and are shorter.

use std::path::Path;

use serde_json::Value;
use sesc_identify::robot::Robot;
use sesc_model::Snapping;
use sesc_test_support::command::{folder, in_words, op2, refused, sesc, stdout};
use sesc_test_support::fleet::Fleet;

/// Robots of the fleet, and those that come after it.
const ROBOTS: usize = 60;
const NEXT: usize = 12;
/// Postures of the latter.
const POSTURES: usize = 10;

fn fit(log: &str, prior: &[&str]) -> Vec<(f64, f64)> {
    let urdf = op2();
    let words = [&["fit", &urdf, "--data", log, "--json"], prior].concat();
    let json: Value = serde_json::from_str(&stdout(&sesc(&words))).unwrap();
    let parameters = json["parameters"].as_array().unwrap().iter();
    parameters
        .map(|p| (p["value"].as_f64().unwrap(), p["std"].as_f64().unwrap()))
        .collect()
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
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let all = Fleet {
        spread: Some((0.03, 0.0015)),
        postures: 30,
        ..Fleet::sound(ROBOTS + NEXT, 1, 21)
    };
    all.write(folder.path()).unwrap();
    let log = |robot: usize| at(&format!("{}/log.csv", Fleet::folder(robot, 1).display()));
    let list = (0..ROBOTS).map(log).collect::<Vec<String>>().join("\n");
    std::fs::write(at("fleet.txt"), list).unwrap();
    let urdf = op2();
    let (list, out, prior) = (at("fleet.txt"), at("fleet.csv"), at("population.toml"));
    let words = in_words(
        "fleet @ --data @ --only parameters --out @ --prior-out @ --json",
        &[&urdf, &list, &out, &prior],
    );
    let json: Value = serde_json::from_str(&stdout(&sesc(&words))).unwrap();
    // The file and the JSON have the same numbers.
    let file: toml::Table = std::fs::read_to_string(&prior).unwrap().parse().unwrap();
    let file = serde_json::to_value(&file["population"]).unwrap();
    assert_eq!(file, json["population"]);
    assert_eq!(file["robots"], ROBOTS);

    for robot in ROBOTS..ROBOTS + NEXT {
        let text = std::fs::read_to_string(log(robot)).unwrap();
        let few: Vec<&str> = text.lines().take(1 + POSTURES).collect();
        std::fs::write(log(robot), few.join("\n")).unwrap();
    }
    let text = std::fs::read_to_string(&urdf).unwrap();
    let (mut held, mut shorter, mut nearer, mut by_cad, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for robot in ROBOTS..ROBOTS + NEXT {
        let truth = truth(&all.body(&text, robot));
        let before = fit(&log(robot), &[]);
        let after = fit(&log(robot), &["--prior", &prior]);
        for ((truth, before), after) in truth.iter().zip(&before).zip(&after) {
            held += f64::from((after.0 - truth).abs() <= 1.96 * after.1);
            by_cad += f64::from((before.0 - truth).abs() <= 1.96 * before.1);
            shorter += after.1 / before.1;
            nearer += (after.0 - truth).powi(2) - (before.0 - truth).powi(2);
            count += 1.0;
        }
    }
    println!(
        "intervals of 95 %: {:.1} % hold ({:.1} % by CAD's tolerances), {:.2} times as long",
        100.0 * held / count,
        100.0 * by_cad / count,
        shorter / count
    );
    assert!((0.92..=1.0).contains(&(held / count)), "{}", held / count);
    assert!(shorter / count < 0.8, "{}", shorter / count);
    assert!(nearer < 0.0);

    // Diagnoses take the same file, and nothing else does by mistake.
    let found = sesc(&[
        "diagnose",
        &urdf,
        "--data",
        &log(ROBOTS),
        "--prior",
        &prior,
        "--json",
    ]);
    let json: Value = serde_json::from_str(&stdout(&found)).unwrap();
    let verdict = json["verdict"].as_str().unwrap();
    assert!(matches!(verdict, "none" | "absorbed"), "{verdict}");
    let left = sesc(&[
        "fit",
        &urdf,
        "--data",
        &log(ROBOTS),
        "--prior",
        &prior,
        "--support",
        "l_sole",
    ]);
    refused(&left, &["population.toml", "r_sole", "l_sole"]);
    let physical = sesc(&[
        "fit",
        &urdf,
        "--data",
        &log(ROBOTS),
        "--prior",
        &prior,
        "--physical",
    ]);
    refused(&physical, &["--physical", "--prior cad"]);
}

/// A prior of too few robots is refused, and neither table nor prior is written: four robots
/// before their logs are read, five of which one has no postures when that is known.
#[test]
fn few_robots_make_no_prior_and_no_table() {
    for (robots, words) in [(4, "logs are of 4 robots"), (5, "4 robots")] {
        let folder = folder();
        let at = |name: &str| folder.path().join(name).display().to_string();
        Fleet::sound(robots, 1, 22).write(folder.path()).unwrap();
        if robots == 5 {
            let log = folder.path().join(Fleet::folder(0, 1)).join("log.csv");
            std::fs::write(log, "cop_x,cop_y\n").unwrap();
        }
        let (urdf, logs, out, prior) = (op2(), at("logs"), at("fleet.csv"), at("population.toml"));
        let (store, page) = (at("store"), at("fleet.html"));
        let command = in_words(
            "fleet @ --data @ --only parameters --store @ --out @ --report @ --prior-out @",
            &[&urdf, &logs, &store, &out, &page, &prior],
        );
        refused(&sesc(&command), &[words, "needs 5"]);
        assert!(
            [&out, &prior, &page]
                .iter()
                .all(|file| !Path::new(file).exists())
        );
        // Rows that were made are kept: the next run need not make them.
        assert_eq!(Path::new(&store).exists(), robots == 5);
    }
}
