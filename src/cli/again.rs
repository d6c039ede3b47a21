//! What was typed, for the command lines of next steps.

use std::ffi::OsString;
use std::path::Path;

use clap::{Arg, CommandFactory as _};
use sesc_identify::next_steps::{CommandLine, NextStep};

use super::{Cli, WORDS, outputs};
use crate::report::next_steps;

/// Options of `fit` that a diagnosis of the same log takes, too. Priors differ: a diagnosis trusts
/// CAD more than a fit does.
pub(super) const TO_DIAGNOSE: &[&str] = &[
    "support",
    "sole-height",
    "no-snap",
    "xacro",
    "both-feet",
    "other-foot",
    "degrees",
    "noise",
    "motion",
    "settle",
];

/// Options of `plan` that a fit of the log takes, too, beside the support link.
pub(super) const TO_FIT: &[&str] = &["no-snap", "xacro", "both-feet", "other-foot"];

/// What a further command on this robot and log begins with: of the options that were typed those
/// that `keep` names. What comes by standard input has no name.
pub(super) fn command_line(
    urdf: Option<&Path>,
    log: Option<&Path>,
    keep: impl Fn(&str) -> bool,
) -> CommandLine {
    let mut line = CommandLine::default();
    let named = |path: &&Path| !outputs::is_standard(path);
    if let Some(urdf) = urdf.filter(named) {
        line.urdf = urdf.display().to_string();
    }
    if let Some(log) = log.filter(named) {
        line.log = log.display().to_string();
    }
    line.options = options(WORDS.get().map_or(&[][..], Vec::as_slice), keep);
    line
}

/// Say on stderr what to do next, where standard output is for data, scripts or names of files.
pub(super) fn next(steps: &[NextStep]) {
    super::message(next_steps::text(steps, &[]).trim_end());
}

/// `generate` for this robot: what computes on it what was looked at here.
pub(super) fn generating(path: &Path, support: &str, model: Option<&Path>, why: &str) -> NextStep {
    let model = model.map(|model| model.display().to_string());
    next_steps::generating(&urdf(path), support, model.as_deref(), why)
}

/// The first of these options that was typed, as it is typed.
pub(super) fn first_typed(options_of: &[&str]) -> Option<String> {
    let words = WORDS.get().map_or(&[][..], Vec::as_slice);
    let typed = options(words, |name| options_of.contains(&name));
    let first = typed.into_iter().next()?;
    Some(first.split('=').next().unwrap_or_default().to_string())
}

/// A URDF as command lines have it.
pub(super) fn urdf(path: &Path) -> String {
    command_line(Some(path), None, |_| false).urdf
}

/// The options among `words`, each with its values, that `keep` names.
fn options(words: &[OsString], keep: impl Fn(&str) -> bool) -> Vec<String> {
    let mut all = Cli::command();
    all.build();
    let words: Vec<String> = words
        .iter()
        .skip(1)
        .map(|word| word.to_string_lossy().into_owned())
        .take_while(|word| word != "--")
        .collect();
    let command = words.iter().find_map(|word| all.find_subcommand(word));
    let Some(command) = command else {
        return Vec::new();
    };
    let mut kept = Vec::new();
    let mut words = words.into_iter().peekable();
    while let Some(word) = words.next() {
        let long = word.strip_prefix("--");
        let long = long.map(|name| name.split('=').next().unwrap_or(name).to_string());
        let known = command.get_arguments().find(|own| match &long {
            Some(long) => own.get_long() == Some(long),
            None => own
                .get_short()
                .is_some_and(|short| word.starts_with(&format!("-{short}"))),
        });
        let Some(known) = known else { continue };
        let named = known.get_long().is_some_and(&keep);
        let more = match word.contains('=') {
            true => 0,
            false => values(known),
        };
        let taken: Vec<String> = (0..more).map_while(|_| words.next()).collect();
        if named {
            kept.push(word);
            kept.extend(taken);
        }
    }
    kept
}

/// How many words behind an option are its values.
fn values(option: &Arg) -> usize {
    match option.get_action().takes_values() {
        true => 1,
        false => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(line: &str, keep: impl Fn(&str) -> bool) -> String {
        let words: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        options(&words, keep).join(" ")
    }

    #[test]
    fn options_are_kept_with_their_values() {
        let line =
            "sesc -q fit op2.urdf --data a.csv --support r_sole --noise=-0.5 --degrees --json";
        let shared = |name: &str| TO_DIAGNOSE.contains(&name);
        assert_eq!(
            kept(line, shared),
            "--support r_sole --noise=-0.5 --degrees"
        );
        let line = "sesc diagnose op2.urdf --prior tight --data a.csv --color never --out m.toml";
        let shaping = |name: &str| !["data", "out", "color"].contains(&name);
        assert_eq!(kept(line, shaping), "--prior tight");
        let line = "sesc plan r.urdf --poses 9 --out - -- --no-snap";
        assert_eq!(kept(line, |name| TO_FIT.contains(&name)), "");
    }
}
