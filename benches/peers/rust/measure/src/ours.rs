//! Our entry points, all that is measured of the generated module and the tape.
//!
//! Faster ones replace these here; nothing else knows how a function is called.

use std::hint::black_box;

use sesc::evaluate::Evaluator;
use sesc::robot::{OP2_URDF, Robot};
use sesc_codegen::{Function, Model, Snapping};
use sesc_generated::op2_r_sole as op2;
use sesc_runtime::{F32x16, F64x8, Lanes, Real, pack, unpack};

use crate::peers::{Batch, One};

pub use op2::{DOF, JOINT_NAMES};

/// Where the robot stands.
pub const SUPPORT: &str = "r_sole";

/// One posture in double precision.
pub fn one(function: Function) -> One<f64> {
    match function {
        Function::Com => com,
        Function::ComJacobian => jacobian,
        Function::RegressorFull => full,
        _ => cop,
    }
}

/// Many postures in double precision, eight at a time.
pub fn batch_f64(function: Function) -> Batch<f64> {
    match function {
        Function::Com => com_f64,
        Function::ComJacobian => jacobian_f64,
        Function::RegressorFull => full_f64,
        _ => cop_f64,
    }
}

/// Many postures in single precision, sixteen at a time.
pub fn batch_f32(function: Function) -> Batch<f32> {
    match function {
        Function::Com => com_f32,
        Function::ComJacobian => jacobian_f32,
        Function::RegressorFull => full_f32,
        _ => cop_f32,
    }
}

/// The tape: from a URDF at run time, without a compiler.
pub fn tape(function: Function) -> impl Fn(&[f64]) -> Vec<f64> {
    let evaluator = Evaluator::new(&model(), function);
    move |q| evaluator.run(q, q.len() / DOF)
}

pub fn robot() -> Robot {
    Robot::parse(OP2_URDF, "op2.urdf").expect("the embedded OP2 is a robot")
}

pub fn model() -> Model {
    let model = robot().model(SUPPORT, Snapping::default(), None);
    model.expect("the OP2 stands on its right sole")
}

/// Parameters of [`op2::CAD_PARAMS`]'s robot, base and full.
pub fn base_params() -> Vec<f64> {
    op2::CAD_PARAMS.to_vec()
}

pub fn full_params() -> Vec<f64> {
    model().chain.full_cad()
}

/// Parameters come at run time; the compiler must not know them.
fn params<T: Real>() -> [T; op2::BASE_PARAMS] {
    black_box(op2::CAD_PARAMS).map(T::from_f64)
}

macro_rules! one_posture {
    ($name:ident, $rows:ty, |$q:ident| $call:expr) => {
        extern "C" fn $name(q: *const f64, out: *mut f64) {
            // SAFETY: `Peers` hands arrays of these sizes to every contestant.
            let ($q, out) = unsafe { (&*q.cast::<[f64; DOF]>(), &mut *out.cast::<$rows>()) };
            *out = $call;
        }
    };
}

one_posture!(com, [f64; 3], |q| op2::com(q, black_box(&op2::CAD_PARAMS)));
one_posture!(jacobian, [[f64; DOF]; 3], |q| op2::com_jacobian(
    q,
    black_box(&op2::CAD_PARAMS)
));
one_posture!(full, [[f64; op2::FULL_PARAMS]; 3], |q| {
    op2::regressor_full(q)
});
one_posture!(cop, [[f64; op2::BASE_PARAMS]; 2], |q| op2::regressor_cop(q));

macro_rules! batch {
    ($name:ident, $scalar:ty, $lanes:ty, $side:literal, $width:expr, |$q:ident, $r:ident| $call:expr) => {
        extern "C" fn $name(q: *const $scalar, n: usize, out: *mut $scalar) {
            const WIDTH: usize = $width;
            // SAFETY: `Peers` hands arrays of these sizes to every contestant.
            let (q, out) = unsafe {
                (
                    std::slice::from_raw_parts(q.cast::<[$scalar; DOF]>(), n),
                    std::slice::from_raw_parts_mut(out.cast::<[$scalar; WIDTH]>(), n),
                )
            };
            let $r = &params::<$lanes>();
            let (q, rest) = q.as_chunks::<$side>();
            assert!(rest.is_empty(), "batches are whole numbers of lanes");
            let (out, _) = out.as_chunks_mut::<$side>();
            for (q, out) in q.iter().zip(out) {
                let $q = &pack(q);
                let columns: [$lanes; WIDTH] = $call;
                *out = unpack(&columns);
            }
        }
    };
}

/// Rows as one array.
fn flat<S: Real, const N: usize, const COLUMNS: usize, const ROWS: usize, const WIDTH: usize>(
    rows: [[Lanes<S, N>; COLUMNS]; ROWS],
) -> [Lanes<S, N>; WIDTH] {
    std::array::from_fn(|k| rows[k / COLUMNS][k % COLUMNS])
}

macro_rules! batches {
    ($scalar:ty, $lanes:ty, $side:literal, $com:ident, $jacobian:ident, $full:ident, $cop:ident) => {
        batch!($com, $scalar, $lanes, $side, 3, |q, r| op2::com(q, r));
        batch!($jacobian, $scalar, $lanes, $side, 3 * DOF, |q, r| {
            flat(op2::com_jacobian(q, r))
        });
        batch!(
            $full,
            $scalar,
            $lanes,
            $side,
            3 * op2::FULL_PARAMS,
            |q, _r| flat(op2::regressor_full(q))
        );
        batch!(
            $cop,
            $scalar,
            $lanes,
            $side,
            2 * op2::BASE_PARAMS,
            |q, _r| flat(op2::regressor_cop(q))
        );
    };
}

batches!(f64, F64x8, 8, com_f64, jacobian_f64, full_f64, cop_f64);
batches!(f32, F32x16, 16, com_f32, jacobian_f32, full_f32, cop_f32);
