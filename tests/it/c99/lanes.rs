//! Functions of many postures: the bits of one posture in every lane, nothing beyond n
//! touched, whatever the registers; within the bound of the reference.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::COMPILERS;
use sesc_codegen::emit::c::Scalar;
use sesc_model::{Function, Given};

use super::case::{Case, exponent};
use super::compiled::{SEPARATE, WARNINGS, folder, parallel, printed, tool, write};
use super::entry::Entry;

/// Robots of every joint type, with effects that divide, clamp and take powers, with
/// parameters as constants and with a sensor effect that can be inverted.
pub(crate) fn cases() -> Vec<Case> {
    let mut two_link = Case::robot("two_link", "foot");
    two_link.take_values(|_, x| x);
    let mut springs = Case::with_effect("joint_compliance", "all", ("stiffness_nm_per_rad", 200.0));
    springs.name = "springs".to_string();
    vec![
        two_link.of_many(8),
        Case::robot("lift_base", "hand").of_many(16),
        Case::robot("arm6", "base_link").of_many(4),
        Case::robot("quadruped", "lf_foot").of_many(8),
        exponent().of_many(8),
        Case::with_effect("sensor_rotation", "-", ("yaw_rad", 0.02)).of_many(8),
        springs.of_many(16),
    ]
}

