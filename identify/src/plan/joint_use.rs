//! What postures ask of the joints.

use serde::Serialize;
use sesc_model::Model;

use super::limits::Limits;
use crate::observations::postures::range;

/// What postures ask of a joint, rad or m.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct JointUse {
    /// The joint's name.
    pub joint: String,
    /// Whether `limits`, `values` and `used` are m.
    pub prismatic: bool,
    /// What was allowed.
    pub limits: [f64; 2],
    /// Posture by posture, in their order.
    #[serde(skip)]
    pub values: Vec<f64>,
    /// Least and largest of these.
    pub used: [f64; 2],
}

/// What the chosen postures ask of every joint.
pub(super) fn of_all(model: &Model, limits: &Limits, q: &[f64], chosen: &[usize]) -> Vec<JointUse> {
    let dof = model.dof();
    let of_joint = |j: usize| {
        let values: Vec<f64> = chosen.iter().map(|k| q[k * dof + j]).collect();
        let (least, largest) = range(values.iter().copied());
        JointUse {
            joint: model.tree.dofs[j].joint.clone(),
            prismatic: model.tree.dofs[j].prismatic,
            limits: limits.ranges[j].into(),
            used: [least, largest],
            values,
        }
    };
    (0..dof).map(of_joint).collect()
}
