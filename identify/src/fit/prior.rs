//! CAD as knowledge with stated uncertainty.
//!
//! Tolerances of CAD are those of [`Tolerances`]; a fleet's are those of its [`Population`]. One robot
//! as an earlier fit knows it takes the place of both:
//!
//! ```text
//! r ~ N(r̂, C)      C = (RᵀR)⁻¹ = S Sᵀ, S = R⁻¹      R: `information.factor` of a model file
//! ```
//!
//! Of a direction that neither data nor prior say anything about, R has a row of zeros; there r stays
//! at r̂.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use nalgebra::{DMatrix, DVector};
use serde::de::IgnoredAny;
use sesc_model::files;
use sesc_model::text::listed;
use sesc_model::urdf::suggestion;
use sesc_model::{Model, ModelFile};

use super::population::{FORMAT, Fitted, Population};
use crate::logs::names::short;
pub use crate::tolerances::{Tolerance, Tolerances};
use crate::{Error, Setting, message};

/// What is known before the data.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Prior {
    /// Nothing: data alone; directions they cannot see stay at CAD.
    Free,
    /// CAD within tolerances.
    Cad(Tolerances),
    /// What a fleet of such robots is like.
    Population(Box<Fitted>),
    /// What an earlier fit knows of this robot.
    Fitted(Box<Fitted>),
}

/// Which prior, before the robot is known that it is of.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub enum PriorChoice {
    /// CAD taken nearly for granted: masses to 0.2 %, CoMs to 0.1 mm.
    Tight,
    /// CAD as it usually is: masses to 10 %, CoMs to 5 mm.
    #[default]
    Cad,
    /// Data alone.
    Free,
    /// A file of tolerances, of a [`Population`], or of a model that was fitted.
    File(PathBuf),
    /// A prior from the caller.
    Given(Prior),
}

impl PriorChoice {
    /// The prior itself.
    ///
    /// # Errors
    /// When a file cannot be read, names unknown links or holds no tolerances.
    pub fn of(&self, model: &Model) -> Result<Prior, Error> {
        Ok(match self {
            PriorChoice::Tight => Prior::Cad(Tolerances::tight()),
            PriorChoice::Cad => Prior::Cad(Tolerances::usual()),
            PriorChoice::Free => Prior::Free,
            PriorChoice::File(file) => Prior::read(file, model)?,
            PriorChoice::Given(prior) => prior.clone(),
        })
    }
}

impl From<&str> for PriorChoice {
    /// `tight`, `cad` or `free`; any other name is that of a file.
    fn from(name: &str) -> PriorChoice {
        match name {
            "tight" => PriorChoice::Tight,
            "cad" => PriorChoice::Cad,
            "free" => PriorChoice::Free,
            file => PriorChoice::File(PathBuf::from(file)),
        }
    }
}

impl From<Prior> for PriorChoice {
    fn from(prior: Prior) -> PriorChoice {
        PriorChoice::Given(prior)
    }
}

impl Prior {
    /// The default of fits and plans: the usual tolerances of CAD.
    pub const DEFAULT: &str = "cad";

    /// The default of diagnoses. Within the usual tolerances masses
    /// absorb a slope, a payload, most pairs of effects; held tight, masses that are
    /// off are an explanation that competes with the effects and is named.
    pub const OF_DIAGNOSES: &str = "tight";

    /// `tight`, `cad`, `free`, or a file of tolerances, of a [`Population`] or of a fitted model.
    ///
    /// # Errors
    /// As [`PriorChoice::of`].
    pub fn named(name: &str, model: &Model) -> Result<Prior, Error> {
        PriorChoice::from(name).of(model)
    }

    fn read(path: &Path, model: &Model) -> Result<Prior, Error> {
        let file = path.display().to_string();
        let text = files::read_text(path, files::MODEL).map_err(|source| {
            let source = format!("{source}; ");
            let message = message![source, Setting::Prior, " takes tight, cad, free or a file"];
            Error::prior(&file, message)
        })?;
        let keys: BTreeMap<String, IgnoredAny> =
            files::parse_toml(&text, u32::MAX).map_err(|fault| Error::prior_toml(&file, fault))?;
        if keys.contains_key("population") {
            let found = Population::read(&text, &file, model)?;
            return Ok(Prior::Population(Box::new(found)));
        }
        if keys.contains_key("parameters") {
            let fitted = ModelFile::parse(&text, &file)?;
            let fitted = Fitted::new(&fitted, model, &file)?;
            return Ok(Prior::Fitted(Box::new(fitted)));
        }
        read_tolerances(&text, &file, model).map(Prior::Cad)
    }

