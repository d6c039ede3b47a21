//! What a fit can say: held-out errors, deviations, lengths of bodies, what is not seen.

use super::criteria::CORRELATED;
use nalgebra::{DMatrix, DVector};
use sesc_model::Model;
use sesc_model::base::{BaseParam, Column};

use super::gather::{Fold, Gathered};
use super::identification::{BodyLength, Correlation, HeightConstant, ParameterFound, Unseen};
use crate::evaluate::Evaluator;
use crate::lsq::factor::Factor;
use crate::lsq::solve::Estimate;
use crate::observations::row_matrix::RowMatrix;
use crate::observations::{grouping, noise};
use crate::simulate::Simulator;

/// The largest correlations that are listed, at most.
const CORRELATIONS: usize = 20;
/// Postures over which errors are expected.
const SAMPLES: usize = 2000;

/// What is odd about the rows.
pub(super) fn oddities(gathered: &Gathered) -> Vec<String> {
    let mut said = Vec::new();
    if gathered.moved > 0 {
        said.push(grouping::moved_sentence(gathered.moved));
    }
    if gathered.tiny > 0 {
        said.push(format!(
            "{} rows state deviations below {:e} m, which no sensor has; that is taken for them: \
             are they in metres?",
            gathered.tiny,
            noise::LEAST_STD
        ));
    }
    if gathered.overfull > 0 {
        said.push(format!(
            "more than {} postures in a log: readings of the others are repeats only where \
             their rows follow each other",
            grouping::MOST
        ));
    }
    said
}

pub(super) struct HeldOut {
    /// RMS per axis, m.
    pub(super) rmse: f64,
    /// Standard error of that, m.
    pub(super) error: f64,
    pub(super) folds: usize,
}

/// k-fold cross-validation on the folds' factors.
pub(super) fn held_out(gathered: &Gathered, mut fit: impl FnMut(&Fold) -> DVector<f64>) -> HeldOut {
    let all: u64 = gathered.folds.iter().map(|fold| fold.plain().rows()).sum();
    let mut folds: Vec<(f64, f64)> = Vec::new(); // mean square, rows
    gathered.without_each(&mut |k, others| {
        let fold = &gathered.folds[k];
        let rows = fold.plain().rows();
        if rows == 0 || rows == all {
            return;
        }
        let sum = fold.plain().residual_sum(&fit(others));
        folds.push((sum / rows as f64, rows as f64));
    });
    let rows: f64 = folds.iter().map(|fold| fold.1).sum();
    if rows == 0.0 {
        return HeldOut {
            rmse: f64::NAN,
            error: f64::NAN,
            folds: 0,
        };
    }
    let mean: f64 = folds.iter().map(|(square, n)| square * n).sum::<f64>() / rows;
    let spread: f64 = folds
        .iter()
        .map(|(square, n)| (n / rows * (square - mean)).powi(2))
        .sum();
    let count = folds.len() as f64;
    let of_mean = (spread * count / (count - 1.0).max(1.0)).sqrt();
    HeldOut {
        rmse: mean.sqrt(),
        // d√x = dx / 2√x
        error: of_mean / (2.0 * mean.sqrt()).max(f64::MIN_POSITIVE),
        folds: folds.len(),
    }
}

/// Standard deviations; none along directions that a free fit does not see.
pub(super) fn deviations(estimate: &Estimate, free: bool) -> Vec<Option<f64>> {
    let blind = |k: usize| free && estimate.unseen.row(k).norm() > 1e-6;
    (0..estimate.params.len())
        .map(|k| (!blind(k)).then(|| estimate.covariance[(k, k)].max(0.0).sqrt()))
        .collect()
}

/// Covariance with what a free fit leaves open filled in by `usual`.
pub(super) fn complete(estimate: &Estimate, usual: Option<DMatrix<f64>>) -> DMatrix<f64> {
    let Some(usual) = usual else {
        return estimate.covariance.clone();
    };
    let half = &estimate.unseen * (estimate.unseen.transpose() * usual);
    &estimate.covariance + &half * half.transpose()
}

pub(super) fn row_norms(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.row_iter().map(|row| row.norm()).collect()
}

pub(super) fn parameters(
    model: &Model,
    estimate: &Estimate,
    std: &[Option<f64>],
    prior_std: Option<&[f64]>,
    cad: &DVector<f64>,
) -> Vec<ParameterFound> {
    let found = |(k, param): (usize, &sesc_model::base::BaseParam)| ParameterFound {
        name: param.name.clone(),
        value: estimate.params[k],
        std: std[k],
        cad: cad[k],
        source: match (std[k], prior_std.map(|prior| prior[k])) {
            (None, _) => "cad",
            // Data that leave more than 70 % of the prior's deviation contain less than the prior.
            (Some(std), Some(prior)) if std >= std::f64::consts::FRAC_1_SQRT_2 * prior => "prior",
            _ => "data",
        },
    };
    model.base.params.iter().enumerate().map(found).collect()
}

/// r_0 along z, which flat readings of one foot never tell. Regrouping keeps it: it drops columns
/// that come after those which make them up.
pub(super) fn height(base: &[BaseParam], parameters: &[ParameterFound]) -> HeightConstant {
    let r_0z = Column::Axis { body: 0, axis: 2 };
    let all = base.iter().zip(parameters);
    let found = all.into_iter().find(|(param, _)| param.column == r_0z);
    let (_, found) = found.expect("r_0 along z is a base parameter of every robot");
    HeightConstant {
        name: found.name.clone(),
        value: found.value,
        std: found.std,
        source: found.source,
    }
}

