//! What `sesc fit` makes of a fit besides the model file: a corrected URDF, physical
//! masses, a page.

use std::path::{Path, PathBuf};

use clap::Args;

use super::outputs::{Files, Kind, Together};
use super::{cad_mass_kg, command_line, units};
use crate::Error;
use crate::report::fit::{FitReport, Shown, page};
use crate::report::next_steps::Worded;
use crate::report::unusable;
use sesc_identify::fit::{Report, Request};
use sesc_identify::skeleton::Skeleton;

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
    total_mass: Option<f64>,
    /// Fit physical masses only: none negative, CoMs inside the collision geometry (boxes,
    /// cylinders, spheres) where the URDF gives it, else near the joints of the link
    #[arg(long, conflicts_with = "partial")]
    physical: bool,
    /// Page to write: figures, tables, what cannot be seen
    #[arg(long, value_name = "FILE", conflicts_with = "partial")]
    report: Option<PathBuf>,
}

impl Outputs {
    /// Say what is written.
    pub(super) fn claimed(&self, files: Files) -> Files {
        let files = files.writes(Kind::Urdf, &self.urdf);
        files.writes(Kind::Page, &self.report)
    }

    /// The URDF to write.
    pub(super) fn urdf(&self) -> Option<&PathBuf> {
        self.urdf.as_ref()
    }

    /// Ask for what they are made of.
    ///
    /// # Errors
    /// A total mass that can only have been meant in another unit.
    pub(super) fn ask(&self, request: &mut Request) -> Result<(), Error> {
        if let Some(robot) = &request.robot {
            units::check_mass(self.total_mass, cad_mass_kg(robot))?;
        }
        request.physical = self.physical;
        request.corrected_urdf = self.urdf.is_some();
        request.total_mass = self.total_mass;
        request.residuals = self.report.is_some();
        Ok(())
    }

    /// What the page shows besides the fit, where one is asked for.
    pub(super) fn shown(&self, report: &Report, folder: Option<&Path>) -> Option<Shown> {
        let sample = || report.residuals.clone();
        (self.report.is_some()).then(|| Shown::of(report, sample(), command_line(), folder))
    }

    /// Write the page of data that cannot be used, where one is asked for.
    pub(super) fn write_broken(
        &self,
        report: &Report,
        next: &[Worded],
        folder: Option<&Path>,
        files: &mut Together,
    ) -> Result<(), Error> {
        if let Some(path) = &self.report {
            let drawn = Skeleton::of(report.model(), &report.robot().description, folder);
            let found = &report.identification;
            let text = unusable::page_of_fit(found, next, Some(&drawn), &command_line());
            files.add(path, &text.map_err(|error| Error::Report(Box::new(error)))?)?;
        }
        Ok(())
    }

    /// Write what is asked for.
    pub(super) fn write(&self, report: &FitReport<'_>, files: &mut Together) -> Result<(), Error> {
        if let (Some(path), Some(corrected)) = (&self.urdf, report.corrected) {
            files.add(path, &corrected.text)?;
        }
        if let Some(path) = &self.report {
            let text = page(report).map_err(|error| Error::Report(Box::new(error)))?;
            files.add(path, &text)?;
        }
        Ok(())
    }
}
