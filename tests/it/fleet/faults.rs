//! What is wrong in a fleet is named, and nothing else, by the page and by every row of the table.
//! `cargo xtask study fleet` asks about whole fleets, and of some in which nothing is hidden.

use sesc_test_support::command::{Folder, Sheet, list, number, says, texts};
use sesc_test_support::fleet::{BATCH, DRIFT, Fleet, STUCK};

use super::table::{fleet, folder, held};

#[test]
fn what_is_wrong_in_a_fleet_is_named_and_nothing_else() {
    let hidden = &Fleet::sound(11, 4, 4).with_faults(4);
    let folder = folder(hidden);
    let (table, json) = fleet(&folder, "logs", "--report fleet.html");
    assert_eq!(json["groups"], hidden.robots * hidden.days);

    // The batch, with its size and its robots.
    let [shared] = &list(&json, "/shared")[..] else {
        panic!("{:#}", json["shared"])
    };
    assert_eq!(
        (&shared["effect"], &shared["target"]),
        (&"joint_offset".into(), &BATCH.0.into())
    );
    let name = |robot: &usize| Fleet::name(*robot);
    let batch: Vec<String> = hidden.batch.iter().map(name).collect();
    assert_eq!(texts(shared, "/robots"), batch);
    let (size, std) = (number(shared, "/size"), number(shared, "/std"));
    let is_known = (size - BATCH.1).abs() < 4.0 * std && std < 0.2 * BATCH.1;
    assert!(is_known, "{size} ± {std}");

    // The drift with its first day, and the new URDF.
    let [drifts, other] = [hidden.drifts, hidden.urdf].map(Option::unwrap);
    let changes = list(&json, "/changes");
    assert_eq!(changes.len(), 2, "{changes:#?}");
    let change = |(robot, day): (usize, usize)| {
        let mut own = changes
            .iter()
            .filter(|change| change["robot"] == Fleet::name(robot));
        let own = own.next().unwrap_or_else(|| panic!("{changes:#?}"));
        assert_eq!(own["day"], day.to_string());
        own["what"].as_str().unwrap()
    };
    says(change(drifts), &[DRIFT.0]);
    change(other);

    // Whoever has something is to be looked at, and nobody else.
    let [drifts, other, stuck] = [drifts.0, other.0, hidden.stuck.unwrap()].map(Fleet::name);
    let mut reasons = list(&json, "/reasons").iter();
    let why = reasons.find(|reason| reason["robot"] == *stuck).unwrap();
    let why = why["why"].as_str().unwrap();
    // What a diagnosis makes of angles that are wrong is not the robot's.
    assert!(why.contains(STUCK) && !why.contains("It has"), "{why}");
    assert_eq!(list(&json, "/failed").len(), hidden.truncated.len());
    assert_eq!(list(&json, "/twice").len(), 1);

    // What spoils data comes first, then what changed, what is shared, the rest by name.
    let mut rest = vec![other];
    rest.extend(hidden.truncated.iter().map(|(robot, _)| name(robot)));
    rest.sort();
    let order = [vec![stuck, drifts], batch, rest].concat();
    assert_eq!(texts(&json, "/look_first"), order);
    rows_name_what_is_hidden(hidden, &table);
    the_page_says_the_same(hidden, &folder, &order);
}

/// And it loads nothing.
fn the_page_says_the_same(hidden: &Fleet, folder: &Folder, order: &[String]) {
    let page = folder.read("fleet.html");
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
        says(folder.read(link), &["href=\"../fleet.html\""]);
    }
    let share = format!("{} robots share", hidden.batch.len());
    let counted = "1 shared effect, 2 changes, 2 logs with errors";
    says(&page, &[counted, &share, "log_again.csv"]);
    let page = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for outside in ["http:", "https:", "src=", "@import", "url(", "<script src"] {
        assert!(!page.contains(outside), "{outside}");
    }
}

/// Every row: the effects, findings, errors and URDFs that were hidden in its robot on its day.
fn rows_name_what_is_hidden(hidden: &Fleet, table: &Sheet) {
    assert_eq!(table.rows.len(), hidden.robots * hidden.days);
    for row in 0..table.rows.len() {
        let field = |name: &str| table.field(row, name);
        let robot: usize = field("robot")[1..].parse().unwrap();
        let day: usize = field("day").parse().unwrap();
        let what = format!("{robot} on {day}");
        let since = |of: Option<(usize, usize)>| of.is_some_and(|(r, d)| r == robot && day >= d);
        let joint = match () {
            () if hidden.batch.contains(&robot) => Some(BATCH.0),
            () if since(hidden.drifts) => Some(DRIFT.0),
            () => None,
        };
        let targets = |of: &serde_json::Value, place: &str| -> Vec<String> {
            let all = list(of, place).iter();
            all.map(|e| e["target"].as_str().unwrap().to_string())
                .collect()
        };
        let effects = held(table, row, "effects");
        assert_eq!(
            targets(&effects, "/explanation"),
            Vec::from_iter(joint),
            "{what}"
        );
        // What is hidden is the best of all effects as the whole explanation, too.
        let scores = targets(&effects, "/scores");
        assert!(scores.len() <= 64, "{what}");
        assert!(joint.is_none_or(|joint| scores[0] == joint), "{what}");
        let stuck = (hidden.stuck == Some(robot)).then_some(STUCK);
        let found = targets(&held(table, row, "health"), "");
        assert_eq!(found, Vec::from_iter(stuck), "{what}");
        let cut = hidden.truncated.contains(&(robot, day));
        assert_eq!(!field("error").is_empty(), cut, "{what}");
        let urdfs = hidden.urdf.is_some_and(|(own, _)| own == robot);
        let said = field("sentence").contains("This robot has 2 URDFs");
        assert_eq!(said, urdfs, "{what}");
    }
}
