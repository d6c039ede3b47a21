//! The sentences that sum a diagnosis up.

use super::com_spread;
use super::criteria;
use super::findings::{Explained, Verdict};
use super::problem::Problem;
use super::words::{self, capital};

/// Names in a row, at most.
const NAMED: usize = 4;

/// What a good colleague would say, in a few sentences.
pub(super) fn sentence(problem: &Problem, found: &Explained) -> String {
    let d = &found.diagnosis;
    let mm = |x: f64| format!("{:.2} mm", 1e3 * x);
    let mut said = vec![format!(
        "Simulated and measured CoP differ by {} RMS; noise explains {}.",
        mm(d.baseline.rmse),
        mm(d.noise_floor)
    )];
    if d.samples.independent < d.samples.rows {
        said.push(format!("The log has {}.", d.samples.sentence()));
    }
    if d.motion.used {
        said.push(d.motion.sentence.clone());
    }
    said.extend(d.health.iter().map(|finding| finding.sentence.clone()));
    said.extend(d.closure.iter().map(|closure| closure.sentence.clone()));
    let values = words::values(problem, &found.best);
    let clauses: Vec<String> = found
        .best
        .terms
        .iter()
        .zip(&values)
        .map(|(i, v)| words::clause(&problem.context, i, v))
        .collect();
    let others: Vec<String> = d
        .class
        .iter()
        .skip(1)
        .map(|m| m.effects.join(" + "))
        .collect();
    match d.verdict {
        Verdict::None => said.push("Nothing is missing that these data could show.".to_string()),
        Verdict::Absorbed => said.push(format!(
            "Masses within their tolerances take {} of it and leave nothing to name: an effect \
             behind it would not be visible in these data.",
            mm(d.absorbed_by_masses)
        )),
        Verdict::Named => said.push(format!(
            "Missing: {}; nothing else that is known explains these data.",
            clauses.join(", and ")
        )),
        Verdict::Class => {
            let shown = others
                .iter()
                .take(NAMED)
                .cloned()
                .collect::<Vec<_>>()
                .join("; ");
            let more = match others.len().saturating_sub(NAMED) {
                0 => String::new(),
                n => format!("; and {n} more"),
            };
            said.push(format!(
                "Missing: most plainly {}; these data cannot tell it from {shown}{more}.",
                clauses.join(", and ")
            ));
        }
        Verdict::TooShort => {
            let [rows, directions] = problem.too_few().unwrap_or_default();
            said.push(format!(
                "The log is too short: {rows} readings for {directions} directions of the masses leave \
                 too few to tell the noise from, so that it is not known whether something is \
                 missing. Record more postures, reach some of them again, or state the noise."
            ));
        }
        Verdict::Unusable => {
            said.push("No effect is looked for in these data.".to_string());
        }
        Verdict::Unexplained => {
            said.extend(d.implausible.clone());
            let open = d.closure.as_ref().is_some_and(|closure| !closure.closes);
            let of_cop = d.leftover.chi2 > criteria::LEFTOVER_RATIO * d.leftover.expected;
            said.push(match found.best.terms.len() {
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
                said.push(format!(
                    "{} {are} part of it.",
                    capital(&clauses.join(", and "))
                ));
            }
            if let Some(suspect) = d.suspects.first() {
                said.push(format!(
                    "The rest goes most with the {suspect} ({:.0} % of it).",
                    100.0 * d.leftover.suspect_share
                ));
            }
        }
    }
    if !d.steps.is_empty() {
        let of = match d.last.left_out {
            0 => String::new(),
            1 => " (1 posture apart)".to_string(),
            n => format!(" ({n} postures apart)"),
        };
        said.push(format!(
            "With it the held-out error is {}{of}.",
            mm(d.last.rmse)
        ));
    }
    said.extend(com_spread::sentence(found));
    let on_log = &d.model_on_log;
    if on_log.stated_rmse > 0.0 && !on_log.agrees {
        said.push(format!(
            "The model file predicts this log to {} RMS, the diagnosis states {}: the two do not agree.",
            mm(on_log.predicted_rmse),
            mm(on_log.stated_rmse)
        ));
    }
    let blind: Vec<String> = d
        .blind
        .iter()
        .take(NAMED)
        .map(|b| format!("{} {}", b.target, b.size))
        .collect();
    if !blind.is_empty() {
        said.push(format!(
            "Smallest detectable offsets: {}.",
            blind.join(", ")
        ));
    }
    said.join(" ")
}
