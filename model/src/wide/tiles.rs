//! Squares of four by four numbers, their rows as columns, in registers of 256 bits.
//!
//! ```text
//! a0 a1 a2 a3        a0 a1 c0 c1        a0 b0 c0 d0
//! b0 b1 b2 b3   ─▶   b0 b1 d0 d1   ─▶   a1 b1 c1 d1
//! c0 c1 c2 c3        a2 a3 c2 c3        a2 b2 c2 d2
//! d0 d1 d2 d3        b2 b3 d2 d3        a3 b3 c3 d3
//! ```
//!
//! The compiler makes sixteen loads of one number each of the same in plain Rust.

/// Numbers in a side of a square.
pub(crate) const SIDE: usize = 4;

/// Lines of a square.
pub(crate) type Lines<'a> = [&'a [f64; SIDE]; SIDE];
/// Lines that columns are written to.
pub(crate) type LinesMut<'a> = [&'a mut [f64; SIDE]; SIDE];
/// What each of the lines is multiplied by.
pub(crate) type Factors<'a> = &'a [f64; SIDE];

/// Work on many squares.
pub(crate) trait Tiles {
    /// Do it; `#[inline(always)]`. `tile` takes four lines, multiplies each by its factor and
    /// writes their columns to four others; it is called at one place, where it is compiled.
    fn run(self, tile: impl Fn([&[f64; SIDE]; SIDE], &[f64; SIDE], [&mut [f64; SIDE]; SIDE]));
}

/// Do the work in the registers that this processor has.
#[allow(unsafe_code)]
pub(crate) fn tiled(work: impl Tiles) {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor and the system have AVX2, and AVX with it.
        return unsafe { x86::run(work) };
    }
    work.run(|from, factors, to| {
        for (k, to) in to.into_iter().enumerate() {
            *to = std::array::from_fn(|j| from[j][k] * factors[j]);
        }
    });
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    use super::{Factors, Lines, LinesMut, SIDE, Tiles};

    #[target_feature(enable = "avx2")]
    pub(super) fn run(work: impl Tiles) {
        work.run(|from, factors, to| tile(from, factors, to));
    }

    #[target_feature(enable = "avx2")]
    #[inline]
    #[allow(unsafe_code)]
    fn tile(from: Lines, factors: Factors, to: LinesMut) {
        let half = |line: &[f64; SIDE], start: usize| _mm_set_pd(line[start + 1], line[start]);
        let halves = |low: &[f64; SIDE], high: &[f64; SIDE], start: usize| {
            _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(half(low, start)), half(high, start))
        };
        let [a, b, c, d] = from;
        let [ac, bd] = [halves(a, c, 0), halves(b, d, 0)];
        let [ca, db] = [halves(a, c, 2), halves(b, d, 2)];
        let columns = [
            _mm256_unpacklo_pd(ac, bd),
            _mm256_unpackhi_pd(ac, bd),
            _mm256_unpacklo_pd(ca, db),
            _mm256_unpackhi_pd(ca, db),
        ];
        let [p, q, r, s] = *factors;
        let factors = _mm256_setr_pd(p, q, r, s);
        for (to, column) in to.into_iter().zip(columns) {
            // SAFETY: there is room for four numbers.
            unsafe { _mm256_storeu_pd(to.as_mut_ptr(), _mm256_mul_pd(column, factors)) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct One([[f64; SIDE]; SIDE]);

    impl Tiles for &mut One {
        #[inline(always)]
        fn run(self, tile: impl Fn([&[f64; SIDE]; SIDE], &[f64; SIDE], [&mut [f64; SIDE]; SIDE])) {
            let from = self.0;
            tile(from.each_ref(), &[1.0, -1.0, 2.0, 1.0], self.0.each_mut());
        }
    }

    #[test]
    fn rows_become_columns() {
        let mut one = One([0.0, 4.0, 8.0, 12.0].map(|x| [x, x + 1.0, x + 2.0, x + 3.0]));
        tiled(&mut one);
        let columns = [0.0, 1.0, 2.0, 3.0].map(|x| [x, -(x + 4.0), 2.0 * (x + 8.0), x + 12.0]);
        assert_eq!(one.0, columns);
    }
}
