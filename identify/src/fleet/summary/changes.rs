//! What changed in a robot between its days, and is more than chance.
//!
//! Two kinds of numbers are followed over its [days](super::history), each with half of the chance
//! of a false alarm: base parameters as fitted without effects, and sizes of effects. On days on
//! which an effect is in no explanation it is 0 ± [`UNSEEN`] of its deviations, since a smaller
//! one would hardly be seen.
//!
//! An explanation may change where nothing does: a body that differs from its URDF is explained
//! by a payload on one day and by an offset on the next. A change of an effect counts where what
//! is fitted without effects changes, too:
//!
//! ```text
//! parameters   δᵀ (C_before + C_after)⁻¹ δ / (n s²)   against Fisher's law
//! gap          Σν e²/Σν after over before             against Fisher's law, to both sides
//! ```
//!
//! δ is the difference between the means θ̄ = C Σ C_d⁻¹ θ_d of the n base parameters, C⁻¹ =
//! Σ C_d⁻¹ over the days d before or after; s widens deviations by what days of the fleet scatter
//! between which no explanation changes. Together parameters tell more than each alone: an offset
//! of a joint moves many of them along a direction that is known far better than any of them.
//!
//! Deviations are widened by what the days of the whole fleet scatter: by the median of the
//! squared differences between neighbouring days, parameter by parameter.

use std::cell::OnceCell;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use statrs::distribution::FisherSnedecor;

use super::history::{Course, History, Key, Step, explained, freedom, principal, steps, tail};
use super::shared::one_in;
use super::{DIFFERENCES, FALSE_ALARM, HYPOTHESES, ROBOTS, UNSEEN};
use crate::diagnose::Quantity;
use crate::diagnose::words::{capital, named};
use crate::fleet::row::{Row, by_number};
use crate::health::Finding;
use crate::observations::noise::quantile;
use crate::observations::postures::range;

/// What kind of thing changed; its name in JSON is in small letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(rename = "FleetChange")
)]
#[non_exhaustive]
pub struct Change {
    /// The robot.
    pub robot: String,
    /// The first such day.
    pub day: String,
    /// Possible days, at 95 %; none of what files themselves state.
    pub day_interval: Option<[String; 2]>,
    /// What changed, as a sentence.
    pub what: String,
    /// What kind of thing changed.
    pub kind: ChangeKind,
    /// Effect, parameter or finding, as `name:target`.
    pub target: String,
    /// Parameter of `before` and `after`; its end is the unit, or it is a base parameter in m.
    pub parameter: Option<String>,
    /// Its size on the day before; none where it is not seen.
    pub before: Option<Quantity>,
    /// Its size on the last such day; none where it is not seen.
    pub after: Option<Quantity>,
    /// Largest chance without changes; none of what is no estimate.
    pub chance: Option<f64>,
}

impl Change {
    /// What a row itself states.
    fn stated(row: &Row, kind: ChangeKind, target: String, what: String) -> Change {
        Change {
            robot: row.robot.clone(),
            day: row.day.clone(),
            day_interval: None,
            what,
            kind,
            target,
            parameter: None,
            before: None,
            after: None,
            chance: None,
        }
    }

    /// A step of a number, by its sizes before it and after it and by what is said of them.
    fn stepped(
        (course, step): (&Course, &Step),
        (kind, target, parameter): (ChangeKind, String, &str),
        [before, after]: [Option<Quantity>; 2],
        (subject, [was, is], remark): (&str, [String; 2], &str),
    ) -> Change {
        let (day, last) = (step.days.start - 1, step.days.end - 1);
        let what = format!(
            "{subject} changes: {was} on {}, {is} on {}{remark}. Chance would make it in {} \
             fleets.",
            course.day(day),
            course.day(last),
            one_in(step.chance)
        );
        let first = [step.first.start(), step.first.end()];
        Change {
            day_interval: Some(first.map(|day| course.day(*day).to_string())),
            parameter: Some(parameter.to_string()),
            before,
            after,
            chance: Some(step.chance),
            ..Change::stated(course.rows[step.days.start], kind, target, what)
        }
    }
}

