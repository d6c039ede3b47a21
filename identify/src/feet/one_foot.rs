//! Whether readings of a two-foot stand are of both feet together.
//!
//! ```text
//! p = (F₁ p₁ + F₂ p₂) / (F₁ + F₂)        seen from the support; it goes with the CoM: slope 1
//! ```
//!
//! The CoP of one foot alone stays under it, however the CoM moves between the two.

use sesc_model::{Function, Model};

use super::criteria::one_foot::{ERRORS, FEWEST, GOES_WITH, MOVES_M};
use super::other::OtherFoot;
use crate::evaluate::Evaluator;
use crate::observations::postures::Postures;

/// A warning where the readings are those of one foot.
pub fn of_one_foot(model: &Model, other: &OtherFoot, data: &Postures) -> Option<String> {
    let remedy = format!(
        "on two feet log the CoP of both together, (F₁ p₁ + F₂ p₂) / (F₁ + F₂), in the frame of \
         `{}`",
        model.support()
    );
    if data.raw_cells {
        return Some(format!(
            "the soles of `{}` and `{}` are both on the floor, and foot cells are those of one: {remedy}",
            model.support(),
            other.name
        ));
    }
    let n = data.len();
    let cad = Evaluator::new(model, Function::Cop).run(&data.q, n);
    let centred = |values: &[f64], axis: usize| -> Vec<f64> {
        let own = values.iter().skip(axis).step_by(2);
        let mean = own.clone().sum::<f64>() / n.max(1) as f64;
        own.map(|x| x - mean).collect()
    };
    let square = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
    let axes = [0, 1].map(|axis| (axis, square(&centred(&cad, axis))));
    let (axis, of_cad) = if axes[0].1 > axes[1].1 {
        axes[0]
    } else {
        axes[1]
    };
    if n < FEWEST || of_cad < n as f64 * MOVES_M * MOVES_M {
        return None;
    }
    let (x, y) = (centred(&cad, axis), centred(&data.reading, axis));
    let slope = x.iter().zip(&y).map(|(x, y)| x * y).sum::<f64>() / of_cad;
    let left = square(&y) - slope * slope * of_cad;
    let error = (left.max(0.0) / (n - 2) as f64 / of_cad).sqrt();
    (slope + ERRORS * error < GOES_WITH).then(|| {
        format!(
            "readings move {slope:.2} times as far as the CoM does between the soles of `{}` and \
             `{}`, like those of one foot: {remedy}",
            model.support(),
            other.name
        )
    })
}
