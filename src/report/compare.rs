//! Two models held against each other: on the console, and as a page.

mod page;
#[cfg(test)]
mod tests;

pub use page::page;

use sesc_identify::compare::{Change, Comparison, Difference, EffectChange};
use sesc_identify::diagnose::words::{NamedValue, spoken};
use sesc_model::effects::Unit;

use super::table::Table;

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
        let mut table = Table::new(&["parameter", "before", "after", "std", "deviations"]);
        for parameter in largest {
            table.row(&[
                parameter.name.clone(),
                millimetres(parameter.before),
                millimetres(parameter.after),
                millimetres(parameter.std),
                judged(parameter),
            ]);
        }
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
    let first = [
        effect.effect.as_str(),
        effect.target.as_str(),
        change(effect),
    ];
    if effect.parameters.is_empty() {
        table.row(&first);
    }
    for (k, parameter) in effect.parameters.iter().enumerate() {
        let [name, target, change] = if k == 0 { first } else { [""; 3] };
        let value = |value: Option<f64>| value.map_or_else(String::new, |x| of(parameter, x));
        table.row(&[
            name.to_string(),
            target.to_string(),
            change.to_string(),
            value(parameter.before),
            value(parameter.after),
            judged(parameter),
        ]);
    }
}

/// A value with the unit that its name ends in, and how well the difference is known.
fn of(parameter: &Difference, value: f64) -> String {
    let name = &parameter.name;
    match parameter.std {
        Some(std) => spoken(&NamedValue { name, value, std }),
        None => {
            let (factor, unit) = Unit::of(name).shown();
            format!("{:.4} {unit}", factor * value)
        }
    }
}

fn millimetres(value: Option<f64>) -> String {
    value.map_or_else(String::new, |x| format!("{:.3}", 1e3 * x))
}

fn judged(parameter: &Difference) -> String {
    let deviations = parameter.deviations;
    deviations.map_or_else(String::new, |z| format!("{z:.1}"))
}
