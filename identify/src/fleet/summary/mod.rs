//! What the rows of a fleet say together: a pure function of the rows.
//!
//! ```text
//! rows ─▶ robots (days in order) ─▶ shared effects ─┐
//!                                └▶ changes ────────┴▶ what to look at first
//! ```

mod bodies;
mod borne_out;
mod changes;
mod course;
pub(super) mod criteria;
mod history;
mod look_first;
mod shared;
mod spread;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use serde::Serialize;

pub use changes::{Change, ChangeKind};
pub use criteria::FALSE_ALARM;
pub use look_first::{Reason, Statement};
pub use shared::{Shared, SharedMember};

use super::row::Row;
use crate::fit::population::Population;

/// What the rows say together.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Summary {
    /// Effects that robots share, the most common first.
    pub shared: Vec<Shared>,
    /// What changed, robot by robot.
    pub changes: Vec<Change>,
    /// Robots, the first to look at first; those of which nothing is to be said are left out.
    pub look_first: Vec<String>,
    /// Why, in the same order.
    pub reasons: Vec<Reason>,
    /// Advice if most robots have effects of their own; an effect may then stand for a body that
    /// differs from the URDF.
    pub bodies: Option<String>,
    /// Prior for the next robot; see [`population`](super::population()).
    pub population: Option<Population>,
}

/// What the rows say together. `names` are those of the base parameters by the hash of the
/// URDF and the support; without them parameters are numbered. `population` is what
/// [`population`](super::population()) made of the same rows, where they have covariances.
pub fn summary(
    rows: &[Row],
    names: &BTreeMap<(String, String), Vec<String>>,
    population: Option<Population>,
) -> Summary {
    let histories = history::histories(rows);
    let shared = shared::shared(&histories);
    let changes = changes::changes(&histories, names);
    let reasons = look_first::reasons(&histories, &shared, &changes);
    Summary {
        look_first: reasons.iter().map(|reason| reason.robot.clone()).collect(),
        reasons,
        bodies: bodies::differ(&histories, &shared),
        population,
        shared,
        changes,
    }
}
