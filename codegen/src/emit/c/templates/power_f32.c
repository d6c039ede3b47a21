#ifdef {{ name }}_USE_LIBM

static float {{ name }}_power(float x, float y)
{
    return powf(x, y);
}

#else
{% if "sincos" not in called %}
{% include "bits.c" %}
{% endif %}
/* The upper half of a mantissa: products of halves are exact. */
static float {{ name }}_high(float x)
{
    return {{ name }}_from_bits({{ name }}_bits_of(x) & 0xFFFFF000u);
}

/* What rounding lost of the product p of a and b. */
static float {{ name }}_lost(float a, float b, float p)
{
    const float a_high = {{ name }}_high(a);
    const float b_high = {{ name }}_high(b);
    const float a_low = a - a_high;
    const float b_low = b - b_high;
    return (((a_high * b_high) - p) + ((a_high * b_low) + (a_low * b_high))) + (a_low * b_low);
}

/*
 * x to the power of y, within 0.7 ulp, for x not negative; NaN for others.
 *
 *     x = 2^k m,  s = (m - 1)/(m + 1),  log2 x = k + 2/ln 2 atanh(s)
 *     y log2 x = n + t/ln 2,  x^y = 2^n e^t
 *
 * With _low: what rounding lost of the number before it. No loop, no call.
 */
static float {{ name }}_power(float x, float y)
{
    /* -0 counts as 0. Bits are ordered as magnitudes are, negative numbers and NaN last. */
    const uint32_t base = {{ name }}_bits_of(x + 0.0f);
    const uint32_t all = {{ name }}_bits_of(y);
    const uint32_t sign = all & 0x80000000u;
    const uint32_t size = all ^ sign;
    const uint32_t not_base = (base > 0x7F800000u) ? 0x7FC00000u : 0u;
    const uint32_t not_size = (size > 0x7F800000u) ? 0x7FC00000u : 0u;

    /* x below the normal numbers is scaled by 2^32. */
    const float scale = (base < 0x00800000u) ? 4294967296.0f : 1.0f;
    const float scaled_by = (base < 0x00800000u) ? 32.0f : 0.0f;
    const uint32_t scaled = {{ name }}_bits_of({{ name }}_from_bits(base) * scale);
    const uint32_t exponent = (scaled + 0x004AFB0Du) >> 23;
    const float k = ({{ name }}_from_bits(0x4B000000u | exponent) - 8388735.0f) - scaled_by;
    const float m = {{ name }}_from_bits((scaled + 0x3F800000u) - (exponent << 23));

    const float f = m - 1.0f;
    const float g = m + 1.0f;
    const float g_low = m - (g - 1.0f);
    const float s = f / g;
    const float p = s * g;
    const float s_low = (((f - p) - {{ name }}_lost(s, g, p)) - (s * g_low)) / g;

    /* atanh(s) = s + s (z/3 + z^2/5 + z^3/7 + ...),  z = s^2 */
    const float z = s * s;
    const float z_low = {{ name }}_lost(s, s, z) + ((s * s_low) * 2.0f);
    const float h = z * 0.33333334f;
    const float h_low = {{ name }}_lost(z, 0.33333334f, h) + ((z_low * 0.33333334f) + (z * -9.934108e-9f));
    float series = 1.0f / 13.0f;
    series = (1.0f / 11.0f) + (z * series);
    series = (1.0f / 9.0f) + (z * series);
    series = (1.0f / 7.0f) + (z * series);
    series = (1.0f / 5.0f) + (z * series);
    const float q = (z * z) * series;
    const float c = h + q;
    const float c_low = (q - (c - h)) + (h_low + ((z_low * z) * (series * 2.0f)));
    const float u = s * c;
    const float u_low = {{ name }}_lost(s, c, u) + ((s * c_low) + (s_low * c));
    const float a = s + u;
    const float a_low = (u - (a - s)) + (u_low + s_low);

    const float b = a * 2.88539f;
    const float b_low = {{ name }}_lost(a, 2.88539f, b) + ((a * 3.851926e-8f) + (a_low * 2.88539f));
    const float l = k + b;
    const float l_low = (b - (l - k)) + b_low;

    /* w = y log2 x; beyond +-200 the power is infinite or zero, as with y of 2^40. */
    const float v = {{ name }}_from_bits(((size < 0x53800000u) ? size : 0x53800000u) | sign);
    const float w = v * l;
    const float above = (w < -200.0f) ? -200.0f : w;
    const float held = (above > 200.0f) ? 200.0f : above;
    const float w_rest = {{ name }}_lost(v, l, w) + (v * l_low);
    const float w_low = ((w < -200.0f) || (w > 200.0f)) ? 0.0f : w_rest;

    /* A sum that has no room for a fraction rounds to the integer n. */
    const float shifted = held + 12582912.0f;
    const float rest = held - (shifted - 12582912.0f);
    const float r = rest + w_low;
    const float r_low = w_low - (r - rest);
    const float t = r * 0.6931472f;
    const float t_low = {{ name }}_lost(r, 0.6931472f, t) + ((r * -1.9046542e-9f) + (r_low * 0.6931472f));
    const float t2 = t * t;
    float taylor = 1.0f / 40320.0f;
    taylor = (1.0f / 5040.0f) + (t * taylor);
    taylor = (1.0f / 720.0f) + (t * taylor);
    taylor = (1.0f / 120.0f) + (t * taylor);
    taylor = (1.0f / 24.0f) + (t * taylor);
    taylor = (1.0f / 6.0f) + (t * taylor);
    const float e = 1.0f + t;
    const float e_low = t - (e - 1.0f);
    const float tail = (t2 * 0.5f) + ((t2 * t) * taylor);
    const float root = e + (e_low + (tail + (t_low * e)));

    /* 2^n in two steps: both are normal numbers, and only the last product rounds. */
    const uint32_t n = ({{ name }}_bits_of(shifted) - 0x4B400000u) + 254u;
    const uint32_t half = n >> 1;
    const float first = {{ name }}_from_bits(half << 23);
    const float second = {{ name }}_from_bits((n - half) << 23);
    const uint32_t found = {{ name }}_bits_of((root * first) * second);

    /* 0^y and infinity^y: one for y = 0, else zero or infinity. */
    const uint32_t of_zero = (sign != 0u) ? 0x7F800000u : 0u;
    const uint32_t of_infinity = (sign != 0u) ? 0u : 0x7F800000u;
    const uint32_t limit = (size == 0u) ? 0x3F800000u : ((base == 0u) ? of_zero : of_infinity);
    const uint32_t power = ((base == 0u) || (base == 0x7F800000u)) ? limit : found;
    return {{ name }}_from_bits((power | not_base) | not_size);
}

#endif
