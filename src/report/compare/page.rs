//! The page of `sesc compare --report`.

use minijinja::value::Value;
use minijinja::{Error, context};

use super::{change, judged, of};
use crate::report::figures::fit::deviations;
use crate::report::figures::robot::Marks;
use crate::report::fleet::mark_effect;
use crate::report::html::render;
use crate::report::next_steps::{self, Worded};
use crate::report::origin::recorded;
use crate::report::robot::{Card, Correction};
use crate::report::table::chance;
use sesc_identify::compare::{Change, Comparison, Difference, EffectChange};
use sesc_identify::skeleton::Skeleton;
use sesc_model::effects::{Target, Unit};
use sesc_model::{DataUsed, ModelFile};

/// The page of a comparison, alone in one file: `files` are the models before and after, `drawn`
/// is their robot where its URDF is at hand, `steps` are what to do next, `command` makes the page
/// again.
///
/// # Errors
/// When the template cannot be filled.
pub fn page(
    comparison: &Comparison,
    files: [&ModelFile; 2],
    steps: &[Worded],
    drawn: Option<&Skeleton>,
    command: &str,
) -> Result<String, Error> {
    let named = files.map(|file| {
        let logs = file.data.iter();
        context! {
            name => file_name(&file.file),
            robot => &file.robot,
            hash => &file.hash,
            logs => logs.map(data).collect::<Vec<Value>>(),
        }
    });
    let rows = comparison.parameters.iter().filter_map(|own| {
        let sign = (own.after? - own.before?).signum();
        Some((own.name.as_str(), sign * own.deviations?))
    });
    let context = context! {
        robot => drawn.map(|drawn| card(comparison, drawn)),
        name => &comparison.robot,
        support => &comparison.support,
        changed => comparison.changed,
        sentence => &comparison.sentence,
        files => named.to_vec(),
        next => next_steps::context(steps),
        chance => comparison.chance.map(chance),
        chi2 => comparison.chi2,
        directions => comparison.directions,
        noise => comparison.noise_floor.to_vec(),
        effects => comparison.effects.iter().map(effect).collect::<Vec<Value>>(),
        figure => Value::from_safe_string(deviations("From before to after, std", rows.collect())),
        parameters => comparison.parameters.iter().map(parameter).collect::<Vec<Value>>(),
        origin => context! { command },
    };
    render("compare.html", context)
}

/// A log that a model was identified from, with when it was recorded where it says so.
fn data(log: &DataUsed) -> Value {
    context! {
        name => file_name(&log.file),
        rows => log.rows,
        hash => &log.hash,
        recorded => log.times.and_then(recorded),
    }
}

/// Without the folders of this machine.
fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// What changed, on the robot.
fn card(comparison: &Comparison, skeleton: &Skeleton) -> Value {
    let mut marks = Marks::default();
    let mut said = Vec::new();
    for own in comparison
        .effects
        .iter()
        .filter(|own| own.change != Change::Same)
    {
        if mark_effect(&mut marks, skeleton, &own.effect, &own.target) {
            let what = format!("{} {}", in_words(&own.effect), change(own));
            said.push(match own.target.as_str() {
                Target::ALL_JOINTS => format!("every joint ({what})"),
                target => format!("`{}` ({what})", target.replace(',', "`, `")),
            });
        }
    }
    let said = match said.is_empty() {
        true => "No joint and no link has an effect that changed.".to_string(),
        false => format!("Orange: {}.", said.join("; ")),
    };
    let card = Card {
        skeleton,
        postures: Vec::new(),
        apart: Vec::new(),
        beside: None,
        caption: format!(
            "{said} Quartered disc: centre of mass by CAD, with its plumb line; all joints at zero."
        ),
        marks,
        correction: Correction::default(),
    };
    card.context()
}

/// `joint offset`: what stands in the tables of other pages, too.
fn in_words(effect: &str) -> String {
    effect.replace('_', " ")
}

fn effect(own: &EffectChange) -> Value {
    let size = |parameter: &Difference| {
        let value = |value: Option<f64>| value.map_or("–".to_string(), |x| of(parameter, x));
        context! {
            name => Unit::stem(&parameter.name),
            before => value(parameter.before),
            after => value(parameter.after),
            z => judged(parameter),
        }
    };
    context! {
        effect => in_words(&own.effect),
        target => &own.target,
        change => change(own),
        sizes => own.parameters.iter().map(size).collect::<Vec<Value>>(),
    }
}

fn parameter(own: &Difference) -> Value {
    context! {
        name => &own.name,
        before => own.before,
        after => own.after,
        std => own.std,
        z => judged(own),
    }
}