pub(super) fn changes(histories: &[History]) -> Vec<Change> {
    let robots = histories.len().max(1) as f64;
    let widening = widening(histories);
    // Most fleets have no effect that comes or goes.
    let known = OnceCell::new();
    let scatter = || *known.get_or_init(|| scatter(histories));
    let mut found = Vec::new();
    for history in histories {
        found.extend(urdfs(history));
        found.extend(findings(history));
        for stretch in history.stretches() {
            let effects = effects(history, &stretch, &scatter, robots);
            if effects.is_empty() {
                found.extend(parameters(&stretch, &widening, robots));
            }
            found.extend(effects);
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
    let mut known = history.rows.clone();
    known.retain(|row| !row.urdf_hash.is_empty());
    let change = |pair: &[&Row]| {
        let [before, after] = [0, 1].map(|k| pair[k].urdf_hash.as_str());
        let what = format!(
            "Its URDF is another one from this day on ({after}, before {before}): numbers before \
             and after are not compared."
        );
        let changed = || Change::stated(pair[1], ChangeKind::Urdf, after.to_string(), what);
        (before != after).then(changed)
    };
    known.windows(2).filter_map(change).collect()
}

/// Findings that two days or more have, up to the last, and none before.
fn findings(history: &History) -> Vec<Change> {
    let rows = history.with_results();
    let Some(last) = rows.last() else {
        return Vec::new();
    };
    let of = |finding: &Finding| {
        let key = Key::of_finding(finding);
        let has = |row: &&Row| row.health.iter().any(|own| Key::of_finding(own) == key);
        let first = rows.iter().position(has)?;
        let lasts = rows[first..].iter().all(has) && first > 0 && rows.len() - first > 1;
        lasts.then(|| {
            let what = finding.sentence.clone();
            Change::stated(rows[first], ChangeKind::Health, key.label(), what)
        })
    };
    last.health.iter().filter_map(of).collect()
}

/// Effects whose size changes; days scatter `scatter` times as much as their deviations say.
fn effects(
    history: &History,
    rows: &[&Row],
    scatter: &dyn Fn() -> f64,
    robots: f64,
) -> Vec<Change> {
    let mut all = Vec::new();
    for key in history.keys() {
        let found = rows.iter().filter_map(|row| key.found(row));
        let Some((name, absent)) = principal(found) else {
            continue;
        };
        let course = course_of_effect(rows, key, name);
        // An effect that no explanation has is not there, whatever it might be.
        let seen = |away: Quantity| (away.value != 0.0).then(|| absent.back(away));
        let words = |Quantity { value, std }| named(name, value, std);
        let say = |size: Option<Quantity>| size.map_or("not seen".to_string(), words);
        let mut since = 0;
        for step in steps(&course, HYPOTHESES * robots) {
            let before = &course.rows[since..step.days.start];
            since = step.days.start;
            if !is_borne_out(before, &course.rows[step.days.clone()], scatter()) {
                continue;
            }
            let sizes = course.sizes_of(&step).map(seen);
            let about = (ChangeKind::Effect, key.label(), name);
            let said = (&*capital(&key.subject()), sizes.map(say), "");
            all.push(Change::stepped((&course, &step), about, sizes, said));
        }
    }
    all
}

/// How far a parameter of an effect is, day by day, from what it is without the effect.
fn course_of_effect<'r>(rows: &[&'r Row], key: Key, parameter: &str) -> Course<'r> {
    let of = |row: &&'r Row| match key.found(row) {
        Some(found) => Some((*row, Some(found.away(parameter)?))),
        // It may be there or not.
        None if key.is_possible(row) => None,
        None => Some((*row, None)),
    };
    let known: Vec<(&Row, Option<Quantity>)> = rows.iter().filter_map(of).collect();
    let stds = known.iter().filter_map(|(_, size)| Some((*size)?.std));
    let unseen = Quantity {
        value: 0.0,
        std: UNSEEN * quantile(stds, 0.5).unwrap_or(0.0),
    };
    let known = known.into_iter();
    Course::of(known.map(|(row, size)| (row, size.unwrap_or(unseen))))
}

