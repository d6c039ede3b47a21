//! What to do next, as the console and pages say it.

use std::fmt::Write as _;

use minijinja::{Value, context};

use super::table::wrapped_at;
use sesc_identify::compare::{Change, Comparison};
use sesc_identify::next_steps::{CommandLine, NextStep, Output};

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

/// What comes before the first log of this robot on its support.
pub fn of_inspection(urdf: &str, support: &str) -> NextStep {
    let words = ["plan", urdf, "--support", support];
    let words = [&words[..], &["--poses", "40", "--out", "poses.csv"]].concat();
    NextStep::of_command(
        "Choose postures to record",
        "a log of them tells most about the parameters",
        &words,
    )
}

/// What a comparison of the functions with the reference leads to: they are right (`pass`), or
/// what was snapped is left out.
pub fn of_verification(urdf: &str, support: &str, model: Option<&str>, pass: bool) -> NextStep {
    if pass {
        let why = "they are what was compared, for C; `--lang rust` for Rust";
        return generating(urdf, support, model, why);
    }
    let mut words = vec!["verify", urdf, "--support", support];
    words.extend(model.iter().flat_map(|file| ["--model", file]));
    words.push("--no-snap");
    let why = "what fails even so is no right angle that the URDF has but nearly";
    NextStep::of_command("Compare without snapped angles", why, &words)
}

/// `generate` for this robot: what computes on it what was looked at here.
pub fn generating(urdf: &str, support: &str, model: Option<&str>, why: &str) -> NextStep {
    let mut words = vec!["generate", urdf, "--support", support];
    words.extend(model.iter().flat_map(|file| ["--model", file]));
    words.extend(["--lang", "c", "--out", "src"]);
    NextStep::of_command("Write the functions as source code", why, &words)
}

/// What the difference of two models leads to, which were called `before` and `after`; `line` has
/// the URDF, and options of the command that writes the functions of the later model. Of logs,
/// the later one is diagnosed.
pub fn of_comparison(
    found: &Comparison,
    [before, after]: [&str; 2],
    line: &CommandLine,
    of_logs: bool,
) -> Vec<NextStep> {
    if !found.changed {
        return vec![NextStep::by_hand(
            format!("Go on with {before}"),
            "nothing differs from it by more than chance, and what was generated from it holds",
        )];
    }
    let mut steps = Vec::new();
    let first = found.effects.iter().find(|own| own.change != Change::Same);
    if let Some(own) = first {
        let what = own.effect.replace('_', " ");
        let what = match own.target.as_str() {
            "-" => format!("Check what became of the {what} on the robot"),
            target => format!("Check what became of the {what} of `{target}` on the robot"),
        };
        steps.push(NextStep::by_hand(what, "it changed by more than chance"));
    }
    steps.push(match of_logs {
        true => NextStep::of_command(
            "Diagnose the later log",
            "a diagnosis says what changes in URDF or controller put it right",
            &["diagnose", &line.urdf, "--data", after],
        ),
        false => {
            let mut words = vec!["generate", &line.urdf];
            words.extend(line.options.iter().map(String::as_str));
            words.extend(["--model", after, "--lang", "c", "--out", "src"]);
            NextStep::of_command(
                "Write the functions of the later model",
                "those of the first are of a robot that has changed",
                &words,
            )
        }
    });
    steps
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