/// A function that there is of many postures.
struct Batch {
    name: String,
    /// What it takes of a posture, with the lengths; r comes without.
    arrays: Vec<(&'static str, String)>,
    width: usize,
}

fn functions(case: &Case, scalar: Scalar) -> Vec<Batch> {
    let dof = format!("{}_DOF", case.name);
    let positions = |entry: &Entry| entry.given == Some(Given::Positions);
    let entries = case.entries(scalar).into_iter().filter(positions);
    let mut functions: Vec<Batch> = entries
        .map(|entry| {
            let mut arrays = vec![("q", dof.clone())];
            arrays.extend(entry.takes_velocities().then(|| ("qd", dof.clone())));
            arrays.extend(entry.takes_accelerations().then(|| ("qdd", dof.clone())));
            arrays.extend(entry.takes_parameters().then(|| ("r", String::new())));
            Batch {
                arrays,
                name: entry.name,
                width: entry.width,
            }
        })
        .collect();
    let correction = case.model.program(Function::CorrectCop, Given::Positions);
    functions.extend(correction.map(|_| Batch {
        name: "correct_cop".to_string(),
        arrays: vec![("reading", "2".to_string())],
        width: 2,
    }));
    functions
}

/// Compares every batch with calls of one posture; prints a sum over the bits of results.
fn driver(case: &Case, scalar: Scalar) -> String {
    let name = &case.name;
    let mut checks = String::new();
    let mut calls = String::new();
    for batch in functions(case, scalar) {
        let (function, width) = (batch.name, batch.width);
        let (mut declared, mut one, mut many) = (String::new(), Vec::new(), vec!["n".to_string()]);
        let (mut fills, mut gathers, mut frees) = (String::new(), String::new(), String::new());
        for (array, length) in &batch.arrays {
            if *array == "r" {
                one.push(format!("{name}_cad_params"));
                many.push(format!("{name}_cad_params"));
                continue;
            }
            let _ = writeln!(declared, "    real one_{array}[{length}];");
            let _ = writeln!(fills, "    real *{array} = fresh({length} * n);");
            let _ = writeln!(fills, "    fill_{array}({array}, n);");
            let _ = writeln!(
                gathers,
                "        for (size_t k = 0; k < {length}; k++) one_{array}[k] = {array}[k * n + i];"
            );
            let _ = writeln!(frees, "    release({array});");
            one.push(format!("one_{array}"));
            many.push((*array).to_string());
        }
        let _ = writeln!(
            checks,
            "static void check_{function}(size_t n)\n{{\n{declared}    real expected[{width}];\n{fills}    \
             real *out = fresh({width}u * n);\n    {name}_{function}_batch({}, out);\n    \
             for (size_t i = 0; i < n; i++) {{\n{gathers}        {name}_{function}({}, expected);\n        \
             for (size_t k = 0; k < {width}; k++) same(\"{function}\", n, i, k, out[k * n + i], expected[k]);\n    }}\n    \
             untouched(\"{function}\", out, {width}u * n);\n{frees}    release(out);\n}}\n",
            many.join(", "),
            one.join(", ")
        );
        let _ = writeln!(calls, "        check_{function}(sizes[s]);");
    }
    let bits = match scalar {
        Scalar::F64 => "uint64_t",
        _ => "uint32_t",
    };
    DRIVER
        .replace("@checks", &checks)
        .replace("@calls", &calls)
        .replace("@bits", bits)
        .replace("@", name)
}

const DRIVER: &str = r#"#include "@.h"
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef @_real real;

/* Under a sanitizer arrays end where their memory ends; else guards stand on both sides. */
#ifdef EXACT
enum { GUARD = 0 };
#else
enum { GUARD = 40 };
#endif
static const unsigned char PATTERN = 0xA5;

static uint64_t state = UINT64_C(88172645463325252);
static uint64_t sum = UINT64_C(14695981039346656037);

/* In [0, 1). */
static double drawn(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (double)(state >> 11) / 9007199254740992.0;
}

/* One number off every alignment. */
static real *fresh(size_t count)
{
    real *base = malloc((count + 2 * GUARD + 1) * sizeof(real));
    if (base == NULL) exit(3);
    memset(base, PATTERN, (count + 2 * GUARD + 1) * sizeof(real));
    return base + 1 + GUARD;
}

static void release(real *array)
{
    free(array - 1 - GUARD);
}

static void untouched(const char *function, const real *array, size_t count)
{
    const unsigned char *before = (const unsigned char *)(array - GUARD);
    const unsigned char *behind = (const unsigned char *)(array + count);
    for (size_t k = 0; k < GUARD * sizeof(real); k++) {
        if (before[k] != PATTERN || behind[k] != PATTERN) {
            fprintf(stderr, "%s writes beyond its result\n", function);
            exit(1);
        }
    }
}

static void same(const char *function, size_t n, size_t i, size_t k, real found, real expected)
{
    @bits a, b;
    memcpy(&a, &found, sizeof a);
    memcpy(&b, &expected, sizeof b);
    if (found != found && expected != expected) {
        a = 1;
    } else if (a != b) {
        fprintf(stderr, "%s of %zu: entry %zu of posture %zu is %.17g, alone %.17g\n", function, n, k, i,
            (double)found, (double)expected);
        exit(1);
    }
    sum = (sum ^ a) * UINT64_C(1099511628211);
}

/* Ends of the limits and what lies between; some postures out of every domain. */
static void fill_q(real *q, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < @_DOF; j++) {
            const double lower = isinf(@_joint_lower[j]) ? -3.2 : (double)@_joint_lower[j];
            const double upper = isinf(@_joint_upper[j]) ? 3.2 : (double)@_joint_upper[j];
            const double share = (i % 4 == 0) ? (double)(drawn() < 0.5) : drawn();
            q[j * n + i] = (real)(lower + share * (upper - lower));
        }
        if (i % 11 == 3) q[(i % @_DOF) * n + i] = (real)NAN;
        if (i % 11 == 5) q[(i % @_DOF) * n + i] = (real)-INFINITY;
        if (i % 11 == 6) q[(i % @_DOF) * n + i] = (real)3e7;
        if (i % 11 == 8) q[(i % @_DOF) * n + i] = (real)-0.0;
        if (i % 11 == 9) q[(i % @_DOF) * n + i] = (real)1e-41;
        if (i % 11 == 10) q[(i % @_DOF) * n + i] = (real)(1000.0 * (drawn() - 0.5));
    }
}

static void fill_qd(real *qd, size_t n)
{
    for (size_t k = 0; k < @_DOF * n; k++) qd[k] = (real)(drawn() - 0.5);
}

static void fill_qdd(real *qdd, size_t n)
{
    fill_qd(qdd, n);
}

static void fill_reading(real *reading, size_t n)
{
    for (size_t k = 0; k < 2 * n; k++) reading[k] = (real)(0.1 * (drawn() - 0.5));
}

