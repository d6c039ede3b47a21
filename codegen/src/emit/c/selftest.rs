//! The self-test that firmware runs at boot: a posture whose results the
//! generator computed in another way.

use minijinja::context;
use minijinja::value::Value;
use serde::Serialize;

use super::exported::{Exported, Input, array_bits};
use super::ticks::Ticks;
use super::{Scalar, listed, number};
use crate::facts::Facts;
use crate::routines::{Routine, takes_context};
use sesc_model::expr::Argument;
use sesc_model::tape::{Kernels, Tape, Values};
use sesc_model::{Function, Given};

/// Errors that only a defect makes, m: in f64, in f32.
const LOOSE: [f64; 2] = [1e-9, 1e-4];

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

/// A function, with what it must give: what callers pass, whether the parameters of the model file
/// are in it, and how far the expectation may be off.
type Expectation = (Function, Input, bool, Vec<f64>, f64);

/// What the functions that are there must give.
fn expectations(facts: &Facts, ticks: Option<&[f64]>) -> Vec<Expectation> {
    let test = &facts.self_test;
    let effects = facts.has_static_effects();
    let of = |function, baked, expected| (function, Input::Program, baked, expected, 0.0);
    let cop = match effects {
        false => test.com[..2].to_vec(),
        true => by_tape(facts, Function::Cop, &facts.model.cad_params()),
    };
    let moments = (test.moments.clone(), test.moments_error);
    let mut all = vec![
        of(Function::Com, false, test.com.to_vec()),
        of(Function::Cop, false, cop),
        (
            Function::GravityMoments,
            Input::Program,
            false,
            moments.0,
            moments.1,
        ),
    ];
    all.extend(ticks.map(|posture| {
        let com = facts.model.expected_com(posture).to_vec();
        (Function::Com, Input::Ticks, false, com, 0.0)
    }));
    if let Some(identified) = &facts.identified {
        let functions = [Function::Com, Function::Cop].into_iter();
        all.extend(
            functions
                .take(1 + usize::from(effects))
                .map(|function| of(function, true, by_tape(facts, function, &identified.values))),
        );
    }
    all.push(of(Function::CorrectCop, false, test.cop.to_vec()));
    all
}

/// Comparisons of the functions that are there, and the arrays they write to, as the templates
/// ask for them.
pub(super) fn texts(
    facts: &Facts,
    scalar: Scalar,
    routines: &[Exported],
    name: &str,
    ticks: Option<&Ticks>,
) -> Value {
    let test = &facts.self_test;
    let real = format!("{name}_real");
    let array = |of: &str, name: String, values| Constant {
        scalar: of.to_string(),
        name,
        values,
    };
    let numbers = |name: &str, values: &[f64], bits| {
        let values = values.iter().map(|x| number(*x, scalar, bits));
        array(&real, name.to_string(), values.collect())
    };
    // An array may not be empty: a robot without joints gets what is at hand.
    let is_empty = test.posture.is_empty();
    let positions = if is_empty {
        format!("{name}_cad_params")
    } else {
        "q".to_string()
    };
    let ticks = ticks.map(|ticks| nearest(ticks, &test.posture));
    let (ticks, at) = ticks.unzip();
    let mut checks: Vec<Check> = Vec::new();
    for (function, input, baked, expected, slack) in expectations(facts, at.as_deref()) {
        let is_it = |routine: &&Exported| {
            (routine.function, routine.input, routine.baked) == (function, input, baked)
                && (input == Input::Ticks || routine.given == Given::Positions)
        };
        let Some(routine) = routines.iter().find(is_it) else {
            continue;
        };
        let stem = routine.name();
        let bits = routine.formats.as_ref().map_or(0, |formats| formats.output);
        let bits_of = |argument| array_bits(routines, argument);
        let (argument, mut arrays) = match (function, input) {
            (Function::CorrectCop, _) => {
                let bits = bits_of(Argument::Reading);
                ("reading", vec![numbers("reading", &test.reading, bits)])
            }
            (_, Input::Ticks) => {
                let values = ticks.iter().flatten().map(i32::to_string);
                (
                    "ticks",
                    vec![array("int32_t", "ticks".into(), values.collect())],
                )
            }
            // The first of all.
            _ if checks.is_empty() && !is_empty => {
                let bits = bits_of(Argument::Positions);
                ("q", vec![numbers("q", &test.posture, bits)])
            }
            _ => (&*positions, Vec::new()),
        };
        let label = format!("expected_{stem}");
        arrays.push(numbers(&label, &expected, bits));
        let mut passed = format!("{argument}, ");
        if routine.takes_parameters() {
            passed += &format!("{name}_cad_params, ");
        }
        if takes_context(&routine.program) {
            let usual: Vec<f64> = facts.context.iter().map(|(_, usual)| *usual).collect();
            let context = format!("context_{stem}");
            arrays.push(numbers(&context, &usual, bits_of(Argument::Context)));
            passed += &format!("{context}, ");
        }
        let got = routine.output();
        let tolerance = tolerance(routine, scalar, &expected, slack);
        checks.push(Check {
            arrays,
            call: format!("{name}_{stem}({passed}{got});"),
            got,
            expected: label,
            count: expected.len(),
            tolerance: number(tolerance, scalar, bits),
            weight: 1 << checks.len(),
            stem,
        });
    }
    let dof = format!("{name}_DOF");
    let results = [("com", "3"), ("cop", "2"), ("moments", &dof)];
    let is_written = |array: &str| checks.iter().any(|check| check.got == array);
    let results = results.into_iter().filter(|(array, _)| is_written(array));
    let results = results.map(|(name, length)| (name.to_string(), length.to_string()));
    let results: Vec<(String, String)> = results.collect();
    // What the self-test adds where the processor rounds otherwise than to nearest.
    let rounding = 1 << checks.len();
    let weights = checks.iter();
    let mut weights: Vec<String> = weights
        .map(|check| format!("{} ({})", check.weight, check.stem))
        .collect();
    if scalar != Scalar::Fixed32 {
        weights.push(format!("{rounding} (sums are not rounded to nearest)"));
    }
    // An eighth of the distance between 1 and the next number: to nearest, 1 with it or without
    // it is 1, and in every other mode one of the two is not.
    let eighth = scalar
        .precision()
        .map_or(0.0, |precision| precision.unit() / 4.0);
    context! {
        selftest_weights => weights.join(", "),
        selftest_rounding => rounding,
        eighth_of_ulp => number(eighth, scalar, 0),
        selftest => listed(checks),
        selftest_results => listed(results),
    }
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
