//! The whole diagnosis: search, class, verdict, held-out errors, sentences.

use std::sync::Arc;

use super::closure;
use super::com_spread;
use super::criteria;
use super::findings::{About, Diagnosis, Explained, Gap, ModelOnLog, NextPostures, Step, Verdict};
use super::held_out::{self, HeldOut};
use super::hypothesis::Term;
use super::leftover::Misfit;
use super::noise;
use super::outliers::Outliers;
use super::problem::{ALL, Fit, Problem};
use super::search::Search;
use super::stated;
use super::statements::{detectable, last, members, outliers, rest, told};
use super::words::{self, capital};
use crate::Error;
use crate::observations::noise::NoiseSource;
use crate::observations::revisits::Again;
use crate::observations::samples::Samples;
use crate::threads::each_long;
use crate::watch::Watch;

/// What is missing in the logs.
///
/// # Errors
/// When `watch` stops the search.
pub fn find<'m>(
    whole_problem: &mut Problem<'m>,
    about: &About,
    watch: &mut dyn Watch,
) -> Result<Explained, Error> {
    let mut search = Search::new(whole_problem.clone());
    let visible = search.visible().to_vec();
    let too_few = whole_problem.first().too_few();
    // Nothing at all is left to tell the noise from.
    let hopeless =
        too_few.is_some_and(|[rows, directions]| rows < directions + noise::LEFT_AT_LEAST);
    let none = search.fit(&[], None);
    // Whatever explains broken data explains nothing.
    let (mut ranked, implausible) = match about.usable && !hopeless {
        true => {
            let mut ranked = search.run(watch)?;
            ranked.retain(|fit| !too_many_outliers(fit));
            judged(&mut search, ranked, &none)
        }
        false => (vec![none.clone()], None),
    };
    // Something is missing only if that is clearly better than nothing missing.
    if none.score() < ranked[0].score() + criteria::OVER_NOTHING {
        ranked = vec![none];
    }
    let mut best = ranked[0].clone();
    ranked.retain(|fit| fit.score() <= best.score() + criteria::CLASS_SCORE);
    let mut class = class(&best, ranked);
    let whole = search.problem();
    let problem = &*whole;
    let misfit = misfit(problem, &best);
    // Noise that was taken from what free masses leave says it where far more is left.
    let known = problem.first().data.noise_source != NoiseSource::Residuals
        || misfit.chi2 > criteria::LEFTOVER_RATIO_OF_RESIDUALS * misfit.expected;
    let crowd = best.terms.len() >= criteria::TOO_MANY_EFFECTS;
    let soles = about.usable && closure::is_open(problem, &best);
    let no_known = known && misfit.is_clear() || soles;
    let is_short = about.usable && too_few.is_some() && best.terms.is_empty() && !soles;
    let unexplained = !is_short && (no_known || crowd || implausible.is_some());
    if unexplained {
        class = vec![best.clone()];
    }
    let baseline = held_out::of_cad(problem);
    let steps = held_out::order(&best, &mut |terms| search.fit(terms, None));
    let null = search.fit(&[], None);
    let last_step = steps.last().unwrap_or(&null);
    let held_out = |step: &Fit| {
        let apart = held_out::apart_on_the_way(problem, step, last_step);
        match stated::settle(problem, step) {
            Some((own, step)) => held_out::cross_validate(&own, &step, &apart),
            None => held_out::cross_validate(problem, step, &apart),
        }
    };
    let start = held_out(&null);
    let held: Vec<HeldOut> = steps.iter().map(held_out).collect();
    let evidence: Vec<f64> = best
        .terms
        .iter()
        .map(|term| {
            let others: Vec<Term> = best.terms.iter().filter(|i| *i != term).cloned().collect();
            settled_score(problem, &search.fit(&others, Some(&best))) - best.score()
        })
        .collect();
    let counted = search.fitted;
    let expected = Misfit::of(problem, &null);
    let raw = raw_misfit(problem);
    let members = members(problem, &class);
    let settled = stated::settle(problem, &best);
    drop(search);
    *whole_problem = Arc::unwrap_or_clone(whole);
    if let Some((own, settled)) = settled {
        *whole_problem = own;
        let problem = &*whole_problem;
        // Everything that is shown beside it is seen from the same masses.
        let again = |fit: &Fit| problem.fit(&fit.terms, Some(fit), ALL);
        class = class.iter().map(again).collect();
        best = settled;
        if let Some(first) = class.first_mut().filter(|first| first.terms == best.terms) {
            *first = best.clone();
        }
    }
    let problem = &*whole_problem;
    let closure = closure::said(problem, &null, &best);
    let verdict = match (unexplained, best.terms.is_empty(), class.len()) {
        _ if !about.usable => Verdict::Unusable,
        _ if is_short => Verdict::TooShort,
        (true, _, _) => Verdict::Unexplained,
        (_, true, _) if raw.is_clear() && !expected.is_clear() => Verdict::Absorbed,
        (_, true, _) => Verdict::None,
        (_, _, 1) => Verdict::Named,
        _ => Verdict::Class,
    };
    let told = told(problem, &best, &steps, &start, &held, &evidence);
    let (told, steps): (Vec<usize>, Vec<Step>) = told.into_iter().unzip();
    let (leftover, suspects) = rest(problem, &best, unexplained);
    let (blind, bearing) = detectable(problem, &visible);
    let diagnosis = Diagnosis {
        verdict,
        health: about.health.clone(),
        warnings: Vec::new(),
        samples: Samples::default(),
        motion: problem.first().data.motion_use.clone(),
        visits: problem.first().data.visits,
        closure,
        again: noise::untold(problem, verdict)
            .and_then(|untold| Again::of(untold, problem.first().model, &problem.first().data)),
        masses_are_cad: problem.masses_are_cad,
        sentence: String::new(),
        lead: String::new(),
        robot: about.robot.to_string(),
        support: about.support.to_string(),
        log: about.log.to_string(),
        times: None,
        postures: problem.first().data.postures,
        postures_used: problem.first().data.len(),
        prior: about.prior.clone(),
        noise: problem.first().data.noise,
        noise_floor: problem.first().data.noise_floor,
        noise_source: problem.first().data.noise_source,
        baseline: Gap {
            rmse: baseline.rmse,
            rmse_x: baseline.rmse_x,
            rmse_y: baseline.rmse_y,
            bias: baseline.bias,
        },
        baseline_chi2: raw.chi2,
        steps,
        last: last(held.last().unwrap_or(&start)),
        indistinguishable: members.iter().map(|one| one.effects.clone()).collect(),
        class: members,
        absorbed_by_masses: absorbed(problem, &best),
        unexplained,
        suspects,
        implausible,
        model_on_log: ModelOnLog::default(),
        leftover,
        outliers: outliers(problem, &best),
        blind,
        detectable: bearing,
        hypotheses_fitted: counted,
        next_postures: NextPostures::default(),
        left_out_of_urdf: None,
    };
    let mut found = Explained {
        diagnosis,
        best,
        told,
        class,
        baseline,
    };
    com_spread::state(problem, &mut found);
    Ok(found)
}

