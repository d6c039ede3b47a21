//! f64 and f32 give the bits of Rust, whatever the compiler and its zeal; integers
//! give the same everywhere by themselves.
//!
//! Rust stands here as the tape (f64) and as programs run node by node in `f32`;
//! `tests/compiled.rs` holds compiled Rust to both, bit by bit.

use sesc_codegen::emit::c::Scalar;
use sesc_model::Given;
use sesc_model::tape::{Tape, Values};

use super::case::{Case, ROBOTS};
use super::compiled::{Compiled, folder, parallel};
use super::draw::{Draw, draw};
use super::entry::Entry;
use sesc_test_support::exact::Interpreter;

const POSTURES: usize = 200;

/// Level after level; optimisation must not change a bit.
const BUILDS: [(&str, &str); 6] = [
    ("gcc", "-O2"),
    ("clang", "-O2"),
    ("gcc", "-O0"),
    ("clang", "-O3"),
    ("gcc", "-O3"),
    ("clang", "-O0"),
];

#[test]
fn every_compiler_gives_the_bits_of_rust() {
    let folder = folder("bits");
    let mut cases: Vec<Case> = ROBOTS.iter().map(|(r, s)| Case::robot(r, s)).collect();
    cases.extend((0..12).map(|k| Case::random(700 + k, 3 + k as usize)));
    cases.extend(Case::effects());
    let mut jobs = Vec::new();
    for (k, case) in cases.iter().enumerate() {
        for &scalar in case.scalars() {
            // Every build for one robot, in turn one for the others, two for some trees.
            let count = match k {
                0 => BUILDS.len(),
                _ if k > ROBOTS.len() && k % 3 == 0 => 2,
                _ => 1,
            };
            // Integers are compared between builds, floats with Rust.
            if scalar != Scalar::Fixed32 || count > 1 {
                let builds = BUILDS.into_iter().cycle().skip(k * count).take(count);
                jobs.push((case, scalar, builds.collect::<Vec<_>>()));
            }
        }
    }
    parallel(jobs, |(case, scalar, builds)| {
        let entries = case.entries(scalar);
        let entries: Vec<&Entry> = entries.iter().collect();
        let mut first: Option<(Draw, Vec<Vec<f64>>)> = None;
        for (compiler, level) in builds {
            let compiled =
                Compiled::build(&folder, case, scalar, compiler, &[level], |source| source);
            let (drawn, expected) = first.get_or_insert_with(|| {
                let drawn = draw(case, POSTURES, 5, &*compiled.hold());
                let expected = match scalar {
                    Scalar::Fixed32 => compiled.run(case, &entries, &drawn),
                    _ => entries
                        .iter()
                        .map(|e| rust(case, scalar, e, &drawn))
                        .collect(),
                };
                (drawn, expected)
            });
            let found = compiled.run(case, &entries, drawn);
            for ((entry, found), expected) in entries.iter().zip(&found).zip(expected.iter()) {
                let name = format!("{}_{} {scalar:?} {compiler} {level}", case.name, entry.name);
                assert!(
                    entry.given.is_none() || found.len() == expected.len(),
                    "{name}"
                );
                for (k, (a, b)) in found.iter().zip(expected).enumerate() {
                    let same = a.to_bits() == b.to_bits() || (*a == 0.0 && *b == 0.0);
                    // An effect of cells has no reading off the foot.
                    let same = same || (a.is_nan() && b.is_nan());
                    assert!(same, "{name}: {a:e} {b:e} at {k}");
                }
            }
        }
    });
}

/// What Rust computes; nothing for ticks, which Rust does not know.
fn rust(case: &Case, scalar: Scalar, entry: &Entry, drawn: &Draw) -> Vec<f64> {
    let Some(given) = entry.given else {
        return Vec::new();
    };
    let program = entry.program(case).unwrap();
    let dof = case.model.dof();
    let params = case.model.base.params.len();
    let prismatic: Vec<bool> = case
        .model
        .tree
        .dofs
        .iter()
        .map(|dof| dof.prismatic)
        .collect();
    let (sin, cos): (Vec<f64>, Vec<f64>) = drawn
        .q
        .iter()
        .zip(prismatic.iter().cycle())
        .map(|(x, prismatic)| match prismatic {
            true => (*x, 0.0),
            false => sesc_runtime::trig::sin_cos(*x),
        })
        .unzip();
    let mut inputs: Vec<(&[f64], usize)> = match given {
        Given::Positions => vec![(&drawn.q, dof)],
        Given::SinesCosines | Given::Direction => vec![(&sin, dof), (&cos, dof)],
    };
    let [qd, qdd] = drawn.motion(entry.function);
    if entry.takes_velocities() {
        inputs.push((qd, dof));
    }
    if entry.takes_accelerations() {
        inputs.push((qdd, dof));
    }
    if entry.takes_parameters() {
        inputs.push((&drawn.r, params));
    }
    let count = drawn.q.len() / dof;
    if scalar == Scalar::F64 {
        let arguments: Vec<Values> = inputs
            .iter()
            .map(|(values, _)| Values::PerPosture(values))
            .collect();
        let mut out = vec![0.0; count * entry.width];
        Tape::new(&program).run(
            &arguments,
            count,
            &mut out,
            sesc_identify::evaluate::PORTABLE,
        );
        return out;
    }
    let interpreter = Interpreter::new(&program);
    let inputs: Vec<(Vec<f32>, usize)> = inputs
        .iter()
        .map(|(values, len)| (values.iter().map(|x| *x as f32).collect(), *len))
        .collect();
    let rows = (0..count).flat_map(|k| {
        let row = |(values, len): &(Vec<f32>, usize)| values[k * len..(k + 1) * len].to_vec();
        let rows: Vec<Vec<f32>> = inputs.iter().map(row).collect();
        let rows: Vec<&[f32]> = rows.iter().map(Vec::as_slice).collect();
        interpreter.run(&rows)
    });
    rows.map(f64::from).collect()
}
