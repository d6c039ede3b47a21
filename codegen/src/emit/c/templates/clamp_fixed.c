/* The nearest number in [-1, 1], 30 bits below the point, of one with so many bits. */
static {{ name }}_real {{ name }}_clamp({{ name }}_real x, uint32_t bits)
{
    const {{ name }}_real one = ({{ name }}_real)((uint32_t)1u << bits);
    const {{ name }}_real above = (x < -one) ? -one : x;
    const {{ name }}_real inside = (above > one) ? one : above;
    return inside * ({{ name }}_real)((uint32_t)1u << (30u - bits));
}
