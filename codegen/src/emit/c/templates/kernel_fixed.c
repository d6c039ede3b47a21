/*
 * Sine and cosine, 30 fraction bits, of an angle with the given fraction bits:
 * the angle as a phase of 2^32 a turn, the nearest step of the table, and for the
 * rest d, below 0.00077 rad, sin(a + d) = sin a + d cos a - d^2/2 sin a.
 */
static void {{ name }}_sincos(int32_t angle, uint32_t bits, int32_t *sine, int32_t *cosine)
{
    /* 2^33 / (2 pi) and 2 pi 2^26, rounded. */
    const int64_t turned = (int64_t)angle * 1367130551;
    const uint32_t phase = (uint32_t)(uint64_t)((turned + ((int64_t)1 << bits)) >> (bits + 1u));
    const uint32_t step = (phase + 0x80000u) >> 20;
    const uint32_t beside = phase - (step << 20);
    const int32_t rest = (int32_t)beside;
    const int32_t d = (int32_t)(((int64_t)rest * 421657428) >> 18);
    const int32_t half_d2 = (int32_t)(((int64_t)d * d) >> 41);
    int32_t s;
    int32_t c;
    {{ name }}_lookup(step, &s, &c);
    *sine = s + {{ name }}_narrow(((int64_t)c * d) - ((int64_t)s * half_d2), 40u);
    *cosine = c - {{ name }}_narrow(((int64_t)s * d) + ((int64_t)c * half_d2), 40u);
}
