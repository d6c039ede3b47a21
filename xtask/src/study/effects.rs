//! Effects hidden alone, in pairs and triples, outside the list, and nothing: what `sesc
//! diagnose` says is judged by what was hidden.

use std::path::{Path, PathBuf};
use std::process::Command;

use sesc_test_support::diagnoser::Diagnoser;
use sesc_test_support::examine::Failure;
use sesc_test_support::hidden::Effect;
use sesc_test_support::survey::{self, Outcome};
use sesc_test_support::table;
use sesc_test_support::trial::Trial;

use super::{Asked, side_by_side};

/// Goals, shares of each effect, and the answers that are not right as a class; `--only` hides
/// one effect alone. A log without an answer is named on stderr and left out.
pub(super) fn table(asked: &Asked, root: &Path, jobs: usize) -> Result<String, Failure> {
    let diagnoser = Diagnoser { sesc: build(root)? };
    let mut choice = survey::everything();
    if let Some(name) = asked.only {
        choice.only = Some(Effect::named(name).ok_or_else(|| format!("no effect `{name}`"))?);
    }
    let questions = survey::questions(asked.logs as usize, &choice);
    let outcomes = side_by_side(questions.len(), jobs, |k| {
        let trial = Trial::draw(questions[k], &choice, asked.seed + k as u64);
        let outcome = survey::ask(&diagnoser, &trial, asked.folder);
        match &outcome {
            Ok(outcome) => eprintln!(
                "{:4} {:5.1} s  chi2 {:8.0}  {}  ->  {}",
                k + 1,
                outcome.seconds,
                outcome.chi2,
                outcome.description,
                outcome.judgement.said
            ),
            Err(error) => eprintln!("{:4} no answer: {error}", k + 1),
        }
        outcome.ok()
    })?;
    let outcomes: Vec<Outcome> = outcomes.into_iter().flatten().collect();
    Ok(format!(
        "Effects are hidden in virtual robots, `sesc diagnose` reads the logs and is judged by the \
         truth; {} of {} logs were answered.\n\nGoals\n\n{}\n\
         Effects hidden alone: shares of the logs in percent (named exactly, with the right target, \
         the truth among the listed explanations, right as a class, postures put aside below 1.1 \
         noise floors, reported as unexplained), then the number of listed explanations\n\n{}\n\
         Answers that are not right as a class\n\n{}",
        outcomes.len(),
        questions.len(),
        table::goal_table(&table::goals(&outcomes)),
        table::effect_table(&outcomes),
        table::mistakes(&outcomes)
    ))
}

/// The command line in release, built from here.
fn build(root: &Path) -> Result<PathBuf, Failure> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .args(["build", "--release", "--package", "sesc", "--bin", "sesc"])
        .current_dir(root)
        .status()?;
    if !status.success() {
        return Err("sesc does not build".into());
    }
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or(root.join("target"), PathBuf::from);
    Ok(target.join("release/sesc"))
}
