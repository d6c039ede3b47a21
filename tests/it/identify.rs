//! Identification on simulated logs of the OP2, judged by a truth that the
//! identification never touches: the reference with masses of its own.

use std::ops::Range;
use std::path::Path;

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Normal};
use sesc_identify::fit::Gathered;
use sesc_identify::fit::prior::Prior;
use sesc_identify::fit::{Identification, Settings, identify};
use sesc_identify::logs::Block;
use sesc_identify::lsq::{Factor, solve};
use sesc_identify::observations::Measurement;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::{Model, Snapping};
use sesc_reference::Reference;

/// CoP noise of the seed paper: one reading, and the mean of 100, m.
const NOISE: f64 = 0.00493;
const NOISE_OF_MEAN: f64 = 0.000493;
/// Largest |CoP| of the paper's experiment on each axis, m.
const STABLE: f64 = 0.023;

struct Op2 {
    robot: Robot,
    reference: Reference,
    /// Standard parameters of CAD, 4 per link.
    cad: DVector<f64>,
}

fn reference_on(robot: &Robot, support: &str) -> Reference {
    let model = robot.model(support, Snapping::default(), None).unwrap();
    sesc::verify::reference(robot, &model).unwrap()
}

impl Op2 {
    fn new() -> Op2 {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/op2/op2.urdf");
        let robot = Robot::read(&path).unwrap();
        let reference = reference_on(&robot, "r_sole");
        Op2 {
            cad: reference.standard_parameters(),
            robot,
            reference,
        }
    }

    fn model(&self, support: &str) -> Model {
        self.robot
            .model(support, Snapping::default(), None)
            .unwrap()
    }

    /// A robot as built: masses ± `mass`, CoMs ± `com` m, drawn.
    fn truth(&self, mass: f64, com: f64, rng: &mut ChaCha8Rng) -> DVector<f64> {
        let mut theta = self.cad.clone();
        for link in 0..theta.len() / 4 {
            let share = self.cad[4 * link];
            let heavier = 1.0 + mass * gauss(rng);
            for k in 0..4 {
                theta[4 * link + k] *= heavier;
            }
            for k in 1..4 {
                theta[4 * link + k] += share * heavier * com * gauss(rng);
            }
        }
        let total: f64 = theta.iter().step_by(4).sum();
        theta / total
    }

    fn cop(&self, theta: &DVector<f64>, q: &[f64]) -> [f64; 2] {
        let com = self.reference.com_of(q, theta.as_slice());
        [com.x, com.y]
    }

    /// Postures within ±30° and the limits, row by row.
    fn postures(&self, count: usize, seed: u64) -> Vec<f64> {
        let dofs = &self.model("r_sole").tree.dofs;
        Simulator::new(dofs, Some(30_f64.to_radians()), seed).batch(count)
    }

    /// Those of many postures whose CAD CoP stays in the box that does not tip.
    fn stable(&self, count: usize, seed: u64) -> Vec<f64> {
        let dof = self.reference.dof();
        let all = self.postures(60 * count, seed);
        let keep = |q: &&[f64]| self.cop(&self.cad, q).iter().all(|x| x.abs() < STABLE);
        let kept = all.chunks(dof).filter(keep).take(count);
        let kept = kept.collect::<Vec<_>>().concat();
        assert_eq!(kept.len(), count * dof, "enough stable postures");
        kept
    }

    fn log(&self, q: &[f64], theta: &DVector<f64>, noise: f64, rng: &mut ChaCha8Rng) -> Block {
        let dof = self.reference.dof();
        let reading = q.chunks(dof).map(|q| {
            let [x, y] = self.cop(theta, q);
            [x + noise * gauss(rng), y + noise * gauss(rng)]
        });
        let reading: Vec<[f64; 2]> = reading.collect();
        let n = reading.len();
        Block {
            line: (0..n as u64).map(|k| k + 2).collect(),
            pose: (0..n as i64).collect(),
            q: q.to_vec(),
            std: Some(vec![[noise; 2]; n]),
            reading: Some(reading),
            ..Block::default()
        }
    }

