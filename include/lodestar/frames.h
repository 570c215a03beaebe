/// Reference frames and their transforms. All transforms are amplitude-invariant: the length of a vector is the
/// amplitude of the phases. A vector in alpha-beta is treated as the complex number alpha + j beta.
#ifndef LODESTAR_FRAMES_H
#define LODESTAR_FRAMES_H

#include "lodestar/scalar.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Values of three phases.
typedef struct {
    float a;
    float b;
    float c;
} lode_abc_t;

/// Vector in the stationary frame; alpha lies on phase a.
typedef struct {
    float alpha;
    float beta;
} lode_ab_t;

/// Vector in the rotor frame; d lies along the magnet's flux.
typedef struct {
    float d;
    float q;
} lode_dq_t;

/// Clarke transform. The common part of the three phases drops out.
LODE_INLINE lode_ab_t lode_clarke(lode_abc_t x) {
    const lode_ab_t out = {(2.0f * x.a - x.b - x.c) * (1.0f / 3.0f),
                           (x.b - x.c) * (1.0f / LODE_SQRT3)};
    return out;
}

/// Inverse Clarke transform; the phases add up to zero.
LODE_INLINE lode_abc_t lode_clarke_inverse(lode_ab_t x) {
    const float half = -0.5f * x.alpha;
    const float side = 0.5f * LODE_SQRT3 * x.beta;
    const lode_abc_t out = {x.alpha, half + side, half - side};
    return out;
}

/// Park transform: x exp(-j theta).
LODE_INLINE lode_dq_t lode_park(lode_ab_t x, lode_sincos_t theta) {
    const lode_dq_t out = {x.alpha * theta.cos + x.beta * theta.sin,
                           x.beta * theta.cos - x.alpha * theta.sin};
    return out;
}

/// Inverse Park transform: x exp(j theta).
LODE_INLINE lode_ab_t lode_park_inverse(lode_dq_t x, lode_sincos_t theta) {
    const lode_ab_t out = {x.d * theta.cos - x.q * theta.sin, x.d * theta.sin + x.q * theta.cos};
    return out;
}

/// Sine and cosine of the sum of two angles.
LODE_INLINE lode_sincos_t lode_angle_add(lode_sincos_t a, lode_sincos_t b) {
    const lode_sincos_t out = {a.sin * b.cos + a.cos * b.sin, a.cos * b.cos - a.sin * b.sin};
    return out;
}

/// Sine and cosine of the difference a - b.
LODE_INLINE lode_sincos_t lode_angle_subtract(lode_sincos_t a, lode_sincos_t b) {
    const lode_sincos_t out = {a.sin * b.cos - a.cos * b.sin, a.cos * b.cos + a.sin * b.sin};
    return out;
}

/// x exp(j angle).
LODE_INLINE lode_ab_t lode_ab_rotate(lode_ab_t x, lode_sincos_t angle) {
    const lode_ab_t out = {x.alpha * angle.cos - x.beta * angle.sin,
                           x.alpha * angle.sin + x.beta * angle.cos};
    return out;
}

/// Square of the length; 1 except for rounding.
LODE_INLINE float lode_angle_length2(lode_sincos_t a) {
    return a.sin * a.sin + a.cos * a.cos;
}

/// Normalises a length that is close to 1.
LODE_INLINE lode_sincos_t lode_angle_normalise(lode_sincos_t a) {
    const float scale = 1.5f - 0.5f * lode_angle_length2(a);
    const lode_sincos_t out = {scale * a.sin, scale * a.cos};
    return out;
}

/// Rotates an angle by atan(`x_rad`), which at 0.3 rad is at most 3 % less than x_rad. The length grows by x^2/2,
/// so lode_angle_normalise() is needed from time to time.
LODE_INLINE lode_sincos_t lode_angle_rotate_small(lode_sincos_t a, float x_rad) {
    const lode_sincos_t out = {a.sin + x_rad * a.cos, a.cos - x_rad * a.sin};
    return out;
}

/// Shortens in advance by what lode_angle_rotate_small() with `x_rad` will add; to within 1.3 % for 0.6 rad.
LODE_INLINE lode_sincos_t lode_angle_shorten(lode_sincos_t a, float x_rad) {
    const float scale = 1.0f - 0.5f * x_rad * x_rad * (1.0f - 0.75f * x_rad * x_rad);
    const lode_sincos_t out = {scale * a.sin, scale * a.cos};
    return out;
}

/// Sine and cosine of twice an angle.
LODE_INLINE lode_sincos_t lode_angle_double(lode_sincos_t a) {
    const lode_sincos_t out = {2.0f * a.sin * a.cos, 1.0f - 2.0f * a.sin * a.sin};
    return out;
}

/// Sine and cosine of three times an angle.
LODE_INLINE lode_sincos_t lode_angle_triple(lode_sincos_t a) {
    const float q = 1.0f - 4.0f * a.sin * a.sin;
    const lode_sincos_t out = {a.sin * (q + 2.0f), a.cos * q};
    return out;
}

LODE_INLINE lode_ab_t lode_ab_subtract(lode_ab_t x, lode_ab_t y) {
    const lode_ab_t out = {x.alpha - y.alpha, x.beta - y.beta};
    return out;
}

/// x + k y.
LODE_INLINE lode_ab_t lode_ab_add_scaled(lode_ab_t x, float k, lode_ab_t y) {
    const lode_ab_t out = {x.alpha + k * y.alpha, x.beta + k * y.beta};
    return out;
}

LODE_INLINE lode_ab_t lode_ab_scale(float k, lode_ab_t x) {
    const lode_ab_t out = {k * x.alpha, k * x.beta};
    return out;
}

/// Square of the length.
LODE_INLINE float lode_ab_length2(lode_ab_t x) {
    return x.alpha * x.alpha + x.beta * x.beta;
}

LODE_INLINE float lode_ab_length(lode_ab_t x) {
    return lode_sqrt(lode_ab_length2(x));
}

/// True if every component is within +-limit; false for NaN.
LODE_INLINE bool lode_ab_in_range(lode_ab_t x, float limit) {
    return lode_in_range(x.alpha, -limit, limit) && lode_in_range(x.beta, -limit, limit);
}

#ifdef __cplusplus
}
#endif

#endif
