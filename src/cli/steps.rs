//! The commands of next steps: complete, with the names of the files and the only option that is
//! new. Words in capitals stand for files that are still to come.

use std::path::{Path, PathBuf};

use sesc_identify::NextStep;

use super::outputs;
use crate::report::next_steps::{self, Worded};

/// What the commands of next steps are about.
#[derive(Default)]
pub(super) struct About<'a> {
    pub urdf: Option<&'a Path>,
    pub log: Option<&'a Path>,
    /// The link on the ground as it was given: the log does not say it.
    pub support: Option<&'a str>,
}

impl<'a> About<'a> {
    /// About a robot alone.
    pub(super) fn new(urdf: &'a Path) -> About<'a> {
        About {
            urdf: Some(urdf),
            ..About::default()
        }
    }

    /// Steps in words, with their commands.
    pub(super) fn worded<'s>(&self, steps: impl IntoIterator<Item = &'s NextStep>) -> Vec<Worded> {
        next_steps::worded(steps, |step| self.command(step))
    }

    /// The command of a step, where one does it.
    fn command(&self, step: &NextStep) -> Option<String> {
        let given = |path: Option<&Path>, otherwise: &str| {
            // What comes by standard input has no name.
            let path = path.filter(|path| !outputs::is_standard(path));
            path.map_or(otherwise.to_string(), |path| path.display().to_string())
        };
        let (urdf, log) = (given(self.urdf, "URDF"), given(self.log, "LOG"));
        let about_log = |command: &str, support: Option<&str>, more: &[&str]| {
            let words = [command, &urdf, "--data", &log];
            line([&words[..], &on(support), more].concat())
        };
        let diagnose = |more: &[&str]| Some(about_log("diagnose", self.support, more));
        let of_model =
            |command: &str, support: Option<&str>, model: &Option<String>, more: &[&str]| {
                let model = model.iter().flat_map(|file| ["--model", file]);
                let words = [command, &urdf].into_iter().chain(on(support));
                line(words.chain(model).chain(more.iter().copied()))
            };
        match step {
            NextStep::Plan { support } => {
                let words = ["plan", &urdf, "--support", support];
                let more = ["--poses", "40", "--out", "poses.csv"];
                Some(line(words.into_iter().chain(more)))
            }
            NextStep::Fit { support } => Some(about_log("fit", support.as_deref(), &[])),
            NextStep::Diagnose => diagnose(&[]),
            NextStep::KeepModel => diagnose(&["--out", "model.toml"]),
            NextStep::WritePostures { .. } => diagnose(&["--next", "next.csv"]),
            NextStep::TakePostures { .. } => diagnose(&["--then", "NEXT_LOG"]),
            NextStep::GivePrior => diagnose(&["--prior", "PRIOR.toml"]),
            NextStep::RecordHealthy => diagnose(&["--healthy", "HEALTHY_LOG"]),
            NextStep::LookAtPage => diagnose(&["--report", "report.html"]),
            NextStep::DiagnoseLater { log } => Some(line(["diagnose", &urdf, "--data", log])),
            NextStep::CompareLater => {
                let words = ["compare", &log, "LATER_LOG", "--urdf", &urdf];
                Some(line(words.into_iter().chain(on(self.support))))
            }
            NextStep::Generate { support, model, .. } => {
                let to = ["--lang", "c", "--out", "src"];
                Some(of_model("generate", support.as_deref(), model, &to))
            }
            NextStep::Verify {
                support,
                model,
                unsnapped,
            } => {
                let more = if *unsnapped { &["--no-snap"][..] } else { &[] };
                Some(of_model("verify", Some(support), model, more))
            }
            // Those that are done on the robot, each by name: a new step asks for its command.
            NextStep::Repair
            | NextStep::Record { .. }
            | NextStep::Repeat { .. }
            | NextStep::Change
            | NextStep::LookAtRobot
            | NextStep::WidenRange { .. }
            | NextStep::CheckSoles
            | NextStep::CheckLoad { .. }
            | NextStep::CheckJoint { .. }
            | NextStep::CheckRecording
            | NextStep::CheckContact
            | NextStep::CheckLengths
            | NextStep::RecordAgain
            | NextStep::GoOn { .. }
            | NextStep::CheckChanged { .. } => None,
        }
    }
}

/// Say on stderr what to do next, where standard output is for data, scripts or names of files.
pub(super) fn say(steps: &[Worded]) {
    super::messages(next_steps::text(steps).trim_end());
}

/// A file of an option as a command names it.
pub(super) fn named(path: &Option<PathBuf>) -> Option<String> {
    path.as_ref().map(|path| path.display().to_string())
}

fn on(support: Option<&str>) -> Vec<&str> {
    support.map_or(Vec::new(), |link| vec!["--support", link])
}

/// `sesc` and these words, as a shell takes them.
pub(super) fn line<'w>(words: impl IntoIterator<Item = &'w str>) -> String {
    let words = words.into_iter().map(quoted);
    let words = std::iter::once("sesc".to_string()).chain(words);
    words.collect::<Vec<_>>().join(" ")
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@".contains(c);
    match word.chars().all(plain) && !word.is_empty() {
        true => word.to_string(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sesc_identify::Functions;

    #[test]
    fn a_command_is_complete_and_has_the_new_option_alone() {
        let about = About {
            urdf: Some(Path::new("a b.urdf")),
            log: Some(Path::new("-")),
            support: Some("r_sole"),
        };
        let of = |step: NextStep| about.worded([&step])[0].command.clone().unwrap();
        assert_eq!(
            of(NextStep::KeepModel),
            "sesc diagnose 'a b.urdf' --data LOG --support r_sole --out model.toml"
        );
        assert_eq!(
            of(NextStep::CompareLater),
            "sesc compare LOG LATER_LOG --urdf 'a b.urdf' --support r_sole"
        );
        let generate = NextStep::Generate {
            support: None,
            model: Some("it's.toml".to_string()),
            of: Functions::Later,
        };
        assert_eq!(
            of(generate),
            "sesc generate 'a b.urdf' --model 'it'\\''s.toml' --lang c --out src"
        );
        assert_eq!(about.worded([&NextStep::Repair])[0].command, None);
    }
}
