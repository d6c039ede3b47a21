//! What a diagnosis says, what it leaves to be done, and what it was made of.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};
use sesc_model::effects::{EffectContext, Fitted, Target};

use super::hypothesis::{FREE_MASSES, Term};
use super::problem::{Fit, Untold};
use crate::NextStep;
use crate::feet::ClosureFound;
use crate::health::Finding;
pub use crate::logs::Quantity;
use crate::logs::Weight;
use crate::observations::motion_use::MotionUse;
use crate::observations::noise::NoiseSource;
use crate::observations::repeats::Visits;
use crate::observations::revisits::Again;
use crate::observations::sample_count::SampleCount;

/// What a diagnosis comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Simulation and data agree.
    None,
    /// One explanation.
    Named,
    /// Several that these data cannot tell apart.
    Class,
    /// Masses within their tolerances take the gap: no effect is visible.
    Absorbed,
    /// Nothing known explains it.
    Unexplained,
    /// The data cannot tell noise from what is missing.
    TooShort,
    /// The data are broken: no effect is looked for.
    Unusable,
}

impl Verdict {
    /// Its name in JSON and in tables.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::None => "none",
            Verdict::Named => "named",
            Verdict::Class => "class",
            Verdict::Absorbed => "absorbed",
            Verdict::Unexplained => "unexplained",
            Verdict::TooShort => "too_short",
            Verdict::Unusable => "unusable",
        }
    }
}

/// How far readings are from predictions, m.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Gap {
    /// RMS over both axes, m.
    pub rmse: f64,
    /// RMS along x.
    pub rmse_x: f64,
    /// RMS along y.
    pub rmse_y: f64,
    /// Mean of reading − prediction.
    pub bias: [f64; 2],
}

/// One effect of the explanation, in the order in which they close the gap.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Step {
    /// Name of the effect: `joint_offset`.
    pub effect: &'static str,
    /// Joint, link or cell that it acts on; `-` where it acts on the whole.
    pub target: String,
    /// The same by its kind.
    #[serde(skip)]
    pub acts_on: ActsOn,
    /// Where it adds something: joint, sensor, ground, load or cell; `record` where it is of the
    /// log.
    pub site: String,
    /// What it adds there, as a formula.
    pub function: String,
    /// Its parameters by name, which ends in the unit: `offset_rad`.
    pub parameters: BTreeMap<&'static str, Quantity>,
    /// What is fitted for each of them: zero where there is no effect.
    #[serde(skip)]
    pub fitted: BTreeMap<&'static str, Fitted>,
    /// Held-out error without it, m; with the steps before.
    pub rmse_before: f64,
    /// Held-out error with it, m; the next step begins there.
    pub rmse_after: f64,
    /// Penalised rise of −2 log evidence without it.
    pub evidence: f64,
    /// The step as a sentence.
    pub sentence: String,
    /// What to change about it.
    pub remedy: Remedy,
}

/// One effect as the whole explanation of a log.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Score {
    /// Name of the effect: `joint_offset`.
    pub effect: &'static str,
    /// Joint, link or cell that it acts on; `-` where it acts on the whole.
    pub target: String,
    /// Its parameters by name, which ends in the unit: `offset_rad`.
    pub parameters: BTreeMap<&'static str, Quantity>,
    /// What is fitted for each of them: zero where there is no effect.
    pub fitted: BTreeMap<&'static str, Fitted>,
    /// Fall of −2 log evidence with it.
    pub evidence: f64,
    /// Fall of χ² with it.
    pub chi2: f64,
}

/// What of the robot an effect acts on.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum ActsOn {
    /// No part of it: sensor, ground, masses or record.
    Whole,
    /// Joints by name.
    Joints(Vec<String>),
    /// Every revolute joint.
    AllJoints,
    /// A link by name.
    Link(String),
    /// A foot cell, from 0.
    Cell(usize),
}

impl ActsOn {
    /// What a term acts on.
    pub(super) fn of(term: &Term, context: &EffectContext) -> ActsOn {
        let tree = &context.robot.tree;
        let joint = |j: usize| tree.dofs[j].joint.clone();
        match term.effect().map(|instance| &instance.target) {
            Some(Target::Joint(j)) => ActsOn::Joints(vec![joint(*j)]),
            Some(Target::Joints(a, b)) => ActsOn::Joints(vec![joint(*a), joint(*b)]),
            Some(Target::AllJoints) => ActsOn::AllJoints,
            Some(Target::Link(link)) => ActsOn::Link(tree.links[*link].name.clone()),
            Some(Target::Cell(k)) => ActsOn::Cell(*k),
            _ => ActsOn::Whole,
        }
    }
}

/// A number before and after.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(inline))]
pub struct Change<T> {
    /// The value as it is.
    pub before: T,
    /// The value as it should be.
    pub after: T,
}

