//! What to change: a sentence for every effect, the zero of a servo, lines of the URDF, and the URDF
//! with all of it, as far as a URDF can hold it.
//!
//! ```text
//! q = s u (n − z)                  n: ticks, s: sign, z: zero, u: rad (m) a tick
//! φ = a q + b = s' u' (n − z')     s' = s sign a,  u' = |a| u,  z' = z − s' b / u'
//!
//! base parameters → masses and CoMs of links       (the robot unbent and unloaded)
//! payload         → a link of its own; below zero, out of the link that lacks it
//! joint_offset    → the origin of the joint, and the offsets of its followers
//! ```
//!
//! Masses come first: a payload's share is one of the robot's own mass, and offsets weigh
//! nothing. Everything else is named, with the reason, and left to the model file.
//!
//! Whole ticks: a corrected zero is known to half a tick. The servo, the URDF and the model
//! file say the same; a robot is corrected in one of them.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use sesc_model::effects::{Catalog, Effect, EncoderMap, Stage, Target, UrdfEdit};
use sesc_model::urdf::{self, Description, Load, Weight};
use sesc_model::{Model, ModelFile, Snapping};

use super::findings::Explained;
pub use super::findings::{Change, Remedy, UrdfChange};
use super::hypothesis::Term;
use super::model_file::model_file;
use super::problem::Problem;
use super::words;
use crate::fit::corrected::towards;
use crate::fit::masses::FLOOR;
use crate::fit::prior::{Prior, Tolerances};
use crate::robot::Robot;
use crate::{Error, Setting, message};

/// Base parameters that move less leave the masses as they are written, m.
const SETTLED: f64 = 1e-9;
/// A CoM further from its link is what is left of two masses that cancel, m.
const FAR: f64 = 10.0;

/// What a tick of a joint's servo means: `q = sign (ticks − zero) step`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Servo {
    /// Ticks at q = 0.
    pub zero: i32,
    /// 1 or −1.
    pub sign: i32,
    /// How far one tick goes.
    pub step: Step,
}

/// How far one tick goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// Resolution of a revolute joint, ticks per turn.
    TicksPerTurn(f64),
    /// Resolution of a prismatic joint, metres per tick.
    MetresPerTick(f64),
}

impl Default for Servo {
    fn default() -> Servo {
        Servo {
            zero: 2048,
            sign: 1,
            step: Step::TicksPerTurn(4096.0),
        }
    }
}

impl Servo {
    /// rad or m per tick, without the sign.
    pub fn per_tick(self) -> f64 {
        match self.step {
            Step::TicksPerTurn(ticks) => TAU / ticks,
            Step::MetresPerTick(metres) => metres,
        }
    }

    /// The servo whose readings are true, where this one's are `map`ped to the truth; `None`
    /// where its zero would be out of range.
    pub fn corrected(self, map: EncoderMap) -> Option<Servo> {
        let sign = if map.scale < 0.0 {
            -self.sign
        } else {
            self.sign
        };
        let stretch = map.scale.abs();
        let step = match self.step {
            Step::TicksPerTurn(ticks) => Step::TicksPerTurn(ticks / stretch),
            Step::MetresPerTick(metres) => Step::MetresPerTick(metres * stretch),
        };
        let by = f64::from(sign) * map.offset / (stretch * self.per_tick());
        let zero = (f64::from(self.zero) - by).round();
        let fits = zero.abs() <= f64::from(i32::MAX);
        fits.then_some(Servo {
            zero: zero as i32,
            sign,
            step,
        })
    }
}

