//! Deviations of what is found in noise that lasts, against the scatter of what is found.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use sesc_model::effects::Experiment;

use super::{Bench, NOISE, about, gauss, term, together, values};
use crate::diagnose::Verdict;
use crate::diagnose::samples::{explained, of_logs};
use crate::observations::correlation::{Correlation, Cut, Process};
use crate::observations::postures::Postures;

const ROWS: usize = 200;
const STEP_S: f64 = 0.1;
/// What noise lasts, s.
const TAU_S: f64 = 0.5;
const LOGS: u64 = 300;

/// Both joints swing at 0.7 Hz and about it, rad.
fn swing() -> Vec<f64> {
    let at = |k: usize| {
        let t = STEP_S * k as f64;
        [(4.4 * t).sin(), (3.7 * t + 1.0).sin()].map(|x| 0.4 * x)
    };
    (0..ROWS).flat_map(at).collect()
}

/// AR(1) noise of deviation NOISE on both axes: e_k = a e_{k−1} + √(1 − a²) w_k.
fn noise(seed: u64) -> Vec<f64> {
    let a = (-STEP_S / TAU_S).exp();
    let mut gauss = gauss(seed);
    let mut e = [gauss(), gauss()];
    let mut all = Vec::new();
    for _ in 0..ROWS {
        all.extend(e.map(|e| NOISE * e));
        e = e.map(|e| a * e + (1.0 - a * a).sqrt() * gauss());
    }
    all
}

/// Correlation of that noise on one axis, in closed form.
fn correlation() -> Correlation {
    let a = (-STEP_S / TAU_S).exp();
    let rows_per_sample = (1.0 + a) / (1.0 - a);
    Correlation {
        time_s: 0.5 * STEP_S * rows_per_sample,
        rows_per_sample,
        variance: 1.0,
        process: Some(Process {
            cut: Cut::new(1, STEP_S),
            tau_s: TAU_S,
            share: 1.0,
            lasting: 1.0,
        }),
    }
}

/// A log of some rows of the swing with such noise.
fn log(bench: &Bench, rows: Range<usize>, seed: u64) -> Postures {
    let q = &swing()[2 * rows.start..2 * rows.end];
    let world = bench.world();
    let clean = q.chunks_exact(2).flat_map(|q| world.cop(q));
    let reading: Vec<f64> = clean.zip(noise(seed)).map(|(x, e)| x + e).collect();
    let mut data = Postures::given(2, q, &reading, NOISE, 0.0);
    data.t = Some(rows.map(|k| STEP_S * k as f64).collect());
    data
}

/// What a gain and an offset are found to be in two logs together, in their deviations, has a
/// mean square of 1 as in one log, whichever of the two is the first.
#[test]
fn deviations_of_two_logs_are_those_of_noise_that_lasts() {
    let bench = Bench::skew();
    let mut squares = [0.0; 4];
    for seed in 0..LOGS {
        let cut = if seed % 2 == 0 { 60 } else { 140 };
        let of = |rows: Range<usize>, seed: u64| {
            let mut problem = bench.certain(log(&bench, rows, seed));
            problem.correlate_noise(0, [1.0; 2], &[correlation(); 2]);
            problem
        };
        let first = of(0..cut, 2 * seed);
        let second = of(cut..ROWS, 2 * seed + 1);
        let terms = ["sensor_gain", "sensor_offset"].map(|name| term(&first, name, "-"));
        let both = together(&first, &second, Experiment::Postures).fit(&terms, None);
        let found = values(&first, &both);
        for (k, (found, truth)) in found.iter().zip([1.0, 1.0, 0.0, 0.0]).enumerate() {
            squares[k] += ((found.value - truth) / found.std).powi(2) / LOGS as f64;
        }
    }
    for square in squares {
        // 1 ± 3 √(2/LOGS)
        assert!((square - 1.0).abs() < 0.25, "{squares:?}");
    }
}

