/* The nearest number in [-1, 1], 30 bits below the point: of x, where 1 is `one` and a unit is
 * `unit` of the result. */
static {{ name }}_real {{ name }}_clamp({{ name }}_real x, {{ name }}_real one, {{ name }}_real unit)
{
    const {{ name }}_real above = (x < -one) ? -one : x;
    const {{ name }}_real inside = (above > one) ? one : above;
    return inside * unit;
}
