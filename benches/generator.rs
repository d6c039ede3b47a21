//! What generating costs: every function of a robot, URDF text to Rust text;
//! and CoM and Jacobian programs of random trees with 100, 500, 1000 joints,
//! which grow about linearly. (A base row has an entry per parameter and each
//! body's orientation is built from its parent's, so rows are linear too; only
//! their products, as in a normal matrix, are quadratic by nature.)

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use sesc_codegen::emit::rust;
use sesc_codegen::facts::Facts;
use sesc_identify::robot::Robot;
use sesc_model::{Function, Given, Model, Snapping};
use sesc_test_support::trees::{Kind, tree};

fn everything(text: &str, support: &str) -> String {
    let robot = Robot::parse(text, "robot.urdf").unwrap();
    let model = robot.model(support, Snapping::default(), None).unwrap();
    rust::module(&Facts::of(&model), "robot").unwrap()
}

fn whole_robots(c: &mut Criterion) {
    let mut group = c.benchmark_group("generate all functions");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(2));
    for (robot, support) in [("op2", "r_sole"), ("plain_humanoid", "right_sole")] {
        let path = format!("{}/robots/{robot}/{robot}.urdf", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).unwrap();
        group.bench_function(robot, |b| b.iter(|| black_box(everything(&text, support))));
    }
    group.finish();
}

fn growth(c: &mut Criterion) {
    let mut group = c.benchmark_group("CoM and Jacobian of random trees");
    group
        .sample_size(10)
        .measurement_time(Duration::from_secs(2));
    for joints in [100, 500, 1000] {
        let kind = Kind {
            joints,
            canonical: false,
            revolute: true,
            chained: 0.8,
        };
        let (text, links) = tree(joints as u64, kind);
        let robot = Robot::parse(&text, "random.urdf").unwrap();
        let model = robot.model(&links[0], Snapping::default(), None).unwrap();
        report_size(joints, &model);
        group.throughput(Throughput::Elements(joints as u64));
        group.bench_with_input(BenchmarkId::from_parameter(joints), &model, |b, model| {
            b.iter(|| {
                black_box(model.program(Function::Com, Given::Positions));
                black_box(model.program(Function::ComJacobian, Given::Positions));
            });
        });
    }
    group.finish();
}

fn report_size(joints: usize, model: &Model) {
    for function in [Function::Com, Function::ComJacobian, Function::RegressorCop] {
        let counts = model
            .program(function, Given::Positions)
            .map(|p| p.counts());
        eprintln!("{joints} joints, {}: {counts:?}", function.name());
    }
}

criterion_group!(benches, whole_robots, growth);
criterion_main!(benches);
