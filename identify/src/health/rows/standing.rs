//! Rows of a log as postures of a robot that stands.
//!
//! ```text
//! y − (ZMP − CoP)        by CAD
//! ```

use sesc_model::Model;

use super::LogRows;
use crate::health::criteria::{MOVED, MOVED_M};
use crate::health::statistics::rms_of_gaps;
use crate::observations::motion::{Motion, Plan, Wanted};
use crate::observations::postures::Postures;
use crate::observations::zmp::Zmp;

/// The `chosen` rows as postures: as they were read, and without what motion adds to their
/// readings.
pub fn postures(rows: &LogRows, chosen: &[usize], model: &Model) -> (Postures, Option<Postures>) {
    let gap = |k: usize, y: [f64; 2]| [0, 1].map(|axis| y[axis] - rows.cad[k][axis]);
    let as_read = rms_of_gaps(chosen.iter().map(|&k| gap(k, rows.reading[k])));
    let least = rows.noise.map_or(MOVED_M, |noise| MOVED * noise);
    let still = match as_read < least {
        // Near enough to CAD.
        true => None,
        false => still(rows, chosen, model),
    };
    let still = still.map(|still| rows.postures_of(&still));
    (rows.postures(chosen), still)
}

/// Those of the `chosen` rows whose motion is known, and their readings without it; none where the
/// robot stands, or the log is not dense enough in time.
pub fn still(rows: &LogRows, chosen: &[usize], model: &Model) -> Option<Vec<(usize, [f64; 2])>> {
    if rows.t.is_empty() || rows.t.len() != rows.len() {
        return None;
    }
    let plan = Plan::of(&rows.t, &rows.q, rows.dof)?;
    let motion = plan.motion((&rows.t, &rows.q, rows.dof), 0..rows.len(), Wanted::Alone)?;
    let known: Vec<usize> = (chosen.iter().copied())
        .filter(|&k| motion.known[k])
        .collect();
    let of = |all: &[f64]| -> Vec<f64> {
        let row = |&k: &usize| all[k * rows.dof..(k + 1) * rows.dof].iter().copied();
        known.iter().flat_map(row).collect()
    };
    let own = Motion {
        rates: of(&motion.rates),
        gains: of(&motion.gains),
        ..Motion::default()
    };
    let level = vec![[0.0; 2]; known.len()];
    let rates = (&own.rates[..], &own.gains[..]);
    let shifts = Zmp::new(model).shifts(&model.cad_params(), &of(&rows.q), rates, &level);
    let without = |(&k, shift): (&usize, [f64; 2])| {
        let y = rows.reading[k];
        (k, [0, 1].map(|axis| y[axis] - shift[axis]))
    };
    let still: Vec<(usize, [f64; 2])> = known.iter().zip(shifts).map(without).collect();
    (!still.is_empty()).then_some(still)
}
