//! The estimator gives the bits of the runtime's.

use std::fs;
use std::path::Path;
use std::process::Command;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_codegen::emit::c::{self, Options, Scalar};
use sesc_codegen::facts::Facts;
use sesc_generated::{op2_r_sole as op2, two_link_foot as two_link};
use sesc_identify::evaluate::PORTABLE;
use sesc_model::tape::{Tape, Values};
use sesc_model::{Function, Given};
use sesc_runtime::fit::Estimator;
use sesc_runtime::{Const, Posture, Scalar as Number, Sesc};

use super::case::Case;
use super::compiled::{SEPARATE, WARNINGS, folder, parallel, printed, tool, write};
use super::draw::Draw;
use crate::COMPILERS;

const POSTURES: usize = 120;

/// Where an estimator begins.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Start {
    /// CAD with the same deviation on every parameter, m.
    Prior(f64),
    /// The model file.
    File,
}

/// What is fed: joint positions and readings, and the deviations of these, m.
struct Log {
    q: Vec<Vec<f64>>,
    readings: Vec<[f64; 2]>,
    cop_std: [f64; 2],
}

fn log(case: &Case, cop_std: [f64; 2]) -> Log {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let dofs = &case.model.tree.dofs;
    let q: Vec<Vec<f64>> = (0..POSTURES)
        .map(|_| dofs.iter().map(|_| rng.random_range(-0.5..0.5)).collect())
        .collect();
    let all: Vec<f64> = q.concat();
    let r: Vec<f64> = case.model.cad_params().iter().map(|r| r + 0.003).collect();
    let cop = case.tape(Function::Cop, &all, &r.repeat(POSTURES), &Draw::default());
    let mut error = 0.0;
    let readings = cop.chunks_exact(2).enumerate().map(|(k, cop)| {
        // Errors that last: five postures share one.
        if k % 5 == 0 {
            error = rng.random_range(-1e-3..1e-3);
        }
        [cop[0] + error, cop[1] - 2e-4]
    });
    let readings = readings.collect();
    Log {
        q,
        readings,
        cop_std,
    }
}

/// The driver: estimates after every tenth posture, then what must be refused.
fn driver(name: &str, start: Start) -> String {
    let begin = match start {
        Start::Prior(_) => format!("{name}_estimator_init(&e, r, r_std, cop_std)"),
        Start::File => format!("{name}_estimator_resume(&e, cop_std)"),
    };
    format!(
        r#"#include "{name}.h"
#include <stdio.h>
#include <string.h>

static {name}_estimator e, before;
static {name}_real r[{name}_BASE_PARAMS], r_std[{name}_BASE_PARAMS], cop_std[2];
static {name}_real found[{name}_BASE_PARAMS], alone[{name}_BASE_PARAMS];
static {name}_real q[{name}_DOF], reading[2], zero[2], worth;

int main(void)
{{
    int k = 0;
    if ((fread(r, sizeof r, 1u, stdin) != 1u) || (fread(r_std, sizeof r_std, 1u, stdin) != 1u)
        || (fread(cop_std, sizeof cop_std, 1u, stdin) != 1u) || ({begin} != 0)) {{
        return 2;
    }}
    while ((fread(q, sizeof q, 1u, stdin) == 1u)
        && (fread(reading, sizeof reading, 1u, stdin) == 1u)) {{
        if ({name}_estimator_add(&e, q, reading) != 0) {{
            return 3;
        }}
        k += 1;
        if ((k % 10) == 0) {{
            {name}_estimator_solve(&e, found, r_std);
            {name}_estimator_params(&e, alone);
            if (memcmp(found, alone, sizeof found) != 0) {{
                return 4;
            }}
            (void)fwrite(found, sizeof found, 1u, stdout);
            (void)fwrite(r_std, sizeof r_std, 1u, stdout);
            (void)fwrite(&e.residual, sizeof e.residual, 1u, stdout);
            worth = {name}_estimator_independent_postures(&e);
            (void)fwrite(&worth, sizeof worth, 1u, stdout);
        }}
    }}
    (void)memcpy(&before, &e, sizeof e);
    zero[1] = cop_std[1];
    if (({name}_estimator_init(&e, r, r, zero) != 1)
        || ({name}_estimator_init(&e, r, zero, cop_std) != 1)) {{
        return 5;
    }}
    reading[0] = zero[0] / zero[0];
    if ({name}_estimator_add(&e, q, reading) != 1) {{
        return 6;
    }}
    reading[0] = cop_std[0] / zero[0];
    if ({name}_estimator_add(&e, q, reading) != 1) {{
        return 7;
    }}
    q[0] = zero[0] / zero[0];
    reading[0] = zero[0];
    if ({name}_estimator_add(&e, q, reading) != 1) {{
        return 8;
    }}
    return (memcmp(&before, &e, sizeof e) != 0) || (e.postures != {POSTURES}u);
}}
"#
    )
}

