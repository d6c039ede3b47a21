//! On the robot: learn the SESC parameters posture by posture, in fixed memory.
//!
//! ```sh
//! cargo run --example on_target
//! ```
//!
//! A controller generates the module of its robot in `build.rs` (`examples/controller`
//! is a complete one); this example takes the OP2's from `generated/`. Nothing here
//! allocates or needs `std` but the printing.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_generated::op2_r_sole::{self as op2, BASE_PARAMS, CAD_PARAMS, DOF};
use sesc_runtime::fit::{Error, Estimator};

/// Standard deviation of a reading of the foot's sensor, m.
const COP_STD_M: [f64; 2] = [1e-3, 1e-3];
/// How far parameters may be from CAD, m.
const PRIOR_STD_M: f64 = 0.01;

fn main() -> Result<(), Error> {
    // The robot as it is: every parameter up to 5 mm off its CAD. One flat foot never
    // sees the constant height, so CAD must be right there.
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut uniform = || random.random_range(-1.0..1.0);
    let mut truth = CAD_PARAMS;
    for r in &mut truth {
        *r += 5e-3 * uniform();
    }
    truth[2] = CAD_PARAMS[2];

    let mut estimator = Estimator::with_prior(&CAD_PARAMS, &[PRIOR_STD_M; BASE_PARAMS])?;
    for _ in 0..1000 {
        // What encoders and sensor say.
        let q: [f64; DOF] = std::array::from_fn(|_| uniform());
        let cop = op2::cop(&q, &truth);
        let reading = [0, 1].map(|k| cop[k] + 3_f64.sqrt() * COP_STD_M[k] * uniform());
        // What the controller does with it.
        estimator.add_posture::<op2::Op2RSole>(&q, &reading, &COP_STD_M)?;
    }

    let learned = estimator.params();
    let (mut before, mut after) = (0.0_f64, 0.0_f64);
    for _ in 0..1000 {
        let q: [f64; DOF] = std::array::from_fn(|_| uniform());
        let exact = op2::com(&q, &truth);
        for (worst, r) in [(&mut before, &CAD_PARAMS), (&mut after, &learned)] {
            let com = op2::com(&q, r);
            *worst = (0..3).fold(*worst, |worst, k| worst.max((com[k] - exact[k]).abs()));
        }
    }
    println!(
        "{} postures, rank {} of {BASE_PARAMS}: CoM on new postures within {:.2} mm, by CAD within {:.2} mm",
        estimator.postures(),
        estimator.rank(),
        1e3 * after,
        1e3 * before
    );
    assert!(after < 0.1 * before, "the fit is ten times closer than CAD");
    Ok(())
}
