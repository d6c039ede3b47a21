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

#else

static {{ name }}_lane_bits {{ name }}_bits_of_lanes({{ name }}_lanes x)
{
    return ({{ name }}_lane_bits)x;
}

static {{ name }}_lanes {{ name }}_from_bits_lanes({{ name }}_lane_bits bits)
{
    return ({{ name }}_lanes)bits;
}

/* Constants stay in registers where it is not called. */
static inline void {{ name }}_sincos_lanes({{ name }}_lanes x, {{ name }}_lanes *sine, {{ name }}_lanes *cosine)
    __attribute__((always_inline));

{% with of = name ~ "_lanes", bits = name ~ "_lane_bits", lanes = "_lanes" -%}
{% include steps %}
{%- endwith %}

#endif
