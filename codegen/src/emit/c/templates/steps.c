/*
 * Sine and cosine of x rad, each within {{ "0.85 ulp for |x| <= 1024" if suffix else "0.9 ulp for |x| <= 2^20" }}, NaN beyond.
 *
 *     pi/2 = P1 + P2 + P3 + P4     {{ "14, 14, 14 and 24" if suffix else "33, 33, 33 and 53" }} bits
 *     r    = ((({{ "x" if lanes else "|x|" }} - k P1) - k P2) - k P3) - k P4
 *
 * The first three products are exact. No branch, no call, no conversion.
 */
static {{ "inline " if lanes }}void {{ name }}_sincos{{ lanes }}({{ of }} x, {{ of }} *sine, {{ of }} *cosine)
{
{% include "reduction_" ~ format ~ ".c" %}
{% include "series_" ~ format ~ ".c" %}
}
