// The current vector of the start, one period.
#ifndef LODE_START_INLINE_H
#define LODE_START_INLINE_H

#include "lodestar/start.h"
#include "ramp_inline.h"
#include "scalar_inline.h"

// Share of the ramp in the second and the third, last attempt. A rotor with more inertia than configured cannot follow
// the full ramp. The last attempt also takes more current, against a load.
#define LODE_START_EASE 0.25f
#define LODE_START_EASE_LAST (LODE_START_EASE * LODE_START_EASE)
#define LODE_START_FAILED_MAX 2u // attempts before the last one
// Attempts that may end after the hand-over: those before the last one, and that itself, which is repeated once (S28).
#define LODE_START_LOSSES_MAX (LODE_START_FAILED_MAX + 1u)

// Ratio of the sweep rates up to half of the current and from there to all of it. Each sweep goes from phase axis to
// phase axis, by 240 and by 60 degrees (S29).
#define LODE_START_SWEEP_FIRST 4.0f

// (S53): rate of current and sweep after an attempt that has failed, over that of the first one. The rotor probably has
// several times the configured inertia.
#define LODE_START_LATER_RISE 0.5f

// Least Lq/Ld of a rotor whose saliency keeps its sign with both inductances 20 % off.
#define LODE_SURELY_SALIENT 1.5f

// Share of the ramp in the present attempt. The repeated last attempt is quicker: the rotor has followed the vector once.
LODE_INLINE float lode_start_ease(const lode_start_t *self) {
    static const float share[] = {1.0f, LODE_START_EASE, LODE_START_EASE_LAST, LODE_START_EASE};
    return share[self->failed & LODE_START_LOSSES_MAX]; // mask: in the table even after a bit flip
}

LODE_INLINE bool lode_start_catches(const lode_start_t *self) {
    return self->stage == (uint_least8_t)LODE_START_CATCH;
}

// Allowed difference of estimated and vector speed, as a share of the latter (S8): a load that swings within a turn
// swings the rotor in proportion.
#define LODE_START_TOLERANCE 0.25f

LODE_INLINE float lode_start_slack(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    return LODE_START_TOLERANCE * lode_max(lode_abs(self->omega_rad_s), tuning->omega_ready);
}

// The estimated speed is that of the vector, which is fast enough for an estimate and turns as commanded.
LODE_INLINE bool lode_start_follows(const lode_start_t *self, const lode_start_tuning_t *tuning,
                                    float omega_rad_s, float slack) {
    const float vector = self->omega_rad_s;
    return lode_abs(vector) >= tuning->omega_ready && vector * self->omega_target > 0.0f &&
           lode_abs(omega_rad_s - vector) <= slack;
}

// What shows a swing: the EMF across the vector shows its speed and angle, the magnitude of the EMF only its speed. The magnitude
// is weighted in as the vector gets faster (S19).
LODE_INLINE float lode_start_across_V(const lode_start_t *self, lode_ab_t e_V) {
    const float by_size = self->by_size;
    const float across_V = lode_park(e_V, self->at).q;
    if (lode_abs(by_size) > 0.0f) { // at rest, where plausibility takes longest, no root
        return (1.0f - lode_abs(by_size)) * across_V + by_size * lode_ab_length(e_V);
    }
    return across_V;
}

// One period from t_k-1 to t_k. `e_V`: estimated EMF at t_k. Returns the vector's rotation per period, rad.
LODE_INLINE float lode_start_step(lode_start_t *self, const lode_start_tuning_t *tuning,
                                  lode_ab_t e_V, float ts_s) {
    // The vector turns at speed once its current is reached and resistance and dead time are measured. While the
    // current rises at standstill the vector sweeps: a rotor that lies opposite to it would feel no torque, and one
    // that falls back to it is carried along (S29).
    const float rate = self->failed > 0u ? LODE_START_LATER_RISE : 1.0f;
    float advance_rad = ts_s * self->omega_rad_s;
    if (!(self->current_A < self->current_target) &&
        !(self->stage < (uint_least8_t)LODE_START_TURN)) {
        (void)lode_ramp(&self->omega_rad_s, &self->left_rad_s, self->omega_target,
                        self->omega_step);
        advance_rad = ts_s * self->omega_rad_s;
    } else if (self->current_A < self->current_target && !(lode_abs(self->omega_rad_s) > 0.0f) &&
               self->stands == 0u) {
        advance_rad = lode_sign(self->omega_target) * rate * tuning->sweep_step_rad;
#ifndef LODE_WITHOUT_START_MEASUREMENT
        if (self->stage == (uint_least8_t)LODE_START_HALF) {
            advance_rad *= LODE_START_SWEEP_FIRST;
        }
#endif
    } else {
        // the vector rests for the measurement, stands ahead of the rotor, or keeps its speed while the current rises
    }
    self->current_A += lode_clamp(self->current_target - self->current_A, -tuning->current_step,
                                  rate * tuning->current_step);
    const lode_sincos_t half = lode_sincos_small(0.5f * advance_rad);
    self->at = lode_angle_add(self->at, lode_angle_double(half));
    const float across_V = lode_start_across_V(self, e_V);
    self->mean_V += tuning->mean_weight * (across_V - self->mean_V);
    self->swing_V += tuning->swing_weight * (across_V - self->mean_V - self->swing_V);
    return advance_rad;
}

// Angle by which the vector is turned ahead to damp the rotor's swing (S6).
LODE_INLINE float lode_start_shift_rad(const lode_start_t *self) {
    return lode_clamp(-self->give * self->swing_V, -LODE_START_SHIFT_MAX_rad,
                      LODE_START_SHIFT_MAX_rad);
}

// Change of this angle since the last call for the same set, rad.
LODE_INLINE float lode_start_shifted_rad(lode_start_t *self, bool second) {
    if (self->stage != (uint_least8_t)LODE_START_TURN) {
        return 0.0f;
    }
    float *shift_rad = &self->seen.turn.shift_rad[second ? 1 : 0];
    const float before_rad = *shift_rad;
    *shift_rad = lode_start_shift_rad(self);
    return *shift_rad - before_rad;
}

// The vector including the damping. At the end of the shift's range the angle is off by 1e-3 rad and the length by 0.3
// %, which is harmless.
LODE_INLINE lode_sincos_t lode_start_vector(const lode_start_t *self) {
    return lode_angle_add(self->at, lode_sincos_small(lode_start_shift_rad(self)));
}

// The vector one period later.
LODE_INLINE lode_sincos_t lode_start_next(const lode_start_t *self, float ts_s) {
    const float move_rad = lode_start_shift_rad(self) + ts_s * self->omega_rad_s;
    return lode_angle_add(self->at, lode_sincos_octant(move_rad));
}

#endif
