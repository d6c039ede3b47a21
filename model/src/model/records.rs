//! A model file against the robot that it is for: every record checked, every effect
//! made an instance.

use std::collections::{BTreeMap, HashSet};

use super::file::{EffectRecord, ModelFile, Parameter, Quantity};
use crate::Error;
use crate::effects::{
    Catalog, Composed, Constant, Definition, Effect, EffectContext, Instance, NO_UNIT, Site, Stage,
    Target,
};
use crate::formula::Formula;
use crate::robot::Robot;
use crate::text::listed;
use crate::urdf::suggestion;

impl EffectRecord {
    /// The record of an effect at the target of this name.
    pub fn new(
        effect: &dyn Effect,
        target: String,
        parameters: BTreeMap<String, Quantity>,
    ) -> EffectRecord {
        let mut record = EffectRecord {
            effect: effect.id().name().to_string(),
            target,
            parameters,
            ..EffectRecord::default()
        };
        if let Some(composed) = effect.composed() {
            let definition = composed.definition().clone();
            let units = definition.constants.into_iter();
            let units = units.filter(|constant| constant.unit != NO_UNIT);
            record.site = Some(definition.site);
            record.function = Some(definition.function.to_string());
            record.at = definition.at;
            record.sentence = definition.sentence;
            record.range = definition.range;
            record.columns = definition.columns;
            record.units = units.map(|own| (own.name, own.unit)).collect();
        }
        record
    }

    /// The effect that site and function make, where there are any.
    fn composed(&self) -> Result<Option<&'static Composed>, String> {
        let (site, function) = match (self.site, &self.function) {
            (Some(site), Some(function)) => (site, function),
            (Some(_), None) => return Err("function is missing; add function = \"…\"".into()),
            (None, Some(_)) => {
                let names = Site::ALL.map(Site::name).join(", ");
                return Err(format!("site is missing; add one of {names}"));
            }
            (None, None) => return Ok(None),
        };
        let function = Formula::parse(function).map_err(|fault| format!("function: {fault}"))?;
        let mut constants: Vec<Constant> = Vec::new();
        for name in function.parameters() {
            let Some(found) = self.parameters.get(&name) else {
                return Err(format!(
                    "`{name}` is missing; add parameters.{name} = {{ value = … }}"
                ));
            };
            let typical = match found.value.is_finite() && found.value != 0.0 {
                true => found.value,
                false => 1.0,
            };
            let unit = self.units.get(&name).map_or(NO_UNIT, String::as_str);
            constants.push(Constant {
                unit: unit.to_string(),
                typical,
                limits: [f64::NEG_INFINITY, f64::INFINITY],
                name,
            });
        }
        let definition = Definition {
            name: self.effect.clone(),
            site,
            function,
            constants,
            targets: Vec::new(),
            at: self.at,
            range: self.range.clone(),
            columns: self.columns.clone(),
            sentence: self.sentence.clone(),
        };
        let composed = Composed::new(definition).map_err(|(key, reason)| match key {
            "adds" => format!("function: {reason}"),
            key => format!("{key}: {reason}"),
        });
        Ok(Some(composed?))
    }

    /// The effect at its target with its unknowns, or what is wrong and what to do.
    fn instance(&self, context: &EffectContext) -> Result<(Instance, Vec<f64>), String> {
        let name = &self.effect;
        let bad = |reason: String| format!("effect `{name}` of `{}`: {reason}", self.target);
        let known = match self.composed().map_err(bad)? {
            Some(composed) => Some(composed as &'static dyn Effect),
            None => context.catalog.named(name),
        };
        let effect = known.ok_or_else(|| {
            let known: Vec<&str> = context.catalog.iter().map(|e| e.id().name()).collect();
            let meant = suggestion(name, known.iter().copied());
            format!(
                "effect `{name}` is not known; known are {}{meant}",
                known.join(", ")
            )
        })?;
        let target = context
            .target_named(effect, &self.target)
            .ok_or_else(|| bad(no_target(effect, &self.target, context)))?;
        let parameters = effect.parameters(context, &target);
        let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name).collect();
        let stray = |key: &&String| !names.contains(&key.as_str());
        if let Some(stray) = self.parameters.keys().find(stray) {
            return Err(bad(match names.is_empty() {
                true => format!("it has no parameters; remove `{stray}`"),
                false => format!("no parameter `{stray}`; it has {}", names.join(", ")),
            }));
        }
        let mut values = Vec::with_capacity(names.len());
        for wanted in &names {
            let found = self.parameters.get(*wanted).ok_or_else(|| {
                bad(format!(
                    "`{wanted}` is missing; add parameters.{wanted} = {{ value = … }}"
                ))
            })?;
            if !found.value.is_finite() {
                return Err(bad(format!("`{wanted}` is not finite; give a number")));
            }
            values.push(found.value);
        }
        if let Some(reason) = effect.invalid_reason(context, &target, &values) {
            return Err(bad(reason.to_string()));
        }
        let unknowns = effect.unknowns(context, &target, &values);
        match unknowns.iter().all(|x| x.is_finite()) {
            true => Ok((Instance { effect, target }, unknowns)),
            false => Err(bad("values that no robot can have; give others".to_string())),
        }
    }
}

