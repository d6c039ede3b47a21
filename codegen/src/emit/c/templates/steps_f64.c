/*
 * Sine and cosine of x rad, each within 0.9 ulp for |x| <= 2^20, NaN beyond.
 *
 *     pi/2 = P1 + P2 + P3 + P4     33, 33, 33 and 53 bits
 *     r    = (((|x| - k P1) - k P2) - k P3) - k P4
 *
 * The first three products are exact. No branch, no call, no conversion.
 */
static {{ "inline " if lanes }}void {{ name }}_sincos{{ lanes }}({{ of }} x, {{ of }} *sine, {{ of }} *cosine)
{
{%- if lanes %}
    const {{ bits }} all = {{ name }}_bits_of{{ lanes }}(x);
    const {{ bits }} magnitude = all & ~((uint64_t)1 << 63);
    /* Bit patterns of magnitudes are ordered as the magnitudes are, NaN last; all bits set are NaN. */
    const {{ bits }} outside = (uint64_t)0 - ((UINT64_C(0x4130000000000000) - magnitude) >> 63);
{%- else %}
    const {{ bits }} all = {{ name }}_bits_of{{ lanes }}(x);
    const {{ bits }} sign = all & ((uint64_t)1 << 63);
    const {{ bits }} magnitude = all ^ sign;
    /* Bit patterns of magnitudes are ordered as the magnitudes are, NaN last. */
    const {{ bits }} outside = ((uint64_t)0 - ((UINT64_C(0x4130000000000000) - magnitude) >> 63)) & UINT64_C(0x7FF8000000000000);
{%- endif %}

    /* k = round(|x| 2/pi), its low bits seen through a sum that has no room for a fraction. */
    const {{ of }} y = {{ name }}_from_bits{{ lanes }}(magnitude{{ " | outside" if lanes }});
    const {{ of }} shifted = (y * 0.6366197723675814) + 6755399441055744.0;
    const {{ bits }} quadrant = {{ name }}_bits_of{{ lanes }}(shifted);
    const {{ of }} k = shifted - 6755399441055744.0;

    const {{ of }} a = y - (k * 1.5707963267341256);
    const {{ of }} b = k * 6.077100506303966e-11;
    const {{ of }} h = a - b;
    const {{ of }} h_lost = (a - h) - b;
    const {{ of }} c = k * 2.0222662487111665e-21;
    const {{ of }} r = h - c;
    const {{ of }} r_lost = (h - r) - c;
    const {{ of }} tail = (h_lost + r_lost) - (k * 8.4784276603689e-32);

    const {{ of }} z = r * r;
    const {{ of }} z2 = z * z;
    const {{ of }} half_z = 0.5 * z;
    const {{ of }} w = 1.0 - half_z;
    const {{ of }} odd_terms = (-0.1666666666666663 + (0.00833333333332184 * z))
        + (z2 * ((-0.00019841269829358522 + (2.7557313538511096e-06 * z)) + (z2 * (-2.5050734388633495e-08 + (1.5895433246246603e-10 * z)))));
    const {{ of }} even_terms = (0.041666666666666595 + (-0.0013888888888873342 * z))
        + (z2 * ((2.48015872890021e-05 + (-2.7557314217051587e-07 * z)) + (z2 * (2.0875705398667983e-09 + (-1.1358749420488109e-11 * z)))));
    const {{ of }} s = r + (((z * r) * odd_terms) + (tail * w));
    const {{ of }} co = w + (((1.0 - w) - half_z) + ((z2 * even_terms) - (r * tail)));

    /* Odd quadrants swap the two; sin < 0 in 2 and 3, cos < 0 in 1 and 2. */
    const {{ bits }} odd = (uint64_t)0 - (quadrant & (uint64_t)1);
    const {{ bits }} s_bits = {{ name }}_bits_of{{ lanes }}(s);
    const {{ bits }} c_bits = {{ name }}_bits_of{{ lanes }}(co);
    const {{ bits }} swap = (s_bits ^ c_bits) & odd;
{%- if lanes %}
    const {{ bits }} half = quadrant << 62;
    const {{ bits }} s_sign = (half ^ all) & ((uint64_t)1 << 63);
    const {{ bits }} c_sign = (half + ((uint64_t)1 << 62)) & ((uint64_t)1 << 63);
    *sine = {{ name }}_from_bits{{ lanes }}((s_bits ^ swap) ^ s_sign);
    *cosine = {{ name }}_from_bits{{ lanes }}((c_bits ^ swap) ^ c_sign);
{%- else %}
    const {{ bits }} s_sign = sign ^ ((quadrant & (uint64_t)2) << 62);
    const {{ bits }} c_sign = ((quadrant + (uint64_t)1) & (uint64_t)2) << 62;
    *sine = {{ name }}_from_bits{{ lanes }}(((s_bits ^ swap) ^ s_sign) | outside);
    *cosine = {{ name }}_from_bits{{ lanes }}(((c_bits ^ swap) ^ c_sign) | outside);
{%- endif %}
}
