//! Columns of the CoP that show nothing, or readings of other postures than those they stand
//! beside.

use super::criteria::{
    ALIKE, CONSTANT_M, ENOUGH, EXCHANGED, MOVES_M, MUST_MOVE, SHUFFLED_MOVES, SILENT_ROWS,
};
use super::statistics::{axis, correlation, mean, rms_of, scatter};
use super::wirings::Wirings;
use super::{Finding, Kind, Look};
use crate::observations::noise::NoiseSource;
use crate::observations::postures::{Postures, rms};

/// Axes of the sensor that do not move where CAD moves them, whatever the wiring.
pub(super) fn dead_axes(look: &Look, wirings: &Wirings) -> Option<Finding> {
    let dead: Vec<usize> = (0..2).filter(|&k| is_dead(look, wirings, k)).collect();
    let millimetres = |k: usize| 1e3 * scatter(&axis(&look.predicted, k));
    let name = |k: usize| ["x", "y"][k];
    match dead[..] {
        [] => None,
        [k] => {
            let sentence = format!(
                "cop_{} does not move with the robot, where CAD moves it by {:.1} mm RMS: check \
                 the sensor's wiring and the column.",
                name(k),
                millimetres(k)
            );
            let finding = Finding::new(Kind::CopAxisDead, name(k), sentence);
            Some(finding.showing(look.beside_cad(k)))
        }
        _ => {
            let sentence = format!(
                "The CoP does not move with the robot, where CAD moves it by {:.1} mm RMS: check \
                 that the sensor is on and that its topic is the right one.",
                rms([millimetres(0), millimetres(1)].into_iter())
            );
            // The axis that should move more shows it best.
            let axis = usize::from(millimetres(1) > millimetres(0));
            let finding = Finding::new(Kind::CopConstant, "-", sentence);
            Some(finding.showing(look.beside_cad(axis)))
        }
    }
}

/// Whether an axis does not move at all.
pub(super) fn is_constant(data: &Postures) -> bool {
    (0..2).any(|k| scatter(&axis(&data.reading, k)) < CONSTANT_M)
}

fn is_dead(look: &Look, wirings: &Wirings, k: usize) -> bool {
    let data = look.data;
    if data.len() < 3 {
        return false;
    }
    let [read, other] = [k, 1 - k].map(|k| axis(&data.reading, k));
    let [cad, across] = [k, 1 - k].map(|k| axis(&look.predicted, k));
    let moves = scatter(&read);
    let constant = moves < CONSTANT_M;
    let least = match constant {
        true => MOVES_M,
        false => MUST_MOVE * moves,
    };
    if scatter(&cad) <= least || !constant && data.len() < SILENT_ROWS {
        return false;
    }
    // Where the axes are exchanged, this one shows what CAD says of the other.
    let [own, exchanged] = [&across, &cad].map(|cad| correlation(&other, cad).abs());
    let exchanged = exchanged > EXCHANGED && exchanged > own;
    !exchanged && wirings.least_scatter(k) > least && (constant || !wirings.relates(k))
}

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
