/* wide / 2^bits, rounded to nearest; bits >= 1. */
static {{ name }}_real {{ name }}_narrow(int64_t wide, uint32_t bits)
{
    return ({{ name }}_real)((wide + ((int64_t)1 << (bits - 1u))) >> bits);
}
