//! What `sesc fit` makes of a fit besides the model file: a corrected URDF, physical
//! masses, a page.

use std::path::PathBuf;

use clap::Args;
use sesc_model::{Model, Snapping};

use super::{command_line, message};
use crate::Error;
use crate::report::fit::{FitReport, Shown, page};
use sesc_identify::fit::corrected::{Corrected, correct};
use sesc_identify::fit::limits::Limits;
use sesc_identify::fit::prior::Prior;
use sesc_identify::fit::{Identification, residuals::Residual};
use sesc_identify::output;
use sesc_identify::robot::Robot;

#[derive(Args)]
pub(super) struct Outputs {
    /// URDF to write: masses and CoMs nearest to CAD that give the identified parameters;
    /// nothing else in the file changes but inertia, scaled with the mass of its link
    #[arg(long, value_name = "FILE", conflicts_with = "partial")]
    urdf: Option<PathBuf>,
    /// What the robot weighs in that URDF, kg; as in CAD unless given
    #[arg(
        long,
        value_name = "KG",
        requires = "urdf",
        allow_negative_numbers = true
    )]
    pub(super) total_mass: Option<f64>,
    /// Fit physical masses only: none negative, CoMs inside the collision geometry (boxes,
    /// cylinders, spheres) where the URDF gives it, else near the joints of the link
    #[arg(long, conflicts_with = "partial")]
    physical: bool,
    /// Page to write: figures, tables, what cannot be seen
    #[arg(long, value_name = "FILE", conflicts_with = "partial")]
    report: Option<PathBuf>,
}

impl Outputs {
    /// Files to write.
    pub(super) fn files(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.urdf, &self.report].into_iter().flatten()
    }

    /// Whether a page is asked for.
    pub(super) fn page(&self) -> bool {
        self.report.is_some()
    }

    /// Bounds of physical masses, if they are asked for.
    pub(super) fn limits(&self, robot: &Robot) -> Result<Option<Limits>, Error> {
        Ok(self.physical.then(|| Limits::of(robot)).transpose()?)
    }

    /// The corrected description, if it is asked for; before anything is written.
    pub(super) fn correct(
        &self,
        robot: &Robot,
        model: &Model,
        snapping: Snapping,
        found: &Identification,
        prior: &Prior,
    ) -> Result<Option<Corrected>, Error> {
        if self.physical && found.masses.is_none() {
            return Err(Error::Usage(format!(
                "--physical: {}; fit without it, or with --prior cad",
                found.warnings.join("; ")
            )));
        }
        if self.urdf.is_none() {
            return Ok(None);
        }
        Ok(Some(correct(
            robot,
            model,
            snapping,
            found,
            prior,
            self.total_mass,
        )?))
    }

    /// What the page shows besides the fit.
    pub(super) fn shown(&self, found: &Identification, residuals: Vec<Residual>) -> Option<Shown> {
        self.page().then(|| Shown {
            residuals,
            correlation_matrix: found.correlation_matrix(),
            command: command_line(),
        })
    }

    /// Write what is asked for.
    pub(super) fn write(&self, report: &FitReport<'_>) -> Result<(), Error> {
        if let (Some(path), Some(corrected)) = (&self.urdf, report.corrected) {
            output::write(path, &corrected.text)?;
            message(&format!("wrote {}", path.display()));
        }
        if let Some(path) = &self.report {
            let text = page(report).map_err(|error| Error::Report(Box::new(error)))?;
            output::write(path, &text)?;
            message(&format!("wrote {}", path.display()));
        }
        Ok(())
    }
}
