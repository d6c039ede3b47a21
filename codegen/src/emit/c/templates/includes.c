/* The self-test is defined here, by its own name, too. */
#define {{ name }}_SOURCE
#include "{{ name }}.h"
#ifndef {{ name }}_PAIR_{{ pair }}
#error "{{ name }}.h is not the header that was written with this source: generate both again"
#endif

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
#include <float.h>
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__)
#error "-ffast-math breaks {{ "sines" if has_kernel else "powers" }}: omit it or define {{ name }}_USE_LIBM"
#endif
#if (FLT_EVAL_METHOD < 0) || (FLT_EVAL_METHOD == 2)
#error "x87 breaks {{ "sines" if has_kernel else "powers" }}: add -msse2 -mfpmath=sse, or define {{ name }}_USE_LIBM"
{%- if real == "float" %}
#elif FLT_EVAL_METHOD == 1
#error "float in double has other bits: add -fexcess-precision=fast, or define {{ name }}_USE_LIBM"
{%- endif %}
#endif
#endif
{%- endif %}
