//! C of small robots, compiled and compared with the tape, bit by bit.

use std::fmt::Write as _;
use std::fs;
use std::process::Command;

use arbitrary::Unstructured;
use sesc_codegen::emit::c::{self, Options, Scalar};
use sesc_codegen::facts::Facts;
use sesc_identify::evaluate::PORTABLE;
use sesc_model::tape::{Tape, Values};
use sesc_model::{Function, Given};

use crate::robots::Drawn;

/// Functions compared for one posture and for three, which the blocks' tail is made of.
const FUNCTIONS: [Function; 4] = [
    Function::Com,
    Function::ComJacobian,
    Function::GravityMoments,
    Function::Cop,
];

/// Compiles with warnings as errors, runs the self-test, compares every number.
pub fn compared(data: &[u8]) {
    let Ok(drawn) = Drawn::of(&mut Unstructured::new(data)) else {
        return;
    };
    let Some(model) = drawn.model().filter(|model| model.dof() > 0) else {
        return;
    };
    let (q, r) = (drawn.posture(&model), model.cad_params());
    let mut options = Options::of(Scalar::F64);
    options.lanes = Some(8);
    let package = c::package(&Facts::of(&model), "drawn", &options).expect("a package");
    let folder = std::env::temp_dir().join(format!("sesc_fuzz_c_{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder");
    let numbers: Vec<String> = q.iter().map(|x| format!("{x:?}")).collect();
    let many: Vec<String> = numbers.iter().flat_map(|x| vec![x.clone(); 9]).collect();
    let mut main = format!(
        "#include \"drawn.h\"\n#include <stdio.h>\nint main(void)\n{{\n    \
         static const double q[] = {{{}}}, many[] = {{{}}};\n    static double out[999], all[9999];\n",
        numbers.join(", "),
        many.join(", ")
    );
    let mut expected = Vec::new();
    for function in FUNCTIONS {
        let program = model
            .program(function, Given::Positions)
            .expect("a function of all robots");
        let tape = Tape::new(&program);
        let mut values = vec![0.0; tape.outputs()];
        let arguments = [Values::PerPosture(&q), Values::Shared(&r)];
        tape.run(&arguments, 1, &mut values, PORTABLE);
        let (name, width) = (function.name(), values.len());
        let _ = write!(
            main,
            "    drawn_{name}(q, drawn_cad_params, out);\n    \
             drawn_{name}_batch(9, many, drawn_cad_params, all);\n    \
             for (int k = 0; k < {width}; k++) {{\n        printf(\"%.17g\\n\", out[k]);\n        \
             for (int i = 0; i < 9; i++) if (all[9 * k + i] != out[k]) return 3;\n    }}\n"
        );
        expected.extend(values);
    }
    main += "    return drawn_selftest();\n}\n";
    for (name, text) in [
        ("drawn.h", &package.header),
        ("drawn.c", &package.source),
        ("main.c", &main),
    ] {
        fs::write(folder.join(name), text).expect("a file");
    }
    let said = Command::new("gcc")
        .args([
            "-std=c99",
            "-O1",
            "-ffp-contract=off",
            "-Wall",
            "-Wextra",
            "-Wpedantic",
            "-Werror",
        ])
        .args(["-fsanitize=undefined", "-fno-sanitize-recover=all"])
        .args(["drawn.c", "main.c", "-o", "program"])
        .current_dir(&folder)
        .output()
        .expect("gcc");
    let about = || format!("on {}\n{}", drawn.support, drawn.text);
    assert!(
        said.status.success(),
        "{}{}",
        String::from_utf8_lossy(&said.stderr),
        about()
    );
    let ran = Command::new(folder.join("program"))
        .output()
        .expect("a program");
    assert!(ran.status.success(), "{:?} {}", ran, about());
    let printed = String::from_utf8_lossy(&ran.stdout);
    let found: Vec<f64> = printed
        .lines()
        .map(|line| line.parse().expect("a number"))
        .collect();
    assert_eq!(found, expected, "{}", about());
}
