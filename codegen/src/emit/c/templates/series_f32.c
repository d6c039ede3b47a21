{#- Lanes take the terms of the sine from r, so their signs are the other ones. -#}
{%- set less = "" if lanes else "-" -%}
{%- set more = "-" if lanes else "" %}
    const {{ of }} z = r * r;
    const {{ of }} z2 = z * z;
    const {{ of }} half_z = 0.5f * z;
    const {{ of }} w = 1.0f - half_z;
    const {{ of }} odd_terms = ({{ less }}0.16666655f + ({{ more }}0.008332188f * z)) + (z2 * {{ less }}0.00019518095f);
    const {{ of }} even_terms = (0.041666646f + (-0.001388731f * z)) + (z2 * 2.4432327e-05f);
{%- if lanes %}
    const {{ of }} s = r - (((z * r) * odd_terms) + (excess * w));
    const {{ of }} co = w + (((1.0f - w) - half_z) + ((z2 * even_terms) + (r * excess)));
{%- else %}
    const {{ of }} s = r + (((z * r) * odd_terms) + (tail * w));
    const {{ of }} co = w + (((1.0f - w) - half_z) + ((z2 * even_terms) - (r * tail)));
{%- endif %}

    /* Odd quadrants swap the two; sin < 0 in 2 and 3, cos < 0 in 1 and 2. */
    const {{ bits }} odd = 0u - (quadrant & 1u);
    const {{ bits }} s_bits = {{ name }}_bits_of{{ lanes }}(s);
    const {{ bits }} c_bits = {{ name }}_bits_of{{ lanes }}(co);
    const {{ bits }} swap = (s_bits ^ c_bits) & odd;
{%- if lanes %}
    const {{ bits }} half = quadrant << 30;
    const {{ bits }} s_sign = half & 0x80000000u;
    const {{ bits }} c_sign = (half + (1u << 30)) & 0x80000000u;
    *sine = {{ name }}_from_bits{{ lanes }}((s_bits ^ swap) ^ s_sign);
    *cosine = {{ name }}_from_bits{{ lanes }}((c_bits ^ swap) ^ c_sign);
{%- else %}
    const {{ bits }} s_sign = sign ^ ((quadrant & 2u) << 30);
    const {{ bits }} c_sign = ((quadrant + 1u) & 2u) << 30;
    *sine = {{ name }}_from_bits{{ lanes }}(((s_bits ^ swap) ^ s_sign) | outside);
    *cosine = {{ name }}_from_bits{{ lanes }}(((c_bits ^ swap) ^ c_sign) | outside);
{%- endif %}
