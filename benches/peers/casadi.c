/* The functions that autocode.cpp wrote, as the measuring program calls them. */
#include "peers.h"

#ifdef SINGLE
/* CasADi writes sin and cos whatever the scalar; these take those of float. */
#include <tgmath.h>
#endif
#include CASADI_CODE

static SCALAR room[1 << 16];

#define CALL(NAME, Q, OUT)                              \
    {                                                   \
        const SCALAR *from[] = {Q};                     \
        SCALAR *to[] = {OUT};                           \
        casadi_##NAME##_raw(from, to, 0, room, 0);      \
    }

#ifdef SINGLE
#define OFFER(NAME, SIZE)                                                       \
    PEER void casadi_##NAME##_batch_f32(const float *q, size_t n, float *out)   \
    {                                                                           \
        for (size_t k = 0; k < n; ++k)                                          \
            CALL(NAME, q + 20 * k, out + SIZE * k)                              \
    }
#else
#define OFFER(NAME, SIZE)                                                       \
    PEER void casadi_##NAME(const double *q, double *out) CALL(NAME, q, out)    \
    PEER void casadi_##NAME##_batch(const double *q, size_t n, double *out)     \
    {                                                                           \
        for (size_t k = 0; k < n; ++k)                                          \
            CALL(NAME, q + 20 * k, out + SIZE * k)                              \
    }
#endif

OFFER(com, COM)
OFFER(jacobian, JACOBIAN)
OFFER(full, FULL)
OFFER(cop, COP)
