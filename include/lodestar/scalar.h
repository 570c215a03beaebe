/// Scalar arithmetic for any input: every float, NaN and Inf included, gives a finite result.
#ifndef LODESTAR_SCALAR_H
#define LODESTAR_SCALAR_H

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "lodestar/platform.h"

#ifdef __cplusplus
extern "C" {
#endif

#define LODE_PI 3.14159265358979324f
#define LODE_TWO_PI 6.28318530717958648f
#define LODE_HALF_PI 1.57079632679489662f
#define LODE_SQRT3 1.73205080756887729f

/// Largest argument of sine and cosine, rad. Beyond it floats are more than 1e-4 rad apart, too coarse for an
/// angle.
#define LODE_ANGLE_LIMIT_rad 2048.0f

typedef struct {
    float sin;
    float cos;
} lode_sincos_t;

/// lo <= x <= hi. False for NaN, also where NaN compares like infinity (C28x FPU).
LODE_INLINE bool lode_in_range(float x, float lo, float hi) {
    return x >= lo && x <= hi;
}

LODE_INLINE float lode_min(float a, float b) {
    return a < b ? a : b;
}

LODE_INLINE float lode_max(float a, float b) {
    return a > b ? a : b;
}

LODE_INLINE float lode_abs(float x) {
    return fabsf(x);
}

/// Neither infinite nor NaN.
LODE_INLINE bool lode_is_finite(float x) {
    return lode_abs(x) <= FLT_MAX;
}

/// -1 for x < 0, else +1 (for NaN too).
LODE_INLINE float lode_sign(float x) {
    return x < 0.0f ? -1.0f : 1.0f;
}

/// x limited to [lo, hi]; lo for NaN.
LODE_SHARED LODE_SMALL_CALL float lode_clamp(float x, float lo, float hi);
LODE_SHARED LODE_SMALL_CALL float lode_clamp(float x, float lo, float hi) {
    return x > lo ? (x < hi ? x : hi) : lo;
}

/// Square root; 0 for negative x and NaN.
LODE_INLINE float lode_sqrt(float x) {
    return x > 0.0f ? sqrtf(x) : 0.0f;
}

/// Takes off one turn at most: x in [-3 pi, 3 pi] gives a result in [-pi, pi]; a larger magnitude becomes 2 pi
/// smaller.
LODE_INLINE float lode_wrap_once(float x) {
    const float down = x > LODE_PI ? x - LODE_TWO_PI : x;
    return x < -LODE_PI ? x + LODE_TWO_PI : down;
}

/// Angle in [-pi, pi], for any x up to LODE_ANGLE_LIMIT_rad; 0 beyond and for NaN.
float lode_wrap(float x_rad);

/// Sine and cosine. Error at most 1e-6; beyond LODE_ANGLE_LIMIT_rad and for NaN the values of angle 0.
lode_sincos_t lode_sincos(float x_rad);

#ifdef LODE_SINCOS_BOARD
/// The board's own sine and cosine. With LODE_SINCOS_BOARD defined for the library, lode_sincos() calls it instead
/// of its polynomials, with |x| <= LODE_ANGLE_LIMIT_rad. Required error: at most 1e-5. The interrupt and threads
/// call it, so it must be reentrant.
lode_sincos_t lode_sincos_board(float x_rad);
#endif

/// Angle of the vector (x, y) in [-pi, pi]. Error at most 1e-6 rad; 0 for (0, 0) and for NaN.
float lode_atan2(float y, float x);

/// 1 - exp(-x) without cancellation, for x >= 0; 0 for negative x and NaN. For init: it iterates.
float lode_one_minus_exp(float x);

#ifdef __cplusplus
}
#endif

#endif
