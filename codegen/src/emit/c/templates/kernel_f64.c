#ifdef {{ name }}_USE_LIBM

static void {{ name }}_sincos(double x, double *sine, double *cosine)
{
    *sine = sin(x);
    *cosine = cos(x);
}

#else

{% include "bits.c" %}

{% include "steps_f64.c" %}

#endif
