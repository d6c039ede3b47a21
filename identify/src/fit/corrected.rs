//! The URDF whose masses and centres of mass give the identified parameters.
//!
//! Everything that data do not determine keeps its CAD value; the text changes in
//! numbers of `<inertial>` alone ([`sesc_model::urdf::edit_masses`]). Before it is
//! handed out, the text is read again and must give the parameters it was made for.

use nalgebra::DVector;
use serde::Serialize;
use sesc_model::{Model, Snapping, urdf};

use super::masses::{self, Limits, Masses};
use super::prior::Prior;
use crate::robot::Robot;
use crate::{Error, Setting, message};

/// Base parameters of the corrected robot may be off by this, m.
const EXACT: f64 = 1e-11;

/// A corrected description.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Corrected {
    /// Mass of the robot, kg.
    pub total_mass: f64,
    /// Links that changed.
    pub links: Vec<Change>,
    /// Bounds on masses that shape the correction.
    pub active_bounds: Vec<String>,
    /// The whole text of the URDF.
    #[serde(skip)]
    pub text: String,
}

/// What a link weighs and where, in CAD and as corrected.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(rename = "LinkChange")
)]
pub struct Change {
    /// Name of the link.
    pub link: String,
    /// Mass in CAD and as corrected, kg.
    pub mass: [f64; 2],
    /// CoM in CAD and as corrected, m.
    pub com: [[f64; 3]; 2],
}

impl Change {
    /// How far the CoM moved, m.
    pub fn shift(&self) -> f64 {
        let [from, to] = self.com;
        (0..3)
            .map(|a| (to[a] - from[a]).powi(2))
            .sum::<f64>()
            .sqrt()
    }
}

/// Correct the text of `robot`, which weighs `total` kg (CAD's mass unless given), so that it has
/// the base parameters `params`; by `masses` where they are known, else by the nearest to CAD.
///
/// # Errors
/// When no masses give these parameters.
#[doc(hidden)]
pub fn correct(
    robot: &Robot,
    model: &Model,
    snapping: Snapping,
    (params, masses): (&[f64], Option<&Masses>),
    prior: &Prior,
    total: Option<f64>,
) -> Result<Corrected, Error> {
    check_positive(Setting::TotalMass, total, " kg")?;
    let found = towards(robot, model, snapping, (params, masses), prior, total)?;
    found.map_err(|reason| {
        Error::request(message![
            format!("no URDF has the identified parameters: {reason}; trust CAD more ("),
            Setting::Prior,
            " cad) or fit physical masses only (",
            Setting::Physical,
            "). Nothing was written"
        ])
    })
}

/// The same where the inner error says why no masses give the parameters.
///
/// # Errors
/// When a text cannot be read.
pub(crate) fn towards(
    robot: &Robot,
    model: &Model,
    snapping: Snapping,
    (params, masses): (&[f64], Option<&Masses>),
    prior: &Prior,
    total: Option<f64>,
) -> Result<Result<Corrected, String>, Error> {
    let masses = match masses_of(robot, model, (params, masses), prior) {
        Ok(masses) => masses,
        Err(reason) => return Ok(Err(reason)),
    };
    let total_mass = total.unwrap_or(model.tree.mass);
    let weights = masses.weights(model, total_mass);
    let file = &robot.description.file;
    let text = urdf::edit_masses(&robot.description, &weights).map_err(sesc_model::Error::from)?;
    let again = Robot::parse(&text, file)?.model(model.support(), snapping, None)?;
    let params = DVector::from_column_slice(params);
    let off = (DVector::from_vec(again.cad_params()) - params).amax();
    if off.is_nan() || off > EXACT {
        return Ok(Err(format!(
            "the masses found give them only to {off:.1e} m"
        )));
    }
    let links = again.tree.links.iter().zip(&model.tree.links);
    let links = links
        .map(|(new, old)| Change {
            link: new.name.clone(),
            mass: [old.mass, new.mass],
            com: [old.com(), new.com()],
        })
        .filter(|change| change.mass[0] != change.mass[1] || change.shift() > 0.0);
    Ok(Ok(Corrected {
        total_mass,
        links: links.collect(),
        active_bounds: masses.active,
        text,
    }))
}

/// The masses of the corrected URDF: those that are known, else the nearest to CAD.
pub(super) fn masses_of(
    robot: &Robot,
    model: &Model,
    (params, masses): (&[f64], Option<&Masses>),
    prior: &Prior,
) -> Result<Masses, String> {
    if let Some(masses) = masses {
        return Ok(masses.clone());
    }
    let (params, limits) = (DVector::from_column_slice(params), Limits::generous(robot));
    masses::nearest(model, &prior.tolerances(), &params, &limits)
}

/// A number above zero that a robot can have.
pub(super) fn check_positive(
    setting: Setting,
    value: Option<f64>,
    unit: &str,
) -> Result<(), Error> {
    match value.filter(|x| !(1e-9..=1e6).contains(x)) {
        None => Ok(()),
        Some(x) => Err(Error::request(message![
            setting,
            format!(" {x:e}{unit}: give a number above zero that a robot can have")
        ])),
    }
}
