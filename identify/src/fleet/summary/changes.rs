//! What changed in a robot between its days, and is more than chance.
//!
//! A number x_d with deviation s_d on each of D days is split at every day:
//!
//! ```text
//! z_k = (x̄_{≥k} − x̄_{<k}) / √(var x̄_{≥k} + var x̄_{<k})      x̄: weighted by 1/s²
//! ```
//!
//! The chance of the largest |z_k| is at most that of one, times D − 1 days, the numbers of a
//! robot and the robots of the fleet (Bonferroni); below [`FALSE_ALARM`] it is a change. Two
//! kinds of numbers are looked at, each with half of that: base parameters as fitted without
//! effects, and sizes of effects. On days on which an effect is in no explanation it is
//! 0 ± [`UNSEEN`] of its deviations, since a smaller one would hardly be seen.
//!
//! The days before a change and those from it on are split again in the same way (binary
//! segmentation), unless a straight line explains them: a drift is one change. Each time the
//! chance counts twice as many numbers, so that a robot with a change gets a second one by
//! chance no more often than a sound robot gets its first.
//!
//! Deviations are widened by what the days of the whole fleet scatter: by the median of the
//! squared differences between neighbouring days, parameter by parameter.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF as _, StudentsT};

use super::criteria::FALSE_ALARM;
use super::criteria::changes::{DIFFERENCES, HYPOTHESES, LEAST_FREEDOM, ONSET, UNSEEN};
use super::history::{History, Key, Said, label, principal, said};
use super::shared::one_in;
use crate::diagnose::words::{NamedValue, named};
use crate::fleet::row::{Row, Size, by_number};

/// Median of the square of a standard normal number.
const MEDIAN_OF_SQUARES: f64 = 0.454_936;

/// What kind of thing changed; its name in JSON is in small letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum ChangeKind {
    /// The size of an effect.
    Effect,
    /// A base parameter that no effect is named for.
    Parameter,
    /// A finding about the data.
    Health,
    /// The robot's URDF.
    Urdf,
}

/// What changed in a robot.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Change {
    /// The robot.
    pub robot: String,
    /// The first day on which it is so.
    pub day: String,
    /// What changed, as a sentence.
    pub what: String,
    /// What kind of thing changed.
    pub kind: ChangeKind,
    /// The effect, the parameter or the finding, as `name:target`.
    pub target: String,
    /// The most that chance would make of it in a fleet in which nothing changes; none of
    /// what is no estimate.
    pub chance: Option<f64>,
}

/// A number by day.
struct Course<'r> {
    days: Vec<&'r str>,
    sizes: Vec<Size>,
    freedom: f64,
}

impl Course<'_> {
    /// The days of a range alone.
    fn part(&self, days: &Range<usize>) -> Self {
        Course {
            days: self.days[days.clone()].to_vec(),
            sizes: self.sizes[days.clone()].to_vec(),
            freedom: self.freedom,
        }
    }
}

/// Where a course can be split best.
struct Split {
    /// Place of the first day on which it is so.
    onset: usize,
    ln_p: f64,
}

/// A change of a course.
struct Step {
    /// Days since the change up to the next one.
    days: Range<usize>,
    /// The most that chance would make of it.
    chance: f64,
}

pub(super) fn changes(
    histories: &[History],
    names: &BTreeMap<(String, String), Vec<String>>,
) -> Vec<Change> {
    let robots = histories.len().max(1) as f64;
    let widening = widening(histories);
    let mut found = Vec::new();
    for history in histories {
        found.extend(urdfs(history));
        found.extend(findings(history));
        for stretch in history.stretches() {
            let effects = effects(history, &stretch, robots);
            match effects.is_empty() {
                true => found.extend(parameters(history, &stretch, &widening, names, robots)),
                false => found.extend(effects),
            }
        }
    }
    found.sort_by(|a, b| {
        let day = || by_number(&a.day, &b.day);
        (a.robot.cmp(&b.robot).then_with(day)).then_with(|| a.what.cmp(&b.what))
    });
    found
}

