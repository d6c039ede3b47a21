//! What is wrong with data themselves, as pages show it.

use minijinja::{Value, context};

use super::figures;
use super::robot::Shown;
use super::table::in_words;
use sesc_identify::health::{Finding, Row};

/// The rows that figures of findings show, as postures that the page's robot can be shown in.
#[derive(Default)]
pub struct Posed<'a> {
    rows: Vec<(&'a Row, Shown)>,
}

impl<'a> Posed<'a> {
    /// Rows of every finding with a figure, each once: with all that the figures show of it.
    pub fn of(findings: &'a [Finding]) -> Posed<'a> {
        let mut posed = Posed::default();
        for picture in findings.iter().filter_map(|f| f.picture.as_ref()) {
            let mut points = picture.points.as_slice();
            for row in &picture.rows {
                let own = points.iter().take_while(|point| point.0 == row.number);
                let (own, rest) = points.split_at(own.count());
                points = rest;
                let k = posed.at(row).unwrap_or_else(|| posed.push(row));
                posed.rows[k].1.said.push(figures::said(picture, own));
            }
        }
        posed
    }

    /// Which of them a row is.
    pub fn at(&self, row: &Row) -> Option<usize> {
        self.rows.iter().position(|(known, _)| *known == row)
    }

    fn push(&mut self, row: &'a Row) -> usize {
        let shown = Shown {
            pose: row.pose,
            q: row.q.clone(),
            row: Some(format!("row {}", row.number)),
            ..Shown::default()
        };
        self.rows.push((row, shown));
        self.rows.len() - 1
    }

    /// How the robot stood in them.
    pub fn shown(self) -> Vec<Shown> {
        self.rows.into_iter().map(|(_, shown)| shown).collect()
    }
}

/// A finding each: its kind in words, target, sentence and figure. `first` is the number that the
/// page gives the first of their rows, where it has a robot to show in them.
pub fn rows(findings: &[Finding], first: Option<usize>) -> Vec<Value> {
    let posed = Posed::of(findings);
    let number = |row: &Row| Some(first? + posed.at(row)?);
    let row = |finding: &Finding| {
        context! {
            kind => in_words(finding.kind.name()),
            target => &finding.target,
            sentence => &finding.sentence,
            figure => finding.picture.as_ref().map(|picture| {
                Value::from_safe_string(figures::health(picture, number))
            }),
        }
    };
    findings.iter().map(row).collect()
}
