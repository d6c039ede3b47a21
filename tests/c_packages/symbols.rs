//! Symbols of the C packages: exactly the documented names, and no two alike.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use sesc_identify::robot::Robot;
use sesc_model::{ModelFile, Snapping};

use crate::user::*;
use sesc_test_support::command::{ROOT, op2, write};

/// Every name of DESIGN.md, section 4, behind the prefix; with `--model` and ticks.
const DATA: [&str; 7] = [
    "joint_names",
    "joint_lower",
    "joint_upper",
    "total_mass_kg",
    "param_names",
    "cad_params",
    "model_params",
];
const FUNCTIONS: [&str; 9] = [
    "com",
    "com_jacobian",
    "com_velocity",
    "gravity_moments",
    "regressor",
    "regressor_cop",
    "regressor_full",
    "cop",
    "zmp",
];
const BAKED: [&str; 2] = ["model_com", "model_cop"];

/// Headers of `generated/c`, by name.
fn shipped() -> Vec<String> {
    let stem = |path: PathBuf| path.file_stem().unwrap().to_str().unwrap().to_string();
    let entries = fs::read_dir(format!("{ROOT}/generated/c")).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let mut names: Vec<String> = paths
        .filter(|path| path.extension().is_some_and(|extension| extension == "h"))
        .map(stem)
        .collect();
    names.sort();
    names
}

/// A controller with the robot in f32 and in fixed32 links both and calls both.
#[test]
fn shipped_c_packages_link_together() {
    let names = shipped();
    assert!(names.len() >= 2, "{names:?}");
    let folder = fresh("together");
    let mut main = String::new();
    for name in &names {
        main += &format!("#include \"{name}.h\"\n");
    }
    // Fixed point beside float, in the same posture of ticks.
    main += "#include <math.h>\n#include <stdio.h>\n\nint main(void)\n{\n    int failed = 0;\n";
    for name in &names {
        main += &format!("    failed |= {name}_selftest();\n");
    }
    main += "\
    int32_t ticks[op2_r_sole_DOF];
    static float rows[3 * op2_r_sole_FULL_PARAMS];
    static int32_t fixed_rows[3 * op2_r_sole_fixed_FULL_PARAMS];
    const double unit = 1.0 / (double)(1 << op2_r_sole_fixed_REGRESSOR_COP_FRACTION_BITS);
    for (int k = 0; k < op2_r_sole_DOF; k += 1) {
        ticks[k] = 2048 + 37 * k;
    }
    op2_r_sole_regressor_cop_ticks(ticks, rows);
    op2_r_sole_fixed_regressor_cop_ticks(ticks, fixed_rows);
    for (int k = 0; k < 2 * op2_r_sole_BASE_PARAMS; k += 1) {
        if (fabs((double)rows[k] - fixed_rows[k] * unit) > 1e-6) {
            printf(\"entry %d: %g %g\\n\", k, (double)rows[k], fixed_rows[k] * unit);
            failed = 1;
        }
    }
    return failed;
}
";
    let include = PathBuf::from(format!("{ROOT}/generated/c"));
    let main = write(&folder, "main.c", main);
    let object = folder.join("main.o");
    compile_c(Path::new(&main), &include, &object);
    let binary = folder.join("together");
    let sources = names.iter().map(|name| include.join(format!("{name}.c")));
    run(Command::new("cc")
        .args(["-std=c99", "-O1"])
        .arg(&object)
        .args(sources)
        .args(["-lm", "-o"])
        .arg(&binary));
    run(&mut Command::new(binary));
}

/// What Python's ctypes and every other FFI do: look up a name, call what is there.
#[test]
fn every_documented_name_is_found_in_a_shared_library() {
    let folder = fresh("shared");
    // No prefix is longer.
    let name = "op2_on_its_right_sole_r_sole_f64";
    let model = Robot::read(Path::new(&op2())).unwrap();
    let model = model.model("r_sole", Snapping::default(), None).unwrap();
    let file = ModelFile::from_values(&model, &model.cad_params(), None, "prior");
    let file = write(&folder, "model.toml", toml::to_string(&file).unwrap());
    for (scalar, real) in [("f64", "double"), ("f32", "float"), ("fixed32", "int32_t")] {
        let out = folder.join(scalar);
        let options = [
            "--scalar", scalar, "--name", name, "--ticks", "true", "--model", &file,
        ];
        generate(&out, &op2(), "r_sole", &options);
        let library = out.join("library.so");
        run(Command::new("cc")
            .args(["-std=c99", "-O1", "-shared", "-fPIC"])
            .arg(out.join(format!("{name}.c")))
            .arg("-o")
            .arg(&library));
        let main = write(&out, "main.c", caller(name, real));
        let binary = out.join("caller");
        // Where the library of C holds dlopen, there is still a libdl to ask for.
        run(Command::new("cc")
            .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-I"])
            .arg(&out)
            .arg(main)
            .args(["-ldl", "-lm", "-o"])
            .arg(&binary));
        let printed = run(Command::new(&binary).arg(&library));
        let turned = |k: i32| f64::from(37 * k) * std::f64::consts::TAU / 4096.0;
        let q: Vec<f64> = (0..20).map(turned).collect();
        near(&printed, reference(&q), F32_M);
    }
}

