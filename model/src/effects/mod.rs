//! Effects: what a real robot does that its URDF does not say.
//!
//! ```text
//! y = h(q; e)        e = 0: the nominal measurement
//! ```
//!
//! Each effect is a rewrite of the symbolic measurement ([`Measured`]) with its
//! unknowns e as expressions; derivatives, fits, Rust and C follow from that one
//! text, and so does the inverse of a sensor. Whatever else is known of an effect
//! (its sentence, bounds, load, edit of a URDF, behaviour in an experiment) is a
//! method of [`Effect`]: a new effect is one file and one line in `standard.rs`, or a site and a
//! formula in a file of the user's ([`Composed`]).

/// Name, stage and page of an effect of this crate, and what of an [`EffectContext`] it acts on.
macro_rules! kind {
    ($name:literal, $stage:ident $(, $targets:ident)?) => {
        fn id(&self) -> $crate::effects::EffectId {
            $crate::effects::EffectId::new($name)
        }

        fn page(&self) -> &'static str {
            include_str!(concat!("pages/", $name, ".md"))
        }

        fn stage(&self) -> $crate::effects::Stage {
            $crate::effects::Stage::$stage
        }

        $(fn targets(&self, context: &EffectContext) -> Vec<Target> {
            context.$targets()
        })?
    };
}

pub mod about;
mod axes;
mod backlash;
mod catalog;
mod cells;
mod composed;
mod context;
mod experiment;
mod external_force;
mod ground_slope;
mod instance;
mod joint_compliance;
mod joint_offset;
mod joint_scale;
mod joint_sign;
mod joint_swap;
mod own;
mod parameter;
mod payload;
pub mod plausible;
mod programs;
pub mod remedy;
mod sensor_drift;
mod sensor_gain;
mod sensor_offset;
mod sensor_rotation;
mod standard;
mod time_delay;
mod units;

use crate::expr::Id;
pub use crate::measurement::foot::rectangle as foot_rectangle;
pub use crate::measurement::{ContextSource, Measured, PostureContext, ROUNDS};
use crate::urdf::{Load, Shift};
pub use catalog::{Catalog, EffectId};
pub use composed::{Composed, Constant, Definition, NO_UNIT, Site};
pub use context::{EffectContext, Target};
pub use experiment::{Carry, Experiment};
pub use instance::{Instance, instances};
pub(crate) use instance::{apply, apply_before_sensor, apply_to_body, reading_slopes, sense, undo};
pub use parameter::{Fitted, Parameter, Unit, Value};
pub use payload::known_weight;
pub use programs::{
    joints, moments, other_sole, other_sole_by_joints, reading, reading_by_masses, resting_reading,
    wired_joints, wired_reading,
};
pub use remedy::EncoderMap;

/// When an effect acts, first to last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
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
}

/// Why values are not believed or not possible, where they are not.
pub type Reason = Option<&'static str>;

/// What a URDF can hold of an effect.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum UrdfEdit {
    /// The origin of a joint moves.
    Joint(Shift),
    /// A link carries a mass; below zero it lacks one.
    Mass(Load),
}

/// One kind of imperfection.
pub trait Effect: Sync {
    /// Which one it is; its name is that of reports and model files.
    fn id(&self) -> EffectId;

