//! The console's account of a diagnosis.

use std::fmt::Write as _;

use super::{DiagnoseReport, parameters, servo, where_to};
use crate::report::table::{Table, count, lines, mm, wrapped};
use crate::report::{about_data, next_steps};
use sesc_identify::diagnose::Diagnosis;
use sesc_model::text::listed;

/// Poses in a row, at most.
const POSES: usize = 12;
/// Spaces as wide as the column of names.
const INDENT: &str = "                 ";

/// The sentence, and what it stands on.
pub fn text(report: &DiagnoseReport<'_>, long: bool) -> String {
    let found = report.found;
    let mut out = format!("{}\n", wrapped(&found.sentence, ""));
    if !found.steps.is_empty() {
        let _ = write!(out, "\n{}", steps(found));
    }
    if found.class.len() > 1 {
        let _ = write!(out, "\n{}", class(found, long));
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
    let titles = [
        "effect",
        "target",
        "parameters",
        "before, mm",
        "after, mm",
        "evidence",
    ];
    let rows = found.steps.iter().map(|step| {
        let [before, after] = [step.rmse_before, step.rmse_after].map(mm);
        let (effect, target) = (step.effect.to_string(), step.target.clone());
        let (parameters, evidence) = (parameters(step).join(", "), format!("{:.0}", step.evidence));
        [effect, target, parameters, before, after, evidence]
    });
    Table::of(&titles, rows)
}

fn class(found: &Diagnosis, long: bool) -> String {
    let titles = [
        "score difference",
        "CoM apart, mm",
        "these data cannot tell apart",
    ];
    let rows = found.class.iter().map(|member| {
        let difference = format!("{:.1}", member.score_difference);
        let apart = member.com_apart.map_or("–".to_string(), mm);
        [difference, apart, member.subjects.clone()]
    });
    Table::of(&titles, rows).listed(long)
}

fn facts(found: &Diagnosis) -> String {
    let last = &found.last;
    let apart = match last.left_out {
        0 => String::new(),
        n => format!(", {} apart", count(n, "posture")),
    };
    let [all, x, y, cad] = [last.rmse, last.rmse_x, last.rmse_y, found.baseline.rmse].map(mm);
    let left = format!(
        "{all} mm held out (x {x}, y {y}{apart}), where CAD leaves {cad} mm; χ² {:.0} where noise \
         leaves {:.0}",
        found.leftover.chi2, found.leftover.expected
    );
    let [noise, floor, absorbed] =
        [found.noise, found.noise_floor, found.absorbed_by_masses].map(mm);
    let source = found.noise_source.phrase();
    let noise = format!("{noise} mm per posture and axis, {source}; {floor} mm with the floor");
    let mut facts = vec![("left", left), ("noise", noise)];
    facts.extend(about_data(
        found.samples.sentence(),
        &found.motion,
        found.again.as_ref(),
        found.closure.as_ref(),
        found.visits.as_ref(),
    ));
    let another = match found.steps.is_empty() {
        true => "",
        false => "another ",
    };
    let prior = &found.prior;
    let masses = format!("take {another}{absorbed} mm of the gap; prior {prior}");
    facts.push(("masses", masses));
    if !found.outliers.is_empty() {
        let poses = listed(&found.outliers, POSES);
        facts.push(("outliers", format!("poses {poses}")));
    }
    lines(facts)
}

/// What to change for each effect, and how the model file is used.
fn changes(report: &DiagnoseReport<'_>) -> String {
    let mut out = String::new();
    let mut fact = |name: &str, text: &str| {
        let text = text.replace('\n', &format!("\n{INDENT}"));
        let _ = writeln!(out, "{name:<16} {text}");
    };
    for step in &report.found.steps {
        let remedy = &step.remedy;
        fact("change", &remedy.sentence);
        if let Some(servo) = servo(remedy) {
            fact("  servo", &servo);
        }
        if let Some(urdf) = &remedy.urdf {
            let before = Some(&*urdf.before).filter(|before| !before.is_empty());
            fact(
                &format!("  URDF line {}", urdf.line),
                before.unwrap_or("new"),
            );
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
