//! What generated files say of a robot: the one description that both languages print.

use crate::routines::{Routine, routines};
use sesc_model::effects::{EncoderMap, Instance, foot_rectangle};
use sesc_model::tree::Dof;
use sesc_model::{EffectRecord, Function, Model, ModelFile, Robot};

/// A robot on its support, as generated files describe it, and its functions.
#[derive(Debug)]
pub struct Facts<'m> {
    /// The robot and what a model file says of it.
    pub model: &'m Model,
    /// Name of the robot.
    pub robot: &'m str,
    /// The link on the ground.
    pub support: &'m str,
    /// Independent joints, in the order of `q`.
    pub dofs: &'m [Dof],
    /// Parameters of a model file.
    pub identified: Option<Identified>,
    /// Effects of a model file.
    pub effects: Vec<Effect<'m>>,
    /// How what encoders read becomes joint positions, in the order of `q`.
    pub encoders: Vec<EncoderMap>,
    /// What generated functions must give.
    pub self_test: SelfTest,
    /// What the effects depend on beside q and r, with its usual value.
    pub context: Vec<(String, f64)>,
    /// Functions that were not asked for.
    pub left_out: Vec<Function>,
    /// The others.
    pub routines: Vec<Routine>,
}

/// Base parameters of a model file.
#[derive(Debug, Clone)]
pub struct Identified {
    /// Where they come from.
    pub source: String,
    /// In the order of `r`, m.
    pub values: Vec<f64>,
    /// Their standard deviations, m, if any is known; infinite where one is not.
    pub std: Option<Vec<f64>>,
    /// R with RᵀR their inverse covariance, row by row from the diagonal on, 1/m.
    pub information: Option<Vec<f64>>,
}

/// An effect of a model file.
#[derive(Debug, Clone)]
pub struct Effect<'m> {
    /// Its name in model files.
    pub name: &'static str,
    /// What it acts on, unless that is the whole robot.
    pub target: Option<&'m str>,
    /// What it adds, of an effect that a formula makes.
    pub function: Option<&'m str>,
    /// `name = value` of each parameter.
    pub values: Vec<String>,
    /// Whether one posture shows it: it is part of `cop`.
    pub is_static: bool,
    /// Whether it is part of every function of the body.
    pub changes_body: bool,
    /// What is to be said of rounding bounds under it.
    pub caution: Option<&'static str>,
}

/// What generated functions must give, computed in another way.
#[derive(Debug, Clone)]
pub struct SelfTest {
    /// A posture inside the joint limits, rad or m.
    pub posture: Vec<f64>,
    /// The CoM there with CAD parameters, m: summed body by body, unless effects move them.
    pub com: [f64; 3],
    /// Moments of gravity there, m, by differences of the summed CoM.
    pub moments: Vec<f64>,
    /// How far those differences may be off, m.
    pub moments_error: f64,
    /// A CoP on the foot, m.
    pub cop: [f64; 2],
    /// The reading that the effects of the sensor make of it.
    pub reading: [f64; 2],
}

/// Error of moments by differences of the summed CoM, relative to the robot's reach.
const DIFFERENCES: f64 = 1e-9;

