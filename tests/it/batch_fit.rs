//! Many postures at once against one after the other, on the OP2 on its right sole, on
//! every set of instructions that this machine has.

use nalgebra::{DMatrix, DVector};
use sesc_generated::op2_r_sole::{self as op2, BASE_PARAMS as N, CAD_PARAMS, DOF, Op2RSole};
use sesc_runtime::Simd;
use sesc_runtime::fit::{Error, Estimator};

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

const STD: [f64; 2] = [1e-3, 2e-3];
type Postures = (Vec<[f64; DOF]>, Vec<[f64; 2]>);

/// A robot that is not its CAD.
fn truth() -> [f64; N] {
    core::array::from_fn(|k| CAD_PARAMS[k] + 0.01 * (k as f64).sin())
}

/// Postures within `range` of `middle`, rad, and readings with `noise`, m.
fn data(count: usize, middle: f64, range: f64, noise: f64) -> Postures {
    let mut rng = ChaCha8Rng::seed_from_u64(count as u64);
    let mut within = |size: f64| size * (2.0 * rng.random::<f64>() - 1.0);
    let mut posture = || core::array::from_fn(|_| middle + within(range));
    let q: Vec<[f64; DOF]> = (0..count).map(|_| posture()).collect();
    let mut reading = |q| op2::cop(q, &truth()).map(|x| x + within(noise));
    let cop = q.iter().map(&mut reading).collect();
    (q, cop)
}

fn batch(start: &Estimator<f64, N>, simd: Simd, (q, cop): &Postures) -> Estimator<f64, N> {
    start.batch::<Op2RSole>(simd, q, cop, &STD).unwrap()
}

/// Those from one on, up to another.
fn part((q, cop): &Postures, rows: std::ops::Range<usize>) -> Postures {
    (q[rows.clone()].to_vec(), cop[rows].to_vec())
}

fn in_turn(start: &Estimator<f64, N>, (q, cop): &Postures) -> Estimator<f64, N> {
    let mut estimator = start.clone();
    for (q, cop) in q.iter().zip(cop) {
        let rows = op2::regressor_cop(q);
        estimator.posture(&rows, cop, &STD).unwrap();
    }
    estimator
}

fn worst(a: &[f64; N], b: &[f64; N]) -> f64 {
    let off = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    off.fold(0.0, f64::max)
}

/// Householder on the weighted rows: no product of rows anywhere.
fn householder((q, cop): &Postures) -> [f64; N] {
    let rows: Vec<[f64; N]> = q.iter().flat_map(op2::regressor_cop).collect();
    let weight = |i: usize| 1.0 / STD[i % 2];
    // The column of the height is not observable.
    let observable: Vec<usize> = (0..N).filter(|k| *k != 2).collect();
    let matrix = DMatrix::from_fn(rows.len(), observable.len(), |i, k| {
        weight(i) * rows[i][observable[k]]
    });
    let off = DVector::from_fn(rows.len(), |i, _| {
        let nominal: f64 = rows[i].iter().zip(&CAD_PARAMS).map(|(y, r)| y * r).sum();
        weight(i) * (cop[i / 2][i % 2] - nominal)
    });
    let (orthogonal, triangle) = matrix.qr().unpack();
    let change = triangle.solve_upper_triangular(&orthogonal.tr_mul(&off));
    let change = change.unwrap();
    let mut params = CAD_PARAMS;
    for (k, change) in observable.into_iter().zip(change.iter()) {
        params[k] += change;
    }
    params
}

#[test]
fn it_is_what_postures_in_turn_give() {
    let start = Estimator::with_nominal(&CAD_PARAMS).unwrap();
    let believed = Estimator::with_prior(&CAD_PARAMS, &[0.01; N]).unwrap();
    // Not a multiple of a block, of a panel, nor of anything.
    for count in [3, 8, 43, 64, 1003] {
        let data = data(count, 0.0, 0.5, 1e-3);
        for start in [&start, &believed] {
            let turn = in_turn(start, &data);
            for simd in Simd::available() {
                let batch = batch(start, simd, &data);
                let what = format!("{count} on {}", simd.name());
                assert_eq!(batch.rank(), turn.rank(), "{what}");
                assert_eq!(batch.postures(), count as u64, "{what}");
                let off = worst(&batch.params(), &turn.params());
                // Few postures leave directions that are barely observable.
                let within = if count > 64 { 1e-12 } else { 1e-9 };
                assert!(off < within, "{what}: {off:e}");
                let (mut mine, mut theirs) = ([[0.0; N]; N], [[0.0; N]; N]);
                batch.covariance(&mut mine);
                turn.covariance(&mut theirs);
                for (mine, theirs) in mine.as_flattened().iter().zip(theirs.as_flattened()) {
                    let within = (mine - theirs).abs() < 1e-6 * (1e-6 + theirs.abs());
                    assert!(mine == theirs || within, "{what}");
                }
                assert_eq!(batch.degrees_of_freedom(), turn.degrees_of_freedom());
                let [mine, theirs] = [&batch, &turn].map(Estimator::residual_sum_of_squares);
                let within = 1e-9 * theirs + 1e-12;
                assert!((mine - theirs).abs() < within, "{what}: {mine} {theirs}");
            }
        }
    }
}

