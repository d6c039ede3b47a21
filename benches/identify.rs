//! From logs to parameters on the OP2: rows, rows and factor, and whole fits of
//! 1,000 to 1,000,000 postures, from memory and from a Parquet file; nalgebra's
//! singular values and faer's QR on the same rows beside them.

use std::hint::black_box;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use faer::linalg::solvers::SolveLstsqCore as _;
use nalgebra::{DMatrix, DVector};
use sesc::OP2_URDF;
use sesc_identify::evaluate::Evaluator;
use sesc_identify::fit::Gathered;
use sesc_identify::fit::prior::Prior;
use sesc_identify::fit::{MotionModel, Request, Settings, identify};
use sesc_identify::logs::{Block, LogSource, PostureWriter, Row, Sidecar, Written};
use sesc_identify::lsq::Factor;
use sesc_identify::lsq::solve;
use sesc_identify::observations::Measurement;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::{Function, Model, Snapping};

const SUPPORT: &str = "r_sole";
const NOISE: f64 = 0.00493;
/// Postures of a block, as logs deliver them.
const BLOCK: usize = 4096;
/// The largest problem whose rows are also kept as one matrix.
const AT_ONCE: usize = 100_000;

/// Postures of ±30° with noisy readings, in blocks.
fn log(model: &Model, count: usize) -> Vec<Block> {
    let mut simulator = Simulator::new(&model.tree.dofs, Some(0.5), 1);
    let cop = Evaluator::new(model, Function::Cop);
    (0..count)
        .step_by(BLOCK)
        .map(|start| {
            let n = BLOCK.min(count - start);
            let q = simulator.batch(n);
            let readings = cop.run(&q, n);
            let mut noisy = |x: f64| x + simulator.gauss(NOISE);
            Block {
                line: (start as u64..(start + n) as u64).collect(),
                pose: (start as i64..(start + n) as i64).collect(),
                reading: Some(
                    readings
                        .chunks(2)
                        .map(|c| [noisy(c[0]), noisy(c[1])])
                        .collect(),
                ),
                q,
                ..Block::default()
            }
        })
        .collect()
}

fn settings() -> Settings {
    Settings::new(Prior::Free)
}

/// Everything `sesc fit` does after reading.
fn fit(robot: &Robot, log: &[Block]) -> f64 {
    let mut measurement = Measurement::new(robot, SUPPORT, Snapping::default()).unwrap();
    let mut gathered = Gathered::new(measurement.model().base.params.len(), 10);
    for block in log {
        gathered.push(&mut measurement, block, "log", None).unwrap();
    }
    identify(measurement.model(), &[SUPPORT], &gathered, &settings()).held_out_rmse
}

fn parquet(model: &Model, log: &[Block], count: usize) -> PathBuf {
    let path = std::env::temp_dir().join(format!("sesc-bench-{count}.parquet"));
    let columns = Written {
        cop: true,
        ..Written::default()
    };
    let mut writer = PostureWriter::create(&path, &model.tree.dofs, columns).unwrap();
    for block in log {
        let readings = block.reading.as_ref().unwrap();
        for (k, q) in block.q.chunks(model.dof()).enumerate() {
            let row = Row {
                pose: block.pose[k],
                q,
                cop: readings[k],
                ..Row::default()
            };
            writer.row(&row).unwrap();
        }
    }
    let sidecar = Sidecar {
        support: Some(SUPPORT.into()),
        ..Sidecar::default()
    };
    writer.finish(&sidecar).unwrap();
    path
}

fn from_file(robot: &Arc<Robot>, path: PathBuf) -> f64 {
    let mut request = Request::default();
    request.robot = Some(Arc::clone(robot));
    request.logs = vec![LogSource::from(path)];
    request.prior = Prior::Free.into();
    request.motion = MotionModel::Off;
    sesc_identify::fit::fit(&request, &mut ())
        .unwrap()
        .identification
        .held_out_rmse
}

