//! What a hypothesis is made of: effects, a noise model, a prior model.
//!
//! ```text
//! effect         a rewrite of the measurement at a target, with its unknowns
//! outliers       some readings come from elsewhere: noise of two widths
//! masses         all base parameters are identified again, CAD within tolerances
//! ```
//!
//! Outliers (a foot that slips, a hand on the robot) are named by posture; nothing
//! that most postures share imitates them. Free masses imitate every load and, on
//! one flat foot, offsets and gains too: they are the last resort.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::DMatrix;
use sesc_model::effects::{
    self, Carry, EffectContext, EffectId, Experiment, Fitted, Instance, Stage, Target, Value,
};

/// One term of a hypothesis.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Term {
    /// An effect at its target.
    Effect(Instance),
    /// Noise of two widths: a few readings come from elsewhere.
    Outliers,
    /// The masses within the usual tolerances of CAD, not within the given prior.
    Masses,
}

/// Unknowns of the noise of two widths: its share and its width.
const OUTLIER_UNKNOWNS: usize = 2;
/// The name of free masses in reports, rows and files.
pub(crate) const FREE_MASSES: &str = FREED.0;
/// Names and subjects of terms that are no effects.
const FREED: (&str, &str) = ("mass_distribution", "masses that differ from CAD");
const OUTLIERS: (&str, &str) = ("cop_outliers", "a few readings that come from elsewhere");

/// What a diagnosis may name that is no effect: its name, the kind of thing that it is about, and
/// its page, which begins with a sentence.
#[doc(hidden)]
pub const MODEL_PAGES: [(&str, &str, &str); 2] = [
    (
        FREE_MASSES,
        "the robot",
        include_str!("pages/mass_distribution.md"),
    ),
    (
        OUTLIERS.0,
        "readings",
        include_str!("pages/cop_outliers.md"),
    ),
];

/// What an explanation names, by its effect and target in rows and files, with that label beside
/// it: `an offset of l_knee (joint_offset:l_knee)`.
#[doc(hidden)]
pub fn subject(effect: &str, target: &str) -> String {
    match [FREED, OUTLIERS].into_iter().find(|own| own.0 == effect) {
        Some((name, phrase)) => format!("{phrase} ({name})"),
        None => effects::about::subject(effect, target),
    }
}

/// Each of `terms` with the places of its unknowns among those of all.
pub(super) fn with_places<'t>(
    terms: &'t [Term],
    context: &EffectContext,
) -> impl Iterator<Item = (&'t Term, Range<usize>)> {
    let mut at = 0;
    terms.iter().map(move |term| {
        let own = at..at + term.unknowns(context);
        at = own.end;
        (term, own)
    })
}

impl Term {
    /// The effect, if it is one.
    pub(super) fn effect(&self) -> Option<&Instance> {
        match self {
            Term::Effect(instance) => Some(instance),
            Term::Outliers | Term::Masses => None,
        }
    }