    fn measurement(&self, support: &str) -> Measurement<'_> {
        Measurement::new(&self.robot, support, Snapping::default()).unwrap()
    }

    /// What is gathered of these blocks.
    fn gathered(measurement: &mut Measurement, blocks: &[Block]) -> Gathered {
        let mut gathered = Gathered::new(measurement.model().base.params.len(), 10);
        for block in blocks {
            gathered.push(measurement, block, "log.csv", None).unwrap();
        }
        gathered
    }

    fn fit(&self, block: &Block, prior: &str) -> Identification {
        let mut measurement = self.measurement("r_sole");
        let gathered = Op2::gathered(&mut measurement, std::slice::from_ref(block));
        identified(&measurement, &gathered, prior)
    }

    /// A robot as built, and what draws the noise of its readings.
    fn built(&self, seed: u64) -> (DVector<f64>, ChaCha8Rng) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (self.truth(0.10, 0.005, &mut rng), rng)
    }

    /// Base parameters of a robot as built.
    fn params(&self, theta: &DVector<f64>) -> DVector<f64> {
        self.model("r_sole").standard_map() * theta
    }

    /// Errors of fits with no prior and with CAD's, mm: of robots as built, each with its seed and
    /// a log at `postures`.
    fn errors(
        &self,
        robots: u64,
        noise: f64,
        held_out: &[f64],
        postures: impl Fn(u64) -> Vec<f64>,
    ) -> [Vec<f64>; 2] {
        ["free", "cad"].map(|prior| {
            let error = |seed| {
                let (theta, mut rng) = self.built(seed);
                let block = self.log(&postures(seed), &theta, noise, &mut rng);
                let found = self.fit(&block, prior);
                assert_eq!(found.rank, 42);
                1e3 * self.clean_error(&found, &theta, held_out)
            };
            (0..robots).map(error).collect()
        })
    }

    /// RMS per axis of the fit's prediction against the noise-free truth, m.
    fn clean_error(&self, found: &Identification, theta: &DVector<f64>, q: &[f64]) -> f64 {
        let dof = self.reference.dof();
        let n = q.len() / dof;
        let block = Block {
            line: vec![0; n],
            pose: vec![0; n],
            q: q.to_vec(),
            reading: Some(q.chunks(dof).map(|q| self.cop(theta, q)).collect()),
            ..Block::default()
        };
        let rows = self.measurement("r_sole").rows(&block).unwrap();
        let error = rows.residual(&found.estimate.params);
        (error.norm_squared() / error.len() as f64).sqrt()
    }
}

fn gauss(rng: &mut ChaCha8Rng) -> f64 {
    Normal::new(0.0, 1.0).unwrap().sample(rng)
}

fn identified(measurement: &Measurement, gathered: &Gathered, prior: &str) -> Identification {
    let model = measurement.model();
    let settings = Settings::new(Prior::named(prior, model).unwrap());
    identify(model, &measurement.supports(), gathered, &settings)
}

