//! How many independent postures a recording is worth.

use super::*;

/// About normal, of deviation one.
fn normal(seed: &mut u64) -> f64 {
    (0..12).map(|_| number(seed)).sum::<f64>() / 2.0
}

/// Slow sines with noise that keeps `rho` of itself from posture to posture; how wrong each
/// parameter is, over its deviation.
fn recording(rho: f64, seed: u64, count: usize) -> (Estimator<f64, 5>, Vec<f64>) {
    let truth = [0.1, -0.2, 0.3, 0.05, 0.4];
    let mut seed = seed;
    let mut estimator = Estimator::new();
    let mut noise = [normal(&mut seed), normal(&mut seed)];
    for k in 0..count {
        let wave = |j: usize| (0.003 * (j + 1) as f64 * k as f64 + j as f64).sin();
        let x: [f64; 5] = core::array::from_fn(wave);
        let y: [f64; 5] = core::array::from_fn(|j| wave(j + 5));
        for e in &mut noise {
            *e = rho * *e + (1.0 - rho * rho).sqrt() * normal(&mut seed);
        }
        let of = |row: &[f64; 5]| row.iter().zip(&truth).map(|(a, b)| a * b).sum::<f64>();
        let cop = [of(&x) + 1e-3 * noise[0], of(&y) + 1e-3 * noise[1]];
        estimator.posture(&[x, y], &cop, &[1e-3; 2]).unwrap();
    }
    let all = estimator.params().into_iter().zip(truth);
    let wrong = all.zip(estimator.lasting_deviations());
    let wrong = wrong.map(|((found, truth), std)| (found - truth) / std);
    let wrong = wrong.collect();
    (estimator, wrong)
}

/// n/n_eff of AR(1) noise is (1 + ρ)/(1 − ρ); deviations are as wide as errors are.
#[test]
fn postures_are_worth_what_the_noise_leaves_of_them() {
    for (rho, count) in [(0.0, 3000), (0.8, 6000), (0.95, 12_000)] {
        let (mut worth, mut square, mut parameters) = (Vec::new(), 0.0, 0.0);
        for seed in 0..24 {
            let (estimator, wrong) = recording(rho, seed, count);
            worth.push(count as f64 / estimator.independent_postures());
            square += wrong.iter().map(|e| e * e).sum::<f64>();
            parameters += wrong.len() as f64;
        }
        worth.sort_by(f64::total_cmp);
        let expected = (1.0 + rho) / (1.0 - rho);
        let median = worth[worth.len() / 2] / expected;
        let rms = (square / parameters).sqrt();
        assert!((0.8..1.5).contains(&median), "{rho}: {median}");
        assert!((0.7..1.2).contains(&rms), "{rho}: {rms}");
        if rho == 0.0 {
            assert_eq!(worth[worth.len() - 1], 1.0);
        }
    }
}

/// Under forgetting, old noise no longer counts.
#[test]
fn noise_that_lasted_once_is_forgotten() {
    let mut estimator = Estimator::<f64, 1>::new().forgetting(0.99).unwrap();
    let mut seed = 7;
    let mut feed = |estimator: &mut Estimator<f64, 1>, hold: usize, count: usize| {
        let mut value = 0.0;
        for k in 0..count {
            if k % hold == 0 {
                value = 1e-3 * normal(&mut seed);
            }
            estimator
                .posture(&[[1.0], [0.0]], &[value, 0.0], &[1e-3; 2])
                .unwrap();
        }
        estimator.independent_postures() / estimator.postures() as f64
    };
    assert!(feed(&mut estimator, 8, 4000) < 0.4);
    assert!(feed(&mut estimator, 1, 40_000) > 0.9);
}
