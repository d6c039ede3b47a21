//! The page of data that cannot be used: what is wrong with them, and nothing that was made of
//! them.

use minijinja::{Error, Value, context};

use super::data::Data;
use super::health::Posed;
use super::html::render;
use super::next_steps::{self, Worded};
use super::origin::Origin;
use super::robot::{Card, Marked};
use super::table::in_words;
use sesc_identify::fit::SampleCount;
use sesc_identify::health::Finding;
use sesc_identify::skeleton::Skeleton;

/// The robot, with the joints marked that a finding is about.
fn card(skeleton: &Skeleton, health: &[Finding]) -> Value {
    let mut marked = Marked::default();
    for finding in health {
        let what = in_words(finding.kind.name());
        marked.point(skeleton, "", &finding.target, &what);
    }
    let (nothing, postures) = ("No finding is about a joint.", Posed::of(health).shown());
    Card::standing(skeleton, marked, nothing, postures).context()
}

/// The page of such data of a robot on `support`, `samples` of so many `postures`; `drawn` is the
/// robot.
///
/// # Errors
/// A fault of the page's template.
pub fn page(
    origin: &Origin<'_>,
    support: &str,
    (samples, postures): (&SampleCount, u64),
    health: &[Finding],
    next: &[Worded],
    drawn: &Skeleton,
) -> Result<String, Error> {
    let data = Data {
        lines: vec![
            ("rows", samples.sentence()),
            ("postures", postures.to_string()),
        ],
        dofs: &[],
        used: &[],
        postures: Vec::new(),
        health,
        first_posed: Some(0),
    };
    let context = context! {
        robot => card(drawn, health),
        support,
        data => data.context(),
        next => next_steps::context(next),
        origin => origin.context(),
    };
    render("unusable.html", context)
}
