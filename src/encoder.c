#include "lodestar/encoder.h"

#include <stddef.h>

#define COUNTS_MIN 6u
#define COUNTS_MAX (1uL << 20)
#define DELAY_MAX_PERIODS 10.0f
#define CHECK_s 5.0e-3f
#define CHECK_MAX_s 10.0f
// A tenth of the rate: the loop's own delay costs it some 6 degrees of phase.
#define BANDWIDTH_SHARE 0.1f
// Up to this count, rad electrical, the steps of a sensor stay small in a loop so fast. With larger ones the
// bandwidth falls as the root of the count, and the speed's ripple stays the same share of the bandwidth.
#define FINE_rad 0.02f
// Inside a count nothing is known, so the loop holds it there by this share of its gain only, which damps it.
#define PULL_INSIDE 0.1f
// From this count on, 31 per electrical turn, the edges between counts are followed, not the counts.
#define COARSE_rad 0.2f
// Of what an edge says of angle and of speed: sampled, it comes up to a period late. The speed's share is the least
// that goes along with a reversal at full torque; with 0.3 the angle lags by 30 degrees and more there.
#define EDGE_ANGLE_GAIN 0.7f
#define EDGE_SPEED_GAIN 0.4f

lode_status_t lode_encoder_tune(lode_encoder_tuning_t *tuning, const lode_encoder_config_t *config,
                                const lode_drive_tuning_t *drive) {
    if (tuning == NULL || config == NULL || drive == NULL) {
        return LODE_ERROR_NULL;
    }
    if (config->counts_per_turn < COUNTS_MIN || config->counts_per_turn > COUNTS_MAX) {
        return LODE_ERROR_ENCODER_COUNTS;
    }
    const float ts_s = drive->estimator.pll.ts_s;
    const float rounded = 1.0f / drive->speed.inv_pole_pairs + 0.5f;
    const uint32_t pole_pairs = (uint32_t)(int32_t)rounded;
    const float rad_per_count = LODE_TWO_PI * (float)pole_pairs / (float)config->counts_per_turn;
    const float finer = lode_min(1.0f, lode_sqrt(FINE_rad / rad_per_count));
    const float bandwidth = lode_given_or(config->bandwidth_rad_s, BANDWIDTH_SHARE * finer / ts_s);
    const float omega_check = lode_given_or(config->omega_check_rad_s, drive->omega_min);
    const float check_s = lode_given_or(config->check_s, CHECK_s);
    if (!lode_in_range(config->offset_rad, -LODE_PI, LODE_PI) ||
        !lode_in_range(config->delay_s, 0.0f, DELAY_MAX_PERIODS * ts_s)) {
        return LODE_ERROR_ENCODER_ANGLE;
    }
    if (!lode_in_range(bandwidth, 1.0f, 1.0f / ts_s)) {
        return LODE_ERROR_ENCODER_BANDWIDTH;
    }
    if (!lode_in_range(omega_check, 1.0f, 1.0e6f) || !lode_in_range(check_s, ts_s, CHECK_MAX_s)) {
        return LODE_ERROR_ENCODER_CHECK;
    }
    const float x = lode_one_minus_exp(bandwidth * ts_s);
    *tuning = (lode_encoder_tuning_t){
        .counts_per_turn = config->counts_per_turn,
        .pole_pairs = pole_pairs,
        .check_periods = (uint32_t)(check_s / ts_s + 0.5f),
        .rad_per_count = config->reversed ? -rad_per_count : rad_per_count,
        .half_rad = 0.5f * rad_per_count,
        .offset_rad = config->offset_rad,
        .ts_s = ts_s,
        .delay_s = config->delay_s,
        .angle_gain = x * (2.0f - x), // both poles at 1 - x (A1)
        .speed_gain = x * x / ts_s,
        .omega_check = omega_check,
        .falls_back = config->falls_back,
        .coarse = rad_per_count > COARSE_rad,
    };
    return LODE_OK;
}

void lode_encoder_reset(lode_encoder_t *self) {
    *self = (lode_encoder_t){.tracks = false};
}

// Electrical angle in the middle of a count. In integers, which at most 2^20 counts times 100 pole pairs fit.
static float angle_of(const lode_encoder_tuning_t *tuning, uint32_t count) {
    const uint32_t within = count % tuning->counts_per_turn;
    const uint32_t electrical = within * tuning->pole_pairs % tuning->counts_per_turn;
    const float share = (float)electrical / (float)tuning->counts_per_turn;
    return lode_wrap((tuning->rad_per_count < 0.0f ? -LODE_TWO_PI : LODE_TWO_PI) * share +
                     tuning->offset_rad);
}

