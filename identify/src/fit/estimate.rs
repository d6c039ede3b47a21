//! From gathered logs to parameters with their uncertainty, observability and held-out error.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use sesc_model::Model;
use sesc_model::base::{BaseParam, Column};

use super::criteria::{CORRELATED, ELSEWHERE_M, FAR, GROSSLY, SURELY};
use super::gather::{Fold, Gathered};
use super::identification::{
    BodyLength, Correlation, HeightConstant, Identification, ParameterFound, Settings, Unseen,
};
use super::masses::constrain;
use super::offset::{self, Wide};
use super::prior::Tolerances;
use crate::evaluate::Evaluator;
use crate::health;
use crate::lsq::factor::Factor;
use crate::lsq::solve::{Beyond, Estimate, information, of_rows};
use crate::observations::criteria::repeats::UNLIKELY;
use crate::observations::grouping;
use crate::observations::noise::{FreeResiduals, LEAST_STD, Noise, NoiseSource, widening};
use crate::observations::row_matrix::RowMatrix;
use crate::simulate::Simulator;

/// The largest correlations that are listed, at most.
const CORRELATIONS: usize = 20;
/// Postures over which errors are expected.
const SAMPLES: usize = 2000;

/// Fit `gathered` and say what was found.
pub fn identify(
    model: &Model,
    supports: &[impl ToString],
    gathered: &Gathered,
    settings: &Settings,
) -> Identification {
    let cad = DVector::from_vec(model.cad_params());
    let together = gathered.together();
    let (whole, plain) = (&together.weighted, together.plain());
    let seen = together.seen();
    let free = seen.solve(whole, 1.0, &cad, None);
    let rows = whole.rows() as f64;
    // Where visits differ, readings of one visit say nothing of what is left.
    let (within, df_within) = match !gathered.correlated && gathered.repeats.by_visits() {
        true => gathered.repeats.about_visits.both(),
        false => (0.0, 0),
    };
    let left = FreeResiduals {
        sum: whole.residual_sum(&free.params) / gathered.consistency - within,
        // Rows that a robust fit trusts less count less.
        df: 2.0 * gathered.trusted - free.rank as f64 - df_within as f64,
        of_cad: (offset::left_about(model, whole, &cad) / (2.0 * gathered.trusted)).sqrt(),
    };
    let mut warnings = Vec::new();
    let known = gathered.known_noise(settings.noise);
    let noise = Noise::known(&known).unwrap_or_else(|| Noise::left_over(left));
    let noise = match gathered.repeats.of_reading() {
        // The scatter of visits is that of as many readings together.
        Some(floor) if noise.source == NoiseSource::Repeats => Noise { floor, ..noise },
        _ => noise,
    };
    warnings.extend(noise.warning());
    warnings.extend(oddities(gathered));
    let lack_of_fit = noise.lack_of_fit(known.repeats, left);
    let misfit = lack_of_fit.filter(|test| test.p_value < UNLIKELY && test.ratio > 1.0);
    // All that is left over counts as noise then.
    let inflation = match misfit {
        // Repeats of a posture are no evidence of their own about what is missing.
        Some(test) if test.df_noise.is_some() => test.ratio.sqrt(),
        Some(_) => (left.sum / left.df).sqrt() / noise.sigma,
        None => 1.0,
    };
    let inflation = inflation.max(1.0);
    let mut health = gathered.health.clone();
    let over = health::FitResiduals {
        chi2: left.sum / (noise.sigma * noise.sigma),
        expected: left.df,
        taken: free.rank as f64,
        samples: rows,
        noise_m: noise.floor,
        floor_m: noise.floor,
        source: noise.source,
    };
    health.extend(over.overstated_noise(&gathered.health));
    if noise.source == NoiseSource::Unknown {
        warnings.push(format!(
            "{rows} rows for {} directions leave nothing to tell the noise from, and CAD's error \
             is taken for it; give the noise, columns of deviations, repeated readings or more \
             postures",
            free.rank
        ));
    }
    if misfit.is_some() {
        warnings.push(format!(
            "the model leaves {:.2} times the noise: something is missing in it; deviations of \
             parameters are widened by that",
            inflation
        ));
    }
    if let Some(closure) = gathered.closure.as_ref().filter(|found| !found.closes) {
        warnings.push(format!(
            "{} A fit of masses cannot tell it; a diagnosis of the log can",
            closure.sentence
        ));
    }
    warnings.extend(gathered.weight.and_then(|weight| weight.sentence()));
    let told_by = misfit.map_or(noise.df, |test| test.df);
    let sigma = noise.sigma * inflation * widening(told_by);
    let guessed = noise.source == NoiseSource::Unknown;
    let prior = settings.prior.spread(model);
    let centre = settings.prior.centre(model);
    let mut failures = Vec::new();
    // Within what masses can be, where that is asked for.
    let mut bounded = |fold: &Fold, params: DVector<f64>| {
        let Some(limits) = &settings.limits else {
            return (params, None);
        };
        let (rows, prior) = (&fold.weighted, &settings.prior);
        match constrain(model, rows, sigma, prior, limits, &params) {
            Ok((params, masses)) => (params, Some(masses)),
            Err(reason) => {
                failures.push(reason);
                (params, None)
            }
        }
    };
    // An offset of readings, where that is by far likelier than masses that are off alone.
    let wide = prior
        .as_ref()
        .filter(|_| supports.len() == 1 && settings.limits.is_none());
    let wide = wide
        .and_then(|prior| Wide::chosen(model, &together, sigma, &centre, prior, &settings.offset));
    let of_readings = wide.as_ref().map(|wide| &wide.factor).or(prior.as_ref());
    let mut estimate = seen.solve(whole, sigma, &centre, of_readings);
    let (params, masses) = bounded(&together, estimate.params);
    estimate.params = params;
    let params_of_readings = estimate.params.clone();
    let mut rows = whole.r() / sigma;
    let (held_out_rmse, held_out_error, folds) = held_out(gathered, |others| {
        let free = others.params(sigma, &centre, of_readings);
        bounded(others, free).0
    });
    let offset = wide.map(|wide| {
        rows = wide.rows_of_masses(&rows);
        let (of_masses, offset) = wide.split(&estimate, whole, sigma, &centre);
        estimate = of_masses;
        offset
    });
    let information = match &prior {
        Some(prior) => information(&rows, prior, Beyond::Exact),
        None => of_rows(&rows, &estimate.unseen),
    };
    if let Some(offset) = &offset {
        warnings.push(offset.sentence());
    }
    if held_out_rmse > FAR * noise.floor && !guessed {
        warnings.push(format!(
            "postures the fit did not see are off by {:.1} times the noise: too few postures, or \
             the model misses something",
            held_out_rmse / noise.floor
        ));
    }
    let axes = gathered.noise_by_axis();
    if noise.source == NoiseSource::Residuals
        && axes[0].max(axes[1]) > GROSSLY * axes[0].min(axes[1])
    {
        warnings.push(format!(
            "what is left is {:.1} times as large on one axis as on the other, which sensors seldom \
             are: the model misses something, or repeated readings would tell",
            axes[0].max(axes[1]) / axes[0].min(axes[1])
        ));
    }
    if let Some(reason) = failures.first() {
        warnings.push(format!(
            "{reason}: bounds were left aside in {} fits",
            failures.len()
        ));
    }
    let rms = |sum: f64, rows: u64| (sum / rows.max(1) as f64).sqrt();
    // What data leave open is as uncertain as CAD usually is.
    let usual = prior.is_none().then(|| Tolerances::usual().factor(model));
    let covariance = complete(&estimate, usual);
    let mut std = deviations(&estimate, prior.is_none());
    if guessed && prior.is_none() {
        std.fill(None);
    }
    let prior_std = prior.as_ref().map(row_norms);
    let over_range = settings.over_range.clone();
    let over_range =
        over_range.unwrap_or_else(|| Arc::new(self::over_range(model, settings.range)));
    let parameters = parameters(model, &estimate, &std, prior_std.as_deref(), &cad);
    let r = plain.r();
    let data_error = (&r * &covariance * r.transpose()).trace();
    Identification {
        robot: model.tree.robot.clone(),
        hash: model.tree.hash.clone(),
        support: model.tree.links[model.tree.support].name.clone(),
        supports: supports.iter().map(ToString::to_string).collect(),
        data: gathered.logs.clone(),
        postures: gathered.repeats.postures,
        readings: gathered.readings,
        base_params: cad.len(),
        rank: free.rank,
        condition_number: free.condition_number,
        unobservable: unobservable(model, &estimate),
        prior: settings.prior.sentence(),
        noise_floor: noise.floor,
        noise_source: noise.source,
        noise_df: noise.df.is_finite().then_some(noise.df),
        noise_axes: gathered.noise_by_axis().map(|axis| axis * noise.floor),
        samples: gathered
            .samples
            .of(gathered.readings + gathered.motion.rows_left_out)
            .by_visits(&gathered.repeats),
        motion: match parameters.iter().any(is_elsewhere) {
            true => gathered.motion.clone().told_of_a_load(),
            false => gathered.motion.clone().told(),
        },
        visits: gathered.repeats.visits(),
        closure: gathered.closure.clone(),
        weight: gathered.weight,
        again: match noise.source {
            NoiseSource::Residuals | NoiseSource::Unknown => gathered.again.clone(),
            // Readings of single visits are known, and the fit leaves more than they scatter.
            _ if inflation > 1.0 && gathered.repeats.rows > gathered.repeats.postures => {
                gathered.again.clone()
            }
            _ => None,
        },
        lack_of_fit,
        inflation,
        offset,
        held_out_rmse,
        held_out_error,
        folds,
        in_sample_rmse: rms(plain.residual_sum(&params_of_readings), plain.rows()),
        cad_rmse: rms(plain.residual_sum(&cad), plain.rows()),
        expected_error_data: rms(data_error, plain.rows()),
        expected_error_range: range_error(&over_range, &covariance),
        range: match settings.range {
            Some(range) => format!("±{:.0}° within the joint limits", range.to_degrees()),
            None => "the joint limits".to_string(),
        },
        com_height_constant: height(&model.base.params, &parameters),
        bodies: bodies(model, &estimate, &cad, &std),
        correlations: correlations(model, &estimate.covariance),
        parameters,
        down_weighted: gathered.down_weighted.clone(),
        health,
        warnings,
        warnings_of_logs: 0,
        active_bounds: masses.as_ref().map(|masses| masses.active.clone()),
        estimate,
        params_of_readings,
        information,
        masses,
    }
}

