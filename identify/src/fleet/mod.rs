//! A fleet: a log per robot and day in, a row per robot and day out, and what the rows say
//! together.
//!
//! ```text
//! inputs ─▶ groups (robot, day or week) ─▶ row(URDF, options, logs) ─▶ table, Parquet or CSV
//!                                       ▲  │                     │
//!                              store: a file for each row        ▼
//!                                                  summary: shared effects, changes,
//!                                                  what to look at first
//! ```
//!
//! [`row`] is a pure function: the logs of a group are sorted by the hash of their content,
//! one that comes twice counts once, and nothing of the result depends on time, paths or the
//! order in which logs arrive. Whatever runs it (threads here, processes or machines
//! elsewhere) and however often, the table is the same to the byte. A log that cannot be
//! read is an error in its row and never the end of a run.
//!
//! [`summary`](summary::summary()) is a pure function of the rows.

mod evaluate;
mod inputs;
mod log;
mod population;
mod row;
mod run;
pub mod summary;

use serde::{Deserialize, Serialize};
use sesc_model::Snapping;

use crate::diagnose::FLOOR_M;
use crate::logs::Angles;

pub use evaluate::row;
pub use inputs::{Group, groups, inputs};
#[doc(hidden)]
pub use log::content_hash;
pub use log::{Failed, Log, Store};
#[doc(hidden)]
pub use population::check_population;
pub use population::population;
#[doc(hidden)]
pub use row::check_table;
pub use row::{COLUMNS, EffectFound, Effects, Row, SCORES, cells, write};
#[doc(hidden)]
pub use run::{Done, gathered, work};
pub use run::{Fleet, Request, Twice, run};

/// How every group is looked at: the options of a diagnosis, and of the fit beside it.
///
/// ```
/// use sesc_identify::fleet::Options;
///
/// let mut options = Options::default();
/// options.support = Some("r_sole".into());
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct Options {
    /// Link on the ground in rows that do not say; each log's own unless given.
    pub support: Option<String>,
    /// Whether decimals of right angles are made exact.
    pub snap: bool,
    /// Unit of revolute joints; each log's own, else rad, unless given.
    pub angles: Option<Angles>,
    /// Tolerances of CAD masses of the diagnosis: `tight`, `cad`, `free` or a file; those of
    /// [`Prior::OF_DIAGNOSES`](crate::fit::prior::Prior::OF_DIAGNOSES) unless given. The fit
    /// has those of [`Prior::DEFAULT`](crate::fit::prior::Prior::DEFAULT) unless given.
    pub prior: Option<String>,
    /// Standard deviation of a single reading on one axis, m; each log's own unless given.
    pub noise: Option<f64>,
    /// Added to the noise of a posture in quadrature, m.
    pub floor: f64,
    /// Whether the motion of the joints counts.
    pub motion: bool,
    /// Whether both feet are on the floor; each log's own unless given.
    pub both_feet: Option<bool>,
    /// The link that is the other sole.
    pub other_foot: Option<String>,
    /// What is made of a group; diagnosis and fit unless given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub only: Option<Only>,
    /// Whether rows of parameters alone keep what they know of all of them together, as those of
    /// diagnoses do, for [`population`](population()).
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub information: bool,
}

/// What alone is made of a group.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Only {
    /// The fit: parameters and health, without verdict and effects.
    Parameters,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            support: None,
            snap: true,
            angles: None,
            prior: None,
            noise: None,
            floor: FLOOR_M,
            motion: true,
            both_feet: None,
            other_foot: None,
            only: None,
            information: false,
        }
    }
}

impl Options {
    /// Whether decimals of right angles are made exact, as models take it.
    pub fn snapping(&self) -> Snapping {
        if self.snap {
            Snapping::default()
        } else {
            Snapping::Off
        }
    }

    /// Everything that rows depend on, as a text: the contents of a file of tolerances, too.
    pub(super) fn key(&self) -> String {
        let mut own = self.clone();
        // Rows of diagnoses are the same with it and without.
        own.information &= own.only.is_some();
        let own = serde_json::to_string(&own).unwrap_or_default();
        let file = self.prior.as_deref();
        let text = file.and_then(|file| std::fs::read_to_string(file).ok());
        format!("{own}\n{}", text.unwrap_or_default())
    }
}
