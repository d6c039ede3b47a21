/* value * 2^bits. A product: shifting a negative number up is undefined. */
#define {{ name }}_shift_up(value, bits) \
    ((int64_t)(value) * ((int64_t)1 << (bits)))
