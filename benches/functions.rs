//! CoM, Jacobian, CoP rows and full rows of a batch of postures, side by side: the
//! reference, the tape, and generated code, as scalars, one posture at a time and in blocks
//! on every set of instructions that this machine has, on one thread and on two.

use std::hint::black_box;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use sesc_identify::evaluate::Evaluator;
use sesc_identify::plan::Limits;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::{Function, Model, Snapping};
use sesc_reference::Reference;
use sesc_runtime::{Batch, F32x16, F64x8, Simd, Single, pack};

/// Postures evaluated together: their rows stay in the second cache.
const BATCH: usize = 512;
/// Batches that each of two threads works through: waking one takes longer than a batch.
const TURNS: usize = 64;

struct Setup {
    model: Model,
    reference: Reference,
    q: Vec<f64>,
}

impl Setup {
    /// Postures within the limits of the URDF, or of a file beside it.
    fn new(name: &str, support: &str, limits: Option<&str>) -> Setup {
        let folder = format!("{}/robots/{name}", env!("CARGO_MANIFEST_DIR"));
        let robot = Robot::read(format!("{folder}/{name}.urdf").as_ref()).unwrap();
        let model = robot.model(support, Snapping::default(), None).unwrap();
        let mut dofs = model.tree.dofs.clone();
        if let Some(file) = limits {
            let limits = Limits::read(format!("{folder}/{file}").as_ref(), &dofs).unwrap();
            for (dof, (lower, upper)) in dofs.iter_mut().zip(limits.ranges) {
                (dof.lower, dof.upper) = (lower, upper);
            }
        }
        Setup {
            reference: sesc::verify::reference(&robot, &model).unwrap(),
            q: Simulator::new(&dofs, None, 1).batch(2 * BATCH),
            model,
        }
    }
}

fn generic(group: &mut BenchmarkGroup<WallTime>, function: Function, setup: &Setup) {
    let q = &setup.q[..BATCH * setup.model.dof()];
    let each = |f: &dyn Fn(&[f64])| q.chunks(setup.model.dof()).for_each(f);
    group.bench_function("reference", |b| {
        b.iter(|| match function {
            Function::Com => each(&|q| {
                black_box(setup.reference.com(q));
            }),
            Function::ComJacobian => each(&|q| {
                black_box(setup.reference.com_jacobian(q));
            }),
            _ => each(&|q| {
                black_box(setup.reference.standard_columns(q));
            }),
        });
    });
    let tape = Evaluator::new(&setup.model, function).fastest();
    let mut out = vec![0.0; BATCH * tape.width()];
    group.bench_function("tape", |b| {
        b.iter(|| tape.run_into(black_box(q), BATCH, black_box(&mut out)));
    });
}

