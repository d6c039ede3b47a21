//! Generated Rust, compiled: the same bits as the tape, within the proven bound
//! of the reference, for every robot and random trees; and no branch, no call
//! in what the compiler makes of it.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use nalgebra::DVector;
use sesc::verify::{allowed, corners, verify};
use sesc_codegen::emit::rust;
use sesc_codegen::facts::Facts;
use sesc_identify::evaluate::Evaluator;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::bounds::Precision;
use sesc_model::expr::Argument;
use sesc_model::{Function, Given, Model, Snapping};
use sesc_test_support::exact::Interpreter;
use sesc_test_support::trees::{Kind, tree};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// Random postures of each robot in a release, besides corners of the limits.
const POSTURES: usize = 10_000;
/// Of the others.
const FEWER: usize = 2_000;
/// Postures whose results are compared value by value; the others by checksum.
const WRITTEN: usize = 200;

/// Robot folder under `robots/`, and a support.
type Standing = (&'static str, &'static str);

/// Robots that are compiled as a controller is: a release.
const OPTIMISED: [Standing; 2] = [("op2", "r_sole"), ("lift_base", "hand")];

/// Robots that are compiled with few optimisations, as random trees are: the same arithmetic,
/// and a third of the compiler's time.
const QUICK: [Standing; 3] = [
    ("arm6", "base_link"),
    ("quadruped", "lf_foot"),
    ("skew_humanoid", "left_sole"),
];

struct Case {
    module: String,
    robot: Robot,
    model: Model,
    support: String,
    /// Row-major postures, exactly representable in f32.
    q: Vec<f64>,
}

impl Case {
    /// Whether its ZMP is compiled: of larger robots that takes long, but for the one of many
    /// joints.
    fn moves(&self) -> bool {
        self.model.dof() <= 12 || self.model.dof() > 64
    }

    /// What is generated and compiled.
    fn functions(&self) -> impl Iterator<Item = Function> {
        let moves = self.moves();
        let all = Function::ALL.into_iter();
        all.filter(move |function| moves || *function != Function::Zmp)
    }
}

fn cases(robots: &[Standing], trees: u64, postures: usize) -> Vec<Case> {
    let mut cases = Vec::new();
    let mut push = |robot: Robot, support: &str, snapping| {
        let module = format!("case_{}", cases.len());
        cases.push(case_of(robot, support, snapping, module, postures));
    };
    for (name, support) in robots {
        let path = Path::new(ROOT).join(format!("robots/{name}/{name}.urdf"));
        push(Robot::read(&path).unwrap(), support, Snapping::default());
    }
    for seed in 0..trees {
        let kind = Kind {
            joints: 4 + 3 * seed as usize,
            canonical: false,
            revolute: false,
            chained: 0.6,
        };
        let (text, links) = tree(500 + seed, kind);
        push(
            Robot::parse(&text, "random.urdf").unwrap(),
            &links[1],
            Snapping::Off,
        );
    }
    cases
}

fn case_of(
    robot: Robot,
    support: &str,
    snapping: Snapping,
    module: String,
    postures: usize,
) -> Case {
    let model = robot.model(support, snapping, None).unwrap();
    let mut q = corners(&model, 12);
    q.extend(Simulator::new(&model.tree.dofs, None, 11).batch(postures));
    Case {
        module,
        support: support.to_string(),
        q: q.into_iter().map(|x| f64::from(x as f32)).collect(),
        robot,
        model,
    }
}

/// A crate that evaluates every case and writes what it finds.
fn write_crate(folder: &Path, cases: &[Case], level: u32) {
    fs::create_dir_all(folder.join("src")).unwrap();
    let manifest = format!(
        "[workspace]\n[package]\nname = \"compiled\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\
         [lib]\nname = \"compiled\"\n[dependencies]\nsesc-runtime = {{ path = {:?} }}\n\
         [profile.release]\nopt-level = {level}\n",
        Path::new(ROOT).join("runtime")
    );
    // What stands there already keeps its time: cargo compiles what has changed.
    let write = |name: &str, text: String| {
        let path = folder.join(name);
        if fs::read_to_string(&path).ok().as_ref() != Some(&text) {
            fs::write(path, text).unwrap();
        }
    };
    write("Cargo.toml", manifest);
    let mut lib = String::from("#![no_std]\n#![forbid(unsafe_code)]\n#![deny(warnings)]\n");
    let mut main = String::from(include_str!("common/compiled_main.rs"));
    main.push_str("\nfn main() {\n");
    for case in cases {
        let functions: Vec<Function> = case.functions().collect();
        let facts = Facts::with(&case.model, &functions);
        let text = rust::module(&facts, &case.module).unwrap();
        write(&format!("src/{}.rs", case.module), text);
        let _ = writeln!(lib, "pub mod {};", case.module);
        let sc = case
            .model
            .program(Function::Com, Given::SinesCosines)
            .is_some();
        let which = if sc { "run_sc" } else { "run" };
        let unit = case.module.replace("case_", "Case");
        let _ = writeln!(main, "    {which}!({}, {unit});", case.module);
        if case.moves() {
            let _ = writeln!(main, "    run_zmp!({});", case.module);
        }
        let bytes: Vec<u8> = case.q.iter().flat_map(|x| x.to_le_bytes()).collect();
        fs::write(folder.join(format!("{}.q", case.module)), bytes).unwrap();
    }
    main.push_str("}\n");
    write("src/lib.rs", lib);
    write("src/main.rs", main);
}