/// Some rows of a block, and their stated deviation, m.
fn cut(block: &Block, rows: Range<usize>, std: f64) -> Block {
    Block {
        line: block.line[rows.clone()].to_vec(),
        pose: block.pose[rows.clone()].to_vec(),
        q: block.q[20 * rows.start..20 * rows.end].to_vec(),
        reading: block.reading.as_ref().map(|all| all[rows.clone()].to_vec()),
        std: Some(vec![[std; 2]; rows.len()]),
        ..Block::default()
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The paper's simulation: 1000 postures in ±30°, 4.93 mm. Theory without a
/// prior: σ √(rank / 2N) = 0.714 mm.
#[test]
fn thousand_postures_reach_the_theory_and_cad_betters_it() {
    let op2 = Op2::new();
    let held_out = op2.postures(2000, 99);
    let [free, cad] = op2.errors(20, NOISE, &held_out, |seed| op2.postures(1000, seed));
    println!("1000 postures, mm: free {free:.3?}, CAD prior {cad:.3?}");
    assert!((0.66..=0.74).contains(&mean(&free)), "{free:?}");
    assert!(mean(&cad) <= 0.52, "{cad:?}");
}

/// The paper's experiment: 38 stable postures, means of 100 readings.
#[test]
fn thirty_eight_stable_postures() {
    let op2 = Op2::new();
    let held_out = op2.stable(500, 98);
    let [free, cad] = op2.errors(12, NOISE_OF_MEAN, &held_out, |seed| op2.stable(38, seed));
    println!("38 postures, mm: free {free:.3?}, CAD prior {cad:.3?}");
    assert!(mean(&free) <= 0.60, "{free:?}");
    assert!(mean(&cad) <= 0.36, "{cad:?}");
}

/// 95 % intervals hold the truth in 93 to 97 % of 500 repeats, each with a robot
/// of its own, with and without a prior.
#[test]
fn deviations_are_honest() {
    let op2 = Op2::new();
    let model = op2.model("r_sole");
    let map = model.standard_map();
    let postures: Vec<Vec<f64>> = (0..20).map(|seed| op2.postures(60, seed)).collect();
    for prior in ["free", "cad"] {
        let prior_of = Prior::named(prior, &model).unwrap();
        let factor = prior_of.covariance_factor(&model);
        let cad = DVector::from_vec(model.cad_params());
        let mut measurement = op2.measurement("r_sole");
        let (mut inside, mut all) = (0, 0);
        for repeat in 0..500 {
            let (theta, mut rng) = op2.built(1000 + repeat);
            let q = &postures[repeat as usize % 20];
            let block = op2.log(q, &theta, NOISE_OF_MEAN, &mut rng);
            let rows = measurement.rows(&block).unwrap();
            let mut data = Factor::new(43);
            let weights = [1.0 / NOISE_OF_MEAN; 120];
            data.push(&rows.matrix.dense(), &rows.reading, &weights);
            let found = solve(&data, 1.0, &cad, factor.as_ref());
            let truth = &map * &theta;
            for k in 0..43 {
                let std = found.covariance[(k, k)].sqrt();
                // Rounding is no uncertainty: some entries are zero in every robot.
                let seen = found.unseen.row(k).norm() < 1e-6 || factor.is_some();
                if seen && std > 1e-12 {
                    all += 1;
                    inside += usize::from((found.params[k] - truth[k]).abs() < 1.96 * std);
                }
            }
        }
        let share = f64::from(inside as u32) / f64::from(all as u32);
        println!("{prior}: {share:.4} of {all} intervals hold the truth");
        assert!((0.93..=0.97).contains(&share), "{prior}: {share}");
    }
}

/// The k-fold error predicts the error on postures never seen.
#[test]
fn held_out_error_is_what_new_postures_show() {
    let op2 = Op2::new();
    let mut ratios = Vec::new();
    for seed in 0..10 {
        let (theta, mut rng) = op2.built(seed);
        let block = op2.log(&op2.postures(100, seed), &theta, NOISE_OF_MEAN, &mut rng);
        let found = op2.fit(&block, "free");
        let clean = op2.clean_error(&found, &theta, &op2.postures(1000, 77));
        // New readings carry noise of their own.
        ratios.push(found.held_out_rmse / clean.hypot(NOISE_OF_MEAN));
        assert!(found.in_sample_rmse < found.held_out_rmse);
    }
    println!("k-fold over new postures: {ratios:.3?}");
    assert!((0.9..1.15).contains(&mean(&ratios)), "{ratios:?}");
}

/// Standing on both feet tells the height; both logs speak of one vector.
#[test]
fn both_feet_tell_the_height() {
    let op2 = Op2::new();
    let (theta, mut rng) = op2.built(3);
    let left = reference_on(&op2.robot, "l_sole");
    let q = op2.postures(1000, 3);
    let mut block = op2.log(&q, &theta, NOISE_OF_MEAN, &mut rng);
    let readings = block.reading.as_mut().unwrap();
    let mut supports = vec!["r_sole".into(); 1000];
    for (k, q) in q.chunks(20).enumerate().filter(|(k, _)| k % 2 == 1) {
        let com = left.com_of(q, theta.as_slice());
        readings[k] = [com.x, com.y].map(|x| x + NOISE_OF_MEAN * gauss(&mut rng));
        supports[k] = "l_sole".into();
    }
    block.support = Some(supports);
    let found = op2.fit(&block, "free");
    println!("both feet: condition number {:.0}", found.condition_number);
    assert_eq!(found.rank, 43);
    assert!(found.condition_number < 60.0);
    let truth = op2.params(&theta);
    let height = &found.com_height_constant;
    assert_eq!(height.source, "data");
    assert!((height.value - truth[2]).abs() < 4.0 * height.std.unwrap());
    assert!(height.std.unwrap() < 0.0005);
    // One foot alone: rank 42, and worse conditioned.
    let one = op2.fit(&op2.log(&q, &theta, NOISE_OF_MEAN, &mut rng), "free");
    assert_eq!((one.rank, one.com_height_constant.source), (42, "cad"));
    assert!(one.condition_number > found.condition_number);
    // The other way round: parameters of the left root are the same after the shift.
    let mut measurement = op2.measurement("l_sole");
    let gathered = Op2::gathered(&mut measurement, &[block]);
    let there = identified(&measurement, &gathered, "free");
    let shift = op2.model("r_sole").params_from(measurement.model());
    let back = &shift.matrix * &there.estimate.params + &shift.offset;
    assert!((back - &found.estimate.params).amax() < 1e-10);
}

/// A known slope tells the height too: gravity per row.
#[test]
fn a_known_slope_tells_the_height() {
    let op2 = Op2::new();
    let (theta, mut rng) = op2.built(4);
    let q = op2.postures(400, 4);
    let mut block = op2.log(&q, &theta, 0.0, &mut rng);
    block.std = None;
    let mut gravity = Vec::new();
    let readings = block.reading.as_mut().unwrap();
    for (k, q) in q.chunks(20).enumerate() {
        let lean = 0.1 * (k % 3) as f64;
        let g = [9.81 * lean.sin(), 0.0, -9.81 * lean.cos()];
        let com = op2.reference.com_of(q, theta.as_slice());
        readings[k] = [com.x + lean.tan() * com.z, com.y];
        gravity.push(g);
    }
    block.gravity = Some(gravity);
    let found = op2.fit(&block, "free");
    assert_eq!(found.rank, 43);
    let truth = op2.params(&theta);
    assert!((&found.estimate.params - truth).amax() < 1e-11);
}

/// Parts of a log give the fit of the whole.
#[test]
fn parts_of_a_log_give_the_whole() {
    let op2 = Op2::new();
    let (theta, mut rng) = op2.built(5);
    let block = op2.log(&op2.postures(300, 5), &theta, NOISE, &mut rng);
    let whole = op2.fit(&block, "cad");
    let mut measurement = op2.measurement("r_sole");
    let mut parts = Gathered::new(43, 10);
    for rows in [0..100, 100..130, 130..300] {
        let part = Op2::gathered(&mut measurement, &[cut(&block, rows, NOISE)]);
        parts.merge(part).unwrap();
    }
    let merged = identified(&measurement, &parts, "cad");
    assert!((&merged.estimate.params - &whole.estimate.params).amax() < 1e-12);
    assert!((merged.held_out_rmse - whole.held_out_rmse).abs() < 1e-12);
    assert_eq!((merged.postures, merged.readings), (300, 300));
}

/// Sums of rows as they are and over their deviations are those of the reference's residuals,
/// while a log states one deviation and after it states others.
#[test]
fn sums_hold_where_stated_deviations_change() {
    let op2 = Op2::new();
    let (theta, mut rng) = op2.built(7);
    let q = op2.postures(300, 7);
    let block = op2.log(&q, &theta, NOISE, &mut rng);
    let params = op2.params(&theta);
    let readings = block.reading.as_ref().unwrap();
    let direct = |rows: &Range<usize>| -> f64 {
        let of = |k: usize| {
            let [x, y] = op2.cop(&theta, &q[20 * k..20 * (k + 1)]);
            (readings[k][0] - x).powi(2) + (readings[k][1] - y).powi(2)
        };
        rows.clone().map(of).sum()
    };
    let check = |gathered: &Gathered, parts: &[(Range<usize>, f64)]| {
        let plain: f64 = parts.iter().map(|(rows, _)| direct(rows)).sum();
        let weighted = parts.iter().map(|(rows, std)| direct(rows) / (std * std));
        let weighted: f64 = weighted.sum();
        let together = gathered.together();
        let found = together.plain().residual_sum(&params);
        assert!((found - plain).abs() < 1e-9 * plain, "{found} {plain}");
        let found = together.weighted.residual_sum(&params);
        assert!((found - weighted).abs() < 1e-9 * weighted);
    };
    let mut measurement = op2.measurement("r_sole");
    let mut gather = |parts: &[(Range<usize>, f64)]| {
        let blocks = parts
            .iter()
            .map(|(rows, std)| cut(&block, rows.clone(), *std));
        Op2::gathered(&mut measurement, &blocks.collect::<Vec<_>>())
    };
    let (fine, coarse) = (2e-4, 7e-4);
    let one = gather(&[(0..100, fine), (100..150, fine)]);
    assert!(one.folds.iter().all(|fold| fold.plain.is_none()));
    check(&one, &[(0..150, fine)]);
    let two = gather(&[(0..150, fine), (150..300, coarse)]);
    assert!(two.folds.iter().all(|fold| fold.plain.is_some()));
    check(&two, &[(0..150, fine), (150..300, coarse)]);
    let mut merged = one;
    merged.merge(gather(&[(150..300, coarse)])).unwrap();
    check(&merged, &[(0..150, fine), (150..300, coarse)]);
}

/// The prior's covariance is the spread of robots drawn from its tolerances.
#[test]
fn tolerances_carry_over_to_parameters() {
    let op2 = Op2::new();
    let model = op2.model("r_sole");
    let map = model.standard_map();
    let cad = DVector::from_vec(model.cad_params());
    let prior = Prior::named("cad", &model).unwrap();
    let factor = prior.covariance_factor(&model).unwrap();
    let stated = &factor * factor.transpose();
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let draws = 4000;
    let mut seen = DMatrix::zeros(43, 43);
    for _ in 0..draws {
        // First order: tolerances a tenth of the stated, scaled back.
        let away = &map * op2.truth(0.01, 0.0005, &mut rng) - &cad;
        seen += 100.0 * &away * away.transpose() / f64::from(draws);
    }
    for k in 0..43 {
        let (a, b) = (stated[(k, k)].sqrt(), seen[(k, k)].sqrt());
        let name = &model.base.params[k].name;
        assert!((a - b).abs() < 0.05 * a + 1e-6, "{name}: {a:.2e} {b:.2e}");
    }
    assert!((&stated - &seen).norm() < 0.1 * stated.norm());
}
