{%- set batch = function.block %}
    if (n < {{ name }}_LANES) {
{%- for array in batch.inputs if not array.is_shared %}
        {{ name }}_real {{ array.name }}_of_one[{{ array.len or 1 }}];
{%- endfor %}
        {{ name }}_real {{ batch.output }}_of_one[{{ batch.outputs }}];
        for (size_t i = 0u; i < n; i += 1u) {
{%- for array in batch.inputs if array.len and not array.is_shared %}
            {{ name }}_gather({{ array.name }}, {{ array.len }}u, n, i, {{ array.name }}_of_one);
{%- endfor %}
            {{ name }}_{{ batch.of_one }}({% for array in batch.inputs %}{{ array.name }}{{ "" if array.is_shared else "_of_one" }}, {% endfor %}{{ batch.output }}_of_one);
            {{ name }}_scatter({{ batch.output }}_of_one, {{ batch.outputs }}u, n, i, {{ batch.output }});
        }
    } else {
        for (size_t i = 0u; i < n; i += {{ name }}_LANES) {
            /* The last block ends with the last posture. */
            const size_t at = ((n - i) < {{ name }}_LANES) ? (n - {{ name }}_LANES) : i;
            {{ name }}_{{ batch.of_one }}_block(n, {% for array in batch.inputs %}{{ array.name if array.is_shared else "&" ~ array.name ~ "[at]" }}, {% endfor %}&{{ batch.output }}[at]);
        }
    }