/// Elements of the URDF before and after.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct UrdfChange {
    /// Line of the first, from 1.
    pub line: usize,
    /// The lines as they are; one tag a line, empty where something is added.
    pub before: String,
    /// The lines as they should be.
    pub after: String,
}

/// What to change about one effect. Servo settings take in every effect on their joint.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Remedy {
    /// With sign and unit; `true angle of l_knee = reading + 1.517°`.
    pub sentence: String,
    /// Ticks at zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub servo_zero: Option<Change<i32>>,
    /// 1 or −1, where it changes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub servo_sign: Option<Change<i32>>,
    /// Ticks a turn, where they change.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub servo_resolution: Option<Change<f64>>,
    /// Stroke of a tick, m; of a prismatic joint.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub servo_metres_per_tick: Option<Change<f64>>,
    /// What a URDF holds of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub urdf: Option<UrdfChange>,
    /// Why a URDF holds none of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_in_urdf: Option<String>,
}

/// Held-out errors of the whole explanation, m.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Last {
    /// Held-out, m.
    pub rmse: f64,
    /// RMS along x.
    pub rmse_x: f64,
    /// RMS along y.
    pub rmse_y: f64,
    /// Postures not judged by; outliers, and joints on the unlikely side of a dead band.
    pub left_out: usize,
}

/// What the diagnosis states of the log, and what its model file predicts, both in sample:
/// neither says how good the model is elsewhere.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ModelOnLog {
    /// Gap that the diagnosis leaves, m.
    pub stated_rmse: f64,
    /// Gap to what the file predicts, m.
    pub predicted_rmse: f64,
    /// Poses left out of both: outliers, and where only the log knows the side of a loose joint.
    pub left_out: Vec<i64>,
    /// Whether the two agree to 1 %.
    pub agrees: bool,
}

/// A complete explanation that the data allow.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Member {
    /// Effects with their targets: `joint_offset:l_knee`.
    pub effects: Vec<String>,
    /// −2 log evidence above the best.
    pub score_difference: f64,
    /// The explanation as a sentence.
    pub sentence: String,
    /// Effects as people call them, each with its label.
    #[serde(skip)]
    pub subjects: String,
    /// RMS CoM distance from the first, m.
    #[serde(rename = "com_apart_m")]
    pub com_apart: Option<f64>,
}

/// An effect with the size from which this log shows it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Blind {
    /// The effect with its target: `joint_offset:l_knee`.
    pub effect: String,
    /// The joint.
    #[serde(skip)]
    pub target: String,
    /// Smallest detectable offset, rad or m.
    pub from: f64,
    /// The same as people read it.
    pub size: String,
}

impl Blind {
    /// The offsets that do not show: `up to 47°`.
    pub fn unseen(&self) -> String {
        format!("up to {}", self.size.trim_start_matches("over "))
    }
}

/// What the explanation leaves over.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Leftover {
    /// χ² of the residuals.
    pub chi2: f64,
    /// χ² that noise alone would leave.
    pub expected: f64,
    /// Share that goes with the first suspect.
    pub suspect_share: f64,
}

/// What an unexplained gap may have to do with.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(into = "String")]
#[non_exhaustive]
pub enum Suspect {
    /// Position of a joint.
    Position(String),
    /// Gravity moment of a joint.
    Moment(String),
    /// Place in the log.
    Place,
    /// An effect with its target: others explain as much, or it is of no help on held-out postures.
    Effect(String),
}

impl fmt::Display for Suspect {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Suspect::Position(joint) => write!(f, "position of {joint}"),
            Suspect::Moment(joint) => write!(f, "gravity moment of {joint}"),
            Suspect::Place => f.write_str("place in the log"),
            Suspect::Effect(label) => f.write_str(label),
        }
    }
}

impl From<Suspect> for String {
    fn from(suspect: Suspect) -> String {
        suspect.to_string()
    }
}

/// One experiment and what it would do to the class.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ExperimentProposal {
    /// What to do, as a sentence.
    pub what: String,
    /// Explanations that it would exclude.
    pub splits: usize,
    /// χ² against the nearest excluded, then each member.
    pub separations: Vec<f64>,
}

/// What next postures are for, and where they were written.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NextPostures {
    /// Why, as a sentence.
    pub why: String,
    /// The file of its postures, where one is written.
    pub file: Option<String>,
    /// What was compared, the best first.
    pub experiments: Vec<ExperimentProposal>,
}

