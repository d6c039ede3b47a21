//! The console's account of a diagnosis.

use std::fmt::Write as _;

use super::{DiagnoseReport, count, parameters, servo, where_to};
use crate::report::table::{Table, mm, wrapped};
use crate::report::{next_steps, soles};
use sesc_identify::diagnose::Diagnosis;

/// Explanations and poses in a row, at most.
const LISTED: usize = 8;
const POSES: usize = 12;
/// Spaces as wide as the column of names.
const INDENT: &str = "                 ";

/// The sentence, and what it stands on.
pub fn text(report: &DiagnoseReport<'_>) -> String {
    let found = report.found;
    let mut out = format!("{}\n", wrapped(&found.sentence, ""));
    if !found.steps.is_empty() {
        let _ = write!(out, "\n{}", steps(found));
    }
    if found.class.len() > 1 {
        let _ = write!(out, "\n{}", class(found));
    }
    let _ = write!(out, "\n{}", facts(found));
    if !found.steps.is_empty() {
        let _ = write!(
            out,
            "\n{}\n{}\n",
            wrapped(where_to(found.verdict), ""),
            changes(report)
        );
    }
    if found.class.len() > 1 {
        let _ = writeln!(
            out,
            "{:<16} {}",
            "experiments",
            wrapped(&found.next_postures.why, INDENT)
        );
    }
    out + &next_steps::text(report.next_steps)
}

fn steps(found: &Diagnosis) -> Table {
    let mut table = Table::new(&[
        "effect",
        "target",
        "parameters",
        "before, mm",
        "after, mm",
        "evidence",
    ]);
    for step in &found.steps {
        table.row(&[
            step.effect.to_string(),
            step.target.clone(),
            parameters(step).join(", "),
            mm(step.rmse_before),
            mm(step.rmse_after),
            format!("{:.0}", step.evidence),
        ]);
    }
    table
}

fn class(found: &Diagnosis) -> String {
    let mut table = Table::new(&[
        "these data cannot tell apart",
        "score difference",
        "CoM apart, mm",
    ]);
    for member in found.class.iter().take(LISTED) {
        table.row(&[
            member.effects.join(" + "),
            format!("{:.1}", member.score_difference),
            member.com_apart.map_or("-".to_string(), mm),
        ]);
    }
    let mut out = table.to_string();
    if found.class.len() > LISTED {
        let more = found.class.len() - LISTED;
        let _ = writeln!(out, "and {more} more in JSON");
    }
    out
}

fn facts(found: &Diagnosis) -> String {
    let mut out = String::new();
    let mut fact = |name: &str, text: String| {
        let _ = writeln!(out, "{name:<16} {text}");
    };
    let apart = match found.last.left_out {
        0 => String::new(),
        n => format!(", {} apart", count(n, "posture")),
    };
    fact(
        "left",
        format!(
            "{} mm held out (x {}, y {}{apart}), where CAD leaves {} mm; χ² {:.0} where noise \
             leaves {:.0}",
            mm(found.last.rmse),
            mm(found.last.rmse_x),
            mm(found.last.rmse_y),
            mm(found.baseline.rmse),
            found.leftover.chi2,
            found.leftover.expected
        ),
    );
    fact(
        "noise",
        format!(
            "{} mm per posture and axis, {}; {} mm with the floor",
            mm(found.noise),
            found.noise_source.phrase(),
            mm(found.noise_floor)
        ),
    );
    fact("samples", found.samples.sentence());
    if !found.motion.sentence.is_empty() {
        fact("motion", found.motion.sentence.clone());
    }
    if let Some(again) = &found.again {
        fact("reach again", again.sentence.clone());
    }
    if let Some(closure) = &found.closure {
        fact("soles", soles(closure));
    }
    if let Some(visits) = &found.visits {
        fact("visits", visits.sentence());
    }
    fact(
        "masses",
        format!(
            "take {} mm of the gap{}; prior {}",
            mm(found.absorbed_by_masses),
            if found.steps.is_empty() {
                ""
            } else {
                " beside that"
            },
            found.prior
        ),
    );
    if !found.outliers.is_empty() {
        let poses = found.outliers.iter().take(POSES).map(ToString::to_string);
        let poses = poses.collect::<Vec<_>>().join(", ");
        let more = match found.outliers.len().saturating_sub(POSES) {
            0 => String::new(),
            n => format!(" and {n} more"),
        };
        fact("outliers", format!("poses {poses}{more}"));
    }
    out
}

/// What to change for each effect, and how the model file is used.
fn changes(report: &DiagnoseReport<'_>) -> String {
    let mut out = String::new();
    let mut fact = |name: &str, text: &str| {
        for (k, line) in text.lines().enumerate() {
            let name = if k == 0 { name } else { "" };
            let _ = writeln!(out, "{name:<16} {line}");
        }
    };
    for step in &report.found.steps {
        let remedy = &step.remedy;
        fact("change", &remedy.sentence);
        if let Some(servo) = servo(remedy) {
            fact("  servo", &servo);
        }
        if let Some(urdf) = &remedy.urdf {
            let place = format!("  URDF line {}", urdf.line);
            match urdf.before.is_empty() {
                true => fact(&place, "new"),
                false => fact(&place, &urdf.before),
            }
            fact("  becomes", &urdf.after);
        }
        if let Some(reason) = &remedy.not_in_urdf {
            fact("  not in a URDF", reason);
        }
    }
    if let Some(model) = &report.model_use {
        fact("build.rs", &model.build_rs);
        fact("C", &format!("{}   after {}", model.c, model.generate));
    }
    out
}
