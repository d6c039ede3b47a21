//! What to do next, as data: front ends put it into sentences, and name the command or the call
//! that does it.

/// Something to do next. It may get further variants: a front end words each of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NextStep {
    /// Repair what is wrong with the data, and record the log again.
    Repair,
    /// Choose postures to record on this support link.
    Plan {
        /// The link on the ground.
        support: String,
    },
    /// Record a row in each of the planned postures.
    Record {
        /// Names of the columns of joint positions.
        joints: Vec<String>,
        /// Whether some of them are revolute, rad.
        revolute: bool,
        /// Whether some of them are prismatic, m.
        prismatic: bool,
        /// The link on the ground.
        support: String,
    },
    /// Fit a log on this support link; the log's own where none is given.
    Fit {
        /// The link on the ground.
        support: Option<String>,
    },
    /// Diagnose the log: a fit leaves more than noise.
    Diagnose,
    /// Reach postures once more: nothing else tells what visits of one posture differ by.
    Repeat {
        /// Their numbers in the log.
        poses: Vec<i64>,
    },
    /// Make the proposed change in one place, then record and diagnose a new log.
    Change,
    /// Keep the corrected model in a file.
    KeepModel,
    /// Write the postures of the experiment that tells explanations apart.
    WritePostures {
        /// The experiment, as a phrase.
        experiment: String,
    },
    /// Take the postures that were written, and diagnose their log with the first.
    TakePostures {
        /// The experiment, as a phrase.
        experiment: String,
        /// The file of the postures.
        file: String,
    },
    /// Look which explanation holds: no experiment tells them apart.
    LookAtRobot,
    /// Give the tolerances of masses that are known better.
    GivePrior,
    /// Record a log of the healthy robot, and diagnose this one beside it.
    RecordHealthy,
    /// Keep the log, and compare a later one with it.
    CompareLater,
    /// Record larger ranges of joints: of this one first.
    WidenRange {
        /// The joint.
        joint: String,
        /// Its offsets that the log does not show: `up to 47°`.
        unseen: String,
    },
    /// Look at the page of the diagnosis.
    LookAtPage,
    /// Check that both soles lie flat on one floor.
    CheckSoles,
    /// Check a joint whose gravity moment the gap goes with.
    CheckLoad {
        /// The joint.
        joint: String,
    },
    /// Check a joint whose position the gap goes with.
    CheckJoint {
        /// The joint.
        joint: String,
    },
    /// Check what changed while the log was recorded.
    CheckRecording,
    /// Check the edges of the sole, and what touches the ground beside it.
    CheckContact,
    /// Compare lengths and axes of the URDF with the robot.
    CheckLengths,
    /// Record the log once more.
    RecordAgain,
    /// Generate functions as source code.
    Generate {
        /// The link on the ground, where the model file does not say it.
        support: Option<String>,
        /// The model file, or what the caller calls it.
        model: Option<String>,
        /// Why just these.
        of: Functions,
    },
    /// Compare the generated functions with the reference.
    Verify {
        /// The link on the ground.
        support: String,
        /// The model file whose effects they have.
        model: Option<String>,
    },
    /// Compare them once more, without snapped right angles.
    VerifyUnsnapped {
        /// The link on the ground.
        support: String,
        /// The model file whose effects they have.
        model: Option<String>,
    },
    /// Nothing changed: go on with the earlier of two models.
    GoOn {
        /// What the caller calls it.
        model: String,
    },
    /// Check an effect that changed.
    CheckChanged {
        /// Its name.
        effect: String,
        /// What it acts on; `-` where it acts on the whole.
        target: String,
    },
    /// Diagnose the later of two logs.
    DiagnoseLater {
        /// The log.
        log: String,
    },
}

/// Functions that are to be generated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Functions {
    /// They agree with the reference.
    Verified,
    /// They predicted the rows of a log.
    Predicted,
    /// They are those of the later of two models.
    Later,
}
