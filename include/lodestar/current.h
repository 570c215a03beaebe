/// Current control in the rotor frame: PI controllers, decoupling, EMF feed-forward, voltage circle.
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

/// Default share of v_bus/sqrt(3) for current control. The rest is left to the dead-time correction.
#define LODE_VOLTAGE_USE 0.95f

/// Configuration. A field that is 0 gets its default from lode_current_design().
typedef struct {
    float bandwidth_rad_s; ///< sets kp = L bandwidth and ki = R bandwidth (K2); 0: 0.2/Ts
    float kp_d_V_A;        ///< this and the next three: 0: from the bandwidth
    float kp_q_V_A;
    float ki_d_V_As;
    float ki_q_V_As;
    /// share of v_bus/sqrt(3) that may be used, 0.1 .. 1.1547; above 1 over-modulation, limited to the hexagon; 0:
    /// LODE_VOLTAGE_USE
    float voltage_use;
} lode_current_config_t;

/// All that is derived from the configuration.
typedef struct {
    lode_pi_tuning_t d;
    lode_pi_tuning_t q;
    float circle;     ///< radius of the voltage circle per bus volt
    uint32_t weakens; ///< 1: field weakening is on, and the d axis comes first
    /// radius per bus volt within which neither the circle nor a rail limits; the drive lowers it to that of the
    /// inverter
    float free;
} lode_current_tuning_t;

/// State of current control.
typedef struct {
    lode_pi_t d;
    lode_pi_t q;
    float kp_q_V_A; ///< kp of the q axis; less if the iron saturates (K20)
    float Lq_H;     ///< for the induced voltage; less if the iron saturates (K21)
} lode_current_t;

/// Fills every zero field that has a default.
void lode_current_design(lode_current_config_t *config, const lode_motor_t *motor, float ts_s);

/// Checks a completed configuration and derives the tuning. On any error `tuning` is left alone.
lode_status_t lode_current_tune(lode_current_tuning_t *tuning, const lode_current_config_t *config,
                                const lode_motor_t *motor, float ts_s);

/// Sets gain and inductance of the q axis for zero current: before the first step, and after a change of the
/// tuning. `Lq_H`: of the motor.
void lode_current_take(lode_current_t *self, const lode_current_tuning_t *tuning, float Lq_H);

/// The same for the current `iq_A` on its way to `ref_A`. `Lq_H`: at zero current; `fall`: its fall per ampere
/// (R2).
void lode_current_saturate(lode_current_t *self, const lode_current_tuning_t *tuning, float Lq_H,
                           float fall, float iq_A, float ref_A);

/// Sets the integrators so that the output is `u_V` at zero control error, for a start without a jump or a change
/// of frame (K6). `induced_V`: voltage induced by rotation; zero in a frame other than the rotor's.
void lode_current_reset(lode_current_t *self, lode_dq_t u_V, lode_dq_t induced_V);

#ifdef __cplusplus
}
#endif

#endif