/// Where another URDF begins.
fn urdfs(history: &History) -> Vec<Change> {
    let known: Vec<&&Row> = history
        .rows
        .iter()
        .filter(|row| !row.urdf_hash.is_empty())
        .collect();
    let pairs = known
        .windows(2)
        .filter(|pair| pair[0].urdf_hash != pair[1].urdf_hash);
    let change = |pair: &[&&Row]| Change {
        robot: history.robot.to_string(),
        day: pair[1].day.clone(),
        what: format!(
            "Its URDF is another one from this day on ({}, before {}): numbers before and after \
             are not compared.",
            pair[1].urdf_hash, pair[0].urdf_hash
        ),
        kind: ChangeKind::Urdf,
        target: pair[1].urdf_hash.clone(),
        chance: None,
    };
    pairs.map(change).collect()
}

/// Findings that two days or more have, up to the last, and none before.
fn findings(history: &History) -> Vec<Change> {
    let rows = history.with_results();
    let Some(last) = rows.last() else {
        return Vec::new();
    };
    let of = |finding: &crate::health::Finding| {
        let has = |row: &&Row| {
            row.health
                .iter()
                .any(|f| f.kind == finding.kind && f.target == finding.target)
        };
        let first = rows.iter().position(has)?;
        let lasts = rows[first..].iter().all(has) && first > 0 && rows.len() - first > 1;
        lasts.then(|| Change {
            robot: history.robot.to_string(),
            day: rows[first].day.clone(),
            what: finding.sentence.clone(),
            kind: ChangeKind::Health,
            target: label((finding.kind.name(), &finding.target)),
            chance: None,
        })
    };
    last.health.iter().filter_map(of).collect()
}

/// Effects whose size changes.
fn effects(history: &History, rows: &[&Row], robots: f64) -> Vec<Change> {
    let mut found = Vec::new();
    for key in history.keys() {
        let all = rows.iter().filter_map(|row| match said(row, &key) {
            Said::Found(found) => Some(found),
            _ => None,
        });
        let Some(parameter) = principal(all) else {
            continue;
        };
        let course = course_of_effect(rows, &key, &parameter);
        let say = |size: Size| match size.value {
            // An effect that no explanation has is not there, whatever it might be.
            0.0 => "not seen".to_string(),
            _ => named(&NamedValue {
                name: &parameter,
                value: size.value,
                std: size.std,
            }),
        };
        for step in steps(&course, HYPOTHESES * robots) {
            let (before, last) = (step.days.start - 1, step.days.end - 1);
            found.push(Change {
                robot: history.robot.to_string(),
                day: course.days[step.days.start].to_string(),
                what: format!(
                    "{} changes: {} on {}, {} on {}. Chance would make it in {} fleets.",
                    label((&key.0, &key.1)),
                    say(course.sizes[before]),
                    course.days[before],
                    say(course.sizes[last]),
                    course.days[last],
                    one_in(step.chance)
                ),
                kind: ChangeKind::Effect,
                target: label((&key.0, &key.1)),
                chance: Some(step.chance),
            });
        }
    }
    found
}

fn course_of_effect<'r>(rows: &[&'r Row], key: &Key, parameter: &str) -> Course<'r> {
    let of = |row: &Row| match said(row, key) {
        Said::Found(found) => found.parameters.get(parameter).copied().map(Some),
        // It may be there or not.
        Said::Possible => None,
        Said::No => Some(None),
    };
    let known: Vec<(&Row, Option<Size>)> = rows
        .iter()
        .filter_map(|row| Some((*row, of(row)?)))
        .collect();
    let mut stds: Vec<f64> = known
        .iter()
        .filter_map(|(_, size)| size.map(|s| s.std))
        .collect();
    stds.sort_by(f64::total_cmp);
    let typical = stds.get(stds.len() / 2).copied().unwrap_or(0.0);
    let unseen = Size {
        value: 0.0,
        std: UNSEEN * typical,
    };
    let used: Vec<&Row> = known.iter().map(|(row, _)| *row).collect();
    Course {
        days: used.iter().map(|row| row.day.as_str()).collect(),
        sizes: known
            .iter()
            .map(|(_, size)| size.unwrap_or(unseen))
            .collect(),
        freedom: freedom(&used),
    }
}

/// Degrees of freedom of the deviations of all rows together.
fn freedom(rows: &[&Row]) -> f64 {
    let of =
        |row: &&Row| (2.0 * row.independent as f64 - row.params.len() as f64).max(LEAST_FREEDOM);
    rows.iter().map(of).sum()
}

