//! CAD as knowledge with stated uncertainty.
//!
//! ```text
//! m_k ~ m_CAD (1 ± mass)      c_k ~ c_CAD ± com on each axis      every link by itself
//! θ = (m_k / M, m_k c_k / M)  r = W θ       C = W D C_θ Dᵀ Wᵀ      D = I − θ 1ᵀ
//! ```
//!
//! `D` keeps mass fractions summing to one: the total mass is no part of a CoP.
//! The covariance C may be singular (massless links); it is kept as a factor S
//! with C = S Sᵀ.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use nalgebra::{DMatrix, DVector, Matrix4};
use serde::{Deserialize, Serialize};
use sesc_model::Model;
use sesc_model::files;
use sesc_model::standard::PER_LINK;
use sesc_model::text::listed;
use sesc_model::urdf::suggestion;

use super::population::{FORMAT, Population};
use crate::logs::names::short;
use crate::svd::svd;
use crate::{Error, Setting, message};

/// How well CAD knows a link.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tolerance {
    /// Standard deviation of its mass, relative.
    pub mass: Option<f64>,
    /// Standard deviation of its CoM on each axis, m.
    pub com: Option<f64>,
    /// Standard deviation of its mass, kg, on top: cables, screws, a link without `<inertial>`.
    pub mass_kg: Option<f64>,
}

/// Tolerances of all links.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Tolerances {
    /// Tolerance of links that are not listed.
    #[serde(default)]
    pub default: Tolerance,
    /// Tolerances of links by name.
    #[serde(default)]
    pub links: BTreeMap<String, Tolerance>,
}

/// What is known before the data.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Prior {
    /// Nothing: data alone; directions they cannot see stay at CAD.
    Free,
    /// CAD within tolerances.
    Cad(Tolerances),
    /// What a fleet of such robots is like.
    Population(Box<Population>),
}

/// CAD taken nearly for granted: parts on a scale, masses to 0.2 %, CoMs to 0.1 mm.
const TIGHT: (f64, f64) = (0.002, 0.0001);
/// CAD as it usually is: masses to 10 %, CoMs to 5 mm.
const USUAL: (f64, f64) = (0.10, 0.005);

/// Which prior, before the robot is known that it is of.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum PriorChoice {
    /// CAD taken nearly for granted: masses to 0.2 %, CoMs to 0.1 mm.
    Tight,
    /// CAD as it usually is: masses to 10 %, CoMs to 5 mm.
    Cad,
    /// Data alone.
    Free,
    /// A file of tolerances or of a [`Population`].
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
            PriorChoice::Tight => Prior::Cad(Tolerances::of(TIGHT)),
            PriorChoice::Cad => Prior::Cad(Tolerances::of(USUAL)),
            PriorChoice::Free => Prior::Free,
            PriorChoice::File(file) => Prior::read(file, model)?,
            PriorChoice::Given(prior) => prior.clone(),
        })
    }
}

impl Default for PriorChoice {
    fn default() -> PriorChoice {
        PriorChoice::from(Prior::DEFAULT)
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

    /// `tight`, `cad`, `free`, or a file of tolerances or of a [`Population`].
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
        match Population::is_in(&text, &file)? {
            true => Population::read(&text, &file, model)
                .map(|found| Prior::Population(Box::new(found))),
            false => Tolerances::read(&text, &file, model).map(Prior::Cad),
        }
    }

