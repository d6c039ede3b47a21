//! What a diagnosis says, and what it was made of.

use std::collections::BTreeMap;

use serde::Serialize;

use super::held_out::HeldOut;
use super::problem::Fit;
use crate::observations::noise::NoiseSource;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Simulation and data agree.
    None,
    /// One explanation.
    Named,
    /// Several that these data cannot tell apart.
    Class,
    /// Masses within their tolerances take the gap: no effect is visible.
    Absorbed,
    /// Nothing known explains it.
    Unexplained,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gap {
    pub rmse: f64,
    pub rmse_x: f64,
    pub rmse_y: f64,
    pub bias: [f64; 2],
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantity {
    pub value: f64,
    pub std: f64,
}

/// One effect of the explanation, in the order in which they close the gap.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Step {
    pub effect: &'static str,
    pub target: String,
    pub parameters: BTreeMap<&'static str, Quantity>,
    /// Held-out, without and with it (beside the steps before), m.
    pub rmse_before: f64,
    pub rmse_after: f64,
    /// By how much −2 log evidence rises without it, its penalty paid.
    pub evidence: f64,
    pub sentence: String,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Last {
    /// Held-out, m.
    pub rmse: f64,
    pub rmse_x: f64,
    pub rmse_y: f64,
    /// Postures not judged by: outliers, and joints on the unlikely side of a
    /// dead band.
    pub left_out: usize,
}

/// A complete explanation that the data allow.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Member {
    pub effects: Vec<String>,
    /// −2 log evidence above the best of the class.
    pub score_difference: f64,
    pub sentence: String,
}

/// An effect that this log can hardly show.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Blind {
    pub effect: String,
    /// From this size on it would be seen.
    pub from: f64,
    /// The smallest that would be detected, as people read it.
    pub size: String,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Leftover {
    pub chi2: f64,
    pub expected: f64,
    /// What the rest goes with most, and its share.
    pub strongest: Option<String>,
    pub strongest_share: f64,
    /// Found, not physical.
    pub formula: Option<String>,
    pub formula_share: Option<f64>,
}

/// One experiment and what it would do to the class.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ExperimentProposal {
    pub what: String,
    /// Explanations other than the first that it would exclude.
    pub splits: usize,
    /// χ² against the nearest that it would exclude, and for each member of the class.
    pub separations: Vec<f64>,
}

/// What next postures are for, and where they were written.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct NextPostures {
    pub why: String,
    pub file: Option<String>,
    /// What was compared, the best first.
    pub experiments: Vec<ExperimentProposal>,
}

/// Everything that is said of a log. Lengths in m.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diagnosis {
    pub verdict: Verdict,
    pub sentence: String,
    pub robot: String,
    pub support: String,
    pub log: String,
    pub postures: usize,
    pub postures_used: usize,
    pub prior: String,
    pub noise: f64,
    pub noise_floor: f64,
    pub noise_source: NoiseSource,
    pub baseline: Gap,
    pub baseline_chi2: f64,
    pub steps: Vec<Step>,
    #[serde(rename = "final")]
    pub last: Last,
    pub indistinguishable: Vec<Vec<String>>,
    pub class: Vec<Member>,
    /// RMS of what masses within their prior take of the gap, m.
    pub absorbed_by_masses: f64,
    pub unexplained: bool,
    pub leftover: Leftover,
    /// Poses that are rather outliers.
    pub outliers: Vec<i64>,
    pub blind: Vec<Blind>,
    pub hypotheses_fitted: usize,
    pub next_postures: NextPostures,
}

/// A diagnosis with what reports, models and experiments are made from.
pub struct Found {
    pub diagnosis: Diagnosis,
    /// The explanation, fitted.
    pub best: Fit,
    /// All that the data allow, the best first.
    pub class: Vec<Fit>,
    /// The explanation effect by effect.
    pub steps: Vec<Fit>,
    pub baseline: HeldOut,
    pub held_out: Vec<HeldOut>,
}

/// Names for the report.
pub struct About<'a> {
    pub robot: &'a str,
    pub support: &'a str,
    pub log: &'a str,
    pub prior: String,
}
