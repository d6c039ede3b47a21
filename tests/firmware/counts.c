/*
 * Every function once for each posture, and some whose length is known, to be
 * counted from outside: what runs between leaving measure() and coming back to
 * it is one call. Nothing is printed.
 */

#include <stdint.h>

#include "postures.h"
#include "robot.h"

/* Of known.S: 1, 3 + 2 n and 5 instructions. */
extern void known_return(void);
extern void known_loop(uint32_t n);
extern void known_skip(uint32_t n);

extern void measure(void);

#ifndef ROBOT_FIXED
static ROBOT(estimator) estimator;
static ROBOT(real) known[ROBOT(BASE_PARAMS)];
static const ROBOT(real) reading[2] = {0.01f, -0.02f};
#endif

static ROBOT(real) out[3 * ROBOT(FULL_PARAMS)];

void measure(void)
{
    const ROBOT(real) *r = ROBOT(cad_params);
    known_return();
    known_loop(1000u);
    known_skip(0u);
    for (uint32_t k = 0u; k < POSTURES_COUNTED; k += 1u) {
        const int32_t *t = ticks[k];
        const ROBOT(real) *x = q[k];
        const ROBOT(real) *s = sin_q[k];
        const ROBOT(real) *c = cos_q[k];
        const ROBOT(real) *v = qd[k];
        ROBOT(com_ticks)(t, r, out);
        ROBOT(com_jacobian_ticks)(t, r, out);
        ROBOT(com_velocity_ticks)(t, v, r, out);
        ROBOT(gravity_moments_ticks)(t, r, out);
        ROBOT(regressor_ticks)(t, out);
        ROBOT(regressor_cop_ticks)(t, out);
        ROBOT(regressor_full_ticks)(t, out);
        ROBOT(cop_ticks)(t, r, out);
        ROBOT(com)(x, r, out);
        ROBOT(com_jacobian)(x, r, out);
        ROBOT(com_velocity)(x, v, r, out);
        ROBOT(gravity_moments)(x, r, out);
        ROBOT(regressor)(x, out);
        ROBOT(regressor_cop)(x, out);
        ROBOT(regressor_full)(x, out);
        ROBOT(cop)(x, r, out);
        ROBOT(com_sc)(s, c, r, out);
        ROBOT(com_jacobian_sc)(s, c, r, out);
        ROBOT(com_velocity_sc)(s, c, v, r, out);
        ROBOT(gravity_moments_sc)(s, c, r, out);
        ROBOT(regressor_sc)(s, c, out);
        ROBOT(regressor_cop_sc)(s, c, out);
        ROBOT(regressor_full_sc)(s, c, out);
        ROBOT(cop_sc)(s, c, r, out);
#ifndef ROBOT_FIXED
        ROBOT(zmp)(x, slow[k], qdd[k], r, out);
        ROBOT(zmp_sc)(s, c, slow[k], qdd[k], r, out);
        ROBOT(zmp_ticks)(t, slow[k], qdd[k], r, out);
        (void)ROBOT(estimator_add)(&estimator, x, reading);
        ROBOT(estimator_params)(&estimator, out);
        ROBOT(estimator_solve)(&estimator, out, known);
#endif
    }
}

int main(void)
{
#ifndef ROBOT_FIXED
    static const ROBOT(real) cop_std[2] = {1.0e-3f, 1.0e-3f};
    for (uint32_t k = 0u; k < ROBOT(BASE_PARAMS); k += 1u) {
        known[k] = 0.01f;
    }
    if (ROBOT(estimator_init)(&estimator, ROBOT(cad_params), known, cop_std) != 0) {
        return 1;
    }
#endif
    measure();
    return 0;
}
