//! The gap against what may explain it, posture by posture: what each effect of the explanation
//! predicts of it, and the position and the gravity moment of a joint, averaged in bins.
//!
//! ```text
//! change = h(all effects) − h(all but this one)        gap = rest + change
//! share = 1 − Σ_bins Σ (e − ē_bin)² / Σ (e − ē)² · (n − 1)/(n − bins)
//! ```
//!
//! `rest` is what the whole explanation leaves, so the gap is what all of it but this effect
//! leaves. Where the effect is right, gap = change but for noise: a line of slope 1.

use super::super::findings::{ActsOn, Explained};
use super::super::hypothesis::{Term, with_places};
use super::super::leftover::Bins;
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
        let subject = term.phrase(problem.context());
        [0, 1].map(|axis| panel(subject.clone(), axis, &change, residuals))
    });
    both.collect()
}

/// Change of every reading by the effect at this place of the explanation, m; none of what
/// changes no reading.
fn change(problem: &Problem, best: &Fit, at: usize) -> Option<Vec<f64>> {
    let first = problem.first();
    match &best.terms[at] {
        Term::Effect(_) => {}
        Term::Masses => {
            let shift = problem.mass_shift(best);
            let metres = shift.iter().zip(&first.weight).map(|(s, w)| s / w);
            return Some(metres.collect());
        }
        Term::Outliers => return None,
    }
    let (mut terms, mut unknowns) = (Vec::new(), Vec::new());
    for (k, (term, own)) in with_places(&best.terms, &first.context).enumerate() {
        if k != at {
            terms.push(term.clone());
            unknowns.extend_from_slice(&best.unknowns[own]);
        }
    }
    let posture_context = problem.posture_contexts(Some(best)).swap_remove(0);
    // Values come with their derivatives by the unknowns.
    let readings = |terms: &[Term], unknowns: &[f64]| {
        let out = first.evaluate(terms, unknowns, &first.data.q, &posture_context);
        out.into_iter().step_by(1 + unknowns.len())
    };
    let without = readings(&terms, &unknowns);
    let with = readings(&best.terms, &best.unknowns).zip(without);
    Some(with.map(|(with, without)| with - without).collect())
}

fn panel(subject: String, axis: usize, change: &[f64], residuals: &Residuals) -> Predicted {
    let n = residuals.outlier.len();
    let change = |k: usize| change[2 * k + axis];
    let gap = |k: usize| residuals.after[2 * k + axis] + change(k);
    let (mut along, mut square) = (0.0, 0.0);
    for k in (0..n).filter(|&k| !residuals.outlier[k]) {
        along += change(k) * gap(k);
        square += change(k) * change(k);
    }
    let points = of_panel(n).map(|(posture, k)| PredictedPoint {
        posture,
        change: change(k),
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

/// Joints that are shown.
const SHOWN: usize = 6;

/// Moments (Nm) and forces (N) below this are written in thousandths.
const SMALL: f64 = 0.2;

/// What a residual is drawn against.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// ° of a revolute joint, mm of a prismatic one.
    Position,
    /// Nm of a revolute joint, N of a prismatic one.
    Moment,
}

/// Residuals of one axis, m, at a value of the quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Place of its posture among those of the view.
    pub posture: usize,
    /// Position or moment of the joint, in the trend's unit.
    pub at: f64,
    /// Residual before, m.
    pub before: f64,
    /// Residual after, m.
    pub after: f64,
    /// Whether the posture is an outlier.
    pub outlier: bool,
}

/// Mean residuals of a bin, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Middle {
    /// Mean position or moment, in the trend's unit.
    pub at: f64,
    /// Mean residual before, m.
    pub before: f64,
    /// Mean residual after, m.
    pub after: f64,
}

