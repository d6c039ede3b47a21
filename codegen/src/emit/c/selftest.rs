//! The self-test that firmware runs at boot: a posture whose results the
//! generator computed in another way.

use serde::Serialize;

use super::exported::{Exported, array_bits};
use super::ticks::Ticks;
use super::{Scalar, number};
use crate::facts::Facts;
use crate::routines::{Routine, takes_context};
use sesc_model::expr::Argument;
use sesc_model::tape::{Kernels, Tape, Values};
use sesc_model::{Function, Given};

/// Errors that only a defect makes, m: in f64, in f32.
const LOOSE: [f64; 2] = [1e-9, 1e-4];

/// A result array of the self-test.
#[derive(Debug, Clone, Serialize)]
pub(super) struct ResultArray {
    name: &'static str,
    length: String,
}

/// One comparison.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Check {
    arrays: Vec<Constant>,
    call: String,
    got: &'static str,
    expected: String,
    count: usize,
    tolerance: String,
    weight: u32,
    #[serde(skip)]
    stem: String,
}

#[derive(Debug, Clone, Serialize)]
struct Constant {
    #[serde(rename = "type")]
    scalar: String,
    name: String,
    values: Vec<String>,
}

/// Which function a comparison calls.
#[derive(Debug, Clone, Copy)]
struct Wanted {
    function: Function,
    of_ticks: bool,
    /// With the parameters of the model file in it.
    baked: bool,
}

impl Wanted {
    fn is(self, routine: &Exported) -> bool {
        routine.function == self.function
            && routine.is_of_ticks() == self.of_ticks
            && routine.baked == self.baked
            && !routine.is_batch()
            && (self.of_ticks || routine.given == Given::Positions)
    }
}

/// What the return value is a sum of.
pub(super) fn weights(checks: &[Check], scalar: Scalar) -> String {
    let weights = checks
        .iter()
        .map(|check| format!("{} ({})", check.weight, check.stem));
    let mut weights: Vec<String> = weights.collect();
    if scalar != Scalar::Fixed32 {
        let rounding = weight_of_rounding(checks);
        weights.push(format!("{rounding} (sums are not rounded to nearest)"));
    }
    weights.join(", ")
}

/// What the self-test adds where the processor rounds otherwise than to nearest.
pub(super) fn weight_of_rounding(checks: &[Check]) -> u32 {
    1 << checks.len()
}

/// An eighth of the distance between 1 and the next number: to nearest, 1 with it or without it
/// is 1, and in every other mode one of the two is not.
pub(super) fn eighth_of_ulp(scalar: Scalar) -> String {
    number(
        scalar
            .precision()
            .map_or(0.0, |precision| precision.unit() / 4.0),
        scalar,
        0,
    )
}

