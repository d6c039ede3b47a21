//! Rows that came before, once more: joints and reading agree to the last digit.
//!
//! Noise makes a reading its own. Where readings are rounded so coarsely that they meet by
//! chance, or are held while the joints move, agreement says nothing; and repeats of a
//! posture without any noise are a simulation unless noise is stated.

use std::collections::{HashMap, HashSet};

use super::LogRows;
use super::digits::{key, reading_of, step};
use super::screen::LeftOut;
use crate::Error;
use crate::health::criteria::{COPIED_SHARE, FEW_ROWS, FINE, HELD_SHARE};
use crate::health::statistics::scatter;
use crate::health::{Finding, Kind, Picture};

pub(super) fn of(rows: &LogRows, left_out: &mut LeftOut) -> Option<Finding> {
    let mut known: HashMap<u64, i64> = HashMap::new();
    let mut readings: HashSet<u64> = HashSet::new();
    let (mut copied, mut held) = (Vec::new(), 0);
    let mut postures: HashSet<u64> = HashSet::new();
    for k in rows.kept(left_out) {
        let reading = reading_of(rows.reading[k], rows.force(k));
        let (own, alone) = (key(rows.q(k), &reading), key(&[], &reading));
        match known.get(&own) {
            Some(&pose) => {
                // Without noise, repeats of one posture agree.
                if pose != rows.pose[k] || rows.noise.is_some_and(|noise| noise > 0.0) {
                    copied.push(k);
                    postures.insert(key(rows.q(k), &[]));
                }
            }
            None => {
                known.insert(own, rows.pose[k]);
                held += usize::from(!readings.insert(alone));
            }
        }
    }
    let total = rows.len() as f64;
    let enough = copied.len() >= FEW_ROWS && copied.len() as f64 >= COPIED_SHARE * total;
    let chance = held as f64 > HELD_SHARE * total || is_coarse(rows);
    if !enough || chance || postures.len() < FEW_ROWS {
        return None;
    }
    left_out.copies = true;
    let finding = Finding::new(
        Kind::RowsCopied,
        "-",
        format!(
            "{} of {} repeat an earlier row to the last digit: they are copies, not readings, \
             and are left out. Check how the log was put together.",
            copied.len(),
            rows.total()
        ),
    );
    let copied: HashSet<usize> = copied.into_iter().collect();
    let x = |k: usize| 1e3 * rows.reading[k][0];
    let meant = |k: usize| copied.contains(&k);
    let picture = Picture::of("CoP x, mm", rows.len(), |k| rows.row(k), x, meant);
    Some(finding.showing(picture))
}

/// Refuse a log whose rows are one row, or two, again and again: repeats without any noise of
/// so few postures tell neither noise nor masses, and a fit would take them for perfect data.
///
/// # Errors
/// Where the log `name` is such a one.
pub(super) fn check_distinct(rows: &LogRows, name: &str) -> Result<(), Error> {
    // Of a longer log the rest may be sound.
    if rows.is_part {
        return Ok(());
    }
    let of = |k: usize| key(rows.q(k), &reading_of(rows.reading[k], rows.force(k)));
    let distinct: HashSet<u64> = (0..rows.len()).map(of).collect();
    let distinct = distinct.len();
    if distinct == 0 || distinct >= FEW_ROWS || rows.len() < FEW_ROWS * distinct {
        return Ok(());
    }
    let what = match distinct {
        1 => "one row".to_string(),
        n => format!("{n} rows"),
    };
    Err(Error::log(
        name,
        None,
        format!(
            "its {} rows are copies of {what}, joints and readings to the last digit; repeats \
             without any noise tell neither noise nor masses: give the readings themselves, in \
             several postures",
            rows.len()
        ),
    ))
}

/// Whether readings meet by chance, for they are rounded.
fn is_coarse(rows: &LogRows) -> bool {
    let channels: Vec<Vec<f64>> = match rows.cells {
        0 => (0..2)
            .map(|c| rows.reading.iter().map(|y| y[c]).collect())
            .collect(),
        cells => (0..cells)
            .map(|c| (0..rows.len()).map(|k| rows.force(k)[c]).collect())
            .collect(),
    };
    channels.iter().all(|values| {
        let size = match rows.noise {
            Some(noise) if rows.cells == 0 => 20.0 * FINE * noise,
            _ => FINE * scatter(values),
        };
        step(values).is_some_and(|step| step > size)
    })
}
