//! A joint (or all alike) yields to its gravity moment.
//!
//! ```text
//! φ_j = q_j + τ_j(φ) / k          k in Nm/rad, τ_j = −∂(potential)/∂φ_j
//! ```
//!
//! The moment is that of the bent robot with everything it carries. Imitated at a
//! support ankle by a sensor gain of that axis, a soft sole or soft ground: the
//! moment is weight times CoP there. Squats of different depth separate them.

use super::{Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct JointCompliance;

impl Effect for JointCompliance {
    fn name(&self) -> &'static str {
        "joint_compliance"
    }

    fn stage(&self) -> Stage {
        Stage::Bends
    }

    fn targets(&self, setting: &Setting) -> Vec<Target> {
        let mut targets = vec![Target::AllJoints];
        targets.extend(setting.turning().into_iter().map(Target::Joint));
        targets
    }

    fn scales(&self, _: &Setting, _: &Target) -> Vec<f64> {
        vec![0.3]
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        for joint in at.turning(target) {
            at.spring(joint, unknowns[0]);
        }
    }

    fn values(&self, setting: &Setting, _: &Target, unknowns: &[f64]) -> Vec<Value> {
        // Unknown: rad per metre of moment over weight.
        super::plain(&["stiffness_nm_per_rad"], &[setting.weight() / unknowns[0]])
    }

    fn unknowns(&self, setting: &Setting, _: &Target, values: &[f64]) -> Vec<f64> {
        vec![setting.weight() / values[0]]
    }

    fn excess(&self, setting: &Setting, _: &Target, unknowns: &[f64]) -> Vec<f64> {
        // Springs push back; beyond half of what buckles under the robot's own
        // weight it could not have stood.
        let most = 0.5 / setting.height();
        let mut excess = vec![(-unknowns[0]).max(0.0) / 0.005];
        excess.extend(super::beyond(unknowns[0], most, 0.1 * most));
        excess
    }

    fn fault(&self, _: &Setting, _: &Target, values: &[f64]) -> Option<&'static str> {
        let soft = values[0] <= 0.0;
        soft.then_some("a stiffness of 0 or less holds nothing; give Nm/rad above 0")
    }
}
