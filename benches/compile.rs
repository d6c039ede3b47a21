//! What generated code costs before it runs: the generator's time for a whole module, the
//! compiler's for the functions that a crate calls, and the size of their machine code.
//!
//! Each robot twice: its whole module, and one of the three functions alone that are called.
//!
//! `cargo bench --bench compile` takes minutes, most of them at 1000 joints; `-- 100 500` draws
//! trees of other sizes, and `-- --test` stops after the OP2.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use sesc_codegen::emit::rust;
use sesc_codegen::facts::Facts;
use sesc_identify::robot::Robot;
use sesc_model::{Function, Model, Snapping};
use sesc_test_support::trees::{Kind, tree};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// Functions that are called, and whose size is told.
const CALLED: [Function; 3] = [Function::Com, Function::ComJacobian, Function::RegressorCop];

fn main() {
    let robots = [("op2", "r_sole"), ("plain_humanoid", "right_sole")];
    let known = robots.iter().map(|(name, support)| {
        let path = Path::new(ROOT).join(format!("robots/{name}/{name}.urdf"));
        let robot = Robot::read(&path).expect("robots of the repository are read");
        (
            robot.model(support, Snapping::default(), None),
            (*name).to_string(),
        )
    });
    let asked: Vec<usize> = std::env::args()
        .filter_map(|word| word.parse().ok())
        .collect();
    let sizes = if asked.is_empty() {
        vec![100, 500, 1000]
    } else {
        asked
    };
    let drawn = sizes.into_iter().map(|joints| {
        let kind = Kind {
            joints,
            canonical: false,
            revolute: true,
            chained: 0.8,
        };
        let (text, links) = tree(joints as u64, kind);
        let robot = Robot::parse(&text, "random.urdf").expect("random trees are robots");
        (
            robot.model(&links[0], Snapping::default(), None),
            "random tree".to_string(),
        )
    });
    let few = std::env::args().any(|argument| argument == "--test");
    println!(
        "robot           joints  functions  generated    lines  compiled  com, kB  jacobian  CoP rows"
    );
    for (model, name) in known.chain(drawn).take(if few { 1 } else { usize::MAX }) {
        let model = model.expect("supports are links of their robots");
        for functions in [&Function::ALL[..], &CALLED] {
            let start = Instant::now();
            let facts = Facts::with(&model, functions);
            let text = rust::module(&facts, "robot").expect("the robot can be generated");
            let generated = start.elapsed();
            let (compiled, sizes) = compile(&model, &text);
            println!(
                "{name:<14} {:>7} {:>10} {:>7.0} ms {:>8} {:>7.1} s {:>8.1} {:>9.1} {:>9.1}",
                model.dof(),
                functions.len(),
                1e3 * generated.as_secs_f64(),
                text.lines().count(),
                compiled,
                sizes[0],
                sizes[1],
                sizes[2],
            );
        }
    }
}

/// Seconds that a crate with these functions takes beyond an empty one, and sizes in kB.
fn compile(model: &Model, module: &str) -> (f64, [f64; 3]) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("compile");
    let source = folder.join("src");
    fs::create_dir_all(&source).expect("the target folder can be written to");
    let write = |name: &str, text: &str| {
        fs::write(folder.join(name), text).expect("the target folder can be written to");
    };
    let runtime = Path::new(ROOT).join("runtime");
    write(
        "Cargo.toml",
        &format!(
            "[workspace]\n[package]\nname = \"compile\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\
             [lib]\ncrate-type = [\"cdylib\"]\n[dependencies]\n\
             sesc-runtime = {{ path = {runtime:?} }}\n[profile.release]\ncodegen-units = 1\n"
        ),
    );
    write("src/lib.rs", "");
    build(&folder);
    write("src/robot.rs", module);
    let (dof, base) = (model.dof(), model.base.params.len());
    let call = |name: &str, arguments: &str, result: String, call: &str| {
        format!(
            "#[unsafe(no_mangle)]\npub fn counted_{name}(q: &[f64; {dof}], {arguments}out: &mut {result}) \
             {{ *out = robot::{name}({call}); }}\n"
        )
    };
    let r = format!("r: &[f64; {base}], ");
    let lib = [
        "mod robot;\n".to_string(),
        call("com", &r, "[f64; 3]".into(), "q, r"),
        call("com_jacobian", &r, format!("[[f64; {dof}]; 3]"), "q, r"),
        call("regressor_cop", "", format!("[[f64; {base}]; 2]"), "q"),
    ];
    write("src/lib.rs", &lib.concat());
    let start = Instant::now();
    build(&folder);
    let seconds = start.elapsed().as_secs_f64();
    let library = folder.join("target/release/libcompile.so");
    let nm = Command::new("nm")
        .arg("--print-size")
        .arg(&library)
        .output();
    let listed = nm.map(|out| String::from_utf8_lossy(&out.stdout).into_owned());
    let listed = listed.expect("nm, of binutils, lists symbols");
    let size = |function: Function| {
        let symbol = format!("counted_{}", function.name());
        let line = listed.lines().find(|line| line.ends_with(&symbol));
        let size = line.and_then(|line| line.split_whitespace().nth(1));
        let size = size.and_then(|size| u64::from_str_radix(size, 16).ok());
        size.map_or(f64::NAN, |bytes| bytes as f64 / 1e3)
    };
    (seconds, CALLED.map(size))
}

fn build(folder: &Path) {
    let cargo = Command::new(env!("CARGO"))
        .args(["build", "--release", "--quiet", "--offline", "--target-dir"])
        .arg(folder.join("target"))
        .current_dir(folder)
        .env_remove("RUSTFLAGS")
        .status();
    assert!(
        cargo.is_ok_and(|status| status.success()),
        "the generated crate builds"
    );
}
