//! What an effect does to the CoP, and what its best imitator leaves of that.

use super::super::svg::{BLUE, ORANGE};
use super::arrows::{Arrows, Gap};
use sesc_identify::diagnose::footprint::{Footprint, Telling};

/// Arrows that stay apart.
const MOST: usize = 60;

/// Two figures of the same scale: arrows from the CoP to the CoP with the effect, and from
/// where imitator and masses put it.
pub fn effect(effect: &Footprint, telling: &Telling, sole_m: f64) -> [String; 2] {
    let step = telling.without.len().div_ceil(MOST).max(1);
    let gap = |k: usize| Gap {
        measured: telling.with[k],
        predicted: [telling.without[k], telling.imitated[k]],
        outlier: false,
    };
    let arrows = Arrows {
        gaps: (0..telling.without.len()).step_by(step).map(gap).collect(),
        rms: [effect.moves_m, telling.left_m],
        foot: None,
        sole: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|corner| corner.map(|x| x * sole_m))
            .to_vec(),
        cells: Vec::new(),
    };
    [
        arrows.draw(0, "What it does to the CoP", ORANGE),
        arrows.draw(1, "What its best imitator leaves", BLUE),
    ]
}