    /// What is fitted for each parameter, if it is an effect.
    pub(super) fn fitted(&self, context: &EffectContext) -> BTreeMap<&'static str, Fitted> {
        let own = self.effect().map(|instance| {
            let parameters = instance.effect.parameters(context, &instance.target);
            parameters.iter().map(|own| (own.name, own.fitted))
        });
        own.into_iter().flatten().collect()
    }

    /// When the effect acts, if it is one.
    pub(super) fn stage(&self) -> Option<Stage> {
        self.effect().map(|instance| instance.effect.stage())
    }

    /// Whether it is of the ground, the sensor or the record, and of all readings alike.
    pub(super) fn is_of_all_readings(&self) -> bool {
        self.effect().is_some_and(|own| {
            let after = own.effect.stage() >= Stage::Ground && own.effect.stage() != Stage::Bends;
            after && own.target == Target::Whole
        })
    }

    /// Number of unknowns that a fit descends in.
    pub(super) fn unknowns(&self, context: &EffectContext) -> usize {
        self.effect().map_or(0, |i| i.unknowns(context))
    }

    /// Number of unknowns that the penalty counts.
    pub(super) fn penalised_unknowns(&self, context: &EffectContext) -> usize {
        match self {
            Term::Outliers => OUTLIER_UNKNOWNS,
            _ => self.unknowns(context),
        }
    }

    /// An ordinary size of each unknown.
    pub(super) fn scales(&self, context: &EffectContext) -> Vec<f64> {
        self.effect().map_or_else(Vec::new, |i| i.scales(context))
    }

    /// Where a fit may start.
    pub(super) fn starts(&self, context: &EffectContext) -> Vec<Vec<f64>> {
        self.effect()
            .map_or_else(|| vec![Vec::new()], |i| i.effect.starts(context, &i.target))
    }

    /// The parameters with the values that these unknowns mean.
    pub(super) fn values(&self, context: &EffectContext, unknowns: &[f64]) -> Vec<Value> {
        self.effect()
            .map_or_else(Vec::new, |i| i.values(context, unknowns))
    }

    /// How far the unknowns are beyond what is physical, per bound.
    pub(super) fn bound_violation(&self, context: &EffectContext, unknowns: &[f64]) -> Vec<f64> {
        self.effect().map_or_else(Vec::new, |i| {
            i.effect.bound_violation(context, &i.target, unknowns)
        })
    }

    /// The width that a fit begins with, where the first unknown is that of a dead band.
    pub(super) fn dead_band(&self) -> Option<f64> {
        self.effect().and_then(|i| i.effect.dead_band())
    }

    /// What becomes of it in a further experiment.
    pub(super) fn in_experiment(&self, experiment: Experiment) -> Carry {
        match self {
            Term::Effect(i) => i.effect.in_experiment(experiment, &i.target),
            Term::Outliers => Carry::Gone,
            Term::Masses => Carry::Same,
        }
    }

    /// Name of its kind in reports: `joint_offset`.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Term::Effect(instance) => instance.effect.id().name(),
            Term::Outliers => OUTLIERS.0,
            Term::Masses => FREE_MASSES,
        }
    }

    /// Name of its target in reports; `-` for the whole robot.
    pub(super) fn target_name(&self, context: &EffectContext) -> String {
        self.effect()
            .map_or_else(|| "-".to_string(), |i| i.target_name(context))
    }

    /// The joint, link, cell or axis that it acts on itself.
    pub(super) fn own_target(&self, context: &EffectContext) -> String {
        self.effect()
            .map_or_else(|| "-".to_string(), |i| context.name_of(&i.target))
    }

    /// `joint_offset:l_knee`; the name alone where there is no target.
    pub(super) fn label(&self, context: &EffectContext) -> String {
        self.effect()
            .map_or_else(|| self.name().to_string(), |i| i.label(context))
    }

    /// The subject of a sentence about it: `an offset of l_knee`.
    pub(super) fn phrase(&self, context: &EffectContext) -> String {
        match self {
            Term::Effect(instance) => instance.phrase(context),
            Term::Outliers => OUTLIERS.1.to_string(),
            Term::Masses => FREED.1.to_string(),
        }
    }

    /// The same with its label: `an offset of l_knee (joint_offset:l_knee)`.
    pub(super) fn subject(&self, context: &EffectContext) -> String {
        format!("{} ({})", self.phrase(context), self.label(context))
    }

    /// Order among terms: that of the catalog, then the models, then targets.
    pub(super) fn rank(&self, context: &EffectContext) -> (usize, Target, EffectId) {
        let effects = context.catalog.iter().len();
        let id = EffectId::new(self.name());
        match self {
            Term::Effect(i) => {
                let id = i.effect.id();
                (context.catalog.rank(id), i.target.clone(), id)
            }
            Term::Outliers => (effects + 1, Target::Whole, id),
            Term::Masses => (effects + 2, Target::Whole, id),
        }
    }

    /// Where it adds something, and what, as a formula.
    pub(super) fn form(&self) -> (String, String) {
        match self.effect().and_then(|i| i.effect.composed()) {
            Some(own) => {
                let definition = own.definition();
                (definition.site.to_string(), definition.function.to_string())
            }
            None => {
                let (site, function) = effects::about::form(self.name());
                (site.to_string(), function.to_string())
            }
        }
    }

    /// Whether it is a function at a site.
    pub(super) fn is_composed(&self) -> bool {
        self.effect().is_some_and(|i| i.effect.composed().is_some())
    }

    /// Whether it may stand beside another: not twice, not one joint and all joints
    /// by the same effect, not two foot cells, no outliers beside a function.
    pub(super) fn is_compatible(&self, other: &Term) -> bool {
        let (Some(a), Some(b)) = (self.effect(), other.effect()) else {
            // What a function leaves where it is the wrong one looks like outliers.
            let both = [self, other];
            let guessed = both.contains(&&Term::Outliers) && both.iter().any(|x| x.is_composed());
            return self.name() != other.name() && !guessed;
        };
        let same = a.effect.id() == b.effect.id();
        let all = a.target == Target::AllJoints || b.target == Target::AllJoints;
        let cells = a.effect.stage() == Stage::Cells && b.effect.stage() == Stage::Cells;
        !(same && (a.target == b.target || all)) && !cells
    }
}

