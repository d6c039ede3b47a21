/*
 * The OP2 on its right foot: where its centre of mass is, and how far the centre
 * of pressure is inside the sole.
 *
 *     stdin    a posture a line: servo ticks in the order of the joint names
 *     stdout   CoM x y z, CoP x y, margin of the CoP, mm
 *
 * On the robot, ticks come from the servo bus instead. Behind the library
 * everything is in whole micrometres, so both arithmetics share it.
 */

#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "robot.h"

struct point {
    int32_t x_um;
    int32_t y_um;
};

/*
 * Corners of the right sole in its frame, counter-clockwise seen from above:
 * -52 to 53 mm about the ankle lengthwise, 66 mm wide (ROBOTIS-OP2-Common,
 * meshes of robotis_op2_description). The real corners are slightly bevelled.
 */
#define CORNERS 4u
static const struct point sole[CORNERS] = {
    {53000, 33000},
    {-52000, 33000},
    {-52000, -33000},
    {53000, -33000}
};

#ifdef ROBOT_FIXED

static int32_t micrometres(ROBOT(real) metres, uint32_t fraction_bits)
{
    const int64_t scaled = (int64_t)metres * 1000000;
    return (int32_t)((scaled + ((int64_t)1 << (fraction_bits - 1u))) >> fraction_bits);
}

#define COM_UM(metres) micrometres((metres), ROBOT(COM_FRACTION_BITS))
#define COP_UM(metres) micrometres((metres), ROBOT(COP_FRACTION_BITS))

#else

static int32_t micrometres(ROBOT(real) metres)
{
    const ROBOT(real) scaled = metres * 1.0e6f;
    return (int32_t)((scaled < 0.0f) ? (scaled - 0.5f) : (scaled + 0.5f));
}

#define COM_UM(metres) micrometres(metres)
#define COP_UM(metres) micrometres(metres)

#endif

/* Square root, rounded down. */
static int64_t root(int64_t square)
{
    int64_t guess = square;
    int64_t better = (square + 1) / 2;
    while (better < guess) {
        guess = better;
        better = (guess + (square / guess)) / 2;
    }
    return guess;
}

/* Smallest signed distance of p to the lines through the edges, um: positive inside. */
static int32_t margin(struct point p)
{
    int64_t least = INT32_MAX;
    for (uint32_t k = 0u; k < CORNERS; k += 1u) {
        const struct point a = sole[k];
        const struct point b = sole[(k + 1u) % CORNERS];
        const int64_t dx = (int64_t)b.x_um - a.x_um;
        const int64_t dy = (int64_t)b.y_um - a.y_um;
        const int64_t area = (dx * ((int64_t)p.y_um - a.y_um)) - (dy * ((int64_t)p.x_um - a.x_um));
        const int64_t distance = area / root((dx * dx) + (dy * dy));
        if (distance < least) {
            least = distance;
        }
    }
    return (int32_t)least;
}

static void print_mm(int32_t um)
{
    const char *sign = (um < 0) ? "-" : "";
    const int32_t size = (um < 0) ? -um : um;
    (void)printf(" %s%" PRId32 ".%03" PRId32, sign, size / 1000, size % 1000);
}

/* How many ticks the line begins with; -1 where something else follows them. */
static int read_ticks(const char *line, int32_t ticks[ROBOT(DOF)])
{
    int count = 0;
    const char *at = line;
    while (count < ROBOT(DOF)) {
        char *after = NULL;
        const long tick = strtol(at, &after, 10);
        if (after == at) {
            break;
        }
        ticks[count] = (int32_t)tick;
        count += 1;
        at = after;
    }
    while ((*at == ' ') || (*at == '\t') || (*at == '\r') || (*at == '\n')) {
        at += 1;
    }
    return (*at == '\0') ? count : -1;
}

int main(void)
{
    char line[512];
    if (ROBOT(selftest)() != 0) {
        (void)fprintf(stderr, "the self-test failed: wrong compiler options?\n");
        return 1;
    }
    for (long number = 1; fgets(line, (int)sizeof line, stdin) != NULL; number += 1) {
        int32_t ticks[ROBOT(DOF)];
        if (read_ticks(line, ticks) != ROBOT(DOF)) {
            (void)fprintf(stderr, "line %ld: give %d ticks, %s to %s\n", number, ROBOT(DOF),
                          ROBOT(joint_names)[0], ROBOT(joint_names)[ROBOT(DOF) - 1]);
            return 2;
        }
        ROBOT(real) com[3];
        ROBOT(real) cop[2];
        ROBOT(com_ticks)(ticks, ROBOT(cad_params), com);
        ROBOT(cop_ticks)(ticks, ROBOT(cad_params), cop);
        const struct point pressure = {COP_UM(cop[0]), COP_UM(cop[1])};
        (void)printf("CoM");
        for (uint32_t k = 0u; k < 3u; k += 1u) {
            print_mm(COM_UM(com[k]));
        }
        (void)printf("  CoP");
        print_mm(pressure.x_um);
        print_mm(pressure.y_um);
        (void)printf("  margin");
        print_mm(margin(pressure));
        (void)printf("\n");
    }
    return 0;
}
