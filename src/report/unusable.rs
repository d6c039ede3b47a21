//! The page of data that cannot be used: what is wrong with them, and nothing that was made of
//! them.

use minijinja::{Error, Value, context};

use super::data::Data;
use super::diagnose::DiagnoseReport;
use super::figures::robot::Marks;
use super::fleet::standing;
use super::health::Posed;
use super::html::render;
use super::next_steps::{self, Worded};
use super::origin::Origin;
use super::table::in_words;
use sesc_identify::fit::Identification;
use sesc_identify::health::Finding;
use sesc_identify::skeleton::Skeleton;
use sesc_model::ModelFile;

/// The page of a fit to such data; `drawn` is its robot where the URDF is at hand, `command`
/// makes the page again.
///
/// # Errors
/// A fault of the page's template.
pub fn page_of_fit(
    found: &Identification,
    next: &[Worded],
    drawn: Option<&Skeleton>,
    command: &str,
) -> Result<String, Error> {
    let postures = found.postures.to_string();
    let lines = vec![("rows", found.samples.sentence()), ("postures", postures)];
    let about = [&*found.robot, &found.support];
    let origin = Origin::of_fit(found, command);
    page(about, lines, &found.health, next, origin, drawn)
}

/// The page of a diagnosis of such data; `made` says of which robot and data it is, `drawn` is
/// the robot, `command` makes the page again.
///
/// # Errors
/// A fault of the page's template.
pub fn page_of_diagnosis(
    report: &DiagnoseReport<'_>,
    made: &ModelFile,
    drawn: Option<&Skeleton>,
    command: &str,
) -> Result<String, Error> {
    let (found, next) = (report.found, report.next_steps);
    let postures = found.postures.to_string();
    let lines = vec![("rows", found.samples.sentence()), ("postures", postures)];
    let about = [&*found.robot, &found.support];
    let origin = Origin::of_diagnosis(found, made, command);
    page(about, lines, &found.health, next, origin, drawn)
}

/// The robot, with the joints marked that a finding is about.
fn card(skeleton: &Skeleton, health: &[Finding]) -> Value {
    let (mut marks, mut said) = (Marks::default(), Vec::new());
    for finding in health {
        if let Some(body) = skeleton.carried_by(&finding.target) {
            marks.joints.push((body, finding.target.clone()));
            let kind = in_words(finding.kind.name());
            said.push(format!("`{}` ({kind})", finding.target));
        }
    }
    standing(
        skeleton,
        marks,
        &said,
        "No finding is about a joint.",
        Posed::of(health).shown(),
    )
}

fn page(
    [robot_name, support]: [&str; 2],
    lines: Vec<(&'static str, String)>,
    health: &[Finding],
    next: &[Worded],
    origin: Origin<'_>,
    drawn: Option<&Skeleton>,
) -> Result<String, Error> {
    let data = Data {
        lines,
        dofs: &[],
        used: &[],
        postures: Vec::new(),
        health,
        first_posed: drawn.map(|_| 0),
    };
    let context = context! {
        robot => drawn.map(|drawn| card(drawn, health)),
        robot_name,
        support,
        log => origin.logs.iter().map(|log| log.0).collect::<Vec<&str>>().join(" + "),
        data => data.context(),
        next => next_steps::context(next),
        origin => origin.context(),
    };
    render("unusable.html", context)
}
