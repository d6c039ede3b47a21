    const {{ bits }} all = {{ name }}_bits_of{{ lanes }}(x);
{%- if lanes %}
    /* Bit patterns of magnitudes are ordered as the magnitudes are, NaN last; all bits set are NaN. */
    const {{ bits }} outside = (uint64_t)0 - ((UINT64_C(0x4130000000000000) - (all & ~((uint64_t)1 << 63))) >> 63);
{%- else %}
    const {{ bits }} sign = all & ((uint64_t)1 << 63);
    const {{ bits }} magnitude = all ^ sign;
    /* Bit patterns of magnitudes are ordered as the magnitudes are, NaN last. */
    const {{ bits }} outside = ((uint64_t)0 - ((UINT64_C(0x4130000000000000) - magnitude) >> 63)) & UINT64_C(0x7FF8000000000000);
{%- endif %}

    /* k = round({{ "x" if lanes else "|x|" }} 2/pi), its low bits seen through a sum that has no room for a fraction. */
{%- if not lanes %}
    const {{ of }} y = {{ name }}_from_bits{{ lanes }}(magnitude);
{%- endif %}
    const {{ of }} shifted = ({{ "x" if lanes else "y" }} * 0.6366197723675814) + 6755399441055744.0;
    const {{ bits }} quadrant = {{ name }}_bits_of{{ lanes }}(shifted);
    const {{ of }} k = shifted - 6755399441055744.0;

    const {{ of }} a = {{ "x" if lanes else "y" }} - (k * 1.5707963267341256);
    const {{ of }} b = k * 6.077100506303966e-11;
    const {{ of }} h = a - b;
    const {{ of }} h_lost = (a - h) - b;
    const {{ of }} c = k * 2.0222662487111665e-21;
    const {{ of }} r = h - c;
    const {{ of }} r_lost = (h - r) - c;
{%- if lanes %}
    /* Of the other sign than a tail, so that the sine of -0 is -0. */
    const {{ of }} lost = (k * 8.4784276603689e-32) - (h_lost + r_lost);
    const {{ of }} excess = {{ name }}_from_bits{{ lanes }}({{ name }}_bits_of{{ lanes }}(lost) | outside);
{%- else %}
    const {{ of }} tail = (h_lost + r_lost) - (k * 8.4784276603689e-32);
{%- endif %}
