{%- if "narrow" in called %}
/* wide / 2^bits, rounded to nearest; bits >= 1. */
static {{ name }}_real {{ name }}_narrow(int64_t wide, uint32_t bits)
{
    return ({{ name }}_real)((wide + ((int64_t)1 << (bits - 1u))) >> bits);
}
{% endif %}
{%- if "shift_up" in called %}
/* value * 2^bits. A product: shifting a negative number up is undefined. */
#define {{ name }}_shift_up(value, bits) \
    ((int64_t)(value) * ((int64_t)1 << (bits)))
{% endif %}
{%- if "add" in called or "subtract" in called %}
/* Inside the ranges of all inputs nothing overflows; for others sums wrap, as angles do. */
{%- if "add" in called %}
#define {{ name }}_add(a, b) \
    ((int32_t)((uint32_t)(a) + (uint32_t)(b)))
{%- endif %}
{%- if "subtract" in called %}
#define {{ name }}_subtract(a, b) \
    ((int32_t)((uint32_t)(a) - (uint32_t)(b)))
{%- endif %}
{% endif %}
{%- if "lookup" in called %}
{% include "table.c" %}
{% endif %}
{%- if "sincos" in called %}
{% include "kernel_fixed.c" if real == "int32_t" else "kernel_float.c" %}
{% endif %}
{%- if has_shared %}

/* A body that two functions share is made a part of both. */
#if defined(__GNUC__)
#define {{ name }}_SHARED static inline __attribute__((always_inline))
#else
#define {{ name }}_SHARED static inline
#endif
{%- endif %}
{%- if "turn" in called %}

/* The sine and cosine that are given, or those of q. */
{{ name }}_SHARED void {{ name }}_turn(
    int of_sines,
    {{ name }}_real q,
    {{ name }}_real sin_q,
    {{ name }}_real cos_q,
    {{ name }}_real *sine,
    {{ name }}_real *cosine)
{
    if (of_sines != 0) {
        *sine = sin_q;
        *cosine = cos_q;
    } else {
        {{ name }}_sincos(q, sine, cosine);
    }
}
{% endif %}
{%- if "clamp" in called %}
{% if real == "int32_t" -%}
/* The nearest number in [-1, 1], 30 bits below the point: of x, where 1 is `one` and a unit is
 * `unit` of the result. */
static {{ name }}_real {{ name }}_clamp({{ name }}_real x, {{ name }}_real one, {{ name }}_real unit)
{
    const {{ name }}_real above = (x < -one) ? -one : x;
    const {{ name }}_real inside = (above > one) ? one : above;
    return inside * unit;
}
{%- else -%}
/* The nearest number in [-1, 1]; NaN for NaN. */
static {{ real }} {{ name }}_clamp({{ real }} x)
{
    const {{ real }} above = (x < -1.0{{ suffix }}) ? -1.0{{ suffix }} : x;
    return (above > 1.0{{ suffix }}) ? 1.0{{ suffix }} : above;
}
{%- endif %}
{% endif %}
{%- if "larger" in called %}

/* The larger of two numbers, the first where neither is. */
static {{ real }} {{ name }}_larger({{ real }} x, {{ real }} y)
{
    return (x < y) ? y : x;
}
{% endif %}
{%- if "power" in called %}
{% include "power_" ~ format ~ ".c" %}
{% endif %}