/// Explanations that a robot can have, the best first, those that come near the best by their
/// score where their own masses are, and that of none is better without one of its terms; and what
/// was implausible about a clearly better one, as a sentence. Nothing is missing where no robot has
/// any.
fn judged(search: &mut Search, ranked: Vec<Fit>, nothing: &Fit) -> (Vec<Fit>, Option<String>) {
    let whole = search.problem();
    let problem = &*whole;
    let mut better: Option<(f64, String)> = None;
    let mut pass_over = |score: f64, sentence: String| {
        if better.as_ref().is_none_or(|(best, _)| score < *best) {
            better = Some((score, sentence));
        }
    };
    let mut plausible = Vec::new();
    for fit in ranked {
        match implausible(problem, &fit) {
            None => plausible.push(fit),
            Some(sentence) => pass_over(fit.score(), sentence),
        }
    }
    let mut waiting = plausible.into_iter().peekable();
    let mut ranked: Vec<Fit> = Vec::new();
    let mut settle = |batch: Vec<Fit>, ranked: &mut Vec<Fit>| {
        let settled = each_long(batch, |fit| match stated::settle(problem, &fit) {
            Some((own, settled)) => {
                let sentence = implausible(&own, &settled);
                let objective = settled.objective;
                (Fit { objective, ..fit }, sentence)
            }
            None => (fit, None),
        });
        for (fit, sentence) in settled {
            match sentence {
                None => ranked.push(fit),
                Some(sentence) => pass_over(fit.score(), sentence),
            }
        }
        ranked.sort_by(|a, b| a.score().total_cmp(&b.score()));
    };
    while ranked.is_empty()
        && let Some(first) = waiting.peek()
    {
        let near = first.score() + criteria::CLASS_SCORE;
        let mut batch = Vec::new();
        while batch.len() < criteria::LISTED
            && let Some(fit) = waiting.next_if(|fit| fit.score() <= near)
        {
            batch.push(fit);
        }
        settle(batch, &mut ranked);
    }
    // What a term took of the masses' part, these may take themselves where they have settled.
    while let Some(best) = ranked.first().filter(|best| best.terms.len() > 1).cloned() {
        let fewer = (0..best.terms.len()).map(|k| {
            let mut terms = best.terms.clone();
            terms.remove(k);
            search.fit(&terms, Some(&best))
        });
        let mut fewer: Vec<Fit> = fewer.collect();
        fewer.retain(|fit| {
            let known = ranked.iter().any(|own| own.terms == fit.terms);
            !known && implausible(problem, fit).is_none()
        });
        settle(fewer, &mut ranked);
        if ranked[0].terms == best.terms {
            break;
        }
    }
    if ranked.is_empty() {
        ranked.push(nothing.clone());
    }
    let first = ranked[0].score().min(nothing.score());
    let better = better.filter(|(score, _)| score + criteria::CLASS_SCORE < first);
    (ranked, better.map(|(_, sentence)| sentence))
}

