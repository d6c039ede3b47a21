/* The nearest number in [-1, 1]; NaN for NaN. */
static {{ real }} {{ name }}_clamp({{ real }} x)
{
    const {{ real }} above = (x < -1.0{{ suffix }}) ? -1.0{{ suffix }} : x;
    return (above > 1.0{{ suffix }}) ? 1.0{{ suffix }} : above;
}
