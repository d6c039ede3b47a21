//! Generated Rust, compiled: the same bits as the tape, within the proven bound
//! of the reference, for every robot, effect and random trees; and no branch, no call
//! in what the compiler makes of it.

use std::fmt::Write as _;
use std::fs;

use nalgebra::DVector;
use sesc::verify::{allowed, corners, verify};
use sesc_codegen::emit::rust;
use sesc_codegen::facts::Facts;
use sesc_identify::evaluate::Evaluator;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::bounds::Precision;
use sesc_model::expr::Argument;
use sesc_model::tape::Values;
use sesc_model::{Function, Given, Model, Snapping};
use sesc_test_support::child::Child;
use sesc_test_support::command::ROOT;
use sesc_test_support::exact::Interpreter;
use sesc_test_support::trees::{Kind, tree};

use crate::effects::compiled::{alone, together};
use crate::effects::correction::with;
use crate::effects::robots::{self, Stand};

/// Random postures of each robot in a release, besides corners of the limits.
const POSTURES: usize = 10_000;
/// Of the others.
const FEWER: usize = 2_000;
/// Postures whose results are compared value by value; the others by checksum.
const WRITTEN: usize = 200;

struct Case {
    module: String,
    model: Model,
    /// What stands where, without effects that the reference does not have.
    bare: Option<Robot>,
    /// Row-major postures, exactly representable in f32.
    q: Vec<f64>,
}

impl Case {
    fn new(robot: Robot, support: &str, snapping: Snapping, postures: usize) -> Case {
        let model = robot.model(support, snapping, None).unwrap();
        let mut q = corners(&model, 12);
        q.extend(Simulator::new(&model.tree.dofs, None, 11).batch(postures));
        Case {
            module: String::new(),
            bare: Some(robot),
            q: q.into_iter().map(|x| f64::from(x as f32)).collect(),
            model,
        }
    }

    /// One of `robots/`.
    fn robot(name: &str, support: &str, postures: usize) -> Case {
        let path = format!("{ROOT}/robots/{name}/{name}.urdf");
        let robot = Robot::read(path.as_ref()).unwrap();
        Case::new(robot, support, Snapping::default(), postures)
    }

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

    /// What the compiled program wrote of this.
    fn written(&self, child: &Child, what: &str) -> Vec<f64> {
        let bytes = fs::read(child.path(&format!("{}.{what}", self.module))).unwrap();
        let value = |b: &[u8]| f64::from_le_bytes(b.try_into().unwrap());
        bytes.chunks(8).map(value).collect()
    }
}

/// Robots that are compiled as a controller is: a release.
#[test]
fn optimised_code_is_the_tape_to_the_bit_and_the_reference_within_its_bound() {
    let robots = [("op2", "r_sole"), ("lift_base", "hand")];
    let cases = robots.map(|(name, support)| Case::robot(name, support, POSTURES));
    compiled_is_tape_and_reference("compiled", cases.into(), 3);
}

/// With few optimisations: the same arithmetic, and a third of the compiler's time.
#[test]
fn code_of_every_robot_and_effect_is_the_tape_to_the_bit() {
    let mut cases: Vec<Case> = [
        ("arm6", "base_link"),
        ("quadruped", "lf_foot"),
        ("skew_humanoid", "left_sole"),
    ]
    .map(|(name, support)| Case::robot(name, support, FEWER))
    .into();
    for seed in 0..4 {
        let kind = Kind {
            joints: 4 + 3 * seed as usize,
            canonical: false,
            revolute: false,
            chained: 0.6,
        };
        let (text, links) = tree(500 + seed, kind);
        let robot = Robot::parse(&text, "random.urdf").unwrap();
        cases.push(Case::new(robot, &links[1], Snapping::Off, FEWER));
    }
    // Hundreds of links; a joint that slides passes its position where the others pass sines.
    let kind = Kind {
        joints: 72,
        canonical: false,
        revolute: true,
        chained: 0.7,
    };
    let (text, links) = tree(72, kind);
    let text = text.replacen("type=\"revolute\"", "type=\"prismatic\"", 1);
    let robot = Robot::parse(&text, "random.urdf").unwrap();
    let many = Case::new(robot, &links[0], Snapping::default(), FEWER);
    assert!(many.model.tree.dofs.iter().any(|dof| dof.prismatic));
    let module = rust::module(&Facts::of(&many.model), "many").unwrap();
    let once = !module.contains(".sin_cos()");
    assert!(once, "every body stands once, for positions and for sines");
    cases.push(many);
    let [two_link, op2] = [("two_link", "foot"), ("op2", "r_sole")].map(|(n, s)| Stand::new(n, s));
    for (stand, hidden) in [(&two_link, alone(&two_link)), (&op2, together(&op2))] {
        let q = stand.postures_inside(WRITTEN).concat();
        let q: Vec<f64> = q.into_iter().map(|x| f64::from(x as f32)).collect();
        cases.extend(hidden.iter().map(|(_, hidden)| Case {
            module: String::new(),
            model: with(stand, hidden),
            bare: None,
            q: q.clone(),
        }));
    }
    compiled_is_tape_and_reference("compiled_quick", cases, 1);
}

