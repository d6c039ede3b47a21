//! From gathered logs to parameters with their uncertainty, observability and held-out error.

use super::criteria::{ELSEWHERE_M, FAR, GROSSLY, SURELY};
use nalgebra::DVector;
use sesc_model::Model;

use super::gather::{Fold, Gathered};
use super::identification::{Identification, ParameterFound, Settings};
use super::offset::{self, Wide};
use super::physical;
use super::prior::Tolerances;
use super::summary::{
    bodies, complete, correlations, deviations, height, held_out, oddities, over_range, parameters,
    range_error, row_norms, unobservable,
};

use crate::health;
use crate::lsq::solve::{Beyond, information, of_rows};
use crate::observations::criteria::repeats::UNLIKELY;
use crate::observations::noise::{FreeResiduals, Noise, NoiseSource, widening};

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
    let (within, df_within) = match gathered.correlated {
        true => (0.0, 0),
        false => gathered.repeats.set_aside(),
    };
    let left = FreeResiduals {
        // Where visits differ, readings of one visit say nothing of what is left.
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
        match physical::constrain(model, rows, sigma, prior, limits, &params) {
            Ok(found) => (found.params, Some(found.masses)),
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
    let held_out = held_out(gathered, |others| {
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
    if held_out.rmse > FAR * noise.floor && !guessed {
        warnings.push(format!(
            "postures the fit did not see are off by {:.1} times the noise: too few postures, or \
             the model misses something",
            held_out.rmse / noise.floor
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
        held_out_rmse: held_out.rmse,
        held_out_error: held_out.error,
        folds: held_out.folds,
        in_sample_rmse: rms(plain.residual_sum(&params_of_readings), plain.rows()),
        cad_rmse: rms(plain.residual_sum(&cad), plain.rows()),
        expected_error_data: rms(data_error, plain.rows()),
        expected_error_range: match &settings.over_range {
            Some(over_range) => range_error(over_range, &covariance),
            None => range_error(&over_range(model, settings.range), &covariance),
        },
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
