//! The bounds that headers promise, against exact evaluation: never exceeded.
//!
//! For f32 and fixed32 the tape in f64 is exact enough: its own proven bound is
//! a ten-millionth of theirs and is allowed for. For f64 programs run in pairs
//! of doubles.

use astro_float::{BigFloat, Consts, RoundingMode};
use sesc_codegen::emit::c::Scalar;
use sesc_model::bounds::Precision;
use sesc_model::tree::Dof;
use sesc_model::{Function, Given};

use super::case::{Case, ROBOTS, Servo};
use super::compiled::{Compiled, folder, parallel, row};
use super::draw::{Draw, draw};
use super::entry::Entry;
use crate::COMPILERS;
use sesc_test_support::exact::{Double, Interpreter, Number};

/// Postures of the OP2 for its CoM.
const MANY: usize = 100_000;

/// Largest |a − b|; a NaN is larger than all.
pub(crate) fn largest(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, |most, x| if x.is_nan() || x > most { x } else { most })
}

/// The larger of two numbers, of which a NaN counts as infinite.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    match b.is_nan() {
        true => f64::INFINITY,
        false => a.max(b),
    }
}

/// Each entry's error on `drawn`, held against the bound in the header.
///
/// Names with what was measured and what is proven, m.
pub(crate) fn check(
    case: &Case,
    compiled: &Compiled,
    entries: &[Entry],
    drawn: &Draw,
) -> Vec<(String, f64, f64)> {
    let found = compiled.run(case, entries, drawn);
    let mut rows = Vec::new();
    for (entry, found) in entries.iter().zip(&found) {
        let q = match entry.given {
            None => &drawn.turned,
            Some(_) => &drawn.q,
        };
        let r = match entry.baked {
            true => &case.model.params().repeat(drawn.q.len()),
            false => &drawn.r,
        };
        let exact = case.tape(entry.function, q, r, drawn);
        let program = case.model.program(entry.function, Given::Positions);
        let own = case.model.rounding(&program.unwrap(), Precision::F64).worst;
        let (measured, proven) = (largest(found, &exact), compiled.bound(entry));
        let name = format!("{}_{}", case.name, entry.name);
        assert!(
            measured <= proven + own,
            "{name}: {measured:.2e} of {proven:.2e}"
        );
        rows.push((entry.name.clone(), measured, proven));
    }
    rows
}

/// What a firmware engineer reads: micrometres, on a hundred thousand postures.
#[test]
fn the_op2s_com_is_proven_to_three_micrometres_and_measured_to_half_of_one() {
    let folder = folder("many");
    let case = Case::robot("op2", "r_sole");
    let mut entries = case.entries(Scalar::F64);
    entries.retain(|entry| entry.function == Function::Com);
    // Binary points are of all functions; floats of one function do not depend on the others.
    let alone = Case {
        functions: vec![Function::Com],
        ..Case::robot("op2", "r_sole")
    };
    let jobs = vec![
        (&alone, Scalar::F32, "-O2"),
        (&case, Scalar::Fixed32, "-O0"),
    ];
    parallel(jobs, |(case, scalar, level)| {
        let compiled = Compiled::plain(&folder, case, scalar, COMPILERS[0], level);
        let drawn = draw(case, MANY, 23, &*compiled.hold());
        let rows = check(case, &compiled, &entries, &drawn);
        assert_eq!(rows.len(), 3, "com, com_sc, com_ticks");
        for (name, measured, proven) in rows {
            println!("op2 {scalar:?} {name}: {measured:.2e} of {proven:.2e} m");
            assert!(proven <= 3e-6, "{name}: proven {proven:.1e}");
            assert!(measured <= 0.5e-6, "{name}: measured {measured:.1e}");
        }
    });
}

