/// What all configurations have in common: a 0 means "choose for me".
#ifndef LODESTAR_CONFIG_H
#define LODESTAR_CONFIG_H

/// A three-state choice.
typedef enum { LODE_AUTO = 0, LODE_ON, LODE_OFF } lode_choice_t;

/// For a quantity that may be done without: there shall be none of it.
#define LODE_NONE (-1.0f)

/// `value` where it was given, else `otherwise`. NaN counts as given: the check will refuse it.
static inline float lode_given_or(float value, float otherwise) {
    return value > 0.0f || !(value <= 0.0f) ? value : otherwise;
}

/// The same for a quantity that LODE_NONE does without.
static inline float lode_given_or_none(float value, float otherwise) {
    return value < 0.0f ? LODE_NONE : lode_given_or(value, otherwise);
}

#endif
