//! The same bits on machines of 32 bits and of the other order of bytes; what computes in
//! other digits is refused.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use sesc_codegen::emit::c::Scalar;

use crate::c99::case::{Case, SCALARS};
use crate::c99::compiled::{SEPARATE, WARNINGS, folder, parallel, tool, write};

/// A compiler, and what runs its programs. By the standard, s390x computes float in double.
const MACHINES: [(&[&str], &[&str]); 4] = [
    (
        &["s390x-linux-gnu-gcc", "-fexcess-precision=fast"],
        &["qemu-s390x"],
    ),
    (&["arm-linux-gnueabihf-gcc"], &["qemu-arm"]),
    (
        &["i686-linux-gnu-gcc", "-msse2", "-mfpmath=sse"],
        &["qemu-i386"],
    ),
    (&["aarch64-linux-gnu-gcc"], &["qemu-aarch64"]),
];

/// A hash over the bits of functions in postures that every machine draws alike.
fn driver(name: &str) -> String {
    DRIVER.replace('@', name)
}

const DRIVER: &str = r#"#include "@.h"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

static uint64_t hash = UINT64_C(0xcbf29ce484222325);

/* The most significant byte first, wherever it stands. */
static void add(const @_real all[], int count)
{
    for (int k = 0; k < count; k += 1) {
        uint64_t bits = 0;
        if (sizeof all[k] == 8u) {
            memcpy(&bits, &all[k], sizeof bits);
        } else {
            uint32_t half;
            memcpy(&half, &all[k], sizeof half);
            bits = half;
        }
        for (int shift = 56; shift >= 0; shift -= 8) {
            hash = (hash ^ ((bits >> shift) & 255u)) * UINT64_C(0x100000001b3);
        }
    }
}

int main(void)
{
    static @_real q[@_DOF], com[3], jacobian[3 * @_DOF], rows[2 * @_BASE_PARAMS];
    uint32_t draw = 1u;
    for (int posture = 0; posture < 40; posture += 1) {
        for (int k = 0; k < @_DOF; k += 1) {
            draw = draw * 1664525u + 1013904223u;
#ifdef @_Q_FRACTION_BITS
            q[k] = (int32_t)(draw >> 4) - (INT32_C(1) << 27);
#else
            q[k] = (@_real)((double)((int32_t)(draw >> 8) - (INT32_C(1) << 23)) * 3.5762786865234375e-7);
#endif
        }
        @_com(q, @_cad_params, com);
        @_com_jacobian(q, @_cad_params, jacobian);
        @_regressor_cop(q, rows);
        add(com, 3);
        add(jacobian, 3 * @_DOF);
        add(rows, 2 * @_BASE_PARAMS);
    }
    printf("%016" PRIx64 "\n", hash);
    return @_selftest();
}
"#;

/// Header, source and driver in a folder of their own.
fn written(folder: &Path, case: &Case, scalar: Scalar, label: &str) -> [PathBuf; 2] {
    let folder = folder.join(format!("{}_{scalar:?}_{label}", case.name));
    fs::create_dir_all(&folder).unwrap();
    let source = write(&folder, &case.name, &case.package(scalar));
    let main = folder.join("main.c");
    fs::write(&main, driver(&case.name)).unwrap();
    [source, main]
}

fn build(command: &[&str], files: &[PathBuf; 2], program: &Path) -> Result<Vec<u8>, String> {
    let mut build = Command::new(command[0]);
    build
        .args(&command[1..])
        .args(WARNINGS)
        .args(["-O2", SEPARATE]);
    build.args(files).args(["-lm", "-o"]).arg(program);
    tool(&mut build)
}

/// What a machine prints; its self-test passes.
fn printed(folder: &Path, case: &Case, scalar: Scalar, command: &[&str], run: &[&str]) -> String {
    let files = written(folder, case, scalar, command[0]);
    let program = files[0].with_file_name("program");
    let whole = [command, &["-static"]].concat();
    build(&whole, &files, &program).unwrap_or_else(|message| panic!("{message}"));
    let mut words = run.to_vec();
    words.push(program.to_str().unwrap());
    let output = tool(Command::new(words[0]).args(&words[1..]));
    let output = output.unwrap_or_else(|message| panic!("{command:?} {scalar:?}: {message}"));
    String::from_utf8(output).unwrap()
}

#[test]
fn every_machine_gives_the_same_bits() {
    let folder = folder("machines");
    let cases = [
        Case::robot("op2", "r_sole"),
        Case::robot("lift_base", "hand"),
    ];
    let mut jobs = Vec::new();
    for case in &cases {
        jobs.extend(SCALARS.map(|scalar| (case, scalar)));
    }
    parallel(jobs, |(case, scalar)| {
        let here = printed(&folder, case, scalar, &["gcc"], &[]);
        for (command, run) in MACHINES {
            let there = printed(&folder, case, scalar, command, run);
            assert_eq!(here, there, "{} {scalar:?} {command:?}", case.name);
        }
    });
}

/// In more digits, or with sums in another order, sines are wrong; the library's are not.
#[test]
fn what_computes_in_other_digits_is_refused() {
    let folder = folder("machines_refused");
    let case = Case::robot("two_link", "foot");
    let libm = format!("-D{}_USE_LIBM", case.name);
    let refused: [(&[&str], &str, &[Scalar]); 3] = [
        (
            &["i686-linux-gnu-gcc", "-mfpmath=387"],
            "x87 breaks sines",
            &[Scalar::F64, Scalar::F32],
        ),
        (
            &["gcc", "-ffast-math"],
            "-ffast-math breaks sines",
            &[Scalar::F64, Scalar::F32],
        ),
        (
            &["s390x-linux-gnu-gcc", "-fexcess-precision=standard"],
            "float in double has other bits",
            &[Scalar::F32],
        ),
    ];
    for (command, word, scalars) in refused {
        for &scalar in scalars {
            let files = written(&folder, &case, scalar, command[0]);
            let program = files[0].with_file_name("program");
            let said = build(command, &files, &program).unwrap_err();
            assert!(said.contains(word), "{said}");
            let own = [command, &[&libm]].concat();
            build(&own, &files, &program).unwrap_or_else(|message| panic!("{message}"));
        }
    }
    // Integers have no digits to spare.
    let files = written(&folder, &case, Scalar::Fixed32, "x87");
    let program = files[0].with_file_name("program");
    let command = ["i686-linux-gnu-gcc", "-mfpmath=387"];
    build(&command, &files, &program).unwrap_or_else(|message| panic!("{message}"));
}
