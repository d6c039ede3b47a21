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

use super::super::criteria::{BINS, PER_BIN};
use super::super::findings::{ActsOn, Explained};
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
        found
            .diagnosis
            .steps
            .iter()
            .position(|step| match &step.acts_on {
                ActsOn::Joints(joints) => joints.iter().any(|own| own == joint),
                _ => false,
            })
    };
    let data = &problem.first().data;
    let dofs = &problem.first().context.robot.tree.dofs;
    let (n, dof) = (data.len(), dofs.len());
    let weight = problem.first().context.weight();
    let moments = match quantity {
        Quantity::Moment => problem.first().moments_at(&data.q),
        Quantity::Position => Vec::new(),
    };
    let mut ranked = Vec::new();
    for (j, joint) in dofs.iter().enumerate() {
        let (factor, unit) = match (quantity, joint.prismatic) {
            (Quantity::Position, false) => (180.0 / std::f64::consts::PI, "°"),
            (Quantity::Position, true) => (1e3, "mm"),
            (Quantity::Moment, false) => (weight, "Nm"),
            (Quantity::Moment, true) => (weight, "N"),
        };
        let mut values: Vec<f64> = match quantity {
            Quantity::Position => (0..n).map(|k| factor * data.q[k * dof + j]).collect(),
            Quantity::Moment => (0..n).map(|k| factor * moments[k * 3 * dof + j]).collect(),
        };
        let unit = match values.iter().fold(0.0, |most: f64, x| most.max(x.abs())) {
            most if quantity == Quantity::Moment && most < SMALL => {
                values.iter_mut().for_each(|x| *x *= 1e3);
                if joint.prismatic { "mN" } else { "mNm" }
            }
            _ => unit,
        };
        let bins = Bins::of(&values, &residuals.outlier);
        let followed =
            [0, 1].map(|axis| [&residuals.before, &residuals.after].map(|e| bins.follows(e, axis)));
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
            means: bins.means(&values, residuals, axis),
        };
        ranked.push((step.unwrap_or(usize::MAX), worth[axis], trend));
    }
    ranked.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    ranked.truncate(SHOWN);
    ranked.into_iter().map(|(.., trend)| trend).collect()
}

/// Postures by the size of a quantity, equally many in each; outliers in none.
struct Bins(Vec<Vec<usize>>);

impl Bins {
    fn of(values: &[f64], outlier: &[bool]) -> Bins {
        let mut order: Vec<usize> = (0..values.len()).filter(|&k| !outlier[k]).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        let count = (order.len() / PER_BIN).clamp(1, BINS);
        let cut = |b: usize| b * order.len() / count;
        Bins(
            (0..count)
                .map(|b| order[cut(b)..cut(b + 1)].to_vec())
                .collect(),
        )
    }

    /// Part of the scatter on an axis that the bins explain, and its size, m².
    fn follows(&self, errors: &[f64], axis: usize) -> (f64, f64) {
        let of = |k: &usize| errors[2 * k + axis];
        let all: Vec<f64> = self.0.iter().flatten().map(of).collect();
        let scatter = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
            values.iter().map(|x| (x - mean).powi(2)).sum::<f64>()
        };
        let whole = scatter(&all);
        let within: f64 = self
            .0
            .iter()
            .map(|bin| scatter(&bin.iter().map(of).collect::<Vec<f64>>()))
            .sum();
        let (n, bins) = (all.len() as f64, self.0.len() as f64);
        if !(whole > 0.0 && n > bins) {
            return (0.0, 0.0);
        }
        let share = (1.0 - within / whole * (n - 1.0) / (n - bins)).max(0.0);
        (share, share * whole)
    }

    fn means(&self, values: &[f64], residuals: &Residuals, axis: usize) -> Vec<Middle> {
        let bins = self.0.iter().filter(|bin| !bin.is_empty());
        bins.map(|bin| {
            let mean = |of: &dyn Fn(usize) -> f64| {
                bin.iter().map(|&k| of(k)).sum::<f64>() / bin.len() as f64
            };
            Middle {
                at: mean(&|k| values[k]),
                before: mean(&|k| residuals.before[2 * k + axis]),
                after: mean(&|k| residuals.after[2 * k + axis]),
            }
        })
        .collect()
    }
}
