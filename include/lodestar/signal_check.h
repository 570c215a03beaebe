/// Signal check before a start: voltage pulses along each phase axis, with the gates off before, one control period forward
/// and one back. They are far too short to turn a rotor. The currents show whether bridge and sensors are connected
/// correctly (S37), and where the axis of a salient rotor lies (S40).
///
/// It is a part of LODE_MODE_PRECHARGE and follows the low-side pulses (fly.h), which have shown that the rotor is slow enough.
/// Without low-side pulses the current before each pulse shows that. LODE_WITHOUT_SIGNAL_CHECK leaves the check out of a
/// build, and so does LODE_WITHOUT_FLYING_START.
#ifndef LODESTAR_SIGNAL_CHECK_H
#define LODESTAR_SIGNAL_CHECK_H

#include "lodestar/fly.h"
#include "lodestar/plausibility.h"

#ifdef __cplusplus
extern "C" {
#endif

#define LODE_SIGNAL_PULSES 6u ///< pulses per set: in both directions of each phase axis

/// All that is derived from the configuration. The "response" of a pulse is the current that it shows along its
/// axis (S37).
typedef struct {
    float pulse;       ///< voltage of a pulse along the axis, V per bus volt
    float mean_A_V;    ///< expected response, mean over all rotor angles, A per bus volt
    float least_A_V;   ///< least current rise in the forward period, A per bus volt
    float off_A;       ///< largest current that the sensors may show with the gates off
    float before_most; ///< largest current before a pulse, as a share of the mean response
    float
        sum_most; ///< largest sum of the three currents, as a share of the smallest phase response
    /// current before one pulse from which the rotor counts as turning; FLT_MAX: decided by all pulses together
    float turns_A;
    float moves_A;   ///< the same for the mean of a set's pulses (S46)
    uint32_t pulses; ///< LODE_SIGNAL_PULSES for each set; 0: no check
} lode_signal_check_tuning_t;

/// What lode_signal_check_tune() has to know from elsewhere.
typedef struct {
    float ts_s;  ///< control period
    bool pulses; ///< low-side pulses (fly.h) come first and detect a turning rotor
    bool sums;   ///< the sum of the three currents is checked (guard.i_sum_A)
} lode_signal_check_given_t;

/// State of the check.
typedef struct {
    lode_ab_t along; ///< sum of all responses, each turned back by the angle of its axis (A of S38)
    /// the same, each turned forward by that angle: shows saliency (B of S38)
    lode_ab_t mirrored;
    float phase_A[LODE_PHASES]; ///< sum of the response magnitudes of each phase
    /// by axis: sum of the three currents in the forward pulse minus that in the opposite pulse (S48)
    float sum_A[LODE_SIGNAL_PULSES / 2u];
    lode_ab_t moves_A;        ///< sum of the currents before the pulses
    float before_A;           ///< largest current before a pulse, with all gates on and no voltage
    float emf_A;              ///< current along the axis before the present pulse, driven by an EMF
    float off_A;              ///< largest phase current before the first pulse, gates off
    float least_A;            ///< smallest current rise in a forward period
    float shown[LODE_PHASES]; ///< response of the phases to the present pulse, 1/256 count
    uint_least8_t least;      ///< pulse to which least_A belongs
    uint_least8_t pulse;      ///< present pulse; in the end their number
    uint_least8_t period;     ///< period of the present pulse
    /// 1: second run of a set, because the sum was out of range in the first one (S48)
    uint_least8_t again;
    /// pulse, from 1, whose phase axis is next to the d axis or to its opposite; 0: not known
    uint_least8_t axis;
} lode_signal_check_t;

/// Derives the tuning. There is no check if `config` disables it, if dead time takes too much of a pulse, or if its
/// current is too small to measure; in the last two cases LODE_ON is refused with LODE_ERROR_CHOICE. LODE_AUTO
/// means off without low-side pulses, unless double update is the reason for that. `motor`: with the inductances of
/// one set driven alone.
lode_status_t lode_signal_check_tune(lode_signal_check_tuning_t *tuning,
                                     const lode_start_config_t *config,
                                     const lode_inverter_config_t *inverter,
                                     const lode_motor_t *motor, const lode_sense_config_t *sense,
                                     lode_signal_check_given_t given);

/// Begins the check if the rotor `rests`; otherwise the check is skipped.
void lode_signal_check_begin(lode_signal_check_t *self, const lode_signal_check_tuning_t *tuning,
                             bool rests);

/// True while further periods of the check are to come.
static inline bool lode_signal_check_goes_on(const lode_signal_check_t *self,
                                             const lode_signal_check_tuning_t *tuning) {
    return (uint32_t)self->pulse < tuning->pulses;
}

/// After a step: true if that was the last period of the last pulse. False if the check was skipped.
static inline bool lode_signal_check_is_through(const lode_signal_check_t *self,
                                                const lode_signal_check_tuning_t *tuning) {
    return !lode_signal_check_goes_on(self, tuning) && self->period == 0u;
}

/// After the check: the phase axis next to the rotor's d axis or to its opposite, as sine and cosine. It is within
/// 30 degrees of that axis, within 55 with the largest errors (S40). Sine and cosine 0: not known, because the
/// rotor turns or has too little saliency.
lode_sincos_t lode_signal_check_axis(const lode_signal_check_t *self);

/// One control period. `i`: phase currents at t_k, 1/256 count. Returns the voltage that acts from t_k+1 on, per
/// bus volt.
lode_ab_t lode_signal_check_step(lode_signal_check_t *self,
                                 const lode_signal_check_tuning_t *tuning,
                                 const lode_sense_tuning_t *sense, const int32_t i[LODE_PHASES]);

/// After a step: true if all gates are on in the period that begins.
bool lode_signal_check_drives(const lode_signal_check_t *self);

/// After a step: what is wrong. LODE_CHECK_NONE: nothing so far; most faults are reported after the last pulse of a
/// set.
lode_finding_t lode_signal_check_judge(lode_signal_check_t *self,
                                       const lode_signal_check_tuning_t *tuning, float v_bus_V,
                                       float ts_s);

#ifdef __cplusplus
}
#endif

#endif
