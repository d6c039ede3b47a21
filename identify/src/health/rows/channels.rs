//! Channels of the readings that end at one value or move in coarse steps, that stay the same
//! while the joints move, and rows that came before.
//!
//! ```text
//! frozen     y_k = y_{k−1} = …   over a run of rows in which CAD moves the CoP by more than noise and steps
//! copied     (q, y)_k = (q, y)_i of an earlier row i, to the last digit
//! ```
//!
//! A sensor that is slower than the joints holds each reading for a few rows: a run is frozen
//! if it is several times as long as others are.
//!
//! Noise makes a reading its own. Where readings are rounded so coarsely that they meet by
//! chance, or are held while the joints move, agreement says nothing; and repeats of a
//! posture without any noise are a simulation unless noise is stated.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use sesc_model::Model;

use super::LogRows;
use super::screen::{EVERYWHERE, LeftOut, key, reading_of};
use crate::Error;
use crate::health::criteria::{FEW_ROWS, FINE, MORE_OFTEN, NEARLY_ALL, SOME_ROWS, UNKNOWN_NOISE_M};
use crate::health::view::scatter;
use crate::health::{Finding, Kind};
use crate::observations::criteria::noise::SHOWS;
use crate::observations::postures::range;

impl LogRows {
    /// What tells a row: its joints and what was read, or one of them.
    fn key(&self, row: usize, joints: bool, reading: bool) -> u64 {
        let q = if joints { self.q(row) } else { &[] };
        let read = reading_of(&self.readings()[row], self.force(row));
        key(q, if reading { read } else { &[] })
    }

    /// How many channels there are: cells, else the axes of the CoP.
    fn channels(&self) -> usize {
        if self.cells() > 0 { self.cells() } else { 2 }
    }

    /// What a channel shows in a row, N or m.
    fn value(&self, row: usize, channel: usize) -> f64 {
        reading_of(&self.readings()[row], self.force(row))[channel]
    }

    fn channel(&self, channel: usize, rows: &[usize]) -> Vec<f64> {
        rows.iter().map(|&row| self.value(row, channel)).collect()
    }
}

/// Channels of the CoP, or of the cells, that are clipped or quantised; `model` says what free
/// masses leave of a channel whose noise nobody states.
pub(super) fn saturated(
    rows: &LogRows,
    model: Option<&Model>,
    left_out: &mut LeftOut,
) -> Vec<Finding> {
    let mut found = Vec::new();
    let kept = rows.kept(left_out);
    let of_cells = rows.cells() > 0;
    for channel in 0..rows.channels() {
        let values = rows.channel(channel, &kept);
        let (name, what, scale, unit) = match of_cells {
            true => (format!("fsr_{}", channel + 1), "Load on ", 1.0, "N"),
            false => (["cop_x", "cop_y"][channel].to_string(), "", 1e3, "mm"),
        };
        let title = format!("{what}{name}, {unit}");
        let mut say = |sentence: String, most: Option<f64>| {
            let meant = |k: usize| most.is_none_or(|most| rows.value(k, channel) == most);
            let about = (Kind::ChannelSaturated, &*name, sentence);
            found.push(rows.finding(about, &title, |k| scale * rows.value(k, channel), meant));
        };
        for sign in [1.0, -1.0].into_iter().take(if of_cells { 1 } else { 2 }) {
            let signed: Vec<f64> = values.iter().map(|x| sign * x).collect();
            let Some((most, count)) = end(rows, &kept, &signed) else {
                continue;
            };
            let at = sign * most;
            let mut of = format!("{} rows", values.len());
            let mut therefore = "the cell is saturated there. The effect cell_saturation says \
                                 what is missing; check";
            if !of_cells {
                // It lies within what was found before.
                let within = left_out.within.get_or_insert(EVERYWHERE);
                within[usize::from(sign > 0.0)][channel] = at;
                of = rows.total();
                therefore = "the channel is saturated there; these rows are left out. Check";
            }
            let sentence = format!(
                "{name} ends at {:.1} {unit}, where {count} of {of} are: {therefore} its range and \
                 amplifier.",
                scale * at
            );
            say(sentence, Some(at));
        }
        let step = (!of_cells).then(|| coarse_step(rows, model, (&kept, channel, &values)));
        if let Some(step) = step.flatten() {
            let std = step / f64::sqrt(12.0);
            left_out.steps[channel] = std;
            let sentence = format!(
                "{name} moves in steps of {:.2} mm: its readings count as known to {:.2} mm. Log \
                 more digits, or check the sensor's resolution.",
                1e3 * step,
                1e3 * std
            );
            say(sentence, None);
        }
    }
    found
}