fn cargo(folder: &Path, arguments: &[&str]) {
    ran(folder, arguments).unwrap_or_else(|error| panic!("{error}"));
}

/// What cargo says where it fails.
fn ran(folder: &Path, arguments: &[&str]) -> Result<(), String> {
    let output = Command::new(env!("CARGO"))
        .arg(arguments[0])
        .args(["--release", "--offline", "--quiet", "--target-dir"])
        .arg(folder.join("target"))
        .args(&arguments[1..])
        .current_dir(folder)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    output.status.success().then_some(()).ok_or(said)
}

fn floats(path: &Path) -> Vec<f64> {
    let bytes = fs::read(path).unwrap();
    bytes
        .chunks(8)
        .map(|b| f64::from_le_bytes(b.try_into().unwrap()))
        .collect()
}

#[test]
fn optimised_code_is_the_tape_to_the_bit_and_the_reference_within_its_bound() {
    compiled_is_tape_and_reference("compiled", &cases(&OPTIMISED, 0, POSTURES), 3);
}

#[test]
fn code_of_every_robot_is_the_tape_to_the_bit_and_the_reference_within_its_bound() {
    compiled_is_tape_and_reference("compiled_quick", &cases(&QUICK, 4, FEWER), 1);
}

#[test]
fn code_of_many_joints_is_the_tape_to_the_bit_and_the_reference_within_its_bound() {
    let kind = Kind {
        joints: 72,
        canonical: false,
        revolute: true,
        chained: 0.7,
    };
    let (text, links) = tree(72, kind);
    // A joint that slides passes its position where the others pass sines.
    let text = text.replacen("type=\"revolute\"", "type=\"prismatic\"", 1);
    let robot = Robot::parse(&text, "random.urdf").unwrap();
    let case = case_of(
        robot,
        &links[0],
        Snapping::default(),
        "case_0".to_string(),
        FEWER,
    );
    assert!(case.model.tree.dofs.iter().any(|dof| dof.prismatic));
    let module = rust::module(&Facts::of(&case.model), &case.module).unwrap();
    assert!(
        !module.contains(".sin_cos()"),
        "every body stands once, for positions and for sines"
    );
    compiled_is_tape_and_reference("compiled_many", &[case], 1);
}

/// Whoever calls a function that its module was generated without is told so by the compiler.
#[test]
fn a_function_that_was_left_out_is_named_when_it_is_compiled() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("left_out");
    let path = Path::new(ROOT).join("robots/two_link/two_link.urdf");
    let robot = Robot::read(&path).unwrap();
    let model = robot.model("foot", Snapping::default(), None).unwrap();
    let facts = Facts::with(&model, &[Function::ComJacobian]);
    write_crate(&folder, &[], 1);
    let module = rust::module(&facts, "leg").unwrap();
    fs::write(folder.join("src/leg.rs"), module).unwrap();
    fs::write(folder.join("src/lib.rs"), "pub mod leg;\n").unwrap();
    // Through the trait, as code for any robot calls: the module has no function `zmp` anyway.
    let main = |call: &str| {
        format!(
            "use compiled::leg::{{CAD_PARAMS as R, Leg}};\nuse sesc_runtime::Sesc;\n\
             fn main() {{\n    let (q, x) = ([0.1, 0.2], [0.0; 2]);\n    \
             println!(\"{{x:?}} {{:?}}\", {call});\n}}\n"
        )
    };
    fs::write(
        folder.join("src/main.rs"),
        main("Leg::com_jacobian(&q, &R)"),
    )
    .unwrap();
    cargo(&folder, &["run"]);
    fs::write(folder.join("src/main.rs"), main("Leg::zmp(&q, &x, &x, &R)")).unwrap();
    let error = ran(&folder, &["build"]).unwrap_err();
    let sentence = "this robot's module was generated without `zmp`: name it in Builder::functions";
    assert!(error.contains(sentence), "{error}");
}

