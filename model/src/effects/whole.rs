//! What is no rewrite of the measurement: outliers, and the masses themselves.
//!
//! ```text
//! cop_outliers         a few readings come from elsewhere: noise of two widths
//! mass_distribution    all of r is identified again, CAD within tolerances
//! ```
//!
//! Outliers (a foot that slips, a hand on the robot) are named by posture; they
//! are imitated by nothing that most postures share. A mass distribution imitates
//! every load and, on one flat foot, offsets and gains too: it is the last resort.

use super::{Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct CopOutliers;

impl Effect for CopOutliers {
    fn name(&self) -> &'static str {
        "cop_outliers"
    }

    fn stage(&self) -> Stage {
        Stage::Whole
    }

    fn targets(&self, _: &Setting) -> Vec<Target> {
        vec![Target::Whole]
    }

    fn scales(&self, _: &Setting, _: &Target) -> Vec<f64> {
        Vec::new()
    }

    fn rewrite(&self, _: &Target, _: &mut Measured, _: &[Id]) {}

    fn values(&self, _: &Setting, _: &Target, _: &[f64]) -> Vec<Value> {
        Vec::new()
    }

    fn unknowns(&self, _: &Setting, _: &Target, _: &[f64]) -> Vec<f64> {
        Vec::new()
    }

    fn of_posture(&self) -> bool {
        false
    }
}

pub(super) struct MassDistribution;

impl Effect for MassDistribution {
    fn name(&self) -> &'static str {
        "mass_distribution"
    }

    fn stage(&self) -> Stage {
        Stage::Whole
    }

    fn targets(&self, _: &Setting) -> Vec<Target> {
        vec![Target::Whole]
    }

    fn scales(&self, _: &Setting, _: &Target) -> Vec<f64> {
        Vec::new()
    }

    fn rewrite(&self, _: &Target, _: &mut Measured, _: &[Id]) {}

    fn values(&self, _: &Setting, _: &Target, _: &[f64]) -> Vec<Value> {
        Vec::new()
    }

    fn unknowns(&self, _: &Setting, _: &Target, _: &[f64]) -> Vec<f64> {
        Vec::new()
    }
}
