#include <{{ name }}.h>

{% if dof -%}
/* {{ "rad (m for prismatic joints)" if floats else "rad * 2^" ~ name ~ "_Q_FRACTION_BITS" }}, in the order of {{ name }}_joint_names */
{% endif -%}
{{ name }}_real q[{{ name ~ "_DOF" if dof else "1" }}] = {0};
/* {{ "m" if floats else "m * 2^" ~ name ~ "_COM_FRACTION_BITS" }}, in the frame of the support */
{{ name }}_real com[3];
{{ name }}_com(q, {{ name }}_{{ params }}, com);
