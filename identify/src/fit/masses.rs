//! From base parameters back to the masses and centres of mass of links.
//!
//! ```text
//! θ = θ_CAD + D S v        r = W θ        v ~ 1: one tolerance of CAD each
//! min ‖v‖²                 W θ = r̂,  m_k ≥ floor,  m_k lo ≤ m_k c_k ≤ m_k hi
//! ```
//!
//! θ are the parts of the whole of [`sesc_model::standard`], S the tolerances of
//! [`super::prior`], D what keeps mass fractions summing to one. Without active
//! inequalities the answer is the mean of θ given the data: what data do not tell
//! stays at CAD.
//!
//! # Fits that only real masses can give
//!
//! ```text
//! min ‖(R W θ − z) / σ‖² + ‖v‖²       under the same bounds
//! ```
//!
//! When the plain fit breaks no bound it is the answer. A free fit has a prior [`WEAK`] times wider
//! than CAD usually is, and only where a bound is active: there it settles what data leave
//! open. Standard deviations stay those of the plain fit: what bounds add is not
//! counted.

use nalgebra::{DMatrix, DVector, Vector4};
use sesc_model::Model;
use sesc_model::standard::PER_LINK;
use sesc_model::text::listed;
use sesc_model::urdf::{self, Extent, Weight};

use super::prior::{Prior, Tolerances};
use crate::lsq::factor::Factor;
use crate::lsq::inequality::{ConstrainedProblem, Linear, NoAnswer};
use crate::robot::Robot;
use crate::svd::svd;
use crate::tolerances::{LinkBlocks, from_columns};

/// Least room of a generous box on each side, m.
const ROOM: f64 = 0.1;
/// Tolerances of a free fit, in units of the usual ones: masses to ten times their
/// own, CoMs to half a metre.
const WEAK: f64 = 100.0;
/// A link keeps at least this part of the mass CAD gives it.
pub(crate) const FLOOR: f64 = 0.01;
/// A link that must get mass though CAD gives it none may weigh this part of the mean link.
const NEW_LINK: f64 = 0.1;
/// Links with a mass whose masses are searched, at most: four unknowns each, and matrices of all
/// by all of them.
const MOST_LINKS: usize = 1000;
/// Where its mass may be about its origin: one standard deviation, m.
const NEW_SPREAD: f64 = 0.05;

/// Masses and first moments of all links around CAD, in units of its tolerances.
pub(crate) struct Space<'m> {
    model: &'m Model,
    cad: DVector<f64>,
    /// D S: 4 per link × unknowns.
    spread: DMatrix<f64>,
    /// W: base parameters × 4 per link.
    map: DMatrix<f64>,
    /// Links that CAD gives no mass and that may get one.
    new: Vec<usize>,
}

/// One bound: `row · θ ≤ right`.
struct Bound {
    row: Vec<(usize, f64)>,
    right: f64,
    name: String,
}

/// Masses that were found.
#[derive(Debug, Clone)]
pub struct Masses {
    /// Parts of the whole of [`sesc_model::standard`].
    pub theta: DVector<f64>,
    /// Bounds that hold them back, by name.
    pub active: Vec<String>,
}

