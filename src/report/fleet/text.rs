//! A fleet on the console.

use std::collections::BTreeSet;

use sesc_identify::fleet::Fleet;
use sesc_identify::fleet::summary::Summary;
use sesc_model::text::visible;

use super::super::table::{Table, count, listed};
use super::{headline, outcomes, twice};

/// What was found, for people.
pub fn text(fleet: &Fleet, summary: &Summary, long: bool) -> String {
    let outcomes = outcomes(fleet.rows.iter()).into_iter();
    let outcomes = outcomes.map(|(verdict, count)| [verdict.to_string(), count.to_string()]);
    let table = Table::of(&["verdict", "rows"], outcomes);
    let robots: BTreeSet<&str> = fleet.rows.iter().map(|row| row.robot.as_str()).collect();
    let (shared, changes) = (summary.shared.iter(), summary.changes.iter());
    let headline = headline(shared.len(), changes.len(), fleet.failed.len());
    let mut out = format!(
        "{}, {}, {} of them from the store: {headline}\n\n{table}\n",
        count(robots.len(), "robot"),
        count(fleet.rows.len(), "row"),
        fleet.from_store
    );
    if let Some(bodies) = &summary.bodies {
        out += &format!("{bodies}\n\n");
    }
    let shared = shared.map(|s| format!("{} ({})", s.sentence, s.robots.join(", ")));
    let changes = changes.map(|c| format!("{}, {}: {}", c.robot, c.day, c.what));
    let first = summary.reasons.iter();
    let first = first.map(|r| format!("{} (place {}): {}", r.robot, r.places_in_words(), r.why));
    let failed = fleet.failed.iter();
    let failed = failed.map(|failed| format!("{}: {}", failed.input, failed.error));
    let lists: [(&str, Vec<String>); 5] = [
        ("What robots share", shared.collect()),
        ("What changed", changes.collect()),
        ("Look at these first", first.collect()),
        ("Logs with errors", failed.collect()),
        (
            "Logs that came twice",
            fleet.twice.iter().map(twice).collect(),
        ),
    ];
    for (title, lines) in lists.into_iter().filter(|(_, lines)| !lines.is_empty()) {
        // A line break of a path is no line of the report.
        let lines = lines.iter().map(|line| format!("  {}", visible(line)));
        let lines: Vec<String> = lines.collect();
        out += &format!("{title}:\n{}\n", listed(&lines, long));
    }
    out
}
