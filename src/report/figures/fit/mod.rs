//! Figures of an identification: what was found, rows in, SVG out.

mod bodies;
mod changes;
mod correlation;
#[cfg(test)]
mod tests;

use super::super::svg::{BLUE, INK, MUTED, ORANGE};
use super::arrows::{Arrows, Gap};
use super::bars::{self, Bar};
use sesc_identify::fit::Identification;
use sesc_identify::fit::residuals::{Residual, rms_lengths};

pub use bodies::bodies;
pub use changes::{changes, deviations};
pub use correlation::correlation;

/// Letters of a name that fit beside a plane.
const NAME: usize = 21;
/// Arrows that stay readable.
const MOST: usize = 400;

/// From CAD's error to the fit's to the noise: what was gained and what is left.
pub fn waterfall(found: &Identification) -> String {
    let bars = [
        ("CAD", found.cad_rmse, MUTED),
        ("unseen postures", found.held_out_rmse, BLUE),
        ("fitted postures", found.in_sample_rmse, BLUE),
        ("noise alone", found.noise_floor, INK),
        ("model alone", found.expected_error_data, ORANGE),
    ];
    let bars = bars.map(|(name, length_m, color)| Bar {
        name,
        length_m,
        color,
        pale: false,
    });
    bars::waterfall("RMS error per axis", &bars, found.noise_floor)
}

/// Rows that figures show.
pub fn some(rows: &[Residual]) -> impl Iterator<Item = &Residual> {
    rows.iter().step_by(rows.len().div_ceil(MOST).max(1))
}

/// CAD's residuals, as they stand beside the robot.
pub fn sole_beside(rows: &[Residual]) -> String {
    of_rows(rows).beside_the_robot("CoP on the ground")
}

/// Residuals where they were measured: CAD's and the fit's, at one scale.
pub fn sole(rows: &[Residual]) -> [String; 2] {
    let arrows = of_rows(rows);
    [
        arrows.draw(0, "CAD", MUTED),
        arrows.draw(1, "The fit", BLUE),
    ]
}

fn of_rows(rows: &[Residual]) -> Arrows {
    let gap = |row: &Residual| Gap {
        measured: row.measured,
        predicted: [row.cad, row.fitted],
        outlier: false,
    };
    Arrows {
        gaps: some(rows).map(gap).collect(),
        rms: rms_lengths(rows),
        foot: None,
        sole: Vec::new(),
        cells: Vec::new(),
    }
}
