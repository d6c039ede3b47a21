//! Which robots to look at first, and why.

use serde::Serialize;

use super::changes::{Change, ChangeKind};
use super::criteria::CLEAR;
use super::history::{History, Key, Said, label, said};
use super::shared::Shared;
use crate::diagnose::Verdict;
use crate::fleet::row::Row;

/// Why a robot is to be looked at.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Reason {
    /// The robot.
    pub robot: String,
    /// The larger, the sooner: what spoils data comes before what spoils the robot, what
    /// changes before what stays, what is the robot's own before what others share.
    pub weight: f64,
    /// Why, in sentences.
    pub why: String,
}

pub(super) fn reasons(histories: &[History], shared: &[Shared], changes: &[Change]) -> Vec<Reason> {
    let of = |history: &History| {
        let mut said: Vec<(f64, String)> = Vec::new();
        said.extend(data(history));
        for change in changes
            .iter()
            .filter(|change| change.robot == history.robot)
        {
            let weight = match change.kind {
                ChangeKind::Urdf => 1.0,
                // The finding itself is said already.
                ChangeKind::Health => 0.0,
                ChangeKind::Effect | ChangeKind::Parameter => 4.0,
            };
            said.push((weight, format!("From {} on: {}", change.day, change.what)));
        }
        let changed = |key: &Key| {
            let label = label((&key.0, &key.1));
            changes
                .iter()
                .any(|c| c.robot == history.robot && c.target == label)
        };
        for key in history.keys().into_iter().filter(|key| lasts(history, key)) {
            let group = shared.iter().find(|group| {
                (&group.effect, &group.target) == (&key.0, &key.1)
                    && group.robots.iter().any(|robot| robot == history.robot)
            });
            let name = label((&key.0, &key.1));
            match group {
                Some(group) => {
                    said.push((
                        2.0,
                        format!("It shares {name} with {} others.", group.robots.len() - 1),
                    ));
                }
                None if changed(&key) => {}
                None => said.push((3.0, format!("It has {name}, which no group shares."))),
            }
        }
        said.extend(unexplained(history));
        said.extend(errors(history));
        if said.is_empty() {
            return None;
        }
        let weight = said.iter().map(|(weight, _)| weight).sum();
        let why: Vec<String> = said.into_iter().map(|(_, why)| why).collect();
        Some(Reason {
            robot: history.robot.to_string(),
            weight,
            why: why.join(" "),
        })
    };
    let mut reasons: Vec<Reason> = histories.iter().filter_map(of).collect();
    reasons.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.robot.cmp(&b.robot)));
    reasons
}

/// Findings about the data: those of two days or more, and those of the last.
fn data(history: &History) -> Vec<(f64, String)> {
    let rows = history.with_results();
    let mut seen: Vec<(String, f64, usize, &str)> = Vec::new();
    for (at, row) in rows.iter().enumerate() {
        for finding in &row.health {
            let name = label((finding.kind.name(), &finding.target));
            let weight = if finding.kind.makes_unusable() {
                6.0
            } else {
                5.0
            };
            match seen.iter_mut().find(|(known, ..)| *known == name) {
                Some((_, _, count, _)) => *count += 1,
                None if at + 1 == rows.len() || weight > 5.0 => {
                    seen.push((name, weight, 2, &finding.sentence));
                }
                None => seen.push((name, weight, 1, &finding.sentence)),
            }
        }
    }
    let lasting = seen.into_iter().filter(|(_, _, count, _)| *count > 1);
    lasting
        .map(|(_, weight, _, sentence)| (weight, sentence.to_string()))
        .collect()
}

/// Whether an effect is on two days or more and on most since the first of them, or clear on
/// the last.
fn lasts(history: &History, key: &Key) -> bool {
    let rows: Vec<Said> = history.usable().map(|row| said(row, key)).collect();
    let is = |said: &Said| matches!(said, Said::Found(_));
    let Some(first) = rows.iter().position(is) else {
        return false;
    };
    let since = &rows[first..];
    let count = since.iter().filter(|said| is(said)).count();
    let clear = match since.last() {
        Some(Said::Found(found)) => found
            .parameters
            .values()
            .any(|size| size.value.abs() > CLEAR * size.std),
        _ => false,
    };
    (count > 1 && 2 * count >= since.len()) || clear
}

fn unexplained(history: &History) -> Option<(f64, String)> {
    let rows: Vec<&Row> = history.usable().collect();
    let count = rows
        .iter()
        .filter(|row| row.verdict == Some(Verdict::Unexplained))
        .count();
    let lasts = count > 1 && 2 * count >= rows.len();
    lasts.then(|| {
        (
            3.5,
            format!("{count} of {} days are unexplained.", rows.len()),
        )
    })
}

fn errors(history: &History) -> Option<(f64, String)> {
    let failed: Vec<&str> = history
        .rows
        .iter()
        .filter(|row| row.error.is_some())
        .map(|row| row.day.as_str())
        .collect();
    (!failed.is_empty()).then(|| (1.0, format!("Logs have errors on {}.", failed.join(", "))))
}