/// Noise-free readings have one answer, known without any fit.
#[test]
fn it_finds_the_truth_to_the_last_digits() {
    let data = data(20_000, 0.0, 0.5, 0.0);
    let mut expected = truth();
    expected[2] = CAD_PARAMS[2];
    for simd in Simd::available() {
        let start = Estimator::with_nominal(&CAD_PARAMS).unwrap();
        let found = batch(&start, simd, &data);
        let off = worst(&found.params(), &expected);
        println!("{}: {off:.1e} m", simd.name());
        assert!(off < 2e-15, "{off:e}");
    }
}

/// Joints that hardly move: the refinement has to make up for the square of the condition
/// number, and where it cannot, rows are rotated.
#[test]
fn narrow_postures_cost_no_digits() {
    for (range, within) in [(0.1, 1e-12), (0.02, 1e-10), (0.003, 1e-8_f64)] {
        let data = data(4_000, 0.3, range, 1e-6);
        let exact = householder(&data);
        for simd in Simd::available() {
            let start = Estimator::with_nominal(&CAD_PARAMS).unwrap();
            let found = batch(&start, simd, &data);
            let off = worst(&found.params(), &exact);
            let turn = worst(&in_turn(&start, &data).params(), &exact);
            let name = simd.name();
            println!("±{range} on {name}: {off:.1e} m, in turn {turn:.1e} m");
            assert!(off < within.max(20.0 * turn), "±{range}: {off:e}");
        }
    }
}

#[test]
fn shares_merge_into_the_whole() {
    let data = data(4_000, 0.0, 0.5, 1e-3);
    let start = Estimator::with_nominal(&CAD_PARAMS).unwrap();
    let whole = batch(&start, Simd::best(), &data);
    let mut first = batch(&start, Simd::best(), &part(&data, 0..1500));
    let second = batch(&start, Simd::best(), &part(&data, 1500..4_000));
    first.merge(&second).unwrap();
    assert_eq!(first.postures(), 4_000);
    assert!(worst(&first.params(), &whole.params()) < 1e-12);
    // What is known already counts.
    let more = part(&data, 0..800);
    let (other, turn) = (batch(&first, Simd::best(), &more), in_turn(&first, &more));
    assert!(worst(&other.params(), &turn.params()) < 1e-12);
}

#[test]
fn forgetting_feeds_in_turn() {
    let data = data(300, 0.0, 0.5, 1e-3);
    let start = Estimator::with_nominal(&CAD_PARAMS).unwrap();
    let start = start.forgetting(0.99).unwrap();
    let found = batch(&start, Simd::best(), &data);
    assert_eq!(found, in_turn(&start, &data));
}

#[test]
fn what_is_no_number_is_refused() {
    let start = Estimator::with_nominal(&CAD_PARAMS).unwrap();
    let (q, cop) = data(100, 0.0, 0.5, 1e-3);
    let fit = |q: &[[f64; DOF]], cop: &[[f64; 2]], std: [f64; 2]| {
        let found = start.batch::<Op2RSole>(Simd::best(), q, cop, &std);
        found.map(|found| found.postures())
    };
    assert_eq!(fit(&q, &cop, STD), Ok(100));
    let lengths = Error::Length {
        postures: 100,
        readings: 50,
    };
    assert_eq!(fit(&q, &cop[..50], STD), Err(lengths));
    assert_eq!(fit(&[], &[], STD), Ok(0));
    assert_eq!(fit(&q, &cop, [0.0, 1.0]), Err(Error::Std));
    assert_eq!(fit(&q, &cop, [1e-3, f64::NAN]), Err(Error::NotFinite));
    assert_eq!(fit(&q, &cop, [1e-40, 1.0]), Err(Error::OutOfRange));
    // In the whole blocks, and in the rest.
    for k in [17, 99] {
        let mut wrong = cop.clone();
        wrong[k][1] = f64::INFINITY;
        assert_eq!(fit(&q, &wrong, STD), Err(Error::NotFinite));
        let mut wrong = q.clone();
        wrong[k][DOF - 1] = f64::NAN;
        assert_eq!(fit(&wrong, &cop, STD), Err(Error::NotFinite));
        wrong[k][DOF - 1] = 1e9;
        assert_eq!(fit(&wrong, &cop, STD), Err(Error::NotFinite));
    }
}
