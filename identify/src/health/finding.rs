//! What is said of data: kinds, targets, sentences; and what a figure shows of them: one number of
//! each row, which rows are meant, and how the robot stood in them.

use serde::{Deserialize, Serialize};

/// What is wrong with data; those kinds first that make data unusable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Kind {
    /// The CoP does not move on either axis.
    CopConstant,
    /// The CoP does not move on one axis, `x` or `y`.
    CopAxisDead,
    /// The readings are of another link, the target.
    OtherFoot,
    /// The z axis of the support frame is not the normal of the sole.
    FrameTurned,
    /// Rows of the CoP and of the joints do not belong together.
    RowsShuffled,
    /// The encoder of a joint, the target, does not move, and the joint does.
    EncoderStuck,
    /// A joint, the target, moves faster than it can.
    JointLeaps,
    /// The CoP, or one axis, the target, stays the same for a while and the joints move.
    CopFrozen,
    /// Readings lie where no CoP can be.
    CopOutsideSole,
    /// The total force is not the weight of the robot.
    ForceUnlikeWeight,
    /// The sole of the other foot, the target, is flat on the floor, too, which nobody said.
    BothFeetFlat,
    /// Rows repeat earlier ones to the last digit.
    RowsCopied,
    /// A channel of the CoP or a cell, the target, ends at one value or moves in coarse steps.
    ChannelSaturated,
    /// Stated noise is far larger than what is left.
    NoiseOverstated,
    /// Nothing stands on the sensor for a while, or on a cell, the target, ever.
    ContactLost,
}

impl Kind {
    /// Its name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Kind::CopConstant => "cop_constant",
            Kind::CopAxisDead => "cop_axis_dead",
            Kind::OtherFoot => "other_foot",
            Kind::FrameTurned => "frame_turned",
            Kind::RowsShuffled => "rows_shuffled",
            Kind::EncoderStuck => "encoder_stuck",
            Kind::JointLeaps => "joint_leaps",
            Kind::CopFrozen => "cop_frozen",
            Kind::CopOutsideSole => "cop_outside_sole",
            Kind::ForceUnlikeWeight => "force_unlike_weight",
            Kind::BothFeetFlat => "both_feet_flat",
            Kind::RowsCopied => "rows_copied",
            Kind::ChannelSaturated => "channel_saturated",
            Kind::NoiseOverstated => "noise_overstated",
            Kind::ContactLost => "contact_lost",
        }
    }

    /// Whether nothing can be done with such data.
    pub fn makes_unusable(self) -> bool {
        self <= Kind::RowsShuffled
    }
}

/// One thing that is wrong with the data themselves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Finding {
    /// What it is.
    pub kind: Kind,
    /// The axis, link, joint or channel; `-` for the whole log.
    pub target: String,
    /// What was seen and what to do.
    pub sentence: String,
    /// What a figure shows of it.
    #[doc(hidden)]
    #[serde(skip)]
    pub picture: Option<Picture>,
}

impl Finding {
    pub(crate) fn new(kind: Kind, target: &str, sentence: String) -> Finding {
        Finding {
            kind,
            target: target.to_string(),
            sentence,
            picture: None,
        }
    }

    pub(super) fn showing(self, picture: Picture) -> Finding {
        Finding {
            picture: Some(picture),
            ..self
        }
    }
}

/// One number over the rows of a log.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Picture {
    /// What it is, with its unit.
    pub title: String,
    /// Rows from 1, values, and whether the finding is about the row.
    pub points: Vec<(usize, f64, bool)>,
    /// Every row that has points, once, in their order.
    pub rows: Vec<Row>,
    /// What other points and those of the finding are, where not rows.
    pub marks: Option<[String; 2]>,
}

/// A row of a log, and how the robot stood in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// From 1.
    pub number: usize,
    /// Number of its posture in the log.
    pub pose: i64,
    /// Joint by joint, rad or m.
    pub q: Vec<f64>,
}

impl Row {
    /// Posture `k` of those of a log, by the numbers and joint positions of all.
    pub(crate) fn among(pose: &[i64], q: &[f64], k: usize) -> Row {
        let dof = q.len() / pose.len().max(1);
        Row {
            number: k + 1,
            pose: pose[k],
            q: q[k * dof..(k + 1) * dof].to_vec(),
        }
    }
}

impl Picture {
    /// Values of each of so many rows, and whether the finding is about them; of rows that are
    /// evenly chosen, at most 500 values.
    pub(crate) fn new(
        title: &str,
        rows: usize,
        row: impl Fn(usize) -> Row,
        values: impl Fn(usize) -> Vec<(f64, bool)>,
    ) -> Picture {
        let mut picture = Picture {
            title: title.to_string(),
            ..Picture::default()
        };
        let each = if rows > 0 { values(0).len() } else { 1 };
        for k in (0..rows).step_by((each * rows).div_ceil(500).max(1)) {
            let own = row(k);
            let point = |(value, meant)| (own.number, value, meant);
            picture.points.extend(values(k).into_iter().map(point));
            picture.rows.push(own);
        }
        picture
    }

    /// What other points and those of the finding are.
    pub fn marks(&self) -> [&str; 2] {
        let marks = self.marks.as_ref();
        marks.map_or(["row", "what the finding is about"], |marks| {
            marks.each_ref().map(String::as_str)
        })
    }
}
