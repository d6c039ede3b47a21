//! How well CAD knows the masses of links.
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

use nalgebra::{DMatrix, DVector, Matrix4, Vector4};
use serde::{Deserialize, Serialize};
use sesc_model::Model;
use sesc_model::standard::PER_LINK;

use crate::svd::svd;

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

/// CAD taken nearly for granted: parts on a scale, masses to 0.2 %, CoMs to 0.1 mm.
const TIGHT: (f64, f64) = (0.002, 0.0001);
/// CAD as it usually is: masses to 10 %, CoMs to 5 mm.
const USUAL: (f64, f64) = (0.10, 0.005);

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

    /// CAD taken nearly for granted.
    pub(crate) fn tight() -> Tolerances {
        Tolerances::of(TIGHT)
    }

    /// The usual tolerances of CAD.
    pub fn usual() -> Tolerances {
        Tolerances::of(USUAL)
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

    /// Deviation of the robot's total mass, as a part of it: links are off each by itself.
    pub(crate) fn of_total(&self, model: &Model) -> f64 {
        let links = model.tree.links.iter();
        let off = links.map(|link| {
            (self.of_link(&link.name).0 * link.mass).hypot(self.extra_mass(&link.name))
        });
        off.fold(0.0, f64::hypot) / model.tree.mass
    }

    /// Factor of the covariance of θ before `D`, link by link: each is known by itself. Links
    /// that carry no joint to the support, and those whose block is zero, are left out.
    pub(crate) fn of_standard(&self, model: &Model) -> LinkBlocks {
        let links = model.tree.links.iter().enumerate();
        let placed = links.filter(|(k, _)| model.chain.places[*k].is_some());
        let blocks = placed.map(|(k, link)| {
            let (relative, com) = self.of_link(&link.name);
            let share = link.mass / model.tree.mass;
            let extra = self.extra_mass(&link.name) / model.tree.mass;
            let mass = (relative * share).hypot(extra);
            let [x, y, z] = link.com().map(|com| mass * com);
            let com = share * com;
            // A heavier link is heavier where it is: δ(m c) = c δm + m δc.
            let block = Matrix4::new(
                mass, 0.0, 0.0, 0.0, x, com, 0.0, 0.0, y, 0.0, com, 0.0, z, 0.0, 0.0, com,
            );
            (k, block)
        });
        LinkBlocks(blocks.filter(|(_, block)| block.amax() > 0.0).collect())
    }

    /// S with S Sᵀ the covariance of the base parameters of `model` about CAD's.
    pub(crate) fn factor(&self, model: &Model) -> DMatrix<f64> {
        let blocks = self.of_standard(model);
        compact(&blocks.to_base(&model.standard_map(), &model.standard_cad()))
    }
}

/// A factor of the covariance of θ that is zero between links: the four rows and columns of each
/// link that has any.
pub(crate) struct LinkBlocks(pub(crate) BTreeMap<usize, Matrix4<f64>>);

impl LinkBlocks {
    /// Columns that are not zero, each with its link.
    pub(crate) fn columns(&self) -> impl Iterator<Item = (usize, Vector4<f64>)> {
        let columns = self.0.iter().flat_map(|(&link, block)| {
            (0..PER_LINK).map(move |k| (link, block.column(k).into_owned()))
        });
        columns.filter(|(_, column)| column.amax() > 0.0)
    }

    /// W D S: what one deviation of each column does to the base parameters; `map` is W.
    pub(crate) fn to_base(&self, map: &DMatrix<f64>, theta: &DVector<f64>) -> DMatrix<f64> {
        let whole = map * theta;
        let columns: Vec<DVector<f64>> = self
            .columns()
            .map(|(k, column)| {
                // D: a heavier link makes every other one a smaller part of the whole.
                map.columns(PER_LINK * k, PER_LINK) * column - &whole * column[0]
            })
            .collect();
        from_columns(map.nrows(), &columns)
    }
}

/// A factor with as many columns as C has directions.
fn compact(factor: &DMatrix<f64>) -> DMatrix<f64> {
    let svd = svd(factor.clone(), true, false);
    let least = 1e-12 * svd.singular_values.max();
    let u = svd.u.unwrap_or_else(|| DMatrix::zeros(factor.nrows(), 0));
    let axes = u.column_iter().zip(&svd.singular_values);
    let kept = axes.filter(|(_, value)| **value > least);
    let kept: Vec<DVector<f64>> = kept.map(|(axis, value)| axis * *value).collect();
    from_columns(factor.nrows(), &kept)
}

/// A matrix of `rows` rows and of any number of columns.
pub(crate) fn from_columns(rows: usize, columns: &[DVector<f64>]) -> DMatrix<f64> {
    DMatrix::from_iterator(rows, columns.len(), columns.iter().flatten().copied())
}
