{#- Lanes take the terms of the sine from r, so their signs are the other ones. -#}
{%- set less = "" if lanes else "-" -%}
{%- set more = "-" if lanes else "" %}
    const {{ of }} z = r * r;
    const {{ of }} z2 = z * z;
    const {{ of }} half_z = 0.5 * z;
    const {{ of }} w = 1.0 - half_z;
    const {{ of }} odd_terms = ({{ less }}0.1666666666666663 + ({{ more }}0.00833333333332184 * z))
        + (z2 * (({{ less }}0.00019841269829358522 + ({{ more }}2.7557313538511096e-06 * z)) + (z2 * ({{ less }}2.5050734388633495e-08 + ({{ more }}1.5895433246246603e-10 * z)))));
    const {{ of }} even_terms = (0.041666666666666595 + (-0.0013888888888873342 * z))
        + (z2 * ((2.48015872890021e-05 + (-2.7557314217051587e-07 * z)) + (z2 * (2.0875705398667983e-09 + (-1.1358749420488109e-11 * z)))));
{%- if lanes %}
    const {{ of }} s = r - (((z * r) * odd_terms) + (excess * w));
    const {{ of }} co = w + (((1.0 - w) - half_z) + ((z2 * even_terms) + (r * excess)));
{%- else %}
    const {{ of }} s = r + (((z * r) * odd_terms) + (tail * w));
    const {{ of }} co = w + (((1.0 - w) - half_z) + ((z2 * even_terms) - (r * tail)));
{%- endif %}

    /* Odd quadrants swap the two; sin < 0 in 2 and 3, cos < 0 in 1 and 2. */
    const {{ bits }} odd = (uint64_t)0 - (quadrant & (uint64_t)1);
    const {{ bits }} s_bits = {{ name }}_bits_of{{ lanes }}(s);
    const {{ bits }} c_bits = {{ name }}_bits_of{{ lanes }}(co);
    const {{ bits }} swap = (s_bits ^ c_bits) & odd;
{%- if lanes %}
    const {{ bits }} half = quadrant << 62;
    const {{ bits }} s_sign = half & ((uint64_t)1 << 63);
    const {{ bits }} c_sign = (half + ((uint64_t)1 << 62)) & ((uint64_t)1 << 63);
    *sine = {{ name }}_from_bits{{ lanes }}((s_bits ^ swap) ^ s_sign);
    *cosine = {{ name }}_from_bits{{ lanes }}((c_bits ^ swap) ^ c_sign);
{%- else %}
    const {{ bits }} s_sign = sign ^ ((quadrant & (uint64_t)2) << 62);
    const {{ bits }} c_sign = ((quadrant + (uint64_t)1) & (uint64_t)2) << 62;
    *sine = {{ name }}_from_bits{{ lanes }}(((s_bits ^ swap) ^ s_sign) | outside);
    *cosine = {{ name }}_from_bits{{ lanes }}(((c_bits ^ swap) ^ c_sign) | outside);
{%- endif %}
