//! The URDF whose masses and centres of mass give the identified parameters.
//!
//! Everything that data do not determine keeps its CAD value; the text changes in
//! numbers of `<inertial>` alone ([`sesc_model::urdf::edit_masses`]). Before it is
//! handed out, the text is read again and must give the parameters it was made for.

use nalgebra::DVector;
use serde::Serialize;
use sesc_model::{Model, Snapping, urdf};

use super::Identification;
use super::limits::Limits;
use super::masses::{self, Impossible, Masses};
use super::prior::{Prior, Tolerances};
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

/// Correct the text of `robot`, which weighs `total` kg (CAD's mass unless given).
///
/// # Errors
/// When no masses give the identified parameters.
#[doc(hidden)]
pub fn correct(
    robot: &Robot,
    model: &Model,
    snapping: Snapping,
    found: &Identification,
    prior: &Prior,
    total: Option<f64>,
) -> Result<Corrected, Error> {
    let params: Vec<f64> = found.parameters.iter().map(|p| p.value).collect();
    towards(
        robot,
        model,
        snapping,
        &params,
        found.masses.as_ref(),
        prior,
        total,
    )?
    .map_err(|impossible| refused(&impossible))
}

/// Correct the text of `robot` so that it has these base parameters; by `masses` where
/// they are known, else by the nearest to CAD. The inner error says why there are none.
///
/// # Errors
/// When a text cannot be read.
#[doc(hidden)]
pub fn towards(
    robot: &Robot,
    model: &Model,
    snapping: Snapping,
    params: &[f64],
    masses: Option<&Masses>,
    prior: &Prior,
    total: Option<f64>,
) -> Result<Result<Corrected, Impossible>, Error> {
    let masses = match masses_of(robot, model, params, masses, prior) {
        Ok(masses) => masses,
        Err(impossible) => return Ok(Err(impossible)),
    };
    let params = DVector::from_column_slice(params);
    let total_mass = total.unwrap_or(model.tree.mass);
    let weights = masses.weights(model, total_mass);
    let file = &robot.description.file;
    let text = urdf::edit_masses(&robot.description, &weights).map_err(sesc_model::Error::from)?;
    let support = &model.tree.links[model.tree.support].name;
    let again = Robot::parse(&text, file)?.model(support, snapping, None)?;
    let off = (DVector::from_vec(again.cad_params()) - &params).amax();
    if off.is_nan() || off > EXACT {
        return Ok(Err(Impossible {
            reason: format!("the masses found give them only to {off:.1e} m"),
        }));
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
    params: &[f64],
    masses: Option<&Masses>,
    prior: &Prior,
) -> Result<Masses, Impossible> {
    if let Some(masses) = masses {
        return Ok(masses.clone());
    }
    let usual = Tolerances::usual();
    let tolerances = match prior {
        Prior::Cad(tolerances) => tolerances,
        Prior::Free | Prior::Population(_) | Prior::Fitted(_) => &usual,
    };
    let params = DVector::from_column_slice(params);
    masses::nearest(model, tolerances, &params, &Limits::generous(robot))
}

/// The URDF of `robot` with the parameters of a fit that is no more: `theta` are its
/// [masses](super::Report::masses); where they are none, the nearest within `prior` are
/// looked for.
///
/// # Errors
/// As those of [`super::Report::corrected_urdf`].
#[doc(hidden)]
pub fn corrected_of(
    robot: &Robot,
    model: &Model,
    snapping: Snapping,
    (params, theta): (&[f64], Option<&[f64]>),
    prior: &Prior,
    total: Option<f64>,
) -> Result<Corrected, Error> {
    check_total(total)?;
    let masses = theta.map(|theta| Masses {
        theta: DVector::from_column_slice(theta),
        active: Vec::new(),
    });
    let masses = masses.as_ref();
    towards(robot, model, snapping, params, masses, prior, total)?
        .map_err(|impossible| refused(&impossible))
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

/// What a robot can weigh, kg.
pub(super) fn check_total(total: Option<f64>) -> Result<(), Error> {
    check_positive(Setting::TotalMass, total, " kg")
}

fn refused(impossible: &Impossible) -> Error {
    let reason = &impossible.reason;
    Error::request(message![
        format!("no URDF has the identified parameters: {reason}; trust CAD more ("),
        Setting::Prior,
        " cad) or fit physical masses only (",
        Setting::Physical,
        "). Nothing was written"
    ])
}