    /// In a few words, for reports.
    pub fn sentence(&self) -> String {
        match self {
            Prior::Population(found) => format!(
                "a fleet: mean and covariance of {} robots of this URDF",
                found.source
            ),
            Prior::Fitted(found) => format!("masses as they were fitted ({})", found.source),
            Prior::Free => "none: data alone, what they cannot see stays at CAD".to_string(),
            Prior::Cad(tolerances) => {
                let (mass, com) = tolerances.of_link("");
                let own = match tolerances.links.len() {
                    0 => String::new(),
                    1 => ", one link with tolerances of its own".to_string(),
                    n => format!(", {n} links with tolerances of their own"),
                };
                format!(
                    "CAD: masses ± {} %, CoMs ± {} mm (standard deviations){own}",
                    100.0 * mass,
                    1e3 * com
                )
            }
        }
    }

    /// S with S Sᵀ the covariance of the base parameters of `model` about CAD's; `None` when
    /// free.
    #[doc(hidden)]
    pub fn covariance_factor(&self, model: &Model) -> Option<DMatrix<f64>> {
        let own = self.spread(model)?;
        if let Prior::Free | Prior::Cad(_) = self {
            return Some(own);
        }
        // Beside Σ, how far the mean is from CAD.
        let columns = own.ncols();
        let mut wider = own.insert_column(columns, 0.0);
        wider.set_column(
            columns,
            &(self.centre(model) - DVector::from_vec(model.cad_params())),
        );
        Some(wider)
    }

    /// What the base parameters are before data: CAD's, or the mean of a fleet.
    pub(crate) fn centre(&self, model: &Model) -> DVector<f64> {
        match self {
            Prior::Free | Prior::Cad(_) => DVector::from_vec(model.cad_params()),
            Prior::Population(found) | Prior::Fitted(found) => found.centre.clone(),
        }
    }

    /// Tolerances of the masses of links: CAD's usual ones where it says nothing of links.
    pub(crate) fn tolerances(&self) -> Tolerances {
        match self {
            Prior::Cad(tolerances) => tolerances.clone(),
            Prior::Free | Prior::Population(_) | Prior::Fitted(_) => Tolerances::usual(),
        }
    }

    /// The robot that is expected: as in CAD, or as an earlier fit found it.
    pub(crate) fn expected(&self, model: Model) -> Model {
        match self {
            Prior::Fitted(found) => model.with_nominal(found.centre.as_slice()),
            _ => model,
        }
    }

    /// The same prior of the robot on the support of `to`, where it is of the one of `from`.
    pub(crate) fn seen_from(&self, from: &Model, to: &Model) -> Prior {
        let mut own = self.clone();
        if let Prior::Fitted(found) = &mut own
            && from.support() != to.support()
        {
            let shift = to.params_from(from);
            found.centre = &shift.matrix * &found.centre + &shift.offset;
            found.factor = &shift.matrix * &found.factor;
        }
        own
    }

    /// # Errors
    /// Where it was fitted to a log of this hash: it would count twice.
    pub(crate) fn check_other(&self, log: &str, hash: &str) -> Result<(), Error> {
        match self {
            Prior::Fitted(found) if found.logs.iter().any(|own| own == hash) => {
                let message = format!(
                    "the masses of {} were fitted to this very log, which would count twice; give \
                     a log of the healthy robot",
                    found.source
                );
                Err(Error::log(log, None, message))
            }
            _ => Ok(()),
        }
    }

    /// S with S Sᵀ the covariance of the base parameters about [`Prior::centre`].
    pub(crate) fn spread(&self, model: &Model) -> Option<DMatrix<f64>> {
        match self {
            Prior::Free => None,
            Prior::Cad(tolerances) => Some(tolerances.factor(model)),
            Prior::Population(found) | Prior::Fitted(found) => Some(found.factor.clone()),
        }
    }
}

/// Tolerances of a TOML file.
fn read_tolerances(text: &str, file: &str, model: &Model) -> Result<Tolerances, Error> {
    let bad = |reason: String| Error::prior(file, reason);
    let tolerances: Tolerances =
        files::parse_toml(text, FORMAT).map_err(|fault| Error::prior_toml(file, fault))?;
    let names = || model.tree.links.iter().map(|link| link.name.as_str());
    if let Some(stray) = tolerances
        .links
        .keys()
        .find(|k| names().all(|name| name != *k))
    {
        let meant = suggestion(stray, names());
        return Err(bad(format!(
            "no link `{}`; the robot has {}{meant}",
            short(stray),
            listed(names().map(short), 12)
        )));
    }
    let all = tolerances.links.iter().map(|(name, t)| (name.as_str(), t));
    for (name, t) in all.chain([("default", &tolerances.default)]) {
        for value in [t.mass, t.com, t.mass_kg].into_iter().flatten() {
            if !(value.is_finite() && value >= 0.0) {
                return Err(bad(format!(
                    "`{name}`: a tolerance of {value:?}; zero or more"
                )));
            }
        }
    }
    Ok(tolerances)
}
