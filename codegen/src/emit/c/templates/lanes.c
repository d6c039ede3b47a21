#if !defined(__GNUC__)
#error "the _batch functions are written with the vector types of gcc and clang"
#endif

/* Postures that a register of the target holds, at most {{ most_lanes }}. */
{%- for width in registers %}
{%- if width.where %}
{{ "#if" if loop.first else "#elif" }} {{ width.where }}
{%- elif not loop.first %}
#else
{%- endif %}
#define {{ name }}_LANES {{ width.lanes }}u
{%- endfor %}
{%- if (registers | length) > 1 %}
#endif
{%- endif %}

/* A register, its bits, and numbers in memory wherever they begin. */
typedef {{ real }} {{ name }}_lanes __attribute__((vector_size({{ name }}_LANES * sizeof({{ real }}))));
typedef {{ bits }} {{ name }}_lane_bits __attribute__((vector_size({{ name }}_LANES * sizeof({{ bits }}))));
typedef {{ real }} {{ name }}_lanes_anywhere
    __attribute__((vector_size({{ name }}_LANES * sizeof({{ real }})), aligned(sizeof({{ real }})), may_alias));

/*
 * `on_stack` of the functions of a block: a function with such a variable has a stack that is
 * aligned for it. For registers that it saves alone clang aligns none: each would lie in two
 * lines of the cache in three runs of four, which takes up to a fifth longer.
 */
{%- if "load" in called %}

/* Numbers of consecutive postures in a row of an array. */
static {{ name }}_lanes {{ name }}_load(const {{ real }} from[], size_t row, size_t n)
{
    return *(const {{ name }}_lanes_anywhere *)&from[row * n];
}
{%- endif %}
{%- if "store" in called %}

static void {{ name }}_store({{ real }} to[], size_t row, size_t n, {{ name }}_lanes x)
{
    *({{ name }}_lanes_anywhere *)&to[row * n] = x;
}
{%- endif %}
{%- if "splat" in called %}

/* The same number in every lane; less a zero, a number is itself, -0 as well. */
static {{ name }}_lanes {{ name }}_splat({{ real }} x)
{
    const {{ name }}_lanes zero = {0};
    return x - zero;
}
{%- endif %}
{%- if "gather" in called %}

/* Column i of an array of n postures. */
static void {{ name }}_gather(const {{ real }} from[], size_t count, size_t n, size_t i, {{ real }} to[])
{
    for (size_t k = 0u; k < count; k += 1u) {
        to[k] = from[(k * n) + i];
    }
}
{%- endif %}
{%- if "scatter" in called %}

static void {{ name }}_scatter(const {{ real }} from[], size_t count, size_t n, size_t i, {{ real }} to[])
{
    for (size_t k = 0u; k < count; k += 1u) {
        to[(k * n) + i] = from[k];
    }
}
{%- endif %}
{%- if "sincos_lanes" in called or "sincos_both" in called %}

{% include "kernel_lanes.c" %}
{%- endif %}
{%- if "clamp_lanes" in called %}

/* The nearest number in [-1, 1] in every lane; NaN for NaN. */
static {{ name }}_lanes {{ name }}_clamp_lanes({{ name }}_lanes x)
{
    const {{ name }}_lanes least = {{ name }}_splat(-1.0{{ suffix }});
    const {{ name }}_lanes most = {{ name }}_splat(1.0{{ suffix }});
    const {{ name }}_lane_bits below = ({{ name }}_lane_bits)(x < least);
    const {{ name }}_lane_bits above = ({{ name }}_lane_bits)(x > most);
    const {{ name }}_lane_bits held = (({{ name }}_lane_bits)x & ~(below | above))
        | ((({{ name }}_lane_bits)least & below) | (({{ name }}_lane_bits)most & above));
    return ({{ name }}_lanes)held;
}
{%- endif %}
{%- if "larger_lanes" in called %}

/* The larger of two numbers in every lane, the first where neither is. */
static {{ name }}_lanes {{ name }}_larger_lanes({{ name }}_lanes x, {{ name }}_lanes y)
{
    const {{ name }}_lane_bits below = ({{ name }}_lane_bits)(x < y);
    const {{ name }}_lane_bits larger = (({{ name }}_lane_bits)x & ~below) | (({{ name }}_lane_bits)y & below);
    return ({{ name }}_lanes)larger;
}
{%- endif %}
{%- if "power_lanes" in called %}

static {{ name }}_lanes {{ name }}_power_lanes({{ name }}_lanes x, {{ name }}_lanes y)
{
    {{ name }}_lanes power = x;
    for (uint32_t k = 0u; k < {{ name }}_LANES; k += 1u) {
        power[k] = {{ name }}_power(x[k], y[k]);
    }
    return power;
}
{%- endif %}
