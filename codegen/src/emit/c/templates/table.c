
/* sin(k pi / 2048) for k = 0 .. 1024: a quarter of the 4096 steps of a turn. */
static const {{ name }}_real {{ name }}_quarter[1025] = {
{%- for line in quarter %}
    {{ line }}{{ "," if not loop.last }}
{%- endfor %}
};

/* Sine and cosine of step * 2 pi / 4096, any step. */
static void {{ name }}_lookup(uint32_t step, {{ name }}_real *sine, {{ name }}_real *cosine)
{
    const uint32_t quadrant = (step >> 10) & 3u;
    const uint32_t near = step & 1023u;
    /* Odd quadrants run backwards: near or 1024 - near. */
    const uint32_t odd = quadrant & 1u;
    const uint32_t at = (near ^ (0u - odd)) + (1025u * odd);
    const {{ name }}_real s = {{ name }}_quarter[at];
    const {{ name }}_real c = {{ name }}_quarter[1024u - at];
    *sine = (quadrant >= 2u) ? -s : s;
    *cosine = (((quadrant + 1u) & 2u) != 0u) ? -c : c;
}