/// Compile the cases with optimisations of `level`, run them and compare.
fn compiled_is_tape_and_reference(place: &str, cases: &[Case], level: u32) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(place);
    write_crate(&folder, cases, level);
    // Nothing of an earlier run is taken for what this one computes.
    for entry in fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        if path
            .file_name()
            .unwrap()
            .to_string_lossy()
            .starts_with("case_")
            && path.extension().is_some_and(|what| what != "q")
        {
            fs::remove_file(path).unwrap();
        }
    }
    cargo(&folder, &["run"]);
    for case in cases {
        same_bits_as_the_tape(case, &folder);
        same_bits_in_single_precision(case, &folder);
        close_to_the_reference(case, &folder);
        tape_agrees_with_the_reference(case);
    }
}

/// The checksum of the compiled program, over what the tape computes.
fn checksum(values: &[f64]) -> f64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for value in values {
        // −0 and 0 are one number.
        let bits = if *value == 0.0 { 0 } else { value.to_bits() };
        hash = (hash ^ bits).wrapping_mul(0x0000_0100_0000_01b3);
    }
    (hash >> 12) as f64
}

fn same_bits_as_the_tape(case: &Case, folder: &Path) {
    let count = case.q.len() / case.model.dof();
    for function in case.functions() {
        let name = format!("{} {}", case.module, function.name());
        let compiled = floats(&folder.join(format!("{}.{}", case.module, function.name())));
        let [qd, qdd] = motion(&case.model, function);
        let evaluator = Evaluator::new(&case.model, function).moving(&qd, &qdd);
        let tape = evaluator.run(&case.q, count);
        let written = WRITTEN * evaluator.width();
        for (a, b) in compiled[..written].iter().zip(&tape) {
            assert!(
                a.to_bits() == b.to_bits() || (*a == 0.0 && *b == 0.0),
                "{name}: {a} {b}"
            );
        }
        let sums: Vec<f64> = tape[written..]
            .chunks(evaluator.width())
            .map(checksum)
            .collect();
        assert_eq!(sums.len(), count - WRITTEN, "{name}");
        assert_eq!(compiled[written..], sums, "{name}");
    }
}

/// Joint velocities (rad/s or m/s) and accelerations that `function` takes, no two alike; as
/// `common/compiled_main.rs` has them.
fn motion(model: &Model, function: Function) -> [Vec<f64>; 2] {
    let rate = |j| f64::from(1.0 / (1.0 + j as f32));
    let rates: Vec<f64> = (0..model.dof()).map(rate).collect();
    let times = |factor: f64| rates.iter().map(|x| factor * x).collect();
    match function {
        Function::Zmp => [times(0.125), times(-0.5)],
        _ => [rates.clone(), Vec::new()],
    }
}

/// `f32`, against the programs run node by node.
fn same_bits_in_single_precision(case: &Case, folder: &Path) {
    let narrow = |values: &[f64]| values.iter().map(|x| *x as f32).collect::<Vec<f32>>();
    let r = narrow(&case.model.cad_params());
    for function in case.functions() {
        let [qd, qdd] = motion(&case.model, function).map(|x| narrow(&x));
        let name = format!("{}.{}_f32", case.module, function.name());
        let compiled = floats(&folder.join(&name));
        let program = case.model.program(function, Given::Positions).unwrap();
        let (interpreter, width) = (Interpreter::new(&program), program.outputs.len());
        let rows = compiled.chunks(width).zip(case.q.chunks(case.model.dof()));
        for (compiled, q) in rows.take(WRITTEN) {
            let q = narrow(q);
            let inputs = program.inputs.iter().map(|array| match array.argument {
                Argument::Velocities => qd.as_slice(),
                Argument::Accelerations => &qdd,
                Argument::Parameters => &r,
                _ => &q,
            });
            let expected = interpreter.run(&inputs.collect::<Vec<_>>());
            for (a, b) in compiled.iter().zip(expected) {
                let b = f64::from(b);
                assert!(
                    a.to_bits() == b.to_bits() || (*a == 0.0 && b == 0.0),
                    "{name}: {a} {b}"
                );
            }
        }
    }
}

