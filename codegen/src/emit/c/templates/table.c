/* sin(k pi / 2048) for k = 0 .. 1024: a quarter of the 4096 steps of a turn. */
static const {{ name }}_real {{ name }}_quarter[1025] = {
{%- for line in quarter %}
    {{ line }}{{ "," if not loop.last }}
{%- endfor %}
};

/* Sine and cosine of step * 2 pi / 4096, any step. */
static void {{ name }}_lookup(uint32_t step, {{ name }}_real *sine, {{ name }}_real *cosine)
{
    const uint32_t rising = step & 1023u;
    const uint32_t falling = 1024u - rising;
    /* Odd quadrants run backwards; sin < 0 in 2 and 3, cos < 0 in 1 and 2. No branch. */
    const uint32_t swap = (rising ^ falling) & (0u - ((step >> 10) & 1u));
    const {{ name }}_real s = {{ name }}_quarter[rising ^ swap];
    const {{ name }}_real c = {{ name }}_quarter[falling ^ swap];
    *sine = ((step & 2048u) != 0u) ? -s : s;
    *cosine = (((step + 1024u) & 2048u) != 0u) ? -c : c;
}
