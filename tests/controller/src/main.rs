//! A 1 kHz balance loop: CoM, its velocity and the gravity moments every tick.

#![forbid(unsafe_code)]
#![deny(warnings)]

mod op2 {
    include!(concat!(env!("OUT_DIR"), "/op2_r_sole.rs"));
}

/// Allocation-free, as it would run on the robot.
mod control {
    use crate::op2;

    pub struct State {
        pub com: [f64; 3],
        pub com_velocity: [f64; 3],
        pub ankle_roll_moment: f64,
    }

    pub fn tick(q: &[f64; op2::DOF], qd: &[f64; op2::DOF], r: &[f64; op2::BASE_PARAMS]) -> State {
        let jacobian = op2::com_jacobian(q, r);
        let velocity = |row: &[f64; op2::DOF]| row.iter().zip(qd).map(|(j, v)| j * v).sum();
        let roll = op2::JOINT_NAMES
            .iter()
            .position(|name| *name == "r_ank_roll");
        State {
            com: op2::com(q, r),
            com_velocity: [0, 1, 2].map(|k| velocity(&jacobian[k])),
            ankle_roll_moment: roll.map_or(0.0, |j| op2::gravity_moments(q, r)[j]),
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
        let state = control::tick(&q, &qd, &op2::CAD_PARAMS);
        for k in 0..3 {
            integrated[k] += dt * state.com_velocity[k];
        }
        for j in 0..op2::DOF {
            q[j] += 0.5 * dt * qd[j];
        }
        if tick % 250 == 0 {
            println!(
                "{tick:4} ms  CoM {:.4?} m, ankle roll moment {:.4} m",
                state.com, state.ankle_roll_moment
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
}
