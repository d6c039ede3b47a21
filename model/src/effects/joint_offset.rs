#![doc = include_str!("pages/joint_offset.md")]

use super::remedy::{EncoderMap, degrees, millimetres, signed};
use super::{Effect, EffectContext, Measured, Parameter, Target, UrdfEdit};
use crate::expr::Id;
use crate::urdf::Shift;

pub(super) struct JointOffset;

impl Effect for JointOffset {
    kind!("joint_offset", Joints, joints);

    fn parameters(&self, context: &EffectContext, target: &Target) -> &'static [Parameter] {
        const REVOLUTE: &[Parameter] = &[Parameter::new("offset_rad", 0.02)];
        const PRISMATIC: &[Parameter] = &[Parameter::new("offset_m", 0.02)];
        context.by_kind(target, REVOLUTE, PRISMATIC)
    }

    fn phrase(&self, _: &Target, name: &str) -> String {
        format!("an offset of {name}")
    }

    fn remedy(&self, context: &EffectContext, target: &Target, values: &[f64]) -> String {
        let kind = context.by_kind(target, "angle", "position");
        let size = match kind {
            "angle" => degrees(values[0]),
            _ => millimetres(values[0]),
        };
        let name = context.name_of(target);
        format!("true {kind} of {name} = reading {}", signed(size))
    }

    fn encoder_map(&self, values: &[f64]) -> Option<EncoderMap> {
        Some(EncoderMap {
            scale: 1.0,
            offset: values[0],
        })
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        if let Target::Joint(j) = *target {
            at.shift_joint(j, unknowns[0]);
        }
    }

    fn reports_smallest_detectable(&self) -> bool {
        true
    }

    fn urdf_edit(&self, target: &str, value: &dyn Fn(&str) -> f64) -> Option<UrdfEdit> {
        Some(UrdfEdit::Joint(Shift {
            joint: target.to_string(),
            // One of the two is there, the other 0.
            by: value("offset_rad") + value("offset_m"),
        }))
    }

    fn bound_violation(&self, _: &EffectContext, _: &Target, unknowns: &[f64]) -> Vec<f64> {
        super::beyond(unknowns[0], 0.7, 0.1)
    }
}
