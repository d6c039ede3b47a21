//! Every way in which encoders and sensors may be wired wrongly, and joint positions under it.

use sesc_model::effects::{self, EffectContext, Instance};
use sesc_model::tape::{Tape, Values};

use crate::evaluate::FASTEST;

/// Effects without unknowns that the robot and its log allow.
pub(crate) fn faults(context: &EffectContext) -> Vec<Instance> {
    let mut all = effects::instances(context);
    all.retain(|fault| fault.unknowns(context) == 0);
    all
}

/// Joint positions that these faults leave of those of a log.
pub(crate) fn positions(context: &EffectContext, faults: &[Instance], q: &[f64]) -> Vec<f64> {
    let joints = Tape::of_many(&effects::wired_joints(context, faults));
    let mut out = vec![0.0; q.len()];
    let n = q.len() / joints.outputs().max(1);
    joints.run(&[Values::PerPosture(q)], n, &mut out, FASTEST);
    out
}
