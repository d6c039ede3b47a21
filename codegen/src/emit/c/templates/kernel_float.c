#ifdef {{ name }}_USE_LIBM

static void {{ name }}_sincos({{ real }} x, {{ real }} *sine, {{ real }} *cosine)
{
    *sine = sin{{ suffix }}(x);
    *cosine = cos{{ suffix }}(x);
}

#else

{% include "bits.c" %}

{% include "steps.c" %}

#endif
