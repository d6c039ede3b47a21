//! What a diagnosis found: on the console, and as a page with figures.

mod page;
#[cfg(test)]
mod tests;
mod text;

pub use page::page;
pub use text::{Asked, text};

use sesc_identify::diagnose::findings::Step;
use sesc_identify::diagnose::words::{Found, named};

/// `width 0.93° ± 0.04°`, one entry per parameter.
fn parameters(step: &Step) -> Vec<String> {
    let found = step.parameters.iter().map(|(name, quantity)| Found {
        name,
        value: quantity.value,
        std: quantity.std,
    });
    found.map(|found| named(&found)).collect()
}

/// `backlash l_knee`, in words that stay apart.
fn effect(step: &Step) -> String {
    step.effect.replace('_', " ")
}

/// `1 posture`, `2 postures`.
fn count(n: usize, what: &str) -> String {
    match n {
        1 => format!("1 {what}"),
        n => format!("{n} {what}s"),
    }
}
