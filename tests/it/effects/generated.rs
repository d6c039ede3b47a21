//! Code of models with effects, compiled and run: Rust by the builder, and C.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use sesc_codegen::Builder;
use sesc_codegen::emit::c::Package;
use sesc_model::{Function, ModelFile, Snapping};

use super::robots::{Stand, urdf};
use sesc_test_support::command::ROOT;

/// What generated code says of one posture.
#[derive(Debug, Clone, PartialEq)]
pub struct Said {
    /// `cop(q, model parameters)`
    pub cop: [f64; 2],
    /// `model_cop(q)`, of C alone.
    pub baked: Option<[f64; 2]>,
    /// `correct_cop(cop)`, where there is one.
    pub corrected: Option<[f64; 2]>,
    /// [`BODY`] one after the other, matrices row-major, joints moving at [`rates`].
    pub body: Vec<f64>,
}

/// Functions of the body that are called beside `cop`.
pub const BODY: [Function; 5] = [
    Function::Com,
    Function::ComJacobian,
    Function::ComVelocity,
    Function::GravityMoments,
    Function::Zmp,
];

/// Joint velocities in both languages, rad/s: an eighth of them beside accelerations, which
/// are minus a half of them.
pub fn rates(dof: usize) -> Vec<f64> {
    (0..dof).map(|j| 1.0 / (1.0 + j as f64)).collect()
}

/// A model to generate code for.
pub struct Case {
    pub module: String,
    pub file: ModelFile,
    pub corrects: bool,
    /// Whether `zmp` is called: compilers make thousands of instructions of it.
    pub moves: bool,
}

impl Case {
    /// The functions of [`BODY`] that are called.
    pub fn body(&self) -> impl Iterator<Item = Function> {
        self.generated(BODY)
    }

    /// Those of `functions` that are generated.
    fn generated(
        &self,
        functions: impl IntoIterator<Item = Function>,
    ) -> impl Iterator<Item = Function> {
        let moves = self.moves;
        let functions = functions.into_iter();
        functions.filter(move |f| moves || *f != Function::Zmp)
    }
}

/// A fresh folder that outlives the test, for whoever wants to look.
pub fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("effects")
        .join(name);
    fs::create_dir_all(folder.join("src")).unwrap();
    folder
}

