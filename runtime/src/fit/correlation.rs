//! How long the noise of readings lasts, from the errors of predictions, as postures come.
//!
//! ```text
//! w_k = (cop_k − Y_k r̂_{k−1})/√(s² + Y_k P_{k−1} Y_kᵀ)      z⁰ = w      z^{l+1} = (z^l_{2k−1} + z^l_{2k})/√2
//! n/n_eff = max_l mean (z^l)²/mean (z⁰)²
//! ```
//!
//! Errors w of predictions from the postures before are independent of each other where the
//! noise is (Brown, Durbin and Evans, J. R. Stat. Soc. B 37, 1975), whatever the fit has taken
//! up. Sums over 2^l of them keep their variance then; where noise lasts, it grows with l until
//! 2^l postures outlast the noise (Flyvbjerg and Petersen, J. Chem. Phys. 91, 1989). A level
//! counts where it is above the first one beyond chance, of [`FEWEST`] sums and more.

use crate::scalar::Scalar;

/// Sums of up to 2^(LEVELS − 1) postures.
const LEVELS: usize = 12;
/// Sums of a level that say something, at least.
const FEWEST: f64 = 24.0;
/// Standard deviations by which a level must exceed the first.
const CLEAR: f64 = 4.0;

/// Errors of predictions of one axis, summed over ever more postures.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Correlation<T> {
    levels: [Level<T>; LEVELS],
    /// Errors that came; its binary digits say which levels wait for a second one.
    count: u32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Level<T> {
    waiting: T,
    /// Σ z², faded.
    squares: T,
    /// Number of these, faded.
    sums: T,
}

impl<T: Scalar> Correlation<T> {
    pub(super) const EMPTY: Self = Self {
        levels: [Level {
            waiting: T::ZERO,
            squares: T::ZERO,
            sums: T::ZERO,
        }; LEVELS],
        count: 0,
    };

    /// The error of a prediction over its deviation; what came before counts `lambda` times.
    pub(super) fn push(&mut self, error: T, lambda: T) {
        let half = T::from_f64(core::f64::consts::FRAC_1_SQRT_2);
        let (mut z, mut fade) = (error, lambda);
        let mut waits = self.count;
        self.count = self.count.wrapping_add(1);
        for level in &mut self.levels {
            level.squares = level.squares * fade + z * z;
            level.sums = level.sums * fade + T::ONE;
            if waits & 1 == 0 {
                level.waiting = z;
                return;
            }
            z = (level.waiting + z) * half;
            fade = fade * fade;
            waits >>= 1;
        }
    }

    /// Postures per independent one, 1 and more.
    pub(super) fn postures_per_sample(&self) -> f64 {
        let mean = |level: &Level<T>| level.squares.to_f64() / level.sums.to_f64();
        let [first, above @ ..] = &self.levels;
        let known = |level: &&Level<T>| level.sums.to_f64() >= FEWEST;
        let mut most = 1.0;
        for level in above.iter().take_while(known) {
            let ratio = mean(level) / mean(first);
            // A mean of n squares of normal numbers has the variance 2/n.
            let (off, variance) = (ratio - 1.0, 2.0 / level.sums.to_f64());
            if ratio > most && off * off > CLEAR * CLEAR * variance {
                most = ratio;
            }
        }
        most
    }

    /// Take over the sums of another log.
    pub(super) fn merge(&mut self, other: &Self) {
        for (level, more) in self.levels.iter_mut().zip(&other.levels) {
            level.squares = level.squares + more.squares;
            level.sums = level.sums + more.sums;
        }
    }
}
