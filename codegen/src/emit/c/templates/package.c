/*
{%- for line in about %}
 *{{ " " if line }}{{ line }}
{%- endfor %}
 */

#include "{{ name }}.h"

#include <stdint.h>
{%- if has_kernel and real != "int32_t" %}
#ifdef {{ name }}_USE_LIBM
#include <math.h>
#else
#include <string.h>
#ifdef __FAST_MATH__
#error "-ffast-math breaks the reduction of angles: leave it out or define {{ name }}_USE_LIBM"
#endif
#endif
{%- endif %}
{%- for (name, symbol) in renamed_static %}
{%- if loop.first %}

/* Names that C99 would not tell apart in their first 31 characters. */
{%- endif %}
#define {{ name }} {{ symbol }}
{%- endfor %}
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
{%- if has_narrow %}
{%- include "narrow.c" %}
{%- endif %}
{%- if has_table %}
{%- include "table.c" %}
{%- endif %}
{%- if has_kernel %}
{%- include kernel %}
{%- endif %}
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
