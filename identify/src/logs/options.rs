//! How a log is to be read.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::contacts::Soles;
use super::sidecar::Angles;

/// How a log is to be read.
///
/// ```
/// use sesc_identify::logs::{Angles, Options};
///
/// let mut options = Options::default();
/// options.angles = Some(Angles::Deg);
/// ```
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Options {
    /// Unit of the revolute joints; the sidecar's, else radians, unless given.
    pub angles: Option<Angles>,
    /// Whether the log must have readings.
    pub readings: Readings,
    /// The robot's links; a support that is none of them is an error. Not
    /// checked if empty.
    pub links: Vec<String>,
    /// Link on the ground in rows that do not say; the sidecar's unless given.
    pub support: Option<String>,
    /// Which stretches of an MCAP recording are postures.
    pub stillness: StillnessLimits,
    /// What becomes of rows in which the robot holds still.
    pub stays: Stays,
    /// Topic of the CoP in an MCAP recording that has several; the sidecar's
    /// unless given.
    pub topic: Option<String>,
    /// Take angles and CoP of any size: which unit they are in is the question.
    pub any_unit: bool,
    /// Where the robot's soles are: with it an MCAP recording of two loaded contacts is one of
    /// both feet, and a wrench in another frame of the support's body is moved to the sole.
    #[doc(hidden)]
    pub soles: Option<Arc<dyn Soles>>,
    /// Whether both feet stand, where the caller says it; one does with `Some(false)`, whatever is
    /// loaded.
    #[doc(hidden)]
    pub both_feet: Option<bool>,
}

/// Whether readings are wanted from a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Readings {
    /// Not looked at, however wrong they are.
    Ignored,
    /// Read where the log has them.
    #[default]
    Optional,
    /// A log without them is an error.
    Required,
}

/// What becomes of rows in which a robot holds still, in a log that has times.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Stays {
    /// They are readings of one posture where the log has no `pose`; other rows are postures
    /// of their own.
    #[default]
    Pooled,
    /// They are rows like others.
    Apart,
    /// They are rows like others, of a robot that moves: every reading of an MCAP recording is a
    /// row, with the joints between its messages.
    Moving,
    /// They alone are read, from stays of at least so many seconds; of an MCAP recording, too.
    Alone(f64),
}

/// No robot settles sooner, and nobody waits longer, s.
const STAYS_S: [f64; 2] = [0.01, 3600.0];

impl Stays {
    /// What `--settle` asks for: stays of at least so many seconds alone, all rows by 0.
    ///
    /// # Errors
    /// As [`Stays::alone`].
    ///
    /// # Examples
    /// ```
    /// # use sesc_identify::logs::Stays;
    /// assert_eq!(Stays::settled(0.5), Ok(Stays::Alone(0.5)));
    /// assert_eq!(Stays::settled(0.0), Ok(Stays::Moving));
    /// ```
    pub fn settled(seconds: f64) -> Result<Stays, String> {
        match seconds == 0.0 {
            true => Ok(Stays::Moving),
            false => Stays::alone(seconds).map_err(|said| format!("{said}, or 0 for all rows")),
        }
    }

    /// Stays of at least so many seconds alone.
    ///
    /// # Errors
    /// What is no length of a stay.
    ///
    /// # Examples
    /// ```
    /// # use sesc_identify::logs::Stays;
    /// assert_eq!(Stays::alone(0.5), Ok(Stays::Alone(0.5)));
    /// assert!(Stays::alone(-1.0).unwrap_err().starts_with("give 0.01 to 3600 seconds"));
    /// ```
    pub fn alone(seconds: f64) -> Result<Stays, String> {
        let [least, longest] = STAYS_S;
        match (least..=longest).contains(&seconds) {
            true => Ok(Stays::Alone(seconds)),
            false => Err(format!(
                "give {least} to {longest} seconds of holding still"
            )),
        }
    }
}

/// When a robot that is being recorded holds still.
///
/// A posture is a stretch in which every joint is slower than `speed` for at
/// least `duration`. Prismatic joints count m for rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StillnessLimits {
    /// rad/s
    pub speed: f64,
    /// s
    pub duration: f64,
}

impl Default for StillnessLimits {
    fn default() -> StillnessLimits {
        StillnessLimits {
            speed: 0.02,
            duration: 0.3,
        }
    }
}

impl StillnessLimits {
    /// What is said of a log in which nothing is held.
    pub(super) fn nothing(self) -> String {
        let StillnessLimits { speed, duration } = self;
        format!(
            "no posture is held: no stretch of {duration} s in which every joint stays below \
             {speed} rad/s"
        )
    }
}
