//! Findings in the words of the people who use them.

use nalgebra::DMatrix;
use sesc_model::effects::{EffectContext, Unit, Value};
use sesc_model::text::minus;

use super::findings::Quantity;
use super::hypothesis::{Term, with_places};
use super::problem::{Fit, Problem};

/// Parameters of an effect by name, which ends in the unit.
pub(super) type Sizes = Vec<(&'static str, Quantity)>;

/// What each effect of a fit amounts to: deviations by the slopes of the values.
pub(super) fn values(problem: &Problem, fit: &Fit) -> Vec<Sizes> {
    let context = problem.context();
    let values = with_places(&fit.terms, context).map(|(term, own)| {
        let (at, count) = (own.start, own.len());
        let unknowns = &fit.unknowns[own];
        let now = term.values(context, unknowns);
        let mut slopes = DMatrix::zeros(now.len(), count);
        for (k, scale) in term.scales(context).into_iter().enumerate() {
            let step = 1e-5 * scale;
            let [ahead, behind] = [step, -step].map(|by| {
                let mut moved = unknowns.to_vec();
                moved[k] += by;
                term.values(context, &moved)
            });
            for (row, (a, b)) in ahead.iter().zip(&behind).enumerate() {
                slopes[(row, k)] = (a.value - b.value) / (2.0 * step);
            }
        }
        let spread = &slopes * fit.covariance.view((at, at), (count, count)) * slopes.transpose();
        let values = now.into_iter().enumerate();
        let values = values.map(|(k, Value { name, value })| {
            let std = spread[(k, k)].max(0.0).sqrt();
            (name, Quantity { value, std })
        });
        values.collect()
    });
    values.collect()
}

/// `0.93° ± 0.04°`, `31 g ± 2 g`: a value with its standard deviation, by the unit at the end of
/// its name.
pub fn spoken(name: &str, value: f64, std: f64) -> String {
    let (factor, unit) = Unit::of(name).shown();
    let (value, std) = (factor * value, factor * std);
    let digits = match std {
        s if s.is_finite() && s > 0.0 => (1.0 - s.log10().floor()).clamp(0.0, 6.0) as usize,
        _ => 3,
    };
    let gap = if unit == "°" { "" } else { " " };
    let said = format!("{value:.digits$}{gap}{unit} ± {std:.digits$}{gap}{unit}");
    minus(said.replace("  ", " ").trim_end())
}

/// `width 0.93° ± 0.04°`: what it is called, without the unit, and its value.
pub fn named(name: &str, value: f64, std: f64) -> String {
    format!("{} {}", Unit::stem(name), spoken(name, value, std))
}

/// `subject`, with its values: `backlash in every joint: width 0.93° ± 0.04°`.
pub(super) fn clause(context: &EffectContext, term: &Term, values: &Sizes) -> String {
    let subject = term.phrase(context);
    if values.is_empty() {
        return subject;
    }
    let composed = term.effect().and_then(|own| own.effect.composed());
    match composed {
        Some(own) => format!(
            "{subject} ({}; {})",
            own.definition().function,
            sizes(values)
        ),
        None => format!("{subject} ({})", sizes(values)),
    }
}

/// The clause of every effect of a fit.
pub(super) fn clauses(problem: &Problem, fit: &Fit) -> Vec<String> {
    let clauses = fit.terms.iter().zip(values(problem, fit));
    let clauses = clauses.map(|(term, own)| clause(problem.context(), term, &own));
    clauses.collect()
}

/// Values after each other: `mass 155 g ± 6 g, x 22.6 mm ± 2.3 mm`.
pub(super) fn sizes(values: &Sizes) -> String {
    let said = values
        .iter()
        .map(|(name, own)| named(name, own.value, own.std));
    said.collect::<Vec<_>>().join(", ")
}

/// The text with a capital at its beginning.
pub(crate) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().collect::<String>() + letters.as_str(),
        None => String::new(),
    }
}
