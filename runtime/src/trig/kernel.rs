//! The algorithm, once for both formats: a module names its scalar and the constants, and gets
//! `sin_cos`.

/// Defines `sin_cos(x)` for the scalar `$real` with bits in `$bits`.
macro_rules! kernel {
    ($real:ty, $bits:ty) => {
        #[inline(always)]
        pub(crate) fn sin_cos(x: $real) -> ($real, $real) {
            let sign = x.to_bits() & SIGN;
            let magnitude = x.to_bits() ^ sign;
            // Bit patterns of magnitudes are ordered as the magnitudes are, NaN last.
            let room = LIMIT_RAD.to_bits().wrapping_sub(magnitude).cast_signed();
            let outside = (room >> (<$bits>::BITS - 1)).cast_unsigned() & NAN;

            let x = <$real>::from_bits(magnitude);
            let shifted = x * FRAC_2_PI + MAGIC;
            let quadrant = shifted.to_bits();
            let k = shifted - MAGIC;

            let a = x - k * P1;
            let b = k * P2;
            let h = a - b;
            let h_lost = (a - h) - b;
            let c = k * P3;
            let r = h - c;
            let r_lost = (h - r) - c;
            let tail = (h_lost + r_lost) - k * P4;

            let (sin, cos) = kernel(r, tail);

            // Odd quadrants swap the two; sin < 0 in 2 and 3, cos < 0 in 1 and 2.
            let odd = (quadrant & 1).wrapping_neg();
            let swap = (sin.to_bits() ^ cos.to_bits()) & odd;
            let sin_sign = sign ^ ((quadrant & 2) << (<$bits>::BITS - 2));
            let cos_sign = (quadrant.wrapping_add(1) & 2) << (<$bits>::BITS - 2);
            (
                <$real>::from_bits((sin.to_bits() ^ swap ^ sin_sign) | outside),
                <$real>::from_bits((cos.to_bits() ^ swap ^ cos_sign) | outside),
            )
        }

        /// Sine and cosine of `r + tail`, |r| <= π/4 and the tail below an ulp or so of `r`.
        ///
        /// The tail enters to first order; the large term of each sum is added last.
        #[inline(always)]
        fn kernel(r: $real, tail: $real) -> ($real, $real) {
            let z = r * r;
            let z2 = z * z;
            let half_z = 0.5 * z;
            let w = 1.0 - half_z;
            let sin = r + (z * r * polynomial(&SIN, z, z2) + tail * w);
            let cos = w + (((1.0 - w) - half_z) + (z2 * polynomial(&COS, z, z2) - r * tail));
            (sin, cos)
        }
    };
}

pub(super) use kernel;
