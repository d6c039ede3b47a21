//! Derivatives of the reading in each unknown, against central differences.

use sesc_model::effects::{self, Catalog};

use super::robots::{Stand, run};

/// Every effect at every target; springs and dead bands included.
#[test]
fn slopes_are_differences() {
    for stand in Stand::all() {
        let context = stand.context();
        let layout = stand.posture_context();
        let mut posture_context: Vec<f64> = (0..layout.len())
            .map(|k| 0.3 * (1.7 * k as f64 + 0.4).sin())
            .collect();
        for axis in 0..2 {
            posture_context[layout.tilt(axis)] *= 0.1;
        }
        let q = stand.postures(1, 0.4, 23).remove(0);
        for instance in effects::instances(&context) {
            let scales = instance.scales(&context);
            if scales.is_empty() {
                continue;
            }
            let starts = instance.effect.starts(&context, &instance.target);
            let start = &starts[starts.len() / 2];
            // Some way off the start, where the unknowns interact.
            let off = start.iter().zip(&scales);
            let unknowns: Vec<f64> = off.map(|(start, scale)| start + 0.37 * scale).collect();
            let program = stand.reading(std::slice::from_ref(&instance), &stand.model.cad_params());
            let at = |e: &[f64]| run(&program, &[&q, e, &posture_context]);
            let (out, width) = (at(&unknowns), scales.len() + 1);
            for (k, scale) in scales.iter().enumerate() {
                // Larger than the steps that a clamp's and a power's slopes are taken by.
                let h = 1e-4 * scale;
                let moved = |by: f64| {
                    let mut e = unknowns.clone();
                    e[k] += by;
                    at(&e)
                };
                let (ahead, behind) = (moved(h), moved(-h));
                for axis in 0..2 {
                    let slope = out[axis * width + 1 + k];
                    let row = axis * width;
                    let expected = (ahead[row] - behind[row]) / (2.0 * h);
                    let size = stand.model.reach() / scale;
                    let allowed = 1e-8 * size + 1e-6 * expected.abs();
                    let label = instance.label(&context);
                    let is_near = (slope - expected).abs() < allowed;
                    assert!(is_near, "{} {label}: {slope} for {expected}", stand.name);
                }
            }
        }
        for effect in Catalog::standard().iter() {
            let name = effect.id().name();
            assert!(!effect.targets(&context).is_empty(), "{name}");
        }
    }
}
