/* The generated robot, in the arithmetic that the build chooses. */

#ifndef ROBOT_H
#define ROBOT_H

#ifdef ROBOT_FIXED
#include "op2_r_sole_fixed.h"
#define ROBOT(word) op2_r_sole_fixed_##word
#else
#include "op2_r_sole.h"
#define ROBOT(word) op2_r_sole_##word
#endif

#endif
