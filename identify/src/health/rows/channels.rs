//! Channels that end at one value, and channels that move in coarse steps.

use std::collections::HashSet;

use sesc_model::Model;

use super::LogRows;
use super::digits::{key, step};
use super::screen::{End, LeftOut};
use crate::health::criteria::{CLIPPED_MORE, CLIPPED_SHARE, COARSE_LEVELS, COARSE_NOISE, FEW_ROWS};
use crate::health::statistics::scatter;
use crate::health::{Finding, Kind, Picture};

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
