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
use super::screen::{End, LeftOut, key, reading_of};
use crate::Error;
use crate::health::criteria::{
    CLIPPED_MORE, FEW_ROWS, FINE, FROZEN_LONGER, FROZEN_MOVES, HELD_SHARE, NEARLY_ALL, SHOWS,
    SOME_ROWS, UNKNOWN_NOISE_M,
};
use crate::health::wirings::scatter;
use crate::health::{Finding, Kind, Picture};
use crate::observations::postures::range;

impl LogRows {
    /// What tells a row: its joints and what was read, or one of them.
    fn key(&self, row: usize, joints: bool, reading: bool) -> u64 {
        let q = if joints { self.q(row) } else { &[] };
        let read = reading_of(&self.reading[row], self.force(row));
        key(q, if reading { read } else { &[] })
    }

    /// How many channels there are: cells, else the axes of the CoP.
    fn channels(&self) -> usize {
        if self.cells > 0 { self.cells } else { 2 }
    }

    fn channel(&self, channel: usize, rows: impl Iterator<Item = usize>) -> Vec<f64> {
        let value = |k: usize| match self.cells {
            0 => self.reading[k][channel],
            _ => self.force(k)[channel],
        };
        rows.map(value).collect()
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
    let of_cells = rows.cells > 0;
    for channel in 0..rows.channels() {
        let values = rows.channel(channel, kept.iter().copied());
        let (name, unit, scale) = match of_cells {
            true => (format!("fsr_{}", channel + 1), "N", 1.0),
            false => (["cop_x", "cop_y"][channel].to_string(), "mm", 1e3),
        };
        let load_on = if of_cells { "Load on " } else { "" };
        let mut say = |sentence: String, most: Option<f64>| {
            let row = |k: usize| rows.row(kept[k]);
            let meant = |k: usize| most.is_none_or(|most| values[k] == most);
            let title = format!("{load_on}{name}, {unit}");
            let value = |k: usize| scale * values[k];
            let picture = Picture::of(&title, values.len(), row, value, meant);
            found.push(Finding::new(Kind::ChannelSaturated, &name, sentence).showing(picture));
        };
        let uppers: &[bool] = if of_cells { &[true] } else { &[true, false] };
        for &upper in uppers {
            let sign = if upper { 1.0 } else { -1.0 };
            let signed: Vec<f64> = values.iter().map(|x| sign * x).collect();
            let Some(count) = end(rows, &kept, &signed) else {
                continue;
            };
            let at = sign * range(signed.iter().copied()).1;
            let sentence = if of_cells {
                format!(
                    "{name} ends at {at:.1} N, where {count} of {} rows are: the cell is saturated \
                     there. The effect cell_saturation says what is missing; check its range and \
                     amplifier.",
                    values.len()
                )
            } else {
                left_out.ends.push(End { channel, upper, at });
                format!(
                    "{name} ends at {:.1} mm, where {count} of {} are: the channel is saturated \
                     there; these rows are left out. Check its range and amplifier.",
                    1e3 * at,
                    rows.total()
                )
            };
            say(sentence, Some(at));
        }
        let left = || rows.left_by_masses(model?, &kept, channel);
        let step = (!of_cells).then(|| coarse_step(&values, rows.noise, left));
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

/// How many of the `kept` rows show exactly the largest value, where that is an end of the
/// channel and no chance: in several postures, and many times more than the next value.
fn end(rows: &LogRows, kept: &[usize], values: &[f64]) -> Option<usize> {
    let most = range(values.iter().copied()).1;
    let next = range(values.iter().copied().filter(|v| *v < most)).1;
    let at: Vec<usize> = (0..values.len()).filter(|&k| values[k] == most).collect();
    let beside = values.iter().filter(|v| **v == next).count();
    let postures: HashSet<u64> = at.iter().map(|&k| rows.key(kept[k], true, false)).collect();
    let least = FEW_ROWS.max((SOME_ROWS * values.len() as f64).ceil() as usize);
    let ends = at.len() >= least && at.len() > CLIPPED_MORE * beside && postures.len() >= FEW_ROWS;
    // A channel that never moves is another finding.
    (ends && next.is_finite() && most != 0.0).then_some(at.len())
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
    let above = |noise: f64| step > SHOWS * noise;
    let coarse = match noise {
        Some(noise) => above(noise),
        None if levels < SHOWS => true,
        None => left().is_some_and(|left| {
            let of_steps = step * step / 12.0;
            above((left * left - of_steps).max(0.0).sqrt())
        }),
    };
    (coarse && levels > 0.1).then_some(step)
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

pub(super) fn frozen(rows: &LogRows, left_out: &mut LeftOut) -> Option<Finding> {
    let n = rows.len();
    let kept = rows.kept(left_out);
    let mut frozen = vec![[false; 2]; n];
    let mut longest: Option<(Range<usize>, f64)> = None;
    let mut count = 0;
    for (number, channel) in Channel::all(rows, &kept).iter().enumerate() {
        for (run, moved) in channel.frozen() {
            count += 1;
            for &k in &kept[run.clone()] {
                frozen[k][number] = true;
            }
            left_out.frozen.insert((number, channel.values[run.start]));
            let known = longest.as_ref().map_or(0, |(known, _)| known.len());
            if run.len() > known {
                longest = Some((run, moved));
            }
        }
    }
    let (run, moved) = longest?;
    let (from, to) = (kept[run.start], kept[run.end - 1]);
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
    let about = if rows_frozen as f64 > NEARLY_ALL * n as f64 {
        left_out.frozen.clear();
        let sentence = format!(
            "In {rows_frozen} of {} the {what} the same to the last digit while CAD moves \
             the CoP by up to {:.1} mm: check that the sensor is on and that its topic is the \
             right one.",
            rows.total(),
            1e3 * moved
        );
        (Kind::CopConstant, "-", sentence)
    } else {
        let stretches = match stretches {
            0 | 1 => "one stretch".to_string(),
            several => format!("{several} stretches"),
        };
        let sentence = format!(
            "In {} ({:.0} %, {stretches}; the longest is rows {} to {}) the \
             {what} the same to the last digit while the joints move it by {:.1} mm: the message is \
             stale; these rows are left out. Check the sensor's driver and how its topic was recorded.",
            rows.some(rows_frozen),
            100.0 * rows_frozen as f64 / n as f64,
            rows.number[from],
            rows.number[to],
            1e3 * moved
        );
        (Kind::CopFrozen, target, sentence)
    };
    let title = ["CoP x, mm", "CoP y, mm"][axis];
    Some(rows.finding(about, title, |k| 1e3 * rows.reading[k][axis], is_frozen))
}

impl Channel {
    fn all(rows: &LogRows, kept: &[usize]) -> Vec<Channel> {
        let noise = FROZEN_MOVES * rows.noise.unwrap_or(0.0);
        let least = noise.max(UNKNOWN_NOISE_M);
        if rows.cells > 0 {
            return vec![Channel {
                values: kept.iter().map(|&k| rows.key(k, false, true)).collect(),
                cad: kept.iter().map(|&k| rows.cad[k]).collect(),
                least,
                ends: [0; 2],
            }];
        }
        let of = |axis: usize| {
            let alone = |at: [f64; 2]| [0, 1].map(|k| if k == axis { at[k] } else { 0.0 });
            let values = rows.channel(axis, kept.iter().copied());
            let (low, high) = range(values.iter().copied());
            Channel {
                least: least.max(SHOWS * step(&values).unwrap_or(0.0)),
                ends: [low.to_bits(), high.to_bits()],
                values: values.iter().map(|x| x.to_bits()).collect(),
                cad: kept.iter().map(|&k| alone(rows.cad[k])).collect(),
            }
        };
        vec![of(0), of(1)]
    }

    /// Frozen runs, and how far CAD moves the CoP in each, m.
    fn frozen(&self) -> Vec<(Range<usize>, f64)> {
        let mut runs: Vec<Range<usize>> = Vec::new();
        for run in self.values.chunk_by(|a, b| a == b) {
            let start = runs.last().map_or(0, |run| run.end);
            runs.push(start..start + run.len());
        }
        let mut lengths: Vec<usize> = runs.iter().map(Range::len).collect();
        lengths.sort_unstable();
        // A channel that never moves is another finding.
        if runs.len() < 2 {
            return Vec::new();
        }
        let longest = FEW_ROWS.max(FROZEN_LONGER * lengths[lengths.len() / 2]);
        let moved = |run: Range<usize>| {
            let [x, y] = [0, 1].map(|axis| {
                let (low, high) = range(self.cad[run.clone()].iter().map(|p| p[axis]));
                high - low
            });
            (run, x.hypot(y))
        };
        let long = |run: &Range<usize>| run.len() > longest && !self.is_clipped(run);
        let moving = runs.into_iter().filter(long).map(moved);
        moving.filter(|(_, moved)| *moved > self.least).collect()
    }

    /// Whether a run shows an end of the channel that other rows show, too.
    fn is_clipped(&self, run: &Range<usize>) -> bool {
        let value = self.values[run.start];
        let mut outside = (0..run.start).chain(run.end..self.values.len());
        self.ends.contains(&value) && outside.any(|k| self.values[k] == value)
    }
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
            if pose != rows.pose[k] || rows.noise.is_some_and(|noise| noise > 0.0) {
                copied.insert(k);
                postures.insert(rows.key(k, true, false));
            }
        } else {
            known.insert(own, rows.pose[k]);
            held += usize::from(!readings.insert(rows.key(k, false, true)));
        }
    }
    let total = rows.len() as f64;
    let enough = copied.len() >= FEW_ROWS && copied.len() as f64 >= SOME_ROWS * total;
    let chance = held as f64 > HELD_SHARE * total || is_coarse(rows);
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
    let x = |k: usize| 1e3 * rows.reading[k][0];
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
    (0..rows.channels()).all(|channel| {
        let values = rows.channel(channel, 0..rows.len());
        let size = match rows.noise {
            Some(noise) if rows.cells == 0 => 20.0 * FINE * noise,
            _ => FINE * scatter(&values),
        };
        step(&values).is_some_and(|step| step > size)
    })
}