/// Rows of every log are worth what its own noise lets them be.
#[test]
fn each_of_several_logs_is_worth_what_its_own_noise_says() {
    let bench = Bench::skew();
    let white = |rows: Range<usize>| {
        let mut data = log(&bench, rows, 0);
        let (mut gauss, world) = (gauss(1), bench.world());
        let clean = data.q.chunks_exact(2).flat_map(|q| world.cop(q));
        data.reading = clean.map(|x| x + NOISE * gauss()).collect();
        data
    };
    let first = bench.problem(white(0..ROWS), "tight");
    let second = bench.problem(log(&bench, 0..ROWS, 7), "tight");
    let both = together(&first, &second, Experiment::Postures);
    let (problem, found, each) = explained(both, &about(), &mut ()).unwrap();
    assert_eq!(found.diagnosis.verdict, Verdict::None);
    let [own, other] = &each[..] else {
        panic!("{each:?}")
    };
    let worth = |axes: &[Correlation; 2]| axes.map(|axis| axis.rows_per_sample);
    assert_eq!(worth(own), [1.0; 2]);
    // An estimate from 20 independent samples.
    let expected = correlation().rows_per_sample;
    for found in worth(other) {
        assert!((0.5..2.0).contains(&(found / expected)), "{found}");
    }
    let samples = of_logs(&problem, &each);
    assert_eq!(samples.rows, 2 * ROWS);
    let all = ROWS as f64 + ROWS as f64 / worth(other)[0].max(worth(other)[1]);
    assert_eq!(samples.independent, all.round() as usize);
}

/// Beside an offset, which is as slow as noise can be, a gain is seen by the swing alone: what is
/// found of both, in its deviations, has a mean square of 1 ± 0.08. Deviations of the gain as of
/// noise that is white over as many rows as are worth one are more than twice too large.
#[test]
fn deviations_are_those_of_noise_that_lasts() {
    let bench = Bench::skew();
    let correlation = correlation();
    let rows_per_sample = correlation.rows_per_sample;
    // Squares of gain x and y, then of offset x and y, in the deviations that are stated, and of
    // the gain in those of white noise.
    let (mut squares, mut as_white) = ([0.0; 4], 0.0);
    for seed in 0..LOGS {
        let mut problem = bench.certain(log(&bench, 0..ROWS, seed));
        let terms = ["sensor_gain", "sensor_offset"].map(|name| term(&problem, name, "-"));
        problem.correlate_noise(0, [1.0; 2], &[correlation; 2]);
        let found = values(&problem, &problem.fit(&terms, None));
        for (k, (found, truth)) in found.iter().zip([1.0, 1.0, 0.0, 0.0]).enumerate() {
            squares[k] += ((found.value - truth) / found.std).powi(2) / LOGS as f64;
        }
        let white = Correlation {
            process: None,
            ..correlation
        };
        problem.correlate_noise(0, [1.0; 2], &[white; 2]);
        // Readings are widened twice now: the deviation is √(rows per sample) times as large.
        let again = values(&problem, &problem.fit(&terms, None));
        let std = again[0].std / rows_per_sample.sqrt();
        as_white += ((again[0].value - 1.0) / std).powi(2) / LOGS as f64;
    }
    for square in squares {
        // 1 ± 3 √(2/LOGS)
        assert!((square - 1.0).abs() < 0.25, "{squares:?}");
    }
    assert!(as_white < 0.25, "{as_white}");
}

/// The same where how long the noise lasts is estimated from what the fit leaves, as a diagnosis
/// does it: 1.96 deviations of gains hold the truth in 95 %, with 20 independent samples an axis.
#[test]
fn intervals_hold_where_how_long_noise_lasts_is_estimated() {
    let bench = Bench::skew();
    let (mut all, mut hold) = (0, 0);
    for seed in 0..LOGS {
        let plain = bench.certain(log(&bench, 0..ROWS, seed));
        let t = plain.first().data.t.clone().unwrap();
        let terms = ["sensor_gain", "sensor_offset"].map(|name| term(&plain, name, "-"));
        let mut problem = plain.clone();
        let mut fit = problem.fit(&terms, None);
        for _ in 0..2 {
            let axes = [0, 1].map(|axis| {
                let whole =
                    |k: usize| problem.first().widened[axis] * fit.blocks[0].residual[2 * k + axis];
                let y = DVector::from_fn(ROWS, |k, _| whole(k));
                let x = DMatrix::from_fn(ROWS, 1 + fit.blocks[0].slopes.ncols(), |k, c| match c {
                    0 => 1.0,
                    c => {
                        problem.first().widened[axis] * fit.blocks[0].slopes[(2 * k + axis, c - 1)]
                    }
                });
                Correlation::of(&t, &y, &x)
            });
            problem = plain.clone();
            problem.correlate_noise(0, [1.0; 2], &axes);
            fit = problem.fit(&terms, None);
        }
        let found = values(&problem, &fit);
        for found in &found[..2] {
            all += 1;
            hold += usize::from((found.value - 1.0).abs() < 1.96 * found.std);
        }
    }
    // 95 % ± 3 √(0.95 · 0.05/600)
    let share = hold as f64 / all as f64;
    assert!((0.923..=0.977).contains(&share), "{hold}");
}