/// The score of a fit where its own masses are.
fn settled_score(problem: &Problem, fit: &Fit) -> f64 {
    let settled = stated::settle(problem, fit);
    settled.map_or(fit.objective, |(_, own)| own.objective) + fit.penalty
}

/// What an explanation leaves. Where masses end far from CAD's, their linearisation about CAD
/// leaves some of it, and not the explanation: more than noise is asked for once they have settled.
fn misfit(problem: &Problem, fit: &Fit) -> Misfit {
    let about_cad = Misfit::of(problem, fit);
    if !about_cad.is_clear() {
        return about_cad;
    }
    let settled = stated::settle(problem, fit);
    let settled = settled.map(|(own, fit)| Misfit::of(&own, &fit));
    let less = settled.filter(|settled| settled.chi2 < about_cad.chi2);
    less.unwrap_or(about_cad)
}

/// What of an explanation no robot has, as a sentence.
fn implausible(problem: &Problem, fit: &Fit) -> Option<String> {
    let context = &problem.first().context;
    let found = words::values(problem, fit);
    let of = |name: &str| {
        fit.terms
            .iter()
            .zip(&found)
            .find(|(term, _)| term.name() == name)
    };
    // One sensor is not in a wrong unit and, beside that, wrong by half of itself.
    if let (Some(_), Some((term, gain))) = (of("units"), of("sensor_gain"))
        && gain
            .iter()
            .any(|gain| !criteria::GAIN_BESIDE_UNIT.contains(&gain.value))
    {
        let clause = capital(&words::clause(context, term, gain));
        return Some(format!(
            "{clause} beside another unit would explain it best and is implausible: together they \
             are no unit and no calibration."
        ));
    }
    fit.terms.iter().zip(&found).find_map(|(term, found)| {
        let instance = term.effect()?;
        let values: Vec<f64> = found.iter().map(|v| v.value).collect();
        let (effect, target) = (instance.effect, &instance.target);
        let reason = effect
            .implausible_reason(context, target, &values)
            .or_else(|| effect.invalid_reason(context, target, &values))?;
        let clause = capital(&words::clause(context, term, found));
        Some(format!(
            "{clause} would explain it best and is implausible: {reason}."
        ))
    })
}

/// The best first, without those that only add to another.
fn class(best: &Fit, near: Vec<Fit>) -> Vec<Fit> {
    let mut class: Vec<Fit> = vec![best.clone()];
    for fit in near {
        let same = fit.terms == best.terms;
        // More of the same is an answer of its own only if it is as good.
        let adds = |other: &Fit| {
            let all = other.terms.iter().all(|i| fit.terms.contains(i));
            let difference = fit.score() - other.score();
            all && other.terms.len() < fit.terms.len() && difference > criteria::ADDED_EFFECT
        };
        if !same && !fit.terms.is_empty() && !class.iter().any(adds) && !best.terms.is_empty() {
            class.push(fit);
        }
    }
    class.truncate(criteria::LISTED);
    class
}

/// Whether more postures are outliers than outliers can explain.
fn too_many_outliers(fit: &Fit) -> bool {
    let share = |o: &Outliers| o.named().len() as f64 / o.chance.len() as f64;
    fit.outliers
        .as_ref()
        .is_some_and(|o| share(o) > criteria::OUTLIER_SHARE)
}

/// χ² of the robot with CAD masses in the log that is reported.
fn raw_misfit(problem: &Problem) -> Misfit {
    let block = &problem.first();
    let out = block.evaluate(&[], &[], &block.data.q, &block.data.posture_context);
    let gaps = block.residual(&out);
    let whole = gaps
        .iter()
        .enumerate()
        .map(|(row, gap)| gap * block.widened[row % 2]);
    Misfit {
        chi2: whole.map(|gap| gap.powi(2)).sum(),
        expected: out.len() as f64,
        rows_per_sample: block.rows_per_sample(),
    }
}

fn absorbed(problem: &Problem, best: &Fit) -> f64 {
    let shift = problem.mass_shift(best);
    crate::observations::postures::rms(
        shift
            .iter()
            .zip(&problem.first().weight)
            .map(|(s, w)| s / w),
    )
}
