//! Figures of a diagnosis: rows in, SVG out.
//!
//! Grey is what was measured, orange the simulation with CAD masses, blue the
//! simulation with what was missing; an outlier wears a box.

mod confusion;
mod course;
mod predicted;
mod regions;
mod rest;
mod spread;
#[cfg(test)]
mod tests;
mod trends;

use super::super::svg::{BLUE, MUTED, ORANGE};
use super::arrows::{Arrows, Gap};
use super::bars::{self, Bar};
use sesc_identify::diagnose::view::{DiagnosisView, Posture, Stage, StageKind};

pub use confusion::confusion;
pub use course::course;
pub use predicted::predicted;
pub use regions::regions;
pub use rest::rest;
pub use spread::spread;
pub use trends::trends;

/// Width of a figure that has a row of the page for itself, pixels.
const WIDE: f64 = 980.0;

/// Arrows to the measured CoP from CAD's simulation, and from the corrected one.
pub fn arrows(view: &DiagnosisView) -> [String; 2] {
    let arrows = of_view(view, &[]);
    [
        arrows.draw(0, "Simulated", ORANGE),
        arrows.draw(1, "Corrected", BLUE),
    ]
}

/// The same beside the robot, before the correction; cells that are meant are marked.
pub fn arrows_beside(view: &DiagnosisView, cells: &[usize]) -> String {
    of_view(view, cells).beside_the_robot("CoP on the ground")
}

fn of_view(view: &DiagnosisView, cells: &[usize]) -> Arrows {
    let gap = |row: &Posture| Gap {
        measured: row.measured,
        predicted: [row.simulated, row.corrected],
        outlier: row.outlier,
    };
    let places = view.cells.iter().enumerate();
    Arrows {
        gaps: view.postures.iter().map(gap).collect(),
        rms: view.rms_lengths,
        foot: view.foot,
        sole: view.skeleton.sole.clone(),
        cells: places.map(|(k, at)| (*at, cells.contains(&k))).collect(),
    }
}

/// The held-out error on its way from CAD, effect by effect, to the noise.
pub fn waterfall(stages: &[Stage]) -> String {
    let bars = stages.iter().map(|stage| Bar {
        name: &stage.name,
        length_m: stage.rmse,
        color: match stage.kind {
            StageKind::Cad => ORANGE,
            StageKind::Better => BLUE,
            StageKind::Noise => MUTED,
        },
        pale: stage.kind == StageKind::Better,
    });
    let bars: Vec<Bar<'_>> = bars.collect();
    let noise = stages.iter().find(|s| s.kind == StageKind::Noise);
    let noise = noise.map_or(0.0, |stage| stage.rmse);
    bars::waterfall("RMS error per axis, held out", &bars, noise)
}