/// Whether masses are so much other than CAD's that what is linear about CAD no longer tells
/// how they are accelerated.
fn is_elsewhere(found: &ParameterFound) -> bool {
    let off = (found.value - found.cad).abs();
    off > ELSEWHERE_M && found.std.is_some_and(|std| off > SURELY * std)
}

/// What is odd about the rows.
fn oddities(gathered: &Gathered) -> Vec<String> {
    let mut said = Vec::new();
    if gathered.moved > 0 {
        said.push(grouping::moved_sentence(gathered.moved));
    }
    if gathered.tiny > 0 {
        said.push(format!(
            "{} rows state deviations below {:e} m, which no sensor has; that is taken for them: \
             are they in metres?",
            gathered.tiny, LEAST_STD
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

/// k-fold cross-validation on the folds' factors: RMS per axis, its standard error, m, and folds.
fn held_out(gathered: &Gathered, mut fit: impl FnMut(&Fold) -> DVector<f64>) -> (f64, f64, usize) {
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
    let mean: f64 = folds.iter().map(|(square, n)| square * n).sum::<f64>() / rows;
    let spread: f64 = folds
        .iter()
        .map(|(square, n)| (n / rows * (square - mean)).powi(2))
        .sum();
    let count = folds.len() as f64;
    let of_mean = (spread * count / (count - 1.0).max(1.0)).sqrt();
    // d√x = dx / 2√x
    let error = match folds.is_empty() {
        true => f64::NAN,
        false => of_mean / (2.0 * mean.sqrt()).max(f64::MIN_POSITIVE),
    };
    (mean.sqrt(), error, folds.len())
}

/// Standard deviations; none along directions that a free fit does not see.
fn deviations(estimate: &Estimate, free: bool) -> Vec<Option<f64>> {
    let blind = |k: usize| free && estimate.unseen.row(k).norm() > 1e-6;
    (0..estimate.params.len())
        .map(|k| (!blind(k)).then(|| estimate.covariance[(k, k)].max(0.0).sqrt()))
        .collect()
}

/// Covariance with what a free fit leaves open filled in by `usual`.
fn complete(estimate: &Estimate, usual: Option<DMatrix<f64>>) -> DMatrix<f64> {
    let Some(usual) = usual else {
        return estimate.covariance.clone();
    };
    let half = &estimate.unseen * (estimate.unseen.transpose() * usual);
    &estimate.covariance + &half * half.transpose()
}

fn row_norms(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.row_iter().map(|row| row.norm()).collect()
}

fn parameters(
    model: &Model,
    estimate: &Estimate,
    std: &[Option<f64>],
    prior_std: Option<&[f64]>,
    cad: &DVector<f64>,
) -> Vec<ParameterFound> {
    let found = |(k, param): (usize, &BaseParam)| ParameterFound {
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
fn height(base: &[BaseParam], parameters: &[ParameterFound]) -> HeightConstant {
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
fn unobservable(model: &Model, estimate: &Estimate) -> Vec<Unseen> {
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

fn bodies(
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

fn correlations(model: &Model, covariance: &DMatrix<f64>) -> Vec<Correlation> {
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
fn range_error(r: &DMatrix<f64>, covariance: &DMatrix<f64>) -> f64 {
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
