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