    /// In a few words, for reports.
    pub fn sentence(&self) -> String {
        match self {
            Prior::Population(found) => format!(
                "a fleet: mean and covariance of {} robots of this URDF",
                found.robots
            ),
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

    /// S with S Sᵀ the covariance of the base parameters of `model`; `None` when free.
    #[cfg(feature = "nalgebra")]
    pub fn factor(&self, model: &Model) -> Option<DMatrix<f64>> {
        self.covariance_factor(model)
    }

    /// S with S Sᵀ the covariance of the base parameters of `model` about CAD's; `None` when
    /// free.
    pub(crate) fn covariance_factor(&self, model: &Model) -> Option<DMatrix<f64>> {
        match self {
            Prior::Free => None,
            Prior::Cad(tolerances) => Some(tolerances.factor(model)),
            Prior::Population(found) => Some(found.about_cad(&model.cad_params())),
        }
    }

    /// What the base parameters are before data: CAD's, or the mean of a fleet.
    pub(crate) fn centre(&self, model: &Model) -> DVector<f64> {
        match self {
            Prior::Free | Prior::Cad(_) => DVector::from_vec(model.cad_params()),
            Prior::Population(found) => found.centre(),
        }
    }

    /// S with S Sᵀ the covariance of the base parameters about [`Prior::centre`].
    pub(crate) fn spread(&self, model: &Model) -> Option<DMatrix<f64>> {
        match self {
            Prior::Free | Prior::Cad(_) => self.covariance_factor(model),
            Prior::Population(found) => found.factor(),
        }
    }
}

impl Tolerances {
    fn of((mass, com): (f64, f64)) -> Tolerances {
        Tolerances {
            default: Tolerance {
                mass: Some(mass),
                com: Some(com),
                mass_kg: None,
            },
            links: BTreeMap::new(),
        }
    }

    /// The usual tolerances of CAD.
    pub fn usual() -> Tolerances {
        Tolerances::of(USUAL)
    }

    fn read(text: &str, file: &str, model: &Model) -> Result<Tolerances, Error> {
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

    /// Relative mass and CoM (m) of a link.
    pub fn of_link(&self, link: &str) -> (f64, f64) {
        let own = self.links.get(link);
        let mass = own.and_then(|t| t.mass).or(self.default.mass);
        let com = own.and_then(|t| t.com).or(self.default.com);
        (mass.unwrap_or(USUAL.0), com.unwrap_or(USUAL.1))
    }

    /// Mass on top of a link's own tolerance, kg.
    pub fn extra_mass(&self, link: &str) -> f64 {
        let own = self.links.get(link).and_then(|t| t.mass_kg);
        own.or(self.default.mass_kg).unwrap_or(0.0)
    }

    /// Factor of the covariance of θ, 4 per link, before `D`.
    pub(crate) fn of_standard(&self, model: &Model) -> DMatrix<f64> {
        let links = &model.tree.links;
        let mut factor = DMatrix::zeros(PER_LINK * links.len(), PER_LINK * links.len());
        for (k, link) in links.iter().enumerate() {
            if model.chain.places[k].is_none() {
                continue;
            }
            let (relative, com) = self.of_link(&link.name);
            let share = link.mass / model.tree.mass;
            let extra = self.extra_mass(&link.name) / model.tree.mass;
            let mass = (relative * share).hypot(extra);
            // A heavier link is heavier where it is: δ(m c) = c δm + m δc.
            let block = Matrix4::new(
                mass,
                0.0,
                0.0,
                0.0,
                mass * link.com()[0],
                share * com,
                0.0,
                0.0,
                mass * link.com()[1],
                0.0,
                share * com,
                0.0,
                mass * link.com()[2],
                0.0,
                0.0,
                share * com,
            );
            factor
                .fixed_view_mut::<4, 4>(PER_LINK * k, PER_LINK * k)
                .copy_from(&block);
        }
        factor
    }

    fn factor(&self, model: &Model) -> DMatrix<f64> {
        let map = model.standard_map();
        let theta = model.standard_cad();
        let mut of_standard = self.of_standard(model);
        // D: a heavier link makes every other one a smaller part of the whole.
        for mut column in of_standard.column_iter_mut() {
            let heavier: f64 = column.iter().step_by(PER_LINK).sum();
            column.axpy(-heavier, &theta, 1.0);
        }
        compact(&(map * of_standard))
    }
}

/// A factor with as many columns as C has directions.
fn compact(factor: &DMatrix<f64>) -> DMatrix<f64> {
    let svd = svd(factor.clone(), true, false);
    let largest = svd.singular_values.max();
    let kept: Vec<usize> = (0..svd.singular_values.len())
        .filter(|&k| svd.singular_values[k] > 1e-12 * largest)
        .collect();
    let u = svd.u.unwrap_or_else(|| DMatrix::zeros(factor.nrows(), 0));
    let mut compact = DMatrix::zeros(factor.nrows(), kept.len());
    for (to, &from) in kept.iter().enumerate() {
        compact.set_column(to, &(u.column(from) * svd.singular_values[from]));
    }
    compact
}
