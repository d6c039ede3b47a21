//! Two models held against each other: on the console, and as a page.

#[cfg(test)]
mod tests;

use minijinja::value::{Serde, Value};
use minijinja::{Error, context};

use super::figures::fit::deviations;
use super::html::{file_name, render};
use super::next_steps::{self, Worded};
use super::origin::recorded;
use super::robot::{Card, Marked};
use super::table::{Table, chance, in_words};
use sesc_identify::compare::{Change, Comparison, Difference, EffectChange};
use sesc_identify::diagnose::words::spoken;
use sesc_identify::skeleton::Skeleton;
use sesc_model::effects::Unit;
use sesc_model::{DataUsed, ModelFile};

/// `comparison` of the files named `before` and `after`.
pub fn text(comparison: &Comparison, before: &str, after: &str) -> String {
    let mut out = format!(
        "{} on {}: {before} → {after}\n\n",
        comparison.robot, comparison.support
    );
    if !comparison.effects.is_empty() {
        let mut table = Table::new(&["effect", "target", "", "before", "after", "deviations"]);
        for effect in &comparison.effects {
            rows(&mut table, effect);
        }
        out += &format!("{table}\n");
    }
    let largest = comparison.largest();
    if !largest.is_empty() {
        let mm = |x: Option<f64>| x.map_or_else(String::new, |x| format!("{:.3}", 1e3 * x));
        let rows = largest.into_iter().map(|own| {
            let [before, after, std] = [own.before, own.after, own.std].map(mm);
            [own.name.clone(), before, after, std, judged(own)]
        });
        let titles = ["parameter", "before", "after", "std", "deviations"];
        let table = Table::of(&titles, rows);
        out += &format!("Base parameters that differ most, mm:\n{table}\n");
    }
    out + &comparison.sentence + "\n"
}

/// What became of an effect, in a word.
fn change(effect: &EffectChange) -> &'static str {
    match effect.change {
        Change::Appeared => "appeared",
        Change::Gone => "gone",
        Change::Changed => "changed",
        Change::Same => "same",
        Change::Unknown => "differs",
    }
}

fn rows(table: &mut Table, effect: &EffectChange) {
    let first: [&str; 3] = [&effect.effect, &effect.target, change(effect)];
    if effect.parameters.is_empty() {
        table.row(&first);
    }
    for (k, own) in effect.parameters.iter().enumerate() {
        let [name, target, change] = if k == 0 { first } else { [""; 3] };
        let value = |value: Option<f64>| value.map_or_else(String::new, |x| of(own, x));
        let [before, after] = [own.before, own.after].map(value);
        table.row(&[name, target, change, &before, &after, &judged(own)]);
    }
}

/// A value with the unit that its name ends in, and how well the difference is known.
fn of(parameter: &Difference, value: f64) -> String {
    let name = &parameter.name;
    match parameter.std {
        Some(std) => spoken(name, value, std),
        None => {
            let (factor, unit) = Unit::of(name).shown();
            format!("{:.4} {unit}", factor * value)
        }
    }
}

fn judged(parameter: &Difference) -> String {
    let deviations = parameter.deviations;
    deviations.map_or_else(String::new, |z| format!("{z:.1}"))
}

// The page of `sesc compare --report`.

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
        parameters => Serde(&comparison.parameters),
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

/// What changed, on the robot.
fn card(comparison: &Comparison, skeleton: &Skeleton) -> Value {
    let mut marked = Marked::default();
    let effects = comparison.effects.iter();
    for own in effects.filter(|own| own.change != Change::Same) {
        let what = format!("{} {}", in_words(&own.effect), change(own));
        marked.point(skeleton, &own.effect, &own.target, &what);
    }
    let nothing = "No joint and no link has an effect that changed.";
    Card::standing(skeleton, marked, nothing, Vec::new()).context()
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
