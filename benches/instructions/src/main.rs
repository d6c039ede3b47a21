//! Calls one function of the OP2 once; callgrind counts between its entry and its return.

use std::hint::black_box;

use sesc_generated::op2_r_sole::{
    self as op2, BASE_PARAMS, CAD_PARAMS, DOF, Op2RSole, SELF_TEST_Q,
};
use sesc_runtime::{Batch as _, F64x8, Real, Simd, Single as _};

type Q = [f64; DOF];
type R = [f64; BASE_PARAMS];

/// Functions of a name that callgrind can be told.
macro_rules! counted {
    ($($name:ident: $argument:ty => $result:ty = |$q:ident, $r:ident| $call:expr;)+) => {
        $(
            #[inline(never)]
            #[unsafe(no_mangle)]
            fn $name($q: &$argument, $r: &R, out: &mut $result) {
                *out = $call;
            }
        )+
    };
}

counted! {
    com: Q => [f64; 3] = |q, r| op2::com(q, r);
    com_jacobian: Q => [[f64; DOF]; 3] = |q, r| op2::com_jacobian(q, r);
    // Joint velocities as large as the angles.
    com_velocity: Q => [f64; 3] = |q, r| op2::com_velocity(q, q, r);
    // And accelerations.
    zmp: Q => [f64; 2] = |q, r| op2::zmp(q, q, q, r);
    gravity_moments: Q => [f64; DOF] = |q, r| op2::gravity_moments(q, r);
    regressor_cop: Q => [[f64; BASE_PARAMS]; 2] = |q, _r| op2::regressor_cop(q);
    com_f32: [f32; DOF] => [f32; 3] = |q, r| op2::com(q, &r.map(|x| x as f32));
    com_single: Q => [f64; 3] = |q, r| Op2RSole::com_single(Simd::PORTABLE, q, r);
    com_batch: [F64x8; DOF] => [F64x8; 3] = |q, r| {
        let mut com = [[F64x8::splat(0.0); 3]];
        Op2RSole::com_batch(Simd::PORTABLE, core::slice::from_ref(q), r, &mut com);
        com[0]
    };
}

fn call<A, T: Copy>(f: fn(&A, &R, &mut T), q: A, start: T) {
    let mut out = start;
    f(black_box(&q), black_box(&CAD_PARAMS), &mut out);
    black_box(out);
}

fn main() {
    let q = SELF_TEST_Q;
    let zero = F64x8::splat(0.0);
    match std::env::args().nth(1).as_deref() {
        Some("com") => call(com, q, [0.0; 3]),
        Some("com_jacobian") => call(com_jacobian, q, [[0.0; DOF]; 3]),
        Some("com_velocity") => call(com_velocity, q, [0.0; 3]),
        Some("zmp") => call(zmp, q, [0.0; 2]),
        Some("gravity_moments") => call(gravity_moments, q, [0.0; DOF]),
        Some("regressor_cop") => call(regressor_cop, q, [[0.0; BASE_PARAMS]; 2]),
        Some("com_f32") => call(com_f32, q.map(|x| x as f32), [0.0; 3]),
        Some("com_single") => call(com_single, q, [0.0; 3]),
        Some("com_batch") => call(com_batch, q.map(<F64x8 as Real>::from_f64), [zero; 3]),
        other => panic!("no function {other:?}"),
    }
}