/// What the C finds: parameters, deviations, residual and independent postures after every
/// tenth posture, as bits.
fn c(
    folder: &Path,
    case: &Case,
    scalar: Scalar,
    log: &Log,
    start: Start,
    build: [&str; 2],
) -> Vec<u64> {
    let name = &case.name;
    let folder = folder.join(format!("{name}_{scalar:?}_{start:?}_{}", build.concat()));
    fs::create_dir_all(&folder).unwrap();
    let source = write(&folder, name, &case.package(scalar));
    fs::write(folder.join("main.c"), driver(name, start)).unwrap();
    let mut command = Command::new(build[0]);
    command.args(WARNINGS).args([SEPARATE, build[1]]);
    command.arg(source).arg(folder.join("main.c"));
    printed(command.arg("-o").arg(folder.join("program")));
    let cad = case.model.cad_params();
    let std = match start {
        Start::Prior(std) => std,
        Start::File => 1.0,
    };
    let mut numbers = cad.clone();
    numbers.extend(vec![std; cad.len()]);
    numbers.extend(log.cop_std);
    for (q, reading) in log.q.iter().zip(&log.readings) {
        numbers.extend(q);
        numbers.extend(reading);
    }
    let bytes = numbers.iter().flat_map(|x| match scalar {
        Scalar::F32 => (*x as f32).to_le_bytes().to_vec(),
        _ => x.to_le_bytes().to_vec(),
    });
    fs::write(folder.join("input"), bytes.collect::<Vec<u8>>()).unwrap();
    let mut command = Command::new(folder.join("program"));
    command.stdin(fs::File::open(folder.join("input")).unwrap());
    let output = tool(&mut command).unwrap_or_else(|message| panic!("{message}"));
    let size = if scalar == Scalar::F32 { 4 } else { 8 };
    let of = |bytes: &[u8]| match scalar {
        Scalar::F32 => u64::from(u32::from_le_bytes(bytes.try_into().unwrap())),
        _ => u64::from_le_bytes(bytes.try_into().unwrap()),
    };
    output.chunks_exact(size).map(of).collect()
}

/// What the runtime finds.
fn rust<R, T, const N: usize>(case: &Case, log: &Log, start: Start, bits: fn(T) -> u64) -> Vec<u64>
where
    R: Sesc<Base = Const<N>>,
    T: Number,
{
    let scalar = |x: f64| T::from_f64(x);
    let mut estimator = match start {
        Start::Prior(std) => {
            let cad: Vec<T> = case.model.cad_params().into_iter().map(scalar).collect();
            Estimator::<T, N>::with_prior(cad.as_slice().try_into().unwrap(), &[scalar(std); N])
        }
        Start::File => {
            let file = case.model.file.as_ref().unwrap();
            let factor = file.information.as_ref().unwrap().packed();
            Estimator::resume(file.values().as_slice().try_into().unwrap(), &factor)
        }
    }
    .unwrap();
    let correct = case.model.program(Function::CorrectCop, Given::Positions);
    let mut found = Vec::new();
    for (k, (posture, reading)) in log.q.iter().zip(&log.readings).enumerate() {
        let mut q: Posture<R, T> = <R::Dof as sesc_runtime::Dim>::filled(T::ZERO);
        let both = q.as_mut().iter_mut().zip(posture);
        both.for_each(|(q, x)| *q = scalar(*x));
        let mut cop = *reading;
        if let Some(program) = &correct {
            let reading = [Values::PerPosture(reading)];
            Tape::new(program).run(&reading, 1, &mut cop, PORTABLE);
        }
        let (cop, std) = (cop.map(scalar), log.cop_std.map(scalar));
        estimator.add_posture::<R>(&q, &cop, &std).unwrap();
        if k % 10 == 9 {
            found.extend(estimator.params().map(bits));
            found.extend(estimator.deviations().map(bits));
            found.push(bits(estimator.residual_sum_of_squares()));
            found.push(bits(T::from_f64(estimator.independent_postures())));
        }
    }
    found
}

