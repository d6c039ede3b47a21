//! Quotients, clamps, powers and maxima in programs made by hand, inside proven bounds of exact
//! arithmetic; the operations themselves give the same bits on tape, in Rust and in C.

mod kernels;
mod programs;

use programs::{bare, cases, edges};
use sesc_identify::evaluate::PORTABLE;
use sesc_model::bounds::{self, Precision};
use sesc_model::program::Program;
use sesc_model::tape::{Tape, Values};
use sesc_runtime::{Lanes, Real};
use sesc_test_support::exact::{Double, Interpreter, Number};

/// Arguments x and y of a program, row by row.
type Rows = [[Vec<f64>; 2]];

const ROWS: usize = 2_000;

fn by_tape(program: &Program, rows: &Rows) -> Vec<f64> {
    let [x, y] = [0, 1].map(|k| {
        rows.iter()
            .flat_map(|row| row[k].clone())
            .collect::<Vec<f64>>()
    });
    let tape = Tape::new(program);
    let mut out = vec![0.0; rows.len() * tape.outputs()];
    let arguments = [Values::PerPosture(&x), Values::PerPosture(&y)];
    tape.run(&arguments, rows.len(), &mut out, PORTABLE);
    out
}

/// Node by node, in any arithmetic.
fn by_nodes<T: Number>(program: &Program, rows: &Rows) -> Vec<T> {
    let interpreter = Interpreter::new(program);
    let row = |row: &[Vec<f64>; 2]| {
        let [x, y] = [0, 1].map(|k| row[k].iter().map(|v| T::of(*v)).collect::<Vec<T>>());
        interpreter.run(&[&x, &y])
    };
    rows.iter().flat_map(row).collect()
}

#[track_caller]
fn assert_same(what: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (k, (a, b)) in found.iter().zip(expected).enumerate() {
        let same = a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
        assert!(same, "{what}: {a:e} for {b:e} at {k}");
    }
}

/// Quotient, clamp, power and maximum as generated Rust calls them.
fn by_rust<T: Real>(x: T, y: T) -> [T; 4] {
    [x / y, x.clamp_unit(), x.power(y), x.larger(y)]
}

#[test]
fn tape_rust_and_c_give_the_same_bits() {
    let rows = edges();
    let pairs: Vec<[f64; 2]> = rows.iter().map(|[x, y]| [x[0], y[0]]).collect();
    let double: Vec<f64> = pairs.iter().flat_map(|[x, y]| by_rust(*x, *y)).collect();
    assert_same("tape", &by_tape(&bare().program, &rows), &double);
    for (four, alone) in pairs.chunks_exact(4).zip(double.chunks_exact(16)) {
        let lanes = |k: usize| Lanes::<f64, 4>(std::array::from_fn(|at| four[at][k]));
        let found = by_rust(lanes(0), lanes(1));
        let found = (0..4).flat_map(|at| found.map(|lanes| lanes.0[at]));
        assert_same("lanes", &found.collect::<Vec<f64>>(), alone);
    }
    let single = pairs
        .iter()
        .flat_map(|[x, y]| by_rust(*x as f32, *y as f32));
    let single: Vec<f64> = single.map(f64::from).collect();
    for (precision, expected) in [(Precision::F64, &double), (Precision::F32, &single)] {
        for (compiler, level) in [("cc", "-O0"), ("cc", "-O3")] {
            let found = kernels::run(precision, compiler, &[level], &pairs);
            assert_same(
                &format!("{precision:?}, {compiler} {level}"),
                &found,
                expected,
            );
        }
    }
}

/// The library's powers are those of other hands.
#[test]
fn powers_of_libm_are_near() {
    let pairs: Vec<[f64; 2]> = (1..100).map(|k| [f64::from(k) / 7.0, 1.3]).collect();
    let flags = ["-O2", "-Dtwo_link_USE_LIBM"];
    let found = kernels::run(Precision::F64, "cc", &flags, &pairs);
    for ([x, y], found) in pairs.iter().zip(found.chunks(4)) {
        let expected = x.power(*y);
        assert!((found[2] - expected).abs() <= 4.0 * f64::EPSILON * expected);
    }
}

#[test]
fn proven_bounds_hold_and_are_not_idle() {
    for case in cases() {
        let rows = case.rows(ROWS);
        let truth = by_nodes::<Double>(&case.program, &rows);
        let double = by_tape(&case.program, &rows);
        let single = by_nodes::<f32>(&case.program, &rows)
            .into_iter()
            .map(f64::from);
        for (precision, found) in [(Precision::F64, double), (Precision::F32, single.collect())] {
            let bound = bounds::prove(&case.program, &case.inputs(), precision);
            for (k, proven) in bound.outputs.iter().enumerate() {
                let column = |k| (k..truth.len()).step_by(bound.outputs.len());
                let errors = column(k).map(|at| truth[at].distance(found[at]));
                let measured = errors.fold(0.0, f64::max);
                println!(
                    "{} {precision:?} {k}: {measured:.1e} of {proven:.1e}",
                    case.name
                );
                assert!(measured <= *proven);
                // But for signs that may be lost, roots that may be at zero, and f64,
                // where what constants may come with outweighs all rounding.
                let steep = case.name == "backlash" || case.name == "exponents";
                let loose = steep || precision == Precision::F64;
                assert!(loose || *proven <= 300.0 * measured);
            }
        }
    }
    let bound = bounds::prove(&bare().program, &bare().inputs(), Precision::F64);
    assert!(bound.worst.is_infinite());
}

#[test]
fn derivatives_are_differences() {
    for case in cases() {
        let rows = case.rows(200);
        for (k, derivative) in case.derivatives.iter().enumerate() {
            let slopes = by_tape(derivative, &rows);
            let h = (-26_f64).exp2();
            let moved = |by: f64| {
                let mut rows = rows.clone();
                rows.iter_mut().for_each(|row| row[0][k] += by);
                by_nodes::<Double>(&case.program, &rows)
            };
            let (ahead, behind) = (moved(h), moved(-h));
            let mut compared = 0;
            for (at, slope) in slopes.iter().enumerate() {
                let row = &rows[at / case.program.outputs.len()];
                // Off the corners of clamps, and of roots.
                let near = |x: f64, corner: f64| (x - corner).abs() < 1e-4;
                let torque = row[0][0].sin() + row[0].get(1).map_or(0.0, |x| x.cos());
                let corner = match case.name {
                    "saturation" => row[0].iter().zip(&row[1]).any(|(x, y)| near(*x, *y)),
                    "exponents" => row[0][0] < 0.05,
                    "backlash" => near(torque, 0.0),
                    "hat" => {
                        let [x, y] = row;
                        near(x[0], y[0])
                            || near(x[1].abs(), y[1])
                            || near(x[1], 0.0)
                            || near(x[0], x[1])
                    }
                    _ => false,
                };
                if corner {
                    continue;
                }
                compared += 1;
                let change = ahead[at].sub(behind[at]);
                let expected = (change.high + change.low) / (2.0 * h);
                assert!(
                    (slope - expected).abs() <= 1e-7 * (1.0 + expected.abs()),
                    "{} {k}: {slope} for {expected}",
                    case.name
                );
            }
            assert!(compared > slopes.len() / 2, "{}", case.name);
        }
    }
}
