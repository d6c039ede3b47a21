//! Whether readings are compared with the ZMP, and how much of it they show.
//!
//! ```text
//! y = Y r + a Δ + noise        Δ = ZMP − static CoP by CAD, a: the share, 1 where all is known
//! ```
//!
//! Noise of accelerations makes least squares see less of Δ than there is. Δ by smooth motion, z,
//! has the same motion and hardly that noise: it is the instrumental variable (Söderström & Stoica,
//! System Identification, 1989, 8), `a = zᵀS y / zᵀS Δ` beside what else is free.
//!
//! Readings hold Δ by the laws of mechanics, whether noise lets it be seen or not. Those of a
//! log that was averaged in standing postures, or simulated so, hold none though its joints
//! move: readings are static where a = 0 is more likely than a = 1 by far,
//! `2 log L = ((1 − a)² − a²)/σ_a²`.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use sesc_model::MotionCounted;

use super::correlation;
use super::criteria::CERTAIN;
use super::criteria::accelerations::LONGEST_S;
use super::criteria::motion::{CLEARLY, SURE, TOLD};
use super::noise::LEAST_STD;

/// Whether the motion of the joints counts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum MotionModel {
    /// Readings are compared with the ZMP where a log knows accelerations.
    #[default]
    Auto,
    /// Readings are taken as those of standing postures.
    Off,
}

/// A share with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Share {
    /// 1 if motion is fully there.
    pub value: f64,
    /// Standard deviation.
    pub std: f64,
}

impl Share {
    /// Whether readings are without the motion: none of it is far more likely than all.
    pub fn is_missing(&self) -> bool {
        1.0 - 2.0 * self.value > SURE * self.std * self.std
    }

    fn is_another(&self) -> bool {
        let off = (self.value - 1.0).abs();
        off > CERTAIN * self.std && off > CLEARLY
    }

    /// The share in whitened readings, of which `residual` is left where all of `shift` is taken;
    /// `instrument` is the shift by smooth motion, `beside` columns that are free, and `left` what is
    /// left of vectors beside masses; `rows_per_sample` rows are worth one. `None` where readings do
    /// not tell.
    pub(crate) fn of(
        [shift, instrument]: [Vec<f64>; 2],
        beside: &DMatrix<f64>,
        residual: &DVector<f64>,
        left: impl Fn(&DMatrix<f64>) -> DMatrix<f64>,
        rows_per_sample: f64,
    ) -> Option<Share> {
        let columns = [instrument, shift, residual.as_slice().to_vec()];
        let mut columns = DMatrix::from_columns(&columns.map(DVector::from_vec));
        let scale = beside
            .column_iter()
            .map(|own| own.norm().max(f64::MIN_POSITIVE));
        let mut beside = beside.clone();
        beside
            .column_iter_mut()
            .zip(scale)
            .for_each(|(mut own, scale)| own /= scale);
        let inner = left(&beside);
        let mut normal = beside.tr_mul(&inner);
        // Directions without information stay where they are.
        (0..normal.nrows()).for_each(|k| normal[(k, k)] += 1e-9);
        columns -= &beside * normal.cholesky()?.solve(&inner.tr_mul(&columns));
        let products = columns.tr_mul(&left(&columns));
        let both = products[(0, 1)];
        let missing = products[(0, 2)] / both;
        let square =
            products[(2, 2)] - missing * (2.0 * products[(1, 2)] - missing * products[(1, 1)]);
        let unknowns = 1.0 + beside.ncols() as f64;
        let spare = (residual.len() as f64 / rows_per_sample - unknowns).max(1.0);
        // What is left says how well readings are known, whatever their noise was said to be.
        let noise = (square / rows_per_sample / spare).max(1.0) * rows_per_sample;
        let share = Share {
            value: 1.0 + missing,
            std: (noise * products[(0, 0)]).sqrt() / both.abs(),
        };
        (share.value.is_finite() && share.std < TOLD).then_some(share)
    }
}

/// What motion adds to readings, beside what masses do.
pub(crate) struct Column {
    /// Shift of the readings that CAD predicts, x and y in turn, m or over deviations.
    pub shift: Vec<f64>,
    /// The same by smooth motion.
    pub smooth: Vec<f64>,
    /// Readings less those of CAD in motion, likewise.
    pub residual: DVector<f64>,
    /// Rows of the base parameters, and of what else may be off, likewise.
    pub rows: DMatrix<f64>,
    /// How many of these are of the base parameters, the first ones.
    pub masses: usize,
}

impl Column {
    /// The share of it in readings, with constants of both axes and what `rows` are of within
    /// `unsure` (F, p × m); `rows_per_sample` rows are worth one.
    pub(crate) fn share(&self, unsure: &DMatrix<f64>, rows_per_sample: f64) -> Option<Share> {
        let n = self.residual.len();
        let constants = DMatrix::from_fn(n, 2, |row, axis| f64::from(u8::from(axis == row % 2)));
        let free = DMatrix::from_fn(n, self.masses + 3, |r, c| match c {
            0 => self.shift[r],
            c if c < 3 => constants[(r, c - 1)],
            c => self.rows[(r, c - 3)],
        });
        let (square, _) = correlation::left(&free, &self.residual);
        let whole = self.residual.norm_squared() / n as f64;
        let square = if square.is_nan() { whole } else { square };
        let noise = square.sqrt().max(LEAST_STD);
        let k = &self.rows * unsure / noise;
        let inner = k.tr_mul(&k) + DMatrix::identity(k.ncols(), k.ncols());
        let inner = inner.cholesky()?;
        let left = |x: &DMatrix<f64>| x - &k * inner.solve(&k.tr_mul(x));
        let residual = &self.residual / noise;
        let shifts = [&self.shift, &self.smooth].map(|all| all.iter().map(|x| x / noise).collect());
        Share::of(shifts, &constants, &residual, left, rows_per_sample)
    }
}