/// Every start in both scalars; readings so exact that rows become light among them.
#[test]
fn estimators_give_the_bits_of_the_runtime() {
    let folder = folder("estimator");
    let mut op2 = Case::robot("op2", "r_sole").informed();
    // What the estimator calls; `bits` compiles the others.
    op2.functions = vec![Function::Cop, Function::RegressorCop];
    let two_link = Case::robot("two_link", "foot").informed();
    let gain = Case::with_effect("sensor_rotation", "-", ("yaw_rad", 0.02)).informed();
    let mut jobs = Vec::new();
    for (k, case) in [&op2, &two_link, &gain].into_iter().enumerate() {
        let starts = [
            (Start::Prior(0.01), [1e-3, 2e-3]),
            (Start::Prior(0.01), [2e-6; 2]),
            (Start::Prior(f64::MAX), [1e-3; 2]),
            (Start::File, [1e-3; 2]),
        ];
        for (j, (start, cop_std)) in starts.into_iter().enumerate() {
            let compiler = COMPILERS[(j + k) % COMPILERS.len()];
            let build = [compiler, ["-O2", "-O3", "-O0", "-O1"][(j + k) % 4]];
            jobs.push((k, case, start, cop_std, build));
        }
    }
    parallel(jobs, |(k, case, start, cop_std, build)| {
        let log = log(case, cop_std);
        let single = match start {
            Start::Prior(std) => Start::Prior(std.min(1e30)),
            Start::File => start,
        };
        let [double_bits, single_bits] = match k {
            0 => [
                rust::<op2::Op2RSole, f64, 43>(case, &log, start, f64::to_bits),
                rust::<op2::Op2RSole, f32, 43>(case, &log, single, |x| x.to_bits().into()),
            ],
            _ => [
                rust::<two_link::TwoLinkFoot, f64, 7>(case, &log, start, f64::to_bits),
                rust::<two_link::TwoLinkFoot, f32, 7>(case, &log, single, |x| x.to_bits().into()),
            ],
        };
        let name = format!("{} {start:?} {build:?}", case.name);
        let found = c(&folder, case, Scalar::F64, &log, start, build);
        assert_eq!(found, double_bits, "{name}");
        let worth = f64::from_bits(*double_bits.last().unwrap());
        assert!(k != 1 || worth < 0.6 * POSTURES as f64, "{name}: {worth}");
        // The runtime's reading is corrected in f64 here.
        if k != 2 {
            let found = c(&folder, case, Scalar::F32, &log, single, build);
            let each = 2 * case.model.base.params.len() + 2;
            let pairs = found.chunks(each).zip(single_bits.chunks(each));
            for pair in pairs {
                let ([found @ .., worth], [expected @ .., rounded]) = pair else {
                    panic!("{name}: no record");
                };
                assert_eq!(found, expected, "{name}");
                // The runtime counts in f64.
                let number = |bits: &u64| f64::from(f32::from_bits(*bits as u32));
                let off = number(worth) / number(rounded) - 1.0;
                assert!(off.abs() < 1e-5, "{name}: {off:e}");
            }
            assert_eq!(found.len(), single_bits.len(), "{name}");
        }
    });
}

#[test]
fn fixed_point_has_no_estimator() {
    let case = Case::robot("two_link", "foot");
    let mut options = Options::of(Scalar::Fixed32);
    options.estimator = true;
    let error = c::package(&Facts::of(&case.model), "leg", &options).unwrap_err();
    assert!(error.to_string().contains("use f32 or f64"), "{error}");
    assert!(!case.package(Scalar::F32).header.contains("estimator"));
}
