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
{%- if "sincos_both" in called %}

typedef struct {
    {{ name }}_lanes x;
} {{ name }}_reduced;

static void {{ name }}_reduce_both({{ name }}_lanes x_1, {{ name }}_lanes x_2, {{ name }}_reduced *of_1, {{ name }}_reduced *of_2)
{
    of_1->x = x_1;
    of_2->x = x_2;
}

static void {{ name }}_sincos_both(const {{ name }}_reduced *of_1, const {{ name }}_reduced *of_2, {{ name }}_lanes *sine_1, {{ name }}_lanes *cosine_1, {{ name }}_lanes *sine_2, {{ name }}_lanes *cosine_2)
{
    {{ name }}_sincos_lanes(of_1->x, sine_1, cosine_1);
    {{ name }}_sincos_lanes(of_2->x, sine_2, cosine_2);
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
{% if "sincos_lanes" in called -%}
/* Constants stay in registers where it is not called. */
static inline void {{ name }}_sincos_lanes({{ name }}_lanes x, {{ name }}_lanes *sine, {{ name }}_lanes *cosine)
    __attribute__((always_inline));

{% include "steps.c" %}
{%- endif %}
{%- if "sincos_lanes" in called and "sincos_both" in called %}

{% endif %}
{%- if "sincos_both" in called -%}
{%- set reduction_of_one -%}
{% include "reduction_" ~ format ~ ".c" %}
    of->r = r;
    of->excess = excess;
    of->quadrant = quadrant;
{% endset -%}
{%- set series_of_one %}
    const {{ name }}_lanes r = of->r;
    const {{ name }}_lanes excess = of->excess;
    const {{ name }}_lane_bits quadrant = of->quadrant;
{% include "series_" ~ format ~ ".c" %}
{% endset -%}
/* What quarter turns leave of an angle, r - excess, and in the last two bits how many they were. */
typedef struct {
    {{ name }}_lanes r;
    {{ name }}_lanes excess;
    {{ name }}_lane_bits quadrant;
} {{ name }}_reduced;

/* Constants stay in registers where these are not called. */
static inline void {{ name }}_reduce_both({{ name }}_lanes x_1, {{ name }}_lanes x_2, {{ name }}_reduced *of_1, {{ name }}_reduced *of_2)
    __attribute__((always_inline));
static inline void {{ name }}_sincos_both(const {{ name }}_reduced *of_1, const {{ name }}_reduced *of_2, {{ name }}_lanes *sine_1, {{ name }}_lanes *cosine_1, {{ name }}_lanes *sine_2, {{ name }}_lanes *cosine_2)
    __attribute__((always_inline));

/*
 * Two angles less quarter turns, by the steps of one in turns: one's are done while the other's
 * are waited for.
 */
static inline void {{ name }}_reduce_both({{ name }}_lanes x_1, {{ name }}_lanes x_2, {{ name }}_reduced *of_1, {{ name }}_reduced *of_2)
{
{{ reduction_of_one | taking_turns }}}

/* Sines and cosines of two angles, likewise. */
static inline void {{ name }}_sincos_both(const {{ name }}_reduced *of_1, const {{ name }}_reduced *of_2, {{ name }}_lanes *sine_1, {{ name }}_lanes *cosine_1, {{ name }}_lanes *sine_2, {{ name }}_lanes *cosine_2)
{
{{ series_of_one | taking_turns }}}
{%- endif %}
{%- endwith %}

#endif
