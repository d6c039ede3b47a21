//! Other rounding modes are noticed by the self-test; denormals that are flushed to zero change
//! nothing that a robot could measure.

use std::fs;
use std::process::Command;

use sesc_codegen::emit::c::Scalar;

use super::case::Case;
use super::compiled::{SEPARATE, WARNINGS, folder, printed, write};
use crate::COMPILERS;

/// What the self-test says in each mode, and in `com` the largest change by flushing.
const DRIVER: &str = r#"#include "@.h"
#include <fenv.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>

#if defined(__SSE2__)
#include <xmmintrin.h>
/* Denormal results and arguments are zero. */
static void flush(void) { _mm_setcsr(_mm_getcsr() | 0x8040u); }
static void keep(void) { _mm_setcsr(_mm_getcsr() & ~0x8040u); }
#endif

int main(void)
{
    const int modes[4] = {FE_TONEAREST, FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO};
    for (int k = 0; k < 4; k += 1) {
        (void)fesetround(modes[k]);
        const int failed = @_selftest();
        (void)fesetround(FE_TONEAREST);
        printf("%d\n", failed);
    }
#if defined(__SSE2__)
    double largest = 0.0;
    uint32_t draw = 1u;
    for (int posture = 0; posture < 2000; posture += 1) {
        @_real q[@_DOF];
        for (int k = 0; k < @_DOF; k += 1) {
            draw = draw * 1664525u + 1013904223u;
            /* From angles of the day to such whose squares, and which themselves, are denormal. */
            q[k] = (@_real)ldexp((double)(draw >> 8) * 1.0e-7, -(int)((draw >> 5) % 1080u));
        }
        @_real kept[3], flushed[3];
        @_com(q, @_cad_params, kept);
        flush();
        @_com(q, @_cad_params, flushed);
        const int failed = @_selftest();
        keep();
        if (failed != 0) {
            return 1;
        }
        for (int k = 0; k < 3; k += 1) {
            largest = fmax(largest, fabs((double)kept[k] - (double)flushed[k]));
        }
    }
    printf("%.3g\n", largest);
#endif
    return 0;
}
"#;

#[test]
fn the_self_test_notices_other_rounding_modes() {
    let folder = folder("rounding");
    let case = Case::robot("op2", "r_sole");
    for scalar in [Scalar::F64, Scalar::F32] {
        let package = case.package(scalar);
        let folder = folder.join(format!("{scalar:?}"));
        fs::create_dir_all(&folder).unwrap();
        let source = write(&folder, &case.name, &package);
        let main = folder.join("main.c");
        fs::write(&main, DRIVER.replace('@', &case.name)).unwrap();
        // What the header says that the mode adds.
        let words: Vec<&str> = package.header.split_whitespace().collect();
        let at = words.iter().position(|word| *word == "(sums").unwrap();
        // A line of the comment may begin between the two.
        let weight = words[..at].iter().rfind(|word| **word != "*").unwrap();
        let weight: i32 = weight.parse().unwrap();
        for options in [["-O0", "-g0"], ["-O3", "-march=native"]] {
            let program = folder.join("program");
            let mut build = Command::new(COMPILERS[0]);
            build.args(WARNINGS).args(options).arg(SEPARATE);
            build.args([&source, &main]).args(["-lm", "-o"]);
            printed(build.arg(&program));
            let said = printed(&mut Command::new(&program));
            let numbers: Vec<f64> = said.lines().map(|line| line.parse().unwrap()).collect();
            assert_eq!(numbers[0], 0.0, "{scalar:?} {options:?}: {said}");
            for number in &numbers[1..4] {
                let noticed = *number as i32 & weight != 0;
                assert!(noticed, "{scalar:?} {options:?}: {said}");
            }
            if cfg!(target_arch = "x86_64") {
                // Sums of a hundred products, of which each loses less than the smallest normal
                // number, 1.2e-38 in f32.
                assert!(numbers[4] < 1e-35, "{scalar:?} {options:?}: {said}");
            }
        }
    }
}