/// How motion was taken into account.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MotionUse {
    /// Whether readings follow the ZMP.
    pub used: bool,
    /// Share of motion terms that is there; none where joints stand or readings do not tell.
    pub share: Option<Share>,
    /// RMS of the motion terms, m.
    pub rms_m: f64,
    /// Rows without known accelerations.
    pub rows_left_out: u64,
    /// Between rows, s; none of logs without times in order.
    pub step_s: Option<f64>,
    /// Whether joints move faster than the rows show.
    pub too_fast: bool,
    /// The same in a sentence; empty of a log without times, or whose joints stand.
    pub sentence: String,
}

impl MotionUse {
    /// How a model file says it; none where nothing moved.
    pub(crate) fn counted(&self) -> Option<MotionCounted> {
        match (self.used, self.share) {
            (true, _) => Some(MotionCounted::Zmp),
            (false, Some(_)) => Some(MotionCounted::Static),
            (false, None) => None,
        }
    }

    /// With its sentence.
    pub fn told(mut self) -> MotionUse {
        self.sentence = match (self.used, self.share, self.step_s) {
            (true, share, _) => self.of_motion(share),
            (false, Some(share), _) => format!(
                "Motion of the joints should add {:.2} mm to the readings, which show {:.2} ± \
                 {:.2} of it: they are taken as those of standing postures.",
                1e3 * self.rms_m,
                share.value,
                share.std
            ),
            // With two digits.
            (false, _, Some(step)) if step > LONGEST_S => format!(
                "Rows are {step:.*} s apart, too far to know accelerations: readings are taken as \
                 those of standing postures.",
                usize::from(step < 10.0)
            ),
            _ => String::new(),
        };
        if self.used && self.too_fast {
            self.sentence += " Joints move faster than the rows show, so that accelerations are known \
                              in part: record more rows a second, 8 to a swing, or slower motions.";
        }
        self
    }

    /// With its sentence, where the masses that were found are far from those of the URDF.
    pub fn told_of_a_load(self) -> MotionUse {
        let mut told = self.told();
        if told.used {
            told.sentence += " The masses found are not those of the URDF, and are accelerated \
                              by what is linear in them, without an inertia of their own: what a \
                              payload adds in motion is missed in part. Fit standing postures, \
                              or diagnose the log.";
        }
        told
    }

    fn of_motion(&self, share: Option<Share>) -> String {
        let shown = match share {
            Some(share) if share.is_another() => format!(
                ", of which they show {:.2} ± {:.2}: they are filtered or late, or inertias are \
                 others",
                share.value, share.std
            ),
            Some(Share { value, std }) => format!(" (they show {value:.2} ± {std:.2} of it)"),
            None => String::new(),
        };
        let rest = match self.rows_left_out {
            0 => String::new(),
            1 => " 1 row does not know its accelerations and is left out.".to_string(),
            n => format!(" {n} rows do not know their accelerations and are left out."),
        };
        format!(
            "Readings are compared with the ZMP, inertias from the URDF: motion adds {:.2} mm RMS \
             to them{shown}.{rest}",
            1e3 * self.rms_m
        )
    }

    /// Add what was found of another log.
    pub fn merge(&mut self, other: &MotionUse) {
        let weight =
            |share: &Option<Share>| share.map_or(0.0, |s| 1.0 / (s.std * s.std).max(1e-12));
        let (own, more) = (weight(&self.share), weight(&other.share));
        self.share = match (self.share, other.share) {
            (Some(a), Some(b)) => Some(Share {
                value: (own * a.value + more * b.value) / (own + more),
                std: 1.0 / (own + more).sqrt(),
            }),
            (a, b) => a.or(b),
        };
        self.used |= other.used;
        self.too_fast |= other.too_fast;
        self.rms_m = self.rms_m.max(other.rms_m);
        self.rows_left_out += other.rows_left_out;
        let steps = self.step_s.into_iter().chain(other.step_s);
        self.step_s = steps.reduce(f64::max);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::noise;

    /// Readings that show all of the motion do so whatever noise accelerations have, and those of
    /// standing postures none of it.
    #[test]
    fn noise_of_accelerations_does_not_take_motion_from_readings() {
        let n = 4000;
        for share in [1.0, 0.0] {
            let mut noise = noise(1.0);
            let (mut shift, mut smooth, mut residual) = (Vec::new(), Vec::new(), Vec::new());
            for row in 0..n {
                // As much noise as motion.
                let (truth, error) = ((0.1 * f64::from(row)).sin() * 2e-3, 2e-3 * noise());
                smooth.push(0.9 * truth + 2e-4 * noise());
                shift.push(truth + error);
                residual.push(share * truth - (truth + error) + 1e-3 * noise());
            }
            let column = Column {
                shift,
                smooth,
                residual: DVector::from_vec(residual),
                rows: DMatrix::zeros(n as usize, 1),
                masses: 1,
            };
            let found = column.share(&DMatrix::zeros(1, 1), 1.0).unwrap();
            let off = (found.value - share).abs();
            assert!(
                off < 3.0 * found.std && found.std < 0.1,
                "{share}: {found:?}"
            );
            assert_eq!(found.is_missing(), share == 0.0);
        }
    }
}
