//! Findings in the words of the people who use them.

use nalgebra::DMatrix;
use sesc_model::effects::{EffectContext, Unit, Value};
use sesc_model::text::minus;

use super::hypothesis::{Term, with_places};
use super::problem::{Fit, Problem};

/// A value of an effect with its standard deviation.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedValue<'n> {
    /// Name of the parameter, which ends in its unit.
    pub name: &'n str,
    /// The estimate.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
}

/// What each effect of a fit amounts to: deviations by the slopes of the values.
pub(super) fn values(problem: &Problem, fit: &Fit) -> Vec<Vec<NamedValue<'static>>> {
    let context = &problem.first().context;
    with_places(&fit.terms, context)
        .map(|(term, own)| {
            let (at, count) = (own.start, own.len());
            let covariance = fit.covariance.view((at, at), (count, count)).into_owned();
            with_deviations(context, term, &fit.unknowns[own], &covariance)
        })
        .collect()
}

fn with_deviations(
    context: &EffectContext,
    term: &Term,
    unknowns: &[f64],
    covariance: &DMatrix<f64>,
) -> Vec<NamedValue<'static>> {
    let of = |x: &[f64]| term.values(context, x);
    let scales = term.scales(context);
    let now = of(unknowns);
    let mut slopes = DMatrix::zeros(now.len(), unknowns.len());
    for k in 0..unknowns.len() {
        let step = 1e-5 * scales[k];
        let moved = |by: f64| {
            let mut x = unknowns.to_vec();
            x[k] += by;
            of(&x)
        };
        let (ahead, behind) = (moved(step), moved(-step));
        for (row, (a, b)) in ahead.iter().zip(&behind).enumerate() {
            slopes[(row, k)] = (a.value - b.value) / (2.0 * step);
        }
    }
    let spread = &slopes * covariance * slopes.transpose();
    now.into_iter()
        .enumerate()
        .map(|(k, Value { name, value })| NamedValue {
            name,
            value,
            std: spread[(k, k)].max(0.0).sqrt(),
        })
        .collect()
}

/// `0.93° ± 0.04°`, `31 g ± 2 g`: by the unit at the end of its name.
pub fn spoken(found: &NamedValue) -> String {
    let (factor, unit) = Unit::of(found.name).shown();
    let (value, std) = (factor * found.value, factor * found.std);
    let digits = match std {
        s if s.is_finite() && s > 0.0 => (1.0 - s.log10().floor()).clamp(0.0, 6.0) as usize,
        _ => 3,
    };
    let gap = if unit == "°" { "" } else { " " };
    let said = format!("{value:.digits$}{gap}{unit} ± {std:.digits$}{gap}{unit}");
    minus(said.replace("  ", " ").trim_end())
}

/// `width 0.93° ± 0.04°`: what it is called, without the unit, and its value.
pub fn named(found: &NamedValue) -> String {
    format!("{} {}", Unit::stem(found.name), spoken(found))
}

/// `subject`, with its values: `backlash in every joint: width 0.93° ± 0.04°`.
pub(super) fn clause(context: &EffectContext, term: &Term, values: &[NamedValue]) -> String {
    let subject = term.phrase(context);
    if values.is_empty() {
        return subject;
    }
    format!("{subject} ({})", sizes(values))
}

/// Values after each other: `mass 155 g ± 6 g, x 22.6 mm ± 2.3 mm`.
pub(super) fn sizes(values: &[NamedValue]) -> String {
    let said: Vec<String> = values.iter().map(named).collect();
    said.join(", ")
}

/// The text with a capital at its beginning.
pub(crate) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().collect::<String>() + letters.as_str(),
        None => String::new(),
    }
}
