//! Fits of logs whose noise lasts unlike on x and y, judged by the truth.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::DMatrix;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use sesc_model::Snapping;

use super::{Request, fit};
use crate::logs::{Block, Table};
use crate::observations::motion_use::MotionModel;
use crate::observations::rows::Measurement;
use crate::robot::Robot;
use crate::tests::SKEW;

/// AR(1) noise of deviation `std` (m) that lasts `tau` seconds, in rows `step` seconds apart.
fn lasting(rows: usize, step: f64, (std, tau): (f64, f64), rng: &mut ChaCha8Rng) -> Vec<f64> {
    let rho = (-step / tau).exp();
    let mut draw = || -> f64 { StandardNormal.sample(rng) };
    let mut e = draw();
    let all = (0..rows).map(|_| {
        e = rho * e + (1.0 - rho * rho).sqrt() * draw();
        std * e
    });
    all.collect()
}

/// Deviations of parameters by least squares of rows `x` (x and y of each posture in turn), whose
/// axes have AR(1) noise of `noise`, once that is taken from them; `None` of what is not seen.
fn deviations(x: &DMatrix<f64>, step: f64, noise: [(f64, f64); 2]) -> Vec<Option<f64>> {
    let white = DMatrix::from_fn(x.nrows(), x.ncols(), |row, column| {
        let (std, tau) = noise[row % 2];
        let rho = (-step / tau).exp();
        let own = x[(row, column)] / std;
        match row {
            0 | 1 => own,
            _ => (own - rho * x[(row - 2, column)] / std) / (1.0 - rho * rho).sqrt(),
        }
    });
    let parts = (white.transpose() * white).symmetric_eigen();
    let least = 1e-9 * parts.eigenvalues.max();
    let of = |k: usize| {
        let own = parts.eigenvectors.row(k);
        let pairs = parts.eigenvalues.iter().zip(own.iter());
        let pairs = pairs.map(|(value, part)| (value, part * part));
        let mut all = pairs.clone();
        let unseen = all.any(|(value, part)| *value < least && part > 1e-9);
        let seen = pairs.filter(|(value, _)| **value >= least);
        let variance: f64 = seen.map(|(value, part)| part / value).sum();
        (!unseen).then_some(variance.sqrt())
    };
    (0..x.ncols()).map(of).collect()
}

/// A minute of two slow sines a joint, whose CoP has noise of 1 mm for 0.1 s on x, and of 4 mm for
/// 1 s on y, of which one number is stated. Parameters of 60 fits are as near to the truth as those of
/// generalised least squares with the noise itself, and are said to be.
#[test]
fn each_axis_counts_by_its_own_noise_where_that_lasts() {
    const STEP: f64 = 0.04;
    const NOISE: [(f64, f64); 2] = [(1e-3, 0.1), (4e-3, 1.0)];
    let robot = Arc::new(Robot::parse(SKEW, "skew.urdf").unwrap());
    let truth = robot.model("foot", Snapping::default(), None).unwrap();
    let truth = truth.cad_params();
    let t: Vec<f64> = (0..1500).map(|k| f64::from(k) * STEP).collect();
    let swing = |[a, b]: [f64; 2]| -> Vec<f64> {
        let at = |t: &f64| 0.4 * (TAU * a * t).sin() + 0.4 * (TAU * b * t + 1.0).sin();
        t.iter().map(at).collect()
    };
    let joints = [swing([0.11, 0.17]), swing([0.13, 0.23])];
    let block = Block {
        line: (2..).take(t.len()).collect(),
        pose: (0..).take(t.len()).collect(),
        q: DMatrix::from_fn(2, t.len(), |j, k| joints[j][k])
            .as_slice()
            .into(),
        ..Block::default()
    };
    let mut measurement = Measurement::new(&robot, "foot", Snapping::default()).unwrap();
    let rows = measurement.rows(&block).unwrap().matrix;
    let cop = rows.times(&truth.clone().into());
    let expected = deviations(&rows.dense(), STEP, NOISE);
    // Squares of errors, and of stated deviations, over those expected.
    let mut sums = vec![[0.0; 2]; truth.len()];
    const FITS: u64 = 60;
    for seed in 0..FITS {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let noise = NOISE.map(|own| lasting(t.len(), STEP, own, &mut rng));
        let axis = |axis: usize| -> Vec<f64> {
            let rows = noise[axis].iter().enumerate();
            rows.map(|(k, e)| cop[2 * k + axis] + e).collect()
        };
        let log = Table::new("log")
            .numbers("t", t.clone())
            .numbers("cop_x", axis(0))
            .numbers("cop_y", axis(1))
            .numbers("hip", joints[0].clone())
            .numbers("knee", joints[1].clone());
        let request = Request {
            robot: Some(Arc::clone(&robot)),
            logs: vec![log.into()],
            support: Some("foot".into()),
            noise: Some(8.5_f64.sqrt() * 1e-3),
            motion: MotionModel::Off,
            prior: "free".into(),
            ..Request::default()
        };
        let found = fit(&request, &mut ()).unwrap().identification;
        for (k, (parameter, truth)) in found.parameters.iter().zip(&truth).enumerate() {
            let is_seen = parameter.std.is_some();
            assert_eq!(is_seen, expected[k].is_some(), "{}", parameter.name);
            if let (Some(std), Some(expected)) = (parameter.std, expected[k]) {
                sums[k][0] += ((parameter.value - truth) / expected).powi(2);
                sums[k][1] += (std / expected).powi(2);
            }
        }
    }
    let seen = sums
        .iter()
        .zip(&expected)
        .filter(|(_, known)| known.is_some());
    let seen = seen.map(|(sums, _)| sums.map(|sum| (sum / FITS as f64).sqrt()));
    let seen: Vec<[f64; 2]> = seen.collect();
    assert_eq!(seen.len(), 6);
    for [off, said] in seen {
        // An RMS of 60 is known to 9 %.
        assert!(off < 1.3 && (0.8..1.25).contains(&said), "{off} {said}");
    }
}
