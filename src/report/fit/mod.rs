//! What a fit found: on the console, as JSON, and as a page with figures.

mod correction;
mod page;
#[cfg(test)]
mod tests;
mod text;

use serde::Serialize;

use sesc_identify::fit::Identification;
use sesc_identify::fit::corrected::Corrected;
use sesc_identify::fit::residuals::Residual;
use sesc_identify::health::Finding;

pub use correction::corrections;
pub use page::page;
pub use text::text;

/// All that `sesc fit` prints, as JSON.
#[derive(Debug, Clone, Serialize)]
pub struct FitReport<'a> {
    /// What was identified, and how well.
    #[serde(flatten)]
    pub found: &'a Identification,
    /// The corrected URDF, where one was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corrected: Option<&'a Corrected>,
    /// What the page shows besides.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub shown: Option<&'a Shown>,
}

/// What `sesc fit` prints as JSON of data that cannot be used.
#[derive(Debug, Clone, Serialize)]
pub struct Unusable<'a> {
    /// Always `unusable`.
    pub verdict: &'static str,
    /// Why.
    pub health: &'a [Finding],
}

impl<'a> Unusable<'a> {
    /// Of a fit to such data.
    pub fn of(found: &'a Identification) -> Unusable<'a> {
        Unusable {
            verdict: "unusable",
            health: &found.health,
        }
    }
}

/// What only the page shows.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Shown {
    /// Some of the readings with their predictions; none where only factors are at hand.
    pub residuals: Vec<Residual>,
    /// One row per parameter.
    pub correlation_matrix: Vec<Vec<f64>>,
    /// Words that make this report again.
    pub command: String,
}
