//! Pictures of what is found beside effects: masses that differ from CAD, readings from elsewhere.
//!
//! ```text
//! y = φ (r_CAD + F z)                    F: factor of the prior `cad`, z one draw
//! y = φ r_CAD + σ e, one in ten ρ σ e        σ: noise of a posture, e a normal pair
//! ```
//!
//! Draws are those of an even sequence, so that pictures are the same everywhere.

use std::f64::consts::TAU;

use nalgebra::DVector;
use sesc_identify::evaluate::Evaluator;
use sesc_identify::fit::prior::PriorChoice;
use sesc_model::Function;

use super::{BOX_M, Bench, NOISE_M};
use crate::report::figures;

/// The golden ratio's part below one: its multiples are even in 0 to 1.
const GOLDEN: f64 = 0.618_033_988_749_895;
/// One posture in so many has a reading from elsewhere, which scatters so many times as much.
const EVERY: usize = 10;
const RATIO: f64 = 12.0;
/// The name of readings from elsewhere, as those of effects.
const OUTLIERS: &str = "cop_outliers";

/// A picture beside a page.
pub struct Picture {
    /// What it shows, in words.
    pub label: &'static str,
    /// SVG.
    pub svg: String,
}

/// The `k`-th pair of an even sequence of normal numbers.
fn normal(k: usize) -> [f64; 2] {
    let part = |factor: f64| ((k as f64 + 0.5) * factor).fract();
    let length = (-2.0 * part(GOLDEN).ln()).sqrt();
    let (sin, cos) = (TAU * part(2.0_f64.sqrt())).sin_cos();
    [length * cos, length * sin]
}

impl Bench {
    /// What is shown of masses or readings of this name.
    pub fn picture(&self, name: &str) -> Picture {
        let n = self.q.len() / self.model.dof();
        let cop = Evaluator::new(&self.model, Function::Cop).run(&self.q, n);
        let pairs = |values: &[f64]| -> Vec<[f64; 2]> {
            values.chunks_exact(2).map(|at| [at[0], at[1]]).collect()
        };
        let cad = pairs(&cop);
        if name == OUTLIERS {
            let elsewhere = |k: usize| k % EVERY == EVERY / 2;
            let read = cad.iter().enumerate().map(|(k, at)| {
                let times = if elsewhere(k) { RATIO } else { 1.0 };
                let by = normal(k).map(|x| times * NOISE_M * x);
                [at[0] + by[0], at[1] + by[1]]
            });
            let read: Vec<[f64; 2]> = read.collect();
            let title = "What readings do";
            return Picture {
                label: "Arrows from the CoP to its reading, seen from above; those from elsewhere \
                        are boxed",
                svg: figures::moved(title, [&cad, &read], elsewhere, BOX_M),
            };
        }
        let with = pairs(&self.with_other_masses(n, &cop));
        Picture {
            label: "Arrows from the CoP by CAD to the CoP of a robot whose masses differ, seen \
                    from above",
            svg: figures::moved("What other masses do", [&cad, &with], |_| false, BOX_M),
        }
    }

    /// CoPs of a robot whose masses are one draw within the usual tolerances of CAD.
    fn with_other_masses(&self, n: usize, cop: &[f64]) -> Vec<f64> {
        let prior = PriorChoice::from("cad").of(&self.model).ok();
        let Some(factor) = prior.and_then(|prior| prior.factor(&self.model)) else {
            return cop.to_vec();
        };
        let z = DVector::from_fn(factor.ncols(), |k, _| normal(k)[0]);
        let by = factor * z;
        let regressor = Evaluator::new(&self.model, Function::RegressorCop).run(&self.q, n);
        let rows = regressor.chunks_exact(by.len());
        let moved = rows.map(|row| row.iter().zip(by.iter()).map(|(f, r)| f * r).sum::<f64>());
        cop.iter().zip(moved).map(|(at, by)| at + by).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sesc_identify::diagnose::MODEL_PAGES;

    #[test]
    fn what_is_no_effect_has_a_picture_too() {
        let bench = Bench::new().unwrap();
        let drawn = MODEL_PAGES.map(|(name, ..)| bench.picture(name).svg);
        assert_ne!(drawn[0], drawn[1]);
        for svg in &drawn {
            assert!(svg.starts_with("<svg ") && !svg.contains("NaN"));
            assert!(svg.matches("data-p=").count() >= 50);
        }
        let boxed = |svg: &str| svg.matches("<rect").count();
        assert!(boxed(&drawn[1]) != boxed(&drawn[0]));
    }

    #[test]
    fn the_sequence_is_normal() {
        let all: Vec<f64> = (0..1000).flat_map(normal).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let square = all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64;
        assert!(
            mean.abs() < 0.02 && (square - 1.0).abs() < 0.02,
            "{mean} {square}"
        );
    }
}
