//! Quotients, clamps and powers in programs made by hand: tape, compiled Rust and
//! compiled C give the same bits, inside proven bounds of exact arithmetic.

mod build;
mod programs;

use std::process::Command;

use build::{ROOT, Rows, WARNINGS, folder, tool, write_c};
use programs::{Case, bare, cases, edges};
use sesc_identify::evaluate::PORTABLE;
use sesc_model::bounds::{self, Precision};
use sesc_model::program::Program;
use sesc_model::tape::{Tape, Values};
use sesc_test_support::exact::{Double, Interpreter, Number};

const ROWS: usize = 2_000;
const PRECISIONS: [Precision; 2] = [Precision::F64, Precision::F32];

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

#[test]
fn tape_rust_and_c_give_the_same_bits() {
    let cases: Vec<(Case, Vec<[Vec<f64>; 2]>)> = cases()
        .into_iter()
        .map(|case| {
            let rows = case.rows(ROWS);
            (case, rows)
        })
        .chain([(bare(), edges())])
        .collect();
    let borrowed: Vec<(&Case, &Rows)> = cases.iter().map(|(c, r)| (c, r.as_slice())).collect();
    let compiled = build::rust(&borrowed);
    for ((case, rows), [double, single, lanes]) in borrowed.iter().zip(&compiled) {
        let name = case.name;
        let by_tape = by_tape(&case.program, rows);
        let narrow = by_nodes::<f32>(&case.program, rows)
            .into_iter()
            .map(f64::from);
        let narrow: Vec<f64> = narrow.collect();
        assert_same(&format!("{name}, Rust"), double, &by_tape);
        assert_same(&format!("{name}, lanes"), lanes, &by_tape);
        assert_same(&format!("{name}, Rust f32"), single, &narrow);
        for precision in PRECISIONS {
            let expected = match precision {
                Precision::F64 => &by_tape,
                Precision::F32 => &narrow,
            };
            for (compiler, level) in [("gcc", "-O0"), ("gcc", "-O3"), ("clang", "-O2")] {
                let found = build::c(case, rows, precision, compiler, &[level]);
                let what = format!("{name} {precision:?}, {compiler} {level}");
                assert_same(&what, &found, expected);
            }
        }
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

#[test]
fn c_needs_no_library_and_takes_it_where_asked() {
    let folder = folder("c");
    for case in cases().into_iter().chain([bare()]) {
        for precision in PRECISIONS {
            let source = write_c(&folder, &case, precision);
            let libm = format!("-D{}_USE_LIBM", case.name);
            for compiler in ["gcc", "clang"] {
                for define in ["-DNOTHING", &libm] {
                    let mut command = Command::new(compiler);
                    command.args(WARNINGS).args(["-fsyntax-only", define]);
                    tool(command.arg(&source));
                }
            }
            let object = folder.join("object.o");
            let mut command = Command::new("gcc");
            command
                .args(["-std=c99", "-O0", "-fno-pic", "-c"])
                .arg(&source);
            tool(command.arg("-o").arg(&object));
            let symbols = tool(Command::new("nm").arg("-u").arg(&object));
            for line in String::from_utf8(symbols).unwrap().lines() {
                let symbol = line.split_whitespace().last().unwrap_or_default();
                assert!(["memcpy", "__stack_chk_fail"].contains(&symbol), "{line}");
            }
        }
    }
    // The library's powers are those of other hands.
    let case = &cases()[1];
    let rows = case.rows(100);
    let found = build::c(
        case,
        &rows,
        Precision::F64,
        "gcc",
        &["-O2", "-Dexponents_USE_LIBM"],
    );
    for (a, b) in found.iter().zip(by_tape(&case.program, &rows)) {
        assert!((a - b).abs() <= 4.0 * f64::EPSILON * b.abs());
    }
}

/// As for whole packages: nothing but the departures that `misra.md` lists.
#[test]
fn cppcheck_finds_nothing_new() {
    let folder = folder("cppcheck");
    let list = std::path::Path::new(ROOT).join("codegen/src/emit/c/misra.md");
    let list = std::fs::read_to_string(list).unwrap();
    for case in cases().into_iter().chain([bare()]) {
        for precision in PRECISIONS {
            let source = write_c(&folder, &case, precision);
            let mut command = Command::new("cppcheck");
            command.args([
                "--enable=warning,style,performance,portability",
                "--addon=misra",
            ]);
            command.args([
                "--std=c99",
                "--quiet",
                "--template={id} {file}:{line} {message}",
            ]);
            let output = command.arg(&source).output().expect("install cppcheck");
            for line in String::from_utf8_lossy(&output.stderr).lines() {
                let rule = line.strip_prefix("misra-c2012-").unwrap_or(line);
                let rule = rule.split_whitespace().next().unwrap_or_default();
                assert!(list.contains(&format!("\n| {rule} |")), "{line}");
            }
        }
    }
}
