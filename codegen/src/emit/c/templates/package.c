/*
{%- for line in about %}
 *{{ " " if line }}{{ line }}
{%- endfor %}
 */

{% include "includes.c" %}
{% for constant in constants %}
{%- if constant.is_array %}
{{ constant.declaration }} = {
{%- for entry in constant.values %}
    {{ entry[0] }}{{ "," if not loop.last }}{{ " /* " ~ entry[1] ~ " */" if entry[1] }}
{%- endfor %}
};
{% else %}
{%- set entry = constant.values[0] %}
{{ constant.declaration }} = {{ entry[0] }};{{ " /* " ~ entry[1] ~ " */" if entry[1] }}
{% endif %}
{%- endfor %}
{%- include "helpers.c" %}
{%- if from_ticks %}
/* {{ from_ticks.brief }} */
static void {{ from_ticks.signature }}
{
{%- for line in from_ticks.lines %}
    {{ line }}
{%- endfor %}
}
{% endif %}
{%- if has_lanes %}
{% include "lanes.c" %}
{% endif %}
{%- for function in functions %}
{%- if function.block %}
static void {{ name }}_{{ function.block.of_one }}_block({{ function.block.parameters }})
{
    volatile {{ name }}_lanes on_stack = {0};
    (void)on_stack;
{%- for line in function.block.body %}
{{ "    " if line }}{{ line }}
{%- endfor %}
}
{% endif %}{%- if function.core %}
{{ name }}_SHARED void {{ name }}_{{ function.name }}_core({{ function.core.parameters }})
{
{%- for line in function.core.body %}
{{ "    " if line }}{{ line }}
{%- endfor %}
}
{% endif %}
void {{ name }}_{{ function.name }}({{ function.definition }})
{
{%- if function.block %}
{%- include "batch.c" %}
{%- endif %}
{%- for line in function.body %}
{{ "    " if line }}{{ line }}
{%- endfor %}
}
{% endfor %}
{%- if estimator %}
{%- include "estimator.c" %}
{% endif %}
{%- include "selftest.c" %}
