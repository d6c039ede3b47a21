//! What the rows of a fleet say together: a pure function of the rows.
//!
//! ```text
//! rows ─▶ robots (days in order) ─▶ shared effects ─┐
//!                                └▶ changes ────────┴▶ what to look at first
//! ```
//!
//! Robots to look at first are sorted by the weight of what is said of them:
//!
//! ```text
//! weight = Σ w_k (1 − p_k)          w_k: how urgent statement k is; p_k: its chance in a sound robot
//! std²   = Σ w_k² p_k (1 − p_k)     whether each is true is drawn on its own
//! robot j is before i for sure:     weight_j − weight_i > 1.96 √(std_j² + std_i²)
//! ```
//!
//! p_k is that of the test which made the statement: of a change or a group in the whole fleet;
//! of an effect of the robot's own 1/(1 + e^(E/2)/D), with E the evidence of the clearest of D
//! days; of a finding on m of D days the chance that so many sound days have it. What files
//! themselves say (another URDF, a log that cannot be read) has 0.

mod changes;
mod history;
mod shared;

use std::collections::BTreeSet;

use serde::Serialize;
use statrs::distribution::{Binomial, DiscreteCDF as _};

use super::row::Row;
use crate::diagnose::Verdict;
use crate::fit::population::Population;
use crate::health::Finding;
use history::{History, Key};
use shared::one_in;

pub use changes::{Change, ChangeKind};
pub use shared::{Shared, SharedMember};

// When something is said of a fleet. `cargo xtask study fleet` counts what comes of all of these
// numbers together.

/// Chance that a fleet of which nothing is wrong gets a shared effect, and that it gets a
/// change: corrected for everything that is looked at in the whole fleet. An effect that comes or
/// goes is a change where what is fitted without effects differs by more than chance makes of it in
/// this part of cases. Chosen: it is the rate of false alarms itself; `cargo xtask study fleet`
/// counts them.
pub const FALSE_ALARM: f64 = 0.01;

/// An effect of the last day alone counts if it is so many deviations large. Chosen: half of it
/// lists robots for one odd day.
pub(in crate::fleet) const CLEAR: f64 = 8.0;

/// Chance that a finding about the data is in a log of a sound robot, at most; taken for the
/// verdict `unexplained`, too. Calibrated on the study of health, where 0 of 300 healthy logs have
/// a finding: 1 % is the upper end of its 95 % interval. Half of it halves the chances that are
/// said of findings, and moves no robot.
pub(in crate::fleet) const FALSE_FINDING: f64 = 0.01;

/// Fewer robots, or pairs of days with one explanation, say nothing of how they are spread. Chosen:
/// four degrees of freedom know a spread to a third (closed form).
pub(in crate::fleet) const ROBOTS: usize = 5;

/// Where more than this part of the robots have effects of their own, bodies are said to differ; in
/// this part of the rows of a robot an effect has to be possible to be the robot's. Chosen: half of it
/// is reached by a fleet with several batches whose sizes scatter, and groups robots by single days.
pub(in crate::fleet) const MOST: f64 = 0.5;

/// Deviations of an effect on a day that does not show it. Chosen: half of it makes an
/// effect that is not named on a day smaller than it may be, and changes too many.
pub(in crate::fleet) const UNSEEN: f64 = 3.0;
/// Effects and targets that a diagnosis may name. Chosen: a factor of two moves the
/// threshold by 0.1 deviations (closed form).
pub(in crate::fleet) const HYPOTHESES: f64 = 500.0;
/// A day that differs from those before it by so many deviations begins a change. Chosen:
/// half of it dates changes too early; twice as much dates drifts late.
pub(in crate::fleet) const ONSET: f64 = 4.0;
/// Fewer differences than these do not tell how days scatter. Chosen: the root of the
/// median of so many squares is off by a quarter (closed form), of half as many by a third.
pub(in crate::fleet) const DIFFERENCES: usize = 20;
/// Fewest degrees of freedom that are taken for a row's deviations. Chosen: half of it asks
/// for larger changes in small fleets.
pub(in crate::fleet) const LEAST_FREEDOM: f64 = 5.0;

