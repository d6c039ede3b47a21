//! What is wrong in a fleet is named, and nothing else, by the page and by every row of the table.
//! `cargo xtask study fleet` asks about whole fleets, and of some in which nothing is hidden.

use std::collections::BTreeSet;

use serde_json::Value;
use sesc_test_support::command::{folder, op2, sesc, stdout};
use sesc_test_support::fleet::{BATCH, DRIFT, Fleet, STUCK};

fn strings(list: &Value) -> Vec<&str> {
    let list = list.as_array().unwrap().iter();
    list.map(|text| text.as_str().unwrap()).collect()
}

#[test]
fn what_is_wrong_in_a_fleet_is_named_and_nothing_else() {
    check(&Fleet::sound(11, 4, 4).with_faults(4));
}

fn check(hidden: &Fleet) {
    let folder = folder();
    let folder = folder.path();
    hidden.write(folder).unwrap();
    let at = |name: &str| folder.join(name).display().to_string();
    let (urdf, data) = (op2(), at("logs"));
    let (out, report) = (at("fleet.csv"), at("fleet.html"));
    let output = sesc(&[
        "fleet", &urdf, "--data", &data, "--out", &out, "--report", &report, "--json",
    ]);
    let json: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(json["groups"], hidden.robots * hidden.days);

    // The batch, with its size and its robots.
    let shared = json["shared"].as_array().unwrap();
    assert_eq!(shared.len(), 1, "{shared:#?}");
    assert_eq!(shared[0]["effect"], "joint_offset", "{shared:#?}");
    assert_eq!(shared[0]["target"], BATCH.0);
    let batch: Vec<String> = hidden
        .batch
        .iter()
        .map(|robot| Fleet::name(*robot))
        .collect();
    assert_eq!(strings(&shared[0]["robots"]), batch);
    let (size, std) = (
        shared[0]["size"].as_f64().unwrap(),
        shared[0]["std"].as_f64().unwrap(),
    );
    assert!(
        (size - BATCH.1).abs() < 4.0 * std && std < 0.2 * BATCH.1,
        "{size} ± {std}"
    );

    // The drift with its first day, and the new URDF.
    let (drifts, from) = hidden.drifts.unwrap();
    let (other, since) = hidden.urdf.unwrap();
    let changes: BTreeSet<(&str, &str)> = json["changes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|change| {
            (
                change["robot"].as_str().unwrap(),
                change["day"].as_str().unwrap(),
            )
        })
        .collect();
    let name = Fleet::name;
    let (drifts, from, other, since) = (
        name(drifts),
        from.to_string(),
        name(other),
        since.to_string(),
    );
    let expected = [
        (drifts.as_str(), from.as_str()),
        (other.as_str(), since.as_str()),
    ];
    assert_eq!(changes, expected.into(), "{:#}", json["changes"]);
    let drift = json["changes"]
        .as_array()
        .unwrap()
        .iter()
        .find(|c| c["robot"] == *drifts)
        .unwrap();
    assert!(
        drift["what"].as_str().unwrap().contains(DRIFT.0),
        "{drift:#}"
    );

    // Whoever has something is to be looked at, and nobody else.
    let stuck = name(hidden.stuck.unwrap());
    let first = strings(&json["look_first"]);
    let why = json["reasons"]
        .as_array()
        .unwrap()
        .iter()
        .find(|r| r["robot"] == *stuck)
        .unwrap();
    let why = why["why"].as_str().unwrap();
    // What a diagnosis makes of angles that are wrong is not the robot's.
    assert!(why.contains(STUCK) && !why.contains("It has"), "{why}");
    assert_eq!(
        json["failed"].as_array().unwrap().len(),
        hidden.truncated.len()
    );
    assert_eq!(json["twice"].as_array().unwrap().len(), 1);

    // What spoils data comes first, then what changed, what is shared, the rest by name.
    let mut order = vec![stuck, drifts];
    order.extend(batch);
    let mut rest = vec![other];
    rest.extend(hidden.truncated.iter().map(|(robot, _)| name(*robot)));
    rest.sort();
    order.extend(rest);
    assert_eq!(first, order);
    rows_name_what_is_hidden(hidden, &out);

    // The page says the same and loads nothing.
    let page = std::fs::read_to_string(report).unwrap();
    for joint in [BATCH.0, DRIFT.0, STUCK] {
        // Named in both views of the robot, and in the sentence under them.
        assert!(page.matches(&format!(">{joint}<")).count() >= 3, "{joint}");
    }
    let listed = page.split_once("Look at these first").unwrap().1;
    let listed = listed.split_once("</table>").unwrap().0;
    let links = listed.split("href=\"").skip(1);
    let links: Vec<&str> = links.map(|link| link.split_once('"').unwrap().0).collect();
    let pages = order.iter().map(|robot| format!("fleet/{robot}.html"));
    assert_eq!(links, pages.collect::<Vec<_>>());
    for link in links {
        let own = std::fs::read_to_string(folder.join(link)).unwrap();
        assert!(own.contains("href=\"../fleet.html\""), "{link}");
    }
    let share = format!("{} robots share", hidden.batch.len());
    for text in [
        "1 shared effect, 2 changes, 2 logs with errors",
        &share,
        "log_again.csv",
    ] {
        assert!(page.contains(text), "{text}");
    }
    let page = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for outside in ["http:", "https:", "src=", "@import", "url(", "<script src"] {
        assert!(!page.contains(outside), "{outside}");
    }
}

