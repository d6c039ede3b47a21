//! Recordings of a robot that moves: what its sensor says includes what its inertia does to
//! the ground, by the reference's own numerics.
//!
//! ```text
//! q_j(t) = m_j + Σ_k a sin(ω_k t + φ_k)        two sines a joint, ω up to 2π × `hertz`
//! ```

use std::f64::consts::TAU;

use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use sesc_reference::{Track, World};

use crate::recording::{Noise, Recording, draw};
use crate::stage::Stage;

/// How a robot moves.
#[derive(Debug, Clone, Copy)]
pub struct Swing {
    /// Fastest sine, Hz; the slowest is a third of it.
    pub hertz: f64,
    /// Amplitude of each of the two sines of a joint, rad.
    pub amplitude: f64,
    /// s
    pub seconds: f64,
    /// Encoders write multiples of this, rad; 0 writes all digits.
    pub tick: f64,
    /// Stamps jitter by this part of an interval.
    pub jitter: f64,
}

impl Swing {
    /// A swing at most this fast, written in all digits at even stamps.
    pub fn new(hertz: f64, amplitude: f64, seconds: f64) -> Swing {
        Swing {
            hertz,
            amplitude,
            seconds,
            tick: 0.0,
            jitter: 0.0,
        }
    }

    /// The positions at any time.
    pub fn motion(
        &self,
        stage: &Stage,
        random: &mut ChaCha8Rng,
    ) -> impl Fn(f64) -> Vec<f64> + Clone + 'static {
        let waves: Vec<[[f64; 2]; 2]> = (0..stage.joint_names().len())
            .map(|_| {
                [(); 2].map(|()| {
                    let part = (1.0 + 2.0 * random.random::<f64>()) / 3.0;
                    [TAU * self.hertz * part, TAU * random.random::<f64>()]
                })
            })
            .collect();
        let (amplitude, stage) = (self.amplitude, stage.clone());
        move |t| {
            let joints = waves.iter();
            let of = |[w, p]: &[f64; 2]| amplitude * (w * t + p).sin();
            stage.held(joints.map(|waves| waves.iter().map(of).sum()).collect())
        }
    }

    /// Record `world` at `rate` Hz.
    pub fn record(
        &self,
        stage: &Stage,
        world: World,
        noise: Noise,
        rate: f64,
        random: &mut ChaCha8Rng,
    ) -> Recording {
        let motion = self.motion(stage, random);
        let count = (self.seconds * rate) as usize;
        let t: Vec<f64> = (0..count)
            .map(|k| (k as f64 + self.jitter * (random.random::<f64>() - 0.5)) / rate)
            .collect();
        let track = Track::moving(t.clone(), motion);
        let readings = world.unsettled().readings(&track);
        let noises = noise.std.map(|std| draw(noise.kind, std, &t, random));
        let written = |q: &f64| match self.tick > 0.0 {
            true => (q / self.tick).round() * self.tick,
            false => *q,
        };
        let q = track.postures().iter();
        let cop = readings.iter().enumerate();
        let cop = cop.map(|(k, own)| [0, 1].map(|axis| own.cop[axis] + noises[axis][k]));
        Recording {
            joints: stage.joint_names(),
            pose: None,
            q: q.map(|q| q.iter().map(written).collect()).collect(),
            cop: cop.collect(),
            t,
        }
    }
}
