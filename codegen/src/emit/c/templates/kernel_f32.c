#ifdef {{ name }}_USE_LIBM

static void {{ name }}_sincos(float x, float *sine, float *cosine)
{
    *sine = sinf(x);
    *cosine = cosf(x);
}

#else

{% include "bits.c" %}

/*
 * Sine and cosine of x rad, each within 0.85 ulp for |x| <= 1024, NaN beyond.
 *
 *     pi/2 = P1 + P2 + P3 + P4     14, 14, 14 and 24 bits
 *     r    = (((|x| - k P1) - k P2) - k P3) - k P4
 *
 * The first three products are exact. No branch, no call, no conversion.
 */
static void {{ name }}_sincos(float x, float *sine, float *cosine)
{
    const uint32_t all = {{ name }}_bits_of(x);
    const uint32_t sign = all & 0x80000000u;
    const uint32_t magnitude = all ^ sign;
    /* Bit patterns of magnitudes are ordered as the magnitudes are, NaN last. */
    const uint32_t outside = (0u - ((0x44800000u - magnitude) >> 31)) & 0x7FC00000u;

    /* k = round(|x| 2/pi), its low bits seen through a sum that has no room for a fraction. */
    const float y = {{ name }}_from_bits(magnitude);
    const float shifted = (y * 0.63661977f) + 12582912.0f;
    const uint32_t quadrant = {{ name }}_bits_of(shifted);
    const float k = shifted - 12582912.0f;

    const float a = y - (k * 1.5706787f);
    const float b = k * 0.000117614865f;
    const float h = a - b;
    const float h_lost = (a - h) - b;
    const float c = k * 9.920313e-10f;
    const float r = h - c;
    const float r_lost = (h - r) - c;
    const float tail = (h_lost + r_lost) - (k * 6.223372e-14f);

    const float z = r * r;
    const float z2 = z * z;
    const float half_z = 0.5f * z;
    const float w = 1.0f - half_z;
    const float odd_terms = (-0.16666655f + (0.008332188f * z)) + (z2 * -0.00019518095f);
    const float even_terms = (0.041666646f + (-0.001388731f * z)) + (z2 * 2.4432327e-05f);
    const float s = r + (((z * r) * odd_terms) + (tail * w));
    const float co = w + (((1.0f - w) - half_z) + ((z2 * even_terms) - (r * tail)));

    /* Odd quadrants swap the two; sin < 0 in 2 and 3, cos < 0 in 1 and 2. */
    const uint32_t odd = 0u - (quadrant & 1u);
    const uint32_t s_bits = {{ name }}_bits_of(s);
    const uint32_t c_bits = {{ name }}_bits_of(co);
    const uint32_t swap = (s_bits ^ c_bits) & odd;
    const uint32_t s_sign = sign ^ ((quadrant & 2u) << 30);
    const uint32_t c_sign = ((quadrant + 1u) & 2u) << 30;
    *sine = {{ name }}_from_bits(((s_bits ^ swap) ^ s_sign) | outside);
    *cosine = {{ name }}_from_bits(((c_bits ^ swap) ^ c_sign) | outside);
}

#endif
