//! The model of a robot: its kinematics, its parameters and its effects.
//!
//! ```text
//! model = robot + parameters (CAD or identified) + effects
//! ```
//!
//! Here functions become programs: those of the body from `functions`, the reading
//! from the measurement with the effects of the model file.

mod file;
mod information;
mod posture;
mod records;
mod sensor;
mod springs;

use std::borrow::Cow;
use std::ops::Deref;

use crate::Error;
use crate::base::{self, Column};
use crate::bounds::{self, Bound, Precision};
use crate::effects::{EncoderMap, Instance, ROUNDS, Target};
use crate::expr::Argument;
use crate::formula::Variable;
use crate::interface::{Function, Given};
use crate::program::{Array, Program};
use crate::robot::Robot;
use crate::snap::Snapping;
use crate::tree;
use crate::urdf::Description;
pub use file::{DataUsed, EffectRecord, ModelFile, MotionCounted, Parameter, Quantity};
pub use information::Information;
pub use posture::{tilted_com, tilted_cop};
pub use sensor::sensor_reading;

/// How far beyond CAD and model file parameters may be, as a part of the robot's reach.
const ROOM: f64 = 0.02;

/// A robot with its parameters and effects, ready to be turned into functions.
///
/// It is a [`Robot`] (and dereferences to it) with what a model file adds.
#[derive(Debug, Clone)]
pub struct Model {
    /// The robot described by its URDF.
    pub robot: Robot,
    /// Identified parameters, if a model file was given.
    pub file: Option<ModelFile>,
    /// Effects of that file with their unknowns.
    #[doc(hidden)]
    pub effects: Vec<(Instance, Vec<f64>)>,
    /// Largest |r_k| that bounds hold for, m (a mass fraction for a prismatic joint's).
    #[doc(hidden)]
    pub param_limits: Vec<f64>,
    /// Rounds in which joints give way.
    #[doc(hidden)]
    pub rounds: usize,
}

impl Deref for Model {
    type Target = Robot;

    fn deref(&self) -> &Robot {
        &self.robot
    }
}

