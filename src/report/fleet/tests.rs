//! The page of a small fleet.

use sesc_identify::fleet::summary::summary;
use sesc_identify::fleet::{Fleet, Row};
use sesc_identify::robot::Robot;
use sesc_identify::skeleton::Skeleton;
use sesc_model::Snapping;

use super::*;
use crate::report::tests::says;

fn row(robot: &str, day: &str, effects: &str) -> Row {
    let json = format!(
        r#"{{"robot": "{robot}", "day": "{day}", "urdf_hash": "a", "support": "sole",
            "postures": 60, "independent": 60, "noise_floor": 0.00014, "held_out_rmse": 0.0002,
            "verdict": "named", "sentence": "", "effects": {{"explanation": [{effects}]}}, "health": [],
            "params": [], "std": [], "inputs": ["0"], "error": null, "version": "0"}}"#
    );
    serde_json::from_str(&json).unwrap()
}

/// An effect of one value, at this target.
fn effect(name: &str, target: &str, parameter: &str, value: f64) -> String {
    format!(
        r#"{{"effect": "{name}", "target": "{target}", "evidence": 90.0,
            "parameters": {{"{parameter}": {{"value": {value}, "std": 0.001}}}}}}"#
    )
}

fn fleet() -> Fleet {
    let offset = |value: f64| effect("joint_offset", "l_<knee>", "offset_rad", value);
    let mut fleet = Fleet::default();
    for (k, robot) in ["r1", "r<2>", "r3", "r4"].iter().enumerate() {
        let offset = offset(0.05 + 1e-4 * k as f64);
        fleet
            .rows
            .extend(["1", "2"].map(|day| row(robot, day, &offset)));
    }
    fleet
}

/// The pages of a fleet and of so many of its robots, and what the console says.
fn shown(fleet: &Fleet, drawn: Option<&Skeleton>, file: &str, most: usize) -> (Pages, String) {
    let summary = summary(&fleet.rows, None);
    let pages = pages(fleet, &summary, drawn, ("sesc fleet", file), most);
    (pages.unwrap(), text(fleet, &summary, false))
}

/// File systems have names of 255 bytes at most.
#[test]
fn pages_of_robots_with_long_names_have_short_names_of_their_own() {
    let mut fleet = Fleet::default();
    let long = "é".repeat(150);
    for robot in ["r1".to_string(), format!("{long}1"), format!("{long}2")] {
        fleet.rows.push(row(&robot, "1", ""));
    }
    let (all, _) = shown(&fleet, None, "fleet.html", ROBOTS);
    let names: Vec<&str> = all.robots.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names[0], "r1.html");
    assert!(names[1..].iter().all(|name| name.len() < 220), "{names:?}");
    assert_ne!(names[1], names[2]);
    for name in &names {
        says(&all.fleet, &[&format!("href=\"fleet/{name}\"")]);
    }
    let path = page_of_robot(std::path::Path::new("fleet.html"), &format!("{long}1"));
    assert_eq!(path.file_name().unwrap().to_str(), Some(names[1]));
}

/// `A.html` and `a.html` are one file on macOS and Windows, and so are the pages of these.
#[test]
fn pages_of_robots_that_differ_in_capitals_are_files_of_their_own() {
    let mut fleet = Fleet::default();
    let robots = ["A", "a", "Ab", "aB", "AB", "ab", "A~_1", "Robot17"];
    robots
        .iter()
        .for_each(|robot| fleet.rows.push(row(robot, "1", "")));
    let (all, _) = shown(&fleet, None, "fleet.html", ROBOTS);
    let names = all.robots.iter().map(|(name, _)| name.to_lowercase());
    let names: BTreeSet<String> = names.collect();
    assert_eq!(names.len(), robots.len(), "{names:?}");
    assert!(
        names.contains("a~_1.html") && names.contains("a.html"),
        "{names:?}"
    );
}

