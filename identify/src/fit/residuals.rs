//! Some of the readings beside what CAD and the fit predict, for figures.
//!
//! A last pass over the logs keeps [`MOST`] rows, each row of the logs with the same
//! chance (reservoir sampling, algorithm R), so that memory does not grow with them.

use nalgebra::DVector;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::identification::Identification;
use super::logs::Logs;
use crate::Error;
use crate::logs::BLOCK;
use crate::watch::{Watch, tell};

/// Rows kept.
pub const MOST: usize = 2000;

/// A reading and its predictions, m, on the sole it was taken on.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Residual {
    /// Its number in the log.
    pub pose: i64,
    /// Link it stood on; empty for the one support of a log.
    pub support: String,
    /// CoP that was read, m.
    pub measured: [f64; 2],
    /// CoP predicted by CAD, m.
    pub cad: [f64; 2],
    /// CoP predicted by the fit, m.
    pub fitted: [f64; 2],
    /// The posture, rad or m.
    #[serde(skip)]
    pub q: Vec<f64>,
}

/// Some of the readings, and what all of them ask of the joints.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sample {
    /// Readings beside their predictions, in the order of the logs.
    pub rows: Vec<Residual>,
    /// Least and largest position of every joint over all rows, rad or m.
    pub used: Vec<[f64; 2]>,
}

/// RMS lengths of what CAD and the fit leave, m.
#[doc(hidden)]
pub fn rms_lengths(rows: &[Residual]) -> [f64; 2] {
    let rms = |predicted: fn(&Residual) -> [f64; 2]| {
        let off = |row: &Residual, axis: usize| predicted(row)[axis] - row.measured[axis];
        let squares = rows
            .iter()
            .map(|row| off(row, 0).powi(2) + off(row, 1).powi(2));
        (squares.sum::<f64>() / rows.len().max(1) as f64).sqrt()
    };
    [rms(|row| row.cad), rms(|row| row.fitted)]
}

/// Residuals of rows of all logs, in their order.
///
/// # Errors
/// When a log cannot be read again.
pub(super) fn sample(
    logs: &Logs<'_>,
    found: &Identification,
    watch: &mut dyn Watch,
) -> Result<Sample, Error> {
    let mut measurement = logs.measurement()?;
    let cad = DVector::from_vec(measurement.model().cad_params());
    let params = &found.params_of_readings;
    let mut kept: Vec<(usize, Residual)> = Vec::new();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut seen = 0;
    let dof = measurement.model().dof();
    let mut used = vec![[f64::INFINITY, f64::NEG_INFINITY]; dof];
    for logged in logs.moving() {
        let (_, mut reader) = logged?;
        loop {
            let (block, motion) = reader.known_rows(BLOCK)?;
            if block.is_empty() {
                break;
            }
            let (done, total) = reader.log.progress();
            tell(watch, "residuals", done, total)?;
            let Some(readings) = &block.reading else {
                break;
            };
            for (k, q) in block.q.iter().enumerate() {
                let [low, high] = &mut used[k % dof];
                (*low, *high) = (low.min(*q), high.max(*q));
            }
            let rows = measurement.moving_rows(&block, motion.as_ref())?;
            let by_cad = rows.residual(&cad);
            let by_fit = rows.residual(params);
            for (k, &measured) in readings.iter().enumerate() {
                let place = match kept.len() < MOST {
                    true => kept.len(),
                    false => rng.random_range(0..=seen),
                };
                seen += 1;
                if place >= MOST {
                    continue;
                }
                let without =
                    |rest: &DVector<f64>| [0, 1].map(|axis| measured[axis] - rest[2 * k + axis]);
                let support = block.support.as_ref().map_or("", |all| &all[k]);
                let residual = Residual {
                    pose: block.pose[k],
                    support: support.to_string(),
                    measured,
                    cad: without(&by_cad),
                    fitted: without(&by_fit),
                    q: block.q[k * dof..(k + 1) * dof].to_vec(),
                };
                match place == kept.len() {
                    true => kept.push((seen, residual)),
                    false => kept[place] = (seen, residual),
                }
            }
        }
    }
    kept.sort_by_key(|(order, _)| *order);
    Ok(Sample {
        rows: kept.into_iter().map(|(_, residual)| residual).collect(),
        used,
    })
}
