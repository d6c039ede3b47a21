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
use sesc_identify::fit::Identification;
use sesc_identify::health::Finding;
use sesc_identify::skeleton::Skeleton;
use sesc_model::ModelFile;

/// What the page is about.
struct Broken<'a> {
    robot: &'a str,
    support: &'a str,
    postures: u64,
    /// How many rows there are, and what they are worth.
    rows: String,
    health: &'a [Finding],
    next: &'a [Worded],
    origin: Origin<'a>,
    /// The robot, where its URDF is at hand.
    drawn: Option<&'a Skeleton>,
}

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
    let times = found.data.iter().filter_map(|log| log.times);
    page(&Broken {
        robot: &found.robot,
        support: &found.support,
        postures: found.postures,
        rows: found.samples.sentence(),
        health: &found.health,
        next,
        origin: Origin {
            robot: [&found.robot, &found.hash],
            logs: found
                .data
                .iter()
                .map(|log| (&*log.file, log.rows, &*log.hash))
                .collect(),
            times: times.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]),
            command,
        },
        drawn,
    })
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
    let found = report.found;
    page(&Broken {
        robot: &found.robot,
        support: &found.support,
        postures: found.postures as u64,
        rows: found.samples.sentence(),
        health: &found.health,
        next: report.next_steps,
        origin: Origin {
            robot: [&made.robot, &made.hash],
            logs: made
                .data
                .iter()
                .map(|log| (&*log.file, log.rows, &*log.hash))
                .collect(),
            times: found.times,
            command,
        },
        drawn,
    })
}

/// The robot, with the joints marked that a finding is about.
fn card(skeleton: &Skeleton, health: &[Finding]) -> Value {
    let (mut marks, mut said) = (Marks::default(), Vec::new());
    for finding in health {
        if let Some(body) = skeleton.carried_by(&finding.target) {
            marks.joints.push((body, finding.target.clone()));
            let kind = finding.kind.name().replace('_', " ");
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

fn page(broken: &Broken<'_>) -> Result<String, Error> {
    let data = Data {
        lines: vec![
            ("rows", broken.rows.clone()),
            ("postures", broken.postures.to_string()),
        ],
        dofs: &[],
        used: &[],
        postures: Vec::new(),
        health: broken.health,
        first_posed: broken.drawn.map(|_| 0),
    };
    let context = context! {
        robot => broken.drawn.map(|drawn| card(drawn, broken.health)),
        robot_name => broken.robot,
        support => broken.support,
        log => broken.origin.logs.iter().map(|log| log.0).collect::<Vec<&str>>().join(" + "),
        data => data.context(),
        next => next_steps::context(broken.next),
        origin => broken.origin.context(),
    };
    render("unusable.html", context)
}
