//! What `sesc fit` writes besides the model file, from the command line.

use sesc_test_support::command::{Folder, stdout};

/// A log of the OP2 as CAD has it, read with `noise` m.
fn log(poses: u32, noise: &str) -> Folder {
    Folder::with_log(&format!(
        "--poses {poses} --range 30 --noise {noise} --seed 4"
    ))
}

#[test]
fn a_corrected_robot_and_a_page_are_written() {
    let folder = log(120, "0.0005");
    let outputs = "--urdf corrected.urdf --total-mass 3.1 --physical --report page.html";
    let json = folder.json(&format!(
        "fit op2.urdf --data log.csv --support r_sole {outputs}"
    ));
    assert_eq!(json["residuals"].as_array().unwrap().len(), 120);
    assert_eq!(json["active_bounds"].as_array().unwrap().len(), 0);
    assert_eq!(json["corrected"]["total_mass"], 3.1);
    let mass = sesc_reference::Robot::from_urdf(&folder.read("corrected.urdf")).unwrap();
    let mass: f64 = mass.links().iter().map(|link| link.mass_kg).sum();
    assert!((mass - 3.1).abs() < 1e-12, "{mass}");
    // What was fitted to the robot is CAD of the corrected one.
    let inspected = folder.json("inspect corrected.urdf --support r_sole");
    assert!(inspected["base_params"].is_u64());
    let page = folder.read("page.html");
    assert!(page.contains("On postures it never saw") && page.contains("--total-mass 3.1"));
}

#[test]
fn masses_that_cannot_be_are_refused_and_nothing_is_written() {
    let folder = log(40, "0.02");
    let before = folder.names();
    folder.refuses_each(
        "fit op2.urdf --data log.csv --prior free --urdf corrected.urdf --out model.toml
            | no URDF has the identified parameters | --physical | Nothing was written
         fit op2.urdf --data log.csv --urdf op2.urdf | is read here
         fit op2.urdf --data log.csv --total-mass 3 | --urdf
         fit op2.urdf --data log.csv --urdf corrected.urdf --total-mass 0 | --total-mass",
    );
    assert_eq!(folder.names(), before);
    let physical = "fit op2.urdf --data log.csv --prior free --physical --urdf corrected.urdf";
    assert!(folder.stdout(physical).contains("held by a bound"));
    assert!(folder.join("corrected.urdf").exists());
}

/// A log that states no noise and repeats nothing is asked for five of its postures once more,
/// by both commands; one whose postures were all reached again is not.
#[test]
fn five_postures_are_named_where_nothing_tells_the_noise() {
    let folder = log(90, "0.0005");
    // Without the two columns of deviations.
    let stated = folder.read("log.csv");
    let rows = stated
        .lines()
        .map(|row| row.rsplitn(3, ',').last().unwrap());
    let rows: Vec<&str> = rows.collect();
    folder.write("log.csv", rows.join("\n"));
    let poses = rows[1..].iter().map(|row| row.split(',').next().unwrap());
    let poses: Vec<i64> = poses.map(|pose| pose.parse().unwrap()).collect();
    let ask = |command: &str| {
        let line = format!("{command} op2.urdf --data log.csv --support r_sole");
        (folder.json(&line), stdout(&folder.run(&line)))
    };
    let named = ["fit", "diagnose"].map(|command| {
        let (json, said) = ask(command);
        let again = json["again"]["poses"].as_array().unwrap();
        let again: Vec<i64> = again.iter().map(|pose| pose.as_i64().unwrap()).collect();
        assert_eq!(again.len(), 5, "{command}");
        assert!(again.windows(2).all(|pair| pair[0] < pair[1]), "{again:?}");
        assert!(again.iter().all(|pose| poses.contains(pose)), "{again:?}");
        let list: Vec<String> = again.iter().map(i64::to_string).collect();
        let listed = format!("reach poses {} once more", list.join(", "));
        assert!(said.contains(&listed), "{said}");
        again
    });
    assert_eq!(named[0], named[1]);
    // Each posture once more after all others, a little off.
    let mut twice = rows.join("\n") + "\n";
    for (k, row) in rows[1..].iter().enumerate() {
        let (rest, y) = row.rsplit_once(',').unwrap();
        let off = 5e-4 * (7.0 * k as f64).sin();
        let y: f64 = y.parse().unwrap();
        twice += &format!("{rest},{:.6}\n", y + off);
    }
    folder.write("log.csv", twice);
    for command in ["fit", "diagnose"] {
        let (json, _) = ask(command);
        assert!(json.get("again").is_none(), "{command}: {}", json["again"]);
    }
}
