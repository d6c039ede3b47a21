//! Readings of other postures than those they stand beside.

use super::criteria::{ALIKE, ENOUGH, SHUFFLED_MOVES};
use super::statistics::{axis, mean, rms_of, scatter};
use super::wirings::Wirings;
use super::{Finding, Kind, Look};
use crate::observations::noise::NoiseSource;

/// Readings that scatter as CAD says and go with no posture, whatever the wiring.
pub(super) fn shuffled(look: &Look, wirings: &Wirings) -> Option<Finding> {
    let data = look.data;
    let as_cad = (0..2).all(|k| {
        let (read, cad) = (axis(&data.reading, k), axis(&look.predicted, k));
        let ratio = scatter_of_rows(look, k, scatter(&read)) / scatter(&cad);
        let near = (mean(&read) - mean(&cad)).abs() < scatter(&cad);
        let moves = scatter(&cad) > SHUFFLED_MOVES * rms_of(&look.std, k);
        (ALIKE.0..ALIKE.1).contains(&ratio) && near && moves
    });
    let broken = data.len() >= ENOUGH && as_cad && !wirings.relate();
    broken.then(|| {
        Finding::new(
            Kind::RowsShuffled,
            "-",
            "Readings scatter as CAD says and go with no posture: rows of the CoP and of the \
             joints do not belong together; check how they were joined."
                .to_string(),
        )
        .showing(look.beside_cad(0))
    })
}

/// Scatter of single readings: where postures were repeated, shuffled rows scatter within a
/// posture, and their means hardly.
fn scatter_of_rows(look: &Look, k: usize, of_means: f64) -> f64 {
    let data = look.data;
    let within = match data.noise_source {
        NoiseSource::Repeats => data.rows_per_posture.sqrt() * rms_of(&look.std, k),
        _ => 0.0,
    };
    of_means.hypot(within)
}
