//! Posture logs of an ideal robot: uniform postures, Gaussian CoP noise.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Normal};
use sesc_model::tree::Dof;

/// Seeded postures and noise; the same numbers on every machine.
pub struct Simulator {
    postures: ChaCha8Rng,
    noise: ChaCha8Rng,
    ranges: Vec<(f64, f64)>,
}

impl Simulator {
    /// Postures uniform within the limits, and within ±`range` rad of zero
    /// where one is given (turning joints only).
    pub fn new(dofs: &[Dof], range: Option<f64>, seed: u64) -> Simulator {
        // Two streams: more noise draws never change the postures.
        let mut noise = ChaCha8Rng::seed_from_u64(seed);
        noise.set_stream(1);
        Simulator {
            postures: ChaCha8Rng::seed_from_u64(seed),
            noise,
            ranges: dofs.iter().map(|dof| narrowed(dof, range)).collect(),
        }
    }

    /// The next posture, rad or m.
    pub fn posture(&mut self) -> Vec<f64> {
        let rng = &mut self.postures;
        self.ranges
            .iter()
            .map(|&(lower, upper)| lower + (upper - lower) * rng.random::<f64>())
            .collect()
    }

    /// The next `count` postures, one after the other.
    pub fn batch(&mut self, count: usize) -> Vec<f64> {
        (0..count).flat_map(|_| self.posture()).collect()
    }

    /// Gaussian noise of standard deviation `std`.
    pub fn gauss(&mut self, std: f64) -> f64 {
        Normal::new(0.0, 1.0).map_or(0.0, |normal| std * normal.sample(&mut self.noise))
    }
}

/// The limits, cut to ±range; a joint whose limits exclude that keeps its own.
fn narrowed(dof: &Dof, range: Option<f64>) -> (f64, f64) {
    match range {
        Some(range) if !dof.prismatic => {
            let (lower, upper) = (dof.lower.max(-range), dof.upper.min(range));
            if lower < upper {
                (lower, upper)
            } else {
                (dof.lower, dof.upper)
            }
        }
        _ => (dof.lower, dof.upper),
    }
}
