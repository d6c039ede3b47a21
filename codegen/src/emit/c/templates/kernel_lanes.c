#ifdef {{ name }}_USE_LIBM

static void {{ name }}_sincos_lanes({{ name }}_lanes x, {{ name }}_lanes *sine, {{ name }}_lanes *cosine)
{
    for (uint32_t k = 0u; k < {{ name }}_LANES; k += 1u) {
        {{ real }} s;
        {{ real }} c;
        {{ name }}_sincos(x[k], &s, &c);
        (*sine)[k] = s;
        (*cosine)[k] = c;
    }
}
{%- if has_sincos_both_lanes %}

static void {{ name }}_sincos_both_lanes({{ name }}_lanes x_1, {{ name }}_lanes x_2, {{ name }}_lanes *sine_1, {{ name }}_lanes *cosine_1, {{ name }}_lanes *sine_2, {{ name }}_lanes *cosine_2)
{
    {{ name }}_sincos_lanes(x_1, sine_1, cosine_1);
    {{ name }}_sincos_lanes(x_2, sine_2, cosine_2);
}
{%- endif %}

#else

static {{ name }}_lane_bits {{ name }}_bits_of_lanes({{ name }}_lanes x)
{
    return ({{ name }}_lane_bits)x;
}

static {{ name }}_lanes {{ name }}_from_bits_lanes({{ name }}_lane_bits bits)
{
    return ({{ name }}_lanes)bits;
}

{% with of = name ~ "_lanes", bits = name ~ "_lane_bits", lanes = "_lanes" -%}
{%- set one -%}
{% include steps %}
{%- endset -%}
{% if has_sincos_lanes -%}
/* Constants stay in registers where it is not called. */
static inline void {{ name }}_sincos_lanes({{ name }}_lanes x, {{ name }}_lanes *sine, {{ name }}_lanes *cosine)
    __attribute__((always_inline));

{{ one }}
{%- endif %}
{%- if has_sincos_lanes and has_sincos_both_lanes %}

{% endif %}
{%- if has_sincos_both_lanes -%}
/* Constants stay in registers where it is not called. */
static inline void {{ name }}_sincos_both_lanes({{ name }}_lanes x_1, {{ name }}_lanes x_2, {{ name }}_lanes *sine_1, {{ name }}_lanes *cosine_1, {{ name }}_lanes *sine_2, {{ name }}_lanes *cosine_2)
    __attribute__((always_inline));

/* Sines and cosines of two angles, by the steps of one in turns: one's are done while the other's are waited for. */
static inline void {{ name }}_sincos_both_lanes({{ name }}_lanes x_1, {{ name }}_lanes x_2, {{ name }}_lanes *sine_1, {{ name }}_lanes *cosine_1, {{ name }}_lanes *sine_2, {{ name }}_lanes *cosine_2)
{
{{ one | taking_turns }}}
{%- endif %}
{%- endwith %}

#endif