/// When parameters change, the clearest of them named.
fn parameters(rows: &[&Row], widening: &[f64], robots: f64) -> Vec<Change> {
    let count = rows.iter().map(|row| row.params.len()).max().unwrap_or(0);
    let rows = rows.iter().copied();
    let rows: Vec<&Row> = rows.filter(|row| row.params.len() == count).collect();
    let Some(first) = rows.first() else {
        return Vec::new();
    };
    let steps_of = |k: usize| {
        let wide = widening.get(k).copied().unwrap_or(1.0);
        let known = rows.iter();
        let course = Course::of(known.filter_map(|row| Some((*row, size(row, k, wide)?))));
        let steps = steps(&course, count as f64 * robots);
        (!steps.is_empty()).then_some((k, course, steps))
    };
    let changed: Vec<(usize, Course, Vec<Step>)> = (0..count).filter_map(steps_of).collect();
    let others = match changed.len().saturating_sub(1) {
        0 => String::new(),
        1 => ". Another parameter changes, too".to_string(),
        n => format!(". {n} other parameters change, too"),
    };
    let clearest = |steps: &[Step]| range(steps.iter().map(|step| step.chance)).0;
    let changed = changed.into_iter();
    let named = changed.min_by(|a, b| clearest(&a.2).total_cmp(&clearest(&b.2)));
    let Some((k, course, steps)) = named else {
        return Vec::new();
    };
    let name = first.names.get(k).cloned();
    let name = name.unwrap_or_else(|| format!("parameter {}", k + 1));
    let say = |Quantity { value, std }| format!("{:.3} ± {:.3} mm", 1e3 * value, 1e3 * std);
    let remark = format!("; no effect is named for it{others}");
    let of = |step: &Step| {
        let sizes = course.sizes_of(step);
        let about = (ChangeKind::Parameter, name.clone(), &*name);
        let said = (&*name, sizes.map(say), &*remark);
        Change::stepped((&course, step), about, sizes.map(Some), said)
    };
    steps.iter().map(of).collect()
}

/// Neighbouring days whose parameters can be compared.
fn neighbours<'r>(histories: &[History<'r>]) -> Vec<[&'r Row; 2]> {
    let mut all = Vec::new();
    for stretch in histories.iter().flat_map(History::stretches) {
        all.extend(stretch.windows(2).map(|pair| [pair[0], pair[1]]));
    }
    all.retain(|[one, other]| one.params.len() == other.params.len());
    all
}

/// How many times as much days scatter as their deviations say, parameter by parameter; 1 at
/// least.
fn widening(histories: &[History]) -> Vec<f64> {
    let mut squares: Vec<Vec<f64>> = Vec::new();
    for [one, other] in neighbours(histories) {
        squares.resize_with(squares.len().max(one.params.len()), Vec::new);
        for (all, own) in squares.iter_mut().zip(squares_between(one, other)) {
            all.extend(own);
        }
    }
    let together = widening_of(squares.iter().flatten().copied());
    let each = |own: Vec<f64>| match own.len() {
        0..DIFFERENCES => together,
        _ => widening_of(own),
    };
    squares.into_iter().map(each).collect()
}

/// Whether what is fitted without effects differs between the days `before` and those `after`,
/// of deviations that are `widening` times as large as fits say.
fn is_borne_out(before: &[&Row], after: &[&Row], widening: f64) -> bool {
    let parameters = chance_of_parameters(before, after, widening);
    let least = parameters.min(chance_of_gaps(before, after));
    // Of two kinds of numbers.
    2.0 * least < FALSE_ALARM
}

/// How many times as much days scatter as their deviations say, of neighbouring days with the
/// same explanation; 1 at least, and where there are too few of them.
fn scatter(histories: &[History]) -> f64 {
    let mut pairs = neighbours(histories);
    pairs.retain(|[one, other]| explained(one) == explained(other));
    if pairs.len() < ROBOTS {
        return 1.0;
    }
    let pairs = pairs.into_iter();
    let squares = pairs.flat_map(|[one, other]| squares_between(one, other));
    widening_of(squares.flatten())
}

/// The factor by which deviations are too small of which these are the squared differences over
/// their variance; 1 at least.
fn widening_of(squares: impl IntoIterator<Item = f64>) -> f64 {
    // Of the square of a standard normal number the median is 0.455.
    let wider = |median: f64| (median / 0.454_936).max(1.0).sqrt();
    quantile(squares.into_iter(), 0.5).map_or(1.0, wider)
}

