//! Everything that a diagnosis answers with, and the postures to take next.

use std::path::Path;

use sesc_model::effects::Experiment;
use sesc_model::tree::Dof;
use sesc_model::{Model, ModelFile};

use super::corrected_urdf::CorrectedUrdf;
use super::findings::Diagnosis;
use super::next_postures::{Next, OnFoot};
use super::view::DiagnosisView;
use crate::Error;
use crate::logs::{PostureWriter, Row, Sidecar, Written};

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
    /// Postures of the experiment that would tell most, if one would tell explanations apart.
    pub next: Option<NextLog>,
    /// What is to be known of the robot.
    pub notes: Vec<String>,
}

/// Postures to be taken next.
#[derive(Debug, Clone)]
pub struct NextLog {
    /// File of the robot's description.
    pub robot: String,
    /// Link on the ground.
    pub support: String,
    /// The experiment that they belong to, written into the sidecar.
    pub experiment: Option<Experiment>,
    /// The robot's independent joints, in the order of `q`.
    pub dofs: Vec<Dof>,
    /// Posture by posture, joint by joint, rad or m.
    pub q: Vec<f64>,
    /// Place of each posture among them by how much it tells, from 0; empty where all are
    /// to be taken.
    pub ranks: Vec<usize>,
}

impl NextLog {
    /// Write them to a log with its sidecar.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let mut log = PostureWriter::create(path, &self.dofs, Written::default())?;
        for (pose, q) in self.q.chunks_exact(self.dofs.len()).enumerate() {
            log.row(&Row {
                pose: pose as i64,
                q,
                ..Row::default()
            })?;
        }
        log.finish(&Sidecar {
            robot: Some(self.robot.clone()),
            support: Some(self.support.clone()),
            experiment: self.experiment.as_ref().map(|e| e.name().to_string()),
            ..Sidecar::default()
        })?;
        Ok(())
    }
}

/// The postures of the best experiment, where it tells anything.
pub(super) fn next_log(next: Next, model: &Model, robot: &str) -> Option<NextLog> {
    next.telling()?;
    let OnFoot { support, q, ranks } = next.postures?;
    Some(NextLog {
        robot: robot.to_string(),
        support,
        experiment: next.experiment,
        dofs: model.tree.dofs.clone(),
        q,
        ranks,
    })
}