impl Facts<'_> {
    /// The description of `model` and all its functions.
    pub fn of(model: &Model) -> Facts<'_> {
        Facts::with(model, &Function::ALL)
    }

    /// The description of `model` with these of its functions; [`Function::Com`] is always there.
    pub fn with<'m>(model: &'m Model, functions: &[Function]) -> Facts<'m> {
        let wanted = |f: &Function| *f == Function::Com || functions.contains(f);
        let (functions, left_out): (Vec<_>, Vec<_>) = Function::ALL.into_iter().partition(wanted);
        let tree = &model.tree;
        Facts {
            model,
            robot: &tree.robot,
            support: &tree.links[tree.support].name,
            dofs: &tree.dofs,
            identified: model.file.as_ref().map(|file| Identified {
                source: file.source(),
                values: file.values(),
                std: standard_deviations(file),
                information: file.information.as_ref().map(|factor| factor.packed()),
            }),
            effects: model.file.as_ref().map_or_else(Vec::new, |file| {
                let instances = model.effects.iter().map(|(instance, _)| instance);
                let pairs = file.effects.iter().zip(instances);
                pairs
                    .map(|(record, instance)| effect(record, instance))
                    .collect()
            }),
            encoders: model.encoders(),
            self_test: SelfTest::of(model),
            context: (model.beyond().into_iter().zip(model.about_beyond()))
                .map(|(variable, (_, usual))| (variable.to_string(), usual))
                .collect(),
            routines: routines(model, &functions),
            left_out,
        }
    }

    /// What each encoder that does not read the truth needs: `r_knee: add 0.0524 rad`.
    pub fn encoder_zeros(&self) -> Vec<String> {
        let pairs = self.dofs.iter().zip(&self.encoders);
        let off = pairs.filter(|(_, map)| **map != EncoderMap::TRUE);
        off.map(|(dof, map)| {
            let unit = if dof.prismatic { "m" } else { "rad" };
            let scaled = match map.scale == 1.0 {
                true => String::new(),
                false => format!("multiply by {:?}, ", map.scale),
            };
            format!("{}: {scaled}add {:?} {unit}", dof.joint, map.offset)
        })
        .collect()
    }

    /// The effects that act on functions of the body, or on `cop` alone, by their names.
    pub fn effects_in(&self, body: bool) -> Vec<String> {
        let acting = self.effects.iter();
        let acting = acting.filter(|effect| effect.is_static && effect.changes_body == body);
        let name = |effect: &Effect| match effect.target {
            Some(target) => format!("{} of {target}", effect.name),
            None => effect.name.to_string(),
        };
        acting.map(name).collect()
    }

    /// Number of independent joints.
    pub fn dof(&self) -> usize {
        self.dofs.len()
    }

    /// Base parameters, in the order of `r`: link and axis.
    pub fn param_names(&self) -> Vec<&str> {
        let params = self.model.base.params.iter();
        params.map(|param| param.name.as_str()).collect()
    }

    /// What effects mean for a function, where any acts on it.
    pub fn effects_sentence(&self, function: Function) -> Option<&'static str> {
        let effects = self.model.effects_of(function);
        function.effects_sentence().filter(|_| !effects.is_empty())
    }

    /// Whether `cop` is more than the CoM's shadow.
    pub fn has_static_effects(&self) -> bool {
        self.effects.iter().any(|effect| effect.is_static)
    }
}

fn standard_deviations(file: &ModelFile) -> Option<Vec<f64>> {
    let std = file.parameters.iter().map(|param| param.std);
    let known = std.clone().any(|std| std.is_some());
    known.then(|| std.map(|std| std.unwrap_or(f64::INFINITY)).collect())
}

fn effect<'m>(record: &'m EffectRecord, instance: &Instance) -> Effect<'m> {
    let Instance { effect, target } = instance;
    let values = record.parameters.iter();
    Effect {
        name: effect.id().name(),
        target: (record.target != "-").then_some(record.target.as_str()),
        function: record.function.as_deref(),
        values: values
            .map(|(name, x)| format!("{name} = {}", x.value))
            .collect(),
        is_static: effect.is_static(),
        changes_body: effect.changes_body(target),
        caution: effect.caution(),
    }
}

impl SelfTest {
    fn of(model: &Model) -> SelfTest {
        let posture = model.self_test_posture();
        let cells = model.file.as_ref().map_or(&[][..], |file| &file.cells);
        // Between the cells of the foot, a little off their middle.
        let cop = match foot_rectangle(cells) {
            Some((middle, half)) => [middle[0] + 0.25 * half[0], middle[1] - 0.125 * half[1]],
            None => [0.0625, -0.03125],
        };
        SelfTest {
            com: model.expected_com(&posture),
            moments: match model.effects_of(Function::GravityMoments).is_empty() {
                true => moments(model, &posture),
                // About joints that give way, not with respect to what encoders read.
                false => model.evaluate(Function::GravityMoments, &posture, &model.cad_params()),
            },
            moments_error: DIFFERENCES * model.reach().max(1.0) * model.largest_tie(),
            cop,
            reading: model.reading_of(cop),
            posture,
        }
    }
}

/// −∂CoM_z/∂q by differences of the summed CoM, of fourth order.
fn moments(robot: &Robot, posture: &[f64]) -> Vec<f64> {
    let height = |j: usize, step: f64| {
        let mut q = posture.to_vec();
        q[j] += step;
        robot.com_by_sum(&q)[2]
    };
    // A follower goes as many times as far.
    let h = 1e-3 / robot.largest_tie();
    let slope = |j: usize| {
        let near = (height(j, h) - height(j, -h)) / (2.0 * h);
        let far = (height(j, 2.0 * h) - height(j, -2.0 * h)) / (4.0 * h);
        -(4.0 * near - far) / 3.0
    };
    (0..posture.len()).map(slope).collect()
}
