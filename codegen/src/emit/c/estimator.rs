//! The recursive estimator of the base parameters, in float.
//!
//! ```text
//! Σ w (x r − y)² = (r − r̂)ᵀ R̄ᵀ D R̄ (r − r̂) + rest
//! ```
//!
//! The operations are those of the runtime's `Estimator`, in its order: with contraction
//! off both give the same bits.

use minijinja::context;
use minijinja::value::Value;

use super::{Scalar, float};
use crate::Error;
use crate::error::Problem;
use crate::facts::Facts;

/// The estimator as the templates ask for it.
///
/// `corrects`: whether the package has `correct_cop`, which inverts the sensor effects.
///
/// # Errors
/// In fixed point, whose numbers have no room for information.
pub(super) fn texts(facts: &Facts, scalar: Scalar, corrects: bool) -> Result<Value, Error> {
    let number = |x: f64| float::literal(x, scalar);
    let power = |n: i32| number(libm::ldexp(1.0, n));
    let n = facts.model.base.params.len();
    let identified = facts.identified.as_ref();
    let information = identified.and_then(|found| found.information.as_deref());
    let of_scalar = match scalar {
        Scalar::F64 => context! {
            limit => power(100),
            least => power(-200),
            light => power(-100),
            independent => power(-36),
            bits => "uint64_t",
            root => "UINT64_C(0x1ff7a3bea91d9b1b)",
            steps => 4,
            rounds => 6,
            narrow => "1e-30",
            far => "1e30",
        },
        Scalar::F32 => context! {
            limit => power(20),
            least => power(-40),
            light => power(-20),
            independent => power(-17),
            bits => "uint32_t",
            root => "UINT32_C(0x1fbd1df5)",
            steps => 3,
            rounds => 4,
            narrow => "1e-6",
            far => "1e6",
        },
        Scalar::Fixed32 => return Err(Problem::EstimatorInFixed.into()),
    };
    Ok(context! {
        // Numbers in the packed triangle.
        entries => n * (n + 1) / 2,
        corrects,
        // Whether the model file says how well its parameters are known.
        resumes => information.is_some(),
        zero => number(0.0),
        half => number(0.5),
        one => number(1.0),
        two => number(2.0),
        half_root => number(core::f64::consts::FRAC_1_SQRT_2),
        // Levels of sums of errors, and the runtime's `FEWEST` and `CLEAR`² of them.
        levels => 12,
        fewest => number(24.0),
        clear => number(16.0),
        // The runtime's `Scalar::LIMIT`, `LEAST`, `LIGHT` and `INDEPENDENT`; type of a number's
        // bits; half the exponent, so that Newton's method ends in so many steps; times that a
        // row's weight can be below `light` in a row; in words the least deviation and the most
        // of them that is taken.
        ..of_scalar
    })
}
