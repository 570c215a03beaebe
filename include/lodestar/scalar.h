/// Scalar arithmetic that is total: every float in, NaN and Inf included, a finite float out.
#ifndef LODESTAR_SCALAR_H
#define LODESTAR_SCALAR_H

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "lodestar/platform.h"

#define LODE_PI 3.14159265358979324f
#define LODE_TWO_PI 6.28318530717958648f
#define LODE_HALF_PI 1.57079632679489662f
#define LODE_SQRT3 1.73205080756887729f

/// Beyond this the argument of sine and cosine carries too little angle to be worth reducing: a
/// float there is spaced by more than 1e-4 rad.
#define LODE_ANGLE_LIMIT_rad 2048.0f

typedef struct {
    float sin;
    float cos;
} lode_sincos_t;

/// lo <= x <= hi. False for NaN, also where NaN compares like infinity (C28x FPU).
static inline bool lode_in_range(float x, float lo, float hi) {
    return x >= lo && x <= hi;
}

static inline bool lode_is_finite(float x) {
    return lode_in_range(x, -FLT_MAX, FLT_MAX);
}

static inline float lode_min(float a, float b) {
    return a < b ? a : b;
}

static inline float lode_max(float a, float b) {
    return a > b ? a : b;
}

static inline float lode_abs(float x) {
    return x < 0.0f ? -x : x;
}

/// -1 for x < 0, else +1 (for NaN too).
static inline float lode_sign(float x) {
    return x < 0.0f ? -1.0f : 1.0f;
}

/// x limited to [lo, hi]; lo for NaN.
static inline float lode_clamp(float x, float lo, float hi) {
    return x > lo ? (x < hi ? x : hi) : lo;
}

/// Square root; 0 for negative x and NaN.
static inline float lode_sqrt(float x) {
    return x > 0.0f ? sqrtf(x) : 0.0f;
}

/// One turn at most: x in [-3 pi, 3 pi] comes back in [-pi, pi]. Anything else is left 2 pi nearer.
static inline float lode_wrap_once(float x) {
    const float down = x > LODE_PI ? x - LODE_TWO_PI : x;
    return x < -LODE_PI ? x + LODE_TWO_PI : down;
}

/// Angle in [-pi, pi], for any x up to LODE_ANGLE_LIMIT_rad; 0 beyond and for NaN.
float lode_wrap(float x_rad);

/// Sine and cosine from one range reduction. Error at most 1e-6 for |x| <= 8 pi; beyond
/// LODE_ANGLE_LIMIT_rad and for NaN those of angle 0.
static inline lode_sincos_t lode_sincos(float x_rad) {
    const float x =
        lode_in_range(x_rad, -LODE_ANGLE_LIMIT_rad, LODE_ANGLE_LIMIT_rad) ? x_rad : 0.0f;
    // Quarter turns to the nearest; |x| is bounded, so the cast is defined.
    const float quarters = x * 0.636619772367581343f;
    const int32_t n = (int32_t)(quarters + (quarters < 0.0f ? -0.5f : 0.5f));
    // pi/2 in two parts, the first with 15 trailing zero bits: n times it is exact (|n| <= 1304).
    const float r = (x - (float)n * 1.5703125f) - (float)n * 4.83826794896619231e-4f;
    const float r2 = r * r;
    // Near-minimax on [-pi/4, pi/4]: tests/golden/gen_minimax.py.
    const float s =
        r + r * r2 * (-1.66666646563e-1f + r2 * (8.33274710437e-3f - r2 * 1.95876390353e-4f));
    const float c = 1.0f + r2 * (-0.5f + r2 * (4.16666505965e-2f +
                                               r2 * (-1.38875865646e-3f + r2 * 2.44634525345e-5f)));
    const bool swap = (n & 1) != 0;
    const float sin_abs = swap ? c : s;
    const float cos_abs = swap ? s : c;
    return (lode_sincos_t){(n & 2) != 0 ? -sin_abs : sin_abs,
                           ((n + 1) & 2) != 0 ? -cos_abs : cos_abs};
}

/// Angle of the vector (x, y) in [-pi, pi]. Error at most 1e-6 rad; 0 for (0, 0) and for NaN.
float lode_atan2(float y, float x);

/// 1 - exp(-x), without cancellation, for x >= 0; 0 for negative x and NaN. For init: it iterates.
float lode_one_minus_exp(float x);

#endif
