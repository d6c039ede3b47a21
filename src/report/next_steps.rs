//! What to do next, as the console and pages say it.

use std::fmt::Write as _;

use minijinja::{Value, context};

use super::table::wrapped_at;
use sesc_identify::next_steps::{NextStep, Output};

/// Names stand in a column of this width on the console.
const NAME: usize = 17;
/// Letters of a line on the console.
const WIDTH: usize = 100;

/// The steps, a sentence each and its command below; without those whose file was asked for.
pub fn text(steps: &[NextStep], asked: &[Output]) -> String {
    let mut out = String::new();
    let indent = " ".repeat(NAME);
    for step in open(steps, asked) {
        let _ = writeln!(
            out,
            "{:<NAME$}{}",
            "next",
            wrapped_at(&step.sentence(), &indent, WIDTH - NAME)
        );
        if let Some(command) = &step.command {
            let _ = writeln!(out, "{indent}{command}");
        }
    }
    out
}

/// What `next.html` takes.
pub(super) fn context(steps: &[NextStep], asked: &[Output]) -> Vec<Value> {
    let row = |step: &NextStep| {
        context! { what => &step.what, why => &step.why, command => &step.command }
    };
    open(steps, asked).map(row).collect()
}

fn open<'s>(steps: &'s [NextStep], asked: &[Output]) -> impl Iterator<Item = &'s NextStep> {
    let done = move |step: &&NextStep| !step.makes.is_some_and(|output| asked.contains(&output));
    steps.iter().filter(done)
}
