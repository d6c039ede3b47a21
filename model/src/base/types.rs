//! What a grouping of parameters consists of.

/// A linear form: full parameters in ascending order, each with its weight.
pub(super) type Form = Vec<(usize, f64)>;

/// Which column of the regressor a base parameter multiplies.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Column {
    /// Canonical axis `axis` of body `body` in the support frame.
    Axis {
        /// Index in the chain.
        body: usize,
        /// 0, 1 or 2.
        axis: usize,
    },
    /// `B_parent a q` of a body on a prismatic joint.
    Prismatic {
        /// Index in the chain.
        body: usize,
    },
}

/// One base parameter: a linear combination of full parameters.
#[derive(Debug, Clone)]
pub struct BaseParam {
    /// Body and axis: `l_knee.x`.
    pub name: String,
    /// What it multiplies.
    #[doc(hidden)]
    pub column: Column,
    /// Full parameters in ascending order with their weights; the parameter is their weighted sum.
    #[doc(hidden)]
    pub terms: Vec<(usize, f64)>,
    /// CAD value, m (or a mass fraction for a prismatic joint).
    pub cad: f64,
    /// What the CAD value is rounded of, m: it is right to as many ulps of 1 m.
    #[doc(hidden)]
    pub ulps_of: f64,
}

/// A direction in parameter space that leaves the measurement unchanged.
#[derive(Debug, Clone, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Unobservable {
    /// In a few words.
    pub name: String,
    /// Where it went.
    pub sentence: String,
    /// Seen from three-dimensional CoM data at least.
    #[serde(skip)]
    pub only_from_cop: bool,
}

/// Base parameters, in preorder of bodies.
#[derive(Debug, Clone)]
pub struct Base {
    /// What data can determine.
    pub params: Vec<BaseParam>,
    /// What they cannot.
    pub unobservable: Vec<Unobservable>,
    /// Rank of stacked CoP rows (x and y), by structure.
    pub rank_cop: usize,
    /// What regrouping columns that are dependent up to rounding moves the CoM, m.
    #[doc(hidden)]
    pub regrouping_error: f64,
}

/// Adds `weight` times a linear form.
pub(super) fn add(sum: &mut Form, terms: &[(usize, f64)], weight: f64) {
    if weight == 0.0 || terms.is_empty() {
        return;
    }
    let mut merged = Vec::with_capacity(sum.len().max(terms.len()));
    let mut own = std::mem::take(sum).into_iter().peekable();
    for &(k, w) in terms {
        while let Some(before) = own.next_if(|(other, _)| *other < k) {
            merged.push(before);
        }
        let there = own.next_if(|(other, _)| *other == k);
        merged.push((k, there.map_or(0.0, |(_, w)| w) + w * weight));
    }
    merged.extend(own);
    *sum = merged;
}
