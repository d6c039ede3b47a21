//! Functions of servo ticks: by the table where a tick is a whole number of its
//! steps, else through the angle.

use serde::Serialize;

use super::functions::Routine;
use super::servos::Servo;
use super::{Options, Scalar, fixed, float};
use crate::Error;
use sesc_model::bounds::{self, Input};
use sesc_model::expr::Argument;
use sesc_model::tree::Dof;
use sesc_model::{Function, Given, Model};

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
    /// Whether the CoP can be had from what ticks are turned into.
    pub(super) fn reach_cop(&self, model: &Model) -> bool {
        model.program(Function::Cop, self.given).is_some()
    }

    pub(super) fn bound(&self, model: &Model, routine: &Routine) -> f64 {
        let mut inputs = model.input_ranges(&routine.program);
        for (array, inputs) in routine.program.inputs.iter().zip(&mut inputs) {
            if array.argument == Argument::Parameters {
                continue;
            }
            for (k, input) in inputs.iter_mut().enumerate() {
                let bits = routine.formats.as_ref().map(|formats| formats.arrays[0]);
                self.widen(&model.tree.dofs[k], self.servos[k], bits, input);
            }
        }
        match (&routine.formats, self.scalar.precision()) {
            (None, Some(precision)) => bounds::prove(&routine.program, &inputs, precision).worst,
            (Some(formats), _) => bounds::prove_fixed(&routine.program, &inputs, formats).worst,
            (None, None) => unreachable!("fixed point comes with formats"),
        }
    }

    /// What comes on top of rounding one argument, which has `bits` fraction bits
    /// in fixed point.
    fn widen(&self, dof: &Dof, servo: Servo, bits: Option<i32>, input: &mut Input) {
        input.rounded = true;
        let size = libm::fabs(dof.lower).max(libm::fabs(dof.upper));
        let by_sines = self.given == Given::SinesCosines && !dof.prismatic;
        if by_sines && servo.steps.is_some() {
            // The table's entry is rounded first, where it has more bits.
            if bits.is_some_and(|bits| bits < TABLE_BITS) {
                input.absolute += unit(TABLE_BITS + 1);
            }
            return;
        }
        // The position is a product with a rounded constant; its sine, if that is
        // what is passed, has the error of the kernel besides.
        input.absolute += match self.scalar.precision() {
            Some(precision) => 3.0 * precision.unit() * size.max(1.0),
            None => bounds::fixed_kernel_error(size) + size * unit(30),
        };
        if by_sines && bits.is_some() {
            // Angle and sine are rounded on the way.
            input.absolute += unit(angle_bits(dof) + 1) + unit(TABLE_BITS + 1);
        }
    }

    pub(super) fn text(
        &self,
        model: &Model,
        scalar: Scalar,
        name: &str,
        routines: &[Routine],
    ) -> Text {
        let real = format!("{name}_real");
        let bits = |array: Argument| {
            let find = |routine: &Routine| {
                let k = routine
                    .program
                    .inputs
                    .iter()
                    .position(|a| a.argument == array)?;
                Some(routine.formats.as_ref()?.arrays[k])
            };
            routines.iter().find_map(find).unwrap_or(0)
        };
        let mut lines = Vec::new();
        for (k, (dof, servo)) in model.tree.dofs.iter().zip(&self.servos).enumerate() {
            let position = |bits: i32| match scalar {
                Scalar::Fixed32 => {
                    let (factor, shift) = multiplier(servo.per_tick, bits);
                    let away = match servo.zero {
                        0 => format!("(int64_t)ticks[{k}]"),
                        zero if zero < 0 => format!("((int64_t)ticks[{k}] + {})", -zero),
                        zero => format!("((int64_t)ticks[{k}] - {zero})"),
                    };
                    format!("{name}_narrow({away} * {factor}, {shift}u)")
                }
                _ => {
                    let factor = float::literal(servo.per_tick, scalar);
                    let zero = float::literal(f64::from(servo.zero.abs()), scalar);
                    let away = match servo.zero {
                        0 => format!("({real})ticks[{k}]"),
                        zero_at if zero_at < 0 => format!("(({real})ticks[{k}] + {zero})"),
                        _ => format!("(({real})ticks[{k}] - {zero})"),
                    };
                    format!("{away} * {factor}")
                }
            };
            if self.given == Given::Positions {
                lines.push(format!("q[{k}] = {};", position(bits(Argument::Positions))));
            } else if dof.prismatic {
                let zero = match scalar {
                    Scalar::Fixed32 => fixed::literal(0.0, 0),
                    _ => float::literal(0.0, scalar),
                };
                lines.push(format!("sin_q[{k}] = {};", position(bits(Argument::Sines))));
                lines.push(format!("cos_q[{k}] = {zero};"));
            } else if let Some(steps) = servo.steps {
                let (at, zero) = (format!("(uint32_t)ticks[{k}]"), servo.zero as u32);
                let away = match servo.sign {
                    1 if zero == 0 => at,
                    1 => format!("{at} - {zero}u"),
                    _ => format!("{zero}u - {at}"),
                };
                let step = match steps {
                    1 => away,
                    _ => format!("({away}) * {steps}u"),
                };
                lines.push(format!("{name}_lookup({step}, &sin_q[{k}], &cos_q[{k}]);"));
            } else {
                let bits = angle_bits(dof);
                let angle = position(bits);
                let bits = match scalar {
                    Scalar::Fixed32 => format!("{bits}u, "),
                    _ => String::new(),
                };
                lines.push(format!(
                    "{name}_sincos({angle}, {bits}&sin_q[{k}], &cos_q[{k}]);"
                ));
            }
            // A long slide among the sines leaves them fewer bits.
            let by_sines = self.given == Given::SinesCosines && !dof.prismatic;
            if by_sines && scalar == Scalar::Fixed32 && bits(Argument::Sines) < TABLE_BITS {
                let more = TABLE_BITS - bits(Argument::Sines);
                for array in ["sin_q", "cos_q"] {
                    lines.push(format!(
                        "{array}[{k}] = {name}_narrow({array}[{k}], {more}u);"
                    ));
                }
            }
        }
        let (brief, results) = match self.given {
            Given::SinesCosines | Given::Direction => (
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

/// Fraction bits of the table of sines.
const TABLE_BITS: i32 = 30;

/// Fraction bits of a joint's angle on its way to its sine.
fn angle_bits(dof: &Dof) -> i32 {
    // More than 28 would leave no room beyond the limits.
    bounds::fitting(libm::fabs(dof.lower).max(libm::fabs(dof.upper))).clamp(16, 28)
}

/// 2^-bits.
fn unit(bits: i32) -> f64 {
    libm::ldexp(1.0, -bits)
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
