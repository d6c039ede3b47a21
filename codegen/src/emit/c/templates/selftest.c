
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
    return failed;
}

int {{ name }}_selftest(void)
{
    return {{ name }}_selftest_{{ pair }}();
}