/// This part of the robots, at least, has a fault of its own. Chosen: twice as much asks a batch of three
/// for another half of a deviation each.
pub(in crate::fleet) const OWN: f64 = 0.05;
/// So many effects explain much the same. Chosen: an offset of a joint, its scale, and those of the
/// joints beside it; twice as many asks a batch of three for another half of a deviation each.
pub(in crate::fleet) const ALIKE: f64 = 5.0;
/// A robot is told of a group from so many deviations of its own size on. Chosen: half of it tells
/// robots of which the log says nothing.
pub(in crate::fleet) const CLEARLY: f64 = 2.0;
/// Robots of a group differ by this part of what they share, a deviation. Chosen: half of it leaves out
/// robots of batches whose offsets scatter, twice as much takes sizes that agree by chance for one.
pub(in crate::fleet) const DIFFER: f64 = 0.05;

/// What the rows say together.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Summary {
    /// Effects that robots share.
    pub shared: Vec<Shared>,
    /// What changed, robot by robot.
    pub changes: Vec<Change>,
    /// Robots to look at first.
    pub look_first: Vec<String>,
    /// Why, in the same order.
    pub reasons: Vec<Reason>,
    /// Advice if most robots have effects; an effect may then stand for a body that differs from
    /// the URDF.
    pub bodies: Option<String>,
    /// Prior for the next robot; see [`population`](super::population()).
    pub population: Option<Population>,
}

/// What the rows say together. `population` is what [`population`](super::population()) made of
/// the same rows, where they have covariances.
pub fn summary(rows: &[Row], population: Option<Population>) -> Summary {
    let histories = history::histories(rows);
    let shared = shared::shared(&histories);
    let changes = changes::changes(&histories);
    let reasons = reasons(&histories, &shared, &changes);
    Summary {
        look_first: reasons.iter().map(|reason| reason.robot.clone()).collect(),
        reasons,
        bodies: differing_bodies(&histories, &shared),
        population,
        shared,
        changes,
    }
}

/// What to do where most robots have effects of their own, as a sentence: a diagnosis that trusts
/// CAD within tight tolerances explains a body that is off by more as an effect, another one in
/// each robot, and most robots of a fleet have no fault of their own.
fn differing_bodies(histories: &[History], shared: &[Shared]) -> Option<String> {
    let in_groups = shared.iter().flat_map(|group| &group.robots);
    let in_groups: BTreeSet<&str> = in_groups.map(String::as_str).collect();
    let of_its_own =
        |history: &&History| history.has_effects() && !in_groups.contains(history.robot);
    let is_usable = |history: &&History| history.usable().next().is_some();
    let all = histories.iter().filter(is_usable).count();
    let own = histories.iter().filter(of_its_own).count();
    let most = all >= ROBOTS && own as f64 > MOST * all as f64;
    most.then(|| {
        format!(
            "{own} of {all} robots have effects of their own on most days. So many robots hardly \
             have faults: their bodies differ from the URDF by more than the prior of these \
             diagnoses takes for granted, and an effect stands for a body. Run the fleet once more \
             with the prior `cad`, or with that of the population, which it can write."
        )
    })
}

/// Why a robot is to be looked at.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Reason {
    /// The robot.
    pub robot: String,
    /// Urgency; what spoils data comes before what spoils the robot, a change before a lasting
    /// state, what is the robot's own before what others share. Each statement counts by the
    /// probability that it is true.
    pub weight: f64,
    /// Standard deviation of the weight; each statement is true or false.
    pub weight_std: f64,
    /// Possible places, at 95 %; robots of one weight share their places.
    pub places: [usize; 2],
    /// Chance for a sound robot.
    pub chance: f64,
    /// The statements.
    pub said: Vec<Statement>,
    /// Why, in sentences.
    pub why: String,
}

