//! What is passed in: postures as ticks, positions, sines and cosines, and joint velocities.

use std::fmt::Write as _;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_generated::op2_r_sole as op2;

use super::build::Config;

pub const DOF: usize = op2::DOF;
pub const POSTURES: usize = 16;
/// Postures that instructions are counted on.
pub const COUNTED: usize = 3;

pub struct Posture {
    pub ticks: [i32; DOF],
    pub q: [f64; DOF],
    /// rad/s
    pub qd: [f64; DOF],
    /// Beside accelerations, rad/s: at which the ground carries half of the weight and more.
    pub slow: [f64; DOF],
    /// rad/s²
    pub qdd: [f64; DOF],
}

/// Both ends of the joint limits, ±2.618 rad, at full speed, and random postures between.
pub fn postures() -> Vec<Posture> {
    const LIMIT_RAD: f64 = 2.617;
    const LIMIT_TICKS: i32 = 1706;
    /// Speed below the limit of every joint in the URDF, 5.6549 rad/s.
    const SPEED: f64 = 5.654;
    const SLOW: f64 = 0.1;
    const GAIN: f64 = 0.5;
    let mut rng = ChaCha8Rng::seed_from_u64(1906);
    let at = |sign: i32| Posture {
        ticks: [2048 + sign * LIMIT_TICKS; DOF],
        q: [f64::from(sign) * LIMIT_RAD; DOF],
        qd: [f64::from(sign) * SPEED; DOF],
        slow: [f64::from(sign) * SLOW; DOF],
        qdd: [f64::from(sign) * GAIN; DOF],
    };
    let mut postures = vec![at(1), at(-1)];
    postures.resize_with(POSTURES, || Posture {
        ticks: std::array::from_fn(|_| 2048 + rng.random_range(-LIMIT_TICKS..=LIMIT_TICKS)),
        q: std::array::from_fn(|_| rng.random_range(-LIMIT_RAD..=LIMIT_RAD)),
        qd: std::array::from_fn(|_| rng.random_range(-SPEED..=SPEED)),
        slow: std::array::from_fn(|_| rng.random_range(-SLOW..=SLOW)),
        qdd: std::array::from_fn(|_| rng.random_range(-GAIN..=GAIN)),
    });
    postures
}

impl Config {
    /// `x` as an integer, or as f32 holds it.
    fn passed(self, x: f64, point: &str) -> f64 {
        match self.fixed {
            true => (x * self.unit(point)).round(),
            false => f64::from(x as f32),
        }
    }

    /// What a passed value means.
    pub fn meant(self, x: f64, point: &str) -> f64 {
        match self.fixed {
            true => self.passed(x, point) / self.unit(point),
            false => self.passed(x, point),
        }
    }

    /// 2^bits of a quantity's binary point.
    pub fn unit(self, point: &str) -> f64 {
        let header = self.header();
        let define = format!("#define {}{point}_FRACTION_BITS ", self.prefix());
        let line = header.lines().find_map(|line| line.strip_prefix(&define));
        let bits: i32 = line
            .expect("the header tells binary points")
            .parse()
            .unwrap();
        2f64.powi(bits)
    }

    pub fn postures_h(self) -> String {
        let mut text = format!(
            "#include <stdint.h>\n\n#include \"robot.h\"\n\n#define POSTURES {POSTURES}u\n\
             #define POSTURES_COUNTED {COUNTED}u\n"
        );
        let mut array = |kind: &str, name: &str, value: &dyn Fn(&Posture, usize) -> String| {
            let _ = writeln!(
                text,
                "\nstatic const {kind} {name}[POSTURES][ROBOT(DOF)] = {{"
            );
            for posture in postures() {
                let row: Vec<String> = (0..DOF).map(|k| value(&posture, k)).collect();
                let _ = writeln!(text, "    {{{}}},", row.join(", "));
            }
            text += "};\n";
        };
        let literal = |x: f64| match self.fixed {
            true => format!("{x}"),
            false => format!("{:?}f", x as f32),
        };
        let (q, qd, sc) = ("Q", "QD", "SC");
        array("int32_t", "ticks", &|p, k| p.ticks[k].to_string());
        array("ROBOT(real)", "q", &|p, k| literal(self.passed(p.q[k], q)));
        array("ROBOT(real)", "qd", &|p, k| {
            literal(self.passed(p.qd[k], qd))
        });
        if !self.fixed {
            array("ROBOT(real)", "slow", &|p, k| literal(p.slow[k]));
            array("ROBOT(real)", "qdd", &|p, k| literal(p.qdd[k]));
        }
        array("ROBOT(real)", "sin_q", &|p, k| {
            literal(self.passed(p.q[k].sin(), sc))
        });
        array("ROBOT(real)", "cos_q", &|p, k| {
            literal(self.passed(p.q[k].cos(), sc))
        });
        text
    }
}