/// Everything that is said of a log. Lengths in m.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Diagnosis {
    /// What the diagnosis comes to.
    pub verdict: Verdict,
    /// What is wrong with the data.
    pub health: Vec<Finding>,
    /// Warnings about the logs as sentences.
    pub warnings: Vec<String>,
    /// Independent samples in the log.
    pub samples: SampleCount,
    /// How motion of the joints counted.
    pub motion: MotionUse,
    /// What the robot weighs by the total force; none of a log without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<Weight>,
    /// Scatter between visits of a posture; none if no posture was visited again.
    pub visits: Option<Visits>,
    /// How both soles lie on one floor; none of a log of one foot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub closure: Option<ClosureFound>,
    /// Postures to reach once more, where nothing tells the noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub again: Option<Again>,
    /// Masses before the log are CAD's: a log of the healthy robot would tell them.
    #[serde(skip)]
    pub masses_are_cad: bool,
    /// The whole result in sentences.
    pub sentence: String,
    /// What it adds to a title that names the effects and to a table of errors.
    #[serde(skip)]
    pub lead: String,
    /// File of the robot's description.
    pub robot: String,
    /// Link on the ground.
    pub support: String,
    /// Name of the log.
    pub log: String,
    /// First and last `t`, s; none of logs without `t`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub times: Option<[f64; 2]>,
    /// Postures in the log.
    pub postures: usize,
    /// Postures that were used; long logs are thinned out.
    pub postures_used: usize,
    /// Tolerances of CAD masses.
    pub prior: String,
    /// Noise without the floor, m.
    pub noise: f64,
    /// The same with the floor, m.
    pub noise_floor: f64,
    /// Where the noise was taken from.
    pub noise_source: NoiseSource,
    /// Errors of CAD without effects.
    pub baseline: Gap,
    /// χ² of these errors.
    pub baseline_chi2: f64,
    /// The explanation, effect by effect.
    pub steps: Vec<Step>,
    /// Held-out errors of the whole explanation.
    #[serde(rename = "final")]
    pub last: Last,
    /// Effects of each of them, those of one place that differ in form alone once.
    pub indistinguishable: Vec<Vec<String>>,
    /// Of each of these the functions beyond the list that its place may have, as formulas.
    pub forms: Vec<Vec<String>>,
    /// Explanations that data cannot tell apart.
    pub class: Vec<Member>,
    /// RMS that masses take, m.
    pub absorbed_by_masses: f64,
    /// Whether known effects leave too much.
    pub unexplained: bool,
    /// What an unexplained gap goes with, the likeliest first, then effects that not every
    /// explanation near the best has; not in the model file.
    pub suspects: Vec<Suspect>,
    /// Why the best explanation is impossible.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub implausible: Option<String>,
    /// The model file on its own log.
    pub model_on_log: ModelOnLog,
    /// What the explanation leaves over.
    pub leftover: Leftover,
    /// Poses that are rather outliers.
    pub outliers: Vec<i64>,
    /// Joint offsets that this log could not have shown, the largest first.
    pub blind: Vec<Blind>,
    /// Smallest detectable offsets of the joints that carry most of the mass, the best seen first.
    pub detectable: Vec<Blind>,
    /// How many explanations were fitted.
    pub hypotheses_fitted: usize,
    /// Experiments that separate the class.
    pub next_postures: NextPostures,
    /// Parts of the explanation that the corrected URDF does not hold, a sentence each; none
    /// without a corrected URDF.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_out_of_urdf: Option<Vec<String>>,
}

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
        let followed = self
            .suspects
            .iter()
            .find_map(|suspect| match suspect.clone() {
                Suspect::Place => Some(NextStep::CheckRecording),
                Suspect::Position(joint) => Some(NextStep::CheckJoint { joint }),
                Suspect::Moment(joint) => Some(NextStep::CheckLoad { joint }),
                Suspect::Effect(_) => None,
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

/// Errors of predicted readings, m; outliers, and postures that a dead band
/// leaves on the side that gravity does not favour, are counted apart.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct HeldOut {
    pub gap: Gap,
    /// reading − prediction per entry; NaN where left out.
    pub errors: Vec<f64>,
    pub left_out: usize,
}

/// A diagnosis with what reports, models and experiments are made from.
pub(super) struct Explained {
    pub diagnosis: Diagnosis,
    /// The explanation, fitted.
    pub best: Fit,
    /// What the model file holds: the explanation, or one of its class that leaves the CoM where
    /// CAD has it.
    pub written: Fit,
    /// The place of each step among its terms.
    pub told: Vec<usize>,
    /// All that the data allow, the best first.
    pub class: Vec<Fit>,
    pub baseline: HeldOut,
    /// Why noise is not told from a misfit, where nothing is named.
    pub untold: Option<Untold>,
    /// Every effect alone, the best first, as many as were asked for.
    pub scores: Vec<Score>,
}

/// Names for the report.
pub(super) struct About<'a> {
    pub robot: &'a str,
    pub support: &'a str,
    pub log: &'a str,
    pub prior: String,
    /// What is wrong with the data themselves.
    pub health: Vec<Finding>,
    /// Whether effects can be looked for in them.
    pub usable: bool,
    /// How many effects are fitted alone.
    pub scores: usize,
    /// Corners of the sole, m, where the URDF has its shape.
    pub sole: Option<[[f64; 2]; 2]>,
}
