#include "{{ name }}.h"

{% if has_infinity -%}
#include <math.h>
{% endif -%}
#include <stdint.h>
{%- if estimator %}
#include <string.h>
{%- endif %}
{%- if (has_kernel or has_power) and real != "int32_t" %}
#ifdef {{ name }}_USE_LIBM
#include <math.h>
#else
{{- "" if estimator else "\n#include <string.h>" }}
#ifdef __FAST_MATH__
#error "-ffast-math breaks {{ "sines" if has_kernel else "powers" }}: omit it or define {{ name }}_USE_LIBM"
#endif
#endif
{%- endif %}
