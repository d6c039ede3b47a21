//! Sentences for users, completed by the front end that shows them.
//!
//! A message of the library may name a [`Setting`] of the call that would help.
//! A Rust caller knows it as a field, a shell as an option, Python as a keyword:
//! each words it by [`Message::worded`].
//!
//! What to do next is data: front ends put it into sentences, and name the command or the call
//! that does it.

use std::fmt;

/// Defines [`Setting`], with the name of each.
macro_rules! settings {
    ($($(#[$about:meta])* $setting:ident = $name:literal,)+) => {
        /// Something that a caller can set, as messages name it.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[non_exhaustive]
        pub enum Setting {
            $($(#[$about])* $setting,)+
            /// A feature that this build leaves out.
            Feature(&'static str),
        }

        impl Setting {
            /// The name of the field, which is the name of Python's keyword too.
            pub fn name(self) -> &'static str {
                match self {
                    $(Setting::$setting => $name,)+
                    Setting::Feature(name) => name,
                }
            }
        }
    };
}

settings! {
    /// Unit of the revolute joints in a log.
    Angles = "angles",
    /// Candidates of a plan.
    Candidates = "candidates",
    /// Least height of links above the ground.
    Clearance = "clearance",
    /// What columns of other names are: the name in the log, then ours.
    Columns = "columns",
    /// Deviation of an offset of readings before the data.
    Offset = "offset",
    /// Half the side of a square for the CoP.
    CopBox = "cop_box",
    /// Logs.
    Data = "data",
    /// What encoder ticks add to the noise.
    Floor = "floor",
    /// Folds of the cross-validation.
    Folds = "folds",
    /// Narrower joint limits.
    Limits = "limits",
    /// Distance of the CoP from the edge.
    Margin = "margin",
    /// Standard deviation of a reading.
    Noise = "noise",
    /// Rows per second of a simulated robot that moves.
    Rate = "rate",
    /// Factor files to be combined later.
    Partial = "partial",
    /// Masses that a robot can have.
    Physical = "physical",
    /// The link that is the other sole, where both feet are on the floor.
    OtherFoot = "other_foot",
    /// Whether the motion of the joints counts.
    Motion = "motion",
    /// Postures of a plan or a simulation.
    Poses = "poses",
    /// The tolerances of CAD masses.
    Prior = "prior",
    /// Range of the joints around zero.
    Range = "range",
    /// Loss of a fit that trusts outliers less.
    Robust = "robust",
    /// Rows of stays alone.
    Settle = "settle",
    /// Safety margin of the CoP in standard deviations.
    Sigmas = "sigmas",
    /// Whether decimals of right angles are made exact.
    Snapping = "snapping",
    /// Corners of the sole.
    Sole = "sole",
    /// The link on the ground.
    Support = "support",
    /// Weight of the whole robot.
    TotalMass = "total_mass",
    /// The robot of its type that logs are of.
    Unit = "unit",
}

/// A sentence; [`Display`](fmt::Display) names settings by their fields.
///
/// ```
/// use sesc_identify::{Setting, message};
///
/// let message = message!["3 candidates for 9 postures; raise ", Setting::Candidates];
/// assert_eq!(message.to_string(), "3 candidates for 9 postures; raise `candidates`");
/// let shell = message.worded(|setting| format!("--{}", setting.name()));
/// assert_eq!(shell, "3 candidates for 9 postures; raise --candidates");
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Message(Vec<Piece>);

/// A piece of a [`Message`].
#[derive(Debug, Clone, PartialEq, Eq)]
#[doc(hidden)]
#[non_exhaustive]
pub enum Piece {
    Text(String),
    Setting(Setting),
}

impl Message {
    /// The sentence with settings as the caller's users know them.
    pub fn worded(&self, word: impl Fn(Setting) -> String) -> String {
        let pieces = self.0.iter().map(|piece| match piece {
            Piece::Text(text) => text.clone(),
            Piece::Setting(setting) => word(*setting),
        });
        pieces.collect()
    }

    /// The sentence with `text` before it.
    pub fn after(mut self, text: &str) -> Message {
        self.0.insert(0, Piece::from(text));
        self
    }

    /// The sentence with `piece` behind it.
    pub(crate) fn and(mut self, piece: impl Into<Piece>) -> Message {
        self.0.push(piece.into());
        self
    }

    /// What stands before the first setting.
    pub(crate) fn first_words(&self) -> &str {
        match self.0.first() {
            Some(Piece::Text(text)) => text,
            _ => "",
        }
    }

    #[doc(hidden)]
    pub fn of(pieces: Vec<Piece>) -> Message {
        Message(pieces)
    }
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.worded(|setting| format!("`{}`", setting.name())))
    }
}

impl serde::Serialize for Message {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<P: Into<Piece>> From<P> for Message {
    fn from(piece: P) -> Message {
        Message(vec![piece.into()])
    }
}

impl From<String> for Piece {
    fn from(text: String) -> Piece {
        Piece::Text(text)
    }
}

impl From<&str> for Piece {
    fn from(text: &str) -> Piece {
        Piece::Text(text.to_string())
    }
}

impl From<Setting> for Piece {
    fn from(setting: Setting) -> Piece {
        Piece::Setting(setting)
    }
}

/// A [`Message`] of texts and [`Setting`]s.
#[doc(hidden)]
#[macro_export]
macro_rules! message {
    ($($piece:expr),+ $(,)?) => {
        $crate::Message::of(vec![$($piece.into()),+])
    };
}

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
        /// Whether once more, without snapped right angles.
        unsnapped: bool,
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
