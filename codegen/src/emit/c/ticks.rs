//! Functions of servo ticks: by the table where a tick is a whole number of its
//! steps, else through the angle.

use serde::Serialize;

use super::functions::Routine;
use super::servos::Servo;
use super::{Options, Scalar, fixed, float};
use crate::Error;
use crate::bounds::{self, Input, Precision};
use crate::model::{Function, Given, Model};

/// How ticks become what programs take.
#[derive(Debug, Clone)]
pub(super) struct Ticks {
    pub(super) servos: Vec<Servo>,
    /// Sines and cosines where they tell everything, else positions.
    pub(super) given: Given,
    scalar: Scalar,
}

/// The helper that turns ticks into the arguments of a program.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Text {
    brief: &'static str,
    signature: String,
    pub(super) lines: Vec<String>,
}

impl Ticks {
    /// `None` where no ticks are wanted, or cannot be had; `notes` says why.
    pub(super) fn of(
        model: &Model,
        options: &Options,
        notes: &mut Vec<String>,
    ) -> Result<Option<Ticks>, Error> {
        let Some(servos) = &options.servos else {
            return Ok(None);
        };
        let dofs = &model.tree.dofs;
        let Some(servos) = servos.of(dofs)? else {
            let slides: Vec<&str> = dofs
                .iter()
                .filter(|dof| dof.prismatic)
                .map(|dof| dof.joint.as_str())
                .collect();
            notes.push(format!(
                "no functions of ticks: sliding joints ({}) need metres_per_tick in a servo file",
                slides.join(", ")
            ));
            return Ok(None);
        };
        if servos.is_empty() {
            return Ok(None);
        }
        let sines = model.program(Function::Com, Given::SinesCosines).is_some();
        Ok(Some(Ticks {
            servos,
            given: match sines {
                true => Given::SinesCosines,
                false => Given::Positions,
            },
            scalar: options.scalar,
        }))
    }

    /// Proven bound of a routine when its arguments come from ticks.
    pub(super) fn bound(&self, model: &Model, routine: &Routine) -> f64 {
        let mut inputs = model.input_ranges(&routine.program);
        for (array, inputs) in routine.program.inputs.iter().zip(&mut inputs) {
            if array.name == "r" {
                continue;
            }
            for (k, input) in inputs.iter_mut().enumerate() {
                self.widen(&model.tree.dofs[k], self.servos[k], input);
            }
        }
        match (&routine.formats, self.scalar.precision()) {
            (None, Some(precision)) => bounds::prove(&routine.program, &inputs, precision).worst,
            (Some(formats), _) => bounds::prove_fixed(&routine.program, &inputs, formats).worst,
            (None, None) => unreachable!("fixed point comes with formats"),
        }
    }

    /// What comes on top of rounding one argument.
    fn widen(&self, dof: &crate::tree::Dof, servo: Servo, input: &mut Input) {
        input.rounded = true;
        let size = libm::fabs(dof.lower).max(libm::fabs(dof.upper));
        let by_table = self.given == Given::SinesCosines && servo.steps.is_some();
        if by_table {
            return;
        }
        // The position is a product with a rounded constant; its sine, if that is
        // what is passed, has the error of the kernel besides.
        input.absolute += match self.scalar.precision() {
            Some(precision) => 3.0 * precision.unit() * size.max(1.0),
            None => bounds::fixed_kernel_error(size) + size * Precision::F32.unit() / 64.0,
        };
    }

    pub(super) fn text(
        &self,
        model: &Model,
        scalar: Scalar,
        name: &str,
        routines: &[Routine],
    ) -> Text {
        let real = format!("{name}_real");
        let bits = |array: &str| {
            let find = |routine: &Routine| {
                let k = routine
                    .program
                    .inputs
                    .iter()
                    .position(|a| a.name == array)?;
                Some(routine.formats.as_ref()?.arrays[k])
            };
            routines.iter().find_map(find).unwrap_or(0)
        };
        let mut lines = Vec::new();
        for (k, (dof, servo)) in model.tree.dofs.iter().zip(&self.servos).enumerate() {
            let position = |bits: i32| match scalar {
                Scalar::Fixed32 => {
                    let (factor, shift) = multiplier(servo.per_tick, bits);
                    let away = format!("((int64_t)ticks[{k}] - {})", servo.zero);
                    format!("{name}_narrow({away} * {factor}, {shift}u)")
                }
                _ => {
                    let zero = float::literal(f64::from(servo.zero), scalar);
                    let factor = float::literal(servo.per_tick, scalar);
                    format!("(({real})ticks[{k}] - {zero}) * {factor}")
                }
            };
            if self.given == Given::Positions {
                lines.push(format!("q[{k}] = {};", position(bits("q"))));
            } else if dof.prismatic {
                let zero = match scalar {
                    Scalar::Fixed32 => fixed::literal(0.0, 0),
                    _ => float::literal(0.0, scalar),
                };
                lines.push(format!("sin_q[{k}] = {};", position(bits("sin"))));
                lines.push(format!("cos_q[{k}] = {zero};"));
            } else if let Some(steps) = servo.steps {
                let (at, zero) = (format!("(uint32_t)ticks[{k}]"), servo.zero as u32);
                let away = match servo.sign {
                    1 => format!("{at} - {zero}u"),
                    _ => format!("{zero}u - {at}"),
                };
                let step = match steps {
                    1 => away,
                    _ => format!("({away}) * {steps}u"),
                };
                lines.push(format!("{name}_lookup({step}, &sin_q[{k}], &cos_q[{k}]);"));
            } else {
                // 20 bits below the point hold any angle; the phase keeps what matters.
                let bits = bits("q").clamp(16, 28);
                let angle = position(bits);
                let bits = match scalar {
                    Scalar::Fixed32 => format!("{bits}u, "),
                    _ => String::new(),
                };
                lines.push(format!(
                    "{name}_sincos({angle}, {bits}&sin_q[{k}], &cos_q[{k}]);"
                ));
            }
        }
        let (brief, results) = match self.given {
            Given::SinesCosines => (
                "Sines and cosines of the joint angles (positions of slides) from servo ticks.",
                format!("{real} sin_q[], {real} cos_q[]"),
            ),
            Given::Positions => ("Joint positions from servo ticks.", format!("{real} q[]")),
        };
        Text {
            brief,
            signature: format!("{name}_from_ticks(const int32_t ticks[], {results})"),
            lines,
        }
    }
}

/// `x` per tick as `factor / 2^shift` of a value with `bits` fraction bits, the
/// factor below 2^30 so that the product with any tick fits 64 bits.
fn multiplier(x: f64, bits: i32) -> (i64, i32) {
    let mut shift = 30;
    while shift > 1 && libm::fabs(libm::ldexp(x, bits + shift)) >= libm::ldexp(1.0, 30) {
        shift -= 1;
    }
    (libm::rint(libm::ldexp(x, bits + shift)) as i64, shift)
}
