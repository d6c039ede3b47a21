//! f64 and f32 give the bits of Rust, whatever the compiler and its zeal; every scalar stays within
//! the bounds that its header promises, and no integer overflows.
//!
//! Rust stands here as the tape (f64) and as programs run node by node in `f32`;
//! `tests/it/compiled.rs` holds compiled Rust to both, bit by bit.

use sesc_codegen::emit::c::Scalar;
use sesc_model::expr::Argument;
use sesc_model::tape::{Tape, Values};
use sesc_model::tree::Dof;

use super::bounds::{check, in_pairs};
use super::case::{Case, ROBOTS, SCALARS};
use super::compiled::{Compiled, folder, parallel};
use super::draw::{Draw, draw};
use super::entry::Entry;
use super::fixed::trapping;
use crate::COMPILERS;
use sesc_test_support::exact::Interpreter;

/// Postures whose bits are compared.
const POSTURES: usize = 200;
/// Postures of each robot for each function that are held against bounds, corners among them.
const BOUNDED: usize = 1_000;
/// Postures in pairs of doubles, which take a microsecond an operation.
const IN_PAIRS: usize = 150;

/// Level after level; optimisation must not change a bit.
const LEVELS: [&str; 4] = ["-O2", "-O0", "-O1", "-O3"];

/// Each robot in each scalar, compiled once: by one compiler and level after the other. Integers,
/// which give the same everywhere by themselves, are stopped where they overflow.
#[test]
fn compiled_c_has_the_bits_of_rust_and_stays_within_its_bounds() {
    let folder = folder("bits");
    // One compiler has robots and trees that differ in kind.
    let few = COMPILERS.len() == 1;
    let alike = |robot: &(&str, &str)| few && ["body_link", "right_sole"].contains(&robot.1);
    let robots = ROBOTS.iter().filter(|robot| !alike(robot));
    let mut cases: Vec<Case> = robots.map(|(r, s)| Case::robot(r, s)).collect();
    // Of these the functions with a model's parameters as constants, too.
    for name in ["op2_r_sole", "lift_base_hand"] {
        let case = cases.iter_mut().find(|case| case.name == name).unwrap();
        case.take_values(|k, x| x * 1.1 + 0.001 * (k % 3) as f64);
    }
    let trees = cases.len();
    let (count, step) = if few { (8, 2) } else { (12, 1) };
    let seeds = (0..count).step_by(step);
    cases.extend(seeds.map(|k| Case::random(700 + k, 3 + 2 * k as usize)));
    // Effects of two links, whose C takes a compiler seconds; several compilers take the OP2's, too.
    let bodies = Case::bodies().into_iter();
    cases.extend(bodies.filter(|case| !few || case.model.dof() == 2));
    let smooth = cases.len();
    // `effects` has those of two links by one compiler.
    cases.extend(Case::of_cells().into_iter().filter(|_| !few));
    let mut jobs = Vec::new();
    for (k, case) in cases.iter().enumerate() {
        for &scalar in case.scalars() {
            let builds = COMPILERS.len() * LEVELS.len();
            let build = (k * SCALARS.len() + scalar as usize) % builds;
            // Every build for one robot: the OP2 by several compilers, two links by one.
            let is_small = case.model.dof() == 2 && k < trees;
            let chosen = if few { is_small } else { k == 0 };
            let builds = match chosen && scalar != Scalar::Fixed32 {
                true => (0..builds).collect(),
                false => vec![build],
            };
            jobs.push((case, scalar, builds, k < smooth));
        }
    }
    parallel(jobs, |(case, scalar, builds, is_smooth)| {
        let entries = case.entries(scalar);
        for (n, build) in builds.into_iter().enumerate() {
            let compiler = COMPILERS[build % COMPILERS.len()];
            let level = LEVELS[build / COMPILERS.len()];
            let compiled = match scalar {
                Scalar::Fixed32 => trapping(&folder, case),
                _ => Compiled::plain(&folder, case, scalar, compiler, level),
            };
            let drawn = draw(case, POSTURES, 5, &*compiled.hold());
            has_the_bits_of_rust(case, scalar, &compiled, &entries, &drawn);
            if is_smooth && n == 0 {
                bounded(case, scalar, &compiled, &entries);
            }
        }
    });
}