/// Opens the library, finds every name, compares q, sines and ticks; prints the CoM in m.
fn caller(name: &str, real: &str) -> String {
    let mut calls = String::new();
    for data in DATA {
        calls += &format!("    (void)find(\"{name}_{data}\");\n");
    }
    let fixed = real == "int32_t";
    for function in FUNCTIONS.into_iter().chain(BAKED) {
        // It divides, which fixed point does not.
        let is_zmp = function == "zmp";
        if is_zmp && fixed {
            continue;
        }
        let r = !(function.starts_with("regressor") || function.starts_with("model"));
        let rates = i32::from(function == "com_velocity") + 2 * i32::from(is_zmp);
        let r = i32::from(r);
        calls += &format!("    compare(\"{function}\", {rates}, {r});\n");
    }
    let bits = |quantity: &str| match fixed {
        true => format!("ldexp(1.0, {name}_{quantity}_FRACTION_BITS)"),
        false => "1.0".to_string(),
    };
    let tolerance = if fixed { "64.0" } else { "1e-5" };
    format!(
        r#"#include "{name}.h"
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {{ DOF = {name}_DOF, LARGEST = 3 * {name}_FULL_PARAMS }};
typedef {real} real;

static void *library;
static real q[DOF], sines[DOF], cosines[DOF], qd[DOF], r[{name}_BASE_PARAMS];
static int32_t ticks[DOF];

static void *find(const char *symbol)
{{
    void *found = dlsym(library, symbol);
    if (found == NULL) {{
        fprintf(stderr, "%s is not there\n", symbol);
        exit(1);
    }}
    return found;
}}

/* A function, by its name; as POSIX asks, its address is copied. */
static void call(const char *function, const char *suffix, int inputs, const void *const *in,
    real *out)
{{
    char symbol[128];
    void *found;
    void (*of_1)(const void *, real *);
    void (*of_2)(const void *, const void *, real *);
    void (*of_3)(const void *, const void *, const void *, real *);
    void (*of_4)(const void *, const void *, const void *, const void *, real *);
    void (*of_5)(const void *, const void *, const void *, const void *, const void *, real *);
    snprintf(symbol, sizeof symbol, "{name}_%s%s", function, suffix);
    found = find(symbol);
    memcpy(&of_1, &found, sizeof found);
    memcpy(&of_2, &found, sizeof found);
    memcpy(&of_3, &found, sizeof found);
    memcpy(&of_4, &found, sizeof found);
    memcpy(&of_5, &found, sizeof found);
    if (inputs == 1) {{
        of_1(in[0], out);
    }} else if (inputs == 2) {{
        of_2(in[0], in[1], out);
    }} else if (inputs == 3) {{
        of_3(in[0], in[1], in[2], out);
    }} else if (inputs == 4) {{
        of_4(in[0], in[1], in[2], in[3], out);
    }} else {{
        of_5(in[0], in[1], in[2], in[3], in[4], out);
    }}
}}

/* Of a function that takes so many arrays of how joints move. */
static void compare(const char *function, int rates, int takes_r)
{{
    static real of_q[LARGEST], of_sc[LARGEST], of_ticks[LARGEST];
    const void *in[5] = {{sines, NULL, NULL, NULL, NULL}};
    int k;
    int more = 1;
    for (k = 0; k < rates; k += 1) {{
        in[++more] = qd;
    }}
    if (takes_r) {{
        in[++more] = r;
    }}
    in[1] = cosines;
    call(function, "_sc", more + 1, in, of_sc);
    in[1] = q;
    call(function, "", more, in + 1, of_q);
    in[1] = ticks;
    call(function, "_ticks", more, in + 1, of_ticks);
    for (k = 0; k < LARGEST; k += 1) {{
        if (fabs((double)of_q[k] - (double)of_sc[k]) > {tolerance}
            || fabs((double)of_q[k] - (double)of_ticks[k]) > {tolerance}) {{
            fprintf(stderr, "%s[%d]: %g %g %g\n", function, k, (double)of_q[k],
                (double)of_sc[k], (double)of_ticks[k]);
            exit(1);
        }}
    }}
}}

int main(int count, char **arguments)
{{
    int (*selftest)(void);
    void *found;
    real com[3], model_com[3];
    const void *in[2] = {{q, r}};
    int k;
    library = dlopen(arguments[count - 1], RTLD_NOW);
    if (library == NULL) {{
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }}
    for (k = 0; k < DOF; k += 1) {{
        const double angle = 37.0 * k * 6.283185307179586 / 4096.0;
        ticks[k] = 2048 + 37 * k;
        q[k] = (real)(angle * {q_unit});
        sines[k] = (real)(sin(angle) * {sc_unit});
        cosines[k] = (real)(cos(angle) * {sc_unit});
        qd[k] = (real)(((k % 3) - 1) * 0.5 * {qd_unit});
    }}
    memcpy(r, find("{name}_cad_params"), sizeof r);
{calls}    call("com", "", 2, in, com);
    call("model_com", "", 1, in, model_com);
    found = find("{name}_selftest");
    memcpy(&selftest, &found, sizeof found);
    for (k = 0; k < 3; k += 1) {{
        if (fabs((double)com[k] - (double)model_com[k]) > {tolerance}) {{
            return 1;
        }}
        printf("%.9g ", com[k] / {com_unit});
    }}
    return selftest();
}}
"#,
        q_unit = bits("Q"),
        qd_unit = bits("QD"),
        sc_unit = bits("SC"),
        com_unit = bits("COM"),
    )
}
