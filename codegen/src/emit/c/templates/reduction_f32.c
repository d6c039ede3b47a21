    const {{ bits }} all = {{ name }}_bits_of{{ lanes }}(x);
{%- if lanes %}
    /* Bit patterns of magnitudes are ordered as the magnitudes are, NaN last; all bits set are NaN. */
    const {{ bits }} outside = 0u - ((0x44800000u - (all & ~0x80000000u)) >> 31);
{%- else %}
    const {{ bits }} sign = all & 0x80000000u;
    const {{ bits }} magnitude = all ^ sign;
    /* Bit patterns of magnitudes are ordered as the magnitudes are, NaN last. */
    const {{ bits }} outside = (0u - ((0x44800000u - magnitude) >> 31)) & 0x7FC00000u;
{%- endif %}

    /* k = round({{ "x" if lanes else "|x|" }} 2/pi), its low bits seen through a sum that has no room for a fraction. */
{%- if not lanes %}
    const {{ of }} y = {{ name }}_from_bits{{ lanes }}(magnitude);
{%- endif %}
    const {{ of }} shifted = ({{ "x" if lanes else "y" }} * 0.63661977f) + 12582912.0f;
    const {{ bits }} quadrant = {{ name }}_bits_of{{ lanes }}(shifted);
    const {{ of }} k = shifted - 12582912.0f;

    const {{ of }} a = {{ "x" if lanes else "y" }} - (k * 1.5706787f);
    const {{ of }} b = k * 0.000117614865f;
    const {{ of }} h = a - b;
    const {{ of }} h_lost = (a - h) - b;
    const {{ of }} c = k * 9.920313e-10f;
    const {{ of }} r = h - c;
    const {{ of }} r_lost = (h - r) - c;
{%- if lanes %}
    /* Of the other sign than a tail, so that the sine of -0 is -0. */
    const {{ of }} lost = (k * 6.223372e-14f) - (h_lost + r_lost);
    const {{ of }} excess = {{ name }}_from_bits{{ lanes }}({{ name }}_bits_of{{ lanes }}(lost) | outside);
{%- else %}
    const {{ of }} tail = (h_lost + r_lost) - (k * 6.223372e-14f);
{%- endif %}
