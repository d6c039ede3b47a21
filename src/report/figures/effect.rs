//! What an effect does to the CoP, and what its best imitator leaves of that.

use super::super::svg::{BLUE, ORANGE};
use super::arrows::{Arrows, Gap};
use sesc_identify::diagnose::footprint::{Footprint, Telling};

/// Arrows that stay apart.
const MOST: usize = 60;

/// No arrow yet, on a square sole.
fn on_sole(half_m: f64) -> Arrows {
    Arrows {
        gaps: Vec::new(),
        rms: [0.0; 2],
        foot: None,
        sole: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|corner| corner.map(|x| x * half_m))
            .to_vec(),
        cells: Vec::new(),
    }
}

/// Arrows from some places to others, posture by posture, m; some postures are meant.
pub fn moved(
    title: &str,
    [from, to]: [&[[f64; 2]]; 2],
    meant: impl Fn(usize) -> bool,
    sole_m: f64,
) -> String {
    let step = from.len().div_ceil(MOST).max(1);
    let gap = |k: usize| Gap {
        measured: to[k],
        predicted: [from[k]; 2],
        outlier: meant(k),
    };
    let squares = from.iter().zip(to);
    let squares = squares.map(|(a, b)| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2));
    let rms = (squares.sum::<f64>() / from.len().max(1) as f64).sqrt();
    let arrows = Arrows {
        gaps: (0..from.len()).step_by(step).map(gap).collect(),
        rms: [rms; 2],
        ..on_sole(sole_m)
    };
    arrows.draw(0, title, ORANGE)
}

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
        ..on_sole(sole_m)
    };
    [
        arrows.draw(0, "What it does to the CoP", ORANGE),
        arrows.draw(1, "What its best imitator leaves", BLUE),
    ]
}