impl<'m> Space<'m> {
    /// Masses of `model` within `tolerances` of CAD.
    ///
    /// # Errors
    /// Why masses of so many links are not searched.
    pub(crate) fn new(model: &'m Model, tolerances: &Tolerances) -> Result<Space<'m>, String> {
        let count = model.tree.links.iter().filter(|l| l.mass > 0.0).count();
        if count > MOST_LINKS {
            return Err(format!(
                "the search for masses takes {MOST_LINKS} links, and {count} have a mass; give \
                 links that are rigid together one mass"
            ));
        }
        Ok(Space::of(model, tolerances.of_standard(model), Vec::new()))
    }

    /// The same where bodies that CAD gives no mass may get one.
    fn with_new_links(model: &'m Model, tolerances: &Tolerances) -> Space<'m> {
        let mut of_standard = tolerances.of_standard(model);
        let mut new = Vec::new();
        let heavy = model.tree.links.iter().filter(|link| link.mass > 0.0);
        let mass = NEW_LINK / heavy.count().max(1) as f64;
        for body in model.chain.bodies.iter().filter(|body| body.mass == 0.0) {
            let own = |k: &&usize| model.tree.links[**k].name == body.name;
            if let Some(&k) = body.links.iter().find(own) {
                let block = of_standard.0.entry(k).or_default();
                let com = mass * NEW_SPREAD;
                block.set_diagonal(&Vector4::new(mass, com, com, com));
                new.push(k);
            }
        }
        Space::of(model, of_standard, new)
    }

    fn of(model: &'m Model, of_standard: LinkBlocks, new: Vec<usize>) -> Space<'m> {
        let cad = model.standard_cad();
        let columns = of_standard.columns().map(|(link, own)| {
            // D: a heavier link makes every other one a smaller part of the whole.
            let mut column = &cad * -own[0];
            let mut rows = column.rows_mut(PER_LINK * link, PER_LINK);
            rows += own;
            column
        });
        let moving: Vec<DVector<f64>> = columns.filter(|column| column.amax() > 0.0).collect();
        Space {
            map: model.standard_map(),
            spread: from_columns(cad.len(), &moving),
            model,
            cad,
            new,
        }
    }

    /// W D S: what the unknowns do to the base parameters.
    pub(crate) fn to_base(&self) -> DMatrix<f64> {
        &self.map * &self.spread
    }

    /// Base parameters of θ.
    pub(crate) fn base(&self, theta: &DVector<f64>) -> DVector<f64> {
        &self.map * theta
    }

    /// Best `v` of ‖data‖² + ‖v‖² under the bounds.
    pub(crate) fn best(
        &self,
        data: Linear,
        equal: Linear,
        limits: &Limits,
    ) -> Result<Masses, NoAnswer> {
        let (rows, n) = data.matrix.shape();
        let mut squares = Linear {
            matrix: data.matrix.insert_rows(rows, n, 0.0),
            right: data.right.insert_rows(rows, n, 0.0),
        };
        squares.matrix.rows_mut(rows, n).fill_with_identity();
        let bounds = self.bounds(limits);
        let mut at_most = Linear {
            matrix: DMatrix::zeros(bounds.len(), n),
            right: DVector::zeros(bounds.len()),
        };
        for (k, bound) in bounds.iter().enumerate() {
            at_most.right[k] = bound.right;
            for &(entry, weight) in &bound.row {
                at_most.right[k] -= weight * self.cad[entry];
                let mut row = at_most.matrix.row_mut(k);
                row += self.spread.row(entry) * weight;
            }
        }
        let answer = ConstrainedProblem {
            squares,
            equal,
            at_most,
        }
        .solve()?;
        Ok(Masses {
            theta: &self.cad + &self.spread * answer.v,
            active: answer
                .active
                .iter()
                .map(|&k| bounds[k].name.clone())
                .collect(),
        })
    }

    /// Masses nearest to CAD that give the base parameters `params`.
    pub(crate) fn nearest(
        &self,
        params: &DVector<f64>,
        limits: &Limits,
    ) -> Result<Masses, NoAnswer> {
        let equal = Linear {
            matrix: self.to_base(),
            right: params - self.base(&self.cad),
        };
        self.best(Linear::none(self.spread.ncols()), equal, limits)
    }

    /// Every bound on a link that tolerances let move.
    fn bounds(&self, limits: &Limits) -> Vec<Bound> {
        let mut bounds = Vec::new();
        for (k, link) in self.model.tree.links.iter().enumerate() {
            let at = PER_LINK * k;
            let new = self.new.contains(&k);
            if self.spread.rows(at, PER_LINK).amax() == 0.0 || (link.mass == 0.0 && !new) {
                continue;
            }
            bounds.push(Bound {
                row: vec![(at, -1.0)],
                right: -FLOOR * self.cad[at],
                name: format!("mass of `{}` at its least", link.name),
            });
            let Some((extent, within)) = limits.extent(k) else {
                continue;
            };
            for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
                for (end, sign, side) in [
                    (extent.low[axis], 1.0, "least"),
                    (extent.high[axis], -1.0, "largest"),
                ] {
                    bounds.push(Bound {
                        row: vec![(at, sign * end), (at + 1 + axis, -sign)],
                        right: 0.0,
                        name: format!("CoM of `{}` at its {side} {name} {within}", link.name),
                    });
                }
            }
        }
        bounds
    }
}

/// Masses nearest to CAD, in units of `tolerances`, that give `params` and keep to
/// `limits` where those are given; masses are never negative.
///
/// # Errors
/// When there are none: with the link that would get a negative mass.
pub(crate) fn nearest(
    model: &Model,
    tolerances: &Tolerances,
    params: &DVector<f64>,
    limits: &Limits,
) -> Result<Masses, String> {
    let space = Space::new(model, tolerances)?;
    let first = space.nearest(params, limits);
    if !matches!(first, Err(NoAnswer::Contradiction)) {
        return first.map_err(|no| space.explain(no, params, limits));
    }
    let wider = Space::with_new_links(model, tolerances);
    wider
        .nearest(params, limits)
        .map_err(|no| wider.explain(no, params, limits))
}

impl Space<'_> {
    fn explain(&self, no: NoAnswer, params: &DVector<f64>, limits: &Limits) -> String {
        match no {
            NoAnswer::Infeasible => self.negative(params, limits),
            NoAnswer::Contradiction => {
                "no masses within the tolerances give them: a link of tolerance zero, or \
                 without mass, would have to change"
                    .to_string()
            }
            NoAnswer::Stuck => "the search for masses did not converge".to_string(),
        }
    }

    /// Which links the nearest answer without bounds makes lighter than nothing, or
    /// carries off.
    fn negative(&self, params: &DVector<f64>, limits: &Limits) -> String {
        let svd = svd(self.to_base(), true, true);
        let limit = 1e-12 * svd.singular_values.max();
        let away = params - self.base(&self.cad);
        let Ok(v) = svd.solve(&away, limit) else {
            return "no masses above zero give them".to_string();
        };
        let theta = &self.cad + &self.spread * v;
        let mut light: Vec<(f64, &str)> = Vec::new();
        let mut far: Vec<(f64, &str)> = Vec::new();
        for (k, link) in self.model.tree.links.iter().enumerate() {
            let share = theta[PER_LINK * k];
            if share < 0.0 {
                light.push((share * self.model.tree.mass, &link.name));
            } else if let Some((extent, _)) = limits.extent(k).filter(|_| share > 0.0) {
                let com = [1, 2, 3].map(|m| theta[PER_LINK * k + m] / share);
                if !extent.holds(com, 0.0) {
                    let distance = com.iter().map(|x| x * x).sum::<f64>().sqrt();
                    far.push((distance, &link.name));
                }
            }
        }
        light.sort_by(|a, b| a.0.total_cmp(&b.0));
        far.sort_by(|a, b| b.0.total_cmp(&a.0));
        let some = |links: &[(f64, &str)], unit: &str| {
            let link = |(x, name): &(f64, &str)| format!("`{name}` {x:.3} {unit}");
            listed(links.iter().map(link), 3)
        };
        if !light.is_empty() {
            let links = some(&light, "kg");
            format!("masses nearest to CAD that give them are negative: {links}")
        } else if !far.is_empty() {
            let links = some(&far, "m from its frame");
            format!("masses nearest to CAD that give them are outside their links: {links}")
        } else {
            "no masses above zero with centres inside the links give them".to_string()
        }
    }
}

impl From<Vec<f64>> for Masses {
    fn from(theta: Vec<f64>) -> Masses {
        Masses {
            theta: theta.into(),
            active: Vec::new(),
        }
    }
}

impl Masses {
    /// Mass and CoM of each link when the robot weighs `total` kg; `None` where a
    /// link weighs nothing, and where no joint but a cut one leads to it.
    pub fn weights(&self, model: &Model, total: f64) -> Vec<Option<Weight>> {
        let links = model.tree.links.iter().enumerate();
        links
            .map(|(k, link)| {
                let share = self.theta[PER_LINK * k];
                let placed = model.chain.places[k].is_some();
                (placed && share > 0.0).then(|| Weight {
                    mass_kg: share * total,
                    com_m: self.com(k, link.com()),
                })
            })
            .collect()
    }