/// All rows as one matrix.
fn stacked(robot: &Robot, log: &[Block]) -> (DMatrix<f64>, DVector<f64>) {
    let mut measurement = Measurement::new(robot, SUPPORT, Snapping::default()).unwrap();
    let blocks: Vec<_> = log
        .iter()
        .map(|block| measurement.rows(block).unwrap())
        .collect();
    let n: usize = blocks.iter().map(|rows| rows.reading.len()).sum();
    let mut matrix = DMatrix::zeros(n, blocks[0].matrix.columns);
    let mut reading = DVector::zeros(n);
    let mut at = 0;
    for rows in blocks {
        let len = rows.reading.len();
        matrix.rows_mut(at, len).copy_from(&rows.matrix.dense());
        reading.rows_mut(at, len).copy_from(&rows.reading);
        at += len;
    }
    (matrix, reading)
}

fn rows(c: &mut Criterion) {
    let robot = Robot::parse(OP2_URDF, "op2.urdf").unwrap();
    let mut measurement = Measurement::new(&robot, SUPPORT, Snapping::default()).unwrap();
    let block = &log(measurement.model(), BLOCK)[0];
    let mut group = c.benchmark_group("op2/identify");
    group.throughput(Throughput::Elements(BLOCK as u64));
    group.bench_function("rows", |b| {
        b.iter(|| measurement.rows(black_box(block)).unwrap())
    });
    group.bench_function("rows and factor", |b| {
        let mut factor = Factor::new(43);
        b.iter(|| {
            let rows = measurement.rows(black_box(block)).unwrap();
            let ones = (0..2 * BLOCK).map(|k| (k, 1.0));
            factor.push_rows(&rows.matrix, &rows.reading, ones);
        });
    });
    group.finish();
}

fn whole(c: &mut Criterion) {
    let robot = Arc::new(Robot::parse(OP2_URDF, "op2.urdf").unwrap());
    let model = robot.model(SUPPORT, Snapping::default(), None).unwrap();
    for count in [1_000, 100_000, 1_000_000] {
        let data = log(&model, count);
        let mut group = c.benchmark_group("op2/fit of all postures");
        group
            .sample_size(10)
            .warm_up_time(Duration::from_millis(100))
            .measurement_time(Duration::from_secs(5))
            .throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::new("from memory", count), |b| {
            b.iter(|| fit(&robot, black_box(&data)));
        });
        let path = parquet(&model, &data, count);
        group.bench_function(BenchmarkId::new("from Parquet", count), |b| {
            b.iter(|| from_file(&robot, path.clone()));
        });
        // Best effort: a file in the temporary folder.
        let _ = std::fs::remove_file(&path);
        let _ = std::fs::remove_file(path.with_extension("toml"));
        if count <= AT_ONCE {
            peers(&mut group, &robot, &data, count);
        }
        group.finish();
    }
}

/// The same least-squares problem by general libraries, rows given.
fn peers(
    group: &mut criterion::BenchmarkGroup<criterion::measurement::WallTime>,
    robot: &Robot,
    data: &[Block],
    count: usize,
) {
    let (matrix, reading) = stacked(robot, data);
    // Columns that flat CoP sees: QR without pivoting needs full rank.
    let seen: Vec<usize> = (0..43).filter(|k| *k != 2).collect();
    let seen = matrix.select_columns(&seen);
    group.bench_function(BenchmarkId::new("factor alone, rows given", count), |b| {
        let ones = vec![1.0; reading.len()];
        b.iter(|| {
            let mut factor = Factor::new(42);
            factor.push(black_box(&seen), &reading, &ones);
            solve(&factor, 1.0, &DVector::zeros(42), None).params
        });
    });
    group.bench_function(
        BenchmarkId::new("nalgebra QR and SVD, rows given", count),
        |b| {
            b.iter(|| {
                // Triangular factor first: the SVD then works on p × p.
                let (q, r) = black_box(seen.clone()).qr().unpack();
                let svd = r.svd(true, true);
                svd.solve(&q.tr_mul(&reading), 1e-10).unwrap()
            });
        },
    );
    let a = faer::Mat::from_fn(seen.nrows(), seen.ncols(), |i, j| seen[(i, j)]);
    let y = faer::Mat::from_fn(reading.len(), 1, |i, _| reading[i]);
    group.bench_function(BenchmarkId::new("faer QR, rows given", count), |b| {
        b.iter(|| {
            let mut x = y.clone();
            black_box(&a)
                .qr()
                .solve_lstsq_in_place_with_conj(faer::Conj::No, x.as_mut());
            x[(0, 0)]
        });
    });
}

criterion_group!(benches, rows, whole);
criterion_main!(benches);
