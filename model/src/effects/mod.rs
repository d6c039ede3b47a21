//! Effects: what a real robot does that its URDF does not say.
//!
//! Each effect is a rewrite of the symbolic measurement ([`Measured`]), with
//! its unknowns as expressions; derivatives, fits, Rust and C follow from that
//! one text, and so does the way back from a reading. A new effect is one file and
//! one line in [`LIST`].
//!
//! An *instance* is an effect at its target: `joint_offset` of `l_knee`.

mod axes;
mod backlash;
pub mod cells;
mod external_force;
mod ground_slope;
mod joint_compliance;
mod joint_offset;
mod joint_scale;
mod joint_sign;
mod joint_swap;
mod payload;
mod sensor_drift;
mod sensor_gain;
mod sensor_offset;
mod sensor_rotation;
mod setting;
mod time_delay;
mod units;
mod unsettled_motion;
mod whole;

use crate::expr::Id;
pub use crate::functions::circumstances::{Circumstances, Source};
pub use crate::functions::correction::perceived;
pub use crate::functions::diagnosis::{foretelling, joints, moments, reading};
pub use crate::functions::measured::{Measured, ROUNDS};
pub use setting::{Setting, Target};

/// When an effect comes in, first to last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Stage {
    /// Which channel is which joint, in what unit.
    Wiring,
    /// Encoder to joint position.
    Joints,
    /// Masses and forces.
    Loads,
    /// The ground.
    Ground,
    /// Joints that give way to gravity.
    Bends,
    /// The foot's cells.
    Cells,
    /// CoP to reading: its scale,
    Gain,
    /// its direction,
    Rotation,
    /// its zero.
    Offset,
    /// The record: order and units of readings.
    Record,
    /// No rewrite: noise, or the parameters themselves.
    Whole,
}

/// A quantity as people know it.
#[derive(Debug, Clone, PartialEq)]
pub struct Value {
    /// With its unit: `offset_rad`, `mass_kg`.
    pub name: &'static str,
    pub value: f64,
}

/// One kind of imperfection.
pub trait Effect: Sync {
    /// As in reports and model files: `joint_offset`.
    fn name(&self) -> &'static str;

    fn stage(&self) -> Stage;

    /// Everything it can be the matter with, on this robot and in this log.
    fn targets(&self, setting: &Setting) -> Vec<Target>;

    /// A size of each unknown that is ordinary; its count is the number of unknowns.
    fn scales(&self, setting: &Setting, target: &Target) -> Vec<f64>;

    /// Where a fit may start; no effect at all unless that has no slope.
    fn starts(&self, setting: &Setting, target: &Target) -> Vec<Vec<f64>> {
        vec![vec![0.0; self.scales(setting, target).len()]]
    }

    /// Write the effect into the measurement; one expression per unknown.
    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]);

    /// What the unknowns mean.
    fn values(&self, setting: &Setting, target: &Target, unknowns: &[f64]) -> Vec<Value>;

    /// The unknowns that have these values, in the order of [`Effect::values`].
    fn unknowns(&self, setting: &Setting, target: &Target, values: &[f64]) -> Vec<f64>;

    /// How far the unknowns are beyond what is physical, in units in which 1 is
    /// clearly too far; one entry per bound, zero within it.
    fn excess(&self, _: &Setting, _: &Target, _: &[f64]) -> Vec<f64> {
        Vec::new()
    }

    /// What keeps a robot from having these values (in the order of
    /// [`Effect::values`]), in words that name the remedy.
    fn fault(&self, _: &Setting, _: &Target, _: &[f64]) -> Option<&'static str> {
        None
    }

    /// What a reader of rounding bounds must know of it.
    fn caution(&self) -> Option<&'static str> {
        None
    }

    /// Whether a posture alone, without the log around it, shows the effect, so
    /// that it can be part of generated code.
    fn of_posture(&self) -> bool {
        true
    }

    /// Whether it comes between the CoP and its reading, so that a reading can be
    /// freed from it.
    fn of_sensor(&self, _: &Target) -> bool {
        (Stage::Cells..=Stage::Record).contains(&self.stage())
    }

    /// Take the effect back: the reading with it becomes the one without.
    ///
    /// Unless there is a closed form, [`Effect::rewrite`] is solved for its CoP.
    /// Faults of cells share their loads and are solved together.
    fn undo(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        at.solve(|at| self.rewrite(target, at, unknowns));
    }
}

