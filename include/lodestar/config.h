/// What all configurations have in common: a 0 means "choose for me".
#ifndef LODESTAR_CONFIG_H
#define LODESTAR_CONFIG_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/// A three-state choice.
typedef enum { LODE_AUTO = 0, LODE_ON, LODE_OFF } lode_choice_t;

/// One of the three.
static inline bool lode_is_choice(lode_choice_t choice) {
    return choice == LODE_AUTO || choice == LODE_ON || choice == LODE_OFF;
}

/// One of the two that an AUTO has become.
static inline bool lode_is_on_or_off(lode_choice_t choice) {
    return choice == LODE_ON || choice == LODE_OFF;
}

/// Value of an optional quantity that shall be absent.
#define LODE_NONE (-1.0f)

/// Whether `value` is LODE_NONE; no other negative value is.
static inline bool lode_is_none(float value) {
    return value >= LODE_NONE && value <= LODE_NONE;
}

/// What depends on the speed, which changes slowly, is updated once in this many periods: lag, gains that
/// depend on the speed, lock quality, slow checks of the guard. Each has a period of its own, so that no call
/// takes much longer than the others.
#define LODE_SLOW_PERIODS 8u

/// `value` unless it is 0. An invalid value counts as given: the check will refuse it.
static inline float lode_given_or(float value, float otherwise) {
    const bool zero = value >= 0.0f && value <= 0.0f;
    return zero ? otherwise : value;
}

#ifdef __cplusplus
}
#endif

#endif
