//! What a diagnosis leaves to be done, by its verdict.

use super::FREE_MASSES;
use super::findings::{Diagnosis, Suspect, Verdict};
use crate::NextStep;
use crate::observations::revisits::Again;

impl Diagnosis {
    /// The verdict in things to do, the most useful first.
    pub fn next_steps(&self) -> Vec<NextStep> {
        let mut steps = match self.verdict {
            Verdict::Unusable => return vec![NextStep::Repair],
            Verdict::TooShort => vec![NextStep::Plan {
                support: self.support.clone(),
            }],
            Verdict::Unexplained => self.checks(),
            Verdict::Class => vec![self.tell_apart(), NextStep::KeepModel],
            Verdict::Named => vec![NextStep::Change, NextStep::KeepModel],
            Verdict::Absorbed => vec![NextStep::GivePrior],
            Verdict::None => {
                let widest = self.blind.first().map(|blind| NextStep::WidenRange {
                    joint: blind.target.clone(),
                    unseen: blind.unseen(),
                });
                [NextStep::CompareLater].into_iter().chain(widest).collect()
            }
        };
        let masses = |effects: &Vec<String>| effects.iter().any(|one| one == FREE_MASSES);
        if self.masses_are_cad && self.indistinguishable.iter().any(masses) {
            steps.insert(0, NextStep::RecordHealthy);
        }
        steps.extend(self.again.as_ref().map(Again::step));
        if self.verdict != Verdict::None {
            steps.push(NextStep::LookAtPage);
        }
        steps
    }

    /// How to tell the explanations of a class apart.
    fn tell_apart(&self) -> NextStep {
        let next = &self.next_postures;
        let best = next.experiments.first().filter(|best| best.splits > 0);
        match (best.map(|best| best.what.clone()), next.file.clone()) {
            (Some(experiment), Some(file)) => NextStep::TakePostures { experiment, file },
            (Some(experiment), None) => NextStep::WritePostures { experiment },
            (None, _) => NextStep::LookAtRobot,
        }
    }

    /// What to check on the robot where nothing known explains the log, by what is left over.
    fn checks(&self) -> Vec<NextStep> {
        let open = self.closure.as_ref().filter(|closure| !closure.closes);
        let followed = self.suspects.first().map(|suspect| match suspect {
            Suspect::Place => NextStep::CheckRecording,
            Suspect::Position(joint) => NextStep::CheckJoint {
                joint: joint.clone(),
            },
            Suspect::Moment(joint) => NextStep::CheckLoad {
                joint: joint.clone(),
            },
        });
        let always = [
            NextStep::CheckContact,
            NextStep::CheckLengths,
            NextStep::RecordAgain,
        ];
        let soles = open.map(|_| NextStep::CheckSoles);
        soles.into_iter().chain(followed).chain(always).collect()
    }
}
