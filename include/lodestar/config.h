/// Common conventions of all configurations: 0 means "choose for me".
#ifndef LODESTAR_CONFIG_H
#define LODESTAR_CONFIG_H

#include <stdbool.h>

#include "lodestar/scalar.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A three-state choice.
typedef enum { LODE_AUTO = 0, LODE_ON, LODE_OFF } lode_choice_t;

/// True for any of the three.
static inline bool lode_is_choice(lode_choice_t choice) {
    return choice == LODE_AUTO || choice == LODE_ON || choice == LODE_OFF;
}

/// True for ON or OFF, one of which a completed configuration has.
static inline bool lode_is_on_or_off(lode_choice_t choice) {
    return choice == LODE_ON || choice == LODE_OFF;
}

/// Value of an optional quantity: it shall not exist.
#define LODE_NONE (-1.0f)

/// True if `value` is LODE_NONE. No other negative value is accepted as that.
static inline bool lode_is_none(float value) {
    return value >= LODE_NONE && value <= LODE_NONE;
}

/// True if `value` is LODE_NONE, or least <= value <= most. For an optional quantity.
static inline bool lode_is_none_or_in(float value, float least, float most) {
    return lode_is_none(value) || lode_in_range(value, least, most);
}

/// Control periods of a round of slow jobs: everything that follows the speed, which changes slowly, is updated
/// once per round (lag, gains, lock quality, slow checks of the guard). Each job has its own period of the round,
/// so that no call takes much longer than the others.
#define LODE_SLOW_PERIODS 8u

/// Returns `value`, or `otherwise` if it is 0. An invalid value is returned too and refused by the check.
static inline float lode_given_or(float value, float otherwise) {
    const bool zero = value >= 0.0f && value <= 0.0f;
    return zero ? otherwise : value;
}

#ifdef __cplusplus
}
#endif

#endif
