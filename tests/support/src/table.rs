//! The study in figures: the goals, and who was taken for whom.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::hidden::Effect;
use crate::survey::Outcome;
use crate::trial::Question;

/// The share that is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    /// At least this share.
    Least(f64),
    /// At most this share.
    Most(f64),
    /// None.
    Shown,
}

/// A share, asked for and found.
#[derive(Debug, Clone, PartialEq)]
pub struct Goal {
    /// What is counted.
    pub what: &'static str,
    /// What is asked for.
    pub bound: Bound,
    /// Trials in which it holds.
    pub met: usize,
    /// Trials in which it might.
    pub of: usize,
}

impl Goal {
    /// The share that was found.
    pub fn found(&self) -> f64 {
        self.met as f64 / self.of as f64
    }

    /// True where nothing was asked, too.
    pub fn is_met(&self) -> bool {
        let found = self.found();
        self.of == 0
            || match self.bound {
                Bound::Least(share) => found >= share,
                Bound::Most(share) => found <= share,
                Bound::Shown => true,
            }
    }
}

/// Shown as strongly as the unmodelled effects of the open logs are.
const STRONG: f64 = 4000.0;

type Is = fn(&Outcome) -> bool;

/// What the study is to show: of which logs at least (or at most) which share
/// is to be how. Where no share is asked, it is for comparison.
const GOALS: [(&str, Is, Bound, Is); 21] = [
    (
        "one effect: named, or of its class",
        one,
        Bound::Least(0.95),
        |o| o.judgement.name_or_class(),
    ),
    ("one effect: named exactly", one, Bound::Least(0.87), |o| {
        o.judgement.name
    }),
    (
        "one effect: target right, or of its class",
        one,
        Bound::Least(0.93),
        |o| o.judgement.class(),
    ),
    (
        "one effect: truth inside the group",
        one,
        Bound::Least(0.97),
        |o| o.judgement.in_group,
    ),
    (
        "nothing hidden: false alarms",
        nothing,
        Bound::Most(0.01),
        |o| !silent(o),
    ),
    ("two effects: class", two, Bound::Least(0.88), |o| {
        o.judgement.class()
    }),
    (
        "two effects: both named exactly",
        two,
        Bound::Least(0.78),
        |o| o.judgement.name,
    ),
    (
        "two effects: both names and targets",
        two,
        Bound::Shown,
        |o| o.judgement.exact,
    ),
    ("three effects: class", three, Bound::Least(0.85), |o| {
        o.judgement.class()
    }),
    (
        "one effect: postures put aside below 1.1 noises",
        one,
        Bound::Least(0.97),
        predicted_to_noise,
    ),
    (
        "two effects: postures put aside below 1.1 noises",
        two,
        Bound::Least(0.95),
        predicted_to_noise,
    ),
    (
        "one effect: held out below 1.1, as reported",
        one,
        Bound::Shown,
        |o| o.judgement.held_out < 1.1,
    ),
    (
        "two effects: held out below 1.1, as reported",
        two,
        Bound::Shown,
        |o| o.judgement.held_out < 1.1,
    ),
    (
        "drift named: postures put aside below 1.1 noises",
        drifting,
        Bound::Shown,
        |o| o.judgement.aside.is_some_and(|aside| aside < 1.1),
    ),
    (
        "outside the library: unexplained, or at its place",
        outside,
        Bound::Shown,
        |o| o.judgement.unexplained || o.judgement.at_place,
    ),
    (
        "... shown with chi2 above 4000: the same",
        strongly_outside,
        Bound::Least(1.0),
        |o| o.judgement.unexplained || o.judgement.at_place,
    ),
    (
        "... the same, or imitated to within noise",
        outside,
        Bound::Shown,
        |o| o.judgement.unexplained || o.judgement.at_place || o.judgement.imitates,
    ),
    (
        "hanging load: payload at its hinge, or unexplained",
        hanging,
        Bound::Least(1.0),
        |o| o.judgement.class() || o.judgement.unexplained,
    ),
    (
        "known effects: unexplained",
        known,
        Bound::Most(0.02),
        |o| o.judgement.unexplained,
    ),
    (
        "invisible here: none",
        invisible,
        Bound::Least(0.95),
        silent,
    ),
    (
        "masses as CAD is trusted: none",
        absorbed,
        Bound::Least(0.95),
        silent,
    ),
];

fn one(outcome: &Outcome) -> bool {
    outcome.question == Question::Library(1)
}

fn two(outcome: &Outcome) -> bool {
    outcome.question == Question::Library(2)
}

fn three(outcome: &Outcome) -> bool {
    outcome.question == Question::Library(3)
}

fn known(outcome: &Outcome) -> bool {
    matches!(outcome.question, Question::Library(_))
}

fn nothing(outcome: &Outcome) -> bool {
    outcome.question == Question::Nothing
}

fn hanging(outcome: &Outcome) -> bool {
    outcome.question == Question::Outside && outcome.effects == [Effect::HangingLoad]
}

fn outside(outcome: &Outcome) -> bool {
    outcome.question == Question::Outside && !hanging(outcome)
}

