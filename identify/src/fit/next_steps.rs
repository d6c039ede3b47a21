//! What a fit leaves to be done.

use super::identification::Identification;
use crate::next_steps::{CommandLine, NextStep};
use crate::observations::revisits::Again;

/// The most useful first; empty where nothing is left to do.
pub(super) fn after(found: &Identification, line: &CommandLine) -> Vec<NextStep> {
    if !found.is_usable() {
        return vec![NextStep::repair()];
    }
    let mut steps = Vec::new();
    if found.misses_something() {
        steps.push(
            NextStep::by_hand(
                "Diagnose the log",
                "the fit leaves more than noise, and a diagnosis says what the model misses",
            )
            .by(line.of("diagnose", "")),
        );
    }
    steps.extend(found.again.as_ref().map(Again::step));
    steps
}
