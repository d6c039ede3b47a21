//! What the gap goes with: residuals against the position and the gravity moment
//! of a joint, averaged in bins.
//!
//! ```text
//! share = 1 − Σ_bins Σ (e − ē_bin)² / Σ (e − ē)² · (n − 1)/(n − bins)
//! ```

use super::super::criteria::{BINS, PER_BIN};
use super::super::findings::{ActsOn, Explained};
use super::super::problem::Problem;
use super::{Residuals, of_panel};

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
