/*
 * The self-test, then the bits of what every function says of every posture:
 *
 *     com_ticks 3dcd0d3c 3dfc89c0 3e3476d2
 */

#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "postures.h"
#include "robot.h"

#define COLUMNS ((uint32_t)ROBOT(BASE_PARAMS))
#define JOINTS ((uint32_t)ROBOT(DOF))

static ROBOT(real) out[3 * ROBOT(FULL_PARAMS)];

static void print(const char *function, uint32_t count)
{
    (void)printf("%s", function);
    for (uint32_t k = 0u; k < count; k += 1u) {
        uint32_t bits;
        (void)memcpy(&bits, &out[k], sizeof bits);
        (void)printf(" %08lx", (unsigned long)bits);
    }
    (void)printf("\n");
}

#define SHOW(function, count, ...)            \
    do {                                      \
        ROBOT(function)(__VA_ARGS__, out);    \
        print(#function, (count));            \
    } while (0)

#ifndef ROBOT_FIXED
/* Parameters and their deviations from all postures, with one reading for each. */
static void estimate(void)
{
    static ROBOT(estimator) estimator;
    static ROBOT(real) r_std[ROBOT(BASE_PARAMS)];
    static const ROBOT(real) cop_std[2] = {1.0e-3f, 2.0e-3f};
    int refused;
    for (uint32_t k = 0u; k < COLUMNS; k += 1u) {
        r_std[k] = 0.01f;
    }
    refused = ROBOT(estimator_init)(&estimator, ROBOT(cad_params), r_std, cop_std);
    for (uint32_t k = 0u; k < POSTURES; k += 1u) {
        ROBOT(cop)(q[k], ROBOT(cad_params), out);
        out[0] += 0.003f;
        refused += ROBOT(estimator_add)(&estimator, q[k], out);
    }
    (void)printf("refused %08lx\n", (unsigned long)refused);
    ROBOT(estimator_solve)(&estimator, out, r_std);
    print("estimator_params", COLUMNS);
    (void)memcpy(out, r_std, sizeof r_std);
    print("estimator_std", COLUMNS);
}
#endif

int main(void)
{
    const ROBOT(real) *r = ROBOT(cad_params);
    const int failed = ROBOT(selftest)();
    (void)printf("selftest %08lx\n", (unsigned long)failed);
    for (uint32_t k = 0u; k < POSTURES; k += 1u) {
        SHOW(com, 3u, q[k], r);
        SHOW(com_jacobian, 3u * JOINTS, q[k], r);
        SHOW(com_velocity, 3u, q[k], qd[k], r);
        SHOW(gravity_moments, JOINTS, q[k], r);
        SHOW(regressor, 3u * COLUMNS, q[k]);
        SHOW(regressor_cop, 2u * COLUMNS, q[k]);
        SHOW(regressor_full, 3u * ROBOT(FULL_PARAMS), q[k]);
        SHOW(cop, 2u, q[k], r);
        SHOW(com_sc, 3u, sin_q[k], cos_q[k], r);
        SHOW(com_jacobian_sc, 3u * JOINTS, sin_q[k], cos_q[k], r);
        SHOW(com_velocity_sc, 3u, sin_q[k], cos_q[k], qd[k], r);
        SHOW(gravity_moments_sc, JOINTS, sin_q[k], cos_q[k], r);
        SHOW(regressor_sc, 3u * COLUMNS, sin_q[k], cos_q[k]);
        SHOW(regressor_cop_sc, 2u * COLUMNS, sin_q[k], cos_q[k]);
        SHOW(regressor_full_sc, 3u * ROBOT(FULL_PARAMS), sin_q[k], cos_q[k]);
        SHOW(cop_sc, 2u, sin_q[k], cos_q[k], r);
        SHOW(com_ticks, 3u, ticks[k], r);
        SHOW(com_jacobian_ticks, 3u * JOINTS, ticks[k], r);
        SHOW(com_velocity_ticks, 3u, ticks[k], qd[k], r);
        SHOW(gravity_moments_ticks, JOINTS, ticks[k], r);
        SHOW(regressor_ticks, 3u * COLUMNS, ticks[k]);
        SHOW(regressor_cop_ticks, 2u * COLUMNS, ticks[k]);
        SHOW(regressor_full_ticks, 3u * ROBOT(FULL_PARAMS), ticks[k]);
        SHOW(cop_ticks, 2u, ticks[k], r);
#ifndef ROBOT_FIXED
        SHOW(zmp, 2u, q[k], slow[k], qdd[k], r);
        SHOW(zmp_sc, 2u, sin_q[k], cos_q[k], slow[k], qdd[k], r);
        SHOW(zmp_ticks, 2u, ticks[k], slow[k], qdd[k], r);
#endif
    }
#ifndef ROBOT_FIXED
    estimate();
#endif
    return failed;
}
