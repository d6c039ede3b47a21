//! What a diagnosis leaves to be done, by its verdict.

use super::findings::{Diagnosis, Suspect, Verdict};
use crate::next_steps::{CommandLine, NextStep, Output};
use crate::observations::revisits::Again;

/// The verdict in things to do, the most useful first. `proposal` is the experiment that tells
/// most, where one tells anything.
pub(super) fn after(
    found: &Diagnosis,
    proposal: Option<&str>,
    line: &CommandLine,
) -> Vec<NextStep> {
    let again = |more: &str| line.of("diagnose", more);
    let mut steps = Vec::new();
    match found.verdict {
        Verdict::Unusable => {
            return vec![NextStep::repair()];
        }
        Verdict::Unexplained => steps.extend(by_hand(found)),
        Verdict::Class => {
            steps.push(apart(found, proposal, again));
            steps.push(keep(again));
        }
        Verdict::Named => {
            steps.push(NextStep::by_hand(
                "Make the change that is proposed, in one place alone, then record a new log and diagnose it",
                "nothing should be missing from it",
            ));
            steps.push(keep(again));
        }
        Verdict::Absorbed => steps.push(
            NextStep::by_hand(
                "Give the tolerances of masses that you trust, or weigh links",
                "masses that are known better do not hide an effect",
            )
            .by(line.without("--prior").of("diagnose", "--prior PRIOR.toml")),
        ),
        Verdict::None => {
            steps.push(later(line));
            steps.extend(larger(found));
        }
    }
    steps.extend(found.again.as_ref().map(Again::step));
    if found.verdict != Verdict::None {
        steps.push(
            NextStep::by_hand(
                "Look at the page of the diagnosis",
                "it shows where the gap is, and what it goes with",
            )
            .by(again("--report report.html"))
            .makes(Output::Page),
        );
    }
    steps
}

/// How to tell the explanations of a class apart.
fn apart(found: &Diagnosis, proposal: Option<&str>, again: impl Fn(&str) -> String) -> NextStep {
    let why = "the explanations predict other readings there";
    match (proposal, &found.next_postures.file) {
        (Some(what), Some(file)) => NextStep::by_hand(
            format!("Take the postures of {file} ({what}), and diagnose their log with the first"),
            why,
        )
        .by(again("--then NEXT_LOG")),
        (Some(what), None) => {
            NextStep::by_hand(format!("Write the postures that tell most: {what}"), why)
                .by(again("--next next.csv"))
                .makes(Output::Postures)
        }
        (None, _) => NextStep::by_hand(
            "Look on the robot which of the explanations holds",
            "no experiment that is known here would tell them apart",
        ),
    }
}

fn keep(again: impl Fn(&str) -> String) -> NextStep {
    NextStep::by_hand(
        "Keep the corrected model",
        "predict, simulate, generate and build.rs read it",
    )
    .by(again("--out model.toml"))
    .makes(Output::Model)
}

/// A robot that is as simulated stays so, or does not.
fn later(line: &CommandLine) -> NextStep {
    let line = line.without("--then").without("--servos");
    NextStep::by_hand(
        "Keep this log, and compare a later one with it",
        "what changes on the robot shows in the difference",
    )
    .by(line.compared())
}

/// What else could have been seen.
fn larger(found: &Diagnosis) -> Option<NextStep> {
    let first = found.blind.first()?;
    let name = first.effect.rsplit(':').next().unwrap_or(&first.effect);
    Some(NextStep::by_hand(
        format!("Record postures with larger ranges of joints, first of all `{name}`"),
        format!("this log shows an offset of it from {} on", first.size),
    ))
}

/// What to check on the robot where nothing known explains the log, by what is left over.
fn by_hand(found: &Diagnosis) -> Vec<NextStep> {
    let mut steps = Vec::new();
    if found
        .closure
        .as_ref()
        .is_some_and(|closure| !closure.closes)
    {
        steps.push(NextStep::by_hand(
            "Check that both soles lie flat on one floor: edges, dirt, carpet, loose soles",
            "the soles lie otherwise than the joints say",
        ));
    }
    match found.suspects.first() {
        Some(Suspect::Moment(joint)) => steps.push(NextStep::by_hand(
            format!("Check `{joint}` under load: play, bending, screws, its cables and connectors"),
            "the gap goes most with the load of this joint",
        )),
        Some(Suspect::Position(joint)) => steps.push(NextStep::by_hand(
            format!("Check cables and connectors at `{joint}`, its encoder, its screws and covers"),
            "the gap goes most with the position of this joint",
        )),
        Some(Suspect::Place) => steps.push(NextStep::by_hand(
            "Check what changed while the log was recorded: a battery or cover that moved, a \
             sensor that warmed up, another floor",
            "the gap goes most with the place in the log",
        )),
        None => {}
    }
    steps.push(NextStep::by_hand(
        "Check the edges of the foot sole, and that no cover, cable or support frame touches the \
         ground or holds the robot",
        "what carries load beside the sole moves the CoP, and no posture predicts it",
    ));
    steps.push(NextStep::by_hand(
        "Compare link lengths and joint axes of the URDF with the robot, and where its battery sits",
        "no effect of the list changes a length",
    ));
    steps.push(NextStep::by_hand(
        "Record the log once more",
        "what comes again belongs to the robot, what does not to the recording",
    ));
    steps
}
