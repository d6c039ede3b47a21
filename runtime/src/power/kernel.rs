//! The algorithm, once for both formats: a module names its scalar and the
//! constants, and gets `power`.

/// Defines `power(x, y)` for the scalar `$real` with bits in `$bits`.
macro_rules! kernel {
    ($real:ty, $bits:ty) => {
        #[inline]
        pub(super) fn power(x: $real, y: $real) -> $real {
            // -0 counts as 0. Bit patterns are ordered as magnitudes are; negative
            // numbers, with their sign bit on top, come after infinity as NaN does.
            let bits = (x + 0.0).to_bits();
            let sign = y.to_bits() & SIGN;
            let size = y.to_bits() ^ sign;
            let nan = mask(bits > INFINITY) | mask(size > INFINITY);

            // x = 2^k m; a sum with 2^52 (2^23) shows the exponent as a number.
            let small = mask(bits < LEAST);
            let scale = <$real>::from_bits(select(small, SCALE, ONE));
            let scaled = (<$real>::from_bits(bits) * scale).to_bits();
            let exponent = scaled.wrapping_add(ONE - ROOT) >> MANTISSA;
            let counted = <$real>::from_bits(COUNT.to_bits() | exponent) - (COUNT + BIAS);
            let k = counted - <$real>::from_bits(SCALED_BY.to_bits() & small);
            let m = <$real>::from_bits(scaled.wrapping_add(ONE).wrapping_sub(exponent << MANTISSA));

            // s = (m - 1)/(m + 1)
            let f = m - 1.0;
            let g = m + 1.0;
            let g_low = m - (g - 1.0);
            let s = f / g;
            let p = s * g;
            let s_low = (((f - p) - lost(s, g, p)) - s * g_low) / g;

            // atanh(s) = s + s c,  c = z/3 + z^2 P(z),  z = s^2
            let z = s * s;
            let z_low = lost(s, s, z) + (s * s_low) * 2.0;
            let t = z * THIRD.0;
            let t_low = lost(z, THIRD.0, t) + (z_low * THIRD.0 + z * THIRD.1);
            let series = polynomial(&P, z);
            let q = (z * z) * series;
            let c = t + q;
            let c_low = (q - (c - t)) + (t_low + (z_low * z) * (series * 2.0));
            let u = s * c;
            let u_low = lost(s, c, u) + (s * c_low + s_low * c);
            let a = s + u;
            let a_low = (u - (a - s)) + (u_low + s_low);

            // log2 x = k + 2/ln 2 atanh(s)
            let b = a * TWO_OVER_LN_2.0;
            let b_low =
                lost(a, TWO_OVER_LN_2.0, b) + (a * TWO_OVER_LN_2.1 + a_low * TWO_OVER_LN_2.0);
            let l = k + b;
            let l_low = (b - (l - k)) + b_low;

            // w = y log2 x, where the result is neither zero nor infinite for sure.
            let y = <$real>::from_bits(size.min(LARGEST.to_bits()) | sign);
            let w = y * l;
            let w_sign = w.to_bits() & SIGN;
            let w_size = w.to_bits() ^ w_sign;
            let far = mask(w_size > FAR.to_bits());
            let w_low = <$real>::from_bits((lost(y, l, w) + y * l_low).to_bits() & !far);
            let w = <$real>::from_bits(select(far, FAR.to_bits(), w_size) | w_sign);

            // w = n + r;  2^r = 1 + t + (t^2/2 + t^3 Q(t)),  t = r ln 2
            let shifted = w + MAGIC;
            let rest = w - (shifted - MAGIC);
            let r = rest + w_low;
            let r_low = w_low - (r - rest);
            let t = r * LN_2.0;
            let t_low = lost(r, LN_2.0, t) + (r * LN_2.1 + r_low * LN_2.0);
            let e = 1.0 + t;
            let e_low = t - (e - 1.0);
            let t2 = t * t;
            let tail = t2 * 0.5 + (t2 * t) * polynomial(&Q, t);
            let root = e + (e_low + (tail + t_low * e));

            // 2^n in two steps: each is a normal number, and only the last product rounds.
            let n = shifted
                .to_bits()
                .wrapping_sub(MAGIC.to_bits())
                .wrapping_add(2 * (ONE >> MANTISSA));
            let half = n >> 1;
            let first = <$real>::from_bits(half << MANTISSA);
            let second = <$real>::from_bits((n - half) << MANTISSA);
            let found = ((root * first) * second).to_bits();

            // 0^y and inf^y: one for y = 0, else zero or infinity.
            let endless = mask(bits == INFINITY);
            let edge = endless | mask(bits == 0);
            let grows = endless ^ mask(sign != 0);
            let limit = select(mask(size == 0), ONE, INFINITY & grows);
            <$real>::from_bits(select(edge, limit, found) | (nan & NAN))
        }

        /// What rounding lost of the product `p` of `a` and `b`.
        #[inline(always)]
        fn lost(a: $real, b: $real, p: $real) -> $real {
            let (a_high, b_high) = (high(a), high(b));
            let (a_low, b_low) = (a - a_high, b - b_high);
            ((a_high * b_high - p) + (a_high * b_low + a_low * b_high)) + a_low * b_low
        }

        /// The upper half of a mantissa: products of halves are exact.
        #[inline(always)]
        fn high(x: $real) -> $real {
            <$real>::from_bits(x.to_bits() & UPPER)
        }

        /// `Σ c_i z^i` by Horner's rule.
        #[inline(always)]
        fn polynomial<const N: usize>(c: &[$real; N], z: $real) -> $real {
            let (last, rest) = c.split_last().expect("polynomials have coefficients");
            rest.iter().rev().fold(*last, |sum, c| *c + z * sum)
        }

        /// All ones where `condition` holds.
        #[inline(always)]
        fn mask(condition: bool) -> $bits {
            <$bits>::from(condition).wrapping_neg()
        }

        /// `a` where the mask is set, `b` elsewhere.
        #[inline(always)]
        fn select(mask: $bits, a: $bits, b: $bits) -> $bits {
            b ^ ((a ^ b) & mask)
        }
    };
}

pub(super) use kernel;
