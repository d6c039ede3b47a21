//! A 1 kHz balance loop: CoM, its velocity and the gravity moments every tick; then
//! the robot finds out that it is not its CAD, from CoP readings.

#![forbid(unsafe_code)]
#![deny(warnings)]

use sesc_runtime::fit::Estimator;

mod op2 {
    include!(concat!(env!("OUT_DIR"), "/op2_r_sole.rs"));
}

/// For any robot; allocation-free, as it would run on one.
mod control {
    use sesc_runtime::fit::{Error, Estimator};
    use sesc_runtime::{Const, Params, Posture, Sesc};

    /// Noise of the foot's CoP, m.
    pub const COP_STD: [f64; 2] = [1e-3; 2];

    /// Called whenever the robot stands still. The number of parameters is found by the
    /// compiler.
    pub fn learn<R: Sesc<Base = Const<N>>, const N: usize>(
        parameters: &mut Estimator<f64, N>,
        q: &Posture<R>,
        reading: &[f64; 2],
    ) -> Result<(), Error> {
        parameters.add_posture::<R>(q, reading, &COP_STD)
    }

    pub struct State<R: Sesc> {
        pub com: [f64; 3],
        pub com_velocity: [f64; 3],
        /// What motors that hold the posture feed forward, N m.
        pub holding_moments: Posture<R>,
    }

    /// Called every millisecond.
    pub fn tick<R: Sesc>(q: &Posture<R>, qd: &Posture<R>, r: &Params<R>) -> State<R> {
        let velocity = |row: &Posture<R>| {
            let terms = row.as_ref().iter().zip(qd.as_ref());
            terms.map(|(j, v)| j * v).sum()
        };
        let jacobian = R::com_jacobian(q, r);
        let mut holding_moments = R::gravity_moments(q, r);
        // The moment that gravity exerts; a motor that holds the posture applies the opposite.
        for moment in holding_moments.as_mut() {
            *moment *= -R::TOTAL_MASS_KG * 9.80665;
        }
        State {
            com: R::com(q, r),
            com_velocity: [0, 1, 2].map(|k| velocity(&jacobian[k])),
            holding_moments,
        }
    }
}

fn main() {
    let com = op2::com(&op2::SELF_TEST_Q, &op2::CAD_PARAMS);
    let off = com
        .iter()
        .zip(op2::SELF_TEST_COM)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    assert!(off < 1e-12, "self-test: {off} m");

    // One second of a slow sway: every joint follows its own sine.
    let (dt, mut q, mut qd) = (1e-3, [0.0; op2::DOF], [0.0; op2::DOF]);
    let mut integrated = op2::com(&q, &op2::CAD_PARAMS);
    for tick in 0..1000 {
        for j in 0..op2::DOF {
            let rate = 1.0 + 0.1 * j as f64;
            qd[j] = 0.2 * rate * (rate * (tick as f64 + 0.5) * dt).cos();
            q[j] += 0.5 * dt * qd[j];
        }
        let state = control::tick::<op2::Op2RSole>(&q, &qd, &op2::CAD_PARAMS);
        for k in 0..3 {
            integrated[k] += dt * state.com_velocity[k];
        }
        for j in 0..op2::DOF {
            q[j] += 0.5 * dt * qd[j];
        }
        if tick % 250 == 0 {
            println!(
                "{tick:4} ms  CoM {:.4?} m, ankle roll motor {:.4} N m",
                state.com,
                state.holding_moments[op2::joint::R_ANK_ROLL]
            );
        }
    }
    let com = op2::com(&q, &op2::CAD_PARAMS);
    let drift = com
        .iter()
        .zip(integrated)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    println!("CoM {com:.6?} m; integrating its velocity drifts by {drift:.1e} m");
    assert!(drift < 1e-6);

    identify().expect("readings are finite numbers");
}

