// One call of speed control.
#ifndef LODE_SPEED_INLINE_H
#define LODE_SPEED_INLINE_H

#include "lodestar/speed.h"
#include "pi_inline.h"
#include "ramp_inline.h"

// Torque control (K13): the target with which lode_speed_step() makes `torque_Nm`, within its limits, or holds the end of
// `between_rad_s` (mechanical) that the speed (ELECTRICAL `omega_rad_s`) would leave with this torque.
float lode_speed_torque_target(lode_speed_t *self, const lode_speed_tuning_t *tuning,
                               float torque_Nm, lode_range_t between_rad_s, float omega_rad_s,
                               float load_Nm);

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
    const float before = self->reference_rad_s;
    self->reference_rad_s = lode_ramp(before, target_rad_s, tuning->ramp_step);
    return self->reference_rad_s - before;
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

// Further torque where a load has taken more than LODE_SPEED_DIP_SHARE of the speed (K47). `error`: of the speed, with the gain's
// factor `gain`.
float lode_speed_dip_Nm(const lode_speed_t *self, const lode_speed_tuning_t *tuning, float gain,
                        float error);

// The rotor lacks so much of the reference.
LODE_INLINE bool lode_speed_dips(const lode_speed_t *self, float gain, float error) {
    const float reference = self->reference_rad_s;
    return error * reference > LODE_SPEED_DIP_SHARE * gain * reference * reference;
}

// A half-wave in the other direction than the last one (K48).
void lode_speed_count_swing(lode_speed_t *self);

// Watches the correction `torque_Nm` for swings (K48).
LODE_INLINE void lode_speed_watch_swing(lode_speed_t *self, const lode_speed_tuning_t *tuning,
                                        float torque_Nm) {
    if ((self->swung_up ? -torque_Nm : torque_Nm) > tuning->swing_Nm) {
        lode_speed_count_swing(self);
    } else if ((float)self->swing_age < tuning->swing_calls) {
        self->swing_age++;
    } else {
        self->swings = 0;
    }
}

// Torque reference, Nm, for the mechanical target `target_rad_s` at the estimated ELECTRICAL speed
// `omega_rad_s` and load torque `load_Nm` (K7, K8).
LODE_INLINE float lode_speed_step(lode_speed_t *self, const lode_speed_tuning_t *tuning,
                                  float target_rad_s, float omega_rad_s, float load_Nm) {
    const float step = lode_speed_ramp(self, tuning, target_rad_s);
    const float gain = self->calm * lode_speed_gain(tuning, omega_rad_s);
    const float error = gain * (self->reference_rad_s - omega_rad_s * tuning->inv_pole_pairs);
    // A rotor ahead of its ramp needs no torque to follow it: the controller's opposing torque is taken off the ramp's, but not
    // beyond zero.
    const float push = self->calm * tuning->inertia_Nm * step;
    const float against = tuning->pi.kp * error;
    lode_speed_watch_swing(self, tuning, against);
    const float ramp = push > 0.0f ? lode_clamp(push + against, 0.0f, push)
                                   : lode_clamp(push + against, push, 0.0f);
    const float ff = lode_speed_fed(tuning, omega_rad_s) * load_Nm + ramp;
    float unlimited = lode_pi_output(&self->pi, &tuning->pi, error, ff);
    if (lode_speed_dips(self, gain, error)) {
        // like the proportional part, it takes no room from the integral
        unlimited += lode_speed_dip_Nm(self, tuning, gain, error);
    }
    const lode_range_t limit = self->limit_Nm;
    if (lode_in_range(unlimited, limit.min, limit.max)) {
        lode_pi_integrate(&self->pi, &tuning->pi, error);
        self->torque_Nm = unlimited;
        return unlimited;
    }
    const float torque = lode_clamp(unlimited, limit.min, limit.max);
    lode_pi_settle(&self->pi, &tuning->pi, error, ff, unlimited, torque);
    self->torque_Nm = torque;
    return torque;
}

#endif