// (A1), with the error (A2).
static void follow_counts(lode_encoder_t *self, const lode_encoder_tuning_t *tuning,
                          float predicted, float off) {
    const float inside = lode_clamp(off, -tuning->half_rad, tuning->half_rad);
    const float error = off - (1.0f - PULL_INSIDE) * inside;
    self->theta_rad = lode_wrap(predicted + tuning->angle_gain * error);
    self->omega_rad_s += tuning->speed_gain * error;
}

// (A3) at an edge, (A4) between two. `moved`: from the middle of the last count to that of this one.
static void follow_edges(lode_encoder_t *self, const lode_encoder_tuning_t *tuning, float predicted,
                         float off, float moved) {
    self->since_s += tuning->ts_s;
    if (lode_abs(moved) > tuning->half_rad) {
        // Seen half a period late on average.
        const float late = 0.5f * tuning->ts_s * self->omega_rad_s;
        const float error = off + late - lode_sign(moved) * tuning->half_rad;
        self->theta_rad = lode_wrap(predicted + EDGE_ANGLE_GAIN * error);
        // By the interval that the speed makes: the one measured is rounded to periods, with the error.
        const float rate = lode_abs(self->omega_rad_s) / (2.0f * tuning->half_rad);
        const float per_s = rate * self->since_s > 0.5f ? rate : 1.0f / self->since_s;
        self->omega_rad_s += EDGE_SPEED_GAIN * per_s * error;
        self->since_s = 0.0f;
        return;
    }
    // Inside the count, and as far beyond it as an edge may not have been seen yet.
    const float late_rad = tuning->ts_s * lode_abs(self->omega_rad_s);
    const float reach = tuning->half_rad + late_rad;
    self->theta_rad = lode_wrap(predicted + off - lode_clamp(off, -reach, reach));
    const float shortest_s = lode_max(self->since_s - tuning->ts_s, 0.5f * tuning->ts_s);
    const float most = 2.0f * tuning->half_rad / shortest_s;
    self->omega_rad_s = lode_clamp(self->omega_rad_s, -most, most);
}

static void track(lode_encoder_t *self, const lode_encoder_tuning_t *tuning, float theta_rad) {
    if (!self->tracks) {
        *self = (lode_encoder_t){.tracks = true, .theta_rad = theta_rad, .seen_rad = theta_rad};
        return;
    }
    const float predicted = self->theta_rad + tuning->ts_s * self->omega_rad_s;
    const float off = lode_wrap(theta_rad - predicted);
    const float moved = lode_wrap(theta_rad - self->seen_rad);
    self->seen_rad = theta_rad;
    if (tuning->coarse) {
        follow_edges(self, tuning, predicted, off, moved);
    } else {
        follow_counts(self, tuning, predicted, off);
    }
}

static void check(lode_encoder_t *self, const lode_encoder_tuning_t *tuning, float lock) {
    self->disagreed = lock < LODE_LOCK_LOST ? self->disagreed + 1u : 0u;
    self->distrusted = self->distrusted || self->disagreed >= tuning->check_periods;
}

lode_estimate_t lode_encoder_estimate(lode_encoder_t *self, const lode_encoder_tuning_t *tuning,
                                      const lode_estimate_t *own, lode_ab_t i_A, uint32_t count) {
    track(self, tuning, angle_of(tuning, count));
    const bool checked = lode_abs(self->omega_rad_s) >= tuning->omega_check;
    check(self, tuning, checked ? own->lock : 1.0f);
    lode_estimate_t estimate = *own;
    if (self->distrusted && tuning->falls_back) {
        return estimate;
    }
    const float theta = lode_wrap(self->theta_rad + tuning->delay_s * self->omega_rad_s);
    estimate.rotor = lode_sincos(theta);
    estimate.omega_rad_s = self->omega_rad_s;
    estimate.i_A = lode_park(i_A, estimate.rotor);
    estimate.load_torque_Nm = 0.0f; // the estimator's goes with its own angle
    estimate.lock = checked ? own->lock : 1.0f;
    estimate.source = LODE_ESTIMATE_SENSOR;
    return estimate;
}

float lode_encoder_offset_rad(const lode_encoder_tuning_t *tuning, const lode_estimate_t *own,
                              uint32_t count) {
    const float raw = angle_of(tuning, count) - tuning->offset_rad;
    const float moved = tuning->delay_s * own->omega_rad_s;
    return lode_wrap(lode_estimate_theta_rad(own) - moved - raw);
}