/// Directions never seen by such data, then those that these data miss.
pub(super) fn unobservable(model: &Model, estimate: &Estimate) -> Vec<Unseen> {
    let from_cop = estimate.rank <= model.base.rank_cop;
    let by_structure = model.base.unobservable.iter();
    let mut all: Vec<Unseen> = by_structure
        .filter(|u| from_cop || !u.only_from_cop)
        .map(|u| Unseen {
            name: u.name.clone(),
            sentence: u.sentence.clone(),
        })
        .collect();
    let expected = model.base.params.len() - model.base.rank_cop;
    let missed = estimate
        .unseen
        .ncols()
        .saturating_sub(if from_cop { expected } else { 0 });
    if missed > 0 {
        // Parameters with the largest part in what is not seen.
        let share = row_norms(&estimate.unseen);
        let mut order: Vec<usize> = (0..share.len()).collect();
        order.sort_by(|a, b| share[*b].total_cmp(&share[*a]));
        let names: Vec<&str> = order
            .iter()
            .take(estimate.unseen.ncols() + 2)
            .filter(|k| share[**k] > 0.1)
            .map(|k| model.base.params[*k].name.as_str())
            .collect();
        all.push(Unseen {
            name: "not excited".to_string(),
            sentence: format!(
                "these postures leave {missed} more direction{} open, among {}: move the joints \
                 that carry them",
                if missed == 1 { "" } else { "s" },
                names.join(", ")
            ),
        });
    }
    all
}

pub(super) fn bodies(
    model: &Model,
    estimate: &Estimate,
    cad: &DVector<f64>,
    std: &[Option<f64>],
) -> Vec<BodyLength> {
    let of_body = |(at, body): (usize, &sesc_model::chain::Body)| {
        let own = |k: &usize| {
            let (Column::Axis { body, .. } | Column::Prismatic { body }) =
                model.base.params[*k].column;
            body == at
        };
        let own: Vec<usize> = (0..cad.len()).filter(own).collect();
        let norm =
            |values: &DVector<f64>| own.iter().map(|&k| values[k].powi(2)).sum::<f64>().sqrt();
        let length = norm(&estimate.params);
        // First order: the deviation along the vector itself.
        let variance: f64 = own
            .iter()
            .flat_map(|&a| own.iter().map(move |&b| (a, b)))
            .map(|(a, b)| estimate.params[a] * estimate.covariance[(a, b)] * estimate.params[b])
            .sum();
        let seen = own.iter().all(|&k| std[k].is_some()) && length > 0.0;
        BodyLength {
            body: body.name.clone(),
            joint: body.joint.clone(),
            cad: norm(cad),
            identified: length,
            std: seen.then(|| variance.max(0.0).sqrt() / length),
        }
    };
    model.chain.bodies.iter().enumerate().map(of_body).collect()
}

pub(super) fn correlations(model: &Model, covariance: &DMatrix<f64>) -> Vec<Correlation> {
    let std: Vec<f64> = covariance
        .diagonal()
        .iter()
        .map(|v| v.max(0.0).sqrt())
        .collect();
    let mut all = Vec::new();
    for a in 0..std.len() {
        for b in a + 1..std.len() {
            let correlation = covariance[(a, b)] / (std[a] * std[b]);
            if correlation.is_finite() && correlation.abs() > CORRELATED {
                all.push(Correlation {
                    a: model.base.params[a].name.clone(),
                    b: model.base.params[b].name.clone(),
                    correlation,
                });
            }
        }
    }
    all.sort_by(|x, y| y.correlation.abs().total_cmp(&x.correlation.abs()));
    all.truncate(CORRELATIONS);
    all
}

/// R with Rᵀ R = Σ φᵀ φ over postures drawn from the range: the same for every log of a robot.
pub(super) fn over_range(model: &Model, range: Option<f64>) -> DMatrix<f64> {
    let params = model.base.params.len();
    let mut simulator = Simulator::new(&model.tree.dofs, range, 1);
    let q = simulator.batch(SAMPLES);
    let rows = Evaluator::new(model, sesc_model::Function::RegressorCop).run(&q, SAMPLES);
    let rows = RowMatrix {
        entries: rows,
        columns: params,
    };
    let mut factor = Factor::new(params);
    let all = (0..2 * SAMPLES).map(|row| (row, 1.0));
    factor.push_rows(&rows, &DVector::zeros(2 * SAMPLES), all);
    factor.r()
}

/// √ of the mean of tr(φ C φᵀ)/2 over the postures of [`over_range`], m.
pub(super) fn range_error(r: &DMatrix<f64>, covariance: &DMatrix<f64>) -> f64 {
    ((r * covariance * r.transpose()).trace() / (2 * SAMPLES) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Robot;
    use sesc_model::Snapping;

    #[test]
    fn the_height_constant_is_r_0_along_z_wherever_it_stands() {
        let urdf = "<robot name='r'><link name='a.b'><inertial><origin xyz='1 2 3'/>\
                    <mass value='1'/></inertial></link></robot>";
        let robot = Robot::parse(urdf, "r.urdf").unwrap();
        let model = robot.model("a.b", Snapping::default(), None).unwrap();
        let mut params = model.base.params.clone();
        let found = |params: &[BaseParam]| {
            let all = params.iter().map(|param| ParameterFound {
                name: param.name.clone(),
                value: param.cad,
                std: None,
                cad: param.cad,
                source: "cad",
            });
            height(params, &all.collect::<Vec<_>>())
        };
        assert_eq!(found(&params).name, "a.b.z");
        assert_eq!(found(&params).value, 3.0);
        // Another parameter is then third, or last.
        for order in [[2, 0, 1], [0, 2, 1]] {
            let other = order.map(|k: usize| params[k].clone());
            assert_eq!(found(&other).name, "a.b.z", "{order:?}");
        }
        params.remove(0);
        assert_eq!(found(&params).name, "a.b.z");
    }
}
