//! Columns of the CoP that show nothing.

use super::criteria::{CONSTANT_M, EXCHANGED, MOVES_M, MUST_MOVE, SILENT_ROWS};
use super::statistics::{axis, correlation, scatter};
use super::wirings::Wirings;
use super::{Finding, Kind, Look};
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
