//! Noise, repeats and what is seen, on a small robot, judged by closed forms.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, Vector2};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Normal};
use sesc_model::Snapping;

use super::gather::Gathered;
use super::prior::Prior;
use super::{Identification, Settings, identify};
use crate::logs::Block;
use crate::lsq::solve::solve;
use crate::observations::grouping::Grouping;
use crate::observations::noise::NoiseSource;
use crate::observations::rows::Measurement;
use crate::robot::Robot;
use crate::tests::{SKEW, says};
const RANK: usize = 6;

/// Any numbers, the same every time.
fn posture(k: usize) -> [f64; 2] {
    [1.3, 2.1].map(|step| 1.5 * (step * k as f64 + 0.4).sin())
}

struct Skew {
    robot: Robot,
    /// Not CAD's, m.
    truth: DVector<f64>,
}

impl Skew {
    fn new() -> Skew {
        let robot = Robot::parse(SKEW, "skew.urdf").unwrap();
        let model = robot.model("foot", Snapping::default(), None).unwrap();
        let truth = DVector::from_vec(model.cad_params());
        let truth = truth.map_with_location(|k, _, cad| cad + 0.01 * (k as f64).cos());
        Skew { robot, truth }
    }

    fn measurement(&self) -> Measurement<'_> {
        Measurement::new(&self.robot, "foot", Snapping::default()).unwrap()
    }

    /// Readings of poses whose joints are `at`, each with its own deviation, m.
    fn log(&self, poses: &[(i64, [f64; 2])], std: &[f64], rng: &mut ChaCha8Rng) -> Block {
        let mut block = Block {
            line: (2..).take(poses.len()).collect(),
            pose: poses.iter().map(|(pose, _)| *pose).collect(),
            q: poses.iter().flat_map(|(_, q)| *q).collect(),
            ..Block::default()
        };
        let rows = self.measurement().rows(&block).unwrap();
        let cop = rows.matrix.times(&self.truth);
        let normal = Normal::new(0.0, 1.0).unwrap();
        let mut noisy = |k: usize, axis: usize| cop[2 * k + axis] + std[k] * normal.sample(rng);
        let reading = (0..poses.len()).map(|k| [noisy(k, 0), noisy(k, 1)]);
        block.reading = Some(reading.collect());
        block
    }

    fn gather(&self, blocks: &[&Block]) -> Gathered {
        let mut measurement = self.measurement();
        let mut gathered = Gathered::new(self.truth.len(), 4);
        for block in blocks {
            let pushed = gathered.push(&mut measurement, block, "log.csv", None);
            pushed.unwrap();
        }
        gathered
    }

    fn identify(&self, gathered: &Gathered) -> Identification {
        let settings = Settings::new(Prior::Free);
        identify(self.measurement().model(), &["foot"], gathered, &settings)
    }
}

/// These rows of a block, in this order.
fn chosen(block: &Block, rows: &[usize]) -> Block {
    let reading = block.reading.as_ref().unwrap();
    let q = |k: &usize| [block.q[2 * k], block.q[2 * k + 1]];
    Block {
        line: rows.iter().map(|&k| block.line[k]).collect(),
        pose: rows.iter().map(|&k| block.pose[k]).collect(),
        q: rows.iter().flat_map(q).collect(),
        reading: Some(rows.iter().map(|&k| reading[k]).collect()),
        ..Block::default()
    }
}

