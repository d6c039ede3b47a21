//! The page of one robot of a fleet: why it is looked at, and what its rows say day by day.

use minijinja::value::Serde;
use minijinja::{Error, context};
use serde::Serialize;
use sesc_identify::fleet::Row;
use sesc_identify::fleet::summary::Summary;
use sesc_identify::skeleton::Skeleton;
use sesc_model::effects::Unit;

use super::super::html::render;
use super::super::origin::Origin;
use super::line::{Line, line};
use super::picture::of_robot;
use super::{hashes, subject};

/// An effect with its size on every day.
#[derive(Serialize)]
struct Course {
    effect: String,
    parameter: String,
    days: Vec<Option<(f64, f64)>>,
}

/// The page of the robot `name`; it stands in a folder beside the page `fleet`. `drawn` is the
/// robot of the fleet.
pub(super) fn robot_page(
    name: &str,
    rows: &[&Row],
    summary: &Summary,
    drawn: Option<&Skeleton>,
    (fleet, command): (&str, &str),
) -> Result<String, Error> {
    let reason = summary.reasons.iter().find(|reason| reason.robot == name);
    let shared = summary.shared.iter();
    let shared = shared.filter(|shared| shared.robots.iter().any(|robot| robot == name));
    let shared: Vec<&str> = shared.map(|shared| shared.sentence.as_str()).collect();
    let changes = summary.changes.iter().filter(|c| c.robot == name);
    let changes: Vec<_> = changes.collect();
    let last = rows.iter().rev().find(|row| row.has_result());
    let context = context! {
        robot => drawn.and_then(|drawn| of_robot(rows, drawn)),
        name => name,
        fleet => fleet,
        why => reason.map(|reason| reason.why.as_str()),
        shared => Serde(shared),
        changes => Serde(changes),
        lines => Serde(rows.iter().map(|row| line(row)).collect::<Vec<Line>>()),
        courses => Serde(courses(rows)),
        days => Serde(rows.iter().map(|row| &row.day).collect::<Vec<&String>>()),
        last => Serde(last.map(|row| (&row.day, &row.sentence))),
        hashes => Serde(hashes(rows.iter().copied())),
        logs => Serde(rows.iter().map(|row| (&row.day, &row.inputs)).collect::<Vec<_>>()),
        origin => Origin { command, ..Origin::default() }.context(),
    };
    render("fleet_robot.html", context)
}

/// Every parameter of every effect, in the unit in which people read it.
fn courses(rows: &[&Row]) -> Vec<Course> {
    let mut found: Vec<Course> = Vec::new();
    for (day, row) in rows.iter().enumerate() {
        for effect in &row.effects.explanation {
            for (parameter, size) in &effect.parameters {
                let (factor, unit) = Unit::of(parameter).shown();
                let stem = Unit::stem(parameter);
                let shown = match unit {
                    "" => stem,
                    unit => format!("{stem}, {unit}"),
                };
                let name = subject(effect);
                let is_it = |course: &Course| course.effect == name && course.parameter == shown;
                let at = found.iter().position(is_it).unwrap_or_else(|| {
                    found.push(Course {
                        effect: name.clone(),
                        parameter: shown.clone(),
                        days: vec![None; rows.len()],
                    });
                    found.len() - 1
                });
                found[at].days[day] = Some((factor * size.value, factor * size.std));
            }
        }
    }
    found
}
