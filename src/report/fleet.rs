//! A fleet on the console.

use std::collections::BTreeMap;

use sesc_identify::fleet::Fleet;

use super::table::Table;

/// Logs that are listed, at most.
const LISTED: usize = 20;

/// What was found, for people.
pub fn text(fleet: &Fleet) -> String {
    let mut verdicts: BTreeMap<&str, usize> = BTreeMap::new();
    for row in &fleet.rows {
        let verdict = match row.verdict.as_str() {
            "" => "no result",
            verdict => verdict,
        };
        *verdicts.entry(verdict).or_default() += 1;
    }
    let mut table = Table::new(&["verdict", "rows"]);
    for (verdict, count) in verdicts {
        table.row(&[verdict.to_string(), count.to_string()]);
    }
    let robots: std::collections::BTreeSet<&str> =
        fleet.rows.iter().map(|row| row.robot.as_str()).collect();
    let mut out = format!(
        "{} robots, {} rows, {} of them from the store\n\n{table}\n",
        robots.len(),
        fleet.rows.len(),
        fleet.from_store
    );
    let mut list = |title: &str, lines: Vec<String>| {
        if lines.is_empty() {
            return;
        }
        out += &format!("{title}:\n");
        for line in lines.iter().take(LISTED) {
            out += &format!("  {line}\n");
        }
        match lines.len().saturating_sub(LISTED) {
            0 => {}
            more => out += &format!("  and {more} more\n"),
        }
    };
    let failed = fleet
        .failed
        .iter()
        .map(|failed| format!("{}: {}", failed.input, failed.error));
    list("Logs with errors", failed.collect());
    let twice = fleet.twice.iter().map(|twice| {
        let what = match twice.counted_once {
            true => "counted once",
            false => "which is of another robot or day: counted in both",
        };
        format!("{} has the bytes of {}: {what}", twice.input, twice.same_as)
    });
    list("Logs that came twice", twice.collect());
    out
}
