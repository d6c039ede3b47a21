//! Every name of a header is in a shared library, and what is called by it agrees.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use nalgebra::DMatrix;
use sesc_identify::robot::Robot;
use sesc_model::{EffectRecord, Function, Information, ModelFile, Quantity, Snapping};

use super::user::*;
use crate::c99::fixed::without_comments;
use sesc_test_support::command::{in_words, op2, write};

/// What the sensor adds to the CoP, x and y, m.
const OFFSET_M: [f64; 2] = [0.004, -0.002];

/// Ends of the names of a function that computes one quantity from several inputs.
const VARIANTS: [&str; 3] = ["_sc", "_ticks", "_batch"];

/// A declaration of a header, its name without the prefix.
#[derive(Debug)]
enum Declared {
    Data(String),
    /// What it returns, and its parameters: whether each is `const`, and its name.
    Function(String, String, Vec<(bool, String)>),
}

/// Everything that a header declares, in its order.
fn declared(header: &str, name: &str) -> Vec<Declared> {
    let code = without_comments(header);
    let lines: Vec<&str> = code.lines().filter(|line| !line.starts_with('#')).collect();
    let behind = |word: &str| {
        let bare = word.trim_start_matches('*').split('[').next()?;
        Some(bare.strip_prefix(name)?.strip_prefix('_')?.to_string())
    };
    let declaration = |text: &str| {
        if let Some(data) = text.trim().strip_prefix("extern const ") {
            return Some(Declared::Data(behind(data.split_whitespace().last()?)?));
        }
        let (head, parameters) = text.split_once('(')?;
        // Long names are on a line of their own.
        let (result, function) = head.trim().rsplit_once(' ')?;
        let result = result.trim_end();
        let parameter = |text: &str| {
            let word = text.split_whitespace().last().unwrap();
            let word = word.trim_start_matches('*').split('[').next().unwrap();
            (text.trim().starts_with("const"), word.to_string())
        };
        let parameters = parameters.trim_end_matches(')').split(',');
        let parameters = parameters.map(parameter).collect();
        let result = result.to_string();
        Some(Declared::Function(result, behind(function)?, parameters))
    };
    lines.join(" ").split(';').filter_map(declaration).collect()
}

/// The functions that the table of functions gives a robot whose sensor has an offset and whose
/// parameters are known.
fn of_the_table(floats: bool) -> BTreeSet<String> {
    let mut names = BTreeSet::from(["selftest".to_string(), "correct_cop".to_string()]);
    // It divides, which fixed point does not.
    let functions = Function::ALL
        .iter()
        .filter(|f| floats || **f != Function::Zmp);
    let baked = ["com", "com_jacobian", "cop", "cop_jacobian"].map(|f| format!("model_{f}"));
    for function in functions.map(|f| f.name().to_string()).chain(baked) {
        names.extend(VARIANTS.map(|end| format!("{function}{end}")));
        names.insert(function);
    }
    match floats {
        true => names.extend(["correct_cop_batch".to_string()]),
        false => names.retain(|name| !name.ends_with("_batch")),
    }
    names
}

/// A model file with parameters of CAD, how well they are known, and the offset.
fn model_file() -> String {
    let model = Robot::read(Path::new(&op2())).unwrap();
    let model = model.model("r_sole", Snapping::default(), None).unwrap();
    let mut file = ModelFile::from_values(&model, &model.cad_params(), None, "data");
    let known = |value: f64| Quantity { value, std: None };
    let [x, y] = OFFSET_M.map(known);
    file.effects = vec![EffectRecord {
        effect: "sensor_offset".to_string(),
        target: "-".to_string(),
        parameters: [("offset_x_m".to_string(), x), ("offset_y_m".to_string(), y)].into(),
        ..EffectRecord::default()
    }];
    let n = model.base.params.len();
    file.inform(Information::of(&(DMatrix::identity(n, n) * 50.0)));
    toml::to_string(&file).unwrap()
}

