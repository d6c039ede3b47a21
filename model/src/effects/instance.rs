//! Effects at their targets, and how a set of them is written into a measurement.
//!
//! Effects act stage by stage; those of one stage in the order in which they are given.

use std::hash::{Hash, Hasher};

use super::{Effect, EffectContext, Measured, Parameter, Stage, Target, Value};
use crate::expr::Id;

/// An effect at its target.
#[derive(Clone)]
pub struct Instance {
    /// Which effect.
    pub effect: &'static dyn Effect,
    /// The joint, link or cell that it acts on.
    pub target: Target,
}

impl PartialEq for Instance {
    fn eq(&self, other: &Instance) -> bool {
        self.effect.id() == other.effect.id() && self.target == other.target
    }
}

impl Eq for Instance {}

impl Hash for Instance {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.effect.id(), &self.target).hash(state);
    }
}

impl std::fmt::Debug for Instance {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{:?}:{:?}", self.effect.id(), self.target)
    }
}

impl Instance {
    /// Number of unknowns.
    pub fn unknowns(&self, context: &EffectContext) -> usize {
        self.effect.parameters(context, &self.target).len()
    }

    /// An ordinary size of each unknown.
    pub fn scales(&self, context: &EffectContext) -> Vec<f64> {
        let parameters = self.effect.parameters(context, &self.target);
        parameters.iter().map(|parameter| parameter.scale).collect()
    }

    /// The parameters with the values that these unknowns mean.
    pub fn values(&self, context: &EffectContext, unknowns: &[f64]) -> Vec<Value> {
        let parameters = self.effect.parameters(context, &self.target);
        let values = self.effect.values(context, &self.target, unknowns);
        let pairs = parameters.iter().zip(values);
        pairs
            .map(|(&Parameter { name, .. }, value)| Value { name, value })
            .collect()
    }

    /// The target as reports name it; `-` where it is no part of the label.
    pub fn target_name(&self, context: &EffectContext) -> String {
        let own = match self.effect.label_has_target() {
            true => context.name_of(&self.target),
            false => return "-".to_string(),
        };
        let others = self.effect.composed().into_iter();
        let others = others.flat_map(|composed| composed.other_joints(&own));
        [own.clone()]
            .into_iter()
            .chain(others)
            .collect::<Vec<_>>()
            .join(",")
    }

    /// `joint_offset:l_knee`; the name alone where there is no target.
    pub fn label(&self, context: &EffectContext) -> String {
        let name = self.effect.id().name();
        match self.target_name(context).as_str() {
            "-" => name.to_string(),
            target => format!("{name}:{target}"),
        }
    }

    /// The subject of a sentence about it: `an offset of l_knee`.
    pub fn phrase(&self, context: &EffectContext) -> String {
        self.effect
            .phrase(&self.target, &context.spoken_name(&self.target))
    }
}

/// Every instance that the robot and its log allow.
pub fn instances(context: &EffectContext) -> Vec<Instance> {
    let of = |effect: &'static dyn Effect| {
        let targets = effect.targets(context).into_iter();
        targets.map(move |target| Instance { effect, target })
    };
    context.catalog.iter().flat_map(of).collect()
}

/// Instances with their own unknowns in the order of their stages; those of one
/// stage as they are given. Split at the CoP.
#[allow(clippy::type_complexity)]
fn by_stage<'i>(
    context: &EffectContext,
    instances: &'i [Instance],
    unknowns: &'i [Id],
) -> [Vec<(&'i Instance, &'i [Id])>; 2] {
    let mut parts = Vec::with_capacity(instances.len());
    let mut rest = unknowns;
    for instance in instances {
        let (own, after) = rest.split_at(instance.unknowns(context));
        parts.push((instance, own));
        rest = after;
    }
    parts.sort_by_key(|(instance, _)| instance.effect.stage());
    let split = parts.partition_point(|(instance, _)| instance.effect.stage() <= Stage::Bends);
    let after = parts.split_off(split);
    [parts, after]
}

/// Write `instances` into the nominal measurement, stage by stage, with
/// `unknowns` in the order of the instances.
pub(crate) fn apply(
    measured: &mut Measured,
    context: &EffectContext,
    instances: &[Instance],
    unknowns: &[Id],
) {
    let [_, after] = by_stage(context, instances, unknowns);
    apply_before_sensor(measured, context, instances, unknowns);
    measured.stand(context.moving);
    for (instance, own) in after {
        instance.effect.rewrite(&instance.target, measured, own);
    }
    measured.record();
}

/// How the reading of [`apply`] moves with what encoders read: rows x and y.
pub(crate) fn reading_slopes(
    measured: &mut Measured,
    context: &EffectContext,
    instances: &[Instance],
    unknowns: &[Id],
) -> Vec<Id> {
    let [_, after] = by_stage(context, instances, unknowns);
    apply_before_sensor(measured, context, instances, unknowns);
    measured.stand(context.moving);
    let slopes = measured.cop_slopes();
    measured.through(&slopes, |measured| {
        for (instance, own) in after {
            instance.effect.rewrite(&instance.target, measured, own);
        }
        measured.record();
    })
}

/// The part of [`apply`] that comes before the CoP: where the joints are, and the loads.
pub(crate) fn apply_before_sensor(
    measured: &mut Measured,
    context: &EffectContext,
    instances: &[Instance],
    unknowns: &[Id],
) {
    apply_to_body(measured, context, instances, unknowns);
    measured.bend(context.rounds);
}

/// The same before any joint gives way.
pub(crate) fn apply_to_body(
    measured: &mut Measured,
    context: &EffectContext,
    instances: &[Instance],
    unknowns: &[Id],
) {
    let [before, _] = by_stage(context, instances, unknowns);
    for (instance, own) in before {
        instance.effect.rewrite(&instance.target, measured, own);
    }
}

/// The sensor's part of [`apply`], from a CoP in [`Measured::reading`].
pub(crate) fn sense(
    measured: &mut Measured,
    context: &EffectContext,
    instances: &[Instance],
    unknowns: &[Id],
) {
    let [before, after] = by_stage(context, instances, unknowns);
    for (instance, own) in before.into_iter().chain(after) {
        instance.effect.rewrite(&instance.target, measured, own);
    }
    measured.record();
}

/// The inverse of [`sense`]: last stage first.
pub(crate) fn undo(
    measured: &mut Measured,
    context: &EffectContext,
    instances: &[Instance],
    unknowns: &[Id],
) {
    let [before, after] = by_stage(context, instances, unknowns);
    // The record's unit.
    for (instance, own) in before {
        instance.effect.rewrite(&instance.target, measured, own);
    }
    measured.unrecord();
    let of_cells = |part: &&(&Instance, &[Id])| part.0.effect.stage() == Stage::Cells;
    let cells: Vec<_> = after.iter().filter(of_cells).collect();
    for (instance, own) in after.iter().rev().filter(|part| !of_cells(part)) {
        instance.effect.undo(&instance.target, measured, own);
    }
    if !cells.is_empty() {
        measured.solve(|at| {
            at.foot = None;
            for (instance, own) in &cells {
                instance.effect.rewrite(&instance.target, at, own);
            }
        });
    }
}
