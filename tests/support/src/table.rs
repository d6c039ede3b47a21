//! The study in figures: the goals, and who was taken for whom.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::hidden::Effect;
use crate::survey::Outcome;
use crate::trial::Question;

use Bound::{Least, Most, Shown};

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
                Least(share) => found >= share,
                Most(share) => found <= share,
                Shown => true,
            }
    }
}

/// Shown as strongly as the unmodelled effects of the open logs are.
const STRONG: f64 = 4000.0;

type Is = fn(&Outcome) -> bool;

/// What is counted: of which outcomes, how many, and which of them.
macro_rules! goals {
    ($($what:literal: $of:ident, $bound:expr, $is:ident;)+) => {
        [$(($what, $of, $bound, $is)),+]
    };
}

/// What the study is to show: of which logs at least (or at most) which share
/// is to be how. Where no share is asked, it is for comparison.
const GOALS: [(&str, Is, Bound, Is); 21] = goals! {
    "one effect: named, or of its class": one, Least(0.95), name_or_class;
    "one effect: named exactly": one, Least(0.87), name;
    "one effect: target right, or of its class": one, Least(0.93), class;
    "one effect: truth inside the group": one, Least(0.97), in_group;
    "nothing hidden: false alarms": nothing, Most(0.01), loud;
    "two effects: class": two, Least(0.88), class;
    "two effects: both named exactly": two, Least(0.78), name;
    "two effects: both names and targets": two, Shown, exact;
    "three effects: class": three, Least(0.85), class;
    "one effect: postures put aside below 1.1 noises": one, Least(0.97), predicted_to_noise;
    "two effects: postures put aside below 1.1 noises": two, Least(0.95), predicted_to_noise;
    "one effect: held out below 1.1, as reported": one, Shown, held_out;
    "two effects: held out below 1.1, as reported": two, Shown, held_out;
    "drift named: postures put aside below 1.1 noises": drifting, Shown, aside;
    "outside the library: unexplained, or at its place": outside, Shown, placed;
    "... shown with chi2 above 4000: the same": strongly_outside, Least(1.0), placed;
    "... the same, or imitated to within noise": outside, Shown, imitated;
    "hanging load: payload at its hinge, or unexplained": hanging, Least(1.0), hinged;
    "known effects: unexplained": known, Most(0.02), unexplained;
    "invisible here: none": invisible, Least(0.95), silent;
    "masses as CAD is trusted: none": absorbed, Least(0.95), silent;
};

/// Facts of an outcome by name.
macro_rules! facts {
    ($($name:ident: $o:ident => $fact:expr;)+) => {
        $(fn $name($o: &Outcome) -> bool { $fact })+
    };
}

facts! {
    name: o => o.judgement.name;
    exact: o => o.judgement.exact;
    class: o => o.judgement.class();
    name_or_class: o => o.judgement.name_or_class();
    in_group: o => o.judgement.in_group;
    held_out: o => o.judgement.held_out < 1.1;
    aside: o => o.judgement.aside.is_some_and(|aside| aside < 1.1);
    unexplained: o => o.judgement.unexplained;
    placed: o => o.judgement.unexplained || o.judgement.at_place;
    imitated: o => placed(o) || o.judgement.imitates;
    hinged: o => o.judgement.class() || o.judgement.unexplained;
    silent: o => o.judgement.none && !o.judgement.unexplained;
    loud: o => !silent(o);
    one: o => o.question == Question::Library(1);
    two: o => o.question == Question::Library(2);
    three: o => o.question == Question::Library(3);
    known: o => matches!(o.question, Question::Library(_));
    nothing: o => o.question == Question::Nothing;
    hanging: o => o.question == Question::Outside && o.effects == [Effect::HangingLoad];
    outside: o => o.question == Question::Outside && !hanging(o);
    strongly_outside: o => outside(o) && o.chi2 > STRONG;
    invisible: o => o.question == Question::Invisible;
    absorbed: o => o.question == Question::Absorbed;
    drifts: o => o.judgement.said.contains(Effect::SensorDrift.name());
    drifting: o => known(o) && drifts(o) && o.judgement.aside.is_some();
}

/// Judge by postures put aside; what depends on a log's own time by what is reported.
fn predicted_to_noise(outcome: &Outcome) -> bool {
    let judgement = &outcome.judgement;
    let aside = judgement.aside.filter(|_| !drifts(outcome));
    aside.unwrap_or(judgement.held_out) < 1.1
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
            Least(share) => format!("at least {:5.1} %", 100.0 * share),
            Most(share) => format!("at most  {:5.1} %", 100.0 * share),
            Shown => String::new(),
        };
        let _ = writeln!(
            text,
            "{:52} {bound:16}  found {:5.1} %  ({} of {}){}",
            goal.what,
            100.0 * goal.found(),
            goal.met,
            goal.of,
            ["   MISSED", ""][usize::from(goal.is_met())]
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
        let share = |is: Is| {
            100.0 * outcomes.iter().filter(|o| is(o)).count() as f64 / outcomes.len() as f64
        };
        let groups: usize = outcomes.iter().map(|o| o.judgement.group).sum();
        let mut taken: BTreeMap<&str, usize> = BTreeMap::new();
        for outcome in outcomes.iter().filter(|o| !o.judgement.name) {
            *taken.entry(&outcome.judgement.said_name).or_default() += 1;
        }
        let mut taken: Vec<_> = taken.into_iter().collect();
        taken.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let taken = taken.iter().map(|(name, count)| format!("{name} {count}"));
        let taken: Vec<String> = taken.collect();
        let _ = writeln!(
            text,
            "{:20} {:5} {:7.1} {:7.1} {:7.1} {:7.1} {:7.1} {:7.1} {:7.1}  {}",
            effect.name(),
            outcomes.len(),
            share(name),
            share(exact),
            share(in_group),
            share(class),
            share(predicted_to_noise),
            share(unexplained),
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
                ["", ", unexplained"][usize::from(judgement.unexplained)],
                judgement.held_out,
                judgement.aside.unwrap_or(f64::NAN),
            );
        }
    }
    text
}
