//! What to do with planned postures: what to record, under which names, and what then.

use sesc_model::Model;
use sesc_model::text::listed;

use crate::next_steps::{CommandLine, NextStep};

/// Joints that a sentence names.
const NAMED: usize = 3;

/// What to record in the postures of a plan of this robot, and what to do with the log.
pub(super) fn after(model: &Model, line: &CommandLine) -> Vec<NextStep> {
    let dofs = &model.tree.dofs;
    let names: Vec<&str> = dofs.iter().map(|dof| dof.joint.as_str()).collect();
    let unit = match (
        dofs.iter().any(|d| d.prismatic),
        dofs.iter().all(|d| d.prismatic),
    ) {
        (false, _) => "rad",
        (true, false) => "rad, of prismatic joints m",
        (true, true) => "m",
    };
    let support = &model.tree.links[model.tree.support].name;
    // A log that is still to come has no sidecar that names it.
    let mut own = line.clone();
    own.options
        .splice(0..0, ["--support".to_string(), support.clone()]);
    vec![
        NextStep::by_hand(
            format!(
                "Stand in each posture until the robot is still, and log a row of it: `pose`, what \
                 encoders read under the names of the joints ({}; {unit}), and the reading as \
                 `cop_x`, `cop_y` (m, in the frame of `{support}`) or as loads of the foot cells \
                 `fsr_1`, `fsr_2`, … (N)",
                listed(&names, NAMED)
            ),
            "a fit reads columns of these names",
        ),
        NextStep::by_hand(
            "Fit the log",
            "it gives the parameters, their uncertainty and the error on postures not seen",
        )
        .by(own.of("fit", "")),
    ]
}