/// Squared differences of two days over their variance, parameter by parameter; none where a day
/// does not know it.
fn squares_between<'r>(one: &'r Row, other: &'r Row) -> impl Iterator<Item = Option<f64>> + 'r {
    (0..one.params.len()).map(move |k| {
        let (a, b) = (size(one, k, 1.0)?, size(other, k, 1.0)?);
        Some((a.value - b.value).powi(2) / (a.std.powi(2) + b.std.powi(2)))
    })
}

/// A parameter of a row with its widened deviation.
fn size(row: &Row, k: usize, widening: f64) -> Option<Quantity> {
    let (value, std) = (*row.params.get(k)?, (*row.std.get(k)?)?);
    (std > 0.0).then_some(Quantity {
        value,
        std: widening * std,
    })
}

/// The chance that base parameters differ so much where none changed.
fn chance_of_parameters(before: &[&Row], after: &[&Row], widening: f64) -> f64 {
    let differing = || {
        let uncertain = uncertain(before.iter().chain(after).copied())?;
        let (one, of_one) = mean(before, &uncertain)?;
        let (other, of_other) = mean(after, &uncertain)?;
        let (n, gap) = (uncertain.len() as f64, other - one);
        let together = (of_one + of_other).cholesky()?;
        let ratio = gap.dot(&together.solve(&gap)) / (n * widening * widening);
        let law = FisherSnedecor::new(n, freedom(before) + freedom(after)).ok()?;
        Some(tail(&law, ratio))
    };
    differing().unwrap_or(1.0)
}

/// The parameters that days differ by, of those rows that have covariances: a parameter of links
/// without mass is known exactly, and would make every covariance singular.
///
/// None where no row has a covariance or rows have other parameters, and where all are exact.
fn uncertain<'r>(rows: impl Iterator<Item = &'r Row>) -> Option<Vec<usize>> {
    let known: Vec<DMatrix<f64>> = rows.filter_map(Row::covariance).collect();
    let n = known.first()?.nrows();
    if known.iter().any(|covariance| covariance.nrows() != n) {
        return None;
    }
    // Of which a fit claims a smaller deviation, 1e-9 m, is known exactly.
    let is_uncertain = |&k: &usize| known.iter().all(|c| c[(k, k)] > 1e-9 * 1e-9);
    let uncertain: Vec<usize> = (0..n).filter(is_uncertain).collect();
    (!uncertain.is_empty()).then_some(uncertain)
}

/// The mean of the parameters `of` these rows, and its covariance; none where no day has a
/// covariance of them.
fn mean(rows: &[&Row], of: &[usize]) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let of_day = |row: &&Row| {
        let own = row.covariance()?.select_rows(of).select_columns(of);
        let precision = own.cholesky()?.inverse();
        let values = DVector::from_iterator(of.len(), of.iter().map(|&k| row.params[k]));
        Some((&precision * values, precision))
    };
    let days = rows.iter().filter_map(of_day);
    let (vector, precision) = days.reduce(|sum, day| (sum.0 + day.0, sum.1 + day.1))?;
    let factor = precision.cholesky()?;
    Some((factor.solve(&vector), factor.inverse()))
}

/// The chance that held-out gaps differ so much where nothing changed.
fn chance_of_gaps(before: &[&Row], after: &[&Row]) -> f64 {
    let pooled = |rows: &[&Row]| {
        let known = rows.iter().filter(|row| row.held_out_rmse.is_some());
        let known: Vec<&Row> = known.copied().collect();
        let square = |row: &&Row| freedom(&[row]) * row.held_out_rmse.unwrap_or(0.0).powi(2);
        let (squares, free) = (known.iter().map(square).sum::<f64>(), freedom(&known));
        (free > 0.0).then_some((squares / free, free))
    };
    let (Some(mut larger), Some(mut smaller)) = (pooled(before), pooled(after)) else {
        return 1.0;
    };
    if smaller.0 >= larger.0 {
        std::mem::swap(&mut larger, &mut smaller);
    }
    if smaller.0 <= 0.0 {
        return if larger.0 > 0.0 { 0.0 } else { 1.0 };
    }
    let law = FisherSnedecor::new(larger.1, smaller.1);
    law.map_or(1.0, |law| 2.0 * tail(&law, larger.0 / smaller.0))
}
