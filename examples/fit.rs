//! From a posture log to the parameters of a robot, what is known of them and what no
//! data of this kind can tell.
//!
//! ```sh
//! cargo run --example fit
//! ```
//!
//! The log is made here, of an OP2 whose parameters are up to 5 mm off its CAD; a real
//! one is a path: `request.logs = vec![Path::new("log.csv").into()]`.

use std::sync::Arc;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_generated::op2_r_sole::{self as op2, CAD_PARAMS, DOF, JOINT_NAMES};
use sesc_identify::fit::{Request, fit};
use sesc_identify::logs::Table;
use sesc_identify::robot::Robot;

const POSTURES: usize = 300;
/// Standard deviation of a reading of the CoP, m.
const NOISE_M: f64 = 1e-3;

fn main() -> Result<(), sesc_identify::Error> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut uniform = || random.random_range(-1.0..1.0);
    let truth = CAD_PARAMS.map(|r| r + 5e-3 * uniform());
    let postures: Vec<[f64; DOF]> = (0..POSTURES)
        .map(|_| std::array::from_fn(|_| 0.5 * uniform()))
        .collect();
    let mut log = Table::new("op2.csv");
    for (axis, column) in ["cop_x", "cop_y"].into_iter().enumerate() {
        let mut noise = || 3_f64.sqrt() * NOISE_M * uniform();
        let cop = postures.iter().map(|q| op2::cop(q, &truth)[axis] + noise());
        log = log.numbers(column, cop.collect::<Vec<f64>>());
    }
    for (j, joint) in JOINT_NAMES.into_iter().enumerate() {
        log = log.numbers(joint, postures.iter().map(|q| q[j]).collect::<Vec<f64>>());
    }

    let mut request = Request::default();
    request.robot = Some(Arc::new(Robot::parse(sesc::OP2_URDF, "op2.urdf")?));
    request.logs = vec![log.into()];
    request.support = Some("r_sole".into());
    request.noise = Some(NOISE_M);
    let found = fit(&request, &mut ())?.identification;

    println!(
        "{} postures: rank {} of {} base parameters, condition number {:.0}",
        found.postures, found.rank, found.base_params, found.condition_number
    );
    println!(
        "on postures that the fit did not see: {:.2} mm RMS; by CAD {:.2} mm; noise {:.2} mm",
        1e3 * found.held_out_rmse,
        1e3 * found.cad_rmse,
        1e3 * found.noise_floor
    );
    for unseen in &found.unobservable[..3] {
        println!("not observable: {}", unseen.sentence);
    }
    assert!(found.held_out_rmse < 0.5 * found.cad_rmse);
    Ok(())
}