/// The effects among terms, in their order.
pub(super) fn effects_of(terms: &[Term]) -> Vec<Instance> {
    terms.iter().filter_map(Term::effect).cloned().collect()
}

/// Every effect that the robot and its log allow, as terms.
pub(super) fn effect_terms(context: &EffectContext) -> Vec<Term> {
    let instances = effects::instances(context).into_iter();
    instances.map(Term::Effect).collect()
}

/// So many of each kind, and so many of all, that come first.
pub(super) fn keep_some<T, K: Ord>(
    all: &mut Vec<T>,
    kind: impl Fn(&T) -> K,
    of_each: usize,
    most: usize,
) {
    let mut seen: BTreeMap<K, usize> = BTreeMap::new();
    all.retain(|one| {
        let count = seen.entry(kind(one)).or_default();
        *count += 1;
        *count <= of_each
    });
    all.truncate(most);
}

/// Whether a term may stand beside others.
pub(super) fn compatible(terms: &[Term], more: &Term) -> bool {
    terms.iter().all(|term| term.is_compatible(more))
}

/// Terms in the order of their ranks.
pub(super) fn sorted(context: &EffectContext, terms: &[Term]) -> Vec<Term> {
    let mut all = terms.to_vec();
    all.sort_by_cached_key(|term| term.rank(context));
    all
}

/// An explanation of a log in the parameters of a further experiment.
pub(super) struct CarriedExplanation {
    pub terms: Vec<Term>,
    pub unknowns: Vec<f64>,
    /// Each of the unknowns: which one of the log's it is, and its sign; a weight that is carried
    /// is none of them.
    pub columns: Vec<(usize, f64)>,
}

impl CarriedExplanation {
    /// Slopes by the unknowns here as slopes by the `count` unknowns of the log.
    pub(super) fn by_unknowns(&self, slopes: &DMatrix<f64>, count: usize) -> DMatrix<f64> {
        let mut all = DMatrix::zeros(slopes.nrows(), count);
        for (own, &(k, sign)) in slopes.column_iter().zip(&self.columns) {
            let mut to = all.column_mut(k);
            to += own * sign;
        }
        all
    }
}

/// The same term on the robot `there`, if it has such a target.
fn moved(term: &Term, here: &EffectContext, there: &EffectContext) -> Option<Term> {
    let Some(instance) = term.effect() else {
        return Some(term.clone());
    };
    let name = here.name_of(&instance.target);
    let target = there.target_named(instance.effect, &name)?;
    let effect = instance.effect;
    Some(Term::Effect(Instance { effect, target }))
}

/// What becomes of `terms` of the robot `here` with their unknowns, if anything, in an experiment
/// `there`; all of them where it is none.
pub(super) fn carried(
    experiment: Option<Experiment>,
    (here, there): (&EffectContext, &EffectContext),
    (terms, unknowns): (&[Term], &[f64]),
) -> CarriedExplanation {
    let (mut carried, mut columns) = (Vec::new(), Vec::new());
    for (term, own) in with_places(terms, here) {
        let (there, carry) = match experiment {
            None => (Some(term.clone()), Carry::Same),
            Some(experiment) => (moved(term, here, there), term.in_experiment(experiment)),
        };
        let factors = match carry {
            Carry::Gone => continue,
            Carry::Scaled(factors) => factors,
            Carry::Same => vec![1.0; own.len()],
        };
        if let Some(there) = there {
            carried.push(there);
            columns.extend(own.zip(factors));
        }
    }
    let unknowns = columns.iter().map(|(k, sign)| sign * unknowns[*k]);
    CarriedExplanation {
        terms: carried,
        unknowns: unknowns.collect(),
        columns,
    }
}
