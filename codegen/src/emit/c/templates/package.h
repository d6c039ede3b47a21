/*
{%- for line in about %}
 *{{ " " if line }}{{ line }}
{%- endfor %}
 */

#ifndef {{ guard }}
#define {{ guard }}
{% if has_lanes or includes_stdint %}
{%- if has_lanes %}
#include <stddef.h>
{%- endif %}
{%- if includes_stdint %}
#include <stdint.h>
{%- endif %}
{% endif %}
#ifdef __cplusplus
extern "C" {
#endif

/** Scalar of every quantity{{ scalar_note }}. */
typedef {{ real }} {{ name }}_real;

/** Present in the header of one run of sesc alone; the source refuses any other header. */
#define {{ name }}_PAIR_{{ pair }}

/** Number of independent joints. */
#define {{ name }}_DOF {{ dof }}
/** Number of base parameters: columns that data can tell apart. */
#define {{ name }}_BASE_PARAMS {{ base_params }}
/** Number of SESC parameters r_0, r_1, ... (and s of prismatic joints). */
#define {{ name }}_FULL_PARAMS {{ full_params }}
{%- if context %}
/** Number of what effects depend on beside q and r: the context of model_com and model_cop. */
#define {{ name }}_CONTEXT {{ context }}
{%- endif %}
{%- for point in points %}

/** Fraction bits of {{ point.of }}: value = integer / 2^{{ point.bits }}. */
#define {{ name }}_{{ point.name }}_FRACTION_BITS {{ point.bits }}
{%- endfor %}
{%- if joints %}

/** Index of each joint in q. */
enum {{ name }}_joint {
{%- for joint in joints %}
    {{ name }}_JOINT_{{ joint }} = {{ loop.index0 }}{{ "," if not loop.last }}
{%- endfor %}
};
{%- endif %}
{%- for constant in constants %}

/** {{ constant.brief }} */
extern {{ constant.declaration }};
{%- endfor %}
{%- if ticks %}

/*
 * Servo ticks:
 *
 *     revolute    q = sign (ticks - zero) 2 pi / (ticks a turn), rad
 *     prismatic   q = sign (ticks - zero) (m a tick), m
 *
{%- for line in ticks %}
 *     {{ line }}
{%- endfor %}
 *
{%- for line in ticks_beyond %}
 * {{ line }}
{%- endfor %}
 */
{%- endif %}
{%- if has_lanes %}

/*
 * Functions of many postures (_batch) take and give structures of arrays:
 *
 *     q[j * n + i]      joint j of posture i
 *     com[k * n + i]    entry k of posture i's result; rows of a matrix follow each other
 *
 * n may be any number of postures, also none. Arrays need no alignment beyond that of their
 * numbers; beyond their n columns nothing is read or written. Functions are quickest where
 * arrays begin at multiples of 64 bytes and n numbers fill no multiple of 4096 bytes: columns
 * would then all meet in the same lines of the first cache. Parameters r are one set for all
 * postures. Units, domains and bounds are those of the function of one posture, and so is
 * every bit of a result where products and sums are rounded each by itself
 * (-ffp-contract=off); a posture out of the domain leaves the others alone.
 *
 * The source computes as many postures side by side as a register of the target holds, at most
 * {{ most_lanes }}, with the vector types of gcc and clang: say -O3 and the processor (-march=native).
 */
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
void {{ name }}_{{ function.name }}({{ function.declaration }});
{%- endfor %}
{%- include "estimator.h" %}

/**
 * @brief Check the compiled functions against what the generator computed by another way.
 * @return 0 on agreement; else the sum of {{ selftest_weights }}.
 */
int {{ name }}_selftest(void);

/*
 * A call of the self-test by its name takes this symbol, which only the source that was written
 * with this header defines: a program that was compiled with the header of another run of sesc
 * does not link.
 */
int {{ name }}_selftest_{{ pair }}(void);
#ifndef {{ name }}_SOURCE
#define {{ name }}_selftest() \
    {{ name }}_selftest_{{ pair }}()
#endif

#ifdef __cplusplus
}
#endif

#endif /* {{ guard }} */
