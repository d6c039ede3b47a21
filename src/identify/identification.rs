//! What a fit found: parameters and all that must be said with them.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use sesc_codegen::{Model, ModelFile};

use super::factor::Factor;
use super::gather::{self, DownWeighted, Fold, Gathered, LogUsed};
use super::limits::Limits;
use super::masses::Masses;
use super::noise::LackOfFit;
use super::noise_level::{Leftover, Noise, UNLIKELY, widening};
use super::physical;
use super::postures;
use super::prior::{Prior, Tolerances};
use super::solve::Estimate;
use crate::evaluate::Evaluator;
use crate::simulate::Simulator;

/// How to fit.
#[derive(Debug, Clone)]
pub struct Settings {
    pub prior: Prior,
    /// Standard deviation of a reading, m; from the data where not given.
    pub noise: Option<f64>,
    /// Range over which errors are expected: ±rad about zero within the limits.
    pub range: Option<f64>,
}

/// Where the size of the noise comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum NoiseSource {
    /// Given by the user.
    Given,
    /// Columns of standard deviations.
    Stated,
    /// Repeated readings, with what a fit leaves where that is of one size with them.
    Replicates,
    /// What a fit without prior leaves.
    Residuals,
    /// CAD's prediction is all there is: too few rows.
    Unknown,
}

/// One base parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterFound {
    pub name: String,
    /// m
    pub value: f64,
    /// m, ± 1.96 of them hold 95 %; none where neither data nor prior say anything.
    pub std: Option<f64>,
    /// m
    pub cad: f64,
    /// `data` or `prior`, whichever tells more.
    pub source: &'static str,
}

/// Two parameters that are known less well apart than together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Correlation {
    pub a: String,
    pub b: String,
    pub correlation: f64,
}

/// ‖base part of r_i‖ of one body.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BodyLength {
    pub body: String,
    pub joint: Option<String>,
    /// m
    pub cad: f64,
    /// m
    pub identified: f64,
    /// Standard deviation of the identified length, m.
    pub std: Option<f64>,
}

/// The constant that flat single-foot CoP never tells.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HeightConstant {
    pub name: String,
    /// m
    pub value: f64,
    pub std: Option<f64>,
    /// `data`, `prior` or `cad`.
    pub source: &'static str,
}

/// A direction that cannot be seen.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Unseen {
    pub name: String,
    pub sentence: String,
}

/// Everything a fit found.
#[derive(Debug, Clone, Serialize)]
pub struct Identification {
    pub robot: String,
    pub hash: String,
    /// The support whose parameters these are.
    pub support: String,
    /// All links that postures stood on.
    pub supports: Vec<String>,
    pub data: Vec<LogUsed>,
    pub postures: u64,
    pub readings: u64,
    pub base_params: usize,
    pub rank: usize,
    pub condition_number: f64,
    /// Never seen by such data, and not seen by these.
    pub unobservable: Vec<Unseen>,
    pub prior: String,
    /// Noise of a reading on one axis, m.
    pub noise_floor: f64,
    pub noise_source: NoiseSource,
    /// Degrees of freedom it was estimated with; none where it is stated or guessed.
    pub noise_df: Option<f64>,
    pub lack_of_fit: Option<LackOfFit>,
    /// Deviations of parameters are larger by this, because the model leaves more than noise.
    pub inflation: f64,
    /// RMS per axis on postures that the fit did not see, m.
    pub held_out_rmse: f64,
    /// Standard error of that, m.
    pub held_out_error: f64,
    pub folds: usize,
    /// RMS per axis on the postures fitted, m: never the accuracy.
    pub in_sample_rmse: f64,
    /// RMS per axis of CAD's prediction, m.
    pub cad_rmse: f64,
    /// Expected RMS error of the prediction per axis where data were taken, m.
    pub expected_error_data: f64,
    /// The same over the joint range, m.
    pub expected_error_range: f64,
    /// What that range is.
    pub range: String,
    pub com_height_constant: HeightConstant,
    pub parameters: Vec<ParameterFound>,
    pub bodies: Vec<BodyLength>,
    /// The strongest, |correlation| > 0.9.
    pub correlations: Vec<Correlation>,
    pub down_weighted: Vec<DownWeighted>,
    pub warnings: Vec<String>,
    /// Bounds of physical masses that hold the fit back; none where it was not bounded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub active_bounds: Option<Vec<String>>,
    #[serde(skip)]
    pub estimate: Estimate,
    /// Masses of a bounded fit.
    #[serde(skip)]
    pub masses: Option<Masses>,
}

/// Correlations worth a line.
const CORRELATED: f64 = 0.9;
const CORRELATIONS: usize = 20;
/// Postures over which errors are expected.
const SAMPLES: usize = 2000;
/// Held-out errors beyond this many times the noise deserve a word.
const FAR: f64 = 2.0;

/// Fit `gathered` and say what was found.
pub fn identify(
    model: &Model,
    supports: &[&str],
    gathered: &Gathered,
    settings: &Settings,
) -> Identification {
    identify_within(model, supports, gathered, settings, None)
}