impl Remedy {
    /// Settings of the servo that change, as a servo file names them: `zero 2048 → 2031`.
    pub fn servo_words(&self) -> Vec<String> {
        fn of<T: std::fmt::Display>(name: &str, change: Option<Change<T>>) -> Option<String> {
            change.map(|c| format!("{name} {} → {}", c.before, c.after))
        }
        let resolution = self.servo_resolution.map(|c| Change {
            before: c.before,
            after: (c.after * 100.0).round() / 100.0,
        });
        let words = [
            of("zero", self.servo_zero),
            of("sign", self.servo_sign),
            of("resolution", resolution),
            of("metres_per_tick", self.servo_metres_per_tick),
        ];
        words.into_iter().flatten().collect()
    }

    fn set_servo(&mut self, old: Servo, new: Servo) {
        fn change<T: PartialEq>(before: T, after: T) -> Option<Change<T>> {
            (before != after).then_some(Change { before, after })
        }
        self.servo_zero = change(old.zero, new.zero);
        self.servo_sign = change(old.sign, new.sign);
        if let (Step::TicksPerTurn(a), Step::TicksPerTurn(b)) = (old.step, new.step) {
            self.servo_resolution = change(a, b);
        }
        if let (Step::MetresPerTick(a), Step::MetresPerTick(b)) = (old.step, new.step) {
            self.servo_metres_per_tick = change(a, b);
        }
    }
}

/// Write the remedy of every step into a diagnosis.
pub(super) fn add(
    problem: &Problem,
    found: &mut Explained,
    description: &Description,
    servos: &BTreeMap<String, Servo>,
) {
    let values = words::values(problem, &found.best).into_iter();
    let values = values.map(|own| own.into_iter().map(|(_, own)| own.value).collect());
    let values: Vec<Vec<f64>> = values.collect();
    let terms = &found.best.terms;
    // The order in which corrections of the reading are applied: the last that acts comes first.
    let mut order = vec![Stage::Offset, Stage::Rotation, Stage::Gain];
    order.retain(|stage| terms.iter().any(|term| term.stage() == Some(*stage)));
    for (step, &at) in found.diagnosis.steps.iter_mut().zip(&found.told) {
        let (term, own) = (&terms[at], &values[at]);
        step.remedy = of_term(problem, term, own, description);
        let place = order.iter().position(|stage| term.stage() == Some(*stage));
        if let Some(place) = place.filter(|_| order.len() > 1) {
            step.remedy.sentence += match place {
                0 => "; of the corrections of the reading, apply this one first",
                1 => {
                    "; of the corrections of the reading, apply this one second, to what the first gives"
                }
                _ => "; of the corrections of the reading, apply this one last",
            };
        }
        if let Some((joint, _)) = encoder(term, own) {
            let dof = &problem.context().robot.tree.dofs[joint];
            let old = servos.get(&dof.joint).copied();
            let map = encoder_of(joint, terms, &values);
            let new = old.zip(map).and_then(|(old, map)| old.corrected(map));
            if let (Some(old), Some(new)) = (old, new) {
                step.remedy.set_servo(old, new);
            }
        }
    }
}

/// The joint whose encoder an effect is about, and how it maps that.
fn encoder(term: &Term, values: &[f64]) -> Option<(usize, EncoderMap)> {
    let instance = term.effect()?;
    match instance.target {
        Target::Joint(joint) => Some((joint, instance.effect.encoder_map(values)?)),
        _ => None,
    }
}

/// How all effects on a joint map its encoder; `None` where its channel is another's.
fn encoder_of(joint: usize, terms: &[Term], values: &[Vec<f64>]) -> Option<EncoderMap> {
    let mut map = EncoderMap::TRUE;
    for (term, values) in terms.iter().zip(values) {
        match term.effect().map(|instance| &instance.target) {
            Some(Target::Joints(a, b)) if joint == *a || joint == *b => return None,
            _ => {}
        }
        if let Some((_, own)) = encoder(term, values).filter(|own| own.0 == joint) {
            map = map.and(own);
        }
    }
    Some(map)
}

