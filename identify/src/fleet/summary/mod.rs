//! What the rows of a fleet say together: a pure function of the rows.
//!
//! ```text
//! rows ─▶ robots (days in order) ─▶ shared effects ─┐
//!                                └▶ changes ────────┴▶ what to look at first
//! ```

mod changes;
mod course;
pub(super) mod criteria;
mod history;
mod look_first;
mod shared;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

pub use changes::{Change, ChangeKind};
pub use criteria::FALSE_ALARM;
pub use look_first::{Reason, Statement};
pub use shared::{Shared, SharedMember};

use criteria::{OWN_EFFECTS, ROBOTS};
use history::History;

use super::row::Row;
use crate::fit::population::Population;

/// What the rows say together.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Summary {
    /// Effects that robots share.
    pub shared: Vec<Shared>,
    /// What changed, robot by robot.
    pub changes: Vec<Change>,
    /// Robots to look at first.
    pub look_first: Vec<String>,
    /// Why, in the same order.
    pub reasons: Vec<Reason>,
    /// Advice if most robots have effects; an effect may then stand for a body that differs from
    /// the URDF.
    pub bodies: Option<String>,
    /// Prior for the next robot; see [`population`](super::population()).
    pub population: Option<Population>,
}

/// What the rows say together. `names` are those of the base parameters by [`Row::model`];
/// without them parameters are numbered. `population` is what
/// [`population`](super::population()) made of the same rows, where they have covariances.
pub fn summary(
    rows: &[Row],
    names: &BTreeMap<String, Vec<String>>,
    population: Option<Population>,
) -> Summary {
    let histories = history::histories(rows);
    let shared = shared::shared(&histories);
    let changes = changes::changes(&histories, names);
    let reasons = look_first::reasons(&histories, &shared, &changes);
    Summary {
        look_first: reasons.iter().map(|reason| reason.robot.clone()).collect(),
        reasons,
        bodies: differing_bodies(&histories, &shared),
        population,
        shared,
        changes,
    }
}

/// What to do where most robots have effects of their own, as a sentence: a diagnosis that trusts
/// CAD within tight tolerances explains a body that is off by more as an effect, another one in
/// each robot, and most robots of a fleet have no fault of their own.
fn differing_bodies(histories: &[History], shared: &[Shared]) -> Option<String> {
    let in_groups = shared.iter().flat_map(|group| &group.robots);
    let in_groups: BTreeSet<&str> = in_groups.map(String::as_str).collect();
    let of_its_own = |history: &&History| {
        let rows = history.usable().count();
        let with = history.usable().filter(|row| !row.effects.is_empty());
        2 * with.count() > rows && !in_groups.contains(history.robot)
    };
    let all = histories.iter().filter(|h| h.usable().next().is_some());
    let all = all.count();
    let own = histories.iter().filter(of_its_own).count();
    let most = all >= ROBOTS && own as f64 > OWN_EFFECTS * all as f64;
    most.then(|| {
        format!(
            "{own} of {all} robots have effects of their own on most days. So many robots hardly \
             have faults: their bodies differ from the URDF by more than the prior of these \
             diagnoses takes for granted, and an effect stands for a body. Run the fleet once more \
             with the prior `cad`, or with that of the population, which it can write."
        )
    })
}
