{%- if has_narrow %}
{% include "narrow.c" %}
{% endif %}
{%- if has_shift_up %}
{% include "shift_up.c" %}
{% endif %}
{%- if has_add or has_subtract %}
{% include "wrapping.c" %}
{% endif %}
{%- if has_table %}
{% include "table.c" %}
{% endif %}
{%- if has_kernel %}
{% include kernel %}
{% endif %}
{%- if has_shared %}

/* A body that two functions share is made a part of both. */
#if defined(__GNUC__)
#define {{ name }}_SHARED static inline __attribute__((always_inline))
#else
#define {{ name }}_SHARED static inline
#endif
{%- endif %}
{%- if has_turn %}

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
{%- if has_clamp %}
{% include clamp %}
{% endif %}
{%- if has_larger %}

/* The larger of two numbers, the first where neither is. */
static {{ real }} {{ name }}_larger({{ real }} x, {{ real }} y)
{
    return (x < y) ? y : x;
}
{% endif %}
{%- if has_power %}
{% include power %}
{% endif %}
