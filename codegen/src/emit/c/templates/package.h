/*
{%- for line in about %}
 *{{ " " if line }}{{ line }}
{%- endfor %}
 */

#ifndef {{ guard }}
#define {{ guard }}
{% if includes_stdint %}
#include <stdint.h>
{% endif %}
#ifdef __cplusplus
extern "C" {
#endif

/** Scalar of every quantity{{ scalar_note }}. */
typedef {{ real }} {{ name }}_real;

/** Number of independent joints. */
#define {{ name }}_DOF {{ dof }}
/** Number of base parameters: columns that data can tell apart. */
#define {{ name }}_BASE_PARAMS {{ base_params }}
/** Number of SESC parameters r_0, r_1, ... (and s of sliding joints). */
#define {{ name }}_FULL_PARAMS {{ full_params }}
{%- for point in points %}

/** Fraction bits of {{ point.of }}: value = integer / 2^{{ point.bits }}. */
#define {{ name }}_{{ point.name }}_FRACTION_BITS {{ point.bits }}
{%- endfor %}
{%- if dof > 0 %}

/** Joints in the order of q. */
extern const char *const {{ name }}_joint_names[{{ name }}_DOF];
{%- endif %}

/** Base parameters from CAD, {{ unit }}. */
extern const {{ name }}_real {{ name }}_cad_params[{{ name }}_BASE_PARAMS];

/** Largest |r[k]| that ranges and rounding bounds are proven for. */
extern const {{ name }}_real {{ name }}_param_limits[{{ name }}_BASE_PARAMS];
{%- if model_source %}

/** Identified base parameters, {{ unit }}, from a model file (source: {{ model_source }}). */
extern const {{ name }}_real {{ name }}_model_params[{{ name }}_BASE_PARAMS];
{%- endif %}
{%- for function in functions %}

/**
 * @brief {{ function.brief }}
{%- for line in function.details %}
 * {{ line }}
{%- endfor %}
{%- for parameter in function.parameters %}
 * @param[{{ parameter.direction }}] {{ parameter.name }} {{ parameter.meaning }}
{%- endfor %}
 */
void {{ name }}_{{ function.name }}({{ function.signature }});
{%- endfor %}

/**
 * @brief Check the compiled functions against what the generator computed by another way.
 * @return 0 on agreement; else the sum of {{ selftest_weights }}.
 */
int {{ name }}_selftest(void);

#ifdef __cplusplus
}
#endif

#endif /* {{ guard }} */
