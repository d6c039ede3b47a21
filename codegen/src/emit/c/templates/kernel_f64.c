#ifdef {{ name }}_USE_LIBM

static void {{ name }}_sincos(double x, double *sine, double *cosine)
{
    *sine = sin(x);
    *cosine = cos(x);
}

#else

{% include "bits.c" %}

/*
 * Sine and cosine of x rad, each within 0.9 ulp for |x| <= 2^20, NaN beyond.
 *
 *     pi/2 = P1 + P2 + P3 + P4     33, 33, 33 and 53 bits
 *     r    = (((|x| - k P1) - k P2) - k P3) - k P4
 *
 * The first three products are exact. No branch, no call, no conversion.
 */
static void {{ name }}_sincos(double x, double *sine, double *cosine)
{
    const uint64_t all = {{ name }}_bits_of(x);
    const uint64_t sign = all & ((uint64_t)1 << 63);
    const uint64_t magnitude = all ^ sign;
    /* Bit patterns of magnitudes are ordered as the magnitudes are, NaN last. */
    const uint64_t outside = ((uint64_t)0 - ((UINT64_C(0x4130000000000000) - magnitude) >> 63)) & UINT64_C(0x7FF8000000000000);

    /* k = round(|x| 2/pi), its low bits seen through a sum that has no room for a fraction. */
    const double y = {{ name }}_from_bits(magnitude);
    const double shifted = (y * 0.6366197723675814) + 6755399441055744.0;
    const uint64_t quadrant = {{ name }}_bits_of(shifted);
    const double k = shifted - 6755399441055744.0;

    const double a = y - (k * 1.5707963267341256);
    const double b = k * 6.077100506303966e-11;
    const double h = a - b;
    const double h_lost = (a - h) - b;
    const double c = k * 2.0222662487111665e-21;
    const double r = h - c;
    const double r_lost = (h - r) - c;
    const double tail = (h_lost + r_lost) - (k * 8.4784276603689e-32);

    const double z = r * r;
    const double z2 = z * z;
    const double half_z = 0.5 * z;
    const double w = 1.0 - half_z;
    const double odd_terms = (-0.1666666666666663 + (0.00833333333332184 * z))
        + (z2 * ((-0.00019841269829358522 + (2.7557313538511096e-06 * z)) + (z2 * (-2.5050734388633495e-08 + (1.5895433246246603e-10 * z)))));
    const double even_terms = (0.041666666666666595 + (-0.0013888888888873342 * z))
        + (z2 * ((2.48015872890021e-05 + (-2.7557314217051587e-07 * z)) + (z2 * (2.0875705398667983e-09 + (-1.1358749420488109e-11 * z)))));
    const double s = r + (((z * r) * odd_terms) + (tail * w));
    const double co = w + (((1.0 - w) - half_z) + ((z2 * even_terms) - (r * tail)));

    /* Odd quadrants swap the two; sin < 0 in 2 and 3, cos < 0 in 1 and 2. */
    const uint64_t odd = (uint64_t)0 - (quadrant & (uint64_t)1);
    const uint64_t s_bits = {{ name }}_bits_of(s);
    const uint64_t c_bits = {{ name }}_bits_of(co);
    const uint64_t swap = (s_bits ^ c_bits) & odd;
    const uint64_t s_sign = sign ^ ((quadrant & (uint64_t)2) << 62);
    const uint64_t c_sign = ((quadrant + (uint64_t)1) & (uint64_t)2) << 62;
    *sine = {{ name }}_from_bits(((s_bits ^ swap) ^ s_sign) | outside);
    *cosine = {{ name }}_from_bits(((c_bits ^ swap) ^ c_sign) | outside);
}

#endif