/// The largest value, and how many of the `kept` rows show exactly it, where that is an end of the
/// channel and no chance: in several postures, and many times more than the next value.
fn end(rows: &LogRows, kept: &[usize], values: &[f64]) -> Option<(f64, usize)> {
    let most = range(values.iter().copied()).1;
    let next = range(values.iter().copied().filter(|v| *v < most)).1;
    let at: Vec<usize> = (0..values.len()).filter(|&k| values[k] == most).collect();
    let beside = values.iter().filter(|v| **v == next).count();
    let postures: HashSet<u64> = at.iter().map(|&k| rows.key(kept[k], true, false)).collect();
    let least = FEW_ROWS.max((SOME_ROWS * values.len() as f64).ceil() as usize);
    let ends = at.len() >= least && at.len() > MORE_OFTEN * beside && postures.len() >= FEW_ROWS;
    // A channel that never moves is another finding.
    (ends && next.is_finite() && most != 0.0).then_some((most, at.len()))
}

/// The step that all values are multiples of, if there is one.
fn step(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    let gaps: Vec<f64> = sorted.windows(2).map(|w| w[1] - w[0]).collect();
    let least = range(gaps.iter().copied().filter(|g| *g > 1e-9)).0;
    let whole = |gap: &f64| {
        let times = gap / least;
        (times - times.round()).abs() < 0.01 * times.clamp(1.0, 10.0)
    };
    let regular = least.is_finite() && gaps.len() >= 2 && gaps.iter().all(whole);
    // Few values far apart have a step only if some of them share it.
    let shared = gaps.iter().filter(|g| **g < 1.5 * least).count();
    (regular && 4 * shared >= gaps.len() && shared >= 2).then_some(least)
}

/// The step of a channel of the CoP that is coarse: far above the noise, or with few levels. Where
/// the noise is not known, it is no more than what free masses leave less what steps are of that:
///
/// ```text
/// σ² = s² − step²/12
/// ```
fn coarse_step(
    rows: &LogRows,
    model: Option<&Model>,
    (kept, channel, values): (&[usize], usize, &[f64]),
) -> Option<f64> {
    let step = step(values)?;
    let levels = scatter(values) / step;
    let noise = rows.noise.or_else(|| {
        if levels < SHOWS {
            return Some(0.0);
        }
        let left = rows.left_by_masses(model?, kept, channel)?;
        Some((left * left - step * step / 12.0).max(0.0).sqrt())
    });
    (step > SHOWS * noise? && levels > 0.1).then_some(step)
}

/// Runs of the kept rows in which one axis of the CoP, or the cells together, stay the same while
/// CAD moves what they show: how far, m, and what they show.
fn frozen_runs(rows: &LogRows, kept: &[usize], channel: usize) -> Vec<(Range<usize>, f64, u64)> {
    let mut least = (SHOWS * rows.noise.unwrap_or(0.0)).max(UNKNOWN_NOISE_M);
    let (mut axes, mut ends) = (0..2, [0; 2]);
    let mut values: Vec<u64> = kept.iter().map(|&k| rows.key(k, false, true)).collect();
    if rows.cells() == 0 {
        axes = channel..channel + 1;
        let own = rows.channel(channel, kept);
        let (low, high) = range(own.iter().copied());
        ends = [low.to_bits(), high.to_bits()];
        least = least.max(SHOWS * step(&own).unwrap_or(0.0));
        values = own.iter().map(|x| x.to_bits()).collect();
    }
    let mut runs: Vec<Range<usize>> = Vec::new();
    for run in values.chunk_by(|a, b| a == b) {
        let start = runs.last().map_or(0, |run| run.end);
        runs.push(start..start + run.len());
    }
    let mut lengths: Vec<usize> = runs.iter().map(Range::len).collect();
    lengths.sort_unstable();
    let usual = lengths.get(lengths.len() / 2).copied().unwrap_or(0);
    let longest = FEW_ROWS.max(MORE_OFTEN * usual);
    let frozen = runs.into_iter().filter_map(|run| {
        let value = values[run.start];
        let mut others = values[..run.start].iter().chain(&values[run.end..]);
        // An end of the channel that other rows show, too, is where it is clipped.
        let clipped = ends.contains(&value) && others.any(|other| *other == value);
        let moves = |axis: usize| {
            let (low, high) = range(kept[run.clone()].iter().map(|&k| rows.cad[k][axis]));
            (high - low).powi(2)
        };
        let moved = axes.clone().map(moves).sum::<f64>().sqrt();
        // A channel that never moves is another finding.
        let is_frozen = run.len() > longest && !clipped && moved > least;
        is_frozen.then_some((run, moved, value))
    });
    frozen.collect()
}

