/// What all configurations have in common: a 0 means "choose for me".
#ifndef LODESTAR_CONFIG_H
#define LODESTAR_CONFIG_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/// A three-state choice.
typedef enum { LODE_AUTO = 0, LODE_ON, LODE_OFF } lode_choice_t;

/// For a quantity that may be done without: there shall be none of it.
#define LODE_NONE (-1.0f)

/// What follows the speed, which moves slowly, is renewed once in so many periods: lag, gains that
/// depend on the speed, lock quality, slow guards. Each has a period of its own, so that no call is much
/// dearer than the others.
#define LODE_SLOW_PERIODS 8u

/// `value` unless it is 0. What makes no sense counts as given: the check will refuse it.
static inline float lode_given_or(float value, float otherwise) {
    const bool zero = value >= 0.0f && value <= 0.0f;
    return zero ? otherwise : value;
}

#ifdef __cplusplus
}
#endif

#endif
