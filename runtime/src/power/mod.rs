//! Powers of numbers that are not negative, in straight-line arithmetic.
//!
//! ```text
//! x = 2^k m       √½ <= m < √2,  s = (m - 1)/(m + 1)
//! log2 x = k + 2/ln 2 (s + s^3/3 + s^5/5 + …)
//! x^y = 2^n e^t   y log2 x = n + t/ln 2,  |t| <= ln 2 / 2
//! ```
//!
//! The logarithm and its product with `y` are sums of two numbers, the second
//! holding what rounding lost of the first: an error of `y log2 x`, which may be
//! a thousand, becomes a relative error of the power. What happens to be a number
//! of the format (`x^1`, small whole powers, roots of squares) is found exactly,
//! because all that comes before the last rounding errs by much less than half an
//! ulp.
//!
//! | scalar | error   | largest measured                                       |
//! |--------|---------|--------------------------------------------------------|
//! | `f64`  | 0.7 ulp | 0.617 at 2.5·10^6 random points, some near each edge   |
//! | `f32`  | 0.7 ulp | 0.627 at 1.2·10^8 random points, some near each edge   |
//!
//! An ulp is a unit in the last place of the true value; below the smallest
//! normal number the result is rounded once more, within one unit of that grid.
//!
//! | x        | y < 0 | y = 0 | y > 0 |
//! |----------|-------|-------|-------|
//! | 0, -0    | ∞     | 1     | 0     |
//! | 1        | 1     | 1     | 1     |
//! | ∞        | 0     | 1     | ∞     |
//! | negative | NaN   | NaN   | NaN   |
//!
//! NaN in either place gives NaN. Like [`trig`](crate::trig), nothing branches,
//! calls or looks up, so a loop over an array becomes vector code and every
//! machine and every lane gives the same bits.

mod double;
mod kernel;
mod single;
#[cfg(test)]
mod tests;

/// `x` to the power of `y`, within 0.7 ulp, for `x` not negative (else NaN).
///
/// ```
/// use sesc_runtime::power;
///
/// assert_eq!(power::power(2.25, 1.5), 3.375);
/// assert_eq!(power::power(0.0, 0.5), 0.0);
/// assert!(power::power(-1.0, 2.0).is_nan());
/// ```
#[inline]
pub fn power(x: f64, y: f64) -> f64 {
    double::power(x, y)
}

/// `x` to the power of `y`, within 0.7 ulp, for `x` not negative (else NaN).
///
/// ```
/// use sesc_runtime::power;
///
/// assert_eq!(power::power_f32(2.25, 1.5), 3.375);
/// ```
#[inline]
pub fn power_f32(x: f32, y: f32) -> f32 {
    single::power(x, y)
}

/// Powers `x[i]^y[i]`, each what [`power`] gives, written to `out`.
///
/// ```
/// use sesc_runtime::power;
///
/// let mut out = [0.0; 2];
/// power::power_block(&[4.0, 9.0], &[0.5, 0.5], &mut out);
/// assert_eq!(out, [2.0, 3.0]);
/// ```
// Always: a caller compiled for wider registers gets the loop in those.
#[inline(always)]
pub fn power_block<const N: usize>(x: &[f64; N], y: &[f64; N], out: &mut [f64; N]) {
    for ((x, y), out) in x.iter().zip(y).zip(out) {
        *out = power(*x, *y);
    }
}
