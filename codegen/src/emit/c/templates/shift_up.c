/* value * 2^bits. A product: shifting a negative number up is undefined. */
static int64_t {{ name }}_shift_up(int64_t value, uint32_t bits)
{
    return value * ((int64_t)1 << bits);
}