@checks
int main(void)
{
    static const size_t sizes[] = {0, 1, 2, 3, 7, 8, 9, 15, 16, 17, 1000};
    if (@_selftest() != 0) return 2;
    /* They are for those robots that take them. */
    (void)fill_q, (void)fill_qd, (void)fill_qdd, (void)fill_reading;
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; s++) {
@calls    }
    printf("%016llx\n", (unsigned long long)sum);
    return 0;
}
"#;

/// Compiles and runs the comparison; the sum over all results.
pub(crate) fn sum(
    folder: &Path,
    case: &Case,
    scalar: Scalar,
    command: &[&str],
    run: &[&str],
) -> String {
    let label: String = command.concat().replace(['/', '='], "_");
    let folder = folder.join(format!("{}_{scalar:?}_{label}", case.name));
    fs::create_dir_all(&folder).unwrap();
    let package = case.package(scalar);
    let source = write(&folder, &case.name, &package);
    let driver = driver(case, scalar);
    let [program, object, main] = ["program", "batch.o", "main.c"].map(|name| folder.join(name));
    fs::write(&main, &driver).unwrap();
    let build = |arguments: &[&str]| {
        let mut build = Command::new(command[0]);
        printed(build.args(&command[1..]).arg(SEPARATE).args(arguments));
    };
    let [source, object, main] = [&source, &object, &main].map(|path| path.to_str().unwrap());
    build(&[&WARNINGS[..], &["-c", source, "-o", object]].concat());
    let program = program.to_str().unwrap();
    build(&["-std=c99", main, object, "-lm", "-o", program]);
    let words = [run, &[program]].concat();
    let output = tool(Command::new(words[0]).args(&words[1..]));
    let output = output.unwrap_or_else(|message| panic!("{} {scalar:?}: {message}", case.name));
    String::from_utf8(output).unwrap()
}

#[test]
fn every_lane_has_the_bits_of_one_posture_and_nothing_else_is_touched() {
    let folder = folder("lanes");
    let mut cases = cases();
    // One compiler has the robot with joints of every type, and effects.
    let alike = ["arm6", "quadruped"];
    let is_alike = |case: &Case| alike.iter().any(|name| case.name.starts_with(name));
    cases.retain(|case| COMPILERS.len() > 1 || !is_alike(case));
    let mut jobs = Vec::new();
    for case in &cases {
        for scalar in [Scalar::F64, Scalar::F32] {
            jobs.push((case, scalar));
        }
    }
    let others = COMPILERS[1..].iter().map(|other| vec![*other, "-O2"]);
    let mut others: Vec<Vec<&str>> = others.collect();
    #[cfg(target_arch = "x86_64")]
    {
        if std::is_x86_feature_detected!("avx2") {
            // gcc 12 makes pairs of products and sums in the function of one posture, and fuses
            // them whatever is said of contraction.
            let apart = "-fno-tree-slp-vectorize";
            others.push(vec![COMPILERS[0], "-O3", "-mavx2", "-mfma", apart]);
        }
        if COMPILERS.len() > 1 && std::is_x86_feature_detected!("avx512f") {
            others.extend(COMPILERS.map(|c| vec![c, "-O1", "-mavx512f", "-mavx512dq"]));
        }
    }
    parallel(jobs, |(case, scalar)| {
        let plain = sum(&folder, case, scalar, &[COMPILERS[0], "-O2"], &[]);
        // Other registers: two links have every kind of statement.
        let all = COMPILERS.len() > 1 || case.model.dof() == 2;
        for command in others.iter().filter(|_| all) {
            let other = sum(&folder, case, scalar, command, &[]);
            assert_eq!(plain, other, "{} {scalar:?} {command:?}", case.name);
        }
    });
}

/// With the C library's sines, lane by lane.
#[test]
fn the_sines_of_the_library_serve_as_well() {
    let folder = folder("lanes_libm");
    let case = Case::robot("two_link", "foot").of_many(8);
    let libm = format!("-D{}_USE_LIBM", case.name);
    for scalar in [Scalar::F64, Scalar::F32] {
        sum(&folder, &case, scalar, &[COMPILERS[0], "-O1", &libm], &[]);
    }
}
