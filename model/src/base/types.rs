//! What a grouping of parameters consists of.

use std::collections::BTreeMap;

/// Which column of the regressor a base parameter multiplies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Column {
    /// Canonical axis `axis` of body `body` in the support frame.
    Axis { body: usize, axis: usize },
    /// `B_parent a q` of the sliding body.
    Slide { body: usize },
}

/// One base parameter: a linear combination of full parameters.
#[derive(Debug, Clone)]
pub struct BaseParam {
    pub name: String,
    pub column: Column,
    /// Full parameter → weight; the parameter is their weighted sum.
    pub terms: BTreeMap<usize, f64>,
    /// CAD value, m (or a mass fraction for a slide).
    pub cad: f64,
}

/// A direction in parameter space that leaves the measurement unchanged.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Unobservable {
    pub name: String,
    pub sentence: String,
    /// Seen from three-dimensional CoM data at least.
    #[serde(skip)]
    pub only_from_cop: bool,
}

/// Base parameters, in preorder of bodies.
#[derive(Debug, Clone)]
pub struct Base {
    pub params: Vec<BaseParam>,
    pub unobservable: Vec<Unobservable>,
    /// Rank of stacked CoP rows (x and y), by structure.
    pub rank_cop: usize,
    /// What regrouping columns that are dependent up to rounding moves the CoM, m.
    pub regrouping_error: f64,
}

/// Adds `weight` times a linear form.
pub(super) fn add(sum: &mut BTreeMap<usize, f64>, terms: &BTreeMap<usize, f64>, weight: f64) {
    if weight == 0.0 {
        return;
    }
    for (&k, w) in terms {
        *sum.entry(k).or_insert(0.0) += w * weight;
    }
}
