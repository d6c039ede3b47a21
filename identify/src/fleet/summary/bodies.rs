//! Whether the bodies of a fleet differ from the URDF by more than diagnoses take for granted.
//!
//! A diagnosis that trusts CAD within tight tolerances explains a body that is off by more as an
//! effect, another one in each robot. Most robots of a fleet have no fault of their own.

use std::collections::BTreeSet;

use super::criteria::{OWN_EFFECTS, ROBOTS};
use super::history::History;
use super::shared::Shared;

/// What to do where most robots have effects of their own, as a sentence.
pub(super) fn differ(histories: &[History], shared: &[Shared]) -> Option<String> {
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
