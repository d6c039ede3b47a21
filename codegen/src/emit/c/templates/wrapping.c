/* Inside the ranges of all inputs nothing overflows; for others sums wrap, as angles do. */
{%- if has_add %}
#define {{ name }}_add(a, b) \
    ((int32_t)((uint32_t)(a) + (uint32_t)(b)))
{%- endif %}
{%- if has_subtract %}
#define {{ name }}_subtract(a, b) \
    ((int32_t)((uint32_t)(a) - (uint32_t)(b)))
{%- endif %}
