//! The sentences that sum a diagnosis up.

use sesc_model::text::listed;

use super::criteria;
use super::findings::{Diagnosis, Explained, Suspect, Verdict};
use super::model_file::com_sentence;
use super::problem::{Problem, Untold};
use super::words::{self, capital};

/// Names in a row, at most.
const NAMED: usize = 4;
/// Noise of the axes is said of each from this ratio on.
const AXES_APART: f64 = 1.5;

/// Why noise is not told from a misfit, and what would tell it.
fn said_of_noise(untold: Untold) -> String {
    let large = |than: &str| {
        format!(
            "The data cannot tell noise from something missing: nothing states the noise, and what is \
             left would make it as large as {than}. State the noise, or reach postures again; record \
             larger motions, and check the sensor where it is that noisy."
        )
    };
    match untold {
        Untold::Few { rows, directions } => format!(
            "The log is too short: {rows} readings for {directions} directions of the masses leave too \
             few to tell the noise from, so that it is not known whether something is missing. Record \
             more postures, reach some of them again, or state the noise."
        ),
        Untold::Lasting => "The log is too short: what is left lasts for more than a fifth of it, so \
                            that it is not known whether it is noise or something missing. Record at \
                            least five times as long, or postures that the robot holds and reaches \
                            again."
            .to_string(),
        Untold::AsLargeAsSpread => large("the spread of the readings"),
        Untold::LargeForSole => large("a fifth of the sole"),
    }
}

