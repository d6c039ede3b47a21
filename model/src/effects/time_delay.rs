#![doc = include_str!("pages/time_delay.md")]

use super::{
    Carry, Effect, EffectContext, Experiment, Measured, Parameter, PostureContext, Target,
};
use crate::expr::Id;

pub(super) struct TimeDelay;

impl Effect for TimeDelay {
    kind!("time_delay", Joints);

    fn targets(&self, context: &EffectContext) -> Vec<Target> {
        match context.times {
            true => vec![Target::Whole],
            false => Vec::new(),
        }
    }

    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        const { &[Parameter::new("delay_s", 0.03)] }
    }

    fn phrase(&self, _: &Target, _: &str) -> String {
        "a delay of joint angles against readings".to_string()
    }

    fn remedy(&self, _: &EffectContext, _: &Target, values: &[f64]) -> String {
        let (late, way) = match values[0] > 0.0 {
            true => ("joint angles", "later"),
            false => ("readings", "earlier"),
        };
        let ms = 1e3 * values[0].abs();
        format!(
            "{late} are {ms:.1} ms late: true angle = what the encoder reads {ms:.1} ms {way}; shift \
             the columns against each other"
        )
    }

    fn rewrite(&self, _: &Target, at: &mut Measured, unknowns: &[Id]) {
        let layout = PostureContext::of(at.robot());
        let d = unknowns[0];
        let half = at.constant(0.5);
        let half_d = at.mul(half, d);
        for joint in 0..at.robot().dof() {
            let rate = at.posture_context(layout.rate(joint));
            let acceleration = at.posture_context(layout.acceleration(joint));
            let g = at.g();
            let curve = g.mul(half_d, acceleration);
            let slope = g.add(curve, rate);
            let moved = g.mul(d, slope);
            at.shift_joint(joint, moved);
        }
        at.shift_motion(d);
    }

    fn is_static(&self) -> bool {
        false
    }

    fn in_experiment(&self, _: Experiment, _: &Target) -> Carry {
        Carry::Gone
    }
}
