//! Our entry points, all that is measured of the generated module and the tape.
//!
//! Faster ones replace these here; nothing else knows how a function is called.

use std::hint::black_box;
use std::sync::LazyLock;

use sesc_codegen::{Builder, Scalar};
use sesc_identify::evaluate::Evaluator;
use sesc::OP2_URDF;
use sesc_identify::robot::Robot;
use sesc_model::{Function, Model, Snapping};
use sesc_generated::op2_r_sole::{self as op2, Op2RSole};
use sesc_runtime::{Batch as _, F32x16, F64x8, Simd, Single as _, pack};

/// One posture.
pub type One<T> = extern "C" fn(*const T, *mut T);

pub use op2::{DOF, JOINT_NAMES};

/// Where the robot stands.
pub const SUPPORT: &str = "r_sole";

macro_rules! batches {
    ($function:expr, $q:expr, $scalar:ty, $lanes:ty, $side:literal) => {{
        let (q, rest) = $q.as_chunks::<DOF>();
        assert!(rest.is_empty(), "postures are whole");
        let (q, rest) = q.as_chunks::<$side>();
        assert!(rest.is_empty(), "batches are whole numbers of lanes");
        let q: Vec<[$lanes; DOF]> = q.iter().map(pack).collect();
        let r: [$scalar; op2::BASE_PARAMS] = op2::CAD_PARAMS.map(|x| x as $scalar);
        let zero = <$lanes>::splat(0.0);
        macro_rules! blocks {
            ($start:expr, $run:expr, |$out:ident| $flat:expr) => {{
                let out = vec![$start; q.len()];
                Box::new(Blocks {
                    q,
                    r,
                    out,
                    run: $run,
                    lane: |$out, k| $flat.iter().map(|x| x.0[k] as f64).collect(),
                    lanes: $side,
                })
            }};
        }
        match $function {
            Function::Com => blocks!(
                [zero; 3],
                |q, r, out| Op2RSole::com_batch(simd(), q, r, out),
                |out| out
            ),
            Function::ComJacobian => blocks!(
                [[zero; DOF]; 3],
                |q, r, out| Op2RSole::com_jacobian_batch(simd(), q, r, out),
                |out| out.as_flattened()
            ),
            Function::RegressorFull => blocks!(
                [[zero; op2::FULL_PARAMS]; 3],
                |q, _, out| Op2RSole::regressor_full_batch(simd(), q, out),
                |out| out.as_flattened()
            ),
            _ => blocks!(
                [[zero; op2::BASE_PARAMS]; 2],
                |q, _, out| Op2RSole::regressor_cop_batch(simd(), q, out),
                |out| out.as_flattened()
            ),
        }
    }};
}

/// One posture in double precision.
pub fn one(function: Function) -> One<f64> {
    match function {
        Function::Com => com,
        Function::ComJacobian => jacobian,
        Function::RegressorFull => full,
        _ => cop,
    }
}

/// Blocks of postures and of results, in the layout that batches have.
pub trait Batches {
    fn run(&mut self);

    /// The results, posture by posture.
    fn answers(&self) -> Vec<f64>;
}

/// Many postures in double precision, eight at a time.
pub fn batch_f64(function: Function, q: &[f64]) -> Box<dyn Batches> {
    batches!(function, q, f64, F64x8, 8)
}

/// Many postures in single precision, sixteen at a time.
pub fn batch_f32(function: Function, q: &[f32]) -> Box<dyn Batches> {
    batches!(function, q, f32, F32x16, 16)
}

/// The tape: from a URDF at run time, without a compiler.
pub fn tape(function: Function) -> impl Fn(&[f64], &mut [f64]) {
    let evaluator = Evaluator::new(&model(), function).fastest();
    move |q, out| evaluator.run_into(q, q.len() / DOF, out)
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

macro_rules! one_posture {
    ($name:ident, $rows:ty, |$q:ident, $out:ident| $call:expr) => {
        extern "C" fn $name($q: *const f64, $out: *mut f64) {
            // SAFETY: `Peers` hands arrays of these sizes to every contestant.
            let ($q, $out) = unsafe { (&*$q.cast::<[f64; DOF]>(), &mut *$out.cast::<$rows>()) };
            $call;
        }
    };
}

one_posture!(com, [f64; 3], |q, out| *out =
    Op2RSole::com_single(simd(), q, params()));
one_posture!(jacobian, [[f64; DOF]; 3], |q, out| {
    Op2RSole::com_jacobian_single_into(simd(), q, params(), out)
});
one_posture!(full, [[f64; op2::FULL_PARAMS]; 3], |q, out| {
    Op2RSole::regressor_full_single_into(simd(), q, out)
});
one_posture!(cop, [[f64; op2::BASE_PARAMS]; 2], |q, out| {
    Op2RSole::regressor_cop_single_into(simd(), q, out)
});

/// Asked once, as a controller does.
pub fn simd() -> Simd {
    static BEST: LazyLock<Simd> = LazyLock::new(Simd::best);
    *BEST
}

/// Parameters come at run time; the compiler must not know them.
fn params() -> &'static [f64; op2::BASE_PARAMS] {
    black_box(&op2::CAD_PARAMS)
}

/// A function over blocks, and where its results go.
struct Blocks<Q, R, O> {
    q: Vec<Q>,
    r: R,
    out: Vec<O>,
    run: fn(&[Q], &R, &mut [O]),
    lane: fn(&O, usize) -> Vec<f64>,
    lanes: usize,
}

impl<Q, R, O> Batches for Blocks<Q, R, O> {
    fn run(&mut self) {
        (self.run)(&self.q, black_box(&self.r), &mut self.out);
        black_box(&mut self.out);
    }

    fn answers(&self) -> Vec<f64> {
        let lanes = self.lanes;
        let blocks = self.out.iter();
        blocks
            .flat_map(|block| (0..lanes).flat_map(|k| (self.lane)(block, k)))
            .collect()
    }
}

/// Our C for computers, in f64 and f32, as `lanes_f64` and `lanes_f32` in `folder`.
pub fn write_c(folder: &str, urdf: &str) -> Result<(), String> {
    for (name, scalar) in [("lanes_f64", Scalar::F64), ("lanes_f32", Scalar::F32)] {
        let builder = Builder::new(urdf).support(SUPPORT).name(name).out_dir(folder);
        let builder = builder.c99(folder).scalar(scalar).lanes(16);
        builder.emit().map_err(|error| error.to_string())?;
    }
    Ok(())
}
