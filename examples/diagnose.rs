//! Simulation and measurement disagree: which effect is missing, where, and how sure.
//!
//! ```sh
//! cargo run --example diagnose
//! ```
//!
//! The log is made here, of an OP2 whose left knee stands 10° from where its encoder
//! says; a real one is a path: `Request::new(robot, Path::new("log.csv"))`.

use std::sync::Arc;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_generated::op2_r_sole::{self as op2, CAD_PARAMS, DOF, JOINT_NAMES, joint};
use sesc_identify::diagnose::{Request, Verdict, diagnose};
use sesc_identify::fit::prior::PriorChoice;
use sesc_identify::logs::Table;
use sesc_identify::robot::Robot;

const POSTURES: usize = 100;
/// Standard deviation of a reading of the CoP, m.
const NOISE_M: f64 = 5e-4;
const OFFSET_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;

fn main() -> Result<(), sesc_identify::Error> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut uniform = || random.random_range(-1.0..1.0);
    let postures: Vec<[f64; DOF]> = (0..POSTURES)
        .map(|_| std::array::from_fn(|_| 0.5 * uniform()))
        .collect();
    let mut log = Table::new("op2.csv");
    for (axis, column) in ["cop_x", "cop_y"].into_iter().enumerate() {
        let mut read = |q: &[f64; DOF]| {
            let mut q = *q;
            q[joint::L_KNEE] += OFFSET_RAD;
            op2::cop(&q, &CAD_PARAMS)[axis] + 3_f64.sqrt() * NOISE_M * uniform()
        };
        let cop: Vec<f64> = postures.iter().map(&mut read).collect();
        log = log.numbers(column, cop);
    }
    for (j, name) in JOINT_NAMES.into_iter().enumerate() {
        log = log.numbers(name, postures.iter().map(|q| q[j]).collect::<Vec<f64>>());
    }

    let robot = Arc::new(Robot::parse(sesc::OP2_URDF, "op2.urdf")?);
    let mut request = Request::new(robot, log);
    request.support = Some("r_sole".into());
    request.noise = Some(NOISE_M);
    // Every link was weighed: masses explain nothing away.
    request.prior = PriorChoice::Tight;
    let found = diagnose(&request, &mut ())?.diagnosis;

    println!("{}", found.sentence);
    println!(
        "explanations that these data cannot tell apart: {:?}",
        found.indistinguishable
    );
    assert!(matches!(found.verdict, Verdict::Named | Verdict::Class));
    Ok(())
}
