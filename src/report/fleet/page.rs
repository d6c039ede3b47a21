//! The page of a fleet: what robots share, what changed, what to look at first, and every row.

use std::collections::{BTreeMap, BTreeSet};

use minijinja::value::Serde;
use minijinja::{Error, context};
use serde::Serialize;
use sesc_identify::fleet::summary::Summary;
use sesc_identify::fleet::{Fleet, Row};

use super::super::html::render;
use super::{count, headline, label, twice};

/// Robots with a section of their own, at most: more would make no page that a browser opens.
const ROBOTS: usize = 2000;
/// Days of the picture, at most: the last ones.
const DAYS: usize = 31;

/// A row as the page has it.
#[derive(Serialize)]
struct Line {
    day: String,
    verdict: String,
    bad: bool,
    postures: u64,
    noise_mm: Option<f64>,
    left_mm: Option<f64>,
    said: String,
}

#[derive(Serialize)]
struct RobotSection {
    name: String,
    lines: Vec<Line>,
}

/// A robot of the picture: a mark a day.
#[derive(Serialize)]
struct Marks {
    robot: String,
    marks: Vec<(&'static str, &'static str, String)>,
}

/// The page; `command` made it.
pub fn page(fleet: &Fleet, summary: &Summary, command: &str) -> Result<String, Error> {
    let mut robots: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    for row in &fleet.rows {
        robots.entry(&row.robot).or_default().push(row);
    }
    let days: BTreeSet<&str> = fleet.rows.iter().map(|row| row.day.as_str()).collect();
    let days: Vec<&str> = days
        .iter()
        .copied()
        .skip(days.len().saturating_sub(DAYS))
        .collect();
    let sections = robots.iter().take(ROBOTS).map(|(name, rows)| RobotSection {
        name: name.to_string(),
        lines: rows.iter().map(|row| line(row)).collect(),
    });
    let picture = summary.look_first.iter().filter_map(|robot| {
        let rows = robots.get(robot.as_str())?;
        let marks = days.iter().map(|day| mark(rows, day));
        Some(Marks {
            robot: robot.clone(),
            marks: marks.collect(),
        })
    });
    let context = context! {
        headline => headline(summary.shared.len(), summary.changes.len(), fleet.failed.len()),
        robots => robots.len(),
        rows => fleet.rows.len(),
        postures => fleet.rows.iter().map(|row| row.postures).sum::<u64>(),
        of_robots => count(robots.len(), "robot"),
        shared => Serde(&summary.shared),
        changes => Serde(&summary.changes),
        reasons => Serde(&summary.reasons),
        population => Serde(summary.population.as_ref().map(|p| (p.robots, p.names.len()))),
        failed => Serde(&fleet.failed),
        twice => fleet.twice.iter().map(twice).collect::<Vec<String>>(),
        days => Serde(&days),
        picture => Serde(picture.collect::<Vec<Marks>>()),
        sections => Serde(sections.collect::<Vec<RobotSection>>()),
        command => command,
    };
    render("fleet.html", context)
}

fn line(row: &Row) -> Line {
    let effects: Vec<String> = row.effects.iter().map(label).collect();
    let health: Vec<String> = row
        .health
        .iter()
        .map(|f| format!("{} {}", f.kind.name(), f.target))
        .collect();
    let error = row.error.iter().cloned();
    let said: Vec<String> = effects.into_iter().chain(health).chain(error).collect();
    Line {
        day: row.day.clone(),
        verdict: match row.verdict.as_str() {
            "" => "no result".to_string(),
            verdict => verdict.to_string(),
        },
        bad: !matches!(row.verdict.as_str(), "none" | "absorbed"),
        postures: row.postures,
        noise_mm: row.noise_floor.map(|x| 1e3 * x),
        left_mm: row.held_out_rmse.map(|x| 1e3 * x),
        said: said.join("; "),
    }
}

/// A day of a robot: mark, class, words.
fn mark(rows: &[&Row], day: &str) -> (&'static str, &'static str, String) {
    let own: Vec<&&Row> = rows.iter().filter(|row| row.day == day).collect();
    let Some(row) = own.last() else {
        return ("", "none", "no log".to_string());
    };
    let line = line(row);
    let words = format!("{}: {}", line.verdict, line.said);
    match (
        row.verdict.as_str(),
        row.error.is_some(),
        row.health.is_empty(),
    ) {
        (_, true, _) | ("", ..) => ("×", "bad", words),
        ("unusable", ..) | (_, _, false) => ("!", "bad", words),
        ("none" | "absorbed", ..) => ("·", "fine", words),
        _ => ("●", "ok", words),
    }
}
