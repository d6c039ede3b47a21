//! What to do next, in sentences: console, pages and JSON print the same list.

use std::fmt::Write as _;
use std::path::Path;

use minijinja::{Value, context};
use serde::Serialize;
use sesc_identify::compare::{Change, Comparison};
use sesc_identify::{Functions, NextStep};
use sesc_model::text::listed;

use super::table::{in_words, wrapped_at};

/// Names stand in a column of this width on the console.
const NAME: usize = 17;
/// Letters of a line on the console.
const WIDTH: usize = 100;
/// Joints that a sentence names.
const NAMED: usize = 3;

/// A step in words.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "NextStep"))]
pub struct Worded {
    /// What to do.
    pub what: String,
    /// What it is good for.
    pub why: String,
    /// Command line, placeholders in capitals; none where no command does it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
}

/// A result with what to do next.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WithSteps<'a, T: Serialize> {
    /// The result.
    #[serde(flatten)]
    pub found: &'a T,
    /// What to do next.
    pub next_steps: &'a [Worded],
}

/// The steps in words; `command` has the command or call of each, where there is one.
pub fn worded<'s>(
    steps: impl IntoIterator<Item = &'s NextStep>,
    command: impl Fn(&NextStep) -> Option<String>,
) -> Vec<Worded> {
    let word = |step| {
        let (said, command) = (sentence(step), command(step));
        let (what, why) = said.rsplit_once(": ").unwrap_or((&said, ""));
        let [what, why] = [what, why].map(String::from);
        Worded { what, why, command }
    };
    steps.into_iter().map(word).collect()
}

/// What to do and, behind the last colon, what it is good for.
fn sentence(step: &NextStep) -> String {
    let said = match step {
        NextStep::Repair => {
            "Repair what is wrong with the data, and record the log again: nothing that is fitted \
             to broken data is a result"
        }
        NextStep::Plan { .. } => {
            "Choose postures to record: a log of them tells most about the parameters"
        }
        NextStep::Record {
            joints,
            revolute,
            prismatic,
            support,
        } => {
            let joints = listed(joints, NAMED);
            let unit = match (revolute, prismatic) {
                (_, false) => "rad",
                (true, true) => "rad, of prismatic joints m",
                (false, true) => "m",
            };
            return format!(
                "Stand in each posture until the robot is still, and log a row of it: `pose`, what \
                 encoders read under the names of the joints ({joints}; {unit}), and the reading as \
                 `cop_x`, `cop_y` (m, in the frame of `{support}`) or as loads of the foot cells \
                 `fsr_1`, `fsr_2`, … (N): a fit reads columns of these names"
            );
        }
        NextStep::Fit { .. } => {
            "Fit the log: it gives the parameters, their uncertainty and the error on postures not \
             seen"
        }
        NextStep::Diagnose => {
            "Diagnose the log: the fit leaves more than noise, and a diagnosis says what the model \
             misses"
        }
        NextStep::Repeat { poses } => {
            let poses: Vec<String> = poses.iter().map(i64::to_string).collect();
            return format!(
                "Reach poses {} once more, and log their readings under the same `pose`: what a \
                 posture that is reached again differs by is noise, which nothing else tells here",
                poses.join(", ")
            );
        }
        NextStep::Change => {
            "Make the change that is proposed, in one place alone, then record a new log and \
             diagnose it: nothing should be missing from it"
        }
        NextStep::KeepModel => {
            "Keep the corrected model: predict, simulate, generate and build.rs read it"
        }
        NextStep::WritePostures { experiment } => {
            return format!(
                "Write the postures that tell most: {experiment}: the explanations predict other \
                 readings there"
            );
        }
        NextStep::TakePostures { experiment, file } => {
            let file = Path::new(file).file_name().unwrap_or_default().display();
            return format!(
                "Take the postures of {file} ({experiment}), and diagnose their log with the \
                 first: the explanations predict other readings there"
            );
        }
        NextStep::LookAtRobot => {
            "Look on the robot which of the explanations holds: no experiment that is known here \
             would tell them apart"
        }
        NextStep::GivePrior => {
            "Give the tolerances of masses that you trust, or weigh links: masses that are known \
             better do not hide an effect"
        }
        NextStep::RecordHealthy => {
            "Record 200 balanced postures of the robot when nothing is wrong with it, before the \
             fault or after its repair, and diagnose this log beside that one: masses are off CAD, \
             and a log of the healthy robot tells them from faults"
        }
        NextStep::CompareLater => {
            "Keep this log, and compare a later one with it: what changes on the robot shows in \
             the difference"
        }
        NextStep::WidenRange { joint, unseen } => {
            return format!(
                "Record postures with larger ranges of joints, first of all `{joint}`: this log \
                 does not show offsets of it {unseen}"
            );
        }
        NextStep::LookAtPage => {
            "Look at the page of the diagnosis: it shows where the gap is, and what it goes with"
        }
        NextStep::CheckSoles => {
            "Check that both soles lie flat on one floor: edges, dirt, carpet, loose soles: the \
             soles lie otherwise than the joints say"
        }
        NextStep::CheckLoad { joint } => {
            return format!(
                "Check `{joint}` under load: play, bending, screws, its cables and connectors: the \
                 gap goes most with the load of this joint"
            );
        }
        NextStep::CheckJoint { joint } => {
            return format!(
                "Check cables and connectors at `{joint}`, its encoder, its screws and covers: the \
                 gap goes most with the position of this joint"
            );
        }
        NextStep::CheckRecording => {
            "Check what changed while the log was recorded: a battery or cover that moved, a \
             sensor that warmed up, another floor: the gap goes most with the place in the log"
        }
        NextStep::CheckContact => {
            "Check the edges of the foot sole, and that no cover, cable or support frame touches \
             the ground or holds the robot: what carries load beside the sole moves the CoP, and \
             no posture predicts it"
        }
        NextStep::CheckLengths => {
            "Compare link lengths and joint axes of the URDF with the robot, and where its battery \
             sits: no effect of the list changes a length"
        }
        NextStep::RecordAgain => {
            "Record the log once more: what comes again belongs to the robot, what does not to the \
             recording"
        }
        NextStep::Generate { of, .. } => match of {
            Functions::Verified => {
                "Write the functions as source code: they are what was compared, in C and in Rust"
            }
            Functions::Predicted => {
                "Write the functions as source code: they compute the same on the robot"
            }
            Functions::Later => {
                "Write the functions of the later model: those of the first are of a robot that \
                 has changed"
            }
        },
        NextStep::Verify { unsnapped, .. } => match unsnapped {
            false => {
                "Compare the functions with an independent reference: it sums the links of the \
                 URDF by itself"
            }
            true => {
                "Compare without snapped angles: what fails even so is no right angle that the \
                 URDF has but nearly"
            }
        },
        NextStep::GoOn { model } => {
            return format!(
                "Go on with {model}: nothing differs from it by more than chance, and what was \
                 generated from it holds"
            );
        }
        NextStep::CheckChanged { effect, target } => {
            let of = match target.as_str() {
                "-" => String::new(),
                target => format!(" of `{target}`"),
            };
            return format!(
                "Check what became of the {}{of} on the robot: it changed by more than chance",
                in_words(effect)
            );
        }
        NextStep::DiagnoseLater { .. } => {
            "Diagnose the later log: a diagnosis says what changes in URDF or controller put it \
             right"
        }
    };
    said.to_string()
}

