/// I-f start: a current vector that is raised and turned whatever the rotor does, until the
/// estimator holds (paper 1, Section 5, after its reference 33).
#ifndef LODESTAR_START_H
#define LODESTAR_START_H

#include "lodestar/estimator.h"
#include "lodestar/inverter.h"
#include "lodestar/references.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    float current_A; ///< amplitude of the vector; 0: 0.7 i_max, at most psi/(2 (Lq - Ld))
    /// ELECTRICAL speed of the hand-over; 0: 0.1 of rated (150 of 1500 rpm)
    float omega_handover_rad_s;
    float ramp_rad_s2;    ///< electrical; 0: what a sixth of the start torque gives the inertia
    float current_rise_s; ///< 0: 0.2
    float damping;        ///< ratio of the rotor's swing about the vector; 0: 0.5; LODE_NONE: none
    float lock_s;         ///< lock quality must have held for this long; 0: 0.1
    float catch_s;   ///< zero current, to see whether the rotor turns already; 0: 0.05; LODE_NONE
    float timeout_s; ///< from start to hand-over; 0: three attempts
    float fade_s;    ///< from the start current to the references after hand-over; 0: 0.1
} lode_start_config_t;

typedef struct {
    float current_A;
    float current_step; ///< A per period
    float omega_handover;
    float sweep_step_rad; ///< per period while the current rises
    float omega_step;     ///< electrical rad/s per period
    float damping;        ///< rad by which the vector gives way per V of swinging EMF
    float mean_weight;    ///< of a new sample in the mean EMF
    float swing_weight;   ///< of a new sample in its swing
    float omega_hold;     ///< up to this speed the estimator is held to the vector
    float ts_s;
    float fade_step; ///< per call of the references
    uint32_t catch_periods;
    uint32_t lock_periods;
    uint32_t attempt_periods;
    uint32_t timeout_periods;
} lode_start_tuning_t;

typedef struct {
    float theta_rad;   ///< angle of the current vector before damping
    lode_sincos_t at;  ///< its sine and cosine
    float omega_rad_s; ///< its electrical speed
    float current_A;   ///< its length
    float shift_rad;   ///< by which the vector stands ahead of theta, to damp the rotor's swing
    float mean_V;      ///< mean EMF across the vector
    float swing_V;     ///< its deviation from the mean
    float fade;        ///< 1 at hand-over, 0 when the references have taken over
    float id_A;        ///< d-axis current at hand-over, which fades
    uint32_t locked;   ///< periods for which the lock has held
    uint32_t catching; ///< periods left to find a rotor that turns already
    uint32_t attempt;  ///< periods since the present attempt began
    uint32_t periods;  ///< since the start
} lode_start_t;

/// Lock quality from which the estimator may take over: well above LODE_LOCK_LOST.
#define LODE_LOCK_HANDOVER 0.7f

void lode_start_design(lode_start_config_t *config, const lode_inverter_config_t *inverter,
                       const lode_motor_t *motor);

lode_status_t lode_start_tune(lode_start_tuning_t *tuning, const lode_start_config_t *config,
                              const lode_inverter_config_t *inverter, const lode_motor_t *motor,
                              float omega_max_rad_s, float ts_s);

/// A vector at `theta_rad`, turning at `omega_rad_s`, of length `current_A`: nothing, for a start from
/// standstill, or the motor's own for the way back from sensorless running.
void lode_start_reset(lode_start_t *self, float theta_rad, float omega_rad_s, float current_A);

/// From rest, but first with zero current for a while: the voltage that this takes shows a rotor that
/// turns already.
void lode_start_begin(lode_start_t *self, const lode_start_tuning_t *tuning);

/// One period of looking for such a rotor. True: the estimator holds one, of either direction.
bool lode_start_catch(lode_start_t *self, const lode_start_tuning_t *tuning,
                      const lode_estimate_t *estimate);

/// One period from t_k-1 to t_k, towards the electrical speed `omega_target_rad_s` and the amplitude
/// `current_A`. `e_V`: estimated EMF at t_k. Returns the angle of the vector at t_k.
float lode_start_step(lode_start_t *self, const lode_start_tuning_t *tuning,
                      float omega_target_rad_s, float current_A, lode_ab_t e_V);

/// Sine and cosine of the angle that lode_start_step() has returned.
static inline lode_sincos_t lode_start_vector(const lode_start_t *self) {
    return lode_angle_add(self->at, lode_sincos_octant(self->shift_rad));
}

/// The estimator holds at hand-over speed, in the direction of the vector, and has for long enough.
bool lode_start_ready(lode_start_t *self, const lode_start_tuning_t *tuning,
                      const lode_estimate_t *estimate);

#ifdef __cplusplus
}
#endif

#endif