    /// CoM of link `k`; CAD's to the last bit where it moved by rounding alone.
    fn com(&self, k: usize, cad: [f64; 3]) -> [f64; 3] {
        let at = PER_LINK * k;
        [0, 1, 2].map(|axis| {
            let found = self.theta[at + 1 + axis] / self.theta[at];
            let rounding = 8.0 * f64::EPSILON * (cad[axis].abs() + 0.01);
            match (found - cad[axis]).abs() <= rounding {
                true => cad[axis],
                false => found,
            }
        })
    }
}

/// What bounds make of the `plain` fit to `factor` (σ = 1 where rows are weighted), and its masses.
///
/// # Errors
/// When the search does not converge.
pub(crate) fn constrain(
    model: &Model,
    factor: &Factor,
    sigma: f64,
    prior: &Prior,
    limits: &Limits,
    plain: &DVector<f64>,
) -> Result<(DVector<f64>, Masses), String> {
    let free = matches!(prior, Prior::Free);
    let width = if free { WEAK } else { 1.0 };
    let space = Space::new(model, &prior.tolerances())?;
    // No bound is felt when masses of the plain fit keep them all: for a prior, its
    // own most likely ones; without, any.
    if let Ok(mut masses) = space.nearest(plain, limits)
        && (free || masses.active.is_empty())
    {
        masses.active.clear();
        return Ok((plain.clone(), masses));
    }
    let cad = DVector::from_vec(model.cad_params());
    let gain = width / sigma;
    let data = Linear {
        matrix: factor.r() * space.to_base() * gain,
        right: (factor.z() - factor.r() * cad) * gain,
    };
    let none = Linear::none(data.matrix.ncols());
    let masses = space.best(data, none, limits).map_err(|no| match no {
        NoAnswer::Stuck => "the search for physical masses did not converge",
        _ => "no physical masses are within the tolerances",
    })?;
    Ok((space.base(&masses.theta), masses))
}

/// Bounds of physical masses: none far below CAD's, and each CoM inside a box.
///
/// Where the URDF gives no shape of known size, the box is generous: around the link's
/// frame, its joints and CAD's CoM, and on each side as much again (`ROOM` at least).
/// Without it a mass of nothing could sit in the next town.
#[derive(Debug, Clone, Default)]
pub(crate) struct Limits {
    /// Extent of each link in document order, and what it is around, in words.
    boxes: Vec<(Extent, &'static str)>,
}

impl Limits {
    /// Those of the collision geometry of `robot`, generous ones elsewhere.
    ///
    /// # Errors
    /// When its text cannot be read.
    pub(crate) fn of(robot: &Robot) -> Result<Limits, crate::Error> {
        let extents = urdf::extents(&robot.description);
        let extents = extents.map_err(sesc_model::Error::from)?;
        let mut limits = Limits::generous(robot);
        for (k, extent) in extents.into_iter().enumerate() {
            if let (Some(extent), Some(own)) = (extent, limits.boxes.get_mut(k)) {
                // Shapes are simplified: a link's box may leave out CAD's own CoM.
                let com = robot.description.links[k].inertial.origin.xyz;
                *own = (extent.holding(com), "in the collision geometry");
            }
        }
        Ok(limits)
    }

    /// Generous ones for every link.
    pub(crate) fn generous(robot: &Robot) -> Limits {
        let description = &robot.description;
        let boxes = description.links.iter().map(|link| {
            let frame = Extent {
                low: [0.0; 3],
                high: [0.0; 3],
            };
            let mut extent = frame.holding(link.inertial.origin.xyz);
            for joint in description.joints.iter().filter(|j| j.parent == link.name) {
                extent = extent.holding(joint.origin.xyz);
            }
            let sides = [0, 1, 2].map(|axis| extent.high[axis] - extent.low[axis]);
            let room = sides.into_iter().fold(ROOM, f64::max);
            let wide = Extent {
                low: extent.low.map(|x| x - room),
                high: extent.high.map(|x| x + room),
            };
            (wide, "near the joints of the link")
        });
        Limits {
            boxes: boxes.collect(),
        }
    }

    /// Where the CoM of link `k` can be, and what that is around, in words.
    pub(crate) fn extent(&self, k: usize) -> Option<&(Extent, &'static str)> {
        self.boxes.get(k)
    }
}
