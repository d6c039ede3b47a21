//! An offset of the reading, compared with none before masses are fitted.
//!
//! ```text
//! y = X r + d + noise        r = r_CAD + S u,  u ~ N(0, 1)        d ~ N(0, σ_o² 1)
//! −2 log p(y) = −‖Qᵀ b‖² + log det(1 + Wᵀ Rᵀ R W / σ²)            W = (S, σ_o E)
//! ```
//!
//! A frame of the foot, the corner of a force plate or the zero of a sensor shift all readings by d.
//! On one foot that is r_0 along x and y, whose columns E of the base parameters move readings one to
//! one: free masses cannot tell them apart. Their priors can: where an offset is by far the likelier
//! cause, it is taken, and CoM x and y rest on CAD's masses of the support.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use sesc_model::base::Column;
use sesc_model::text::minus;
use sesc_model::{EffectRecord, Model, Quantity};

use super::gather::Fold;
use crate::lsq::factor::Factor;
use crate::lsq::solve::{Estimate, with_prior};
use crate::observations::criteria::OVER_NOTHING;
use crate::{Error, Setting, message};

/// Deviations of an offset that are tried, m: a frame that is a little off, and a plate's corner.
/// Chosen: as the offsets of eight recordings, 9 to 51 mm; wider ones cost evidence.
pub(crate) const STD_M: [f64; 2] = [0.003, 0.03];

/// Deviations that are tried where a request asks for one: none where that is zero.
///
/// # Errors
/// One below zero, or above a metre.
pub(crate) fn tried(asked: Option<f64>) -> Result<Vec<f64>, Error> {
    match asked {
        None => Ok(STD_M.to_vec()),
        Some(0.0) => Ok(Vec::new()),
        Some(std) if (1e-6..=1.0).contains(&std) => Ok(vec![std]),
        Some(std) => Err(Error::request(message![
            Setting::Offset,
            format!(" {std:e} m: give how far readings may be shifted, up to a metre; 0 for none")
        ])),
    }
}

/// The offset of all readings.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Offset {
    /// Along x, y of the support frame, m.
    pub value: [f64; 2],
    /// Its standard deviation, m.
    pub std: [f64; 2],
    /// Standard deviation before the data, m.
    pub prior_std: f64,
    /// What it gains over none: −2 log evidence.
    pub evidence: f64,
}

impl Offset {
    /// The sentence that reports print.
    pub fn sentence(&self) -> String {
        let [x, y] =
            [0, 1].map(|k| format!("{:.2} ± {:.2}", 1e3 * self.value[k], 1e3 * self.std[k]));
        minus(&format!(
            "readings are shifted by {x} mm in x and {y} mm in y: a frame of the foot, a force plate \
             or the zero of the sensor; CoM x and y then rest on CAD's masses"
        ))
    }

    /// The effect of a model file.
    pub(super) fn record(&self) -> EffectRecord {
        let quantity = |k: usize| Quantity {
            value: self.value[k],
            std: Some(self.std[k]),
        };
        let names = ["offset_x_m", "offset_y_m"];
        EffectRecord {
            effect: OFFSET.to_string(),
            target: "-".to_string(),
            parameters: [0, 1].map(|k| (names[k].to_string(), quantity(k))).into(),
            ..EffectRecord::default()
        }
    }
}

/// The effect that an offset of readings is.
pub(crate) const OFFSET: &str = "sensor_offset";

/// What is known before data of parameters of readings, r + E d, where an offset is taken.
pub(super) struct Wide {
    /// W: that of masses, then σ_o E.
    pub factor: DMatrix<f64>,
    /// Places of r_0 along x, y among the base parameters.
    places: [usize; 2],
    std: f64,
    evidence: f64,
}

/// Places of r_0 along x, y among the base parameters.
fn places(model: &Model) -> Option<[usize; 2]> {
    let place = |axis| {
        let column = Column::Axis { body: 0, axis };
        let mut params = model.base.params.iter();
        params.position(|param| param.column == column)
    };
    Some([place(0)?, place(1)?])
}

/// Σ of what CAD and the likeliest shift of all readings leave of `rows`.
pub(super) fn left_about(model: &Model, rows: &Factor, cad: &DVector<f64>) -> f64 {
    let all = rows.residual_sum(cad);
    let Some(places) = places(model) else {
        return all;
    };
    let columns = rows.r().select_columns(&places);
    let away = rows.z() - rows.r() * cad;
    let pull = columns.tr_mul(&away);
    let found = columns.tr_mul(&columns).cholesky();
    all - found.map_or(0.0, |factor| pull.dot(&factor.solve(&pull)))
}

impl Wide {
    /// The likeliest of some deviations of an offset, where one is by far likelier than none.
    pub(super) fn chosen(
        model: &Model,
        rows: &Fold,
        sigma: f64,
        centre: &DVector<f64>,
        prior: &DMatrix<f64>,
        tried: &[f64],
    ) -> Option<Wide> {
        let places = places(model)?;
        let evidence = |s: &DMatrix<f64>| with_prior(&rows.weighted, sigma, centre, s).evidence();
        let none = evidence(prior);
        let wide = tried.iter().map(|&std| {
            let m = prior.ncols();
            let mut factor = prior.clone().insert_columns(m, 2, 0.0);
            (0..2).for_each(|axis| factor[(places[axis], m + axis)] = std);
            Wide {
                evidence: none - evidence(&factor),
                factor,
                places,
                std,
            }
        });
        let best = wide.max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
        (best.evidence > OVER_NOTHING).then_some(best)
    }

    /// The parameters of masses alone, with the offset beside them, where `estimate` is of both
    /// together.
    pub(super) fn split(
        &self,
        estimate: &Estimate,
        factor: &Factor,
        sigma: f64,
        centre: &DVector<f64>,
    ) -> (Estimate, Offset) {
        let m = self.factor.ncols() - 2;
        let posterior = with_prior(factor, sigma, centre, &self.factor);
        let of_masses = {
            let mut own = self.factor.clone();
            own.columns_mut(m, 2).fill(0.0);
            own
        };
        let half = posterior.spread(&of_masses);
        let estimate = Estimate {
            params: centre + of_masses * &posterior.mean,
            covariance: &half * half.transpose(),
            ..estimate.clone()
        };
        let mut of_offset = DMatrix::zeros(2, m + 2);
        (0..2).for_each(|axis| of_offset[(axis, m + axis)] = self.std);
        let value = &of_offset * &posterior.mean;
        let half = posterior.spread(&of_offset);
        let offset = Offset {
            value: [value[0], value[1]],
            std: [0, 1].map(|axis| half.row(axis).norm()),
            prior_std: self.std,
            evidence: self.evidence,
        };
        (estimate, offset)
    }

    /// Rows over their deviations with what the offset takes of them: they tell of masses alone.
    ///
    /// ```text
    /// (σ_o R E  R; 1  0) = Q T        T without its first two rows and columns
    /// ```
    pub(super) fn rows_of_masses(&self, rows: &DMatrix<f64>) -> DMatrix<f64> {
        let (n, p) = rows.shape();
        let mut both = DMatrix::zeros(n + 2, p + 2);
        both.view_mut((0, 2), (n, p)).copy_from(rows);
        for (axis, place) in self.places.into_iter().enumerate() {
            both.view_mut((0, axis), (n, 1))
                .copy_from(&(rows.column(place) * self.std));
            both[(n + axis, axis)] = 1.0;
        }
        let triangle = both.qr().r();
        triangle
            .view((2, 2), (triangle.nrows() - 2, p))
            .into_owned()
    }
}