/// All effects, in the order in which ties are broken: the plainest first.
pub const LIST: &[&dyn Effect] = &[
    &sensor_offset::SensorOffset,
    &sensor_rotation::SensorRotation,
    &sensor_gain::SensorGain,
    &ground_slope::GroundSlope,
    &joint_offset::JointOffset,
    &joint_scale::JointScale,
    &joint_compliance::JointCompliance,
    &backlash::Backlash,
    &payload::Payload,
    &external_force::ExternalForce,
    &sensor_drift::SensorDrift,
    &cells::Gain,
    &cells::Offset,
    &cells::Exponent,
    &cells::Saturation,
    &time_delay::TimeDelay,
    &unsettled_motion::UnsettledMotion,
    &joint_sign::JointSign,
    &joint_swap::JointSwap,
    &axes::SensorAxes,
    &units::Units,
    &whole::CopOutliers,
    &whole::MassDistribution,
];

/// The effect of this name.
pub fn named(name: &str) -> Option<&'static dyn Effect> {
    LIST.iter().copied().find(|effect| effect.name() == name)
}

/// An effect at its target.
#[derive(Clone)]
pub struct Instance {
    pub effect: &'static dyn Effect,
    pub target: Target,
}

impl PartialEq for Instance {
    fn eq(&self, other: &Instance) -> bool {
        self.effect.name() == other.effect.name() && self.target == other.target
    }
}

impl std::fmt::Debug for Instance {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{}:{:?}", self.effect.name(), self.target)
    }
}

impl Instance {
    /// Number of unknowns.
    pub fn unknowns(&self, setting: &Setting) -> usize {
        self.effect.scales(setting, &self.target).len()
    }

    /// `joint_offset:l_knee`; the name alone where there is no target.
    pub fn label(&self, setting: &Setting) -> String {
        match setting.name_of(&self.target) {
            // Which unit it is belongs to the finding, not to its name.
            target if target == "-" || self.effect.name() == "units" => {
                self.effect.name().to_string()
            }
            target => format!("{}:{target}", self.effect.name()),
        }
    }
}

/// Every instance that can be the matter.
pub fn instances(setting: &Setting) -> Vec<Instance> {
    let of = |effect: &&'static dyn Effect| {
        let effect = *effect;
        let targets = effect.targets(setting).into_iter();
        targets.map(move |target| Instance { effect, target })
    };
    LIST.iter().flat_map(of).collect()
}

/// Instances with their own unknowns in the order of their stages; those of one
/// stage as they are given. Split at the CoP.
#[allow(clippy::type_complexity)]
fn by_stage<'i>(
    setting: &Setting,
    instances: &'i [Instance],
    unknowns: &'i [Id],
) -> [Vec<(&'i Instance, &'i [Id])>; 2] {
    let mut parts = Vec::with_capacity(instances.len());
    let mut rest = unknowns;
    for instance in instances {
        let (own, after) = rest.split_at(instance.unknowns(setting));
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
    setting: &Setting,
    instances: &[Instance],
    unknowns: &[Id],
) {
    let [before, after] = by_stage(setting, instances, unknowns);
    for (instance, own) in before {
        instance.effect.rewrite(&instance.target, measured, own);
    }
    measured.bend();
    measured.stand();
    for (instance, own) in after {
        instance.effect.rewrite(&instance.target, measured, own);
    }
    measured.record();
}

/// The sensor's part of [`apply`], from a CoP in [`Measured::reading`].
pub(crate) fn sense(
    measured: &mut Measured,
    setting: &Setting,
    instances: &[Instance],
    unknowns: &[Id],
) {
    let [before, after] = by_stage(setting, instances, unknowns);
    for (instance, own) in before.into_iter().chain(after) {
        instance.effect.rewrite(&instance.target, measured, own);
    }
    measured.record();
}

/// The inverse of [`sense`]: last stage first.
pub(crate) fn undo(
    measured: &mut Measured,
    setting: &Setting,
    instances: &[Instance],
    unknowns: &[Id],
) {
    let [before, after] = by_stage(setting, instances, unknowns);
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

/// Values that are what their names say.
fn plain(names: &[&'static str], values: &[f64]) -> Vec<Value> {
    let pairs = names.iter().zip(values);
    pairs.map(|(&name, &value)| Value { name, value }).collect()
}

/// How far |x| is beyond `most`, in units of `unit`.
fn beyond(x: f64, most: f64, unit: f64) -> Vec<f64> {
    vec![(libm::fabs(x) - most).max(0.0) / unit]
}
