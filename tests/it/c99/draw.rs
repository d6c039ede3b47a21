//! What the functions are called with: postures, motion, parameters and ticks.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc::verify::JointMotion;
use sesc_model::Function;

use super::case::Case;

/// Postures, joint velocities and parameters, row by row.
#[derive(Clone, Default)]
pub(crate) struct Draw {
    pub q: Vec<f64>,
    /// Joint velocities.
    pub qd: Vec<f64>,
    /// Those beside accelerations, at which the ground carries half of the weight and more.
    pub slow: Vec<f64>,
    /// Joint accelerations.
    pub qdd: Vec<f64>,
    pub r: Vec<f64>,
    pub ticks: Vec<i32>,
    /// What the ticks stand for.
    pub turned: Vec<f64>,
}

impl Draw {
    /// Joint velocities and accelerations that `function` takes.
    pub(crate) fn motion(&self, function: Function) -> [&[f64]; 2] {
        match function {
            Function::Zmp => [&self.slow, &self.qdd],
            _ => [&self.qd, &self.qdd],
        }
    }
}

/// What is drawn of a joint.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Drawn {
    Angle,
    Stroke,
    Velocity,
}

/// A value as a scalar holds it: what it is of, whether rounded up.
pub(crate) type Hold = dyn Fn(f64, Drawn, bool) -> f64;

/// `count` draws: corners of the limits and of the promised parameters among
/// them, everything in between, positions and velocities such that the scalar holds them.
pub(crate) fn draw(case: &Case, count: usize, seed: u64, hold: &Hold) -> Draw {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut rates = ChaCha8Rng::seed_from_u64(!seed);
    let mut drawn = Draw::default();
    let servos = case.servos();
    let most = JointMotion::new(&case.model, |_| 1.0);
    let cad = case.model.cad_params();
    for k in 0..count {
        // Every fourth a corner in q, every third one in r; the first both, at their lowest.
        let corner = |rng: &mut ChaCha8Rng, at: bool| match (at, k < 2) {
            (true, true) => k as f64,
            (true, false) => f64::from(u8::from(rng.random_bool(0.5))),
            (false, _) => rng.random(),
        };
        for (j, (dof, servo)) in case.model.tree.dofs.iter().zip(&servos).enumerate() {
            let (lower, upper) = (dof.lower, dof.upper);
            let x = lower + corner(&mut rng, k % 4 < 2) * (upper - lower);
            // Towards the middle: what is rounded beyond a limit is no posture any more.
            let up = x < 0.5 * (lower + upper);
            let kind = match dof.prismatic {
                true => Drawn::Stroke,
                false => Drawn::Angle,
            };
            drawn.q.push(hold(x, kind, up));
            // Every second time at full speed, the first two all joints the same way.
            let share: f64 = rates.random_range(-1.0..=1.0);
            let share = match k {
                0 => -1.0,
                1 => 1.0,
                _ if k % 2 == 0 => share.signum(),
                _ => share,
            };
            let qd = share * dof.speed;
            drawn.qd.push(hold(qd, Drawn::Velocity, qd < 0.0));
            let slow = share * most.rates[j];
            drawn.slow.push(hold(slow, Drawn::Velocity, slow < 0.0));
            let qdd = rates.random_range(-1.0..=1.0) * most.accelerations[j];
            drawn.qdd.push(hold(qdd, Drawn::Velocity, qdd < 0.0));
            let at = x / servo.per_tick;
            let away = [at.floor(), at.ceil(), 0.0]
                .into_iter()
                .find(|n| (lower..=upper).contains(&(n * servo.per_tick)))
                .unwrap_or(at.round());
            drawn.ticks.push(servo.zero + away as i32);
            drawn.turned.push(away * servo.per_tick);
        }
        for (limit, cad) in case.model.param_limits.iter().zip(&cad) {
            drawn.r.push(match k % 3 {
                0 => limit * (2.0 * corner(&mut rng, true) - 1.0),
                1 => limit * (2.0 * rng.random::<f64>() - 1.0),
                _ => *cad,
            });
        }
    }
    drawn
}
