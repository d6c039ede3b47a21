//! A fleet: on the console, and as a page.

mod page;
#[cfg(test)]
mod tests;
mod text;

pub use page::{Pages, ROBOTS, page_of_robot, pages, skeleton};
pub use text::text;

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use sesc_identify::diagnose::{self, Verdict};
use sesc_identify::fleet::summary::Summary;
use sesc_identify::fleet::{EffectFound, Failed, Fleet, Row, Twice};

use super::table::in_words;

/// What programs are told, besides the rows.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Answer<'a> {
    /// Rows of the table: robots and days.
    groups: usize,
    /// Rows that were taken from the store.
    from_store: usize,
    /// Files that could not be used.
    failed: &'a [Failed],
    /// Logs that came more than once.
    twice: &'a [Twice],
    /// What is said across robots.
    #[serde(flatten)]
    summary: &'a Summary,
}

/// What programs are told, besides the rows.
pub fn answer<'a>(fleet: &'a Fleet, summary: &'a Summary) -> Answer<'a> {
    Answer {
        groups: fleet.rows.len(),
        from_store: fleet.from_store,
        failed: &fleet.failed,
        twice: &fleet.twice,
        summary,
    }
}

/// `an offset of l_knee (joint_offset:l_knee)`
fn subject(found: &EffectFound) -> String {
    diagnose::subject(&found.effect, &found.target)
}

/// What became of a log that came twice.
fn twice(twice: &Twice) -> String {
    let what = if twice.counted_once {
        "counted once"
    } else {
        "which is of another robot or day: counted in both"
    };
    format!("{} has the bytes of {}: {what}", twice.input, twice.same_as)
}

/// Hashes of the URDFs of rows.
fn hashes<'r>(rows: impl Iterator<Item = &'r Row>) -> Vec<&'r str> {
    let all: BTreeSet<&str> = rows.map(|row| row.urdf_hash.as_str()).collect();
    all.into_iter().filter(|hash| !hash.is_empty()).collect()
}

/// The result in a line: what robots share, what changed, what failed.
fn headline(shared: usize, changes: usize, failed: usize) -> String {
    let counted = |n: usize, one: &str, several: &str| match n {
        0 => format!("no {one}"),
        1 => format!("1 {one}"),
        n => format!("{n} {several}"),
    };
    [
        counted(shared, "shared effect", "shared effects"),
        counted(changes, "change", "changes"),
        counted(failed, "log with errors", "logs with errors"),
    ]
    .join(", ")
}

/// What was found of a row, in short.
fn said(row: &Row) -> String {
    let effects = row.effects.explanation.iter().map(subject);
    let health = row.health.iter();
    let health = health.map(|f| match f.target.as_str() {
        "-" => in_words(f.kind.name()),
        target => format!("{}: {target}", in_words(f.kind.name())),
    });
    let error = row.error.iter().cloned();
    let said: Vec<String> = effects.chain(health).chain(error).collect();
    said.join("; ")
}

/// The verdict of a row; where there is none, whether it was fitted.
fn outcome(row: &Row) -> &'static str {
    match row.verdict {
        Some(verdict) => verdict.name(),
        None if row.has_result() => "fitted",
        None => "no result",
    }
}

/// How many rows have each outcome.
fn outcomes<'r>(rows: impl Iterator<Item = &'r Row>) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    rows.for_each(|row| *counts.entry(outcome(row)).or_default() += 1);
    counts
}

/// Whether nothing is missing and the data are sound, as far as it was looked for.
fn is_fine(row: &Row) -> bool {
    let is_explained = match row.verdict {
        Some(verdict) => matches!(verdict, Verdict::None | Verdict::Absorbed),
        None => row.has_result(),
    };
    is_explained && row.health.is_empty()
}
