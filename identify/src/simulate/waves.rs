//! A motion through the range of every joint.
//!
//! ```text
//! q_j(t) = m_j + a_j/2 Σ_k sin(ω_k t + φ_k)        two sines a joint, 0.05 to 0.25 Hz
//! ```
//!
//! `m_j ± a_j` is the joint's range. Velocities and accelerations are those of the sines.

use std::f64::consts::TAU;

use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

/// Slowest and fastest sine, Hz.
const HERTZ: (f64, f64) = (0.05, 0.25);

/// One joint.
struct Wave {
    middle: f64,
    amplitude: f64,
    /// rad/s and rad of each sine.
    sines: [[f64; 2]; 2],
}

/// How all joints move.
pub(super) struct Waves(Vec<Wave>);

/// Positions, velocities and accelerations, joint by joint.
#[derive(Default)]
pub(super) struct Moment {
    pub q: Vec<f64>,
    pub rates: Vec<f64>,
    pub accelerations: Vec<f64>,
}

impl Waves {
    /// Within `ranges`, rad or m.
    pub fn draw(ranges: &[(f64, f64)], random: &mut ChaCha8Rng) -> Waves {
        let wave = |&(lower, upper): &(f64, f64)| Wave {
            middle: 0.5 * (lower + upper),
            amplitude: 0.25 * (upper - lower),
            sines: [(); 2].map(|()| {
                let hertz = HERTZ.0 + (HERTZ.1 - HERTZ.0) * random.random::<f64>();
                [TAU * hertz, TAU * random.random::<f64>()]
            }),
        };
        Waves(ranges.iter().map(wave).collect())
    }

    /// Add the moment `t` seconds after the start.
    pub fn at(&self, t: f64, to: &mut Moment) {
        for wave in &self.0 {
            let [mut q, mut rate, mut acceleration] = [wave.middle, 0.0, 0.0];
            for [w, phase] in wave.sines {
                let (sin, cos) = (w * t + phase).sin_cos();
                q += wave.amplitude * sin;
                rate += wave.amplitude * w * cos;
                acceleration -= wave.amplitude * w * w * sin;
            }
            to.q.push(q);
            to.rates.push(rate);
            to.accelerations.push(acceleration);
        }
    }
}
