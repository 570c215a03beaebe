// The current vector of the start, one period.
#ifndef LODE_START_INLINE_H
#define LODE_START_INLINE_H

#include "lodestar/start.h"
#include "scalar_inline.h"

// Three attempts until the start has failed. A rotor with more on its shaft than configured cannot follow the
// ramp: each has a quarter of the one before. The last one also takes more current, against a load.
#define LODE_START_EASE 0.25f
#define LODE_START_EASE_LAST (LODE_START_EASE * LODE_START_EASE)
#define LODE_START_FAILED_MAX 2u // attempts before the last one
// Attempts that may end after the hand-over: these and the last one itself, which nothing gentler follows and which is
// repeated once (S28).
#define LODE_START_LOSSES_MAX (LODE_START_FAILED_MAX + 1u)

// The sweep to half of the current, where it is measured there, over that from there to all of it: to each from phase
// axis to phase axis, by 240 and by 60 degrees (S29).
#define LODE_START_SWEEP_FIRST 4.0f

// Share of the ramp in the present attempt, by those that failed. The last one, repeated, need not take as long: the rotor
// has followed it.
LODE_INLINE float lode_start_ease(const lode_start_t *self) {
    static const float share[] = {1.0f, LODE_START_EASE, LODE_START_EASE_LAST, LODE_START_EASE};
    return share[self->failed & LODE_START_LOSSES_MAX]; // 3: within the table, whatever flips
}

LODE_INLINE bool lode_start_catches(const lode_start_t *self) {
    return self->stage == (uint_least8_t)LODE_START_CATCH;
}

// Between the speeds of estimator and vector. Of the vector's speed: a load that swings within a turn swings the rotor in
// proportion.
#define LODE_START_TOLERANCE 0.25f

LODE_INLINE float lode_start_slack(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    return LODE_START_TOLERANCE * lode_max(lode_abs(self->omega_rad_s), tuning->omega_ready);
}

// A speed estimate goes with a vector that turns fast enough for one.
LODE_INLINE bool lode_start_follows(const lode_start_t *self, const lode_start_tuning_t *tuning,
                                    float omega_rad_s, float slack) {
    const float vector = self->omega_rad_s;
    return lode_abs(vector) >= tuning->omega_ready && vector * self->omega_target > 0.0f &&
           lode_abs(omega_rad_s - vector) <= slack;
}

// One period from t_k-1 to t_k. `e_V`: estimated EMF at t_k. Returns the angle by which the vector turns in
// a period now, rad.
LODE_INLINE float lode_start_step(lode_start_t *self, const lode_start_tuning_t *tuning,
                                  lode_ab_t e_V, float ts_s) {
    // Turning at speed begins when the current is there and resistance and dead time are measured. While the
    // current rises at standstill the vector sweeps, most of it to the first current that is measured with: a rotor
    // that lies opposite to it would feel no torque, and one that falls back to it is carried along (S29).
    float advance_rad = ts_s * self->omega_rad_s;
    if (!(self->current_A < self->current_target) &&
        !(self->stage < (uint_least8_t)LODE_START_TURN)) {
        const float most = self->omega_step;
        self->omega_rad_s += lode_clamp(self->omega_target - self->omega_rad_s, -most, most);
        advance_rad = ts_s * self->omega_rad_s;
    } else if (self->current_A < self->current_target && !(lode_abs(self->omega_rad_s) > 0.0f) &&
               self->stands == 0u) {
        advance_rad = lode_sign(self->omega_target) * tuning->sweep_step_rad;
#ifndef LODE_WITHOUT_START_MEASUREMENT
        if (self->stage == (uint_least8_t)LODE_START_HALF) {
            advance_rad *= LODE_START_SWEEP_FIRST;
        }
#endif
    } else {
        // the vector rests while it is measured or stands ahead of the rotor, or its current rises on at the speed that there is
    }
    self->current_A += lode_clamp(self->current_target - self->current_A, -tuning->current_step,
                                  tuning->current_step);
    const lode_sincos_t half = lode_sincos_small(0.5f * advance_rad);
    self->at = lode_angle_add(self->at, lode_angle_double(half));
    // Of a swing the EMF across the vector shows speed and angle; its size, which comes in with speed, only the
    // speed (S19).
    const float by_size = self->by_size;
    float across_V = lode_park(e_V, self->at).q;
    if (lode_abs(by_size) > 0.0f) { // no root at rest: there the plausibility takes most
        across_V = (1.0f - lode_abs(by_size)) * across_V + by_size * lode_ab_length(e_V);
    }
    self->mean_V += tuning->mean_weight * (across_V - self->mean_V);
    self->swing_V += tuning->swing_weight * (across_V - self->mean_V - self->swing_V);
    return advance_rad;
}

// How far the vector is turned ahead, to damp the rotor's swing.
LODE_INLINE float lode_start_shift_rad(const lode_start_t *self) {
    return lode_clamp(-self->give * self->swing_V, -LODE_START_SHIFT_MAX_rad,
                      LODE_START_SHIFT_MAX_rad);
}

// How far the damping has turned the vector, rad, since the last call.
LODE_INLINE float lode_start_shifted_rad(lode_start_t *self) {
    if (self->stage != (uint_least8_t)LODE_START_TURN) {
        return 0.0f;
    }
    const float before_rad = self->seen.turn.shift_rad;
    self->seen.turn.shift_rad = lode_start_shift_rad(self);
    return self->seen.turn.shift_rad - before_rad;
}

// The vector, with the damping. At the end of the shift's range the angle is off by 1e-3 rad, the length by
// 0.3 %: the damping does not mind.
LODE_INLINE lode_sincos_t lode_start_vector(const lode_start_t *self) {
    return lode_angle_add(self->at, lode_sincos_small(lode_start_shift_rad(self)));
}

// Where it will be a period on.
LODE_INLINE lode_sincos_t lode_start_next(const lode_start_t *self, float ts_s) {
    const float move_rad = lode_start_shift_rad(self) + ts_s * self->omega_rad_s;
    return lode_angle_add(self->at, lode_sincos_octant(move_rad));
}

#endif