/// When parameters change, the clearest of them named.
fn parameters(
    history: &History,
    rows: &[&Row],
    widening: &[f64],
    names: &BTreeMap<(String, String), Vec<String>>,
    robots: f64,
) -> Vec<Change> {
    let count = rows.iter().map(|row| row.params.len()).max().unwrap_or(0);
    let rows: Vec<&Row> = rows
        .iter()
        .copied()
        .filter(|row| row.params.len() == count)
        .collect();
    let Some(first) = rows.first() else {
        return Vec::new();
    };
    let mut changed: Vec<(usize, Course, Vec<Step>)> = Vec::new();
    for k in 0..count {
        let known: Vec<(&Row, Size)> = rows
            .iter()
            .filter_map(|row| Some((*row, size(row, k, widening)?)))
            .collect();
        let used: Vec<&Row> = known.iter().map(|(row, _)| *row).collect();
        let course = Course {
            days: used.iter().map(|row| row.day.as_str()).collect(),
            sizes: known.iter().map(|(_, size)| *size).collect(),
            freedom: freedom(&used),
        };
        let steps = steps(&course, count as f64 * robots);
        if !steps.is_empty() {
            changed.push((k, course, steps));
        }
    }
    let others = match changed.len().saturating_sub(1) {
        0 => String::new(),
        1 => " Another parameter changes, too.".to_string(),
        n => format!(" {n} other parameters change, too."),
    };
    let clearest = |steps: &[Step]| {
        let chances = steps.iter().map(|step| step.chance);
        chances.fold(f64::INFINITY, f64::min)
    };
    let named = changed
        .into_iter()
        .min_by(|a, b| clearest(&a.2).total_cmp(&clearest(&b.2)));
    let Some((k, course, steps)) = named else {
        return Vec::new();
    };
    let key = (first.urdf_hash.clone(), first.support.clone());
    let name = names.get(&key).and_then(|names| names.get(k)).cloned();
    let name = name.unwrap_or_else(|| format!("parameter {}", k + 1));
    let say = |size: Size| format!("{:.3} ± {:.3} mm", 1e3 * size.value, 1e3 * size.std);
    let of = |step: &Step| {
        let (before, last) = (step.days.start - 1, step.days.end - 1);
        Change {
            robot: history.robot.to_string(),
            day: course.days[step.days.start].to_string(),
            what: format!(
                "{name} changes: {} on {}, {} on {}; no effect is named for it.{others} Chance \
                 would make it in {} fleets.",
                say(course.sizes[before]),
                course.days[before],
                say(course.sizes[last]),
                course.days[last],
                one_in(step.chance)
            ),
            kind: ChangeKind::Parameter,
            target: name.clone(),
            chance: Some(step.chance),
        }
    };
    steps.iter().map(of).collect()
}

/// A parameter of a row with its widened deviation.
fn size(row: &Row, k: usize, widening: &[f64]) -> Option<Size> {
    let (value, std) = (*row.params.get(k)?, (*row.std.get(k)?)?);
    let wide = widening.get(k).copied().unwrap_or(1.0);
    (std > 0.0).then_some(Size {
        value,
        std: wide * std,
    })
}

/// How many times as much days scatter as their deviations say, parameter by parameter; 1 at
/// least.
fn widening(histories: &[History]) -> Vec<f64> {
    let mut squares: Vec<Vec<f64>> = Vec::new();
    for stretch in histories.iter().flat_map(History::stretches) {
        for pair in stretch.windows(2) {
            let count = pair[0].params.len();
            if count != pair[1].params.len() {
                continue;
            }
            squares.resize_with(squares.len().max(count), Vec::new);
            for (k, squares) in squares.iter_mut().enumerate().take(count) {
                if let (Some(a), Some(b)) = (size(pair[0], k, &[]), size(pair[1], k, &[])) {
                    squares.push((a.value - b.value).powi(2) / (a.std.powi(2) + b.std.powi(2)));
                }
            }
        }
    }
    let median = |mut all: Vec<f64>| {
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2)
            .map_or(1.0, |m| (m / MEDIAN_OF_SQUARES).max(1.0).sqrt())
    };
    let together = median(squares.iter().flatten().copied().collect());
    let each = squares
        .into_iter()
        .map(|own| match own.len() < DIFFERENCES {
            true => together,
            false => median(own),
        });
    each.collect()
}