/// What Python's ctypes and every other FFI do: look up a name, call what is there.
#[test]
fn every_name_of_a_header_is_found_in_a_shared_library_and_called() {
    let folder = fresh("shared");
    // No prefix is longer.
    let name = format!("op2_on_its_right_sole_{}", "n".repeat(78));
    assert_eq!(name.len(), 100);
    let file = write(&folder, "model.toml", model_file());
    for scalar in ["f64", "f32", "fixed32"] {
        let (floats, out) = (scalar != "fixed32", folder.join(scalar));
        let options = "--scalar @ --name @ --ticks true --model @";
        let more = if floats { " --estimator --lanes 8" } else { "" };
        let options = format!("{options}{more}");
        let options = in_words(&options, &[scalar, &name, &file]);
        generate(&out, &op2(), "r_sole", &options);
        let header = fs::read_to_string(out.join(format!("{name}.h"))).unwrap();
        let declared = declared(&header, &name);
        let functions = declared.iter().filter_map(|declared| match declared {
            // The self-test has a symbol of this one header, too, which a macro calls.
            Declared::Function(_, function, _) if function.starts_with("selftest_") => None,
            Declared::Function(_, function, _) => Some(function.clone()),
            Declared::Data(_) => None,
        });
        let (estimator, of_table): (BTreeSet<String>, BTreeSet<String>) =
            functions.partition(|function| function.starts_with("estimator_"));
        assert_eq!(of_table, of_the_table(floats), "{scalar}");
        assert_eq!(estimator.len(), if floats { 6 } else { 0 }, "{estimator:?}");
        let library = out.join("library.so");
        let mut cc = Command::new("cc");
        cc.args(["-std=c99", "-O1", "-shared", "-fPIC", "-o"]);
        run(cc.arg(&library).arg(out.join(format!("{name}.c"))));
        let printed = call_all(&out, &library, &caller(&name, &declared, &header));
        let turned = |k: i32| f64::from(37 * k) * std::f64::consts::TAU / 4096.0;
        let q: Vec<f64> = (0..20).map(turned).collect();
        let com = reference(&q);
        let lines: Vec<&str> = printed.lines().collect();
        near(lines[0], com, F32_M);
        // The reading is the CoM's x and y and the offset, which the correction takes off.
        let [x, y] = [0, 1].map(|axis| com[axis] + OFFSET_M[axis]);
        near(lines[1], [x, y, 0.0], F32_M);
        near(lines[2], [com[0], com[1], 0.0], F32_M);
    }
}

/// What the caller prints that is compiled and run with the library's path.
fn call_all(out: &Path, library: &Path, text: &str) -> String {
    let main = write(out, "main.c", text);
    let mut cc = Command::new("cc");
    cc.args(["-std=c99", "-Wall", "-Wextra", "-Werror"]);
    // Where the library of C holds dlopen, there is still a libdl to ask for.
    cc.args([&main, "-ldl", "-lm", "-o", "caller"]);
    run(cc.current_dir(out));
    run(Command::new(out.join("caller")).arg(library))
}

/// Opens the library, finds and calls every name, and compares what computes one quantity;
/// prints the CoM, the reading and the reading corrected, m.
fn caller(name: &str, declared: &[Declared], header: &str) -> String {
    let fixed = header.contains("_FRACTION_BITS");
    let mut calls = String::new();
    let mut results = String::new();
    for declared in declared {
        match declared {
            Declared::Data(data) => {
                let _ = writeln!(calls, "    read_all(\"{data}\", sizeof {name}_{data});");
            }
            Declared::Function(result, function, parameters) => {
                let is_static = result == "void" && !function.starts_with("estimator_");
                if is_static && quantity(function) == function {
                    let _ = writeln!(results, "static real of_{function}[LARGEST];");
                }
                calls += &call(name, result, function, parameters);
            }
        }
    }
    let bits = |quantity: &str| match fixed {
        true => format!("ldexp(1.0, {name}_{quantity}_FRACTION_BITS)"),
        false => "1.0".to_string(),
    };
    let estimator = match fixed {
        true => String::new(),
        false => format!("static {name}_estimator estimator;\n"),
    };
    let units = ["Q", "QD", "SC", "READING", "COM", "COP", "CORRECT_COP"];
    let units = units.map(|quantity| format!("#define {quantity}_UNIT {}\n", bits(quantity)));
    let texts = [
        ("@RESULTS@", results + &estimator),
        ("@UNITS@", units.concat()),
        ("@CALLS@", calls),
        (
            "@TOLERANCE@",
            if fixed { "64.0" } else { "1e-5" }.to_string(),
        ),
        ("@NAME@", name.to_string()),
    ];
    texts.iter().fold(CALLER.to_string(), |text, (word, by)| {
        text.replace(word, by)
    })
}

/// The function without variants that computes what `function` does.
fn quantity(function: &str) -> &str {
    let end = VARIANTS.iter().find_map(|end| function.strip_suffix(end));
    let bare = end.unwrap_or(function);
    bare.strip_prefix("model_").unwrap_or(bare)
}

/// The call of a function by its name, with the arrays that its parameters are called after.
fn call(name: &str, result: &str, function: &str, parameters: &[(bool, String)]) -> String {
    let many = function.ends_with("_batch");
    let argument = |(constant, word): &(bool, String)| match (word.as_str(), constant) {
        ("void", _) => String::new(),
        ("e", _) => "&estimator".to_string(),
        ("n", _) => "POSTURES".to_string(),
        ("r", true) => "r".to_string(),
        (word, true) if many => format!("many_{word}"),
        (word, true) => word.to_string(),
        ("r_std", false) => "found_std".to_string(),
        (_, false) => "out".to_string(),
    };
    let arguments: Vec<String> = parameters.iter().map(argument).collect();
    let call = format!("f({})", arguments.join(", "));
    let of_estimator = function.starts_with("estimator_");
    let checked = match result {
        "void" if of_estimator => {
            format!("{call};\n        like(\"{function}\", r, @NAME@_BASE_PARAMS, 1);")
        }
        "void" if quantity(function) == function => {
            format!("{call};\n        memcpy(of_{function}, out, sizeof of_{function});")
        }
        "void" => format!(
            "{call};\n        like(\"{function}\", of_{}, LARGEST, {});",
            quantity(function),
            if many { "POSTURES" } else { "1" }
        ),
        "int" => format!("zero(\"{function}\", {call});"),
        // One posture is worth one.
        _ => format!("zero(\"{function}\", {call} != 1);"),
    };
    let then = match function {
        "cop" => "        read_cop();\n",
        _ => "",
    };
    format!(
        "    {{\n        __typeof__(&{name}_{function}) f;\n        \
         void *found = find(\"{name}_{function}\");\n        \
         memcpy(&f, &found, sizeof f);\n        \
         memset(out, 0, sizeof out);\n        {checked}\n{then}    }}\n"
    )
}

