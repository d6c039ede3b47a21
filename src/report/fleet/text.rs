//! A fleet on the console.

use std::collections::{BTreeMap, BTreeSet};

use sesc_identify::fleet::Fleet;
use sesc_identify::fleet::summary::Summary;

use super::super::table::Table;
use super::line::outcome;
use super::{count, headline, twice};

/// Lines of a list, at most.
const LISTED: usize = 20;

/// What was found, for people.
pub fn text(fleet: &Fleet, summary: &Summary) -> String {
    let mut verdicts: BTreeMap<&str, usize> = BTreeMap::new();
    for row in &fleet.rows {
        *verdicts.entry(outcome(row)).or_default() += 1;
    }
    let mut table = Table::new(&["verdict", "rows"]);
    for (verdict, count) in verdicts {
        table.row(&[verdict.to_string(), count.to_string()]);
    }
    let robots: BTreeSet<&str> = fleet.rows.iter().map(|row| row.robot.as_str()).collect();
    let headline = headline(
        summary.shared.len(),
        summary.changes.len(),
        fleet.failed.len(),
    );
    let mut out = format!(
        "{}, {}, {} of them from the store: {headline}\n\n{table}\n",
        count(robots.len(), "robot"),
        count(fleet.rows.len(), "row"),
        fleet.from_store
    );
    if let Some(bodies) = &summary.bodies {
        out += &format!("{bodies}\n\n");
    }
    let shared = summary.shared.iter();
    let shared = shared.map(|s| format!("{} ({})", s.sentence, s.robots.join(", ")));
    let changes = summary.changes.iter();
    let changes = changes.map(|c| format!("{}, {}: {}", c.robot, c.day, c.what));
    let first = summary
        .reasons
        .iter()
        .map(|r| format!("{} (place {}): {}", r.robot, r.places_in_words(), r.why));
    let failed = fleet
        .failed
        .iter()
        .map(|failed| format!("{}: {}", failed.input, failed.error));
    for (title, lines) in [
        ("What robots share", shared.collect()),
        ("What changed", changes.collect()),
        ("Look at these first", first.collect()),
        ("Logs with errors", failed.collect()),
        (
            "Logs that came twice",
            fleet.twice.iter().map(twice).collect::<Vec<String>>(),
        ),
    ] {
        out += &list(title, &lines);
    }
    out
}

fn list(title: &str, lines: &[String]) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let mut out = format!("{title}:\n");
    for line in lines.iter().take(LISTED) {
        out += &format!("  {line}\n");
    }
    match lines.len().saturating_sub(LISTED) {
        0 => {}
        more => out += &format!("  and {more} more\n"),
    }
    out + "\n"
}
