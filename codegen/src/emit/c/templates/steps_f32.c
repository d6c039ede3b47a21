/*
 * Sine and cosine of x rad, each within 0.85 ulp for |x| <= 1024, NaN beyond.
 *
 *     pi/2 = P1 + P2 + P3 + P4     14, 14, 14 and 24 bits
 *     r    = (((|x| - k P1) - k P2) - k P3) - k P4
 *
 * The first three products are exact. No branch, no call, no conversion.
 */
static {{ "inline " if lanes }}void {{ name }}_sincos{{ lanes }}({{ of }} x, {{ of }} *sine, {{ of }} *cosine)
{
{%- if lanes %}
    const {{ bits }} all = {{ name }}_bits_of{{ lanes }}(x);
    const {{ bits }} magnitude = all & ~0x80000000u;
    /* Bit patterns of magnitudes are ordered as the magnitudes are, NaN last; all bits set are NaN. */
    const {{ bits }} outside = 0u - ((0x44800000u - magnitude) >> 31);
{%- else %}
    const {{ bits }} all = {{ name }}_bits_of{{ lanes }}(x);
    const {{ bits }} sign = all & 0x80000000u;
    const {{ bits }} magnitude = all ^ sign;
    /* Bit patterns of magnitudes are ordered as the magnitudes are, NaN last. */
    const {{ bits }} outside = (0u - ((0x44800000u - magnitude) >> 31)) & 0x7FC00000u;
{%- endif %}

    /* k = round(|x| 2/pi), its low bits seen through a sum that has no room for a fraction. */
    const {{ of }} y = {{ name }}_from_bits{{ lanes }}(magnitude{{ " | outside" if lanes }});
    const {{ of }} shifted = (y * 0.63661977f) + 12582912.0f;
    const {{ bits }} quadrant = {{ name }}_bits_of{{ lanes }}(shifted);
    const {{ of }} k = shifted - 12582912.0f;

    const {{ of }} a = y - (k * 1.5706787f);
    const {{ of }} b = k * 0.000117614865f;
    const {{ of }} h = a - b;
    const {{ of }} h_lost = (a - h) - b;
    const {{ of }} c = k * 9.920313e-10f;
    const {{ of }} r = h - c;
    const {{ of }} r_lost = (h - r) - c;
    const {{ of }} tail = (h_lost + r_lost) - (k * 6.223372e-14f);

    const {{ of }} z = r * r;
    const {{ of }} z2 = z * z;
    const {{ of }} half_z = 0.5f * z;
    const {{ of }} w = 1.0f - half_z;
    const {{ of }} odd_terms = (-0.16666655f + (0.008332188f * z)) + (z2 * -0.00019518095f);
    const {{ of }} even_terms = (0.041666646f + (-0.001388731f * z)) + (z2 * 2.4432327e-05f);
    const {{ of }} s = r + (((z * r) * odd_terms) + (tail * w));
    const {{ of }} co = w + (((1.0f - w) - half_z) + ((z2 * even_terms) - (r * tail)));

    /* Odd quadrants swap the two; sin < 0 in 2 and 3, cos < 0 in 1 and 2. */
    const {{ bits }} odd = 0u - (quadrant & 1u);
    const {{ bits }} s_bits = {{ name }}_bits_of{{ lanes }}(s);
    const {{ bits }} c_bits = {{ name }}_bits_of{{ lanes }}(co);
    const {{ bits }} swap = (s_bits ^ c_bits) & odd;
{%- if lanes %}
    const {{ bits }} half = quadrant << 30;
    const {{ bits }} s_sign = (half ^ all) & 0x80000000u;
    const {{ bits }} c_sign = (half + (1u << 30)) & 0x80000000u;
    *sine = {{ name }}_from_bits{{ lanes }}((s_bits ^ swap) ^ s_sign);
    *cosine = {{ name }}_from_bits{{ lanes }}((c_bits ^ swap) ^ c_sign);
{%- else %}
    const {{ bits }} s_sign = sign ^ ((quadrant & 2u) << 30);
    const {{ bits }} c_sign = ((quadrant + 1u) & 2u) << 30;
    *sine = {{ name }}_from_bits{{ lanes }}(((s_bits ^ swap) ^ s_sign) | outside);
    *cosine = {{ name }}_from_bits{{ lanes }}(((c_bits ^ swap) ^ c_sign) | outside);
{%- endif %}
}