/// Three rounds through six postures: RSS = SS_pe + Σ n ‖ȳ − φ r̂‖², the fit being
/// that of the means.
#[test]
fn poses_that_come_back_are_repeats() {
    const POSES: usize = 6;
    const ROUNDS: usize = 3;
    let skew = Skew::new();
    let visit = |k: usize| ((k % POSES) as i64, posture(k % POSES));
    let poses: Vec<_> = (0..ROUNDS * POSES).map(visit).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let block = skew.log(&poses, &[0.002; ROUNDS * POSES], &mut rng);
    let gathered = skew.gather(&[&block]);
    let found = skew.identify(&gathered);

    let mut groups: BTreeMap<i64, Vec<Vector2<f64>>> = BTreeMap::new();
    for (pose, reading) in block.pose.iter().zip(block.reading.as_ref().unwrap()) {
        groups.entry(*pose).or_default().push((*reading).into());
    }
    let mean = |all: &Vec<Vector2<f64>>| all.iter().sum::<Vector2<f64>>() / all.len() as f64;
    let means: Vec<Vector2<f64>> = groups.values().map(mean).collect();
    let pairs = groups.values().zip(&means);
    let pure = pairs.flat_map(|(all, mean)| all.iter().map(move |y| (y - mean).norm_squared()));
    let pure: f64 = pure.sum();
    let first = chosen(&block, &(0..POSES).collect::<Vec<_>>());
    let rows = skew.measurement().rows(&first).unwrap().matrix.dense();
    let means = DVector::from_iterator(2 * POSES, means.iter().flat_map(|m| [m.x, m.y]));
    let fit = rows.clone().svd(true, true).solve(&means, 1e-9).unwrap();
    let lack = ROUNDS as f64 * (rows * fit - means).norm_squared();

    assert_eq!((found.rank, found.postures, found.readings), (RANK, 6, 18));
    assert!((gathered.repeats.pure().both().0 - pure).abs() < 1e-12 * pure);
    let test = found.lack_of_fit.unwrap();
    let [df, df_pure] = [2 * POSES - RANK, 2 * POSES * (ROUNDS - 1)].map(|df| df as f64);
    assert_eq!((test.df, test.df_noise), (df, Some(df_pure)));
    let ratio = (lack / df) / (pure / df_pure);
    assert!((test.ratio - ratio).abs() < 1e-9 * ratio);
    // What the model leaves is no part of the noise, though it is of one size.
    assert_eq!(found.noise_source, NoiseSource::Repeats);
    assert_eq!(found.noise_df, Some(df_pure));
    assert!((found.noise_floor - (pure / df_pure).sqrt()).abs() < 1e-12);

    // In the order of poses, or cut in two, they tell the same.
    let mut order: Vec<usize> = (0..block.len()).collect();
    order.sort_by_key(|&k| block.pose[k]);
    let of_sorted = skew.gather(&[&chosen(&block, &order)]).repeats;
    assert!((of_sorted.pure().both().0 - pure).abs() < 1e-12 * pure);
    assert_eq!((of_sorted.pure().both().1, of_sorted.postures), (24, 6));
    let [early, late] = [0..7, 7..18].map(|rows| chosen(&block, &rows.collect::<Vec<_>>()));
    let cut = skew.gather(&[&early, &late]);
    assert_eq!(cut.repeats, gathered.repeats);
    // Repeats keep together in their fold.
    let rows = |gathered: &Gathered| -> Vec<u64> {
        let folds = gathered.folds.iter();
        folds.map(|fold| fold.weighted.rows()).collect()
    };
    assert_eq!(rows(&cut), rows(&gathered));
    assert!(rows(&gathered).iter().all(|rows| rows % 6 == 0));
}

/// Poses numbered anew for other postures are none that come back.
#[test]
fn other_postures_of_one_number_are_others() {
    let skew = Skew::new();
    let again = |k: usize| ((k % 10) as i64, posture(k));
    let poses: Vec<_> = (0..20).map(again).collect();
    let block = skew.log(&poses, &[0.002; 20], &mut ChaCha8Rng::seed_from_u64(2));
    let gathered = skew.gather(&[&block]);
    let repeats = &gathered.repeats;
    assert_eq!((repeats.pure().both().1, repeats.postures), (0, 20));
    assert_eq!(gathered.moved, 10);
    let words = "10 rows share the `pose` of an earlier row";
    says(skew.identify(&gathered).warnings.join("\n"), &[words]);
}