fn of_term(problem: &Problem, term: &Term, values: &[f64], description: &Description) -> Remedy {
    let context = problem.context();
    let (sentence, urdf) = match term {
        Term::Effect(instance) => {
            let (effect, target) = (instance.effect, &instance.target);
            let parameters = effect.parameters(context, target);
            let value = |name: &str| {
                let place = parameters.iter().position(|own| own.name == name);
                place.map_or(0.0, |place| values[place])
            };
            let edited = edited(description, effect, (&context.name_of(target), &value), 1.0);
            let change = edited.map(|text| changed(&description.text, &text));
            (effect.remedy(context, target, values), change)
        }
        Term::Outliers => (
            "readings of the poses named as outliers come from elsewhere; repeat them or leave \
             them out"
                .to_string(),
            Err("it says nothing of the robot".to_string()),
        ),
        Term::Masses => (
            "true masses differ from CAD; the model file holds the parameters that these data \
             know, a corrected URDF the masses nearest to CAD that have them"
                .to_string(),
            Ok(None),
        ),
    };
    Remedy {
        sentence,
        not_in_urdf: urdf.as_ref().err().cloned(),
        urdf: urdf.ok().flatten(),
        ..Remedy::default()
    }
}

/// A corrected description.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrectedUrdf {
    /// The whole text of the URDF.
    pub text: String,
    /// What the text does not hold, a sentence each.
    pub left_out: Vec<String>,
}

/// What of an explanation belongs to the log alone, a sentence each.
pub(super) fn of_the_log(found: &Explained) -> Vec<String> {
    let outliers = found.best.terms.contains(&Term::Outliers);
    let outliers = outliers.then(|| Term::Outliers.name());
    let sentence = |name| format!("{name} is left out: it says nothing of the robot");
    outliers.map(sentence).into_iter().collect()
}

/// The URDF of `robot` with what `found` says.
///
/// # Errors
/// When a text cannot be read again.
pub(super) fn corrected_urdf(
    problem: &Problem,
    found: &Explained,
    robot: &Robot,
    snapping: Snapping,
    prior: &Prior,
    total_mass: Option<f64>,
) -> Result<CorrectedUrdf, Error> {
    let file = model_file(problem, &found.written);
    let wide = Prior::Cad(Tolerances::usual());
    let prior = match found.written.frees_masses() {
        true => &wide,
        false => prior,
    };
    // Masses move from CAD's, also where others are expected of this robot.
    let model = &robot.model(problem.first().model.support(), snapping, None)?;
    let mut corrected = of_model_file(
        &file,
        robot,
        model,
        &problem.context().catalog,
        snapping,
        prior,
        total_mass,
    )?;
    corrected.left_out.extend(of_the_log(found));
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
        match towards(robot, model, snapping, (&params, None), prior, total_mass)? {
            Ok(corrected) => text = corrected.text,
            Err(reason) => left_out.push(format!(
                "the identified masses stay in the model file: no URDF has them: {reason}"
            )),
        }
    }
    for record in &file.effects {
        let value = |name: &str| record.parameters.get(name).map_or(0.0, |q| q.value);
        let edited = match catalog.named(&record.effect) {
            None => Err("it is not known".to_string()),
            Some(effect) => urdf::parse(&text, name)
                .map_err(|error| error.to_string())
                .and_then(|own| edited(&own, effect, (&record.target, &value), scale)),
        };
        match edited {
            Ok(edited) => text = edited,
            Err(why) => {
                let label = match record.target.as_str() {
                    "-" => record.effect.clone(),
                    target => format!("{}:{target}", record.effect),
                };
                left_out.push(format!("{label} stays in the model file: {why}"));
            }
        }
    }
    // Nothing is handed out that this program would refuse.
    Robot::parse(&text, name)?;
    Ok(CorrectedUrdf { text, left_out })
}

