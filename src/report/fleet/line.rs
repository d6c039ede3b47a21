//! A row of the table as pages have it.

use std::collections::BTreeMap;

use serde::Serialize;
use sesc_identify::diagnose::Verdict;
use sesc_identify::fleet::Row;

use super::subject;
use crate::report::table::in_words;

/// A row: verdict, worth of the data, and what was found, in short.
#[derive(Serialize)]
pub(super) struct Line {
    pub day: String,
    pub verdict: &'static str,
    pub bad: bool,
    pub postures: u64,
    pub noise_mm: Option<f64>,
    pub left_mm: Option<f64>,
    pub said: String,
}

/// A row as pages have it.
pub(super) fn line(row: &Row) -> Line {
    let effects = row.effects.explanation.iter().map(subject);
    let health = row.health.iter();
    let health = health.map(|f| match f.target.as_str() {
        "-" => in_words(f.kind.name()),
        target => format!("{}: {target}", in_words(f.kind.name())),
    });
    let error = row.error.iter().cloned();
    let said: Vec<String> = effects.chain(health).chain(error).collect();
    Line {
        day: row.day.clone(),
        verdict: outcome(row),
        bad: !is_fine(row),
        postures: row.postures,
        noise_mm: row.noise_floor.map(|x| 1e3 * x),
        left_mm: row.held_out_rmse.map(|x| 1e3 * x),
        said: said.join("; "),
    }
}

/// The verdict of a row; where there is none, whether it was fitted.
pub(super) fn outcome(row: &Row) -> &'static str {
    match row.verdict {
        Some(verdict) => verdict.name(),
        None if row.has_result() => "fitted",
        None => "no result",
    }
}

/// How many rows have each outcome.
pub(super) fn outcomes<'r>(rows: impl Iterator<Item = &'r Row>) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    rows.for_each(|row| *counts.entry(outcome(row)).or_default() += 1);
    counts
}

/// Whether nothing is missing and the data are sound, as far as it was looked for.
pub(super) fn is_fine(row: &Row) -> bool {
    let is_explained = match row.verdict {
        Some(verdict) => matches!(verdict, Verdict::None | Verdict::Absorbed),
        None => row.has_result(),
    };
    is_explained && row.health.is_empty()
}
