//! Programs on tape as Rust calls them, in nanoseconds a posture: one posture a call, and a
//! batch. `benches/python.py` runs it beside the same calls from Python.
//!
//! `cargo bench --bench tape -- URDF SUPPORT` prints a line of each function: its name, one
//! posture, a batch. Each number is the least of many short repeats. Of the OP2 on its right sole
//! it also prints what one posture takes generated code.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use sesc_generated::op2_r_sole::{self as op2, CAD_PARAMS, DOF};
use sesc_identify::evaluate::Evaluator;
use sesc_identify::robot::{Robot, Stance};
use sesc_model::Function;
use sesc_model::tape::Values;

/// The functions that Python has, by its names.
const FUNCTIONS: [(&str, Function); 9] = [
    ("com", Function::Com),
    ("com_jacobian", Function::ComJacobian),
    ("com_velocity", Function::ComVelocity),
    ("gravity_moments", Function::GravityMoments),
    ("cop", Function::Cop),
    ("cop_rows", Function::RegressorCop),
    ("com_rows", Function::Regressor),
    ("full_rows", Function::RegressorFull),
    ("zmp", Function::Zmp),
];

/// Calls of one posture that are timed together: short enough to be left alone by other programs.
const ALONE: usize = 200;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let tested = arguments.iter().any(|argument| argument == "--test");
    let mut given = arguments.iter().filter(|word| !word.starts_with("--"));
    let op2 = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/op2/op2.urdf");
    let urdf = given.next().map_or(op2, String::as_str);
    let support = given.next().map_or("r_sole", String::as_str);
    let model =
        Robot::read(Path::new(urdf)).and_then(|robot| Stance::new(robot).on(support).model());
    let model = model.expect("the robot can be read");
    let (postures, repeats) = if tested { (100, 1) } else { (10_000, 300) };
    let q: Vec<f64> = (0..postures * model.dof())
        .map(|k| 0.5 * f64::sin(k as f64))
        .collect();
    for (name, function) in FUNCTIONS {
        let evaluator = Evaluator::new(&model, function);
        let mut out = vec![0.0; postures * evaluator.width()];
        let few = ALONE.min(postures);
        let one = least(repeats, || {
            for q in q.chunks_exact(model.dof()).take(few) {
                // Velocities and accelerations for those that take them.
                let q = black_box(q);
                evaluator.run_moving_into(q, [Values::PerPosture(q); 2], 1, &mut out);
            }
        });
        let batch = least(repeats, || {
            let q = black_box(&q[..]);
            evaluator.run_moving_into(q, [Values::PerPosture(q); 2], postures, &mut out)
        });
        println!(
            "{name:<20} {:>10.1} {:>10.1}",
            1e9 * one / few as f64,
            1e9 * batch / postures as f64
        );
    }
    if urdf == op2 && support == "r_sole" {
        generated(&q, repeats);
    }
}

/// One posture by generated code, as scalars: sines and arithmetic of the same bits.
fn generated(q: &[f64], repeats: usize) {
    let r = black_box(&CAD_PARAMS);
    let postures = || q.as_chunks::<DOF>().0.iter().take(ALONE).map(black_box);
    let few = postures().count();
    let print = |name: &str, seconds: f64| {
        println!("{name}, generated code: {:.1}", 1e9 * seconds / few as f64);
    };
    let com = || {
        postures().for_each(|q| {
            black_box(op2::com(q, r));
        })
    };
    print("com", least(repeats, com));
    let zmp = || {
        postures().for_each(|q| {
            black_box(op2::zmp(q, q, q, r));
        })
    };
    print("zmp", least(repeats, zmp));
}

/// Seconds of one call.
fn least(repeats: usize, mut call: impl FnMut()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        call();
        start.elapsed().as_secs_f64()
    };
    (0..repeats).map(time).fold(f64::INFINITY, f64::min)
}
