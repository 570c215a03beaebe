/// What every module test needs: numbers, random floats, the motor of paper 1.
#ifndef SUPPORT_CHECK_H
#define SUPPORT_CHECK_H

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <unity.h>

#include "lodestar/motor.h"

#define CHECK_PI 3.14159265358979323846
#define CHECK_DEG (CHECK_PI / 180.0)
#define COUNT_OF(array) ((int)(sizeof(array) / sizeof((array)[0])))

/// How often a search or a sweep tries: all of it, or one CHECK_SHARE-th where an emulated processor
/// would take too long (tests/target).
#ifndef CHECK_SHARE
#define CHECK_SHARE 1
#endif
#define CHECK_TRIES(count) ((count) / CHECK_SHARE)

/// Absolute tolerance in double, with the place and the figures in the message.
#define CHECK_NEAR(tolerance, expected, actual)                                                    \
    TEST_ASSERT_DOUBLE_WITHIN((tolerance), (double)(expected), (double)(actual))

/// Relative tolerance.
#define CHECK_CLOSE(share, expected, actual)                                                       \
    TEST_ASSERT_DOUBLE_WITHIN((share)*fabs((double)(expected)), (double)(expected),                \
                              (double)(actual))

/// actual <= limit and actual >= limit, with both figures. False for NaN.
#define CHECK_AT_MOST(limit, actual) check_at_most((double)(limit), (double)(actual), __LINE__)
#define CHECK_AT_LEAST(limit, actual) check_at_least((double)(limit), (double)(actual), __LINE__)

static inline void check_at_most(double limit, double actual, int line) {
    char text[80];
    (void)snprintf(text, sizeof text, "%.9g is not at most %.9g", actual, limit);
    if (!(actual <= limit)) {
        UNITY_TEST_FAIL((UNITY_LINE_TYPE)line, text);
    }
}

static inline void check_at_least(double limit, double actual, int line) {
    char text[80];
    (void)snprintf(text, sizeof text, "%.9g is not at least %.9g", actual, limit);
    if (!(actual >= limit)) {
        UNITY_TEST_FAIL((UNITY_LINE_TYPE)line, text);
    }
}

/// The largest of what it is shown; NaN counts as infinite.
typedef struct {
    double value;
} worst_t;

static inline void worst_note(worst_t *self, double x) {
    if (!(fabs(x) <= self->value)) {
        self->value = isfinite(x) ? fabs(x) : (double)INFINITY;
    }
}

/// Floats that arithmetic tends to forget.
static const float check_odd_floats[] = {
    0.0f, -0.0f, 1.0e-45f, -1.0e-45f, FLT_MIN, -FLT_MIN, 1.0f,    -1.0f,
    NAN,  -NAN,  INFINITY, -INFINITY, 3.0e38f, -3.0e38f, FLT_MAX, -FLT_MAX};

/// Numbers that are no configuration value.
static const float check_not_finite[] = {NAN, INFINITY, -INFINITY};

static inline float check_from_bits(uint32_t bits) {
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/// xorshift64*: the same numbers on every machine.
typedef struct {
    uint64_t state;
} random_t;

static inline random_t random_seed(uint64_t seed) {
    return (random_t){seed * 2685821657736338717u + 88172645463325252u};
}

static inline uint32_t random_bits(random_t *self) {
    self->state ^= self->state >> 12;
    self->state ^= self->state << 25;
    self->state ^= self->state >> 27;
    return (uint32_t)((self->state * 2685821657736338717u) >> 32);
}

static inline double random_between(random_t *self, double lo, double hi) {
    return lo + (hi - lo) * ((double)random_bits(self) / 4294967296.0);
}

static inline float random_float(random_t *self, double lo, double hi) {
    return (float)random_between(self, lo, hi);
}

/// Any bit pattern: every second one huge, tiny, infinite or not a number.
static inline float random_any(random_t *self) {
    return check_from_bits(random_bits(self));
}

/// Difference of two angles in [-pi, pi].
static inline double angle_error(double a, double b) {
    return remainder(a - b, 2.0 * CHECK_PI);
}

/// The motor of paper 1, Table 3; 1500 rpm are 471.24 electrical rad/s.
static inline lode_motor_t paper_motor(void) {
    return (lode_motor_t){.pole_pairs = 3.0f,
                          .Rs_Ohm = 0.75f,
                          .Ld_H = 3.5e-3f,
                          .Lq_H = 9.8e-3f,
                          .psi_Wb = 0.142f,
                          .J_kgm2 = 0.0174f,
                          .B_Nms = 7.5e-4f,
                          .omega_rated_rad_s = 471.238898f};
}

#define PAPER_TS_s 2.0e-4f
#define PAPER_OMEGA_RATED 471.238898
#define PAPER_V_BUS 200.0f

/// Electrical rad/s of the paper's motor.
static inline double paper_omega(double rpm) {
    return rpm * 3.0 * CHECK_PI / 30.0;
}

static inline lode_sincos_t sincos_of(double angle_rad) {
    return (lode_sincos_t){(float)sin(angle_rad), (float)cos(angle_rad)};
}

#endif