/// A robot whose parameters are up to 5 mm off its CAD stands in 1000 postures.
fn identify() -> Result<(), sesc_runtime::fit::Error> {
    let mut seed = 1_u64;
    let mut uniform = move || {
        seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let mut truth = op2::CAD_PARAMS;
    for r in &mut truth {
        *r += 5e-3 * uniform();
    }
    // No reading of one flat foot shows the constant height: there, CAD is right.
    truth[2] = op2::CAD_PARAMS[2];

    let mut parameters = Estimator::with_prior(&op2::CAD_PARAMS, &[0.01; op2::BASE_PARAMS])?;
    for _ in 0..1000 {
        let q = [(); op2::DOF].map(|()| uniform());
        let noise = [(); 2].map(|()| 3_f64.sqrt() * uniform());
        let cop = op2::cop(&q, &truth);
        let reading = [0, 1].map(|k| cop[k] + control::COP_STD[k] * noise[k]);
        control::learn::<op2::Op2RSole, _>(&mut parameters, &q, &reading)?;
    }

    let r = parameters.params();
    let (mut before, mut after, mut surprise) = (0.0_f64, 0.0_f64, 0.0_f64);
    for _ in 0..1000 {
        let q = [(); op2::DOF].map(|()| uniform());
        let (exact, cad) = (op2::com(&q, &truth), op2::com(&q, &op2::CAD_PARAMS));
        let (com, rows) = (op2::com(&q, &r), op2::regressor(&q));
        for k in 0..2 {
            // The height is known up to the prior's constant: that std is 10 mm.
            let std = parameters.predict(&rows[k])?.variance.sqrt();
            surprise = surprise.max((com[k] - exact[k]).abs() / std);
        }
        for k in 0..3 {
            before = before.max((cad[k] - exact[k]).abs());
            after = after.max((com[k] - exact[k]).abs());
        }
    }
    println!(
        "identified from {} postures: on new ones CoM within {:.2} mm, by CAD within {:.2} mm",
        parameters.postures(),
        1e3 * after,
        1e3 * before
    );
    println!("x and y are within {surprise:.1} of the predicted standard deviations");
    assert!(surprise < 5.0);
    let scatter = parameters.residual_sum_of_squares() / parameters.degrees_of_freedom();
    assert!(
        (0.8..1.2).contains(&scatter),
        "residuals over noise: {scatter}"
    );
    balance(&truth, &r);
    Ok(())
}

/// One step of the right ankle towards the reading that is wanted, rad.
fn stand(q: &mut [f64; op2::DOF], r: &[f64; op2::BASE_PARAMS], wanted: [f64; 2]) {
    let (roll, pitch) = (op2::joint::R_ANK_ROLL, op2::joint::R_ANK_PITCH);
    let ([x, y], cop) = (op2::cop_jacobian(q, r), op2::cop(q, r));
    let off = [wanted[0] - cop[0], wanted[1] - cop[1]];
    let det = x[roll] * y[pitch] - x[pitch] * y[roll];
    q[roll] += (off[0] * y[pitch] - x[pitch] * off[1]) / det;
    q[pitch] += (x[roll] * off[1] - off[0] * y[roll]) / det;
}

/// The robot of `truth` stands by the model of `r` where CAD would have it elsewhere.
fn balance(truth: &[f64; op2::BASE_PARAMS], r: &[f64; op2::BASE_PARAMS]) {
    let wanted = [0.01, 0.0];
    let off = |r: &[f64; op2::BASE_PARAMS]| {
        let mut q = [0.0; op2::DOF];
        for _ in 0..8 {
            stand(&mut q, r, wanted);
        }
        let cop = op2::cop(&q, truth);
        (cop[0] - wanted[0]).hypot(cop[1] - wanted[1])
    };
    let (by_model, by_cad) = (off(r), off(&op2::CAD_PARAMS));
    println!(
        "stands {:.2} mm off by the model, {:.2} mm by CAD",
        1e3 * by_model,
        1e3 * by_cad
    );
    assert!(by_model < 1e-3 && by_cad > 5.0 * by_model);
}
