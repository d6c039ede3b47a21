//! Next steps as calls of Python: of a `robot`, with words in capitals for what is still to come.

use sesc::report::next_steps::{self, Worded};
use sesc_identify::NextStep;

/// Steps in words, with their calls; `model` is how a call names a model file.
pub(crate) fn worded<'s>(
    steps: impl IntoIterator<Item = &'s NextStep>,
    model: impl Fn(&str) -> String,
) -> Vec<Worded> {
    next_steps::worded(steps, |step| call(step, &model))
}

/// A text as Python writes it.
pub(crate) fn text(value: &str) -> String {
    let escaped = value.replace('\\', "\\\\").replace('"', "\\\"");
    format!("\"{escaped}\"")
}

fn call(step: &NextStep, model: &impl Fn(&str) -> String) -> Option<String> {
    const DIAGNOSIS: &str = "sesc.diagnose(robot, \"LOG\")";
    let on = |robot: &str, support: &str, file: &Option<String>| {
        let model = file.as_ref().map(|file| format!(", model={}", model(file)));
        format!("{robot}.on({}{})", text(support), model.unwrap_or_default())
    };
    let call = match step {
        NextStep::Plan { support } => format!(
            "sesc.plan(robot, support={}, poses=40).save(\"poses.csv\")",
            text(support)
        ),
        NextStep::Fit { support } => {
            let support = support
                .as_ref()
                .map(|link| format!(", support={}", text(link)));
            format!("sesc.fit(robot, \"LOG\"{})", support.unwrap_or_default())
        }
        NextStep::Diagnose => DIAGNOSIS.to_string(),
        NextStep::KeepModel => format!("{DIAGNOSIS}.save(\"model.toml\")"),
        NextStep::WritePostures { .. } => format!("{DIAGNOSIS}.next_postures().save(\"next.csv\")"),
        NextStep::TakePostures { .. } => {
            "sesc.diagnose(robot, \"LOG\", then=\"NEXT_LOG\")".to_string()
        }
        NextStep::GivePrior => "sesc.diagnose(robot, \"LOG\", prior=\"PRIOR.toml\")".to_string(),
        NextStep::RecordHealthy => {
            "sesc.diagnose(robot, \"LOG\", healthy=\"HEALTHY_LOG\")".to_string()
        }
        NextStep::LookAtPage => format!("{DIAGNOSIS}.report(\"report.html\")"),
        NextStep::DiagnoseLater { log } => format!("sesc.diagnose(robot, {})", text(log)),
        NextStep::CompareLater => {
            format!("sesc.compare({DIAGNOSIS}, sesc.diagnose(robot, \"LATER_LOG\"))")
        }
        NextStep::Generate { support, model, .. } => {
            let support = support.as_deref().unwrap_or("LINK");
            format!("{}.c99(\"src\")", on("robot", support, model))
        }
        NextStep::Verify {
            support,
            model,
            unsnapped,
        } => {
            let robot = match unsnapped {
                true => "sesc.Robot(\"URDF\", snap=False)",
                false => "robot",
            };
            format!("sesc.verify({})", on(robot, support, model))
        }
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
        | NextStep::CheckChanged { .. } => return None,
    };
    Some(call)
}
