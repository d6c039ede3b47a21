//! Estimating the 43 base parameters of the OP2 on its right sole, posture by
//! posture: feeding a posture whose rows are known, and reading off the
//! parameters and their covariance.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use sesc::OP2_URDF;
use sesc_generated::op2_r_sole::{self as op2, BASE_PARAMS as N, CAD_PARAMS, DOF};
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::Snapping;
use sesc_runtime::fit::Estimator;
use sesc_runtime::{Scalar, Simd};

/// Postures fed in turn.
const POSTURES: usize = 1024;

fn scalar<T: Scalar>(c: &mut Criterion, name: &str) {
    let robot = Robot::parse(OP2_URDF, "op2.urdf").unwrap();
    let model = robot.model("r_sole", Snapping::default(), None).unwrap();
    let mut simulator = Simulator::new(&model.tree.dofs, None, 1);
    let data: Vec<_> = (0..POSTURES)
        .map(|_| {
            let q: [f64; DOF] = simulator.posture().try_into().unwrap();
            let cop = op2::cop(&q, &CAD_PARAMS).map(|x| T::from_f64(x + simulator.gauss(1e-3)));
            (op2::regressor_cop(&q).map(|row| row.map(T::from_f64)), cop)
        })
        .collect();
    let (mean, std) = (CAD_PARAMS.map(T::from_f64), [T::from_f64(0.02); N]);
    let noise = [T::from_f64(1e-3); 2];
    let start = Estimator::with_prior(&mean, &std).unwrap();

    let mut group = c.benchmark_group(format!("op2/fit {name}"));
    group
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_millis(1000));
    for (feed, lambda) in [("posture", 1.0), ("posture, forgetting", 0.999)] {
        let mut estimator = start.clone().forgetting(T::from_f64(lambda)).unwrap();
        let mut turn = data.iter().cycle();
        group.bench_function(feed, |b| {
            b.iter(|| {
                if let Some((rows, cop)) = turn.next() {
                    black_box(estimator.posture(black_box(rows), black_box(cop), &noise)).unwrap();
                }
            });
        });
    }
    let mut estimator = start;
    for (rows, cop) in &data {
        estimator.posture(rows, cop, &noise).unwrap();
    }
    group.bench_function("params", |b| b.iter(|| black_box(&estimator).params()));
    group.bench_function("predict a row", |b| {
        b.iter(|| black_box(&estimator).predict(black_box(&data[0].0[0])));
    });
    let mut covariance = [[T::ZERO; N]; N];
    group.bench_function("covariance", |b| {
        b.iter(|| black_box(&estimator).covariance(black_box(&mut covariance)));
    });
    group.bench_function("merge", |b| {
        b.iter_batched_ref(
            || estimator.clone(),
            |other| other.merge(black_box(&estimator)),
            criterion::BatchSize::SmallInput,
        );
    });
    group.finish();
}

fn op2_fit(c: &mut Criterion) {
    scalar::<f64>(c, "f64");
    scalar::<f32>(c, "f32");
}

/// Parameters from postures in memory: rows, products, one refinement.
fn many(c: &mut Criterion) {
    let robot = Robot::parse(OP2_URDF, "op2.urdf").unwrap();
    let model = robot.model("r_sole", Snapping::default(), None).unwrap();
    let mut simulator = Simulator::new(&model.tree.dofs, Some(0.5), 1);
    let q = simulator.batch(1_000_000);
    let q: &[[f64; DOF]] = q.as_chunks().0;
    let mut reading = |x: f64| x + simulator.gauss(1e-3);
    let cop: Vec<[f64; 2]> = q
        .iter()
        .map(|q| op2::cop(q, &CAD_PARAMS).map(&mut reading))
        .collect();
    let start = Estimator::with_nominal(&CAD_PARAMS).unwrap();
    let fit = |simd, q: &[[f64; DOF]], cop: &[[f64; 2]]| {
        start.batch::<op2::Op2RSole>(simd, black_box(q), cop, &[1e-3; 2])
    };
    for count in [1_000, 100_000, 1_000_000] {
        let (q, cop) = (&q[..count], &cop[..count]);
        let mut group = c.benchmark_group(format!("op2/fit of {count} postures"));
        group
            .throughput(Throughput::Elements(count as u64))
            .sample_size(10)
            .warm_up_time(Duration::from_millis(100))
            .measurement_time(Duration::from_secs(2));
        for simd in Simd::available() {
            group.bench_function(simd.name(), |b| b.iter(|| fit(simd, q, cop).unwrap()));
        }
        group.bench_function("two threads", |b| {
            let half = count / 2;
            b.iter(|| {
                let (first, second) = rayon::join(
                    || fit(Simd::best(), &q[..half], &cop[..half]),
                    || fit(Simd::best(), &q[half..], &cop[half..]),
                );
                let mut whole = first.unwrap();
                whole.merge(&second.unwrap()).unwrap();
                whole.params()
            });
        });
        group.finish();
    }
}

criterion_group!(benches, op2_fit, many);
criterion_main!(benches);