pub fn tool(command: &mut Command) -> Vec<u8> {
    let output = command
        .output()
        .unwrap_or_else(|error| panic!("{command:?} does not start: {error}"));
    assert!(
        output.status.success(),
        "{command:?}\n{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    output.stdout
}

/// `<module>.rs` in `src` and `<module>.{h,c}` beside it, as a build script writes them.
pub fn write(folder: &Path, stand: &Stand, case: &Case) {
    let model = folder.join(format!("{}.toml", case.module));
    fs::write(&model, toml::to_string(&case.file).unwrap()).unwrap();
    let tree = &stand.model.tree;
    Builder::new(urdf(stand.name))
        .support(&tree.links[tree.support].name)
        .snapping(Snapping::Off)
        .model(&model)
        .name(&case.module)
        .functions(case.generated(Function::ALL).map(Function::name))
        .out_dir(folder.join("src"))
        .c99(folder)
        .emit()
        .unwrap();
}

/// What stands there already keeps its time: cargo compiles what has changed.
fn write_if_changed(path: &Path, text: &str) {
    if fs::read_to_string(path).is_ok_and(|before| before == text) {
        return;
    }
    fs::write(path, text).unwrap();
}

/// Every case in one crate, run on all postures.
pub fn rust(folder: &Path, cases: &[Case], postures: &Path, count: usize) -> Vec<Vec<Said>> {
    let manifest = format!(
        "[workspace]\n[package]\nname = \"effects\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\
         [dependencies]\nsesc-runtime = {{ path = {:?} }}\n[profile.release]\nopt-level = 1\n",
        Path::new(ROOT).join("runtime")
    );
    write_if_changed(&folder.join("Cargo.toml"), &manifest);
    let (mut modules, mut calls) = (String::new(), String::new());
    for Case {
        module,
        corrects,
        moves,
        ..
    } in cases
    {
        let _ = writeln!(modules, "mod {module};");
        let correct = match corrects {
            true => format!("{module}::correct_cop(&cop)"),
            false => "[f64::NAN; 2]".to_string(),
        };
        let zmp = match moves {
            true => format!(
                "{module}::zmp(q, &qd.map(|x| 0.125 * x), &qd.map(|x| -0.5 * x), r).to_vec()"
            ),
            false => "Vec::new()".to_string(),
        };
        let _ = writeln!(
            calls,
            "    run!({module}, q, qd, r, cop, {correct}, {zmp});"
        );
    }
    let main = format!(
        "#![forbid(unsafe_code)]\n#![deny(warnings)]\n{modules}\nmacro_rules! run {{\n    \
         ($m:ident, $q:ident, $qd:ident, $r:ident, $cop:ident, $correct:expr, $zmp:expr) => {{{{\n        let path = std::env::args().nth(1).unwrap();\n        \
         let bytes = std::fs::read(path).unwrap();\n        let values: Vec<f64> = bytes.chunks(8)\
         .map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();\n        let mut out = Vec::new();\n        \
         for q in values.chunks($m::DOF) {{\n            let $q: &[f64; $m::DOF] = q.try_into().unwrap();\n            \
         let $r = &$m::MODEL_PARAMS;\n            \
         let $qd: [f64; $m::DOF] = core::array::from_fn(|j| 1.0 / (1.0 + j as f64));\n            \
         let $cop = $m::cop($q, $r);\n            \
         let back: [f64; 2] = $correct;\n            \
         let mut row: Vec<f64> = $cop.into_iter().chain(back).chain($m::com($q, $r)).collect();\n            \
         row.extend($m::com_jacobian($q, $r).concat());\n            \
         row.extend($m::com_velocity($q, &$qd, $r).into_iter().chain($m::gravity_moments($q, $r)));\n            \
         let zmp: Vec<f64> = $zmp;\n            row.extend(zmp);\n            \
         out.extend(row.into_iter().flat_map(f64::to_le_bytes));\n        }}\n        \
         std::fs::write(concat!(stringify!($m), \".out\"), out).unwrap();\n    }}}};\n}}\n\nfn main() {{\n{calls}}}\n"
    );
    write_if_changed(&folder.join("src/main.rs"), &main);
    for case in cases {
        // Nothing of an earlier run is taken for what this one computes.
        let _ = fs::remove_file(folder.join(format!("{}.out", case.module)));
    }
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("effects-target");
    tool(
        Command::new(env!("CARGO"))
            .args(["run", "--release", "--offline", "--quiet", "--target-dir"])
            .arg(target)
            .arg("--")
            .arg(postures)
            .current_dir(folder),
    );
    let read = |case: &Case| {
        let out = floats(&fs::read(folder.join(format!("{}.out", case.module))).unwrap());
        let said = out.chunks(out.len() / count).map(|row| Said {
            cop: [row[0], row[1]],
            baked: None,
            corrected: case.corrects.then_some([row[2], row[3]]),
            body: row[4..].to_vec(),
        });
        said.collect()
    };
    cases.iter().map(read).collect()
}

/// One case in C, run on all postures, its self-test first.
pub fn c(folder: &Path, case: &Case, postures: &Path, count: usize) -> Vec<Said> {
    let name = &case.module;
    let correct = match case.corrects {
        true => format!("{name}_correct_cop(out, out + 4);"),
        false => String::new(),
    };
    let zmp = match case.moves {
        true => format!("{name}_zmp(q, slow, qdd, r, out + 12 + 4 * N);"),
        false => "(void)slow;\n        (void)qdd;".to_string(),
    };
    let main = format!(
        "#include \"{name}.h\"\n#include <stdio.h>\n\nint main(int count, char **arguments)\n{{\n    \
         enum {{ N = {name}_DOF, WIDTH = 14 + 4 * N }};\n    \
         double q[N], qd[N], slow[N], qdd[N], out[WIDTH] = {{0.0}};\n    const double *r = {name}_model_params;\n    FILE *input = (count > 1) ? fopen(arguments[1], \"rb\") : NULL;\n    \
         if ((input == NULL) || ({name}_selftest() != 0)) {{\n        return 2;\n    }}\n    \
         for (int k = 0; k < N; k += 1) {{\n        qd[k] = 1.0 / (1.0 + k);\n        \
         slow[k] = 0.125 * qd[k];\n        qdd[k] = -0.5 * qd[k];\n    }}\n    \
         while (fread(q, sizeof q, 1u, input) == 1u) {{\n        {name}_cop(q, r, out);\n        \
         {name}_model_cop(q, out + 2);\n        {correct}\n        \
         {name}_com(q, r, out + 6);\n        {name}_com_jacobian(q, r, out + 9);\n        \
         {name}_com_velocity(q, qd, r, out + 9 + 3 * N);\n        \
         {name}_gravity_moments(q, r, out + 12 + 3 * N);\n        \
         {zmp}\n        \
         if (fwrite(out, sizeof out, 1u, stdout) != 1u) {{\n            return 3;\n        }}\n    }}\n    \
         return fclose(input);\n}}\n"
    );
    let source = folder.join(format!("{name}.c"));
    let main_file = folder.join(format!("{name}_main.c"));
    fs::write(&main_file, main).unwrap();
    let program = folder.join(format!("{name}.program"));
    let mut command = Command::new("cc");
    command.args([
        "-std=c99",
        "-Wall",
        "-Wextra",
        "-Wpedantic",
        "-Wconversion",
        "-Werror",
    ]);
    command.args(["-O1", "-ffp-contract=off"]);
    command.arg(source).arg(main_file);
    tool(command.arg("-o").arg(&program));
    let out = floats(&tool(Command::new(&program).arg(postures)));
    let said = out.chunks(out.len() / count).map(|row| Said {
        cop: [row[0], row[1]],
        baked: Some([row[2], row[3]]),
        corrected: case.corrects.then_some([row[4], row[5]]),
        body: row[6..row.len() - if case.moves { 0 } else { 2 }].to_vec(),
    });
    said.collect()
}

/// Compile a package without a warning and run its self-test.
pub fn self_test(folder: &Path, name: &str, package: &Package) {
    fs::write(folder.join(format!("{name}.h")), &package.header).unwrap();
    fs::write(folder.join(format!("{name}.c")), &package.source).unwrap();
    let main = format!("#include \"{name}.h\"\nint main(void) {{ return {name}_selftest(); }}\n");
    fs::write(folder.join("main.c"), main).unwrap();
    let program = folder.join("program");
    let mut command = Command::new("cc");
    command.args([
        "-std=c99",
        "-Wall",
        "-Wextra",
        "-Wpedantic",
        "-Wconversion",
        "-Werror",
    ]);
    command.args(["-Wdouble-promotion", "-Wshadow", "-O1"]);
    command
        .arg(folder.join(format!("{name}.c")))
        .arg(folder.join("main.c"));
    tool(command.arg("-o").arg(&program));
    tool(&mut Command::new(&program));
}

fn floats(bytes: &[u8]) -> Vec<f64> {
    let value = |b: &[u8]| f64::from_le_bytes(b.try_into().unwrap());
    bytes.chunks(8).map(value).collect()
}