    /// What it is, for people: a sentence, the equation in a block, what imitates it and
    /// which postures tell it apart; Markdown.
    fn page(&self) -> &'static str {
        ""
    }

    /// When it acts.
    fn stage(&self) -> Stage;

    /// Joints, links or cells that it may act on, on this robot and in this log; the whole
    /// robot or its sensor unless it says.
    fn targets(&self, _: &EffectContext) -> Vec<Target> {
        vec![Target::Whole]
    }

    /// Its parameters, one per unknown.
    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        &[]
    }

    /// The subject of a sentence about it: `an offset of l_knee`; `name` is that of
    /// the target, `every joint` where it acts on all.
    fn phrase(&self, target: &Target, name: &str) -> String;

    /// What to change, or how a reading becomes the truth, with sign and unit: `true angle of
    /// l_knee = reading + 1.517°`; `values` in the order of the parameters.
    fn remedy(&self, context: &EffectContext, target: &Target, _values: &[f64]) -> String {
        let subject = self.phrase(target, context.spoken_name(target).as_str());
        format!("{subject} is held by the model file alone; predict with it")
    }

    /// How what the encoder of its joint reads becomes the joint's position.
    fn encoder_map(&self, _values: &[f64]) -> Option<EncoderMap> {
        None
    }

    /// Why a URDF cannot hold it, where [`Effect::urdf_edit`] does not write it.
    fn urdf_gap(&self) -> &'static str {
        remedy::urdf_gap(self.stage(), self.is_static())
    }

    /// Where a fit may start; no effect at all unless that has no slope.
    fn starts(&self, context: &EffectContext, target: &Target) -> Vec<Vec<f64>> {
        vec![vec![0.0; self.parameters(context, target).len()]]
    }

    /// Write the effect into the measurement; one expression per unknown.
    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]);

    /// Values of the parameters that these unknowns mean: each by what is [`Fitted`] for it,
    /// unless they depend on each other.
    fn values(&self, context: &EffectContext, target: &Target, unknowns: &[f64]) -> Vec<f64> {
        let parameters = self.parameters(context, target).iter().zip(unknowns);
        let value = |(p, x): (&Parameter, &f64)| p.fitted.value(*x, context.weight());
        parameters.map(value).collect()
    }

    /// The unknowns that have these values: the inverse of [`Effect::values`].
    fn unknowns(&self, context: &EffectContext, target: &Target, values: &[f64]) -> Vec<f64> {
        let parameters = self.parameters(context, target).iter().zip(values);
        let unknown = |(p, x): (&Parameter, &f64)| p.fitted.unknown(*x, context.weight());
        parameters.map(unknown).collect()
    }

    /// How far the unknowns are beyond what is physical, in units in which 1 is
    /// clearly too far; one entry per bound, zero within it.
    fn bound_violation(&self, _: &EffectContext, _: &Target, _: &[f64]) -> Vec<f64> {
        Vec::new()
    }

    /// Why these values (in the order of the parameters) are not believed of any robot: they
    /// sit at or beyond a bound of [`plausible`].
    fn implausible_reason(&self, _: &EffectContext, _: &Target, _: &[f64]) -> Reason {
        None
    }

    /// Why no robot can have these values (in the order of the parameters), in
    /// words that name the remedy.
    fn invalid_reason(&self, _: &EffectContext, _: &Target, _: &[f64]) -> Reason {
        None
    }

    /// What a reader of rounding bounds must know of it.
    fn caution(&self) -> Option<&'static str> {
        None
    }

    /// Whether one posture shows the effect without the log around it, so that it
    /// can be part of generated code.
    fn is_static(&self) -> bool {
        true
    }

    /// Whether it comes between the CoP and its reading, so that `correct_cop` can
    /// invert it.
    fn is_sensor_effect(&self, _: &Target) -> bool {
        (Stage::Cells..=Stage::Record).contains(&self.stage())
    }

    /// Whether it changes where the links are or what they weigh when encoders read q, and
    /// so every function of the body; what acts on the ground or the sensor belongs to the
    /// CoP alone.
    fn changes_body(&self, target: &Target) -> bool {
        let of_body = matches!(
            self.stage(),
            Stage::Wiring | Stage::Joints | Stage::Loads | Stage::Bends
        );
        of_body && self.is_static() && !self.is_sensor_effect(target)
    }

    /// Whether it is part of regressor rows, which know neither masses nor moments.
    fn changes_regressor(&self, target: &Target) -> bool {
        self.changes_body(target) && matches!(self.stage(), Stage::Wiring | Stage::Joints)
    }

    /// Whether `units:degrees` (true) or `units` alone (false) is its label.
    fn label_has_target(&self) -> bool {
        true
    }

    /// Site and function, of an effect that is made of these.
    fn composed(&self) -> Option<&Composed> {
        None
    }

    /// Share of the weight on the ground that it adds to a robot of `robot_kg`; a sum of raw cells
    /// shows it.
    fn load_share(&self, _unknowns: &[f64], _robot_kg: f64) -> f64 {
        0.0
    }

    /// The width that a fit begins with, where the first unknown is the width of a
    /// dead band: on which side of it a joint rests is then fitted posture by posture.
    fn dead_band(&self) -> Option<f64> {
        None
    }

    /// Whether it is a spring in series with every joint that it acts on, whose stiffness
    /// (Nm/rad) is its first parameter.
    fn is_spring(&self) -> bool {
        false
    }

    /// Whether it is a unit of the record: any other wiring may stand beside it.
    fn is_unit(&self) -> bool {
        false
    }

    /// Whether a diagnosis says how small an effect of this kind the log would show.
    fn reports_smallest_detectable(&self) -> bool {
        false
    }

    /// What becomes of it in a further experiment on the same robot.
    fn in_experiment(&self, experiment: Experiment, _: &Target) -> Carry {
        match experiment {
            // Another foot has another sensor.
            Experiment::OtherFoot if self.stage() >= Stage::Cells => Carry::Gone,
            _ => Carry::Same,
        }
    }

    /// What a URDF can hold of it: `target` as a model file names it, `value` of a
    /// parameter by name (0 where there is none).
    fn urdf_edit(&self, _target: &str, _value: &dyn Fn(&str) -> f64) -> Option<UrdfEdit> {
        None
    }

    /// Take the effect back: the reading with it becomes the one without.
    ///
    /// Unless there is a closed form, [`Effect::rewrite`] is solved for its CoP.
    /// Faults of cells share their loads and are solved together.
    fn undo(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        at.solve(|at| self.rewrite(target, at, unknowns));
    }
}

/// How far |x| is beyond `most`, in units of `unit`.
fn beyond(x: f64, most: f64, unit: f64) -> Vec<f64> {
    vec![(libm::fabs(x) - most).max(0.0) / unit]
}