/// Generated code of one robot; `r` marks functions that take parameters.
macro_rules! robot {
    (
        $name:ident, $title:literal, $folder:literal, $support:literal, $limits:expr,
        $home:ident::$module:ident, $robot:ident: $($which:ident)+
    ) => {
        fn $name(c: &mut Criterion) {
            #[allow(unused_imports)] // not every function is on every list
            use $home::$module::{self as module, BASE_PARAMS, CAD_PARAMS, DOF, FULL_PARAMS, $robot};
            let setup = Setup::new($folder, $support, $limits);
            let q: &[[f64; DOF]] = setup.q.as_chunks().0;
            let q32: Vec<[f32; DOF]> = q.iter().map(|q| q.map(|x| x as f32)).collect();
            let eight: Vec<[F64x8; DOF]> = q.as_chunks().0.iter().map(pack).collect();
            let sixteen: Vec<[F32x16; DOF]> = q32.as_chunks().0.iter().map(pack).collect();
            let r32 = CAD_PARAMS.map(|x| x as f32);
            let (zero, zero32) = (F64x8::splat(0.0), F32x16::splat(0.0));

            macro_rules! function {
                (@ Com) => { function!(Com, com(r), com_single, com_batch, |z| [z; 3]) };
                (@ ComJacobian) => {
                    function!(ComJacobian, com_jacobian(r), com_jacobian_single, com_jacobian_batch, |z| [[z; DOF]; 3])
                };
                (@ RegressorCop) => {
                    function!(RegressorCop, regressor_cop(-), regressor_cop_single, regressor_cop_batch, |z| [[z; BASE_PARAMS]; 2])
                };
                (@ RegressorFull) => {
                    function!(RegressorFull, regressor_full(-), regressor_full_single, regressor_full_batch, |z| [[z; FULL_PARAMS]; 3])
                };
                ($function:ident, $scalar:ident($r:tt), $single:ident, $batch:ident, |$z:ident| $start:expr) => {{
                    let function = Function::$function;
                    let mut group = c.benchmark_group(format!("{}/{}", $title, function.name()));
                    group
                        .throughput(Throughput::Elements(BATCH as u64))
                        .sample_size(20)
                        .warm_up_time(Duration::from_millis(200))
                        .measurement_time(Duration::from_millis(700));
                    generic(&mut group, function, &setup);
                    group.bench_function("scalar f64", |b| {
                        b.iter(|| for q in &q[..BATCH] {
                            black_box(function!(@scalar $r, $scalar, black_box(q)));
                        });
                    });
                    let mut out = vec![{ let $z = zero; $start }; 2 * BATCH / 8];
                    let mut out32 = vec![{ let $z = zero32; $start }; 2 * BATCH / 16];
                    for simd in Simd::available() {
                        let set = simd.name();
                        group.bench_function(format!("one posture f64, {set}"), |b| {
                            b.iter(|| for q in &q[..BATCH] {
                                black_box(function!(@one $r, $single, f64, simd, black_box(q), CAD_PARAMS));
                            });
                        });
                        group.bench_function(format!("batch f64, {set}"), |b| {
                            let (q, out) = (&eight[..BATCH / 8], &mut out[..BATCH / 8]);
                            b.iter(|| function!(@many $r, $batch, simd, black_box(q), CAD_PARAMS, out));
                        });
                        group.bench_function(format!("batch f32, {set}"), |b| {
                            let (q, out) = (&sixteen[..BATCH / 16], &mut out32[..BATCH / 16]);
                            b.iter(|| function!(@many $r, $batch, simd, black_box(q), r32, out));
                        });
                    }
                    group.throughput(Throughput::Elements((2 * TURNS * BATCH) as u64));
                    let simd = Simd::best();
                    group.bench_function("batch f64, two threads", |b| {
                        let (q, p) = eight.split_at(eight.len() / 2);
                        let (out, tuo) = out.split_at_mut(q.len());
                        b.iter(|| {
                            rayon::join(
                                || for _ in 0..TURNS {
                                    function!(@many $r, $batch, simd, black_box(q), CAD_PARAMS, out);
                                },
                                || for _ in 0..TURNS {
                                    function!(@many $r, $batch, simd, black_box(p), CAD_PARAMS, tuo);
                                },
                            )
                        });
                    });
                    group.finish();
                }};
                (@scalar r, $f:ident, $q:expr) => { module::$f($q, black_box(&CAD_PARAMS)) };
                (@scalar -, $f:ident, $q:expr) => { module::$f($q) };
                (@one r, $f:ident, $s:ty, $simd:expr, $q:expr, $r:expr) => {
                    $robot::$f($simd, $q, black_box(&$r))
                };
                (@one -, $f:ident, $s:ty, $simd:expr, $q:expr, $r:expr) => {
                    $robot::$f::<$s>($simd, $q)
                };
                (@many r, $f:ident, $simd:expr, $q:expr, $r:expr, $out:expr) => {
                    $robot::$f($simd, $q, black_box(&$r), black_box($out))
                };
                (@many -, $f:ident, $simd:expr, $q:expr, $r:expr, $out:expr) => {
                    $robot::$f($simd, $q, black_box($out))
                };
            }
            $(function!(@ $which);)+
        }
    };
}

robot!(
    op2, "op2", "op2", "r_sole", None, sesc_generated::op2_r_sole, Op2RSole:
    Com ComJacobian RegressorCop RegressorFull
);
robot!(
    paper, "op2 in the paper's limits", "op2", "r_sole", Some("limits_paper.csv"), sesc_generated::op2_r_sole,
    Op2RSole: Com ComJacobian RegressorCop RegressorFull
);
robot!(
    humanoid, "skew_humanoid", "skew_humanoid", "right_sole", None, sesc_bench_robots::skew_humanoid_right_sole,
    SkewHumanoidRightSole: Com RegressorCop
);

criterion_group!(benches, op2, paper, humanoid);
criterion_main!(benches);
