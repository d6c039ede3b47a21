//! The gap against what each effect of the explanation predicts of it.
//!
//! ```text
//! change = h(all effects) − h(all but this one)        gap = rest + change
//! ```
//!
//! `rest` is what the whole explanation leaves, so the gap is what all of it but this effect
//! leaves. Where the effect is right, gap = change but for noise: a line of slope 1.

use super::super::findings::Explained;
use super::super::hypothesis::{Term, with_places};
use super::super::problem::{Fit, Problem};
use super::{Residuals, of_panel};

/// The gap of one axis against one effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Predicted {
    /// The effect and its target in words: `an offset of r_knee`.
    pub subject: String,
    /// 0: x, 1: y.
    pub axis: usize,
    /// Slope of the straight line through the origin that fits the gap best: 1 where the
    /// effect explains all of it; outliers apart. NaN where the effect changes nothing.
    pub slope: f64,
    /// The postures.
    pub points: Vec<PredictedPoint>,
}

/// One posture: what the effect predicts and what was read, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedPoint {
    /// Place of its posture among those of the view.
    pub posture: usize,
    /// Change of the reading that the effect predicts, m.
    pub change: f64,
    /// Gap that all other effects leave, m.
    pub gap: f64,
    /// Whether the posture is an outlier.
    pub outlier: bool,
}

/// Both axes of every effect that changes readings, in the order of the steps.
pub(super) fn predicted(
    problem: &Problem,
    found: &Explained,
    residuals: &Residuals,
) -> Vec<Predicted> {
    let best = &found.best;
    let steps = found
        .told
        .iter()
        .filter_map(|&at| Some((&best.terms[at], change(problem, best, at)?)));
    let both = steps.flat_map(|(term, change)| {
        let subject = term.phrase(&problem.first().context);
        [0, 1].map(|axis| panel(subject.clone(), axis, &change, residuals))
    });
    both.collect()
}

/// Change of every reading by the effect at this place of the explanation, m; none of what
/// changes no reading.
fn change(problem: &Problem, best: &Fit, at: usize) -> Option<Vec<f64>> {
    match &best.terms[at] {
        Term::Effect(_) => {}
        Term::Masses => {
            let shift = problem.mass_shift(best);
            let metres = shift
                .iter()
                .zip(&problem.first().weight)
                .map(|(s, w)| s / w);
            return Some(metres.collect());
        }
        Term::Outliers => return None,
    }
    let context = &problem.first().context;
    let (mut terms, mut unknowns) = (Vec::new(), Vec::new());
    for (k, (term, own)) in with_places(&best.terms, context).enumerate() {
        if k != at {
            terms.push(term.clone());
            unknowns.extend_from_slice(&best.unknowns[own]);
        }
    }
    let posture_context = problem.posture_contexts(Some(best)).swap_remove(0);
    // Values come with their derivatives by the unknowns.
    let readings = |terms: &[Term], unknowns: &[f64]| -> Vec<f64> {
        let out =
            problem
                .first()
                .evaluate(terms, unknowns, &problem.first().data.q, &posture_context);
        out.into_iter().step_by(1 + unknowns.len()).collect()
    };
    let (with, without) = (
        readings(&best.terms, &best.unknowns),
        readings(&terms, &unknowns),
    );
    Some(with.iter().zip(&without).map(|(a, b)| a - b).collect())
}

fn panel(subject: String, axis: usize, change: &[f64], residuals: &Residuals) -> Predicted {
    let n = residuals.outlier.len();
    let gap = |k: usize| residuals.after[2 * k + axis] + change[2 * k + axis];
    let kept = (0..n).filter(|&k| !residuals.outlier[k]);
    let (mut along, mut square) = (0.0, 0.0);
    for k in kept {
        let by = change[2 * k + axis];
        along += by * gap(k);
        square += by * by;
    }
    let points = of_panel(n).map(|(posture, k)| PredictedPoint {
        posture,
        change: change[2 * k + axis],
        gap: gap(k),
        outlier: residuals.outlier[k],
    });
    Predicted {
        subject,
        axis,
        slope: along / square,
        points: points.collect(),
    }
}