/// Whoever calls a function that its module was generated without is told so by the compiler.
#[test]
fn a_function_that_was_left_out_is_named_when_it_is_compiled() {
    let child = Child::new("left_out", "");
    let leg = Case::robot("two_link", "foot", 0).model;
    let facts = Facts::with(&leg, &[Function::ComJacobian]);
    child.write("src/leg.rs", &rust::module(&facts, "leg").unwrap());
    // Through the trait, as code for any robot calls: the module has no function `zmp` anyway.
    let build = |call: &str| {
        let main = format!(
            "pub mod leg;\nuse leg::{{CAD_PARAMS as R, Leg}};\nuse sesc_runtime::Sesc;\n\
             fn main() {{\n    let (q, x) = ([0.1, 0.2], [0.0; 2]);\n    \
             println!(\"{{x:?}} {{:?}}\", {call});\n}}\n"
        );
        child.write("src/main.rs", &main);
        child.cargo(&["build", "--release"])
    };
    build("Leg::com_jacobian(&q, &R)").unwrap();
    let error = build("Leg::zmp(&q, &x, &x, &R)").unwrap_err();
    let sentence = "this robot's module was generated without `zmp`: name it in Builder::functions";
    assert!(error.contains(sentence), "{error}");
}

/// Compile the cases with optimisations of `level` in a crate that evaluates each and writes what
/// it finds, run them and compare.
fn compiled_is_tape_and_reference(place: &str, mut cases: Vec<Case>, level: u32) {
    let child = Child::new(
        place,
        &format!("[lib]\nname = \"compiled\"\n[profile.release]\nopt-level = {level}\n"),
    );
    let mut lib = String::from("#![no_std]\n#![forbid(unsafe_code)]\n#![deny(warnings)]\n");
    let mut main = String::from(include_str!("common/compiled_main.rs"));
    main.push_str("\nfn main() {\n");
    for (k, case) in cases.iter_mut().enumerate() {
        case.module = format!("case_{k}");
        let (module, unit) = (&case.module, format!("Case{k}"));
        let functions: Vec<Function> = case.functions().collect();
        let facts = Facts::with(&case.model, &functions);
        let text = rust::module(&facts, module).unwrap();
        child.write(&format!("src/{module}.rs"), &text);
        let _ = writeln!(lib, "pub mod {module};");
        let has = |function, given| case.model.program(function, given).is_some();
        let sines = case.bare.is_some() && has(Function::Com, Given::SinesCosines);
        let which = if sines { "run_sc" } else { "run" };
        let _ = writeln!(main, "    {which}!({module}, {unit});");
        if case.moves() {
            let _ = writeln!(main, "    run_zmp!({module});");
        }
        if has(Function::CorrectCop, Given::Positions) {
            let _ = writeln!(main, "    run_correction!({module});");
        }
        let bytes: Vec<u8> = case.q.iter().flat_map(|x| x.to_le_bytes()).collect();
        fs::write(child.path(&format!("{module}.q")), bytes).unwrap();
        // Nothing of an earlier run is taken for what this one computes.
        for function in Function::ALL.map(Function::name) {
            for end in ["", "_f32"] {
                let _ = fs::remove_file(child.path(&format!("{module}.{function}{end}")));
            }
        }
    }
    main.push_str("}\n");
    child.write("src/lib.rs", &lib);
    child.write("src/main.rs", &main);
    child.cargo(&["run", "--release", "--quiet"]).unwrap();
    for case in &cases {
        same_bits_as_the_tape(case, &child);
        same_bits_in_single_precision(case, &child);
        if let Some(robot) = &case.bare {
            close_to_the_reference(case, robot, &child);
            // The tape stands for the compiled code, bit by bit; so all postures count.
            let postures = case.q.len() / case.model.dof();
            let found = verify(robot, &case.model, postures, 11, &mut ()).unwrap();
            assert!(found.pass, "{}: {found:#?}", case.module);
        }
    }
}