/// Every row: the effects, findings, errors and URDFs that were hidden in its robot on its day.
fn rows_name_what_is_hidden(hidden: &Fleet, table: &str) {
    let mut reader = csv::Reader::from_path(table).unwrap();
    let header = reader.headers().unwrap().clone();
    let mut count = 0;
    for record in reader.records() {
        let record = record.unwrap();
        let field = |name: &str| &record[header.iter().position(|column| column == name).unwrap()];
        let robot: usize = field("robot")[1..].parse().unwrap();
        let day: usize = field("day").parse().unwrap();
        let since = |of: Option<(usize, usize)>| of.is_some_and(|(r, d)| r == robot && day >= d);
        let joint = match () {
            () if hidden.batch.contains(&robot) => Some(BATCH.0),
            () if since(hidden.drifts) => Some(DRIFT.0),
            () => None,
        };
        let effects: Value = serde_json::from_str(field("effects")).unwrap();
        let named: Vec<&str> = effects["explanation"]
            .as_array()
            .unwrap()
            .iter()
            .map(|e| e["target"].as_str().unwrap())
            .collect();
        assert_eq!(named, Vec::from_iter(joint), "{record:?}");
        // What is hidden is the best of all effects as the whole explanation, too.
        let scores = effects["scores"].as_array().unwrap();
        assert!(scores.len() <= 64, "{record:?}");
        if let Some(joint) = joint {
            assert_eq!(scores[0]["target"], joint, "{record:?}");
        }
        let stuck = hidden.stuck == Some(robot);
        let health: Vec<Value> = serde_json::from_str(field("health")).unwrap();
        let found: Vec<&str> = health
            .iter()
            .map(|f| f["target"].as_str().unwrap())
            .collect();
        assert_eq!(found, Vec::from_iter(stuck.then_some(STUCK)), "{record:?}");
        let cut = hidden.truncated.contains(&(robot, day));
        assert_eq!(!field("error").is_empty(), cut, "{record:?}");
        let urdfs = hidden.urdf.is_some_and(|(own, _)| own == robot);
        let said = field("sentence").contains("This robot has 2 URDFs");
        assert_eq!(said, urdfs, "{record:?}");
        count += 1;
    }
    assert_eq!(count, hidden.robots * hidden.days);
}