pub(super) fn frozen(rows: &LogRows, left_out: &mut LeftOut) -> Option<Finding> {
    let n = rows.len();
    let kept = rows.kept(left_out);
    let of_cells = rows.cells() > 0;
    let mut frozen: HashSet<usize> = HashSet::new();
    let (mut runs, mut counts) = (Vec::new(), [0, 0]);
    let channels = if of_cells { 1 } else { 2 };
    for (channel, count) in counts.iter_mut().enumerate().take(channels) {
        for (run, moved, value) in frozen_runs(rows, &kept, channel) {
            frozen.extend(&kept[run.clone()]);
            left_out.frozen.insert((channel, value));
            *count += 1;
            runs.push((run, 1e3 * moved));
        }
    }
    // The first of the longest ones.
    let (run, moved) = runs.into_iter().rev().max_by_key(|(run, _)| run.len())?;
    // Target of the finding, what stays, and the axis that shows it. A stretch of both axes was
    // counted on each.
    let (target, what, axis, stretches) = match counts {
        [count, _] if of_cells => ("-", "loads of the cells stay", 0, count),
        [count, 0] => ("x", "cop_x stays", 0, count),
        [0, count] => ("y", "cop_y stays", 1, count),
        [x, y] => ("-", "CoP stays", 0, (x + y) / 2),
    };
    let about = if frozen.len() as f64 > NEARLY_ALL * n as f64 {
        left_out.frozen.clear();
        let sentence = format!(
            "In {} of {} the {what} the same to the last digit while CAD moves the CoP by up to \
             {moved:.1} mm: check that the sensor is on and that its topic is the right one.",
            frozen.len(),
            rows.total()
        );
        (Kind::CopConstant, "-", sentence)
    } else {
        let stretches = match stretches {
            0 | 1 => "one stretch".to_string(),
            several => format!("{several} stretches"),
        };
        let sentence = format!(
            "In {} ({:.0} %, {stretches}; the longest is rows {} to {}) the {what} the same to the \
             last digit while the joints move it by {moved:.1} mm: the message is stale; these \
             rows are left out. Check the sensor's driver and how its topic was recorded.",
            rows.some(frozen.len()),
            100.0 * frozen.len() as f64 / n as f64,
            rows.number(kept[run.start]),
            rows.number(kept[run.end - 1])
        );
        (Kind::CopFrozen, target, sentence)
    };
    let is_frozen = |k: usize| frozen.contains(&k);
    let title = ["CoP x, mm", "CoP y, mm"][axis];
    Some(rows.finding(about, title, |k| 1e3 * rows.readings()[k][axis], is_frozen))
}

pub(super) fn copied(rows: &LogRows, left_out: &mut LeftOut) -> Option<Finding> {
    let mut known: HashMap<u64, i64> = HashMap::new();
    let mut readings: HashSet<u64> = HashSet::new();
    let (mut copied, mut held) = (HashSet::new(), 0);
    let mut postures: HashSet<u64> = HashSet::new();
    for k in rows.kept(left_out) {
        let own = rows.key(k, true, true);
        if let Some(&pose) = known.get(&own) {
            // Without noise, repeats of one posture agree.
            if pose != rows.block.pose[k] || rows.noise.is_some_and(|noise| noise > 0.0) {
                copied.insert(k);
                postures.insert(rows.key(k, true, false));
            }
        } else {
            known.insert(own, rows.block.pose[k]);
            held += usize::from(!readings.insert(rows.key(k, false, true)));
        }
    }
    let total = rows.len() as f64;
    let enough = copied.len() >= FEW_ROWS && copied.len() as f64 >= SOME_ROWS * total;
    let chance = held as f64 > SOME_ROWS * total || is_coarse(rows);
    if !enough || chance || postures.len() < FEW_ROWS {
        return None;
    }
    left_out.copies = true;
    let sentence = format!(
        "{} of {} repeat an earlier row to the last digit: they are copies, not readings, \
         and are left out. Check how the log was put together.",
        copied.len(),
        rows.total()
    );
    let x = |k: usize| 1e3 * rows.readings()[k][0];
    let about = (Kind::RowsCopied, "-", sentence);
    Some(rows.finding(about, "CoP x, mm", x, |k| copied.contains(&k)))
}

/// Refuse a log whose rows are one row, or two, again and again: repeats without any noise of
/// so few postures tell neither noise nor masses, and a fit would take them for perfect data.
///
/// # Errors
/// Where the log `name` is such a one.
pub(super) fn check_distinct(rows: &LogRows, name: &str) -> Result<(), Error> {
    let distinct = (0..rows.len()).map(|k| rows.key(k, true, true));
    let distinct = distinct.collect::<HashSet<u64>>().len();
    let few = (1..FEW_ROWS).contains(&distinct) && rows.len() >= FEW_ROWS * distinct;
    // Of a longer log the rest may be sound.
    if rows.is_part || !few {
        return Ok(());
    }
    let what = match distinct {
        1 => "one row".to_string(),
        n => format!("{n} rows"),
    };
    let why = format!(
        "its {} rows are copies of {what}, joints and readings to the last digit; repeats \
         without any noise tell neither noise nor masses: give the readings themselves, in \
         several postures",
        rows.len()
    );
    Err(Error::log(name, None, why))
}

/// Whether readings meet by chance, for they are rounded.
fn is_coarse(rows: &LogRows) -> bool {
    let all: Vec<usize> = (0..rows.len()).collect();
    (0..rows.channels()).all(|channel| {
        let values = rows.channel(channel, &all);
        let size = match rows.noise {
            Some(noise) if rows.cells() == 0 => 20.0 * FINE * noise,
            _ => FINE * scatter(&values),
        };
        step(&values).is_some_and(|step| step > size)
    })
}
