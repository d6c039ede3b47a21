//! What a part was gathered with, as far as that shaped its sums.
//!
//! Parts of other options are not of one fit: a fit of all their logs has one of each. Units of
//! joints and feet on the floor belong to each log, and sums know nothing of CAD's tolerances.

use serde::{Deserialize, Serialize};

use crate::fit::robust::Loss;
use crate::logs::Stays;
use crate::observations::motion_use::MotionModel;
use crate::{Message, Setting, message};

/// The options of a fit that shaped the sums of a part.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PartOptions {
    /// Whether the motion of the joints counts.
    pub motion: MotionModel,
    /// What becomes of rows in which the robot holds still.
    pub stays: Stays,
    /// The loss that trusts outliers less, where one was asked for.
    pub robust: Option<Loss>,
}

impl PartOptions {
    /// The first one that differs, as a sentence with the remedy.
    pub(super) fn difference(&self, other: &PartOptions) -> Option<Message> {
        let [own, its] = [self, other].map(PartOptions::named);
        let pairs = own.into_iter().zip(its);
        let mut different = pairs.filter(|(own, its)| own.1 != its.1);
        different.next().map(|((setting, own), (_, its))| {
            message![
                "gathered with ",
                setting,
                format!(" {its}, the first part with {own}; gather both alike")
            ]
        })
    }

    fn named(&self) -> [(Setting, String); 3] {
        let motion = match self.motion {
            MotionModel::Auto => "auto",
            MotionModel::Off => "off",
        };
        let stays = match self.stays {
            Stays::Pooled => "none".to_string(),
            Stays::Apart => "rows apart".to_string(),
            Stays::Moving => "0 s".to_string(),
            Stays::Alone(seconds) => format!("{seconds} s"),
        };
        let robust = match self.robust {
            None => "none",
            Some(Loss::Huber) => "huber",
            Some(Loss::Tukey) => "tukey",
        };
        [
            (Setting::Motion, motion.to_string()),
            (Setting::Settle, stays),
            (Setting::Robust, robust.to_string()),
        ]
    }
}