#[track_caller]
fn assert_same(name: &str, found: &[f64], expected: impl IntoIterator<Item = f64>) {
    for (a, b) in found.iter().zip(expected) {
        let same = a.to_bits() == b.to_bits() || (*a == 0.0 && b == 0.0);
        assert!(same, "{name}: {a} {b}");
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

fn same_bits_as_the_tape(case: &Case, child: &Child) {
    let count = case.q.len() / case.model.dof();
    for function in case.functions() {
        let name = format!("{} {}", case.module, function.name());
        let compiled = case.written(child, function.name());
        let [qd, qdd] = motion(&case.model, function);
        let evaluator = Evaluator::new(&case.model, function);
        let tape = evaluator.run_moving(&case.q, [&qd, &qdd].map(|x| Values::Shared(x)), count);
        let written = WRITTEN * evaluator.width();
        assert_same(&name, &compiled[..written], tape[..written].to_vec());
        let rest = tape[written..].chunks(evaluator.width());
        let sums: Vec<f64> = rest.map(checksum).collect();
        assert_eq!(sums.len(), count - WRITTEN, "{name}");
        assert_eq!(compiled[written..], sums, "{name}");
    }
    let correction = case.model.program(Function::CorrectCop, Given::Positions);
    if let Some(correction) = correction {
        let corrected = case.written(child, Function::CorrectCop.name());
        let cop = Evaluator::new(&case.model, Function::Cop).run(&case.q, count);
        let tape = cop.chunks(2).take(WRITTEN);
        let tape = tape.flat_map(|cop| robots::run(&correction, &[cop]));
        assert_same(&case.module, &corrected, tape);
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
fn same_bits_in_single_precision(case: &Case, child: &Child) {
    let narrow = |values: &[f64]| values.iter().map(|x| *x as f32).collect::<Vec<f32>>();
    let r = narrow(&case.model.cad_params());
    for function in case.functions() {
        let [qd, qdd] = motion(&case.model, function).map(|x| narrow(&x));
        let name = format!("{}_f32", function.name());
        let compiled = case.written(child, &name);
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
            let name = format!("{} {name}", case.module);
            assert_same(&name, compiled, expected.into_iter().map(f64::from));
        }
    }
}

fn close_to_the_reference(case: &Case, robot: &Robot, child: &Child) {
    let model = &case.model;
    let reference = sesc::verify::reference(robot, &case.model).unwrap();
    let program = model.program(Function::Com, Given::Positions).unwrap();
    let snapped: f64 = model.tree.snaps.iter().map(|snap| snap.com_error).sum();
    let single_bound = model.rounding(&program, Precision::F32).worst + snapped;
    let com = case.written(child, "com");
    let single = case.written(child, "com_f32");
    let rows = case.written(child, "regressor");
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

/// Release code of the checked-in OP2 on x86-64: straight lines only.
#[test]
fn compiled_functions_have_no_branch_and_no_call() {
    let generated = format!(
        "sesc-generated = {{ path = \"{ROOT}/generated\" }}\n[profile.release]\ncodegen-units = 1\n"
    );
    let child = Child::new("straight", &generated);
    child.write("src/lib.rs", include_str!("common/straight_lib.rs"));
    let assembly = child.path("straight.s").display().to_string();
    let emit = format!("asm={assembly}");
    let words = ["rustc", "--release", "--lib", "--", "--emit", &emit];
    child.cargo(&words).unwrap();
    let assembly = fs::read_to_string(assembly).unwrap();
    for function in [
        "straight_com",
        "straight_com_f32",
        "straight_com_jacobian",
        "straight_regressor",
    ] {
        let body = body(&assembly, function);
        assert!(body.len() > 100, "{function} is {} long", body.len());
        let stray: Vec<&&str> = body.iter().filter(|line| is_jump_or_call(line)).collect();
        assert!(stray.is_empty(), "{function}: {stray:?}");
    }
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
