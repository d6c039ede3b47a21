/*
{%- for line in about %}
 *{{ " " if line }}{{ line }}
{%- endfor %}
 */

{% include "includes.c" %}
{% if has_names %}
const char *const {{ name }}_joint_names[{{ name }}_DOF] = {
{%- for joint in joints %}
    {{ joint }}{{ "," if not loop.last }}
{%- endfor %}
};
{% endif %}
{%- for array in arrays %}
{{ array.declaration }} = {
{%- for value in array.values %}
    {{ value }}{{ "," if not loop.last }}
{%- endfor %}
};
{% endfor %}
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
{%- for function in functions %}
void {{ name }}_{{ function.name }}({{ function.signature }})
{
{%- for line in function.body %}
{{ "    " if line }}{{ line }}
{%- endfor %}
}
{% endfor %}
{%- include "selftest.c" %}
