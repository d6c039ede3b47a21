//! What the diagnoser said, against the truth.
//!
//! An answer is right *as a class* where one of these holds:
//!
//! * it is the truth, effect by effect, target by target;
//! * the truth is among the explanations that it calls indistinguishable;
//! * the data cannot tell: refitted on the same postures, the answer leaves at
//!   most 9 more of chi2 than the truth, with at most one parameter more.
//!
//! An extra `cop_outliers` beside backlash is no mistake: in a wide dead band
//! single postures fall to either side.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::hidden::{Effect, Hidden, NOWHERE};
use crate::refit::Refit;
use crate::trial::Trial;

/// Three standard deviations: what noise alone may cost.
const NOISE_ALLOWS: f64 = 9.0;

/// Labels `effect` or `effect:target`, without order.
pub type Labels = BTreeSet<String>;

/// The parts of an answer that are judged.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answer {
    /// The verdict's name.
    pub verdict: String,
    /// Labels of the effects that are named.
    pub steps: Labels,
    /// Labels of every explanation that the data cannot tell apart.
    pub groups: Vec<Labels>,
    /// Whether something is left that nothing explains.
    pub unexplained: bool,
    /// RMS residual on held-out postures, m.
    pub final_rmse: f64,
    /// The noise that it is compared with, m.
    pub noise_floor: f64,
}

impl Answer {
    /// Reads the diagnoser's JSON.
    ///
    /// # Errors
    /// Where it is not as the contract has it.
    pub fn read(json: &Value) -> Result<Answer, String> {
        Answer::of(json).ok_or_else(|| format!("no answer of the contract: {json}"))
    }

    fn of(json: &Value) -> Option<Answer> {
        let step = |step: &Value| Some(label(step["effect"].as_str()?, step["target"].as_str()?));
        let one = |one: &Value| {
            let one = one.as_str()?;
            let (effect, target) = one.split_once(':').unwrap_or((one, NOWHERE));
            Some(label(effect, target))
        };
        let group = |group: &Value| group.as_array()?.iter().map(one).collect();
        let groups = json["indistinguishable"].as_array()?.iter().map(group);
        Some(Answer {
            verdict: json["verdict"].as_str()?.to_owned(),
            steps: json["steps"]
                .as_array()?
                .iter()
                .map(step)
                .collect::<Option<_>>()?,
            groups: groups.collect::<Option<_>>()?,
            unexplained: json["unexplained"].as_bool()?,
            final_rmse: json["final"]["rmse"].as_f64()?,
            noise_floor: json["noise_floor"].as_f64()?,
        })
    }

    /// Whether it names the truth, effect by effect and target by target.
    pub fn is(&self, truth: &Labels) -> bool {
        without_excuses(&self.steps, truth) == *truth
    }

    /// Whether the truth is what it names, or among what it calls indistinguishable.
    pub fn lists(&self, truth: &Labels) -> bool {
        let is = |group: &Labels| without_excuses(group, truth) == *truth;
        self.is(truth) || self.groups.iter().any(is)
    }
}

/// One answer, judged.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Judgement {
    /// The names of all effects are right.
    pub name: bool,
    /// Names and targets.
    pub exact: bool,
    /// The truth is in the group that the answer names.
    pub in_group: bool,
    /// The data cannot tell it from the truth.
    pub twin: bool,
    /// The number of explanations in the group.
    pub group: usize,
    /// Nothing is said to be hidden.
    pub none: bool,
    /// Something is said to be left that nothing explains.
    pub unexplained: bool,
    /// All of it acts on the one part where something is hidden.
    pub at_place: bool,
    /// The answer leaves no more than noise might, whatever it is made of.
    pub imitates: bool,
    /// RMSE on held-out postures over the noise floor, as the diagnoser has it.
    pub held_out: f64,
    /// The same of its model on postures that it never saw, with the true noise.
    pub aside: Option<f64>,
    /// The answer, for the table of confusions.
    pub said: String,
    /// Its effects without their targets.
    pub said_name: String,
}

impl Judgement {
    /// Compares an answer with the truth.
    pub fn of(answer: &Answer, trial: &Trial) -> Judgement {
        let truth = truth(&trial.hidden);
        let steps = without_excuses(&answer.steps, &truth);
        let exact = answer.is(&truth);
        Judgement {
            name: names(&steps) == names(&truth),
            exact,
            in_group: answer.lists(&truth),
            twin: exact || is_twin(&steps, trial),
            at_place: is_at_place(&steps, &truth),
            imitates: exact || imitates(&answer.steps, trial),
            aside: None,
            group: answer.groups.len(),
            none: answer.steps.is_empty(),
            unexplained: answer.unexplained,
            held_out: answer.final_rmse / answer.noise_floor,
            said: joined(&answer.steps),
            said_name: joined(&names(&steps).into_iter().collect()),
        }
    }

