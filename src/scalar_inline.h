// Sines without range reduction.
#ifndef LODE_SCALAR_INLINE_H
#define LODE_SCALAR_INLINE_H

#include "lodestar/scalar.h"

// Sine and cosine for |x| <= pi/4. Error at most 1e-7. Near-minimax: tests/golden/gen_minimax.py.
LODE_SHARED lode_sincos_t lode_sincos_octant(float x_rad) {
    const float x = x_rad;
    const float x2 = x * x;
    return (lode_sincos_t){
        x + x * x2 * (-1.66666646563e-1f + x2 * (8.33274710437e-3f - x2 * 1.95876390353e-4f)),
        1.0f + x2 * (-0.5f + x2 * (4.16666505965e-2f +
                                   x2 * (-1.38875865646e-3f + x2 * 2.44634525345e-5f)))};
}

// Adds to a sum what may be less than its last digit: `rest` keeps what rounding leaves out (K35).
LODE_INLINE void lode_add_small(float *sum, float *rest, float x) {
    const float before = *sum;
    const float added = x + *rest;
    *sum = before + added;
    *rest = added - (*sum - before);
}

// For a frame that is normalised later: error at most x^4/24 in length and x^5/30 in angle, 3e-5 rad for |x| <= 0.25.
LODE_INLINE lode_sincos_t lode_sincos_small(float x_rad) {
    const float half_x2 = 0.5f * x_rad * x_rad;
    return (lode_sincos_t){x_rad - x_rad * half_x2 * (1.0f / 3.0f), 1.0f - half_x2};
}

#endif
