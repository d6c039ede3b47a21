//! Channels that end at one value, and channels that move in coarse steps.
//!
//! Readings that stay the same to the last digit while the joints move: a stale message.
//!
//! ```text
//! y_k = y_{k−1} = …   over a run of rows in which CAD moves the CoP by more than noise and steps
//! ```
//!
//! A sensor that is slower than the joints holds each reading for a few rows: a run is frozen
//! if it is several times as long as others are.
//!
//! Rows that came before, once more: joints and reading agree to the last digit.
//!
//! Noise makes a reading its own. Where readings are rounded so coarsely that they meet by
//! chance, or are held while the joints move, agreement says nothing; and repeats of a
//! posture without any noise are a simulation unless noise is stated.

use std::collections::{HashMap, HashSet};

use sesc_model::Model;

use super::LogRows;
use super::screen::{End, LeftOut};
use super::screen::{key, reading_of, step};
use crate::Error;
use crate::health::criteria::{
    CLIPPED_MORE, CLIPPED_SHARE, COARSE_LEVELS, COARSE_NOISE, COPIED_SHARE, FEW_ROWS, FINE,
    FROZEN_LONGER, FROZEN_MOVES, FROZEN_MOVES_M, FROZEN_STEPS, HELD_SHARE, MOST_LOST,
};
use crate::health::wirings::scatter;
use crate::health::{Finding, Kind, Picture};
use crate::observations::postures::range;