/// Where a number changes, day after day. `tests` are the numbers that are looked at, besides
/// days.
fn steps(course: &Course, tests: f64) -> Vec<Step> {
    let days = course.sizes.len();
    // Of two kinds of numbers.
    let looks = 2.0 * tests * (days as f64 - 1.0);
    let mut onsets: Vec<(usize, f64)> = Vec::new();
    let mut parts = vec![(0..days, looks)];
    while let Some((part, looks)) = parts.pop() {
        let own = course.part(&part);
        let again = part.len() < days;
        if again && is_straight(&own.sizes) {
            continue;
        }
        let Some(Split { onset, ln_p }) = split(&own) else {
            continue;
        };
        let chance = (ln_p + looks.ln()).exp().min(1.0);
        if chance < FALSE_ALARM {
            let onset = part.start + onset;
            onsets.push((onset, chance));
            parts.push((part.start..onset, 2.0 * looks));
            parts.push((onset..part.end, 2.0 * looks));
        }
    }
    onsets.sort_by_key(|(onset, _)| *onset);
    let ends = onsets.iter().skip(1).map(|(onset, _)| *onset).chain([days]);
    let steps = onsets.iter().zip(ends).map(|(&(onset, chance), end)| Step {
        days: onset..end,
        chance,
    });
    steps.collect()
}

/// Whether a straight line over the days, weighted by 1/s², explains the sizes.
fn is_straight(sizes: &[Size]) -> bool {
    let days = sizes.iter().enumerate().map(|(day, size)| {
        let weight = 1.0 / (size.std * size.std);
        (day as f64, size.value, weight)
    });
    let sum =
        |of: &dyn Fn(f64, f64) -> f64| days.clone().map(|(t, x, w)| w * of(t, x)).sum::<f64>();
    let weight = sum(&|_, _| 1.0);
    let (mean_t, mean_x) = (sum(&|t, _| t) / weight, sum(&|_, x| x) / weight);
    let slope = sum(&|t, x| (t - mean_t) * (x - mean_x)) / sum(&|t, _| (t - mean_t).powi(2));
    let line = |t: f64| mean_x + slope * (t - mean_t);
    let chi2 = sum(&|t, x| (x - line(t)).powi(2));
    // Two days always lie on a line.
    let law = ChiSquared::new(sizes.len() as f64 - 2.0);
    law.is_ok_and(|law| law.sf(chi2) > FALSE_ALARM) || sizes.len() < 3
}

fn split(course: &Course) -> Option<Split> {
    let n = course.sizes.len();
    // Means of the days before each day, and of those from it on.
    let before = means(course.sizes.iter());
    let mut after = means(course.sizes.iter().rev());
    after.reverse();
    let gap = |later: Size, k: usize| {
        let before: Size = before[k - 1];
        (later.value - before.value) / later.std.hypot(before.std)
    };
    let z = |k: usize| gap(after[k], k);
    let best = (1..n).max_by(|a, b| z(*a).abs().total_cmp(&z(*b).abs()))?;
    let of = |k: usize| {
        let own = gap(course.sizes[k], k);
        own.abs() > ONSET && own.signum() == z(best).signum()
    };
    // A drift is split best in its middle, and begins before.
    let onset = (1..=best).find(|k| of(*k)).unwrap_or(best);
    let law = StudentsT::new(0.0, 1.0, course.freedom.max(LEAST_FREEDOM)).ok()?;
    let p = 2.0 * law.sf(z(best).abs());
    let ln_p = p.max(f64::MIN_POSITIVE).ln();
    z(best).is_finite().then_some(Split { onset, ln_p })
}

/// Means weighted by 1/s² of the first number, of the first two, and so on.
fn means<'s>(sizes: impl Iterator<Item = &'s Size>) -> Vec<Size> {
    let (mut sum, mut weights) = (0.0, 0.0);
    let mean = |size: &Size| {
        let weight = 1.0 / (size.std * size.std);
        weights += weight;
        sum += weight * size.value;
        Size {
            value: sum / weights,
            std: weights.sqrt().recip(),
        }
    };
    sizes.map(mean).collect()
}