/// Of a ZMP in f32 without a bound below a millimetre the header says what was seen: no posture of
/// ours is off by ten times as much, and none has a bound beyond a millimetre.
#[test]
fn a_zmp_has_a_bound_below_a_millimetre_or_the_error_that_was_seen() {
    let folder = folder("seen");
    let zmp = |robot: &str, support: &str| Case {
        functions: vec![Function::Com, Function::Zmp],
        ..Case::robot(robot, support)
    };
    let cases = ROBOTS.map(|(robot, support)| zmp(robot, support));
    let seen = parallel(cases.iter().collect(), |case| {
        let compiled = Compiled::plain(&folder, case, Scalar::F32, COMPILERS[0], "-O1");
        let mut entries = case.entries(Scalar::F32);
        entries.retain(|entry| entry.function == Function::Zmp);
        let mut drawn = draw(case, 600, 61, &*compiled.hold());
        drawn.r = case.model.cad_params().repeat(600);
        let rows = check(case, &compiled, &entries, &drawn);
        let header = case.package(Scalar::F32).header;
        for (name, measured, proven) in &rows {
            let what = format!("{}_{name}", case.name);
            assert!(*proven <= 1e-3 || proven.is_infinite(), "{what}: {proven}");
            if proven.is_infinite() {
                let row = row(&header, name);
                assert_eq!(row[5..7], ["none;", "seen"], "{what}");
                let seen: f64 = row[7].parse().unwrap();
                assert!(
                    *measured < 10.0 * seen,
                    "{what}: {measured:.1e} of {seen:.1e}"
                );
                assert!(seen < 1e-4, "{what}: {seen:.1e} m");
            }
        }
        rows.iter().any(|row| row.2.is_infinite())
    });
    assert!(seen.contains(&true) && seen.contains(&false), "{seen:?}");
}

/// Largest distance of `found` from the same program in pairs of doubles.
pub(crate) fn in_pairs(case: &Case, entry: &Entry, drawn: &Draw, found: &[f64]) -> f64 {
    let program = case.model.program(entry.function, Given::Positions);
    let interpreter = Interpreter::new(&program.unwrap());
    let dof = case.model.dof();
    let servos = case.servos();
    let mut worst: f64 = 0.0;
    for (k, found) in found.chunks(entry.width).enumerate() {
        let row = k * dof..(k + 1) * dof;
        let doubles = |all: &[f64]| -> Vec<Double> { all.iter().map(|x| Double::of(*x)).collect() };
        let [qd, qdd] = drawn
            .motion(entry.function)
            .map(|all| doubles(&all[row.clone()]));
        let of_ticks = |((ticks, servo), dof): ((&i32, &Servo), &Dof)| {
            let away = f64::from(ticks - servo.zero);
            match dof.prismatic {
                true => Double::of(away).mul(Double::of(servo.per_tick)),
                false => servo.turned(away),
            }
        };
        let q = match entry.given {
            Some(_) => doubles(&drawn.q[row]),
            None => {
                let ticks = drawn.ticks[row].iter().zip(&servos);
                ticks.zip(&case.model.tree.dofs).map(of_ticks).collect()
            }
        };
        let params = case.model.base.params.len();
        let r = match entry.baked {
            true => case.model.params(),
            false => drawn.r[k * params..(k + 1) * params].to_vec(),
        };
        let r = doubles(&r);
        let mut inputs = vec![q.as_slice()];
        inputs.extend(entry.takes_velocities().then_some(qd.as_slice()));
        inputs.extend(entry.takes_accelerations().then_some(qdd.as_slice()));
        inputs.extend(entry.function.takes_parameters().then_some(r.as_slice()));
        let exact = interpreter.run(&inputs);
        let errors = exact
            .iter()
            .zip(found)
            .map(|(exact, found)| exact.distance(*found));
        worst = errors.fold(worst, larger);
    }
    worst
}

/// Pairs of doubles against 256 bits.
#[test]
fn pairs_of_doubles_are_as_exact_as_they_must_be() {
    let mut constants = Consts::new().unwrap();
    let big = |x: Double| {
        let high = BigFloat::from_f64(x.high, 256);
        high.add(&BigFloat::from_f64(x.low, 256), 256, RoundingMode::ToEven)
    };
    let distance = |a: &BigFloat, b: Double| -> f64 {
        let difference = a.sub(&big(b), 256, RoundingMode::ToEven);
        difference.to_string().parse::<f64>().unwrap().abs()
    };
    let even = RoundingMode::ToEven;
    for k in -500..=500 {
        let third = Double::of(f64::from(k) * 0.0371);
        let x = third.mul(Double::of(1.0 / 3.0));
        let (s, c) = x.sin_cos();
        for (exact, found) in [
            (big(x).sin(256, even, &mut constants), s),
            (big(x).cos(256, even, &mut constants), c),
            (big(x).mul(&big(s), 256, even), x.mul(s)),
            (big(x).add(&big(s), 256, even), x.add(s)),
        ] {
            assert!(distance(&exact, found) < 1e-30, "{k}");
        }
    }
}