/// What a comparison of two models leads to, which the caller calls `before` and `after`; of logs,
/// the later one is diagnosed. `support` is named where the command that generates needs it.
pub fn of_comparison(
    found: &Comparison,
    [before, after]: [&str; 2],
    support: Option<String>,
    of_logs: bool,
) -> Vec<NextStep> {
    if !found.changed {
        let model = before.to_string();
        return vec![NextStep::GoOn { model }];
    }
    let first = found.effects.iter().find(|own| own.change != Change::Same);
    let check = first.map(|own| NextStep::CheckChanged {
        effect: own.effect.clone(),
        target: own.target.clone(),
    });
    let after = after.to_string();
    let last = match of_logs {
        true => NextStep::DiagnoseLater { log: after },
        false => NextStep::Generate {
            support,
            model: Some(after),
            of: Functions::Later,
        },
    };
    check.into_iter().chain([last]).collect()
}

/// What a comparison of the functions with the reference leads to: they are right (`pass`), or
/// what was snapped is left out.
pub fn of_verification(support: &str, model: Option<String>, pass: bool) -> NextStep {
    let support = support.to_string();
    match pass {
        true => NextStep::Generate {
            support: Some(support),
            model,
            of: Functions::Verified,
        },
        false => NextStep::Verify {
            support,
            model,
            unsnapped: true,
        },
    }
}

/// The steps on the console, a sentence each and its command below.
pub fn text(steps: &[Worded]) -> String {
    let mut out = String::new();
    let indent = " ".repeat(NAME);
    for step in steps {
        let said = format!("{}: {}.", step.what, step.why);
        let said = wrapped_at(&said, &indent, WIDTH - NAME);
        let _ = writeln!(out, "{:<NAME$}{said}", "next");
        if let Some(command) = &step.command {
            let _ = writeln!(out, "{indent}{command}");
        }
    }
    out
}

/// What `next.html` takes.
pub(super) fn context(steps: &[Worded]) -> Vec<Value> {
    let row = |step: &Worded| {
        context! { what => &step.what, why => &step.why, command => &step.command }
    };
    steps.iter().map(row).collect()
}