/// In floats compiled C gives the bits of Rust; integers, which Rust does not have, are not stopped.
pub(crate) fn has_the_bits_of_rust(
    case: &Case,
    scalar: Scalar,
    compiled: &Compiled,
    entries: &[Entry],
    drawn: &Draw,
) {
    let found = compiled.run(case, entries, drawn);
    let floats = entries
        .iter()
        .zip(&found)
        .filter(|_| scalar != Scalar::Fixed32);
    for (entry, found) in floats {
        let name = format!("{}_{} {scalar:?}", case.name, entry.name);
        let rust = rust(case, scalar, entry, drawn);
        same(&name, found, &rust, entry.given.is_some());
    }
}

/// The same bits; a result of ticks has none to be compared with.
fn same(name: &str, found: &[f64], expected: &[f64], all: bool) {
    assert!(!all || found.len() == expected.len(), "{name}");
    for (k, (a, b)) in found.iter().zip(expected).enumerate() {
        let same = a.to_bits() == b.to_bits() || (*a == 0.0 && *b == 0.0);
        // An effect of cells has no reading off the foot.
        let same = same || (a.is_nan() && b.is_nan());
        assert!(same, "{name}: {a:e} {b:e} at {k}");
    }
}

/// No bound is exceeded; and one far above what is measured would prove nothing.
pub(crate) fn bounded(case: &Case, scalar: Scalar, compiled: &Compiled, entries: &[Entry]) {
    if scalar == Scalar::F64 {
        let drawn = draw(case, IN_PAIRS, 29, &*compiled.hold());
        for (entry, found) in entries.iter().zip(&compiled.run(case, entries, &drawn)) {
            let (measured, proven) = (in_pairs(case, entry, &drawn, found), compiled.bound(entry));
            let name = format!("{}_{}", case.name, entry.name);
            assert!(measured <= proven, "{name}: {measured:e} of {proven:e}");
        }
        return;
    }
    let drawn = draw(case, BOUNDED, 17, &*compiled.hold());
    for (name, measured, proven) in check(case, compiled, entries, &drawn) {
        // Through springs the worst of four rounds multiplies. The ZMP is drawn where the ground
        // carries half of the weight whatever the parameters: at a hundredth of the motion that
        // its bound holds for.
        let loosest = match name.starts_with("zmp") {
            true => 1e9,
            false if case.has_springs() => 1e6,
            false => 2000.0,
        };
        // Where the header has no bound of use, it says what was seen.
        let tells = measured >= proven / loosest || proven.is_infinite();
        assert!(tells, "{} {name}: {measured:e} of {proven:e}", case.name);
    }
}

/// What Rust computes; nothing for ticks, which Rust does not know.
fn rust(case: &Case, scalar: Scalar, entry: &Entry, drawn: &Draw) -> Vec<f64> {
    if entry.given.is_none() {
        return Vec::new();
    }
    let program = entry.program(case).unwrap();
    let dofs = &case.model.tree.dofs;
    let pair = |(x, dof): (&f64, &Dof)| match dof.prismatic {
        true => (*x, 0.0),
        false => sesc_runtime::trig::sin_cos(*x),
    };
    let pairs = drawn.q.iter().zip(dofs.iter().cycle()).map(pair);
    let (sin, cos): (Vec<f64>, Vec<f64>) = pairs.unzip();
    let [qd, qdd] = drawn.motion(entry.function);
    let arrays = program.inputs.iter().map(|array| match array.argument {
        Argument::Positions => drawn.q.as_slice(),
        Argument::Sines => &sin,
        Argument::Cosines => &cos,
        Argument::Velocities => qd,
        Argument::Accelerations => qdd,
        _ => &drawn.r,
    });
    let count = drawn.q.len() / dofs.len();
    if scalar == Scalar::F64 {
        let arguments: Vec<Values> = arrays.map(Values::PerPosture).collect();
        let mut out = vec![0.0; count * entry.width];
        let portable = sesc_identify::evaluate::PORTABLE;
        Tape::new(&program).run(&arguments, count, &mut out, portable);
        return out;
    }
    let interpreter = Interpreter::new(&program);
    let narrow = |values: &[f64]| values.iter().map(|x| *x as f32).collect::<Vec<f32>>();
    let arrays: Vec<Vec<f32>> = arrays.map(narrow).collect();
    let rows = (0..count).flat_map(|k| {
        let row = |all: &'_ Vec<f32>| -> Vec<f32> {
            let width = all.len() / count;
            all[k * width..(k + 1) * width].to_vec()
        };
        let rows: Vec<Vec<f32>> = arrays.iter().map(row).collect();
        interpreter.run(&rows.iter().map(Vec::as_slice).collect::<Vec<_>>())
    });
    rows.map(f64::from).collect()
}
