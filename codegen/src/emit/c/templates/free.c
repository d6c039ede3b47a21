/*
{%- for line in about %}
 *{{ " " if line }}{{ line }}
{%- endfor %}
 */

{% include "includes.c" %}
{% include "helpers.c" %}
void {{ name }}_run({{ signature }})
{
{%- for line in body %}
{{ "    " if line }}{{ line }}
{%- endfor %}
}
