/// Current control in the rotor frame: PI, decoupling, EMF feed-forward, voltage circle.
#ifndef LODESTAR_CURRENT_H
#define LODESTAR_CURRENT_H

#include "lodestar/frames.h"
#include "lodestar/inverter.h"
#include "lodestar/motor.h"
#include "lodestar/pi.h"
#include "lodestar/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Default share of v_bus/sqrt(3) that current control may use: the rest is for the dead-time correction.
#define LODE_VOLTAGE_USE 0.95f

typedef struct {
    float bandwidth_rad_s; ///< places kp = L bandwidth, ki = R bandwidth; 0: 0.2/Ts
    float kp_d_V_A;        ///< 0: from the bandwidth
    float kp_q_V_A;
    float ki_d_V_As;
    float ki_q_V_As;
    /// share of v_bus/sqrt(3) that may be used, 0.1 .. 1.1547; above 1: over-modulation, cut to the hexagon;
    /// 0: LODE_VOLTAGE_USE
    float voltage_use;
} lode_current_config_t;

typedef struct {
    lode_pi_tuning_t d;
    lode_pi_tuning_t q;
    float circle;     ///< radius of the voltage circle per bus volt
    uint32_t weakens; ///< 1: field weakening holds the EMF back by the d axis
    float
        free; ///< radius per bus volt within which neither circle nor rail limits; the drive lowers it
              ///< to the inverter's
} lode_current_tuning_t;

typedef struct {
    lode_pi_t d;
    lode_pi_t q;
    float kp_q_V_A; ///< of the tuning, less where the q axis saturates (K20)
    float Lq_H;     ///< for what rotation induces: of the motor, less where it saturates (K21)
} lode_current_t;

void lode_current_design(lode_current_config_t *config, const lode_motor_t *motor, float ts_s);

lode_status_t lode_current_tune(lode_current_tuning_t *tuning, const lode_current_config_t *config,
                                const lode_motor_t *motor, float ts_s);

/// The q axis as it is at zero current: before the first step, and with another tuning. `Lq_H`: of the motor.
void lode_current_take(lode_current_t *self, const lode_current_tuning_t *tuning, float Lq_H);

/// The same at the current `iq_A` on its way to `ref_A`, for a `Lq_H` that falls by `fall` per ampere, (R2).
void lode_current_saturate(lode_current_t *self, const lode_current_tuning_t *tuning, float Lq_H,
                           float fall, float iq_A, float ref_A);

/// Puts the integrators where the output is `u_V` without control error: for a bumpless start of
/// control, or a change of frame. `induced_V`: what rotation induces (K2); zero in a frame
/// that is not the rotor's.
void lode_current_reset(lode_current_t *self, lode_dq_t u_V, lode_dq_t induced_V);

#ifdef __cplusplus
}
#endif

#endif