/// Comparisons of the functions that are there, and the arrays they write to.
pub(super) fn checks(
    facts: &Facts,
    scalar: Scalar,
    routines: &[Exported],
    name: &str,
    ticks: Option<&Ticks>,
) -> (Vec<Check>, Vec<ResultArray>) {
    let test = &facts.self_test;
    let posture = &test.posture;
    // An array may not be empty: a robot without joints gets what is at hand.
    let any = format!("{name}_cad_params");
    let positions = if posture.is_empty() {
        any.as_str()
    } else {
        "q"
    };
    let q = (!posture.is_empty()).then(|| Constant {
        scalar: format!("{name}_real"),
        name: "q".into(),
        values: in_format(posture, scalar, array_bits(routines, Argument::Positions)),
    });
    let mut checks = Vec::new();
    let mut push = |wanted: Wanted, expected: &[f64], mut arrays: Vec<Constant>, slack: f64| {
        let Some(routine) = routines.iter().find(|routine| wanted.is(routine)) else {
            return;
        };
        let stem = routine.name();
        let bits = routine.formats.as_ref().map_or(0, |formats| formats.output);
        let got = routine.output();
        let label = format!("expected_{stem}");
        let tolerance = tolerance(routine, scalar, expected, slack);
        arrays.push(Constant {
            scalar: format!("{name}_real"),
            name: label.clone(),
            values: in_format(expected, scalar, bits),
        });
        let argument = match routine.function {
            Function::CorrectCop => "reading",
            _ if routine.is_of_ticks() => "ticks",
            _ => positions,
        };
        let context = match takes_context(&routine.program) {
            true => {
                let usual: Vec<f64> = facts.context.iter().map(|(_, usual)| *usual).collect();
                let bits = array_bits(routines, Argument::Context);
                arrays.push(Constant {
                    scalar: format!("{name}_real"),
                    name: format!("context_{stem}"),
                    values: in_format(&usual, scalar, bits),
                });
                format!("context_{stem}, ")
            }
            false => String::new(),
        };
        let r = match routine.takes_parameters() {
            true => format!("{name}_cad_params, "),
            false => String::new(),
        };
        checks.push(Check {
            arrays,
            call: format!("{name}_{stem}({argument}, {r}{context}{got});"),
            got,
            expected: label,
            count: expected.len(),
            tolerance: number(tolerance, scalar, bits),
            weight: 0,
            stem,
        });
    };
    let wanted = |function| Wanted {
        function,
        of_ticks: false,
        baked: false,
    };
    push(
        wanted(Function::Com),
        &test.com,
        q.into_iter().collect(),
        0.0,
    );
    let effects = facts.has_static_effects();
    match effects {
        false => push(wanted(Function::Cop), &test.com[..2], Vec::new(), 0.0),
        true => {
            let expected = by_tape(facts, Function::Cop, &facts.cad_params());
            push(wanted(Function::Cop), &expected, Vec::new(), 0.0);
        }
    }
    push(
        wanted(Function::GravityMoments),
        &test.moments,
        Vec::new(),
        test.moments_error,
    );
    if let Some(ticks) = ticks {
        let (values, posture) = nearest(ticks, posture);
        let com = test.com_at(&posture);
        let array = Constant {
            scalar: "int32_t".into(),
            name: "ticks".into(),
            values: values.iter().map(i32::to_string).collect(),
        };
        let com_of_ticks = Wanted {
            of_ticks: true,
            ..wanted(Function::Com)
        };
        push(com_of_ticks, &com, vec![array], 0.0);
    }
    if let Some(identified) = &facts.identified {
        let functions = [Function::Com, Function::Cop];
        for function in functions.into_iter().take(1 + usize::from(effects)) {
            let baked = Wanted {
                baked: true,
                ..wanted(function)
            };
            let expected = by_tape(facts, function, &identified.values);
            push(baked, &expected, Vec::new(), 0.0);
        }
    }
    let reading = Constant {
        scalar: format!("{name}_real"),
        name: "reading".into(),
        values: in_format(
            &test.reading,
            scalar,
            array_bits(routines, Argument::Reading),
        ),
    };
    push(wanted(Function::CorrectCop), &test.cop, vec![reading], 0.0);
    for (k, check) in checks.iter_mut().enumerate() {
        check.weight = 1 << k;
    }
    let dof = format!("{name}_DOF");
    let arrays = [("com", "3"), ("cop", "2"), ("moments", &dof)];
    let is_written = |array: &str| checks.iter().any(|check| check.got == array);
    let written = arrays.into_iter().filter(|(array, _)| is_written(array));
    let results = written.map(|(name, length)| ResultArray {
        name,
        length: length.to_string(),
    });
    let results = results.collect();
    (checks, results)
}

fn in_format(values: &[f64], scalar: Scalar, bits: i32) -> Vec<String> {
    values.iter().map(|x| number(*x, scalar, bits)).collect()
}

/// The proven bound, and the rounding of what is expected.
fn tolerance(routine: &Exported, scalar: Scalar, expected: &[f64], slack: f64) -> f64 {
    let largest = expected.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let rounding = match (&routine.formats, scalar.precision()) {
        (Some(formats), _) => libm::ldexp(1.0, -formats.output),
        (None, Some(precision)) => 2.0 * precision.unit() * largest.max(routine.bound.min(1e3)),
        (None, None) => 0.0,
    };
    // A side that may flip, or an iteration: far from what is met in this posture.
    let bound = match (routine.counts.other, scalar) {
        (0, _) | (_, Scalar::Fixed32) => routine.bound,
        (_, Scalar::F64) => routine.bound.min(LOOSE[0]),
        (_, Scalar::F32) => routine.bound.min(LOOSE[1]),
    };
    // Summation by another way has rounding of its own, in f64.
    bound + rounding + slack + 64.0 * f64::EPSILON * largest
}

/// Ticks nearest to a posture, and the posture that they stand for.
fn nearest(ticks: &Ticks, posture: &[f64]) -> (Vec<i32>, Vec<f64>) {
    let pairs = ticks.servos.iter().zip(posture).map(|(servo, q)| {
        let away = libm::rint(q / servo.per_tick());
        (
            servo.zero.saturating_add(away as i32),
            away * servo.per_tick(),
        )
    });
    pairs.unzip()
}

/// A function of `params` in the posture of the test, by the program that takes them.
fn by_tape(facts: &Facts, function: Function, params: &[f64]) -> Vec<f64> {
    let of = |r: &&Routine| r.function == function && r.given == Given::Positions && !r.baked;
    let Some(Routine { program, .. }) = facts.routines.iter().find(of) else {
        return Vec::new();
    };
    let mut out = vec![0.0; program.outputs.len()];
    let arguments = [
        Values::PerPosture(&facts.self_test.posture),
        Values::Shared(params),
    ];
    Tape::new(program).run(&arguments, 1, &mut out, Kernels::LIBM);
    out
}
