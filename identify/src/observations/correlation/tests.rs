use super::*;
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Normal deviates by Box and Muller.
fn gauss(rng: &mut ChaCha8Rng) -> f64 {
    let unit = |rng: &mut ChaCha8Rng| (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let (u, v) = (unit(rng).max(1e-300), unit(rng));
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// What noise is like.
#[derive(Debug, Clone, Copy)]
enum Kind {
    White,
    /// AR(1) of this time constant, s.
    Ar1(f64),
    /// Two AR(1) in a row: smooth, as behind a filter.
    Smooth(f64),
    /// AR(1) under as much white noise.
    Under(f64),
}

impl Kind {
    /// Rows `step` seconds apart per independent one.
    fn rows_per_sample(self, step: f64) -> f64 {
        // ∫ ρ: τ of AR(1), 2 τ of (1 + h/τ) exp(−h/τ).
        match self {
            Kind::White => 1.0,
            Kind::Ar1(tau) => 2.0 * tau / step,
            Kind::Smooth(tau) => 4.0 * tau / step,
            Kind::Under(tau) => 0.5 * (2.0 * tau / step) + 0.5,
        }
    }

    fn draw(self, n: usize, step: f64, rng: &mut ChaCha8Rng) -> DVector<f64> {
        let mut ar1 = |tau: f64, drive: &dyn Fn(usize, &mut ChaCha8Rng) -> f64| {
            let rho = (-step / tau).exp();
            let mut e = 0.0;
            let all: Vec<f64> = (0..n + 2000)
                .map(|k| {
                    e = rho * e + (1.0 - rho * rho).sqrt() * drive(k, rng);
                    e
                })
                .collect();
            all
        };
        let own = |_: usize, rng: &mut ChaCha8Rng| gauss(rng);
        match self {
            Kind::White => DVector::from_fn(n, |_, _| gauss(rng)),
            Kind::Ar1(tau) => DVector::from_vec(ar1(tau, &own)[2000..].to_vec()),
            Kind::Smooth(tau) => {
                let first = ar1(tau, &own);
                DVector::from_vec(ar1(tau, &|k, _| first[k])[2000..].to_vec())
            }
            Kind::Under(tau) => {
                let slow = DVector::from_vec(ar1(tau, &own)[2000..].to_vec());
                slow + DVector::from_fn(n, |_, _| gauss(rng))
            }
        }
    }
}

/// Slow sines that a fit takes away, and noise.
fn log(n: usize, step: f64, kind: Kind, seed: u64) -> (Vec<f64>, DVector<f64>, DMatrix<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let t: Vec<f64> = (0..n)
        .map(|k| step * (k as f64 + 0.2 * gauss(&mut rng).tanh()))
        .collect();
    let y = kind.draw(n, step, &mut rng);
    let wave = |k: usize, c: usize| (0.1 * (c + 1) as f64 * t[k] + c as f64).sin();
    (t.clone(), y, DMatrix::from_fn(n, 20, wave))
}

/// Rows that a fit counts for independent over those of the process, sorted.
fn ratios(
    kind: Kind,
    step: f64,
    seeds: impl IntoIterator<Item = u64>,
    log: impl Fn(u64) -> (Vec<f64>, DVector<f64>, DMatrix<f64>),
) -> Vec<f64> {
    let ratio = |seed| {
        let (t, y, x) = log(seed);
        Correlation::of(&t, &y, &x).rows_per_sample / kind.rows_per_sample(step)
    };
    let mut ratios: Vec<f64> = seeds.into_iter().map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    println!("{step} {kind:?}: {ratios:.2?}");
    ratios
}

#[test]
fn independent_samples_are_counted_as_such() {
    for (rows, seeds) in [(400, 0..60), (2000, 100..120)] {
        for seed in seeds {
            let (t, y, x) = log(rows, 0.1, Kind::White, seed);
            assert_eq!(Correlation::of(&t, &y, &x), Correlation::NONE, "{seed}");
        }
    }
}

/// The number of independent samples is that of the process, though a fit of 20
/// columns has eaten the slow part of the noise; at every rate, and of every kind.
#[test]
fn samples_are_counted_by_the_correlation_of_the_process() {
    let kinds = [
        Kind::Ar1(0.2),
        Kind::Ar1(0.5),
        Kind::Ar1(1.0),
        Kind::Smooth(0.2),
        Kind::Under(0.5),
    ];
    for step in [0.1, 0.02] {
        for kind in kinds {
            let n = (120.0 / step) as usize;
            let ratios = ratios(kind, step, 100..109, |seed| log(n, step, kind, seed));
            let middle = (0.7..1.4).contains(&ratios[4]);
            assert!(middle && ratios[0] > 0.35 && ratios[8] < 2.8);
        }
    }
}

/// A minute of a sway of half a second under the white noise of a sensor at 200 Hz:
/// single rows look nearly independent, and the fit takes much of the sway.
#[test]
fn a_sway_under_the_white_noise_of_a_fast_sensor_is_counted() {
    let (kind, step) = (Kind::Under(0.45), 0.005);
    let ratios = ratios(kind, step, 200..209, |seed| log(12_000, step, kind, seed));
    assert!((0.7..1.4).contains(&ratios[4]), "{ratios:?}");
    assert!(ratios[0] > 0.4 && ratios[8] < 2.5, "{ratios:?}");
}

/// A reading less what those before it say of it, over its deviation, is the row of L⁻¹ y where
/// L Lᵀ is the covariance of all.
#[test]
fn innovations_are_those_of_the_covariance() {
    let t = [0.0_f64, 0.1, 0.2, 0.35, 0.36, 0.9, 1.0, 2.5];
    let y = [0.3, -1.0, 0.7, 0.2, 0.1, 2.0, -0.4, 0.6];
    for (tau, share) in [(0.3_f64, 0.4_f64), (1.0, 0.95), (0.1, 1.0), (0.5, 0.01)] {
        let covariance = DMatrix::from_fn(t.len(), t.len(), |i, j| {
            let lasting = share * (-(t[i] - t[j]).abs() / tau).exp();
            if i == j { 1.0 } else { lasting }
        });
        let factor = covariance.cholesky().unwrap().l();
        let expected = factor.solve_lower_triangular(&DVector::from_column_slice(&y));
        let expected = expected.unwrap();
        let mut filter = mixture::Filter::new(1, share);
        for k in 0..t.len() {
            let rho = match k {
                0 => 0.0,
                _ => (-(t[k] - t[k - 1]) / tau).exp(),
            };
            let mut row = [y[k]];
            let variance = filter.whiten(rho, share, &mut row);
            assert!((row[0] - expected[k]).abs() < 1e-12, "{tau} {share}: {k}");
            assert!((variance.sqrt() - factor[(k, k)]).abs() < 1e-12);
        }
    }
}

#[test]
fn times_that_run_backwards_say_nothing() {
    let (mut t, y, x) = log(200, 0.1, Kind::Ar1(0.5), 3);
    t.reverse();
    t.swap(10, 20);
    assert_eq!(Correlation::of(&t, &y, &x), Correlation::NONE);
}

#[test]
fn a_clock_that_is_set_back_once_in_a_hundred_rows_has_a_step() {
    let mut t: Vec<f64> = (0..100).map(|k| 0.25 * f64::from(k)).collect();
    t[40] -= 1.0;
    assert_eq!(step(&t), Some(0.25));
    for k in [10, 60, 80] {
        t[k] -= 1.0;
    }
    assert_eq!(step(&t), None);
}

/// Noise of windows, entry by entry: e_k = m_w + d_k, where m of two windows are correlated and d
/// are independent; with a pause, after which a window begins.
#[test]
fn the_spread_of_a_sum_is_that_of_the_dense_covariance() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let t: Vec<f64> = (0..97)
        .map(|k| 0.01 * f64::from(k) + if k < 41 { 0.0 } else { 0.3 })
        .collect();
    let z = DMatrix::from_fn(t.len(), 3, |k, c| match c {
        0 => 1.0,
        1 => (40.0 * t[k]).sin(),
        _ => gauss(&mut rng),
    });
    for (rows, share, lasting) in [(1, 1.0, 1.0), (1, 0.6, 1.0), (8, 1.0, 0.7), (8, 0.8, 0.4)] {
        let cut = Cut::new(rows, 0.01);
        let process = Process {
            cut,
            tau_s: 0.12,
            share,
            lasting,
        };
        let windows = {
            let mut all: Vec<Range<usize>> = Vec::new();
            for part in [0..41, 41..97] {
                let starts = part.clone().step_by(rows);
                all.extend(starts.map(|k| k..(k + rows).min(part.end)));
            }
            all
        };
        let window = |k: usize| windows.iter().position(|w| w.contains(&k)).unwrap();
        let middle =
            |w: usize| windows[w].clone().map(|k| t[k]).sum::<f64>() / windows[w].len() as f64;
        let mean = |w: usize| lasting + (1.0 - lasting) / windows[w].len() as f64;
        let dense = DMatrix::from_fn(t.len(), t.len(), |k, l| {
            let (a, b) = (window(k), window(l));
            if a != b {
                let apart = (middle(a) - middle(b)).abs();
                return share * (-apart / 0.12).exp() * (mean(a) * mean(b)).sqrt();
            }
            // d_k and d_l of one window sum to nothing.
            let own = f64::from(u8::from(k == l)) - 1.0 / windows[a].len() as f64;
            (1.0 - lasting) * own + mean(a)
        });
        let expected = z.tr_mul(&dense) * &z;
        let found = process.spread(&t, &z);
        let off = (&found - &expected).amax();
        assert!(off < 1e-9 * expected.amax(), "{rows}: {found} {expected}");
    }
}

/// Half a minute of a sway of a quarter of a second under white noise at 500 Hz, beside sixty slow
/// columns. Windows of 16 rows are the first that are filtered, and nearly all of their variance
/// lasts: white noise beside it is hardly likelier than none, but without it something is left.
#[test]
fn a_sway_under_white_noise_that_sixty_columns_take_most_of_is_counted() {
    let (kind, step) = (Kind::Under(0.25), 0.002);
    let ratios = ratios(kind, step, [303, 304, 305, 313, 318], |seed| {
        let (t, y, _) = log(15_000, step, kind, seed);
        let wave = |k: usize, c: usize| (0.08 * (c + 1) as f64 * t[k] + c as f64).sin();
        let x = DMatrix::from_fn(t.len(), 60, wave);
        (t, y, x)
    });
    assert!(ratios[0] > 0.3, "{ratios:?}");
}
