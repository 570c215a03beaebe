/// Flying start: finds angle and speed of a rotor that is already turning, by short zero vectors with the gates otherwise
/// off.
///
/// The low sides alone are on for a share of the period around t_k. They short-circuit the EMF, which drives a current: one
/// current vector shows the angle, two of them the speed with its sign (S21)-(S24). The first pulses are so short that even at
/// the highest speed the current stays below i_max; they lengthen until the current can be measured. A part of
/// LODE_MODE_PRECHARGE. LODE_WITHOUT_FLYING_START and LODE_WITHOUT_PRECHARGE leave it out of a build.
#ifndef LODESTAR_FLY_H
#define LODESTAR_FLY_H

#include "lodestar/inverter.h"
#include "lodestar/options.h"
#include "lodestar/start.h"

#ifdef __cplusplus
extern "C" {
#endif

/// All that is derived from the configuration.
typedef struct {
    float share_first; ///< length of the first pulses, as a share of the period; 0: no pulses
    float share_dead;  ///< share of the period that dead time takes from a pulse
} lode_fly_tuning_t;

/// Values that a step needs and that the drive has in other tunings.
typedef struct {
    float ts_s; ///< control period
    float i_max_A;
    float psi_Wb;
    float Lq_H;
    float inv_Ld;          ///< 1/H
    float duty_max;        ///< as for lode_fly_tune()
    float omega_handover;  ///< electrical; a much slower rotor is left to the start
    uint32_t catch_rounds; ///< rounds of LODE_SLOW_PERIODS for which a rotor is looked for
    float v_bus_V;
    float charge; ///< least total pulse length before the pulses may end, control periods
} lode_fly_given_t;

/// Values of lode_fly_t.stage.
enum {
    LODE_FLY_BEGIN, ///< gates off; no current may flow
    LODE_FLY_GROW,  ///< the pulses become longer
    LODE_FLY_TURN,  ///< the rotation of the current vectors is measured
    LODE_FLY_COAST, ///< no more pulses; the current decays
    LODE_FLY_FOUND, ///< angle and speed are known
    LODE_FLY_SLOW   ///< at rest, too slow, or no usable result
};

/// State of the search.
typedef struct {
    float share; ///< share of the period for which the low sides are on, from the next period on
    float theta_rad;     ///< angle of the last current vector; COAST, FOUND: rotor angle at t_k
    float turned_rad;    ///< TURN: angle turned since the stage began
    float sum_A;         ///< TURN: sum of the vectors' lengths over the periods
    float sum_rad;       ///< sum of turned_rad over the periods (S25)
    float moment_rad;    ///< sum of turned_rad times the number of the period
    float square_rad2;   ///< sum of the squares of turned_rad
    float omega_rad_s;   ///< COAST, FOUND: electrical speed
    float charged;       ///< total length of the pulses, control periods
    float sum_A2;        ///< BEGIN: sum of the squared currents, gates off
    float noise_A;       ///< from BEGIN on: rms current with the gates off
    float seen_A;        ///< from BEGIN on: least current whose direction is used (S50)
    uint32_t periods;    ///< periods in the present stage
    uint_least8_t wait;  ///< periods until a new pulse length has been sampled
    uint_least8_t stage; ///< LODE_FLY_...
    uint_least8_t span;  ///< pulses of so many whole periods (S51); 0: pulses within each period
    uint_least8_t cycle; ///< of such a pulse and the pause after it: periods since its beginning
    uint_least8_t tries; ///< searches that ended without a rotor (S45)
    uint_least8_t sure;  ///< TURN: not 0: it is the rotor, more vectors only tell its angle (S57)
    uint_least8_t rests; ///< SLOW: not 0: the longest pulses have shown no rotation
} lode_fly_t;

/// Derives the tuning. There are no pulses if `config` disables them, or if a pulse that is safe at
/// `omega_max_rad_s` is too short for low-side shunts, which can be sampled only for shares above 1 - `duty_max`.
lode_status_t lode_fly_tune(lode_fly_tuning_t *tuning, const lode_start_config_t *config,
                            const lode_inverter_config_t *inverter, const lode_motor_t *motor,
                            float omega_max_rad_s, float duty_max, float ts_s);

/// Begins the search.
void lode_fly_begin(lode_fly_t *self, const lode_fly_tuning_t *tuning);

/// One control period, with the low sides alone or all gates off. `i_A`: current at t_k.
void lode_fly_step(lode_fly_t *self, const lode_fly_tuning_t *tuning, lode_ab_t i_A,
                   const lode_fly_given_t *given);

#ifdef __cplusplus
}
#endif

#endif
