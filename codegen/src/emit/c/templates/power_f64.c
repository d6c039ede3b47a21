#ifdef {{ name }}_USE_LIBM

static double {{ name }}_power(double x, double y)
{
    return pow(x, y);
}

#else
{% if "sincos" not in called %}
{% include "bits.c" %}
{% endif %}
/* The upper half of a mantissa: products of halves are exact. */
static double {{ name }}_high(double x)
{
    return {{ name }}_from_bits({{ name }}_bits_of(x) & ~(uint64_t)0x07FFFFFF);
}

/* What rounding lost of the product p of a and b. */
static double {{ name }}_lost(double a, double b, double p)
{
    const double a_high = {{ name }}_high(a);
    const double b_high = {{ name }}_high(b);
    const double a_low = a - a_high;
    const double b_low = b - b_high;
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
static double {{ name }}_power(double x, double y)
{
    /* -0 counts as 0. Bits are ordered as magnitudes are, negative numbers and NaN last. */
    const uint64_t base = {{ name }}_bits_of(x + 0.0);
    const uint64_t all = {{ name }}_bits_of(y);
    const uint64_t sign = all & ((uint64_t)1 << 63);
    const uint64_t size = all ^ sign;
    const uint64_t not_base = (base > UINT64_C(0x7FF0000000000000)) ? UINT64_C(0x7FF8000000000000) : (uint64_t)0;
    const uint64_t not_size = (size > UINT64_C(0x7FF0000000000000)) ? UINT64_C(0x7FF8000000000000) : (uint64_t)0;

    /* x below the normal numbers is scaled by 2^64. */
    const double scale = (base < UINT64_C(0x0010000000000000)) ? 18446744073709551616.0 : 1.0;
    const double scaled_by = (base < UINT64_C(0x0010000000000000)) ? 64.0 : 0.0;
    const uint64_t scaled = {{ name }}_bits_of({{ name }}_from_bits(base) * scale);
    const uint64_t exponent = (scaled + UINT64_C(0x00095F619980C433)) >> 52;
    const double k = ({{ name }}_from_bits(UINT64_C(0x4330000000000000) | exponent) - 4503599627371519.0) - scaled_by;
    const double m = {{ name }}_from_bits((scaled + UINT64_C(0x3FF0000000000000)) - (exponent << 52));

    const double f = m - 1.0;
    const double g = m + 1.0;
    const double g_low = m - (g - 1.0);
    const double s = f / g;
    const double p = s * g;
    const double s_low = (((f - p) - {{ name }}_lost(s, g, p)) - (s * g_low)) / g;

    /* atanh(s) = s + s (z/3 + z^2/5 + z^3/7 + ...),  z = s^2 */
    const double z = s * s;
    const double z_low = {{ name }}_lost(s, s, z) + ((s * s_low) * 2.0);
    const double h = z * 0.3333333333333333;
    const double h_low = {{ name }}_lost(z, 0.3333333333333333, h) + ((z_low * 0.3333333333333333) + (z * 1.850371707708594e-17));
    double series = 1.0 / 25.0;
    series = (1.0 / 23.0) + (z * series);
    series = (1.0 / 21.0) + (z * series);
    series = (1.0 / 19.0) + (z * series);
    series = (1.0 / 17.0) + (z * series);
    series = (1.0 / 15.0) + (z * series);
    series = (1.0 / 13.0) + (z * series);
    series = (1.0 / 11.0) + (z * series);
    series = (1.0 / 9.0) + (z * series);
    series = (1.0 / 7.0) + (z * series);
    series = (1.0 / 5.0) + (z * series);
    const double q = (z * z) * series;
    const double c = h + q;
    const double c_low = (q - (c - h)) + (h_low + ((z_low * z) * (series * 2.0)));
    const double u = s * c;
    const double u_low = {{ name }}_lost(s, c, u) + ((s * c_low) + (s_low * c));
    const double a = s + u;
    const double a_low = (u - (a - s)) + (u_low + s_low);

    const double b = a * 2.8853900817779268;
    const double b_low = {{ name }}_lost(a, 2.8853900817779268, b) + ((a * 4.0710547481862066e-17) + (a_low * 2.8853900817779268));
    const double l = k + b;
    const double l_low = (b - (l - k)) + b_low;

    /* w = y log2 x; beyond +-1100 the power is infinite or zero, as with y of 2^64. */
    const double v = {{ name }}_from_bits(((size < UINT64_C(0x43F0000000000000)) ? size : UINT64_C(0x43F0000000000000)) | sign);
    const double w = v * l;
    const double above = (w < -1100.0) ? -1100.0 : w;
    const double held = (above > 1100.0) ? 1100.0 : above;
    const double w_rest = {{ name }}_lost(v, l, w) + (v * l_low);
    const double w_low = ((w < -1100.0) || (w > 1100.0)) ? 0.0 : w_rest;

    /* A sum that has no room for a fraction rounds to the integer n. */
    const double shifted = held + 6755399441055744.0;
    const double rest = held - (shifted - 6755399441055744.0);
    const double r = rest + w_low;
    const double r_low = w_low - (r - rest);
    const double t = r * 0.6931471805599453;
    const double t_low = {{ name }}_lost(r, 0.6931471805599453, t) + ((r * 2.3190468138462996e-17) + (r_low * 0.6931471805599453));
    const double t2 = t * t;
    double taylor = 1.0 / 87178291200.0;
    taylor = (1.0 / 6227020800.0) + (t * taylor);
    taylor = (1.0 / 479001600.0) + (t * taylor);
    taylor = (1.0 / 39916800.0) + (t * taylor);
    taylor = (1.0 / 3628800.0) + (t * taylor);
    taylor = (1.0 / 362880.0) + (t * taylor);
    taylor = (1.0 / 40320.0) + (t * taylor);
    taylor = (1.0 / 5040.0) + (t * taylor);
    taylor = (1.0 / 720.0) + (t * taylor);
    taylor = (1.0 / 120.0) + (t * taylor);
    taylor = (1.0 / 24.0) + (t * taylor);
    taylor = (1.0 / 6.0) + (t * taylor);
    const double e = 1.0 + t;
    const double e_low = t - (e - 1.0);
    const double tail = (t2 * 0.5) + ((t2 * t) * taylor);
    const double root = e + (e_low + (tail + (t_low * e)));

    /* 2^n in two steps: both are normal numbers, and only the last product rounds. */
    const uint64_t n = ({{ name }}_bits_of(shifted) - UINT64_C(0x4338000000000000)) + (uint64_t)2046;
    const uint64_t half = n >> 1;
    const double first = {{ name }}_from_bits(half << 52);
    const double second = {{ name }}_from_bits((n - half) << 52);
    const uint64_t found = {{ name }}_bits_of((root * first) * second);

    /* 0^y and infinity^y: one for y = 0, else zero or infinity. */
    const uint64_t of_zero = (sign != (uint64_t)0) ? UINT64_C(0x7FF0000000000000) : (uint64_t)0;
    const uint64_t of_infinity = (sign != (uint64_t)0) ? (uint64_t)0 : UINT64_C(0x7FF0000000000000);
    const uint64_t limit = (size == (uint64_t)0) ? UINT64_C(0x3FF0000000000000) : ((base == (uint64_t)0) ? of_zero : of_infinity);
    const uint64_t power = ((base == (uint64_t)0) || (base == UINT64_C(0x7FF0000000000000))) ? limit : found;
    return {{ name }}_from_bits((power | not_base) | not_size);
}

#endif
