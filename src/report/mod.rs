//! What was found, for people: plain results in, text out; no numerics.
//!
//! [`html`] makes a page that stands alone in one file, [`figures`] the
//! figures on it, [`table`] the aligned columns of the command line. Lengths
//! arrive in metres and leave in millimetres.

pub mod compare;
mod data;
pub mod demo;
pub mod diagnose;
pub mod figures;
pub mod fit;
pub mod fleet;
pub mod health;
pub mod html;
pub mod next_steps;
pub mod origin;
pub mod plan;
mod plot;
mod robot;
mod svg;
pub mod table;
#[cfg(test)]
mod tests;
pub mod unusable;

use serde::Serialize;
use sesc_identify::diagnose::Diagnosis;
use sesc_identify::diagnose::view::DiagnosisView;
use sesc_identify::feet::ClosureFound;
use sesc_identify::fit::{Again, MotionUse, Visits};

/// The seed paper's simulation end to end, on one robot.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DemoReport {
    /// Robot, as its URDF calls it.
    pub robot: String,
    /// Hash of its URDF, in hexadecimal.
    pub hash: String,
    /// Link that stands on the ground.
    pub support: String,
    /// Independent joints.
    pub dof: usize,
    /// Bodies: groups of links joined by fixed joints.
    pub bodies: usize,
    /// Columns of the full regressor.
    pub full_params: usize,
    /// Parameters that CoM rows tell apart.
    pub base_params: usize,
    /// Parameters that flat CoP rows tell apart.
    pub rank_cop: usize,
    /// Postures fitted.
    pub postures: usize,
    /// Range of joint angles, ± degrees.
    pub range_deg: f64,
    /// Noise of a coordinate, m.
    pub noise_m: f64,
    /// Held-out postures.
    pub held_out: usize,
    /// Generated functions, compared with the reference.
    pub functions: Vec<FunctionRow>,
    /// Lengths of bodies; outward from the support.
    pub lengths: Vec<LengthRow>,
    /// Errors of the identified CoP.
    pub errors: Errors,
    /// CoP of some held-out postures.
    pub cop: Vec<CopRow>,
    /// CoM height of some held-out postures.
    pub height: Vec<HeightRow>,
    /// Minimum-norm height minus CAD's, m.
    pub height_offset_m: f64,
    /// Directions that no flat CoP shows.
    pub unobservable: Vec<String>,
    /// The second act; none in reports without it.
    pub hidden: Option<HiddenAct>,
}

/// Something was hidden in the robot, and found.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HiddenAct {
    /// What the diagnosis says.
    pub sentence: String,
    /// Postures that it read.
    pub postures: usize,
    /// Postures never seen that judge.
    pub judged: usize,
    /// RMS error of CAD's CoP there, m.
    pub before: f64,
    /// The same of the corrected model, m.
    pub after: f64,
    /// RMS error of CAD's CoM there, m.
    pub com_before: f64,
    /// The same of the corrected model, m.
    pub com_after: f64,
    /// Lines of Rust of the corrected model.
    #[serde(skip)]
    pub lines: usize,
    /// What its figures show.
    #[serde(skip)]
    pub view: DiagnosisView,
    /// The diagnosis.
    #[serde(skip)]
    pub diagnosis: Diagnosis,
}

/// A generated function: its cost, and its error against the reference.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FunctionRow {
    /// Name of the function.
    pub name: String,
    /// Multiplications.
    pub mul: usize,
    /// Additions.
    pub add: usize,
    /// Pairs of sine and cosine.
    pub sin_cos: usize,
    /// Largest difference from the reference, m.
    pub worst_error_m: f64,
    /// Proven bound, m.
    pub bound_m: f64,
}

/// ‖r_i‖ of one body (the paper's Fig. 3a).
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LengthRow {
    /// Name of the body.
    pub body: String,
    /// Joint that moves the body; empty for the body that stands.
    pub joint: String,
    /// ‖r_i‖ from CAD, m.
    pub cad_m: f64,
    /// ‖r_i‖ by pseudo-inverse, m; identified on all columns.
    pub full_m: f64,
    /// Observable part from CAD, m.
    pub base_cad_m: f64,
    /// The same part identified, m.
    pub base_m: f64,
    /// The unobservable part, or empty.
    pub unseen: String,
}

/// Errors of the identified CoP, m.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(rename = "DemoErrors")
)]
pub struct Errors {
    /// Mean |error| against held-out readings.
    pub measured_mae_m: f64,
    /// Mean |error| against fitted readings.
    pub in_sample_mae_m: f64,
    /// Mean |error| the noise alone makes: σ √(2/π).
    pub noise_mae_m: f64,
    /// RMS error of base columns, m; against the truth.
    pub clean_rmse_base_m: f64,
    /// RMS error of all columns, m; against the truth.
    pub clean_rmse_full_m: f64,
    /// Theory of both; σ √(rank / 2N).
    pub theory_rmse_m: f64,
    /// RMS error of CAD, m; against the truth.
    pub cad_clean_rmse_m: f64,
}

/// CoP (x, y) of one held-out posture, m.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CopRow {
    /// Number of the posture.
    pub pose: usize,
    /// Positions of its joints, rad.
    pub q: Vec<f64>,
    /// Noisy reading.
    pub measured: [f64; 2],
    /// True CoP.
    pub truth: [f64; 2],
    /// Predicted from CAD.
    pub cad: [f64; 2],
    /// Predicted from the identified parameters.
    pub identified: [f64; 2],
}

/// CoM height of one held-out posture, m.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HeightRow {
    /// Number of the posture.
    pub pose: usize,
    /// True height, m.
    pub truth: f64,
    /// Identified, the unobservable constant of minimum norm.
    pub identified: f64,
    /// Identified, the constant taken from CAD.
    pub anchored: f64,
}

/// A name, and what is said of it.
type Fact = (&'static str, String);

/// What consoles say of the data of a fit or a diagnosis.
fn about_data(
    samples: String,
    motion: &MotionUse,
    again: Option<&Again>,
    closure: Option<&ClosureFound>,
    visits: Option<&Visits>,
) -> impl Iterator<Item = Fact> {
    let motion = Some(motion.sentence.clone()).filter(|motion| !motion.is_empty());
    let facts = [
        ("samples", Some(samples)),
        ("motion", motion),
        ("reach again", again.map(|own| own.sentence.clone())),
        ("soles", closure.map(soles)),
        ("visits", visits.map(Visits::sentence)),
    ];
    let known = facts.into_iter();
    known.filter_map(|(name, said)| Some((name, said?)))
}

/// How the soles of both feet lie, in a line.
fn soles(closure: &ClosureFound) -> String {
    let why = match closure.noise_from_log {
        true => "as the log has it",
        false => "the least that is believed",
    };
    format!(
        "{} off that of {} by {} RMS, {} left; noise of a posture {}, {why}; in all postures alike \
         {} are allowed",
        closure.other_foot,
        closure.support,
        closure.before.sentence(),
        closure.after.sentence(),
        closure.noise.sentence(),
        closure.tolerance.sentence()
    )
}
