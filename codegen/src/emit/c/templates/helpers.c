{%- if has_narrow %}
{% include "narrow.c" %}
{% endif %}
{%- if has_shift_up %}
{% include "shift_up.c" %}
{% endif %}
{%- if has_table %}
{% include "table.c" %}
{% endif %}
{%- if has_kernel %}
{% include kernel %}
{% endif %}
{%- if has_clamp %}
{% include clamp %}
{% endif %}
{%- if has_power %}
{% include power %}
{% endif %}
