#if defined(__cplusplus)
#error "{{ name }}.c is C99: compile it as C; {{ name }}.h is for C and C++"
#elif defined(_MSC_VER) && !defined(__clang__)
#error "{{ name }}.c is C99, which MSVC does not take whole: compile it with clang-cl"
#elif !defined(__STDC_VERSION__) || (__STDC_VERSION__ < 199901L)
#error "{{ name }}.c is C99: add -std=c99 or a later standard"
#endif

/* The self-test is defined here, by its own name, too. */
#define {{ name }}_SOURCE
#include "{{ name }}.h"
#ifndef {{ name }}_PAIR_{{ pair }}
#error "{{ name }}.h is not the header that was written with this source: generate both again"
#endif

{% if has_infinity -%}
#include <math.h>
{% endif -%}
{% if real != "int32_t" -%}
#include <float.h>
{% endif -%}
#include <stdint.h>
{%- if estimator %}
#include <string.h>
{%- endif %}

{% if real == "double" -%}
#if (FLT_RADIX != 2) || (DBL_MANT_DIG != 53) || (DBL_MAX_EXP != 1024)
#error "double has no 64 bits here: generate {{ name }} with --scalar f32, or ask the compiler for them"
#endif
{%- elif real == "float" -%}
#if (FLT_RADIX != 2) || (FLT_MANT_DIG != 24) || (FLT_MAX_EXP != 128)
#error "float is not of IEEE's 32 bits here: generate {{ name }} with --scalar fixed32"
#endif
{%- else -%}
#if ((-1 >> 1) != -1) || !defined(INT32_MAX) || !defined(INT64_MAX)
#error "{{ name }} needs int32_t, int64_t and shifts that keep the sign"
#endif
{%- endif %}
{%- if ("sincos" in called or "power" in called) and real != "int32_t" %}
#ifdef {{ name }}_USE_LIBM
#include <math.h>
#else
{{- "" if estimator else "\n#include <string.h>" }}
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__)
#error "-ffast-math breaks {{ "sines" if "sincos" in called else "powers" }}: omit it or define {{ name }}_USE_LIBM"
#endif
#if (FLT_EVAL_METHOD < 0) || (FLT_EVAL_METHOD == 2)
#error "x87 breaks {{ "sines" if "sincos" in called else "powers" }}: add -msse2 -mfpmath=sse, or define {{ name }}_USE_LIBM"
{%- if real == "float" %}
#elif FLT_EVAL_METHOD == 1
#error "float in double has other bits: add -fexcess-precision=fast, or define {{ name }}_USE_LIBM"
{%- endif %}
#endif
#endif
{%- endif %}