/// Residuals against one quantity of one joint, on the axis that follows it more.
#[derive(Debug, Clone, PartialEq)]
pub struct Trend {
    /// Name of the joint.
    pub joint: String,
    /// Whether the explanation names it.
    pub named: bool,
    /// Unit of positions or moments.
    pub unit: &'static str,
    /// 0: x, 1: y.
    pub axis: usize,
    /// Part of the scatter that follows the quantity, before and after.
    pub share: [f64; 2],
    /// The postures.
    pub points: Vec<Point>,
    /// Means over bins of the quantity.
    pub means: Vec<Middle>,
}

/// The joints that the explanation names, and then those that the gap, or what is left of it,
/// goes with most.
pub(super) fn strongest(
    problem: &Problem,
    found: &Explained,
    residuals: &Residuals,
    quantity: Quantity,
) -> Vec<Trend> {
    let of_rest = found.diagnosis.unexplained;
    let named = |joint: &str| {
        let mut steps = found.diagnosis.steps.iter();
        steps.position(|step| match &step.acts_on {
            ActsOn::Joints(joints) => joints.iter().any(|own| own == joint),
            _ => false,
        })
    };
    let (data, context) = (problem.data(), problem.context());
    let (n, dofs) = (data.len(), &context.robot.tree.dofs);
    // By joint, posture by posture, `width` apart.
    let (all, width) = match quantity {
        Quantity::Position => (data.q.clone(), dofs.len()),
        Quantity::Moment => (problem.first().moments_at(&data.q), 3 * dofs.len()),
    };
    let mut ranked = Vec::new();
    for (j, joint) in dofs.iter().enumerate() {
        let (factor, unit) = match (quantity, joint.prismatic) {
            (Quantity::Position, false) => (180.0 / std::f64::consts::PI, "°"),
            (Quantity::Position, true) => (1e3, "mm"),
            (Quantity::Moment, false) => (context.weight(), "Nm"),
            (Quantity::Moment, true) => (context.weight(), "N"),
        };
        let mut values: Vec<f64> = (0..n).map(|k| factor * all[k * width + j]).collect();
        let unit = match values.iter().fold(0.0, |most: f64, x| most.max(x.abs())) {
            most if quantity == Quantity::Moment && most < SMALL => {
                values.iter_mut().for_each(|x| *x *= 1e3);
                if joint.prismatic { "mN" } else { "mNm" }
            }
            _ => unit,
        };
        let kept = (0..n).filter(|&k| !residuals.outlier[k]).collect();
        let bins = Bins::new(kept, |k| values[k]);
        let both = [&residuals.before, &residuals.after];
        let followed = [0, 1].map(|axis| both.map(|e| bins.share(|row| e[row], axis..axis + 1)));
        let worth = followed.map(|own| own[usize::from(of_rest)].1);
        let axis = usize::from(worth[1] > worth[0]);
        let point = |(posture, k): (usize, usize)| Point {
            posture,
            at: values[k],
            before: residuals.before[2 * k + axis],
            after: residuals.after[2 * k + axis],
            outlier: residuals.outlier[k],
        };
        let step = named(&joint.joint);
        let trend = Trend {
            joint: joint.joint.clone(),
            named: step.is_some(),
            unit,
            axis,
            share: followed[axis].map(|(share, _)| share),
            points: of_panel(n).map(point).collect(),
            means: means(&bins, &values, residuals, axis),
        };
        ranked.push((step.unwrap_or(usize::MAX), worth[axis], trend));
    }
    ranked.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    ranked.truncate(SHOWN);
    ranked.into_iter().map(|(.., trend)| trend).collect()
}

fn means(bins: &Bins, values: &[f64], residuals: &Residuals, axis: usize) -> Vec<Middle> {
    let bins = bins.0.iter().filter(|bin| !bin.is_empty());
    let middle = |bin: &Vec<usize>| {
        let mean =
            |of: &dyn Fn(usize) -> f64| bin.iter().map(|&k| of(k)).sum::<f64>() / bin.len() as f64;
        Middle {
            at: mean(&|k| values[k]),
            before: mean(&|k| residuals.before[2 * k + axis]),
            after: mean(&|k| residuals.after[2 * k + axis]),
        }
    };
    bins.map(middle).collect()
}