/// The C program that calls the functions; it copies their addresses, as POSIX asks.
const CALLER: &str = r#"#include "@NAME@.h"
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DOF = @NAME@_DOF, LARGEST = 3 * @NAME@_FULL_PARAMS, POSTURES = 11 };
typedef @NAME@_real real;
@UNITS@
static void *library;
static real q[DOF], sin_q[DOF], cos_q[DOF], qd[DOF], qdd[DOF], reading[2];
static real many_q[DOF * POSTURES], many_qd[DOF * POSTURES], many_qdd[DOF * POSTURES];
static real many_reading[2 * POSTURES], out[LARGEST * POSTURES];
static real r[@NAME@_BASE_PARAMS], r_std[@NAME@_BASE_PARAMS], found_std[@NAME@_BASE_PARAMS];
static real cop_std[2];
static int32_t ticks[DOF];
static unsigned sum;
@RESULTS@
static void *find(const char *symbol)
{
    void *found = dlsym(library, symbol);
    if (found == NULL) {
        fprintf(stderr, "%s is not there\n", symbol);
        exit(1);
    }
    return found;
}

/* Every byte of a constant. */
static void read_all(const char *data, size_t size)
{
    char symbol[200];
    const unsigned char *bytes;
    size_t k;
    snprintf(symbol, sizeof symbol, "@NAME@_%s", data);
    bytes = find(symbol);
    for (k = 0; k < size; k += 1) {
        sum += bytes[k];
    }
}

static void zero(const char *function, int result)
{
    if (result != 0) {
        fprintf(stderr, "%s: %d\n", function, result);
        exit(1);
    }
}

/* Entry k of posture i of what was computed last, of so many postures. */
static void like(const char *function, const real *expected, int entries, int postures)
{
    int k, i;
    for (k = 0; k < entries; k += 1) {
        for (i = 0; i < postures; i += 1) {
            const double found = (double)out[k * postures + i];
            if (!(fabs(found - (double)expected[k]) <= @TOLERANCE@)) {
                fprintf(stderr, "%s[%d] of %d: %g, not %g\n", function, k, i, found,
                    (double)expected[k]);
                exit(1);
            }
        }
    }
}

/* The same numbers for many postures. */
static void repeat(const real *one, real *many, int entries)
{
    int k, i;
    for (k = 0; k < entries; k += 1) {
        for (i = 0; i < POSTURES; i += 1) {
            many[k * POSTURES + i] = one[k];
        }
    }
}

/* The reading that the robot's own prediction is. */
static void read_cop(void)
{
    int k;
    for (k = 0; k < 2; k += 1) {
        reading[k] = (real)((double)of_cop[k] / COP_UNIT * READING_UNIT);
    }
    repeat(reading, many_reading, 2);
}

int main(int count, char **arguments)
{
    int k;
    library = dlopen(arguments[count - 1], RTLD_NOW);
    if (library == NULL) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    for (k = 0; k < DOF; k += 1) {
        const double angle = 37.0 * k * 6.283185307179586 / 4096.0;
        ticks[k] = 2048 + 37 * k;
        q[k] = (real)(angle * Q_UNIT);
        sin_q[k] = (real)(sin(angle) * SC_UNIT);
        cos_q[k] = (real)(cos(angle) * SC_UNIT);
        qd[k] = (real)(((k % 3) - 1) * 0.5 * QD_UNIT);
        qdd[k] = qd[k];
    }
    repeat(q, many_q, DOF);
    repeat(qd, many_qd, DOF);
    repeat(qdd, many_qdd, DOF);
    memcpy(r, find("@NAME@_cad_params"), sizeof r);
    for (k = 0; k < @NAME@_BASE_PARAMS; k += 1) {
        r_std[k] = (real)0.02;
    }
    cop_std[0] = (real)1e-3;
    cop_std[1] = (real)1e-3;
    (void)found_std; /* Fixed point has no estimator. */
@CALLS@    printf("%.9g %.9g %.9g\n", of_com[0] / COM_UNIT, of_com[1] / COM_UNIT,
        of_com[2] / COM_UNIT);
    printf("%.9g %.9g 0\n", of_cop[0] / COP_UNIT, of_cop[1] / COP_UNIT);
    printf("%.9g %.9g 0\n", of_correct_cop[0] / CORRECT_COP_UNIT,
        of_correct_cop[1] / CORRECT_COP_UNIT);
    return sum == 0;
}
"#;