impl Model {
    /// The model for motion that was measured: links whose inertia no body of their size has are
    /// points at their centres of mass.
    pub fn with_believed_inertias(&self) -> Cow<'_, Model> {
        if !self.tree.links.iter().any(|link| link.inertia_is_refuted) {
            return Cow::Borrowed(self);
        }
        let mut believed = self.clone();
        let links = believed.robot.tree.links.iter_mut();
        for link in links.filter(|link| link.inertia_is_refuted) {
            link.inertia.fill(0.0);
        }
        Cow::Owned(believed)
    }

    /// The model of a robot with the parameters of its CAD masses.
    ///
    /// # Errors
    /// As [`Robot::new`].
    pub fn new(
        description: &Description,
        support: &str,
        snapping: Snapping,
    ) -> Result<Model, Error> {
        Ok(Model::of(Robot::new(description, support, snapping)?))
    }

    /// The model of a robot that has been read already.
    pub fn of(robot: Robot) -> Model {
        let mut model = Model {
            robot,
            file: None,
            effects: Vec::new(),
            param_limits: Vec::new(),
            rounds: ROUNDS,
        };
        model.param_limits = model.limits_of(&model.cad_params());
        model
    }

    /// The parameters to compute with: identified ones where a model file gives them.
    pub fn params(&self) -> Vec<f64> {
        match &self.file {
            Some(file) => file.values(),
            None => self.cad_params(),
        }
    }

    /// The same robot with other base parameters in the place of CAD's, m: what is expected of it.
    #[doc(hidden)]
    pub fn with_nominal(mut self, values: &[f64]) -> Model {
        let params = self.robot.base.params.iter_mut();
        params
            .zip(values)
            .for_each(|(param, value)| param.cad = *value);
        self.param_limits = self.limits_of(values);
        self
    }

    /// The same robot with the masses of CAD, and the effects of its model file.
    #[doc(hidden)]
    pub fn with_cad_masses(&self) -> Model {
        let mut own = self.clone();
        let cad = self.cad_params();
        if let Some(file) = &mut own.file {
            let pairs = file.parameters.iter_mut().zip(&cad);
            pairs.for_each(|(own, cad)| own.value = *cad);
        }
        own.param_limits = self.limits_of(&cad);
        own
    }

    /// Take identified parameters from a model file.
    pub fn with_file(mut self, file: ModelFile) -> Result<Model, Error> {
        file.check(&self.robot)?;
        self.param_limits = self.limits_of(&file.values());
        self.effects = file.instances(&self.robot)?;
        self.file = Some(file);
        let rounds = springs::rounds(&self);
        let file = self.file.as_ref().map_or("", |file| &file.file);
        self.rounds = rounds.map_err(|reason| Error::model_file(file, reason))?;
        Ok(self)
    }

    /// Effects that one posture shows, with their unknowns: those of [`Function::Cop`].
    #[doc(hidden)]
    pub fn static_effects(&self) -> impl Iterator<Item = &(Instance, Vec<f64>)> {
        self.effects.iter().filter(|(i, _)| i.effect.is_static())
    }

    /// Effects that act on a function, with their unknowns.
    #[doc(hidden)]
    pub fn effects_of(&self, function: Function) -> Vec<&(Instance, Vec<f64>)> {
        let acts = |(Instance { effect, target }, _): &&(Instance, Vec<f64>)| match function {
            Function::Cop | Function::CopJacobian => true,
            Function::CorrectCop => effect.is_sensor_effect(target),
            Function::Com
            | Function::ComJacobian
            | Function::ComVelocity
            | Function::GravityMoments
            | Function::Zmp => effect.changes_body(target),
            Function::Regressor | Function::RegressorCop | Function::RegressorFull => {
                effect.changes_regressor(target)
            }
        };
        self.static_effects().filter(acts).collect()
    }

    /// What the effects depend on beside q and r, each once, in the order of the effects.
    #[doc(hidden)]
    pub fn beyond(&self) -> Vec<Variable> {
        let mut all: Vec<Variable> = Vec::new();
        for (instance, _) in self.static_effects() {
            let own = instance.effect.composed().into_iter();
            for variable in own.flat_map(|own| own.beyond(self, &instance.target)) {
                if !all.contains(&variable) {
                    all.push(variable);
                }
            }
        }
        all
    }

    /// Range and usual value of each of [`Model::beyond`]: the widest range of the effects.
    #[doc(hidden)]
    pub fn about_beyond(&self) -> Vec<([f64; 2], f64)> {
        let about = |variable: &Variable| {
            let mut found: Option<([f64; 2], f64)> = None;
            for (Instance { effect, target }, _) in self.static_effects() {
                let Some(own) = effect.composed() else {
                    continue;
                };
                if own.beyond(self, target).contains(variable) {
                    let ([least, most], usual) = own.about(variable);
                    let ([low, high], first) = found.unwrap_or(([least, most], usual));
                    found = Some(([low.min(least), high.max(most)], first));
                }
            }
            found.unwrap_or_default()
        };
        self.beyond().iter().map(about).collect()
    }

    /// How what each encoder reads becomes its joint's position, in the order of `q`.
    pub fn encoders(&self) -> Vec<EncoderMap> {
        let context = posture::context(self);
        let mut maps = vec![EncoderMap::TRUE; self.dof()];
        for (Instance { effect, target }, unknowns) in &self.effects {
            let values = effect.values(&context, target, unknowns);
            if let (Target::Joint(joint), Some(map)) = (target, effect.encoder_map(&values)) {
                maps[*joint] = maps[*joint].and(map);
            }
        }
        maps
    }

    /// What the robot weighs with its loads, kg: gravity moments are per kg of this.
    pub fn total_mass_kg(&self) -> f64 {
        let loads = self.effects_of(Function::Com).into_iter();
        loads.fold(self.tree.mass, |mass, (instance, unknowns)| {
            // A share of the robot with the load.
            let share = instance.effect.load_share(unknowns, self.tree.mass);
            mass + self.tree.mass * share / (1.0 - share)
        })
    }

    /// What a user of the model file should know, as sentences: effects with values that are
    /// believed of no robot, and effects that generated code leaves out.
    pub fn cautions(&self) -> Vec<String> {
        let mut cautions = self.implausible();
        cautions.extend(self.left_out());
        let beyond = self.beyond().into_iter().zip(self.about_beyond());
        let usual: Vec<String> = beyond
            .map(|(v, (_, usual))| format!("{v} = {usual:?}"))
            .collect();
        if !usual.is_empty() {
            cautions.push(format!(
                "effects depend on more than joint positions; taken are {}",
                usual.join(", ")
            ));
        }
        cautions
    }

    /// Effects with values that are believed of no robot.
    fn implausible(&self) -> Vec<String> {
        let context = posture::context(self);
        let said = self.effects.iter().filter_map(|(instance, unknowns)| {
            let Instance { effect, target } = instance;
            let values = effect.values(&context, target, unknowns);
            let reason = effect.implausible_reason(&context, target, &values)?;
            let label = instance.label(&context);
            Some(format!(
                "effect `{label}` is believed of no robot: {reason}"
            ))
        });
        said.collect()
    }

    /// Effects of the model file that generated code leaves out, as sentences.
    fn left_out(&self) -> Vec<String> {
        let of_log = self.effects.iter().filter(|(i, _)| !i.effect.is_static());
        of_log
            .map(|(instance, _)| {
                format!(
                    "effect `{}` belongs to the log it was found in and is left out here",
                    instance.effect.id().name()
                )
            })
            .collect()
    }

    /// Bounds hold for CAD parameters, those of a model file, and all up to
    /// [`ROOM`] of the robot's reach beyond: what is identified differs from CAD.
    fn limits_of(&self, values: &[f64]) -> Vec<f64> {
        let reach = self.reach();
        let params = self.base.params.iter().zip(values);
        let limit = |(param, value): (&base::BaseParam, &f64)| {
            let room = match param.column {
                Column::Prismatic { .. } => ROOM,
                Column::Axis { .. } => ROOM * reach,
            };
            libm::fabs(param.cad).max(libm::fabs(*value)) + room
        };
        params.map(limit).collect()
    }

    /// Straight-line code of one function; `None` where it cannot be had (sines
    /// and cosines of q do not give those of q/2, which a mimic may need).
    pub fn program(&self, function: Function, given: Given) -> Option<Program> {
        self.build(function, given, false)
    }

    /// The same with the parameters of the model file (CAD's without one) as
    /// constants: zeros vanish, sums of constants fold.
    pub fn baked_program(&self, function: Function, given: Given) -> Option<Program> {
        self.build(function, given, true)
    }

    fn build(&self, function: Function, given: Given, baked: bool) -> Option<Program> {
        match function {
            Function::CorrectCop => sensor::correct_cop(self, given),
            _ => posture::program(self, function, given, baked.then(|| self.params())),
        }
    }

    /// Proven bound on the rounding error of each kind of output.
    pub fn rounding(&self, program: &Program, precision: Precision) -> Bound {
        bounds::prove(program, &self.input_ranges(program), precision)
    }

    /// What the inputs of `program` may be: joint limits, parameters within theirs.
    #[doc(hidden)]
    pub fn input_ranges(&self, program: &Program) -> Vec<Vec<bounds::Input>> {
        let joint = |dof: &tree::Dof| bounds::Input::exact(dof.lower, dof.upper);
        let parameter = |(k, param): (usize, &base::BaseParam)| {
            let size = self.param_limits[k];
            bounds::Input {
                ulps_of: param.ulps_of,
                ..bounds::Input::rounded(-size, size)
            }
        };
        // A prismatic joint passes its position where a revolute one passes its sine.
        let sine = |dof: &tree::Dof| match dof.prismatic {
            true => joint(dof),
            false => bounds::Input::rounded(-1.0, 1.0),
        };
        let of = |argument: Argument| match argument {
            Argument::Positions => self.tree.dofs.iter().map(joint).collect(),
            Argument::Sines | Argument::Cosines => self.tree.dofs.iter().map(sine).collect(),
            Argument::Velocities => {
                let accelerated = |array: &Array| array.argument == Argument::Accelerations;
                let moderate = program.inputs.iter().any(accelerated);
                let speed = |dof: &tree::Dof| match moderate {
                    true => dof.moderate_speed(),
                    false => dof.speed,
                };
                let both_ways = |dof| bounds::Input::exact(-speed(dof), speed(dof));
                self.tree.dofs.iter().map(both_ways).collect()
            }
            Argument::Accelerations => {
                let most = tree::Dof::moderate_acceleration;
                let both_ways = |dof| bounds::Input::exact(-most(dof), most(dof));
                self.tree.dofs.iter().map(both_ways).collect()
            }
            Argument::Parameters => self.base.params.iter().enumerate().map(parameter).collect(),
            Argument::Reading => self
                .largest_reading()
                .map(|most| bounds::Input::rounded(-most, most))
                .to_vec(),
            // A direction d, ‖d‖ ≤ 1.
            Argument::Direction => vec![bounds::Input::exact(-1.0, 1.0); 3],
            Argument::Context => {
                let about = self.about_beyond().into_iter();
                about
                    .map(|([least, most], _)| bounds::Input::rounded(least, most))
                    .collect()
            }
            // Those of fits: no bound is proven for them.
            Argument::Unknowns | Argument::Free => Vec::new(),
        };
        program
            .inputs
            .iter()
            .map(|array| of(array.argument))
            .collect()
    }
}
