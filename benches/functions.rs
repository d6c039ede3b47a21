//! One posture's worth of CoM, Jacobian, CoP rows and full rows, side by side:
//! the reference, the tape (per posture, in blocks) and generated code (from q,
//! from sines and cosines, in f64, f32 and SIMD lanes, per posture).

use std::hint::black_box;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use sesc::evaluate::Evaluator;
use sesc::robot::Robot;
use sesc::simulate::Simulator;
use sesc_codegen::{Function, Model, Snapping};
use sesc_generated::{op2_r_sole, skew_humanoid_right_sole};
use sesc_reference::Reference;
use sesc_runtime::{F32x16, F64x8, Real};

/// Postures in a batch: what a tape and lanes work through together.
const BATCH: usize = 1024;

fn robot(name: &str, support: &str) -> (Model, Reference, Vec<f64>) {
    let path = format!("{}/robots/{name}/{name}.urdf", env!("CARGO_MANIFEST_DIR"));
    let robot = Robot::read(path.as_ref()).unwrap();
    let model = robot.model(support, Snapping::default(), None).unwrap();
    let q = Simulator::new(&model.tree.dofs, None, 1).batch(BATCH);
    (model, robot.reference(support).unwrap(), q)
}

fn reference_and_tape(
    group: &mut BenchmarkGroup<WallTime>,
    function: Function,
    (model, reference, q): &(Model, Reference, Vec<f64>),
) {
    let tape = Evaluator::new(model, function);
    let each = |f: &dyn Fn(&[f64])| q.chunks(model.dof()).for_each(f);
    group.bench_function("reference", |b| {
        b.iter(|| match function {
            Function::Com => each(&|q| {
                black_box(reference.com(q));
            }),
            Function::ComJacobian => each(&|q| {
                black_box(reference.com_jacobian(q));
            }),
            _ => each(&|q| {
                black_box(reference.standard_columns(q));
            }),
        });
    });
    group.bench_function("tape", |b| b.iter(|| black_box(tape.run(q, BATCH))));
}

/// Generated code on a batch, one posture after the other, in each scalar type.
macro_rules! generated {
    ($group:expr, $module:ident, $q:expr, $f:ident ( $($r:ident)? ), $sc:ident) => {{
        const DOF: usize = $module::DOF;
        let q: Vec<[f64; DOF]> = $q.chunks(DOF).map(|q| q.try_into().unwrap()).collect();
        let q32: Vec<[f32; DOF]> = q.iter().map(|q| q.map(|x| x as f32)).collect();
        let sines: Vec<([f64; DOF], [f64; DOF])> = q
            .iter()
            .map(|q| (q.map(|x| Real::sin_cos(x).0), q.map(|x| Real::sin_cos(x).1)))
            .collect();
        let eight: Vec<[F64x8; DOF]> = q
            .chunks(8)
            .map(|p| core::array::from_fn(|j| sesc_runtime::Lanes(core::array::from_fn(|k| p[k][j]))))
            .collect();
        let sixteen: Vec<[F32x16; DOF]> = q32
            .chunks(16)
            .map(|p| core::array::from_fn(|j| sesc_runtime::Lanes(core::array::from_fn(|k| p[k][j]))))
            .collect();
        generated!(@run $group, "f64", $module::$f, q, |q| (q), f64, $module, $($r)?);
        generated!(@run $group, "f64 from sines", $module::$sc, sines, |p| (&p.0, &p.1), f64, $module, $($r)?);
        generated!(@run $group, "f32", $module::$f, q32, |q| (q), f32, $module, $($r)?);
        generated!(@run $group, "f64 x8 lanes", $module::$f, eight, |q| (q), F64x8, $module, $($r)?);
        generated!(@run $group, "f32 x16 lanes", $module::$f, sixteen, |q| (q), F32x16, $module, $($r)?);
    }};
    (@run $group:expr, $name:expr, $f:path, $batch:ident, |$p:ident| ($($argument:expr),+), $t:ty, $module:ident, $r:ident) => {{
        let r = $module::CAD_PARAMS.map(<$t as Real>::from_f64);
        $group.bench_function($name, |b| {
            b.iter(|| for $p in &$batch { black_box($f($($argument),+, black_box(&r))); });
        });
    }};
    (@run $group:expr, $name:expr, $f:path, $batch:ident, |$p:ident| ($($argument:expr),+), $t:ty, $module:ident,) => {{
        $group.bench_function($name, |b| {
            b.iter(|| for $p in &$batch { black_box($f($($argument),+)); });
        });
    }};
}

macro_rules! robot_benches {
    ($name:ident, $module:ident, $robot:expr, $support:expr) => {
        fn $name(c: &mut Criterion) {
            let setup = robot($robot, $support);
            let q = &setup.2;
            let mut group = |function: Function| {
                let mut group = c.benchmark_group(format!("{}/{}", $robot, function.name()));
                group
                    .throughput(Throughput::Elements(BATCH as u64))
                    .sample_size(20)
                    .warm_up_time(Duration::from_millis(300))
                    .measurement_time(Duration::from_millis(1000));
                reference_and_tape(&mut group, function, &setup);
                match function {
                    Function::Com => generated!(group, $module, q, com(r), com_sc),
                    Function::ComJacobian => {
                        generated!(group, $module, q, com_jacobian(r), com_jacobian_sc)
                    }
                    Function::RegressorCop => {
                        generated!(group, $module, q, regressor_cop(), regressor_cop_sc)
                    }
                    _ => generated!(group, $module, q, regressor_full(), regressor_full_sc),
                }
                group.finish();
            };
            group(Function::Com);
            group(Function::ComJacobian);
            group(Function::RegressorCop);
            group(Function::RegressorFull);
        }
    };
}

robot_benches!(op2, op2_r_sole, "op2", "r_sole");
robot_benches!(
    humanoid,
    skew_humanoid_right_sole,
    "skew_humanoid",
    "right_sole"
);

criterion_group!(benches, op2, humanoid);
criterion_main!(benches);
