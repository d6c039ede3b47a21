#ifdef {{ name }}_USE_LIBM

static void {{ name }}_sincos(float x, float *sine, float *cosine)
{
    *sine = sinf(x);
    *cosine = cosf(x);
}

#else

{% include "bits.c" %}

{% include "steps_f32.c" %}

#endif
