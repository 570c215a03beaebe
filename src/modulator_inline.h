// Voltage to duties, one set of three phases at a time.
#ifndef LODE_MODULATOR_INLINE_H
#define LODE_MODULATOR_INLINE_H

#include "inverter_inline.h"
#include "lodestar/modulator.h"

// Result for the phases of one set.
typedef struct {
    lode_abc_t duty;
    lode_abc_t seen; // seen by the motor if not `as_commanded`
    bool as_commanded;
} lode_modulator_phases_t;

// Input of one set. One struct for the same reason as lode_current_case_t.
typedef struct {
    lode_abc_t v;   // per bus volt
    lode_abc_t i_A; // while it acts
} lode_modulator_case_t;

// As lode_modulator_set(), if a duty may reach a rail or the dead time is modelled.
lode_modulator_phases_t lode_modulator_limit(const lode_inverter_tuning_t *inverter,
                                             const lode_dead_time_t *dead_time,
                                             const lode_modulator_case_t *at);

// Adding this rounds a float to a whole number.
#define MODULATOR_WHOLE 8388608.0f // 2^23

// Rounds to the nearest of at most 65535 ticks. NaN stays NaN.
LODE_INLINE float lode_modulator_on_grid(const lode_inverter_tuning_t *inverter, float duty) {
    const float beside = duty * inverter->ticks + MODULATOR_WHOLE;
    return (beside - MODULATOR_WHOLE) * inverter->inv_ticks;
}

// Dead-time errors of the phases at the currents `i_A`.
LODE_INLINE lode_abc_t lode_modulator_errors(const lode_dead_time_t *dead_time, lode_abc_t i_A) {
    return (lode_abc_t){lode_inverter_error(dead_time, i_A.a),
                        lode_inverter_error(dead_time, i_A.b),
                        lode_inverter_error(dead_time, i_A.c)};
}

// Duties for the phase voltages `v`, per bus volt, that sum to zero.
LODE_INLINE lode_abc_t lode_modulator_duties(lode_abc_t v) {
    // The common mode that centres the three duties (B9), half of the middle one, equals space-vector modulation. The three sum
    // to zero, so the middle one is the smallest by magnitude.
    const float ab = lode_abs(v.a) < lode_abs(v.b) ? v.a : v.b;
    const float middle = lode_abs(v.c) < lode_abs(ab) ? v.c : ab;
    const float centre = 0.5f + 0.5f * middle;
    return (lode_abc_t){v.a + centre, v.b + centre, v.c + centre};
}

// One set: `v` phase voltages per bus volt, `i_A` its currents meanwhile. `free`: the voltage lies within
// lode_inverter_tuning_t.free.
LODE_INLINE lode_modulator_phases_t lode_modulator_set(const lode_inverter_tuning_t *inverter,
                                                       const lode_dead_time_t *dead_time,
                                                       lode_abc_t v, lode_abc_t i_A, bool free) {
    if (!free) {
        const lode_modulator_case_t edge = {v, i_A};
        return lode_modulator_limit(inverter, dead_time, &edge);
    }
    const lode_abc_t ideal = lode_modulator_duties(v);
    const lode_abc_t error = lode_modulator_errors(dead_time, i_A); // 0 without correction
    const lode_abc_t duty = {ideal.a + error.a, ideal.b + error.b, ideal.c + error.c};
    if (inverter->grid != 0u) {
        const lode_abc_t made = {lode_modulator_on_grid(inverter, duty.a),
                                 lode_modulator_on_grid(inverter, duty.b),
                                 lode_modulator_on_grid(inverter, duty.c)};
        return (lode_modulator_phases_t){
            made, {made.a - error.a, made.b - error.b, made.c - error.c}, false};
    }
    return (lode_modulator_phases_t){duty, duty, true};
}

// Set 1, or the only one: duties for the voltage `v` per bus volt, to act while the current is `i_A`, which must be finite.
// Linear up to 1/sqrt(3). Beyond that, and where the correction exceeds the rails, the duties are clamped; `realised` is what
// remains.
LODE_INLINE lode_modulator_out_t lode_modulator_step(const lode_inverter_tuning_t *inverter,
                                                     const lode_dead_time_t *dead_time, lode_ab_t v,
                                                     lode_ab_t i_A, bool free) {
    const lode_modulator_phases_t out = lode_modulator_set(
        inverter, dead_time, lode_clarke_inverse(v), lode_clarke_inverse(i_A), free);
    return (lode_modulator_out_t){out.duty, out.as_commanded ? v : lode_clarke(out.seen)};
}

// Every duty is within [0, most]. Compared as unsigned integers, which order non-negative floats as they are; NaN, Inf and
// negative values are larger.
LODE_INLINE bool lode_modulator_is_within(lode_abc_t duty, float most) {
    const union {
        float value;
        uint32_t bits;
    } limit = {most}, a = {duty.a}, b = {duty.b}, c = {duty.c};
    return a.bits <= limit.bits && b.bits <= limit.bits && c.bits <= limit.bits;
}

LODE_INLINE bool lode_modulator_is_sound(lode_abc_t duty) {
    return lode_modulator_is_within(duty, 1.0f);
}

#endif
