//! One posture: number by number, its sines and cosines eight at a time.

use super::plan::{Instruction, Plan, RegisterFill, Step, angles_first};
use super::{Kernels, SHORT, Values};
use crate::program::Program;

/// The steps of a program for one posture.
#[derive(Debug, Clone)]
pub(super) struct Alone {
    plan: Plan,
    /// Steps of angles that no sine is part of, and of those and their sines.
    ends: [usize; 2],
}

impl Alone {
    pub fn new(program: &Program) -> Alone {
        let (order, angles) = angles_first(program);
        let plan = Plan::new(program, &order);
        let sine = |step: &Instruction| matches!(step.step, Step::SinCos(_));
        let sines = plan.steps[angles..].iter().take_while(|step| sine(step));
        let ends = [angles, angles + sines.count()];
        Alone { plan, ends }
    }

    /// Evaluate into `out`, with the bits of a block.
    pub fn run(
        &self,
        sources: &[RegisterFill],
        arguments: &[Values],
        out: &mut [f64],
        kernels: Kernels,
    ) {
        let mut values = vec![0.0; self.plan.registers];
        for (value, source) in values.iter_mut().zip(sources) {
            *value = match *source {
                RegisterFill::Const(x) => x,
                RegisterFill::Input { array, index } => match arguments[array] {
                    Values::PerPosture(given) | Values::Shared(given) => given[index],
                },
            };
        }
        let [angles, sines] = self.ends;
        run(&self.plan.steps[..angles], &mut values, kernels);
        for some in self.plan.steps[angles..sines].chunks(SHORT) {
            sin_cos(some, &mut values, kernels);
        }
        run(&self.plan.steps[sines..], &mut values, kernels);
        for (to, register) in out.iter_mut().zip(&self.plan.outputs) {
            *to = values[*register];
        }
    }
}

fn run(steps: &[Instruction], values: &mut [f64], kernels: Kernels) {
    for step in steps {
        values[step.to] = match step.step {
            Step::Add(a, b) => values[a] + values[b],
            Step::Sub(a, b) => values[a] - values[b],
            Step::Mul(a, b) => values[a] * values[b],
            Step::Div(a, b) => values[a] / values[b],
            Step::Neg(a) => -values[a],
            Step::Clamp(a) => values[a].clamp(-1.0, 1.0),
            Step::Pow(a, b) => {
                let mut power = [0.0; SHORT];
                (kernels.power)(&[values[a]; SHORT], &[values[b]; SHORT], &mut power);
                power[0]
            }
            Step::SinCos(_) => {
                sin_cos(std::slice::from_ref(step), values, kernels);
                continue;
            }
        };
    }
}

/// Sines and cosines of up to [`SHORT`] angles.
fn sin_cos(steps: &[Instruction], values: &mut [f64], kernels: Kernels) {
    let (mut angles, mut sines, mut cosines) = ([0.0; SHORT], [0.0; SHORT], [0.0; SHORT]);
    for (angle, step) in angles.iter_mut().zip(steps) {
        if let Step::SinCos(a) = step.step {
            *angle = values[a];
        }
    }
    (kernels.sin_cos)(&angles, &mut sines, &mut cosines);
    for ((step, sine), cosine) in steps.iter().zip(sines).zip(cosines) {
        values[step.to] = sine;
        values[step.also] = cosine;
    }
}
