/// Flying start: angle and speed of a rotor that is already turning, by short zero vectors with the gates otherwise off.
///
/// While the low sides alone are on, for a share of the period around t_k, the EMF is short-circuited and
/// drives a current across the rotor: one vector shows the angle, two the speed with its sign (S21)-(S24).
/// The shares begin so short that a rotor at the highest speed stays below i_max, and lengthen until the
/// current can be seen. A part of LODE_MODE_PRECHARGE; LODE_WITHOUT_FLYING_START leaves it out of a build,
/// and so does LODE_WITHOUT_PRECHARGE.
#ifndef LODESTAR_FLY_H
#define LODESTAR_FLY_H

#include "lodestar/inverter.h"
#include "lodestar/start.h"

#ifdef __cplusplus
extern "C" {
#endif

#if defined(LODE_WITHOUT_PRECHARGE) && !defined(LODE_WITHOUT_FLYING_START)
#define LODE_WITHOUT_FLYING_START
#endif

typedef struct {
    float share_first; ///< of the period; 0: no pulses
    float share_dead;  ///< of it, that dead time takes
} lode_fly_tuning_t;

/// What a step needs that the drive has in other tunings.
typedef struct {
    float ts_s;
    float i_max_A;
    float psi_Wb;
    float Lq_H;
    float inv_Ld;          ///< 1/H
    float duty_max;        ///< as in lode_fly_tune()
    float omega_handover;  ///< electrical; a rotor that is much slower is left to the start
    uint32_t catch_rounds; ///< of LODE_SLOW_PERIODS, in which a rotor is looked for
    float v_bus_V;
    float charge; ///< for so many periods of pulses they go on in any case
} lode_fly_given_t;

/// What lode_fly_t.stage may be.
enum {
    LODE_FLY_BEGIN, ///< gates off: no current may flow
    LODE_FLY_GROW,  ///< the pulses lengthen
    LODE_FLY_TURN,  ///< the vectors are seen to turn
    LODE_FLY_COAST, ///< no more pulses: the current decays
    LODE_FLY_FOUND,
    LODE_FLY_SLOW ///< at rest, too slow, or nothing that could be seen
};

typedef struct {
    float share;        ///< of the period in which the low sides are on, from the next period on
    float theta_rad;    ///< angle of the last vector; COAST, FOUND: of the rotor at t_k
    float turned_rad;   ///< TURN: since its begin
    float sum_rad;      ///< of turned_rad over the periods
    float moment_rad;   ///< of turned_rad times the period's number
    float square_rad2;  ///< of turned_rad, squared
    float omega_rad_s;  ///< COAST, FOUND: electrical
    float charged;      ///< periods with the low sides on
    uint32_t periods;   ///< of the present stage
    uint_least8_t wait; ///< periods until a new share has been sampled
    uint_least8_t stage;
    uint_least8_t rests; ///< SLOW, not 0: the longest pulses have shown nothing that turns
} lode_fly_t;

/// No pulses where `config` says so, or where a share that is safe at `omega_max_rad_s` is too short for
/// low-side shunts, which see nothing below 1 - `duty_max`.
lode_status_t lode_fly_tune(lode_fly_tuning_t *tuning, const lode_start_config_t *config,
                            const lode_inverter_config_t *inverter, const lode_motor_t *motor,
                            float omega_max_rad_s, float duty_max, float ts_s);

void lode_fly_begin(lode_fly_t *self, const lode_fly_tuning_t *tuning);

/// One period with the low sides alone, or none. `i_A`: at t_k.
void lode_fly_step(lode_fly_t *self, const lode_fly_tuning_t *tuning, lode_ab_t i_A,
                   const lode_fly_given_t *given);

#ifdef __cplusplus
}
#endif

#endif
