/*
{%- for line in about %}
 *{{ " " if line }}{{ line }}
{%- endfor %}
 */

#ifndef {{ guard }}
#define {{ guard }}

#ifdef __cplusplus
extern "C" {
#endif

{%- for (name, symbol) in renamed %}
{%- if loop.first %}

/* Names that C99 would not tell apart in their first 31 characters. */
{%- endif %}
#define {{ name }} {{ symbol }}
{%- endfor %}

/** Scalar of every quantity. */
typedef {{ real }} {{ name }}_real;

/**
 * @brief The program, unrolled. {{ promise }}
{%- for array in arrays %}
 * @param[in] {{ array.name }} [{{ array.len }}]
{%- endfor %}
 * @param[out] out the results, row-major, [{{ outputs }}]
 */
void {{ name }}_run({{ signature }});

#ifdef __cplusplus
}
#endif

#endif /* {{ guard }} */
