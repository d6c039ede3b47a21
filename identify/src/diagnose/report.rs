//! Everything that a diagnosis answers with.

use sesc_model::ModelFile;

use super::corrected_urdf::CorrectedUrdf;
use super::experiment::NextLog;
use super::findings::Diagnosis;
use super::view::DiagnosisView;
use crate::logs::Recording;

/// Everything that was found.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Report {
    /// What was found, as it is printed.
    pub diagnosis: Diagnosis,
    /// Parameters and effects, for predictions and generated code.
    pub model_file: ModelFile,
    /// Where it was wanted.
    pub corrected_urdf: Option<CorrectedUrdf>,
    /// Whether masses are part of the explanation: those of a corrected URDF then move within
    /// the usual tolerances, else within those of the request.
    pub frees_masses: bool,
    /// What of the explanation belongs to the log alone, a sentence each.
    pub of_the_log: Vec<String>,
    /// Where it was wanted.
    #[doc(hidden)]
    pub view: Option<DiagnosisView>,
    /// Where it was wanted.
    #[doc(hidden)]
    pub recording: Option<Recording>,
    /// Postures of the experiment that would tell most, if one would tell explanations apart.
    pub next: Option<NextLog>,
    /// What is to be known of the robot.
    pub notes: Vec<String>,
}