/// Channels of the CoP, or of the cells, that are clipped or quantised; `model` says what free
/// masses leave of a channel whose noise nobody states.
pub(super) fn saturated(
    rows: &LogRows,
    model: Option<&Model>,
    left_out: &mut LeftOut,
) -> Vec<Finding> {
    let mut found = Vec::new();
    let kept = rows.kept(left_out);
    let mut say =
        |name: &str, sentence: String, shown: (&str, f64), values: &[f64], most: Option<f64>| {
            let (title, scale) = shown;
            let row = |k: usize| rows.row(kept[k]);
            let meant = |k: usize| most.is_none_or(|most| values[k] == most);
            let picture = Picture::of(title, values.len(), row, |k| scale * values[k], meant);
            found.push(Finding::new(Kind::ChannelSaturated, name, sentence).showing(picture));
        };
    for cell in 0..rows.cells {
        let loads: Vec<f64> = kept.iter().map(|&k| rows.force(k)[cell]).collect();
        let Some(count) = end(rows, &kept, &loads) else {
            continue;
        };
        let (name, most) = (format!("fsr_{}", cell + 1), largest(&loads));
        let sentence = format!(
            "{name} ends at {most:.1} N, where {count} of {} rows are: the cell is saturated \
             there. The effect cell_saturation says what is missing; check its range and \
             amplifier.",
            loads.len()
        );
        let title = format!("Load on {name}, N");
        say(&name, sentence, (&title, 1.0), &loads, Some(most));
    }
    let channels = if rows.cells > 0 { 0 } else { 2 };
    for channel in 0..channels {
        let name = ["cop_x", "cop_y"][channel];
        let title = format!("{name}, mm");
        let values: Vec<f64> = kept.iter().map(|&k| rows.reading[k][channel]).collect();
        for upper in [true, false] {
            let sign = if upper { 1.0 } else { -1.0 };
            let signed: Vec<f64> = values.iter().map(|x| sign * x).collect();
            let Some(count) = end(rows, &kept, &signed) else {
                continue;
            };
            let at = sign * largest(&signed);
            left_out.ends.push(End { channel, upper, at });
            let sentence = format!(
                "{name} ends at {:.1} mm, where {count} of {} are: the channel is saturated \
                 there; these rows are left out. Check its range and amplifier.",
                1e3 * at,
                rows.total()
            );
            say(name, sentence, (&title, 1e3), &values, Some(at));
        }
        let left = || rows.left_by_masses(model?, &kept, channel);
        if let Some(step) = coarse_step(&values, rows.noise, left) {
            let std = step / f64::sqrt(12.0);
            left_out.steps[channel] = std;
            let sentence = format!(
                "{name} moves in steps of {:.2} mm: its readings count as known to {:.2} mm. Log \
                 more digits, or check the sensor's resolution.",
                1e3 * step,
                1e3 * std
            );
            say(name, sentence, (&title, 1e3), &values, None);
        }
    }
    found
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// How many of the `kept` rows show exactly the largest value, where that is an end of the
/// channel and no chance: in several postures, and many times more than the next value.
fn end(rows: &LogRows, kept: &[usize], values: &[f64]) -> Option<usize> {
    let most = largest(values);
    let mut next = f64::NEG_INFINITY;
    for &value in values.iter().filter(|v| **v < most) {
        next = next.max(value);
    }
    let at: Vec<usize> = (0..values.len()).filter(|&k| values[k] == most).collect();
    let beside = values.iter().filter(|v| **v == next).count();
    let postures: HashSet<u64> = at.iter().map(|&k| key(rows.q(kept[k]), &[])).collect();
    let least = FEW_ROWS.max((CLIPPED_SHARE * values.len() as f64).ceil() as usize);
    let ends = at.len() >= least && at.len() > CLIPPED_MORE * beside && postures.len() >= FEW_ROWS;
    // A channel that never moves is another finding.
    (ends && next.is_finite() && most != 0.0).then_some(at.len())
}

/// The step of a channel that is coarse: far above the noise, or with few levels. Where the
/// noise is not known, it is what masses leave less what steps are of that:
///
/// ```text
/// σ² = s² − step²/12
/// ```
fn coarse_step(
    values: &[f64],
    noise: Option<f64>,
    left: impl FnOnce() -> Option<f64>,
) -> Option<f64> {
    let step = step(values)?;
    let levels = scatter(values) / step;
    let above = |noise: f64| step > COARSE_NOISE * noise;
    let coarse = match noise {
        Some(noise) => above(noise),
        None if levels < COARSE_LEVELS => true,
        None => left().is_some_and(|left| {
            let of_steps = step * step / 12.0;
            above((left * left - of_steps).max(0.0).sqrt())
        }),
    };
    let moves = levels > 0.1;
    (coarse && moves).then_some(step)
}

/// What may freeze: one axis of the CoP, or the cells together.
struct Channel {
    values: Vec<u64>,
    /// CoP by CAD of what it shows, m.
    cad: Vec<[f64; 2]>,
    /// CAD moves it by more than this in a frozen run, m.
    least: f64,
    /// Runs that show one of these are clipped.
    ends: [u64; 2],
}

/// A run of rows: the first, and one past the last.
type Run = (usize, usize);

pub(super) fn frozen(rows: &LogRows, left_out: &mut LeftOut) -> Option<Finding> {
    let n = rows.len();
    let kept = rows.kept(left_out);
    let mut frozen = vec![[false; 2]; n];
    let mut first: Option<(Run, f64)> = None;
    let mut count = 0;
    let channels = channels(rows, &kept);
    for (number, channel) in channels.iter().enumerate() {
        for (run, moved) in channel.frozen() {
            count += 1;
            for &k in &kept[run.0..run.1] {
                frozen[k][number] = true;
            }
            left_out.frozen.insert((number, channel.values[run.0]));
            if first.is_none_or(|(known, _)| run.1 - run.0 > known.1 - known.0) {
                first = Some(((kept[run.0], kept[run.1 - 1] + 1), moved));
            }
        }
    }
    let ((from, to), moved) = first?;
    let is_frozen = |k: usize| frozen[k][0] || frozen[k][1];
    let rows_frozen = (0..n).filter(|&k| is_frozen(k)).count();
    let on = |axis: usize| (0..n).filter(|&k| frozen[k][axis]).count();
    // Target of the finding, what stays, and the axis that shows it. A stretch of both axes was
    // counted on each.
    let (target, what, axis, stretches) = match (rows.cells > 0, on(0), on(1)) {
        (true, ..) => ("-", "loads of the cells stay", 0, count),
        (_, _, 0) => ("x", "cop_x stays", 0, count),
        (_, 0, _) => ("y", "cop_y stays", 1, count),
        _ => ("-", "CoP stays", 0, count / 2),
    };
    let title = ["CoP x, mm", "CoP y, mm"][axis];
    let reading = |k: usize| 1e3 * rows.reading[k][axis];
    let picture = Picture::of(title, n, |k| rows.row(k), reading, is_frozen);
    let share = 100.0 * rows_frozen as f64 / n as f64;
    if rows_frozen as f64 > MOST_LOST * n as f64 {
        left_out.frozen.clear();
        let sentence = format!(
            "In {rows_frozen} of {} the {what} the same to the last digit while CAD moves \
             the CoP by up to {:.1} mm: check that the sensor is on and that its topic is the \
             right one.",
            rows.total(),
            1e3 * moved
        );
        let finding = Finding::new(Kind::CopConstant, "-", sentence);
        return Some(finding.showing(picture));
    }
    let stretches = match stretches {
        0 | 1 => "one stretch".to_string(),
        several => format!("{several} stretches"),
    };
    let sentence = format!(
        "In {} ({share:.0} %, {stretches}; the longest is rows {} to {}) the \
         {what} the same to the last digit while the joints move it by {:.1} mm: the message is \
         stale; these rows are left out. Check the sensor's driver and how its topic was recorded.",
        rows.some(rows_frozen),
        rows.number[from],
        rows.number[to - 1],
        1e3 * moved
    );
    Some(Finding::new(Kind::CopFrozen, target, sentence).showing(picture))
}

fn channels(rows: &LogRows, kept: &[usize]) -> Vec<Channel> {
    let noise = FROZEN_MOVES * rows.noise.unwrap_or(0.0);
    let least = noise.max(FROZEN_MOVES_M);
    if rows.cells > 0 {
        let values = |&k: &usize| key(&[], &reading_of(rows.reading[k], rows.force(k)));
        return vec![Channel {
            values: kept.iter().map(values).collect(),
            cad: kept.iter().map(|&k| rows.cad[k]).collect(),
            least,
            ends: [0; 2],
        }];
    }
    let of = |axis: usize| {
        let alone = |at: [f64; 2]| [0, 1].map(|k| if k == axis { at[k] } else { 0.0 });
        let values: Vec<f64> = kept.iter().map(|&k| rows.reading[k][axis]).collect();
        let (low, high) = range(values.iter().copied());
        Channel {
            least: least.max(FROZEN_STEPS * step(&values).unwrap_or(0.0)),
            ends: [low.to_bits(), high.to_bits()],
            values: values.iter().map(|x| x.to_bits()).collect(),
            cad: kept.iter().map(|&k| alone(rows.cad[k])).collect(),
        }
    };
    vec![of(0), of(1)]
}

impl Channel {
    /// Frozen runs, and how far CAD moves the CoP in each, m.
    fn frozen(&self) -> Vec<(Run, f64)> {
        let n = self.values.len();
        let starts = (0..n).filter(|&k| k == 0 || self.values[k] != self.values[k - 1]);
        let starts: Vec<usize> = starts.collect();
        let ends = starts.iter().skip(1).copied().chain([n]);
        let runs: Vec<Run> = starts.iter().copied().zip(ends).collect();
        let mut lengths: Vec<usize> = runs.iter().map(|run| run.1 - run.0).collect();
        lengths.sort_unstable();
        // A channel that never moves is another finding.
        let Some(&typical) = lengths.get(lengths.len() / 2).filter(|_| runs.len() > 1) else {
            return Vec::new();
        };
        let longest = FEW_ROWS.max(FROZEN_LONGER * typical);
        let moved = |run: &Run| {
            let own = &self.cad[run.0..run.1];
            let [x, y] = [0, 1].map(|axis| {
                let (low, high) = range(own.iter().map(|p| p[axis]));
                high - low
            });
            x.hypot(y)
        };
        runs.into_iter()
            .filter(|run| run.1 - run.0 > longest && !self.is_clipped(run, n))
            .map(|run| (run, moved(&run)))
            .filter(|(_, moved)| *moved > self.least)
            .collect()
    }

    /// Whether a run shows an end of the channel that other rows show, too.
    fn is_clipped(&self, run: &Run, n: usize) -> bool {
        let value = self.values[run.0];
        let outside = (0..run.0).chain(run.1..n);
        self.ends.contains(&value) && outside.filter(|&k| self.values[k] == value).count() > 0
    }
}

pub(super) fn copied(rows: &LogRows, left_out: &mut LeftOut) -> Option<Finding> {
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
