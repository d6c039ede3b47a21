//! What a diagnosis found: on the console, and as a page with figures.

mod page;
#[cfg(test)]
mod tests;
mod text;

pub(super) use page::card;
pub use page::page;
pub use text::text;

use serde::Serialize;
use sesc_identify::diagnose::remedy::Remedy;
use sesc_identify::diagnose::words::named;
use sesc_identify::diagnose::{Diagnosis, Step, Verdict};

use super::next_steps::Worded;
use super::table::in_words;

/// All that `sesc diagnose` prints, as JSON.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DiagnoseReport<'a> {
    /// What was found.
    #[serde(flatten)]
    pub found: &'a Diagnosis,
    /// What to do next.
    pub next_steps: &'a [Worded],
    /// How the model file is used, where one is written that predicts the log.
    #[serde(rename = "use", skip_serializing_if = "Option::is_none")]
    pub model_use: Option<ModelUse>,
}

/// How a model file is used.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ModelUse {
    /// The file.
    pub model: String,
    /// The line of a `build.rs`.
    pub build_rs: String,
    /// What generates C.
    pub generate: String,
    /// The CoM's call in C.
    pub c: &'static str,
}

/// `width 0.93° ± 0.04°`, one entry per parameter.
fn parameters(step: &Step) -> Vec<String> {
    let found = step.parameters.iter();
    let found = found.map(|(name, own)| named(name, own.value, own.std));
    found.collect()
}

/// `backlash l_knee`, in words that stay apart.
fn effect(step: &Step) -> String {
    in_words(step.effect)
}

/// Where to make a change, and how sure it is that it is right.
fn where_to(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Unexplained => {
            "What was found explains a part only: find the rest before anything is changed."
        }
        Verdict::Class => {
            "If the first explanation is right, correct it in one place only: on the robot, in its \
             URDF or by the model file."
        }
        _ => "Correct it in one place only: on the robot, in its URDF or by the model file.",
    }
}

/// `zero 2048 → 2031, sign 1 → -1`: what changes in a servo file.
fn servo(remedy: &Remedy) -> Option<String> {
    let words = remedy.servo_words();
    (!words.is_empty()).then(|| words.join(", "))
}
