/* What every peer offers to the measuring program: plain C functions over
 * postures in the peer's own joint order, results wherever they are to go.
 *
 *     peer_joint(i)                     name of joint i
 *     NAME(q, out)                      one posture
 *     NAME_batch(q, n, out)             n postures, one after the other
 *     NAME_batch_f32(q, n, out)         the same in single precision
 *     NAME_fit(rows, q, reading, n, out)
 *
 * Results are columns of 3 (com, jacobian, full) or 2 (cop rows). */
#pragma once
#include <stddef.h>

#ifdef __cplusplus
#define PEER extern "C" __attribute__((visibility("default")))
#else
#define PEER __attribute__((visibility("default")))
#endif

enum { COM = 3, JACOBIAN = 3 * 20, FULL = 3 * 60, COP = 2 * 42 };

/* CoP rows of one posture. */
typedef void (*peer_rows)(const double *q, double *rows);
