//! The URDF with what a diagnosis found, as far as a URDF can hold it.
//!
//! ```text
//! base parameters → masses and CoMs of links       (the robot unbent and unloaded)
//! payload         → a link of its own; below zero, out of the link that lacks it
//! joint_offset    → the origin of the joint, and the offsets of its followers
//! ```
//!
//! In this order each is exact: a payload's share is one of the robot's own mass, and
//! offsets weigh nothing. Everything else is named, with the reason, and left to the model file.

use sesc_model::effects::{Catalog, UrdfEdit};
use sesc_model::urdf::{self, Description, Load, Weight};
use sesc_model::{EffectRecord, Model, ModelFile, Snapping};

use super::findings::Explained;
use super::hypothesis::Term;
use super::model_file::model_file;
use super::problem::Problem;
use crate::fit::corrected::towards;
use crate::fit::masses::FLOOR;
use crate::fit::prior::{Prior, Tolerances};
use crate::robot::Robot;
use crate::{Error, Setting, message};

/// Base parameters that move less leave the masses as they are written, m.
const SETTLED: f64 = 1e-9;
/// A CoM further from its link is what is left of two masses that cancel, m.
const FAR: f64 = 10.0;

/// A corrected description.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrectedUrdf {
    /// The whole text of the URDF.
    pub text: String,
    /// What the text does not hold, a sentence each.
    pub left_out: Vec<String>,
}

/// What of an explanation belongs to the log alone, a sentence each.
pub(crate) fn of_the_log(problem: &Problem, found: &Explained) -> Vec<String> {
    let terms = found.best.terms.iter();
    let outliers = terms.filter(|term| matches!(term, Term::Outliers));
    let said = outliers.map(|term| {
        format!(
            "{} is left out: it says nothing of the robot",
            term.label(&problem.first().context)
        )
    });
    said.collect()
}

/// The URDF of `robot` with what `found` says.
///
/// # Errors
/// When a text cannot be read again.
pub(crate) fn of(
    problem: &Problem,
    found: &Explained,
    robot: &Robot,
    snapping: Snapping,
    prior: &Prior,
    total_mass: Option<f64>,
) -> Result<CorrectedUrdf, Error> {
    let file = model_file(problem, &found.best);
    let wide = Prior::Cad(Tolerances::usual());
    let prior = match found.best.frees_masses() {
        true => &wide,
        false => prior,
    };
    // Masses move from CAD's, also where others are expected of this robot.
    let model = &robot.model(problem.first().model.support(), snapping, None)?;
    let mut corrected = of_model_file(
        &file,
        robot,
        model,
        &problem.first().context.catalog,
        snapping,
        prior,
        total_mass,
    )?;
    corrected.left_out.extend(of_the_log(problem, found));
    Ok(corrected)
}