/// A folder's name writes no lines of its own into a report.
#[test]
fn a_line_break_of_a_path_begins_no_line() {
    let mut fleet = Fleet::default();
    let path = "l3/robot=new\\nnext   all is well/log.csv";
    let twice = format!(r#"{{"input": "{path}", "same_as": "{path}", "counted_once": true}}"#);
    let failed = format!(r#"{{"input": "{path}", "error": "no log"}}"#);
    fleet.twice.push(serde_json::from_str(&twice).unwrap());
    fleet.failed.push(serde_json::from_str(&failed).unwrap());
    let (_, text) = shown(&fleet, None, "fleet.html", ROBOTS);
    assert_eq!(text.matches("robot=new\\u{a}next").count(), 3, "{text}");
    assert!(!text.contains("\nnext   all"), "{text}");
}

#[test]
fn the_page_says_what_robots_share_and_escapes_names() {
    let fleet = fleet();
    let (all, text) = shown(&fleet, None, "my fleet.html", ROBOTS);
    let page = all.fleet;
    let shared = "4 robots share an offset of l_&lt;knee&gt; (joint_offset:l_&lt;knee&gt;)";
    says(
        &page,
        &[shared, "offset 2.87", "1 shared effect, no change"],
    );
    assert!(!page.contains("<knee>") && !page.contains("r<2>"));
    // Every robot is linked to a page of its own, whatever its name.
    let names: Vec<&str> = all.robots.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["r1.html", "r3.html", "r4.html", "r~3c2~3e.html"]);
    for name in names {
        says(&page, &[&format!("href=\"my%20fleet/{name}\"")]);
    }
    let own = &all.robots[3].1;
    let parts = [
        "<h1>r&lt;2&gt;</h1>",
        "href=\"../my%20fleet.html\"",
        "4 robots share",
        // 0.0501 rad ± 0.001 rad on both days.
        "<td>2.87 ± 0.06</td><td>2.87 ± 0.06</td>",
    ];
    says(own, &parts);
    assert!(!own.contains("<knee>") && !own.contains("r<2>"));
    says(&text, &["4 robots, 8 rows", "4 robots share"]);
}

#[test]
fn every_size_is_told_in_the_unit_that_people_read() {
    let all = [
        ("payload", "mass_kg", 0.2),
        ("external_force", "force_x_n", 1.5),
        ("time_delay", "delay_s", 0.025),
        ("joint_compliance", "stiffness_nm_per_rad", 40.0),
        ("joint_scale", "scale", 1.05),
    ];
    let all = all.map(|(name, parameter, value)| effect(name, "trunk", parameter, value));
    let mut fleet = Fleet::default();
    fleet.rows.push(row("r1", "1", &all.join(",")));
    let (pages, _) = shown(&fleet, None, "fleet.html", ROBOTS);
    let words = "mass, g|200.00 ± 1.00|force x, N|1.50 ± 0.00|delay, ms|25.00 ± 1.00|\
                 stiffness, Nm&#x2f;rad|>scale<";
    says(&pages.robots[0].1, &words.split('|').collect::<Vec<_>>());
}

/// The robot stands on the page of a robot whose last result is of its URDF, and on no other.
#[test]
fn the_page_of_a_robot_shows_what_is_suspected_on_it() {
    let urdf = include_str!("../../../robots/two_link/two_link.urdf");
    let robot = Robot::parse(urdf, "robot.urdf").unwrap();
    let model = robot.model("foot", Snapping::default(), None).unwrap();
    let drawn = Skeleton::of(&model, &robot.description, None);
    let offset = effect("joint_offset", "knee", "offset_rad", 0.05);
    let mut fleet = Fleet::default();
    for (name, hash) in [("r1", drawn.hash.as_str()), ("r2", "another")] {
        let mut own = row(name, "1", &offset);
        own.urdf_hash = hash.to_string();
        fleet.rows.push(own);
    }
    let (all, _) = shown(&fleet, Some(&drawn), "fleet.html", ROBOTS);
    let [first, second] = [&all.robots[0].1, &all.robots[1].1];
    assert_eq!(first.matches("<svg ").count(), 2);
    says(first, &["Orange: an offset of knee (joint_offset:knee)."]);
    says(
        first,
        &["<td class=\"words\">an offset of knee (joint_offset:knee)</td>"],
    );
    assert_eq!(second.matches("<svg ").count(), 0);
    for (page, hash) in [(first, drawn.hash.as_str()), (second, "another")] {
        let own = format!("<dd>hash {hash}</dd>");
        says(page, &[&own, "log with hash 0", "<pre>sesc fleet</pre>"]);
    }
    assert!(all.fleet.contains("2 logs, 1 to 1"), "{}", all.fleet);
}

#[test]
fn rows_that_were_fitted_alone_are_called_so_on_page_and_console() {
    let mut fleet = Fleet::default();
    for robot in ["r1", "r2"] {
        let mut row = row(robot, "1", "");
        row.verdict = None;
        if robot == "r1" {
            row.params = vec![0.1];
        }
        fleet.rows.push(row);
    }
    let (pages, text) = shown(&fleet, None, "fleet.html", ROBOTS);
    for told in ["fitted", "no result"] {
        assert!(text.contains(told), "{told}\n{text}");
        assert!(pages.fleet.contains(&format!("{told} on 1 day")), "{told}");
    }
}

/// A page that is not made is not linked to.
#[test]
fn robots_without_a_page_of_their_own_have_no_links() {
    let fleet = fleet();
    let (pages, _) = shown(&fleet, None, "fleet.html", 2);
    let names: Vec<&str> = pages.robots.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names.len(), 2);
    let links: Vec<&str> = pages.fleet.split("href=\"fleet/").skip(1).collect();
    assert!(!links.is_empty());
    for link in links {
        let (name, _) = link.split_once('"').unwrap();
        assert!(names.contains(&name), "{name}");
    }
    says(&pages.fleet, &["2 of them have a page of their own"]);
}

/// A row of which the data are not sound agrees with nothing, whatever its verdict.
#[test]
fn a_row_with_a_finding_is_not_fine() {
    let mut sound = row("r1", "1", "");
    sound.verdict = Some(sesc_identify::diagnose::Verdict::None);
    let mut stuck = sound.clone();
    let finding = r#"{"kind": "encoder_stuck", "target": "knee", "sentence": "It is stuck."}"#;
    stuck.health = vec![serde_json::from_str(finding).unwrap()];
    assert!(is_fine(&sound) && !is_fine(&stuck));
}
