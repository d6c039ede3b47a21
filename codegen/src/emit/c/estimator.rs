//! The recursive estimator of the base parameters, in float.
//!
//! ```text
//! Σ w (x r − y)² = (r − r̂)ᵀ R̄ᵀ D R̄ (r − r̂) + rest
//! ```
//!
//! The operations are those of the runtime's `Estimator`, in its order: with contraction
//! off both give the same bits.

use minijinja::value::{Serde, Value};
use serde::Serialize;

use super::{Scalar, float};
use crate::Error;
use crate::error::Problem;
use crate::facts::Facts;

/// What the templates need to know of it.
#[derive(Debug, Clone, Serialize)]
struct Texts {
    /// Numbers in the packed triangle.
    entries: usize,
    /// Whether the model has sensor effects, which a reading is freed of.
    corrects: bool,
    /// Whether the model file says how well its parameters are known.
    resumes: bool,
    zero: String,
    half: String,
    one: String,
    two: String,
    /// 1/√2.
    half_root: String,
    /// Levels of sums of errors, and the runtime's `FEWEST` and `CLEAR`² of them.
    levels: usize,
    fewest: String,
    clear: String,
    /// The runtime's `Scalar::LIMIT`, `LEAST`, `LIGHT` and `INDEPENDENT`.
    limit: String,
    least: String,
    light: String,
    independent: String,
    /// Type of a number's bits.
    bits: &'static str,
    /// Half the exponent, so that Newton's method ends in so many steps.
    root: &'static str,
    steps: u32,
    /// Times that a row's weight can be below `light` in a row.
    rounds: u32,
    /// In words: the least deviation and the most of them that is taken.
    narrow: &'static str,
    far: &'static str,
}

/// The estimator as the templates ask for it.
///
/// `corrects`: whether the package has `correct_cop`, which inverts the sensor effects.
///
/// # Errors
/// In fixed point, whose numbers have no room for information.
pub(super) fn texts(facts: &Facts, scalar: Scalar, corrects: bool) -> Result<Value, Error> {
    let power = |n: i32| float::literal(libm::ldexp(1.0, n), scalar);
    let n = facts.params.len();
    let identified = facts.identified.as_ref();
    let information = identified.and_then(|found| found.information.as_deref());
    let texts = Texts {
        entries: n * (n + 1) / 2,
        corrects,
        resumes: information.is_some(),
        zero: float::literal(0.0, scalar),
        half: float::literal(0.5, scalar),
        one: float::literal(1.0, scalar),
        two: float::literal(2.0, scalar),
        half_root: float::literal(core::f64::consts::FRAC_1_SQRT_2, scalar),
        levels: 12,
        fewest: float::literal(24.0, scalar),
        clear: float::literal(16.0, scalar),
        limit: String::new(),
        least: String::new(),
        light: String::new(),
        independent: String::new(),
        bits: "uint64_t",
        root: "UINT64_C(0x1ff7a3bea91d9b1b)",
        steps: 4,
        rounds: 6,
        narrow: "1e-30",
        far: "1e30",
    };
    let texts = match scalar {
        Scalar::F64 => Texts {
            limit: power(100),
            least: power(-200),
            light: power(-100),
            independent: power(-36),
            ..texts
        },
        Scalar::F32 => Texts {
            limit: power(20),
            least: power(-40),
            light: power(-20),
            independent: power(-17),
            bits: "uint32_t",
            root: "UINT32_C(0x1fbd1df5)",
            steps: 3,
            rounds: 4,
            narrow: "1e-6",
            far: "1e6",
            ..texts
        },
        Scalar::Fixed32 => return Err(Problem::EstimatorInFixed.into()),
    };
    Ok(Value::from(Serde(texts)))
}
