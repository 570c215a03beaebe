// One call of speed control.
#ifndef LODE_SPEED_INLINE_H
#define LODE_SPEED_INLINE_H

#include "lodestar/speed.h"
#include "pi_inline.h"
#include "ramp_inline.h"

// Limit of the bandwidth times the run-up time (lode_motor_run_up_s): a faster loop answers noise with all of its torque.
#define LODE_SPEED_RUN_UP_MAX 13.0f
// Largest share of the torque of i_max for the ramp.
#define LODE_SPEED_RAMP_SHARE 0.5f

// Torque control (K13): the target with which lode_speed_step() makes `torque_Nm`, within its limits, or holds the end of
// `between_rad_s` (mechanical) that the speed (ELECTRICAL `omega_rad_s`) would leave with this torque.
float lode_speed_torque_target(lode_speed_t *self, const lode_speed_tuning_t *tuning,
                               float torque_Nm, lode_range_t between_rad_s, float omega_rad_s,
                               float load_Nm);

// Limits the ramped reference to +-`most_rad_s`, mechanical.
void lode_speed_bound(lode_speed_t *self, float most_rad_s);

// False: integral or reference has changed by itself.
LODE_INLINE bool lode_speed_is_whole(const lode_speed_t *self) {
    const float integral = self->pi.integral - self->copy.integral_Nm;
    const float reference = self->reference_rad_s - self->copy.reference_rad_s;
    return lode_abs(integral) + lode_abs(reference) <= 0.0f;
}

// Half of the last digit of 1e5 rad/s, rounded up: no rounding leaves out more.
#define LODE_SPEED_LEFT_MAX_rad_s 0.01f

// False: what rounding has left out of the reference has changed by itself.
LODE_INLINE bool lode_speed_left_ok(const lode_speed_t *self) {
    return lode_abs(self->left_rad_s) <= LODE_SPEED_LEFT_MAX_rad_s;
}

#ifndef LODE_WITHOUT_SHAPED_RAMP

// One step of the reference towards the mechanical target, with two slopes and a jerk (K33)-(K35), rad/s.
float lode_speed_shaped_step(lode_speed_t *self, const lode_speed_tuning_t *tuning,
                             float target_rad_s);

#endif

// One step of the reference towards the mechanical target, rad/s.
LODE_INLINE float lode_speed_ramp(lode_speed_t *self, const lode_speed_tuning_t *tuning,
                                  float target_rad_s) {
#ifndef LODE_WITHOUT_SHAPED_RAMP
    if (tuning->jerk_step > 0.0f) {
        return lode_speed_shaped_step(self, tuning, target_rad_s);
    }
#endif
    return lode_ramp(&self->reference_rad_s, &self->left_rad_s, target_rad_s, tuning->ramp_step);
}

// Factor of both gains at the electrical speed `omega_rad_s`.
LODE_INLINE float lode_speed_gain(const lode_speed_tuning_t *tuning, float omega_rad_s) {
    const float up = lode_abs(omega_rad_s) * tuning->inv_span - 1.0f;
    return 1.0f + tuning->rise * lode_clamp(up, 0.0f, 1.0f);
}

// Share of the load that is fed forward at the electrical speed `omega_rad_s` (K46).
LODE_INLINE float lode_speed_fed(const lode_speed_tuning_t *tuning, float omega_rad_s) {
    if (!(tuning->load_fall > 0.0f)) { // by default
        return tuning->load_feed_forward;
    }
    const float up = 2.0f * lode_abs(omega_rad_s) * tuning->inv_span - 1.0f;
    return tuning->load_feed_forward - tuning->load_fall * lode_clamp(up, 0.0f, 1.0f);
}

// Torque reference, Nm, for the mechanical target `target_rad_s` at the estimated ELECTRICAL speed
// `omega_rad_s` and load torque `load_Nm` (K7, K8).
float lode_speed_step(lode_speed_t *self, const lode_speed_tuning_t *tuning, float target_rad_s,
                      float omega_rad_s, float load_Nm);

#endif