/// Targets named in a message, at most.
const NAMED: usize = 30;

fn no_target(effect: &dyn Effect, wrong: &str, context: &EffectContext) -> String {
    let targets = effect.targets(context);
    match targets.is_empty() {
        true if effect.stage() == Stage::Cells => {
            "the places of the cells are missing; add cells = [[x, y], …], four corners of a \
             rectangle, m"
                .to_string()
        }
        true if effect.composed().is_some() => {
            "this robot has no such target, or no joint that its function names".to_string()
        }
        true => "no joint, link or cell of this robot can have this effect; remove it".to_string(),
        false => {
            let names = targets.iter().map(|target| context.name_of(target));
            let names: Vec<String> = names.collect();
            let meant = suggestion(wrong, names.iter().map(String::as_str));
            format!(
                "no such target on this robot; it has {}{meant}",
                listed(names, NAMED)
            )
        }
    }
}

/// Effects for each joint, link and cell, at most.
const MOST_OF_EACH: usize = 4;

/// A link of a body that loads leave no mass.
fn without_mass<'r>(robot: &'r Robot, all: &[(Instance, Vec<f64>)]) -> Option<&'r str> {
    let mut masses: Vec<f64> = robot.chain.bodies.iter().map(|body| body.mass).collect();
    all.iter().find_map(|(instance, unknowns)| {
        let Target::Link(link) = instance.target else {
            return None;
        };
        let share = instance.effect.load_share(unknowns, robot.tree.mass);
        if !instance.effect.changes_body(&instance.target) || share >= 0.0 {
            return None;
        }
        let mass = &mut masses[robot.chain.places[link].as_ref()?.body];
        *mass += robot.tree.mass * share / (1.0 - share);
        (*mass <= 0.0).then_some(robot.tree.links[link].name.as_str())
    })
}

impl ModelFile {
    /// The effects as instances with their unknowns, in the file's order.
    pub(crate) fn instances(&self, robot: &Robot) -> Result<Vec<(Instance, Vec<f64>)>, Error> {
        let context = EffectContext::new(robot, &self.cells, true, Catalog::standard());
        let bad = |reason: String| Error::model_file(&self.file, reason);
        let of = |record: &EffectRecord| record.instance(&context).map_err(bad);
        let most = MOST_OF_EACH * (robot.dof() + robot.tree.links.len() + self.cells.len());
        if self.effects.len() > most {
            return Err(bad(format!(
                "{} effects, and this robot can have {most} at most; keep those that data showed",
                self.effects.len()
            )));
        }
        let all: Vec<(Instance, Vec<f64>)> =
            self.effects.iter().map(of).collect::<Result<_, _>>()?;
        let mut known = HashSet::new();
        if let Some((twice, _)) = all.iter().find(|(instance, _)| !known.insert(instance)) {
            return Err(bad(format!(
                "effect `{}` stands there twice; keep one, with the values of both together",
                twice.label(&context)
            )));
        }
        match without_mass(robot, &all) {
            Some(link) => Err(bad(format!(
                "effect `payload`: the body of link `{link}` would weigh nothing or less; give \
                 mass_kg above minus what it weighs"
            ))),
            None => Ok(all),
        }
    }

    /// Whether the file belongs to this robot and support, parameter by parameter.
    pub(crate) fn check(&self, robot: &Robot) -> Result<(), Error> {
        let support = robot.support();
        let bad = |reason: String| Error::model_file(&self.file, reason);
        self.check_robot(&robot.tree.hash, &robot.tree.file)?;
        if self.support != support {
            return Err(bad(format!(
                "made for support `{}`, not `{support}`; fit for that support, or use the \
                 corrected URDF of a fit, which serves every support",
                self.support
            )));
        }
        let expected = robot.base.params.iter().map(|p| p.name.as_str());
        let found = self.parameters.iter().map(|p| p.name.as_str());
        if let Some((want, have)) = expected.clone().zip(found.clone()).find(|(w, h)| w != h) {
            return Err(bad(format!(
                "parameter `{want}` expected where `{have}` stands"
            )));
        }
        if self.parameters.len() != robot.base.params.len() {
            return Err(bad(format!(
                "{} parameters, the robot has {} base parameters",
                self.parameters.len(),
                robot.base.params.len()
            )));
        }
        Ok(())
    }

    /// A model file with the given values for every base parameter of `model`.
    pub fn from_values(
        robot: &Robot,
        values: &[f64],
        std: Option<&[f64]>,
        source: &str,
    ) -> ModelFile {
        let parameters = robot
            .base
            .params
            .iter()
            .zip(values)
            .enumerate()
            .map(|(k, (param, &value))| Parameter {
                name: param.name.clone(),
                value,
                std: std.map(|std| std[k]),
                source: Some(source.to_string()),
            })
            .collect();
        ModelFile {
            robot: robot.tree.robot.clone(),
            hash: robot.tree.hash.clone(),
            support: robot.support().to_string(),
            noise_floor: None,
            motion: None,
            parameters,
            data: Vec::new(),
            cells: Vec::new(),
            effects: Vec::new(),
            information: None,
            file: String::new(),
        }
    }
}