fn strongly_outside(outcome: &Outcome) -> bool {
    outside(outcome) && outcome.chi2 > STRONG
}

fn invisible(outcome: &Outcome) -> bool {
    outcome.question == Question::Invisible
}

fn absorbed(outcome: &Outcome) -> bool {
    outcome.question == Question::Absorbed
}

fn silent(outcome: &Outcome) -> bool {
    outcome.judgement.none && !outcome.judgement.unexplained
}

/// Judge by postures put aside; what depends on a log's own time by what is reported.
fn predicted_to_noise(outcome: &Outcome) -> bool {
    let judgement = &outcome.judgement;
    let aside = judgement.aside.filter(|_| !drifts(outcome));
    aside.unwrap_or(judgement.held_out) < 1.1
}

fn drifts(outcome: &Outcome) -> bool {
    outcome.judgement.said.contains(Effect::SensorDrift.name())
}

fn drifting(outcome: &Outcome) -> bool {
    known(outcome) && drifts(outcome) && outcome.judgement.aside.is_some()
}

/// The goals, counted.
pub fn goals(outcomes: &[Outcome]) -> Vec<Goal> {
    let counted = GOALS.iter().map(|&(what, asked, bound, is)| {
        let asked = outcomes.iter().filter(|outcome| asked(outcome));
        Goal {
            what,
            bound,
            met: asked.clone().filter(|outcome| is(outcome)).count(),
            of: asked.count(),
        }
    });
    counted.collect()
}

/// The table of goals as text.
pub fn goal_table(goals: &[Goal]) -> String {
    let mut text = String::new();
    for goal in goals.iter().filter(|goal| goal.of > 0) {
        let bound = match goal.bound {
            Bound::Least(share) => format!("at least {:5.1} %", 100.0 * share),
            Bound::Most(share) => format!("at most  {:5.1} %", 100.0 * share),
            Bound::Shown => String::new(),
        };
        let _ = writeln!(
            text,
            "{:52} {bound:16}  found {:5.1} %  ({} of {}){}",
            goal.what,
            100.0 * goal.found(),
            goal.met,
            goal.of,
            if goal.is_met() { "" } else { "   MISSED" }
        );
    }
    text
}

/// One line for every effect: how often it was hidden alone, how it was named.
pub fn effect_table(outcomes: &[Outcome]) -> String {
    let mut rows: BTreeMap<Effect, Vec<&Outcome>> = BTreeMap::new();
    for outcome in outcomes {
        let asked = matches!(outcome.question, Question::Library(1) | Question::Outside);
        if let ([effect], true) = (&outcome.effects[..], asked) {
            rows.entry(*effect).or_default().push(outcome);
        }
    }
    let mut text = format!(
        "{:20} {:>5} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7}  taken for\n",
        "hidden alone", "logs", "name", "target", "group", "class", "aside", "unexpl", "size"
    );
    for (effect, outcomes) in rows {
        let share = |is: &dyn Fn(&Outcome) -> bool| {
            100.0 * outcomes.iter().filter(|o| is(o)).count() as f64 / outcomes.len() as f64
        };
        let groups: usize = outcomes.iter().map(|o| o.judgement.group).sum();
        let mut taken: BTreeMap<&str, usize> = BTreeMap::new();
        for outcome in outcomes.iter().filter(|o| !o.judgement.name) {
            *taken.entry(&outcome.judgement.said_name).or_default() += 1;
        }
        let mut taken: Vec<_> = taken.into_iter().collect();
        taken.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let taken: Vec<String> = taken
            .iter()
            .map(|(name, count)| format!("{name} {count}"))
            .collect();
        let _ = writeln!(
            text,
            "{:20} {:5} {:7.1} {:7.1} {:7.1} {:7.1} {:7.1} {:7.1} {:7.1}  {}",
            effect.name(),
            outcomes.len(),
            share(&|o| o.judgement.name),
            share(&|o| o.judgement.exact),
            share(&|o| o.judgement.in_group),
            share(&|o| o.judgement.class()),
            share(&predicted_to_noise),
            share(&|o| o.judgement.unexplained),
            groups as f64 / outcomes.len() as f64,
            taken.join(", ")
        );
    }
    text
}

/// Every answer that is not right as a class, with the seed to draw it again.
pub fn mistakes(outcomes: &[Outcome]) -> String {
    let mut text = String::new();
    for outcome in outcomes {
        let judgement = &outcome.judgement;
        let right = match outcome.question {
            Question::Library(_) => {
                judgement.name_or_class() && !judgement.unexplained && predicted_to_noise(outcome)
            }
            Question::Outside => judgement.unexplained || judgement.class(),
            _ => judgement.none && !judgement.unexplained,
        };
        if !right {
            let _ = writeln!(
                text,
                "seed {}  chi2 {:.0}  {}\n    said {}{}  held out {:.3}, aside {:.3}",
                outcome.seed,
                outcome.chi2,
                outcome.description,
                judgement.said,
                if judgement.unexplained {
                    ", unexplained"
                } else {
                    ""
                },
                judgement.held_out,
                judgement.aside.unwrap_or(f64::NAN),
            );
        }
    }
    text
}
