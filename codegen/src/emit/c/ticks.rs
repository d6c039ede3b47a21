//! Functions of servo ticks: by the table where a tick is a whole number of its
//! steps, else through the angle.

use crate::emit::header::{self, printable};
use serde::Serialize;

use super::exported::{self, Exported, array_bits};
use super::helpers::{Calls, Helper};
use super::servos::{Scale, Servo};
use super::{Options, Scalar, float, number};
use crate::Error;
use crate::facts::Facts;
use crate::routines::Routine;
use sesc_model::bounds::{self, Input};
use sesc_model::expr::Argument;
use sesc_model::tree::Dof;
use sesc_model::{Function, Given};

/// How ticks become what programs take.
#[derive(Debug, Clone)]
pub(super) struct Ticks {
    pub(super) servos: Vec<Servo>,
    /// Sines and cosines where they determine the result, else positions.
    pub(super) given: Given,
    scalar: Scalar,
}

/// The helper that turns ticks into the arguments of a program.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Text {
    brief: &'static str,
    signature: String,
    lines: Vec<String>,
}

impl Ticks {
    /// `None` where no ticks are wanted, or cannot be had; `notes` says why.
    pub(super) fn of(
        facts: &Facts,
        options: &Options,
        notes: &mut Vec<String>,
    ) -> Result<Option<Ticks>, Error> {
        let Some(servos) = &options.servos else {
            return Ok(None);
        };
        let dofs = facts.dofs;
        let Some(servos) = servos.of_dofs(dofs)? else {
            let prismatic: Vec<&str> = dofs
                .iter()
                .filter(|dof| dof.prismatic)
                .map(|dof| dof.joint.as_str())
                .collect();
            notes.push(format!(
                "no functions of ticks: prismatic joints ({}) need metres_per_tick in a servo file",
                prismatic.join(", ")
            ));
            return Ok(None);
        };
        if servos.is_empty() {
            return Ok(None);
        }
        let sines = has(facts, Function::Com, Given::SinesCosines);
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
    pub(super) fn bound(&self, dofs: &[Dof], routine: &Exported) -> f64 {
        let mut inputs = routine.inputs.clone();
        for (array, inputs) in routine.program.inputs.iter().zip(&mut inputs) {
            // What ticks are not turned into comes as it is.
            if let Argument::Parameters
            | Argument::Velocities
            | Argument::Accelerations
            | Argument::Context = array.argument
            {
                continue;
            }
            for (k, input) in inputs.iter_mut().enumerate() {
                let bits = routine.formats.as_ref().map(|formats| formats.arrays[0]);
                self.widen(&dofs[k], self.servos[k], bits, input);
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
        let way = self.way(dof, servo);
        if let Way::Table(_) = way {
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
        if way == Way::Sines && bits.is_some() {
            // Angle and sine are rounded on the way.
            input.absolute += unit(angle_bits(dof) + 1) + unit(TABLE_BITS + 1);
        }
    }

    /// `routine` from ticks, its bound still to be proven.
    pub(super) fn routine<'f>(&self, dofs: &[Dof], routine: &Exported<'f>) -> Exported<'f> {
        let mut counts = routine.counts;
        let mut look_ups = 0;
        for (dof, servo) in dofs.iter().zip(&self.servos) {
            match self.way(dof, *servo) {
                // What forms the argument of a sine belongs to it.
                Way::Sines => counts.sin_cos += 1,
                Way::Table(_) => look_ups += 1,
                Way::Position if self.given == Given::Positions && !dof.prismatic => {}
                Way::Position => {
                    counts.mul += 1;
                    counts.add += usize::from(servo.zero != 0);
                }
            }
        }
        Exported {
            input: exported::Input::Ticks,
            counts,
            look_ups,
            ..routine.clone()
        }
    }

    fn way(&self, dof: &Dof, servo: Servo) -> Way {
        match (self.given, servo.steps()) {
            (Given::Positions, _) => Way::Position,
            _ if dof.prismatic => Way::Position,
            (_, Some(steps)) => Way::Table(steps),
            (_, None) => Way::Sines,
        }
    }

    /// A line for each joint: what a tick of it means.
    pub(super) fn convention(&self, dofs: &[Dof]) -> Vec<String> {
        let names: Vec<String> = dofs.iter().map(|dof| printable(&dof.joint)).collect();
        let width = names.iter().map(|name| name.chars().count()).max();
        let width = width.unwrap_or(0).max("joint".len());
        let mut lines = vec![format!(
            "{:<width$} {:>9} {:>5}   scale",
            "joint", "zero", "sign"
        )];
        for (name, servo) in names.iter().zip(&self.servos) {
            let scale = match servo.scale {
                Scale::TicksPerTurn(ticks) => format!("{ticks} ticks a turn"),
                Scale::MetresPerTick(metres) => format!("{metres:?} m a tick"),
            };
            lines.push(format!(
                "{name:<width$} {:>9} {:>+5}   {scale}",
                servo.zero, servo.sign
            ));
        }
        lines
    }

    /// What ticks give that are beyond a joint's limits.
    pub(super) fn beyond(&self, dofs: &[Dof]) -> Vec<String> {
        let mut text = "Ticks beyond the joint limits count on, and the result is that of where \
                        they stand, without a bound"
            .to_string();
        let ways = dofs.iter().zip(&self.servos);
        let ways: Vec<Way> = ways.map(|(dof, servo)| self.way(dof, *servo)).collect();
        if ways.iter().any(|way| matches!(way, Way::Table(_))) {
            text += "; a whole turn more is the same angle, for every int32_t";
        }
        if ways.iter().any(|way| !matches!(way, Way::Table(_))) {
            text += match self.scalar {
                Scalar::F64 => "; angles beyond 2^20 rad give NaN",
                Scalar::F32 => "; angles beyond 1024 rad give NaN",
                Scalar::Fixed32 => "; what 32 bits do not hold wraps to another posture",
            };
        }
        header::wrapped(&(text + ". Nothing is undefined."))
    }

    pub(super) fn text(
        &self,
        dofs: &[Dof],
        name: &str,
        routines: &[Exported],
        calls: &Calls,
    ) -> Text {
        let real = format!("{name}_real");
        let arrays: &[&str] = match self.given {
            Given::Positions => &["q"],
            Given::SinesCosines | Given::Direction => &["sin_q", "cos_q"],
        };
        let bits = match self.given {
            Given::Positions => array_bits(routines, Argument::Positions),
            Given::SinesCosines | Given::Direction => array_bits(routines, Argument::Sines),
        };
        let mut lines = Vec::new();
        for (k, (dof, servo)) in dofs.iter().zip(&self.servos).enumerate() {
            let position = |bits| self.position(k, *servo, bits, &real, calls);
            let way = self.way(dof, *servo);
            match way {
                Way::Position => {
                    lines.push(format!("{}[{k}] = {};", arrays[0], position(bits)));
                    lines.extend(arrays.get(1).map(|cosines| {
                        format!("{cosines}[{k}] = {};", number(0.0, self.scalar, 0))
                    }));
                }
                Way::Table(steps) => {
                    let step = step(k, *servo, steps);
                    let arguments = format!("{step}, &sin_q[{k}], &cos_q[{k}]");
                    lines.push(calls.call(Helper::Lookup, &arguments) + ";");
                }
                Way::Sines => {
                    let of_angle = angle_bits(dof);
                    let angle = position(of_angle);
                    let of_angle = match self.scalar {
                        Scalar::Fixed32 => format!("{of_angle}u, "),
                        _ => String::new(),
                    };
                    let arguments = format!("{angle}, {of_angle}&sin_q[{k}], &cos_q[{k}]");
                    lines.push(calls.call(Helper::Sincos, &arguments) + ";");
                }
            }
            // A long stroke among the sines leaves them fewer bits.
            if way != Way::Position && self.scalar == Scalar::Fixed32 && bits < TABLE_BITS {
                let more = TABLE_BITS - bits;
                for array in arrays {
                    let arguments = format!("{array}[{k}], {more}u");
                    let call = calls.call(Helper::Narrow, &arguments);
                    lines.push(format!("{array}[{k}] = {call};"));
                }
            }
        }
        Text {
            brief: match self.given {
                Given::Positions => "Joint positions from servo ticks.",
                Given::SinesCosines | Given::Direction => {
                    "Sines and cosines of the joint angles, positions of prismatic joints, \
                     from servo ticks."
                }
            },
            signature: format!(
                "{name}_from_ticks(const int32_t ticks[], {})",
                arrays
                    .iter()
                    .map(|array| format!("{real} {array}[]"))
                    .collect::<Vec<_>>()
                    .join(", ")
            ),
            lines,
        }
    }

    /// Position of joint `k`, with `bits` fraction bits in fixed point.
    fn position(&self, k: usize, servo: Servo, bits: i32, real: &str, calls: &Calls) -> String {
        let away = |cast: &str, zero: &str| match servo.zero {
            0 => format!("({cast})ticks[{k}]"),
            at if at < 0 => format!("(({cast})ticks[{k}] + {zero})"),
            _ => format!("(({cast})ticks[{k}] - {zero})"),
        };
        let zero = servo.zero.unsigned_abs();
        match self.scalar {
            Scalar::Fixed32 => {
                let (factor, shift) = multiplier(servo.per_tick(), bits);
                let away = away("int64_t", &zero.to_string());
                calls.call(Helper::Narrow, &format!("{away} * {factor}, {shift}u"))
            }
            _ => {
                let factor = float::literal(servo.per_tick(), self.scalar);
                let zero = float::literal(f64::from(zero), self.scalar);
                format!("{} * {factor}", away(real, &zero))
            }
        }
    }
}

/// Whether there is such a function.
fn has(facts: &Facts, function: Function, given: Given) -> bool {
    let is_it = |r: &Routine| r.function == function && r.given == given && !r.baked;
    facts.routines.iter().any(is_it)
}

/// How a tick becomes what the programs take.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    /// The position itself is passed on.
    Position,
    /// From the table of sines, with this many steps a tick.
    Table(u32),
    /// The sine and cosine of its angle are passed on.
    Sines,
}

/// The step of the table that joint `k` stands at, modulo 2^32.
fn step(k: usize, servo: Servo, steps: u32) -> String {
    let (at, zero) = (format!("(uint32_t)ticks[{k}]"), servo.zero as u32);
    let away = match servo.sign {
        1 if zero == 0 => at,
        1 => format!("{at} - {zero}u"),
        _ => format!("{zero}u - {at}"),
    };
    match steps {
        1 => away,
        _ => format!("({away}) * {steps}u"),
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
