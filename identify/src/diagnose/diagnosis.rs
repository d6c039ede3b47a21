//! The whole diagnosis: search, class, verdict, held-out errors, sentences.

use std::borrow::Cow;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use sesc_model::effects::Unit;

use super::findings::{
    About, ActsOn, Blind, Diagnosis, Explained, HeldOut, Last, Leftover, Member, ModelOnLog,
    NextPostures, Quantity, Score, Step, Suspect, Verdict,
};
use super::hypothesis::Term;
use super::leftover::{Misfit, closure_found, is_open, suspects};
use super::model_file::{settle, state_com_apart, unsettled_reason};
use super::outliers::Outliers;
use super::problem::{Fit, Problem, Untold};
use super::remedy::Remedy;
use super::search::{Beyond, Search};
use super::words::{self, Sizes, capital};
use super::{criteria, held_out, noise};
use crate::Error;
use crate::observations::criteria::noise::ROWS;
use crate::observations::noise::NoiseSource;
use crate::observations::postures::rms;
use crate::observations::revisits::Again;
use crate::observations::sample_count::SampleCount;
use crate::threads::each_long;
use crate::watch::Watch;

/// What is missing in the logs; whether functions beyond the list are tried.
///
/// # Errors
/// When `watch` stops the search.
pub(super) fn find<'m>(
    whole_problem: &mut Problem<'m>,
    about: &About,
    beyond: Beyond,
    watch: &mut dyn Watch,
) -> Result<Explained, Error> {
    let mut search = Search::new(whole_problem.clone());
    // Nothing at all is left to tell the noise from.
    let hopeless = match whole_problem.first().why_untold(about.sole) {
        Some(Untold::Few { rows, directions }) => (rows as f64) < directions as f64 + ROWS,
        _ => false,
    };
    let null = search.fit(&[], None);
    // Whatever explains broken data explains nothing.
    let (mut ranked, implausible) = match about.usable && !hopeless {
        true => {
            let mut ranked = search.run(beyond, watch)?;
            // More postures are outliers than outliers can explain.
            let outliers = |fit: &Fit| fit.outliers.as_ref().map_or(0, |o| o.named().len());
            let most = criteria::OUTLIER_SHARE * whole_problem.data().len() as f64;
            ranked.retain(|fit| outliers(fit) as f64 <= most);
            judged(&mut search, ranked, &null)
        }
        false => (vec![null.clone()], None),
    };
    // Something is missing only if that is clearly better than nothing missing.
    if null.score() < ranked[0].score() + criteria::OVER_NOTHING {
        ranked = vec![null.clone()];
    }
    let mut best = ranked[0].clone();
    ranked.retain(|fit| fit.score() <= best.score() + criteria::CLASS_SCORE);
    let near = ranked.iter();
    let near = near.filter(|fit| fit.score() <= best.score() + criteria::OVER_NOTHING);
    let in_all = |term: &&Term| near.clone().all(|fit| fit.terms.contains(term));
    let common: Vec<Term> = best.terms.iter().filter(in_all).cloned().collect();
    let mut class = class(&best, ranked);
    let whole = Arc::clone(&search.problem);
    let problem = &*whole;
    let misfit = misfit(problem, &best);
    // Noise that was taken from what free masses leave says it where far more is left.
    let known = problem.data().noise_source != NoiseSource::Residuals
        || misfit.chi2 > criteria::LEFTOVER_RATIO_OF_RESIDUALS * misfit.expected;
    let crowd = best.terms.len() >= criteria::TOO_MANY_EFFECTS;
    let soles = about.usable && is_open(problem, &best);
    let no_known = known && misfit.is_clear() || soles;
    let untold = problem.first().why_untold(about.sole);
    let untold = untold.filter(|_| about.usable && best.terms.is_empty() && !soles);
    let unexplained = untold.is_none() && (no_known || crowd || implausible.is_some());
    let mut doubtful: Vec<Term> = Vec::new();
    if unexplained {
        // A robot is corrected by what every explanation near the best has; the rest is a guess.
        let certain: Vec<Term>;
        (certain, doubtful) = best
            .terms
            .iter()
            .cloned()
            .partition(|term| common.contains(term));
        if !doubtful.is_empty() {
            best = search.fit(&certain, Some(&best));
        }
        class = vec![best.clone()];
    }
    let baseline = held_out::of_cad(problem);
    let (told, held) = loop {
        let steps = held_out::order(&best, &mut |terms| search.fit(terms, None));
        let (told, steps): (Vec<usize>, Vec<Fit>) = steps.into_iter().unzip();
        let held_out = |step: &Fit| {
            let apart = held_out::apart_on_the_way(problem, step, steps.last().unwrap_or(&null));
            let (own, step) = settle(problem, step);
            held_out::cross_validate(&own, &step, &apart)
        };
        let held: Vec<HeldOut> = [&null].into_iter().chain(&steps).map(held_out).collect();
        // A part of an unexplained gap that is of no help on postures it has not seen is a guess.
        let mut pairs = held.windows(2).zip(&told);
        let helpless = pairs.find(|(pair, _)| pair[1].gap.rmse >= pair[0].gap.rmse);
        let Some((_, place)) = helpless.filter(|_| unexplained) else {
            break (told, held);
        };
        doubtful.push(best.terms[*place].clone());
        best = search.fit(&best.terms_without(*place), Some(&best));
        class = vec![best.clone()];
    };
    let mut evidence = |place: usize| {
        let without = search.fit(&best.terms_without(place), Some(&best));
        settle(problem, &without).1.objective + without.penalty - best.score()
    };
    let evidence: Vec<f64> = told.iter().map(|place| evidence(*place)).collect();
    let counted = search.fitted;
    let (no_effect, alone) = match about.usable && !hopeless && about.scores > 0 {
        true => search.alone(about.scores),
        false => (null.clone(), Vec::new()),
    };
    let scores = alone.iter();
    let scores = scores.filter_map(|fit| score(problem, fit, &no_effect));
    let scores: Vec<Score> = scores.collect();
    let expected = Misfit::of(problem, &null);
    let first = problem.first();
    let raw = baseline.errors.iter().zip(first.inverse_noise());
    let raw = raw.map(|(gap, weight)| (gap * weight).powi(2));
    // Of the robot with CAD masses, in the log that is reported.
    let raw = Misfit {
        chi2: raw.sum(),
        expected: baseline.errors.len() as f64,
        rows_per_sample: first.rows_per_sample(),
    };
    let members = members(problem, &class);
    let places = by_place(problem, &class);
    let (blind, bearing) = detectable(problem, &search.visible);
    let (own, settled) = settle(problem, &best);
    let own = match own {
        Cow::Owned(own) => Some(own),
        Cow::Borrowed(_) => None,
    };
    drop(search);
    *whole_problem = Arc::unwrap_or_clone(whole);
    if let Some(own) = own {
        *whole_problem = own;
        let problem = &*whole_problem;
        // Everything that is shown beside it is seen from the same masses.
        let again = |fit: &Fit| problem.fit(&fit.terms, Some(fit));
        class = class.iter().map(again).collect();
        best = settled;
        if let Some(first) = class.first_mut().filter(|first| first.terms == best.terms) {
            *first = best.clone();
        }
    }
    let problem = &*whole_problem;
    let closure = closure_found(problem, &null, &best);
    let verdict = match (unexplained, best.terms.is_empty(), places.len()) {
        _ if !about.usable => Verdict::Unusable,
        _ if untold.is_some() => Verdict::TooShort,
        (true, _, _) => Verdict::Unexplained,
        (_, true, _) if raw.is_clear() && !expected.is_clear() => Verdict::Absorbed,
        (_, true, _) => Verdict::None,
        (_, _, 1) => Verdict::Named,
        _ => Verdict::Class,
    };
    let steps = steps_told(problem, &best, &told, &held, &evidence);
    let end = held.last().unwrap_or(&baseline);
    let outliers = best.outliers.iter().flat_map(Outliers::named);
    let outliers = outliers.map(|k| problem.data().pose[k]);
    let shift = problem.mass_shift(&best);
    let shift = shift.iter().zip(&problem.first().weight);
    let absorbed = rms(shift.map(|(s, w)| s / w));
    let left = Misfit::of(problem, &best);
    let suspects = match unexplained && left.is_clear() {
        true => suspects(problem, &best),
        false => Vec::new(),
    };
    let diagnosis = Diagnosis {
        verdict,
        health: about.health.clone(),
        warnings: Vec::new(),
        samples: SampleCount::default(),
        motion: problem.data().motion_use.clone(),
        weight: problem.data().weight,
        visits: problem.data().visits,
        closure,
        again: noise::untold(problem, verdict)
            .and_then(|untold| Again::of(untold, problem.first().model, problem.data())),
        masses_are_cad: problem.masses_are_cad,
        sentence: String::new(),
        lead: String::new(),
        robot: about.robot.to_string(),
        support: about.support.to_string(),
        log: about.log.to_string(),
        times: None,
        postures: problem.data().postures,
        postures_used: problem.data().len(),
        prior: about.prior.clone(),
        noise: problem.data().noise,
        noise_floor: problem.data().noise_floor,
        noise_source: problem.data().noise_source,
        baseline: baseline.gap.clone(),
        baseline_chi2: raw.chi2,
        steps,
        last: Last {
            rmse: end.gap.rmse,
            rmse_x: end.gap.rmse_x,
            rmse_y: end.gap.rmse_y,
            left_out: end.left_out,
        },
        indistinguishable: places.iter().map(|own| own.0.clone()).collect(),
        forms: places.into_iter().map(|own| own.1).collect(),
        class: members,
        absorbed_by_masses: absorbed,
        unexplained,
        suspects: {
            let label = |term: &Term| Suspect::Effect(term.label(problem.context()));
            let doubtful = doubtful.iter().map(label);
            suspects
                .iter()
                .map(|(own, _)| own.clone())
                .chain(doubtful)
                .collect()
        },
        implausible,
        model_on_log: ModelOnLog::default(),
        leftover: Leftover {
            chi2: left.chi2,
            expected: left.expected,
            suspect_share: suspects.first().map_or(0.0, |first| first.1),
        },
        outliers: outliers.collect(),
        blind,
        detectable: bearing,
        hypotheses_fitted: counted,
        next_postures: NextPostures::default(),
        left_out_of_urdf: None,
    };
    let mut found = Explained {
        diagnosis,
        written: best.clone(),
        best,
        told,
        class,
        baseline,
        untold,
        scores,
    };
    state_com_apart(problem, &null, &mut found);
    Ok(found)
}

