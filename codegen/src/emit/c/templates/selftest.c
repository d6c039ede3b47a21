
static int {{ name }}_differs(
    const {{ name }}_real got[],
    const {{ name }}_real expected[],
    uint32_t count,
    {{ name }}_real tolerance)
{
    int differs = 0;
    for (uint32_t k = 0u; k < count; k += 1u) {
{%- if real == "int32_t" %}
        const int64_t difference = (int64_t)got[k] - expected[k];
{%- else %}
        const {{ name }}_real difference = got[k] - expected[k];
{%- endif %}
        /* A NaN differs. */
        if (!((difference <= tolerance) && (difference >= -tolerance))) {
            differs = 1;
        }
    }
    return differs;
}

{%- if real != "int32_t" %}

/* Sums that are rounded up, down or to zero: sines would leave their bounds. */
static int {{ name }}_rounds_otherwise(void)
{
    /* Volatile: the compiler would compute these sums in the mode that it assumes. */
    static const volatile {{ name }}_real one = 1.0{{ suffix }};
    static const volatile {{ name }}_real eighth_of_ulp = {{ eighth_of_ulp }};
    const {{ name }}_real at = one;
    const {{ name }}_real little = eighth_of_ulp;
    volatile {{ name }}_real above = at + little;
    volatile {{ name }}_real below = at - little;
    const {{ name }}_real up = above;
    const {{ name }}_real down = below;
    return ((up > at) || (down < at)) ? 1 : 0;
}
{%- endif %}

int {{ name }}_selftest_{{ pair }}(void)
{
{%- for check in selftest %}
{%- for array in check.arrays %}
    static const {{ array.type }} {{ array.name }}[{{ array.values | length }}] = {
{%- for value in array.values %}
        {{ value }}{{ "," if not loop.last }}
{%- endfor %}
    };
{%- endfor %}
{%- endfor %}
{%- for result in selftest_results %}
    {{ name }}_real {{ result.name }}[{{ result.length }}];
{%- endfor %}
    int failed = 0;
{%- for check in selftest %}

    {{ check.call }}
    if ({{ name }}_differs({{ check.got }}, {{ check.expected }}, {{ check.count }}u, {{ check.tolerance }}) != 0) {
        failed += {{ check.weight }};
    }
{%- endfor %}
{%- if real != "int32_t" %}

    if ({{ name }}_rounds_otherwise() != 0) {
        failed += {{ selftest_rounding }};
    }
{%- endif %}
    return failed;
}

int {{ name }}_selftest(void)
{
    return {{ name }}_selftest_{{ pair }}();
}