/// Say in a few sentences what a good colleague would, and, for a page, what that adds to a title
/// that names the effects and to a table of errors.
pub(super) fn state(problem: &Problem, found: &mut Explained) {
    let d = &found.diagnosis;
    let mm = |x: f64| format!("{:.2} mm", 1e3 * x);
    let both = |x: f64, y: f64, how: [&str; 2]| format!("{}{}{}{}", mm(x), how[0], mm(y), how[1]);
    let [x, y] = problem.first().noise_by_axis();
    let (gap, noise) = match x.max(y) > AXES_APART * x.min(y) {
        true => (
            both(
                d.baseline.rmse_x,
                d.baseline.rmse_y,
                [" RMS in x and ", " in y"],
            ),
            both(x, y, [" and ", ""]),
        ),
        false => (mm(d.baseline.rmse) + " RMS per axis", mm(d.noise_floor)),
    };
    let before = format!("Simulated and measured CoP differ by {gap}; noise explains {noise}.");
    let mut parts = Vec::new();
    if d.samples.independent < d.samples.rows {
        parts.push(format!("The log has {}.", d.samples.sentence()));
    }
    if d.motion.used {
        parts.push(d.motion.sentence.clone());
    }
    parts.extend(d.health.iter().map(|finding| finding.sentence.clone()));
    parts.extend(d.weight.and_then(|weight| weight.sentence()));
    parts.extend(d.closure.iter().map(|closure| closure.sentence.clone()));
    let mut lead = parts.clone();
    let clauses = words::clauses(problem, &found.best);
    let others = d.class.iter().skip(1);
    let others: Vec<&str> = others.map(|member| &*member.subjects).collect();
    // The title of a page has the effects.
    let mut rest_of_title = None;
    let mut missing = |how: &str, rest: &str| {
        parts.push(format!("Missing: {how}{}; {rest}", clauses.join(", and ")));
        let sizes = words::values(problem, &found.best).into_iter();
        let sizes = sizes.map(|own| words::sizes(&own));
        let sizes = sizes.filter(|own| !own.is_empty()).collect::<Vec<_>>();
        let sizes = (!sizes.is_empty()).then(|| capital(&sizes.join("; ")) + ".");
        rest_of_title = Some(sizes.into_iter().chain([capital(rest)]).collect::<Vec<_>>());
    };
    match d.verdict {
        Verdict::None => parts.push("Nothing is missing that these data could show.".to_string()),
        Verdict::Absorbed => parts.push(format!(
            "Masses within their tolerances take {} of it and leave nothing to name: an effect \
             behind it would not be visible in these data.",
            mm(d.absorbed_by_masses)
        )),
        Verdict::Named => {
            let forms = d.forms.first().map_or(&[][..], |forms| &forms[..]);
            let rest = match forms.split_first() {
                Some((_, others)) if !others.is_empty() => format!(
                    "the place is clear, its form may as well be {}.",
                    listed(others.iter().cloned(), NAMED)
                ),
                _ => "nothing else that is known explains these data.".to_string(),
            };
            missing("", &rest);
        }
        Verdict::Class => {
            let shown = others[..others.len().min(NAMED)].join("; ");
            let more = match others.len().saturating_sub(NAMED) {
                0 => String::new(),
                n => format!("; and {n} more"),
            };
            let it = if clauses.len() > 1 { "them" } else { "it" };
            let rest = format!("these data cannot tell {it} from {shown}{more}.");
            missing("most plainly ", &rest);
        }
        Verdict::TooShort => parts.extend(found.untold.map(said_of_noise)),
        Verdict::Unusable => {
            parts.push("No effect is looked for in these data.".to_string());
        }
        Verdict::Unexplained => {
            parts.extend(d.implausible.clone());
            let open = d.closure.as_ref().is_some_and(|closure| !closure.closes);
            let of_cop = d.leftover.chi2 > criteria::LEFTOVER_RATIO * d.leftover.expected;
            let guessed = d
                .suspects
                .iter()
                .filter(|own| matches!(own, Suspect::Effect(_)));
            let guessed: Vec<String> = guessed.map(ToString::to_string).collect();
            parts.push(match found.best.terms.len() + guessed.len() {
                _ if open && !of_cop => {
                    "No known effect explains how the soles lie on the floor.".to_string()
                }
                few if few < criteria::TOO_MANY_EFFECTS => format!(
                    "{} known effect explains it: χ² is {:.0} where noise leaves {:.0}.",
                    match d.implausible {
                        Some(_) => "Without it no",
                        None => "No",
                    },
                    d.leftover.chi2,
                    d.leftover.expected
                ),
                count => format!(
                    "It takes {count} known effects to imitate it (χ² {:.0}, noise leaves {:.0}): more \
                     likely something is missing that is not known here.",
                    d.leftover.chi2, d.leftover.expected
                ),
            });
            if !clauses.is_empty() {
                let are = if clauses.len() > 1 { "are" } else { "is" };
                parts.push(format!(
                    "{} {are} part of it.",
                    capital(&clauses.join(", and "))
                ));
            }
            if !guessed.is_empty() {
                parts.push(format!(
                    "Perhaps a part of it, too uncertain for the model: {}.",
                    listed(guessed, NAMED)
                ));
            }
            if d.leftover.suspect_share > 0.0
                && let Some(suspect) = d.suspects.first()
            {
                parts.push(format!(
                    "The rest goes most with the {suspect} ({:.0} % of it).",
                    100.0 * d.leftover.suspect_share
                ));
            }
        }
    }
    lead.extend(rest_of_title.unwrap_or_else(|| parts[lead.len()..].to_vec()));
    if !d.steps.is_empty() {
        let of = match d.last.left_out {
            0 => String::new(),
            1 => " (1 posture apart)".to_string(),
            n => format!(" ({n} postures apart)"),
        };
        let with = if d.steps.len() > 1 { "them" } else { "it" };
        parts.push(format!(
            "With {with} the held-out error is {}{of}.",
            mm(d.last.rmse)
        ));
    }
    parts.extend(com_sentence(found));
    let on_log = &d.model_on_log;
    if on_log.stated_rmse > 0.0 && !on_log.agrees {
        parts.push(format!(
            "The model file predicts this log to {} RMS, the diagnosis states {}: the two do not agree.",
            mm(on_log.predicted_rmse),
            mm(on_log.stated_rmse)
        ));
    }
    parts.extend(limits(d));
    parts.insert(0, before);
    found.diagnosis.sentence = parts.join(" ");
    found.diagnosis.lead = lead.join(" ");
}

/// From which size on offsets of the joints that matter show, and which offsets do not.
fn limits(d: &Diagnosis) -> Vec<String> {
    let mut parts = Vec::new();
    match &d.detectable[..] {
        [] => {}
        [only] => parts.push(format!(
            "Offsets of {}, the joint that carries most of the mass, show from {} on.",
            only.target, only.size
        )),
        [best, .., worst] => parts.push(format!(
            "Of the joints that carry most of the mass, {} shows offsets from {} on, {} from {} on.",
            best.target, best.size, worst.target, worst.size
        )),
    }
    if !d.blind.is_empty() {
        let blind = d.blind.iter();
        let blind = blind.map(|own| format!("of {} {}", own.target, own.unseen()));
        parts.push(format!(
            "Could not have been seen: offsets {}.",
            listed(blind, NAMED)
        ));
    }
    parts
}