/// The text of `description` with an effect of these values at its target, where a robot of another
/// mass carries `scale` times as much; else why no URDF holds it.
fn edited(
    description: &Description,
    effect: &dyn Effect,
    (target, value): (&str, &dyn Fn(&str) -> f64),
    scale: f64,
) -> Result<String, String> {
    let gap = || effect.urdf_gap().to_string();
    let edited = match effect.urdf_edit(target, value).ok_or_else(gap)? {
        UrdfEdit::Joint(shift) => urdf::edit_joints(description, &[shift]),
        UrdfEdit::Mass(mut load) => {
            load.mass_kg *= scale;
            match load.mass_kg > 0.0 {
                true => urdf::add_loads(description, &[load]),
                false => urdf::edit_masses(description, &without(description, &load)?),
            }
        }
        _ => return Err("no URDF can hold it".to_string()),
    };
    edited.map_err(|error| error.to_string())
}

/// The masses of links where one lacks a load, its first moment kept right; else why it cannot.
fn without(description: &Description, load: &Load) -> Result<Vec<Option<Weight>>, String> {
    let of = |link: &urdf::Link| {
        let (mass, com) = (link.inertial.mass_kg, link.inertial.origin.xyz);
        let mass_kg = mass + load.mass_kg;
        let com_m = [0, 1, 2].map(|k| (mass * com[k] + load.mass_kg * load.at_m[k]) / mass_kg);
        let there = com_m.iter().all(|x| x.abs() <= FAR);
        match mass_kg >= FLOOR * mass && mass_kg > 0.0 && there {
            true => Ok(Weight { mass_kg, com_m }),
            false => Err(format!(
                "{} weighs {mass} kg and cannot lack {} kg there",
                load.link, -load.mass_kg
            )),
        }
    };
    let links = description.links.iter();
    let masses = links.map(|link| (link.name == load.link).then(|| of(link)).transpose());
    masses.collect()
}

/// Elements that differ; `None` where none does.
pub(super) fn changed(old: &str, new: &str) -> Option<UrdfChange> {
    let (a, b) = (elements(old), elements(new));
    let (mut i, mut j) = (0, 0);
    let (mut before, mut after, mut line) = (Vec::new(), Vec::new(), None);
    while i < a.len() || j < b.len() {
        // The next elements that are alike, with as few as possible between.
        let rest = a.len() - i + b.len() - j;
        let (x, y) = (0..rest)
            .flat_map(|sum| (0..=sum).map(move |x| (x, sum - x)))
            .find(|&(x, y)| match (a.get(i + x), b.get(j + y)) {
                (Some((_, a)), Some((_, b))) => a == b,
                _ => false,
            })
            .unwrap_or((a.len() - i, b.len() - j));
        if x + y > 0 && line.is_none() {
            let first = a.get(i).or(a.last());
            line = first.map(|(at, _)| 1 + old[..*at].matches('\n').count());
        }
        before.extend(&a[i..i + x]);
        after.extend(&b[j..j + y]);
        (i, j) = ((i + x + 1).min(a.len()), (j + y + 1).min(b.len()));
    }
    line.map(|line| UrdfChange {
        line,
        before: indented(old, &before),
        after: indented(new, &after),
    })
}

/// Elements of a text below each other, indented as they were against each other.
fn indented(text: &str, elements: &[&(usize, &str)]) -> String {
    let indent = |at: usize| {
        let line = &text[text[..at].rfind('\n').map_or(0, |end| end + 1)..];
        line.len() - line.trim_start_matches([' ', '\t']).len()
    };
    let least = elements.iter().map(|(at, _)| indent(*at)).min();
    let line = |(at, own): &&(usize, &str)| " ".repeat(indent(*at) - least.unwrap_or(0)) + own;
    elements.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Every tag with the text after it, and its place.
fn elements(text: &str) -> Vec<(usize, &str)> {
    let mut starts: Vec<usize> = text.match_indices('<').map(|(at, _)| at).collect();
    starts.push(text.len());
    let elements = starts.windows(2);
    let elements = elements.map(|pair| (pair[0], text[pair[0]..pair[1]].trim()));
    elements.collect()
}