/// Explanations that a robot can have, the best first, those that come near the best by their
/// score where their own masses are, and that of none is better without one of its terms; and what
/// was implausible about a clearly better one, as a sentence. Nothing is missing where no robot has
/// any.
fn judged(search: &mut Search, ranked: Vec<Fit>, nothing: &Fit) -> (Vec<Fit>, Option<String>) {
    let whole = Arc::clone(&search.problem);
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
    let mut settle_all = |batch: Vec<Fit>, ranked: &mut Vec<Fit>| {
        let settled = each_long(batch, |fit| {
            let (own, settled) = settle(problem, &fit);
            let objective = settled.objective;
            (Fit { objective, ..fit }, implausible(&own, &settled))
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
        settle_all(batch, &mut ranked);
    }
    // What a term took of the masses' part, these may take themselves where they have settled.
    while let Some(best) = ranked.first().filter(|best| best.terms.len() > 1).cloned() {
        let places = 0..best.terms.len();
        let fewer = places.map(|k| search.fit(&best.terms_without(k), Some(&best)));
        let mut fewer: Vec<Fit> = fewer.collect();
        fewer.retain(|fit| {
            let known = ranked.iter().any(|own| own.terms == fit.terms);
            !known && implausible(problem, fit).is_none()
        });
        settle_all(fewer, &mut ranked);
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

/// What an explanation leaves. Where masses end far from CAD's, their linearisation about CAD
/// leaves some of it, and not the explanation: more than noise is asked for once they have settled.
fn misfit(problem: &Problem, fit: &Fit) -> Misfit {
    let about_cad = Misfit::of(problem, fit);
    if !about_cad.is_clear() {
        return about_cad;
    }
    let (own, fit) = settle(problem, fit);
    let settled = Misfit::of(&own, &fit);
    if settled.chi2 < about_cad.chi2 {
        return settled;
    }
    about_cad
}

/// What of an explanation no robot has, as a sentence.
fn implausible(problem: &Problem, fit: &Fit) -> Option<String> {
    let context = problem.context();
    let found = words::values(problem, fit);
    let terms = || fit.terms.iter().zip(&found);
    let of = |name: &str| terms().find(|(term, _)| term.name() == name);
    let is_odd = |gain: &Quantity| !criteria::GAIN_BESIDE_UNIT.contains(&gain.value);
    // A gain that is known to no more than itself is none.
    let is_open = |gain: &Quantity| gain.std > gain.value.abs();
    let of_gain = || {
        let (term, gain) = of("sensor_gain")?;
        let clause = words::clause(context, term, gain);
        let any = |holds: fn(&Quantity) -> bool| gain.iter().any(|(_, own)| holds(own));
        // One sensor is not in a wrong unit and, beside that, wrong by half of itself.
        if of("units").is_some() && any(is_odd) {
            let reason = "together they are no unit and no calibration";
            return Some((clause + " beside another unit", reason));
        }
        any(is_open).then_some((clause, "its interval is wider than itself"))
    };
    let of_term = |(term, found): (&Term, &Sizes)| {
        let instance = term.effect()?;
        let values: Vec<f64> = found.iter().map(|(_, own)| own.value).collect();
        let (effect, target) = (instance.effect, &instance.target);
        let reason = effect
            .implausible_reason(context, target, &values)
            .or_else(|| effect.invalid_reason(context, target, &values))?;
        Some((words::clause(context, term, found), reason))
    };
    let of_all = || {
        let reason = unsettled_reason(problem, fit)?;
        Some((words::clauses(problem, fit).join(", with "), reason))
    };
    let of_one = of_gain().or_else(|| terms().find_map(of_term));
    let of_one = of_one.map(|(clause, reason)| (clause, reason.to_string()));
    let (clause, reason) = of_one.or_else(of_all)?;
    let clause = capital(&clause);
    Some(format!(
        "{clause} would explain it best and is implausible: {reason}."
    ))
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

/// The steps in the order in which they close the gap, `told` by their places among the terms.
fn steps_told(
    problem: &Problem,
    best: &Fit,
    told: &[usize],
    held: &[HeldOut],
    evidence: &[f64],
) -> Vec<Step> {
    let (context, values) = (problem.context(), words::values(problem, best));
    let step = |(k, &at): (usize, &usize)| {
        let (term, values) = (&best.terms[at], &values[at]);
        let (rmse_before, rmse_after) = (held[k].gap.rmse, held[k + 1].gap.rmse);
        let way = match rmse_after > rmse_before {
            true => "rises",
            false => "falls",
        };
        Step {
            effect: term.name(),
            target: term.target_name(context),
            acts_on: ActsOn::of(term, context),
            site: term.form().0,
            function: term.form().1,
            parameters: values.iter().copied().collect(),
            fitted: term.fitted(context),
            rmse_before,
            rmse_after,
            evidence: evidence[k],
            sentence: format!(
                "{}: the held-out gap {way} from {:.2} mm to {:.2} mm.",
                capital(&words::clause(context, term, values)),
                1e3 * rmse_before,
                1e3 * rmse_after
            ),
            remedy: Remedy::default(),
        }
    };
    told.iter().enumerate().map(step).collect()
}

/// An effect as it is fitted alone, beside `none`.
fn score(problem: &Problem, fit: &Fit, none: &Fit) -> Option<Score> {
    let context = problem.context();
    let mut found = fit.terms.iter().zip(words::values(problem, fit));
    let (term, values) = found.find(|(term, _)| term.effect().is_some())?;
    Some(Score {
        effect: term.name(),
        target: term.target_name(context),
        parameters: values.into_iter().collect(),
        fitted: term.fitted(context),
        evidence: none.score() - fit.score(),
        chi2: none.objective - fit.objective,
    })
}

/// The explanations of a class, as they are listed.
fn members(problem: &Problem, class: &[Fit]) -> Vec<Member> {
    let context = problem.context();
    let first = class.first().map_or(0.0, Fit::score);
    let member = |fit: &Fit| {
        let subjects = fit.terms.iter().map(|term| term.subject(context));
        Member {
            effects: fit.terms.iter().map(|i| i.label(context)).collect(),
            score_difference: fit.score() - first,
            sentence: capital(&words::clauses(problem, fit).join(", with ")),
            subjects: subjects.collect::<Vec<_>>().join(" with "),
            com_apart: None,
        }
    };
    let some = class.iter().filter(|fit| !fit.terms.is_empty());
    some.map(member).collect()
}

/// The explanations of a class by their effects, those that differ only in the functions at their
/// places once; with the functions of each.
fn by_place(problem: &Problem, class: &[Fit]) -> Vec<(Vec<String>, Vec<String>)> {
    let context = problem.context();
    let place = |term: &Term| match term.is_composed() {
        true => format!("{} {}", term.form().0, term.own_target(context)),
        false => term.label(context),
    };
    let mut seen: Vec<Vec<String>> = Vec::new();
    let mut all: Vec<(Vec<String>, Vec<String>)> = Vec::new();
    for fit in class.iter().filter(|fit| !fit.terms.is_empty()) {
        let places: Vec<String> = fit.terms.iter().map(place).collect();
        let functions = fit.terms.iter().filter(|term| term.is_composed());
        let functions = functions.map(|term| term.form().1);
        match seen.iter().position(|known| *known == places) {
            Some(k) => all[k].1.extend(functions),
            None => {
                let labels = fit.terms.iter().map(|term| term.label(context));
                all.push((labels.collect(), functions.collect()));
                seen.push(places);
            }
        }
    }
    all
}

/// Joint offsets with the size from which this log shows them: those that it hardly shows, the
/// largest first, and those of the joints that carry most of the mass, the smallest first.
fn detectable(problem: &Problem, visible: &[(Term, f64)]) -> (Vec<Blind>, Vec<Blind>) {
    let context = problem.context();
    let reach = context.robot.reach();
    let mut spots = Vec::new();
    for (term, chi2) in visible {
        let Some(instance) = term.effect() else {
            continue;
        };
        if !instance.effect.reports_smallest_detectable() {
            continue;
        }
        let scales = term.scales(context);
        let from = scales[0] * (criteria::VISIBLE / chi2.max(1e-9)).sqrt();
        let parameters = instance.effect.parameters(context, &instance.target);
        let unit = parameters.first().map_or(Unit::One, |p| p.unit);
        spots.push(Blind {
            effect: term.label(context),
            target: context.name_of(&instance.target),
            from,
            size: match unit.shown() {
                _ if unit == Unit::Radian && from > FRAC_PI_2 => "over 90°".to_string(),
                // More than the whole robot reaches.
                _ if unit == Unit::Metre && from > reach => {
                    format!("over {:.0} mm", 1e3 * reach)
                }
                (factor, symbol) => {
                    let digits = (1.0 - (factor * from).log10().floor()).clamp(0.0, 3.0) as usize;
                    let gap = if symbol == "°" { "" } else { " " };
                    format!("{:.digits$}{gap}{symbol}", factor * from)
                }
            },
        });
    }
    spots.sort_by(|a, b| a.from.total_cmp(&b.from));
    let bodies = &context.robot.chain.bodies;
    let carried = |spot: &Blind| {
        let mut bodies = bodies.iter();
        let body = bodies.find(|body| body.joint.as_ref() == Some(&spot.target));
        body.map_or(0.0, |body| body.carried)
    };
    let most = spots.iter().map(carried).fold(0.0, f64::max);
    let half = most.min(0.5 * bodies[0].carried);
    let bearing = spots.iter().filter(|spot| carried(spot) >= half).cloned();
    let bearing = bearing.collect();
    // A smaller offset than this is no gap in what the log shows.
    spots.retain(|spot| spot.from >= criteria::SMALLEST_REPORTED);
    spots.reverse();
    (spots, bearing)
}