/// The same, by masses within `limits` where those are given.
pub fn identify_within(
    model: &Model,
    supports: &[&str],
    gathered: &Gathered,
    settings: &Settings,
    limits: Option<&Limits>,
) -> Identification {
    let cad = DVector::from_vec(model.cad_params());
    let together = gathered.together(None);
    let (whole, plain) = (&together.weighted, together.plain());
    let free = together.solve(1.0, &cad, None);
    let rows = whole.rows() as f64;
    let left = Leftover {
        sum: whole.residual_sum(&free.params) / gathered.consistency,
        // Rows that a robust fit trusts less count less.
        df: 2.0 * gathered.trusted - free.rank as f64,
        of_cad: (whole.residual_sum(&cad) / rows).sqrt(),
    };
    let mut warnings = Vec::new();
    let noise = Noise::of(gathered, settings.noise, left);
    if noise.understated > 1.0 {
        warnings.push(format!(
            "repeated readings scatter {:.1} times as much as is stated; the scatter is taken",
            noise.understated
        ));
    }
    warnings.extend(oddities(gathered));
    let lack_of_fit = noise.lack_of_fit(gathered, left);
    let misfit = lack_of_fit.filter(|test| test.p_value < UNLIKELY && test.ratio > 1.0);
    // All that is left over counts as noise then.
    let inflation = match misfit {
        // Repeats of a posture are no evidence of their own about what is missing.
        Some(test) if test.df_noise.is_some() => test.ratio.sqrt(),
        Some(_) => (left.sum / left.df).sqrt() / noise.sigma,
        None => 1.0,
    };
    let inflation = inflation.max(1.0);
    if noise.source == NoiseSource::Unknown {
        warnings.push(format!(
            "{rows} rows for {} directions leave nothing to tell the noise from, and CAD's error \
             is taken for it; give --noise, columns of deviations, repeated readings or more \
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
    let told_by = misfit.map_or(noise.df, |test| test.df);
    let sigma = noise.sigma * inflation * widening(told_by);
    let guessed = noise.source == NoiseSource::Unknown;
    let prior = settings.prior.factor(model);
    let mut failures = Vec::new();
    let mut fit = |fold: &Fold| {
        let mut estimate = fold.solve(sigma, &cad, prior.as_ref());
        let bounded = limits.map(|limits| {
            physical::constrain(
                model,
                &fold.weighted,
                sigma,
                &settings.prior,
                limits,
                &estimate.params,
            )
        });
        match bounded {
            None => (estimate, None),
            Some(Ok(bounded)) => {
                estimate.params = bounded.params;
                (estimate, Some(bounded.masses))
            }
            Some(Err(failure)) => {
                failures.push(failure.reason);
                (estimate, None)
            }
        }
    };
    let (estimate, masses) = fit(&together);
    let held_out = held_out(gathered, |others| fit(others).0);
    if held_out.rmse > FAR * noise.floor && !guessed {
        warnings.push(format!(
            "postures the fit did not see are off by {:.1} times the noise: too few postures, or \
             the model misses something",
            held_out.rmse / noise.floor
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
    let usual = Prior::Cad(Tolerances::usual()).factor(model);
    let covariance = complete(&estimate, prior.is_none().then_some(usual).flatten());
    let mut std = deviations(&estimate, prior.is_none());
    if guessed && prior.is_none() {
        std.fill(None);
    }
    let prior_std = prior.as_ref().map(row_norms);
    let parameters = parameters(model, &estimate, &std, prior_std.as_deref(), &cad);
    let r = plain.r();
    let data_error = (&r * &covariance * r.transpose()).trace();
    Identification {
        robot: model.tree.robot.clone(),
        hash: model.tree.hash.clone(),
        support: model.tree.links[model.tree.support].name.clone(),
        supports: supports.iter().map(|s| s.to_string()).collect(),
        data: gathered.logs.clone(),
        postures: gathered.replicates.groups,
        readings: gathered.readings,
        base_params: cad.len(),
        rank: free.rank,
        condition_number: free.condition_number,
        unobservable: unobservable(model, &estimate),
        prior: settings.prior.sentence(),
        noise_floor: noise.floor,
        noise_source: noise.source,
        noise_df: noise.df.is_finite().then_some(noise.df),
        lack_of_fit,
        inflation,
        held_out_rmse: held_out.rmse,
        held_out_error: held_out.error,
        folds: held_out.folds,
        in_sample_rmse: rms(plain.residual_sum(&estimate.params), plain.rows()),
        cad_rmse: rms(plain.residual_sum(&cad), plain.rows()),
        expected_error_data: rms(data_error, plain.rows()),
        expected_error_range: range_error(model, &covariance, settings.range),
        range: match settings.range {
            Some(range) => format!("±{:.0}° within the joint limits", range.to_degrees()),
            None => "the joint limits".to_string(),
        },
        com_height_constant: height(&parameters),
        bodies: bodies(model, &estimate, &cad, &std),
        correlations: correlations(model, &estimate.covariance),
        parameters,
        down_weighted: gathered.down_weighted.clone(),
        warnings,
        active_bounds: masses.as_ref().map(|masses| masses.active.clone()),
        estimate,
        masses,
    }
}

/// What is odd about the rows.
fn oddities(gathered: &Gathered) -> Vec<String> {
    let mut said = Vec::new();
    if gathered.moved > 0 {
        said.push(format!(
            "{} rows share the `pose` of an earlier row but not its joint positions: \
             taken as postures of their own",
            gathered.moved
        ));
    }
    if gathered.tiny > 0 {
        said.push(format!(
            "{} rows state deviations below {:e} m, which no sensor has; that is taken for them: \
             are they in metres?",
            gathered.tiny,
            gather::LEAST_STD
        ));
    }
    if gathered.overfull > 0 {
        said.push(format!(
            "more than {} postures in a log: readings of the others are repeats only where \
             their rows follow each other",
            postures::MOST
        ));
    }
    said
}

struct HeldOut {
    rmse: f64,
    error: f64,
    folds: usize,
}

/// k-fold cross-validation on the folds' factors.
fn held_out(gathered: &Gathered, mut fit: impl FnMut(&Fold) -> Estimate) -> HeldOut {
    let all: u64 = gathered.folds.iter().map(|fold| fold.plain().rows()).sum();
    let mut folds: Vec<(f64, f64)> = Vec::new(); // mean square, rows
    for (k, fold) in gathered.folds.iter().enumerate() {
        let rows = fold.plain().rows();
        if rows == 0 || rows == all {
            continue;
        }
        let estimate = fit(&gathered.together(Some(k)));
        let sum = fold.plain().residual_sum(&estimate.params);
        folds.push((sum / rows as f64, rows as f64));
    }
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
    let found = |(k, param): (usize, &sesc_codegen::base::BaseParam)| ParameterFound {
        name: param.name.clone(),
        value: estimate.params[k],
        std: std[k],
        cad: cad[k],
        source: match (std[k], prior_std.map(|prior| prior[k])) {
            (None, _) => "cad",
            // Data that leave more than 70 % of the prior's deviation told less than it.
            (Some(std), Some(prior)) if std >= std::f64::consts::FRAC_1_SQRT_2 * prior => "prior",
            _ => "data",
        },
    };
    model.base.params.iter().enumerate().map(found).collect()
}

/// r_0 along z: the third parameter of body 0.
fn height(parameters: &[ParameterFound]) -> HeightConstant {
    let found = &parameters[2.min(parameters.len() - 1)];
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
    let of_body = |body: &sesc_codegen::chain::Body| {
        let own = |k: &usize| {
            let name = model.base.params[*k].name.rsplit_once('.');
            name.is_some_and(|(link, _)| link == body.name)
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
    model.chain.bodies.iter().map(of_body).collect()
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

/// √ of the mean of tr(φ C φᵀ)/2 over postures drawn from the range, m.
fn range_error(model: &Model, covariance: &DMatrix<f64>, range: Option<f64>) -> f64 {
    let mut simulator = Simulator::new(&model.tree.dofs, range, 1);
    let q = simulator.batch(SAMPLES);
    let rows = Evaluator::new(model, sesc_codegen::Function::RegressorCop).run(&q, SAMPLES);
    let mut factor = Factor::new(covariance.nrows());
    let matrix = DMatrix::from_row_slice(2 * SAMPLES, covariance.nrows(), &rows);
    factor.push(
        &matrix,
        &DVector::zeros(2 * SAMPLES),
        &vec![1.0; 2 * SAMPLES],
    );
    let r = factor.r();
    ((&r * covariance * r.transpose()).trace() / (2 * SAMPLES) as f64).sqrt()
}

impl Identification {
    /// Correlations of the parameters with each other; NaN where one has no deviation.
    pub fn correlation_matrix(&self) -> Vec<Vec<f64>> {
        let covariance = &self.estimate.covariance;
        let of = |a: usize, b: usize| {
            covariance[(a, b)] / (covariance[(a, a)] * covariance[(b, b)]).sqrt()
        };
        let all = 0..covariance.nrows();
        all.clone()
            .map(|a| all.clone().map(|b| of(a, b)).collect())
            .collect()
    }

    /// The model file of what was found.
    pub fn model_file(&self, model: &Model) -> ModelFile {
        let values: Vec<f64> = self.parameters.iter().map(|p| p.value).collect();
        let mut file = ModelFile::from_values(model, &values, None, "data");
        for (parameter, found) in file.parameters.iter_mut().zip(&self.parameters) {
            parameter.std = found.std;
            parameter.source = Some(found.source.to_string());
        }
        file.noise_floor = Some(self.noise_floor);
        file.data = self
            .data
            .iter()
            .map(|log| sesc_codegen::DataUsed {
                file: log.file.clone(),
                hash: log.hash.clone(),
                rows: log.rows,
            })
            .collect();
        file
    }
}