/// One thing that is said of a robot.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Statement {
    /// How urgent it is.
    pub weight: f64,
    /// Chance of a false statement; 0 of what files themselves state.
    pub chance: f64,
    /// What is said, as a sentence.
    pub sentence: String,
}

impl Reason {
    /// How often a sound robot is listed so, as words: `in 1 of 40 robots`.
    pub fn chance_in_words(&self) -> String {
        if self.chance <= 0.0 {
            return "never".to_string();
        }
        format!("in {} robots", one_in(self.chance))
    }

    /// The places that the robot may have, as words: `1`, or `2 to 4`.
    pub fn places_in_words(&self) -> String {
        match self.places {
            [first, last] if first == last => first.to_string(),
            [first, last] => format!("{first} to {last}"),
        }
    }
}

impl Statement {
    fn new(weight: f64, chance: f64, sentence: String) -> Statement {
        Statement {
            weight,
            chance: chance.clamp(0.0, 1.0),
            sentence,
        }
    }
}

fn reasons(histories: &[History], shared: &[Shared], changes: &[Change]) -> Vec<Reason> {
    let of = |history: &History| {
        let said = statements(history, shared, changes);
        if said.is_empty() {
            return None;
        }
        let true_part = |one: &Statement| one.weight * (1.0 - one.chance);
        let variance = |one: &Statement| one.weight * one.chance * true_part(one);
        let why: Vec<&str> = said.iter().map(|one| one.sentence.as_str()).collect();
        Some(Reason {
            robot: history.robot.to_string(),
            weight: said.iter().map(true_part).sum(),
            weight_std: said.iter().map(variance).sum::<f64>().sqrt(),
            places: [0, 0],
            chance: said.iter().map(|one| one.chance).product(),
            why: why.join(" "),
            said,
        })
    };
    let mut reasons: Vec<Reason> = histories.iter().filter_map(of).collect();
    reasons.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.robot.cmp(&b.robot)));
    place(&mut reasons);
    reasons
}

/// The places that each may have.
fn place(reasons: &mut [Reason]) {
    // At 97.5 % of a normal number; sums of the same weights may differ in their last digits.
    let is_before = |one: &Reason, other: &Reason| {
        let std = one.weight_std.hypot(other.weight_std);
        one.weight - other.weight > 1.959_963_985 * std + 1e-9
    };
    for k in 0..reasons.len() {
        let before = reasons.iter().filter(|one| is_before(one, &reasons[k]));
        let after = reasons.iter().filter(|one| is_before(&reasons[k], one));
        reasons[k].places = [before.count() + 1, reasons.len() - after.count()];
    }
}

fn statements(history: &History, shared: &[Shared], changes: &[Change]) -> Vec<Statement> {
    let mut all = data(history);
    let own = || changes.iter().filter(|c| c.robot == history.robot);
    for change in own() {
        let weight = match change.kind {
            ChangeKind::Urdf => 1.0,
            // The finding itself is said already.
            ChangeKind::Health => 0.0,
            ChangeKind::Effect | ChangeKind::Parameter => 4.0,
        };
        let sentence = format!("From {} on: {}", change.day, change.what);
        let chance = change.chance.unwrap_or(0.0);
        all.push(Statement::new(weight, chance, sentence));
    }
    let keys = history.keys().into_iter();
    for key in keys.filter(|key| lasts(history, *key)) {
        let group = shared.iter().find(|group| {
            (&*group.effect, &*group.target) == (key.effect, key.target)
                && group.robots.iter().any(|robot| robot == history.robot)
        });
        let what = key.subject();
        if let Some(group) = group {
            let others = match group.robots.len().saturating_sub(1) {
                1 => "1 other".to_string(),
                n => format!("{n} others"),
            };
            let sentence = format!("It shares {what} with {others}.");
            all.push(Statement::new(2.0, group.chance, sentence));
        } else if !own().any(|change| change.target == key.label()) {
            let sentence = format!("It has {what}; no group of robots shares it.");
            all.push(Statement::new(3.0, chance_of(history, key), sentence));
        }
    }
    all.extend(unexplained(history));
    all.extend(errors(history));
    all
}

