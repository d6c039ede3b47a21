
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

#if !defined(__FLT_EVAL_METHOD__) || (__FLT_EVAL_METHOD__ != 2)
/* Sums that are rounded up, down or to zero: sines would leave their bounds. The compiler would
   add known numbers in the mode that it assumes; the result of a function it does not know.
   On x87 sums have more digits than their type. */
static int {{ name }}_rounds_otherwise({{ name }}_real result)
{
    const {{ name }}_real zero = 0.0{{ suffix }} * result;
    const {{ name }}_real at = zero + 1.0{{ suffix }};
    const {{ name }}_real little = zero + {{ eighth_of_ulp }};
    const {{ name }}_real up = at + little;
    const {{ name }}_real down = at - little;
    return ((up > at) || (down < at)) ? 1 : 0;
}
#endif
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
    {{ name }}_real {{ result[0] }}[{{ result[1] }}];
{%- endfor %}
    int failed = 0;
{%- for check in selftest %}

    {{ check.call }}
    if ({{ name }}_differs({{ check.got }}, {{ check.expected }}, {{ check.count }}u, {{ check.tolerance }}) != 0) {
        failed += {{ check.weight }};
    }
{%- endfor %}
{%- if real != "int32_t" %}

#if !defined(__FLT_EVAL_METHOD__) || (__FLT_EVAL_METHOD__ != 2)
    if ({{ name }}_rounds_otherwise({{ selftest_results[0][0] }}[0]) != 0) {
        failed += {{ selftest_rounding }};
    }
#endif
{%- endif %}
    return failed;
}

int {{ name }}_selftest(void)
{
    return {{ name }}_selftest_{{ pair }}();
}