fn close_to_the_reference(case: &Case, folder: &Path) {
    let model = &case.model;
    let reference = sesc::verify::reference(&case.robot, &case.support).unwrap();
    let program = model.program(Function::Com, Given::Positions).unwrap();
    let snapped: f64 = model.tree.snaps.iter().map(|snap| snap.com_error).sum();
    let single_bound = model.rounding(&program, Precision::F32).worst + snapped;
    let com = floats(&folder.join(format!("{}.com", case.module)));
    let single = floats(&folder.join(format!("{}.com_f32", case.module)));
    let rows = floats(&folder.join(format!("{}.regressor", case.module)));
    let params = DVector::from_vec(model.cad_params());
    let bounds = [
        allowed(model, Function::Com, Given::Positions),
        allowed(model, Function::Regressor, Given::Positions),
    ];
    let mut worst_single: f64 = 0.0;
    for (k, q) in case.q.chunks(model.dof()).take(WRITTEN).enumerate() {
        let truth = reference.com(q);
        for axis in 0..3 {
            let at = 3 * k + axis;
            let row = &rows[at * params.len()..(at + 1) * params.len()];
            let by_rows = DVector::from_column_slice(row).dot(&params);
            let error = [(com[at] - truth[axis]).abs(), (by_rows - truth[axis]).abs()];
            assert!(
                error[0] <= bounds[0] && error[1] <= bounds[1],
                "{}: {error:?}",
                case.module
            );
            worst_single = worst_single.max((single[at] - truth[axis]).abs());
        }
    }
    assert!(
        worst_single <= single_bound,
        "{}: f32 off by {worst_single:.1e}, proven {single_bound:.1e}",
        case.module
    );
    // A bound far above what is measured would prove nothing.
    assert!(
        worst_single >= single_bound / 200.0,
        "{worst_single:.1e} of {single_bound:.1e}"
    );
}

/// The tape stands for the compiled code, bit by bit; so all postures count.
fn tape_agrees_with_the_reference(case: &Case) {
    let postures = case.q.len() / case.model.dof();
    let found = verify(&case.robot, &case.model, postures, 11, &mut ()).unwrap();
    assert!(found.pass, "{}: {found:#?}", case.module);
}

/// Release code of the checked-in OP2 on x86-64: straight lines only.
#[test]
fn compiled_functions_have_no_branch_and_no_call() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("straight");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(folder.join("src")).unwrap();
    let manifest = format!(
        "[workspace]\n[package]\nname = \"straight\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\
         [dependencies]\nsesc-generated = {{ path = {:?} }}\n[profile.release]\ncodegen-units = 1\n",
        Path::new(ROOT).join("generated")
    );
    fs::write(folder.join("Cargo.toml"), manifest).unwrap();
    fs::write(
        folder.join("src/lib.rs"),
        include_str!("common/straight_lib.rs"),
    )
    .unwrap();
    cargo(&folder, &["rustc", "--lib", "--", "--emit", "asm"]);
    let assembly = newest_assembly(&folder);
    for function in [
        "straight_com",
        "straight_com_f32",
        "straight_com_jacobian",
        "straight_regressor",
    ] {
        let body = body(&assembly, function);
        assert!(
            body.len() > 100,
            "{function} is {} instructions",
            body.len()
        );
        let stray: Vec<&&str> = body.iter().filter(|line| is_jump_or_call(line)).collect();
        assert!(stray.is_empty(), "{function}: {stray:?}");
    }
}

fn newest_assembly(folder: &Path) -> String {
    let deps = folder.join("target/release/deps");
    let found: Vec<PathBuf> = fs::read_dir(deps)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            let name = path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            name.starts_with("straight-") && name.ends_with(".s")
        })
        .collect();
    let newest = found
        .iter()
        .max_by_key(|path| fs::metadata(path).unwrap().modified().unwrap());
    fs::read_to_string(newest.expect("rustc wrote assembly")).unwrap()
}

/// Instructions between a function's label and its end.
fn body<'a>(assembly: &'a str, function: &str) -> Vec<&'a str> {
    let label = format!("{function}:");
    assembly
        .lines()
        .skip_while(|line| *line != label)
        .skip(1)
        .take_while(|line| !line.trim_start().starts_with(".cfi_endproc"))
        .map(str::trim)
        .filter(|line| !line.starts_with('.') && !line.ends_with(':') && !line.is_empty())
        .collect()
}

/// x86: j*, call, loop*; ARM64: b, bl, b.cond, cb(n)z, tb(n)z.
fn is_jump_or_call(line: &str) -> bool {
    let name = line.split_whitespace().next().unwrap_or_default();
    let arm = ["b", "bl", "blr", "br", "cbz", "cbnz", "tbz", "tbnz"];
    name.starts_with('j')
        || name.starts_with("call")
        || name.starts_with("loop")
        || name.starts_with("b.")
        || arm.contains(&name)
}