#[test]
fn more_postures_than_can_be_known_are_said() {
    let skew = Skew::new();
    let poses: Vec<_> = (0..12).map(|k| ((k % 6) as i64, posture(k % 6))).collect();
    let block = skew.log(&poses, &[0.002; 12], &mut ChaCha8Rng::seed_from_u64(3));
    let mut measurement = skew.measurement();
    let mut gathered = Gathered::new(skew.truth.len(), 4);
    gathered.postures = Grouping::up_to(4);
    let pushed = gathered.push(&mut measurement, &block, "log.csv", None);
    pushed.unwrap();
    let ended = gathered.end_log(&mut measurement, 0);
    ended.unwrap();
    // Four come back; two are met twice as if they were others.
    let repeats = &gathered.repeats;
    assert_eq!((repeats.pure().both().1, repeats.postures), (8, 8));
    let words = "more than 200000 postures in a log";
    says(skew.identify(&gathered).warnings.join("\n"), &[words]);
}

/// Share of 95 % intervals that hold the truth, of 500 logs.
fn coverage(poses: &[(i64, [f64; 2])]) -> (f64, Identification) {
    let skew = Skew::new();
    let std = vec![0.002; poses.len()];
    let (mut inside, mut all, mut last) = (0, 0, None);
    for seed in 0..500 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let found = skew.identify(&skew.gather(&[&skew.log(poses, &std, &mut rng)]));
        for (parameter, truth) in found.parameters.iter().zip(&skew.truth) {
            if let Some(std) = parameter.std {
                all += 1;
                inside += u32::from((parameter.value - truth).abs() < 1.96 * std);
            }
        }
        last = Some(found);
    }
    assert_eq!(all, 500 * RANK);
    (f64::from(inside) / all as f64, last.unwrap())
}

/// Twelve degrees of freedom and no more: three postures, which settle six directions, three times
/// each; normal intervals of such a noise hold 92.6 %. Then twelve of repeats beside many residuals,
/// which are no part of the noise.
#[test]
fn intervals_are_honest_when_few_repeats_tell_the_noise() {
    let of = |rows: usize, poses: usize| {
        let visit = |k: usize| ((k % poses) as i64, posture(k % poses));
        let (share, found) = coverage(&(0..rows).map(visit).collect::<Vec<_>>());
        assert!((0.93..=0.97).contains(&share), "{rows}: {share}");
        found
    };
    let found = of(9, 3);
    assert_eq!((found.rank, found.noise_df), (RANK, Some(12.0)));
    assert_eq!(found.noise_source, NoiseSource::Repeats);
    let found = of(26, 20);
    assert_eq!(found.lack_of_fit.unwrap().df_noise, Some(12.0));
    assert_eq!(found.noise_df, Some(12.0));
}

/// A knee that hardly moves is seen at 1e-4 of the rest: a row that is said to be
/// 1e7 times better than all others hides it only where rank is cut on weights.
#[test]
fn a_row_said_to_be_exact_hides_no_other() {
    let skew = Skew::new();
    let still = |k: usize| (k as i64, [posture(k)[0], 1e-4 * posture(k)[1]]);
    let poses: Vec<_> = (0..30).map(still).collect();
    let mut std = vec![0.01; 30];
    std[11] = 1e-300;
    let mut block = skew.log(&poses, &std, &mut ChaCha8Rng::seed_from_u64(4));
    block.std = Some(std.iter().map(|s| [*s; 2]).collect());
    let gathered = skew.gather(&[&block]);
    let weighted = gathered.together().weighted;
    assert!(solve(&weighted, 1.0, &skew.truth, None).rank < RANK);
    let found = skew.identify(&gathered);
    assert_eq!(found.rank, RANK);
    let words = "1 rows state deviations below 1e-9 m";
    says(found.warnings.join("\n"), &[words]);
    for (parameter, truth) in found.parameters.iter().zip(&skew.truth) {
        if let Some(std) = parameter.std {
            assert!(std.is_finite() && (parameter.value - truth).abs() < 4.0 * std + 1e-6);
        }
    }
    // Without that row it is what stated deviations of one size give.
    block.std = None;
    let plain = skew.identify(&skew.gather(&[&block]));
    assert_eq!(plain.rank, RANK);
    assert!((plain.condition_number / found.condition_number - 1.0).abs() < 1e-9);
    let blind = |found: &Identification| -> DMatrix<f64> { found.estimate.unseen.clone() };
    assert!((blind(&plain).tr_mul(&blind(&found))[(0, 0)].abs() - 1.0).abs() < 1e-9);
}