/// Chance of an effect of the robot's own: by the evidence of the clearest day, any of which
/// might have been it.
fn chance_of(history: &History, key: Key) -> f64 {
    let rows: Vec<&Row> = history.usable().collect();
    let known = rows.iter().filter_map(|row| key.found(row));
    let most = known.map(|found| found.evidence).fold(0.0, f64::max);
    let odds = (0.5 * most - (rows.len().max(1) as f64).ln()).exp();
    1.0 / (1.0 + odds)
}

/// Chance that a sound robot has a finding on so many of its days or more.
fn chance_of_days(count: usize, days: usize) -> f64 {
    let law = Binomial::new(FALSE_FINDING, days as u64);
    law.map_or(1.0, |law| law.sf((count as u64).saturating_sub(1)))
}

/// Findings about the data: those of two days or more, and those of the last.
fn data(history: &History) -> Vec<Statement> {
    let rows = history.with_results();
    let last = rows.last().map_or(&[][..], |row| &row.health);
    let all: Vec<&Finding> = rows.iter().flat_map(|row| &row.health).collect();
    let statement = |(at, finding): (usize, &&Finding)| {
        let is_it = |other: &Finding| Key::of_finding(other) == Key::of_finding(finding);
        let is_first = !all[..at].iter().any(|other| is_it(other));
        let days = all.iter().filter(|other| is_it(other)).count();
        let unusable = finding.kind.makes_unusable();
        let counts = days > 1 || unusable || last.iter().any(is_it);
        (is_first && counts).then(|| {
            let weight = if unusable { 6.0 } else { 5.0 };
            let chance = chance_of_days(days, rows.len());
            Statement::new(weight, chance, finding.sentence.clone())
        })
    };
    all.iter().enumerate().filter_map(statement).collect()
}

/// Whether an effect is on two days or more and on most since the first of them, or clear on
/// the last.
fn lasts(history: &History, key: Key) -> bool {
    let rows: Vec<_> = history.usable().map(|row| key.found(row)).collect();
    let Some(first) = rows.iter().position(Option::is_some) else {
        return false;
    };
    let since = &rows[first..];
    let count = since.iter().flatten().count();
    let clear = since[since.len() - 1].is_some_and(|found| {
        let mut sizes = found.parameters.keys().filter_map(|name| found.away(name));
        sizes.any(|size| size.value.abs() > CLEAR * size.std)
    });
    (count > 1 && 2 * count >= since.len()) || clear
}

fn unexplained(history: &History) -> Option<Statement> {
    let rows: Vec<&Row> = history.usable().collect();
    let is_open = |row: &&&Row| row.verdict == Some(Verdict::Unexplained);
    let (count, days) = (rows.iter().filter(is_open).count(), rows.len());
    let sentence = format!("{count} of {days} days are unexplained.");
    let statement = Statement::new(3.5, chance_of_days(count, days), sentence);
    (count > 1 && 2 * count >= days).then_some(statement)
}

fn errors(history: &History) -> Option<Statement> {
    let failed = history.rows.iter().filter(|row| row.error.is_some());
    let mut days: Vec<&str> = failed.map(|row| row.day.as_str()).collect();
    let any = !days.is_empty();
    days.retain(|day| !day.is_empty());
    let on = if days.is_empty() { "" } else { " on " };
    let sentence = format!("Logs have errors{on}{}.", days.join(", "));
    any.then(|| Statement::new(1.0, 0.0, sentence))
}

#[cfg(test)]
mod tests;
