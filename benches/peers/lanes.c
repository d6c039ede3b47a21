/* Our own C for computers: functions of many postures, structures of arrays on both sides. */
#include "peers.h"

#include "lanes_f32.h"
#include "lanes_f64.h"

#define OFFER(SUFFIX, SCALAR, NAME)                                                        \
    PEER void lanes_com_batch##SUFFIX(const SCALAR *q, size_t n, SCALAR *out)              \
    {                                                                                      \
        NAME##_com_batch(n, q, NAME##_cad_params, out);                                    \
    }                                                                                      \
    PEER void lanes_jacobian_batch##SUFFIX(const SCALAR *q, size_t n, SCALAR *out)         \
    {                                                                                      \
        NAME##_com_jacobian_batch(n, q, NAME##_cad_params, out);                           \
    }                                                                                      \
    PEER void lanes_full_batch##SUFFIX(const SCALAR *q, size_t n, SCALAR *out)             \
    {                                                                                      \
        NAME##_regressor_full_batch(n, q, out);                                            \
    }                                                                                      \
    PEER void lanes_cop_batch##SUFFIX(const SCALAR *q, size_t n, SCALAR *out)              \
    {                                                                                      \
        NAME##_regressor_cop_batch(n, q, out);                                             \
    }

OFFER(, double, lanes_f64)
OFFER(_f32, float, lanes_f32)
