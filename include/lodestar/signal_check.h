/// Signal check before a start: voltage pulses along each phase axis, between gates off, one period forward and one back, far
/// too short to turn a rotor. The currents show whether bridge and sensors match (S37), and where the
/// axis of a salient rotor lies (S40).
///
/// A part of LODE_MODE_PRECHARGE, after the low-side pulses (fly.h), which have shown that the rotor is slow enough for it. Without
/// those, the current that flows before a pulse has to show it.
/// LODE_WITHOUT_SIGNAL_CHECK leaves it out of a build, and so does LODE_WITHOUT_FLYING_START.
#ifndef LODESTAR_SIGNAL_CHECK_H
#define LODESTAR_SIGNAL_CHECK_H

#include "lodestar/fly.h"
#include "lodestar/plausibility.h"

#ifdef __cplusplus
extern "C" {
#endif

#if defined(LODE_WITHOUT_FLYING_START) && !defined(LODE_WITHOUT_SIGNAL_CHECK)
#define LODE_WITHOUT_SIGNAL_CHECK
#endif

#define LODE_SIGNAL_PULSES 6u ///< to both sides of each phase axis

typedef struct {
    float pulse;       ///< volts per bus volt, along the axis
    float mean_A_V;    ///< what it shows of the current, mean of all rotor angles, per bus volt
    float least_A_V;   ///< the same that it shows at least
    float off_A;       ///< what the sensors may show with the gates off
    float before_most; ///< of that mean, that may flow before a pulse
    float sum_most;    ///< of what the phase shows that shows least, that their sum may be
    float turns_A;   ///< before one pulse, of a rotor that turns after all; FLT_MAX: by all pulses
    float moves_A;   ///< the same, mean of a set's pulses
    uint32_t pulses; ///< LODE_SIGNAL_PULSES for each set; 0: no check
} lode_signal_check_tuning_t;

/// What is known elsewhere.
typedef struct {
    float ts_s;
    bool pulses; ///< of the low sides (fly.h) come before, and detect a rotor that turns
    bool sums;   ///< the three currents sum to zero by construction
} lode_signal_check_given_t;

typedef struct {
    lode_ab_t along; ///< sums over the pulses: what each shows, seen from its axis
    lode_ab_t
        mirrored; ///< the same, turned on by the axis' angle instead of back: that is saliency
    float phase_A[LODE_PHASES]; ///< what each phase shows, without sign
    /// by axis: the sum of all three in the pulse one way, less that in the pulse the other way
    float sum_A[LODE_SIGNAL_PULSES / 2u];
    lode_ab_t moves_A; ///< sum of the currents before the pulses
    float before_A;    ///< the largest current before a pulse, with all gates on and no voltage
    float emf_A;       ///< along the present pulse, before it
    float off_A;       ///< the largest phase current before the first pulse
    float least_A;     ///< of the pulse that shows least by itself, without the way back
    float shown[LODE_PHASES]; ///< by the present pulse, 1/256 count
    uint_least8_t least;      ///< which pulse that is
    uint_least8_t pulse;      ///< the present one; at the end their number
    uint_least8_t period;     ///< of it
    uint_least8_t
        again; ///< 1: the set's second go, as the sum of the first was beyond its limit (S48)
    uint_least8_t
        axis; ///< pulse from 1 whose phase axis is next to the d axis or opposite; 0: not known
} lode_signal_check_t;

/// No check where `config` says so, where dead time takes too much of a pulse, or where its current would be too small to be
/// seen: then LODE_ERROR_CHOICE where it is on. Auto: none without low-side pulses, but with double update. `motor`: with the inductances of
/// one of `sets`, driven alone.
lode_status_t lode_signal_check_tune(lode_signal_check_tuning_t *tuning,
                                     const lode_start_config_t *config,
                                     const lode_inverter_config_t *inverter,
                                     const lode_motor_t *motor, const lode_sense_config_t *sense,
                                     lode_signal_check_given_t given);

/// Begins, if the rotor `rests`; else it is passed over.
void lode_signal_check_begin(lode_signal_check_t *self, const lode_signal_check_tuning_t *tuning,
                             bool rests);

/// More periods of it are to come.
static inline bool lode_signal_check_goes_on(const lode_signal_check_t *self,
                                             const lode_signal_check_tuning_t *tuning) {
    return (uint32_t)self->pulse < tuning->pulses;
}

/// After a step: that was the last one of the last pulse. Not so if it was passed over.
static inline bool lode_signal_check_is_through(const lode_signal_check_t *self,
                                                const lode_signal_check_tuning_t *tuning) {
    return !lode_signal_check_goes_on(self, tuning) && self->period == 0u;
}

/// After the check: the phase axis that is next to the rotor's d axis, at most 45 degrees off it or opposite to it. A sine and a
/// cosine of 0: it is not known, as the rotor turns or has too little saliency.
lode_sincos_t lode_signal_check_axis(const lode_signal_check_t *self);

/// One period. `i`: at t_k, 1/256 count. Returns the voltage that acts from t_k+1 on, per bus volt.
lode_ab_t lode_signal_check_step(lode_signal_check_t *self,
                                 const lode_signal_check_tuning_t *tuning,
                                 const lode_sense_tuning_t *sense, const int32_t i[LODE_PHASES]);

/// After a step: all gates are on in the period that begins.
bool lode_signal_check_drives(const lode_signal_check_t *self);

/// After a step: what is wrong. LODE_CHECK_NONE: nothing yet; most is said after a set's last pulse.
lode_finding_t lode_signal_check_judge(lode_signal_check_t *self,
                                       const lode_signal_check_tuning_t *tuning, float v_bus_V,
                                       float ts_s);

#ifdef __cplusplus
}
#endif

#endif