/// The URDF of `robot` with the parameters and effects of `file`, both of which
/// belong to `model`; masses move within `prior`, and the robot without its loads weighs
/// `total_mass` kg, as in CAD unless given.
///
/// # Errors
/// When a text cannot be read again.
#[doc(hidden)]
pub fn of_model_file(
    file: &ModelFile,
    robot: &Robot,
    model: &Model,
    catalog: &Catalog,
    snapping: Snapping,
    prior: &Prior,
    total_mass: Option<f64>,
) -> Result<CorrectedUrdf, Error> {
    if let Some(mass) = total_mass.filter(|mass| !(1e-9..=1e6).contains(mass)) {
        return Err(Error::request(message![
            Setting::TotalMass,
            format!(" {mass:e} kg: give a number above zero that a robot can have")
        ]));
    }
    // Shares of the robot's mass are what data tell.
    let scale = total_mass.map_or(1.0, |mass| mass / model.tree.mass);
    let name = &robot.description.file;
    let mut left_out = Vec::new();
    let mut text = robot.text().to_string();
    let params = file.values();
    let moved = params.iter().zip(model.cad_params());
    let moved = moved.map(|(to, from)| (to - from).abs());
    if moved.fold(0.0, f64::max) > SETTLED || scale != 1.0 {
        match towards(robot, model, snapping, &params, None, prior, total_mass)? {
            Ok(corrected) => text = corrected.text,
            Err(impossible) => left_out.push(format!(
                "the identified masses stay in the model file: no URDF has them: {}",
                impossible.reason
            )),
        }
    }
    let (mut shifts, mut loads) = (Vec::new(), Vec::new());
    for record in &file.effects {
        let value = |name: &str| record.parameters.get(name).map_or(0.0, |q| q.value);
        let effect = catalog.named(&record.effect);
        match effect.and_then(|effect| effect.urdf_edit(&record.target, &value)) {
            Some(UrdfEdit::Joint(shift)) => shifts.push(shift),
            Some(UrdfEdit::Mass(load)) => {
                let load = Load {
                    mass_kg: scale * load.mass_kg,
                    ..load
                };
                if load.mass_kg > 0.0 {
                    loads.push(load);
                } else if let Err(why) = take_out(&mut text, name, &load)? {
                    left_out.push(stays(record, &why));
                }
            }
            _ => {
                let why = effect.map_or("it is not known", |effect| effect.urdf_gap());
                left_out.push(stays(record, why));
            }
        }
    }
    let read = |text: &str| urdf::parse(text, name).map_err(sesc_model::Error::from);
    let text = urdf::add_loads(&read(&text)?, &loads).map_err(sesc_model::Error::from)?;
    let text = urdf::edit_joints(&read(&text)?, &shifts).map_err(sesc_model::Error::from)?;
    // Nothing is handed out that this program would refuse.
    Robot::parse(&text, name)?;
    Ok(CorrectedUrdf { text, left_out })
}

/// The text of `description` with one edit alone; else why no URDF holds it.
pub(super) fn edited(description: &Description, edit: &UrdfEdit) -> Result<String, String> {
    let said = |error: urdf::Error| error.to_string();
    match edit {
        UrdfEdit::Joint(shift) => {
            urdf::edit_joints(description, std::slice::from_ref(shift)).map_err(said)
        }
        UrdfEdit::Mass(load) if load.mass_kg > 0.0 => {
            urdf::add_loads(description, std::slice::from_ref(load)).map_err(said)
        }
        UrdfEdit::Mass(load) => {
            let mut text = description.text.clone();
            let taken = take_out(&mut text, &description.file, load);
            taken.map_err(|error| error.to_string())?.map(|()| text)
        }
        _ => Err("no URDF can hold it".to_string()),
    }
}

fn stays(record: &EffectRecord, why: &str) -> String {
    let label = match record.target.as_str() {
        "-" => record.effect.clone(),
        target => format!("{}:{target}", record.effect),
    };
    format!("{label} stays in the model file: {why}")
}

/// Take the mass that a link lacks out of it, its first moment kept right. The inner
/// error says why the link cannot lack it.
fn take_out(text: &mut String, file: &str, load: &Load) -> Result<Result<(), String>, Error> {
    let description = urdf::parse(text, file).map_err(sesc_model::Error::from)?;
    let weights = description.links.iter().map(|link| {
        (link.name == load.link).then(|| {
            let (mass, com) = (link.inertial.mass_kg, link.inertial.origin.xyz);
            let left = mass + load.mass_kg;
            let moment = |k: usize| mass * com[k] + load.mass_kg * load.at_m[k];
            let weight = Weight {
                mass_kg: left,
                com_m: [0, 1, 2].map(|k| moment(k) / left),
            };
            let there = weight.com_m.iter().all(|x| x.abs() <= FAR);
            match left >= FLOOR * mass && left > 0.0 && there {
                true => Ok(weight),
                false => Err(format!(
                    "{} weighs {mass} kg and cannot lack {} kg there",
                    load.link, -load.mass_kg
                )),
            }
        })
    });
    let weights: Result<Vec<Option<Weight>>, String> = weights.map(Option::transpose).collect();
    match weights {
        Ok(weights) => {
            *text = urdf::edit_masses(&description, &weights).map_err(sesc_model::Error::from)?;
            Ok(Ok(()))
        }
        Err(why) => Ok(Err(why)),
    }
}
