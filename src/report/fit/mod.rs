//! What a fit found: on the console, as JSON, and as a page with figures.

mod page;
#[cfg(test)]
mod tests;
mod text;

use std::path::Path;

use serde::Serialize;
use sesc_model::base::Column;

use sesc_identify::fit::corrected::Corrected;
use sesc_identify::fit::residuals::{Residual, Sample};
use sesc_identify::fit::{self, Identification};
use sesc_identify::health::Finding;
use sesc_identify::skeleton::Skeleton;

use crate::report::figures::fit::moved;
use crate::report::next_steps::Worded;

pub use page::page;
pub use text::{corrections, text};

/// All that `sesc fit` prints, as JSON.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FitReport<'a> {
    /// What was identified, and how well.
    #[serde(flatten)]
    pub found: &'a Identification,
    /// What to do next.
    pub next_steps: &'a [Worded],
    /// The corrected URDF, where one was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corrected: Option<&'a Corrected>,
    /// What the page shows besides.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub shown: Option<&'a Shown>,
}

/// What `sesc fit` and `sesc compare` print as JSON of data that cannot be used.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Unusable<'a> {
    /// Always `unusable`.
    pub verdict: &'static str,
    /// The log, where several are given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub log: Option<&'a str>,
    /// Why.
    pub health: &'a [Finding],
    /// What to do next.
    pub next_steps: &'a [Worded],
}

impl<'a> Unusable<'a> {
    /// What is wrong with the data, and what to do next.
    pub fn new(health: &'a [Finding], next_steps: &'a [Worded]) -> Unusable<'a> {
        Unusable {
            verdict: "unusable",
            log: None,
            health,
            next_steps,
        }
    }
}

/// What only the page shows.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Shown {
    /// Some of the readings with their predictions; none where only factors are at hand.
    pub residuals: Vec<Residual>,
    /// One row per parameter.
    pub correlation_matrix: Vec<Vec<f64>>,
    /// Words that make this report again.
    pub command: String,
    /// The robot, and how far data moved its bodies.
    #[serde(skip)]
    pub robot: Option<Moved>,
    /// Least and largest position of every joint over all rows, rad or m.
    #[serde(skip)]
    pub used: Vec<[f64; 2]>,
}

/// The robot of a fit, and how far data moved its bodies.
#[derive(Debug, Clone)]
pub struct Moved {
    /// The robot.
    pub skeleton: Skeleton,
    /// The largest change of a parameter of each body, in its standard deviations.
    pub deviations: Vec<f64>,
}

impl Shown {
    /// What is shown of a fit and some of its readings; `command` makes the page again, meshes
    /// are looked for in `folder`.
    pub fn of(
        report: &fit::Report,
        sample: Sample,
        command: String,
        folder: Option<&Path>,
    ) -> Shown {
        let (found, model) = (&report.identification, &report.model);
        let skeleton = Skeleton::of(model, &report.robot.description, folder);
        let mut deviations = vec![0.0_f64; skeleton.bodies.len()];
        for (known, param) in found.parameters.iter().zip(&model.base.params) {
            let (Column::Axis { body, .. } | Column::Prismatic { body }) = param.column;
            if let Some(own) = moved(known) {
                deviations[body] = deviations[body].max(own.abs());
            }
        }
        Shown {
            residuals: sample.rows,
            used: sample.used,
            correlation_matrix: found.correlation_matrix(),
            command,
            robot: Some(Moved {
                skeleton,
                deviations,
            }),
        }
    }
}