    /// Right as a class.
    pub fn class(&self) -> bool {
        self.exact || self.in_group || self.twin
    }

    /// Right in the effects' names, or as a class.
    pub fn name_or_class(&self) -> bool {
        self.name || self.class()
    }
}

/// What should be said. A hanging load is a payload at its hinge.
pub fn truth(hidden: &[Hidden]) -> Labels {
    let labels = hidden.iter().map(|hidden| match hidden.effect {
        Effect::HangingLoad => label(Effect::Payload.name(), &hidden.target),
        effect => label(effect.name(), &hidden.target),
    });
    labels.collect()
}

fn label(effect: &str, target: &str) -> String {
    let mut ends: Vec<&str> = target.split(',').map(str::trim).collect();
    ends.sort_unstable();
    if target == NOWHERE || target.is_empty() {
        effect.to_owned()
    } else {
        format!("{effect}:{}", ends.join(","))
    }
}

/// The names alone; two of a kind count as two.
pub fn names(labels: &Labels) -> Vec<String> {
    let names = labels.iter().map(|label| label.split(':').next());
    let mut names: Vec<String> = names.map(|name| name.unwrap_or("").to_owned()).collect();
    names.sort_unstable();
    names
}

fn joined(labels: &Labels) -> String {
    if labels.is_empty() {
        "none".to_owned()
    } else {
        labels.iter().cloned().collect::<Vec<_>>().join(" + ")
    }
}

fn without_excuses(said: &Labels, truth: &Labels) -> Labels {
    let outliers = Effect::CopOutliers.name();
    let is_loose = |label: &String| label.starts_with(Effect::Backlash.name());
    let mut said = said.clone();
    if truth.iter().any(is_loose) && !truth.contains(outliers) {
        said.remove(outliers);
    }
    said
}

/// An explanation by labels, sizes left open.
fn explanation(labels: &Labels) -> Option<Vec<Hidden>> {
    let hidden = labels.iter().map(|label| {
        let (effect, target) = label.split_once(':').unwrap_or((label, NOWHERE));
        let effect = Effect::named(effect).filter(|effect| !effect.is_outside())?;
        let can_refit = !matches!(effect, Effect::MassDistribution | Effect::Units);
        can_refit.then(|| Hidden::new(effect, target, &vec![0.0; effect.parameters()]))
    });
    hidden.collect()
}

fn parameters(hidden: &[Hidden]) -> usize {
    hidden.iter().map(|hidden| hidden.effect.parameters()).sum()
}

/// What the truth leaves, and what the answer leaves when it is refitted.
fn left_over(said: &[Hidden], trial: &Trial) -> (f64, f64) {
    let outliers = |hidden: &[Hidden]| hidden.iter().any(|h| h.effect == Effect::CopOutliers);
    let robust = outliers(said) || outliers(&trial.hidden);
    let refit = Refit::new(&trial.stage, &trial.log, robust);
    (refit.least(&trial.hidden), refit.least_from_nothing(said))
}

/// What is said explains the data as well as the truth does.
fn is_twin(steps: &Labels, trial: &Trial) -> bool {
    let Some(said) = explanation(steps).filter(|said| !said.is_empty()) else {
        return false;
    };
    let misses_outliers = truth(&trial.hidden).contains(Effect::CopOutliers.name())
        && !steps.contains(Effect::CopOutliers.name());
    if misses_outliers || parameters(&said) > parameters(&trial.hidden) + 1 {
        return false;
    }
    let (truth, answer) = left_over(&said, trial);
    answer <= truth + NOISE_ALLOWS
}

/// Whether all steps act on the one part where something is hidden.
fn is_at_place(steps: &Labels, truth: &Labels) -> bool {
    let place = |label: &String| {
        let (_, target) = label.split_once(':')?;
        Some(target.split(',').next().unwrap_or(target).to_string())
    };
    let hidden: Vec<_> = truth.iter().map(place).collect();
    let all = |of: &Option<String>| steps.iter().all(|own| place(own) == *of);
    matches!(&hidden[..], [one] if one.is_some() && !steps.is_empty() && all(one))
}

/// What is said, refitted, leaves no more than noise might: three standard
/// deviations of chi2, each parameter paid for.
fn imitates(steps: &Labels, trial: &Trial) -> bool {
    let Some(said) = explanation(steps) else {
        return false;
    };
    let expected = 2.0 * trial.log.cop.len() as f64;
    let (_, answer) = left_over(&said, trial);
    answer + parameters(&said) as f64 <= expected + 3.0 * (2.0 * expected).sqrt()
}
