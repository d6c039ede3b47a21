static {{ bits }} {{ name }}_bits_of({{ real }} x)
{
    {{ bits }} bits;
    (void)memcpy(&bits, &x, sizeof bits);
    return bits;
}

static {{ real }} {{ name }}_from_bits({{ bits }} bits)
{
    {{ real }} x;
    (void)memcpy(&x, &bits, sizeof x);
    return x;
}
