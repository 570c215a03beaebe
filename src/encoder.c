#include "lodestar/encoder.h"

#include <float.h>
#include <stddef.h>

#define COUNTS_MIN 6u
#define COUNTS_MAX (1uL << 20)
#define DELAY_MAX_PERIODS 10.0f
#define CHECK_s 5.0e-3f
#define CHECK_MAX_s 10.0f
// Of the call rate: the loop's own delay then costs it some 6 degrees of phase.
#define BANDWIDTH_SHARE 0.1f
// Largest count, rad electrical, whose steps stay small in so fast a loop. For larger counts the bandwidth falls with the
// root of the count, so that the speed ripple stays the same share of the bandwidth.
#define FINE_rad 0.02f
// (A2): inside a count the sensor knows nothing; this share of the gain acts there to damp the loop.
#define PULL_INSIDE 0.1f
// From this count on, 31 counts per electrical turn, the loop follows the edges between counts instead of the counts.
#define COARSE_rad 0.2f
// (A5): poles of speed and load from edge to edge. For an edge near where it is expected: stable with a rotor four times
// lighter than configured. For one that is a whole count off: the speed becomes the mean since the last edge.
#define POLE_NEAR 0.8f
#define POLE_FAR 0.414f
// Of a count: an edge that is less off is near. Real edges are a tenth off.
#define NEAR_SHARE 0.25f
// Times the speed from which the EMF checks the sensor, for coarse counts: without a bias in id (K10) dead time is a larger part of
// the voltage.
#define CHECK_COARSE 1.5f
// Largest load over the largest torque of the drive.
#define LOAD_MOST 2.0f

// Electrical acceleration per torque, over the torque factor. A QPLL has none: then by the inertia that speed control feeds
// forward, 0 without that.
static float acc_per_torque(const lode_drive_tuning_t *drive) {
    const float given = drive->estimator.acc_per_torque;
    const float call_s = (float)drive->speed_periods * drive->estimator.pll.ts_s;
    const float J_kgm2 = drive->speed.inertia_Nm * call_s;
    if (given > 0.0f || !(J_kgm2 > 0.0f)) {
        return given;
    }
    return drive->references.torque_factor / (drive->speed.inv_pole_pairs * J_kgm2);
}

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
    // With injection there is no lowest speed: omega_min is negative.
    const float by_default =
        drive->omega_min > 0.0f ? drive->omega_min : drive->start.omega_handover;
    const bool coarse = rad_per_count > COARSE_rad;
    const float omega_check =
        lode_given_or(config->omega_check_rad_s, coarse ? CHECK_COARSE * by_default : by_default);
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
    const float acc = acc_per_torque(drive);
    *tuning = (lode_encoder_tuning_t){
        .counts_per_turn = config->counts_per_turn,
        .pole_pairs = pole_pairs,
        .check_periods = (uint32_t)(check_s / ts_s + 0.5f),
        .settle_periods = (uint32_t)drive->estimator.settle_rounds * LODE_SLOW_PERIODS,
        .rad_per_count = config->reversed ? -rad_per_count : rad_per_count,
        .half_rad = 0.5f * rad_per_count,
        .offset_rad = config->offset_rad,
        .ts_s = ts_s,
        .delay_s = config->delay_s,
        .angle_gain = x * (2.0f - x), // both poles at 1 - x (A1)
        .speed_gain = x * x / ts_s,
        .omega_check = omega_check,
        .falls_back = config->falls_back,
        .coarse = coarse,
        .acc_per_torque = acc,
        .acc_per_omega = drive->estimator.acc_per_omega,
        .psi_Wb = drive->estimator.psi_Wb,
        .salient_H = drive->estimator.salient_H,
        .load_most = LOAD_MOST * acc * drive->references.tau_max,
    };
    return LODE_OK;
}

void lode_encoder_reset(lode_encoder_t *self) {
    *self = (lode_encoder_t){.tracks = false};
}

// Electrical angle in the middle of a count. Computed in integers, in which 2^20 counts times 100 pole pairs fit.
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

typedef struct {
    float omega_rad_s;
    float load_rad_s2;
} correction_t;

// (A5), for an edge that is `error` away from where it is expected.
static correction_t correction(const lode_encoder_t *self, const lode_encoder_tuning_t *tuning,
                               float error) {
    const float count_rad = 2.0f * tuning->half_rad;
    const float far = (lode_abs(error) / count_rad - NEAR_SHARE) / (1.0f - NEAR_SHARE);
    const float left = 1.0f - POLE_NEAR + (POLE_NEAR - POLE_FAR) * lode_clamp(far, 0.0f, 1.0f);
    // The interval by the estimated speed: the measured one is rounded to periods, as the error is.
    const float made_s = count_rad / lode_max(lode_abs(self->omega_rad_s), FLT_MIN);
    const float least_s = lode_max(self->since_s - tuning->ts_s, 0.5f * tuning->ts_s);
    const float tau_s = lode_clamp(made_s, least_s, self->since_s + tuning->ts_s);
    const float mean = error / tau_s;
    return (correction_t){left * (2.0f - 0.5f * left) * mean, left * left * mean / tau_s};
}

// The rotor is at `theta_rad`, `error` away from where it was expected.
static void correct(lode_encoder_t *self, const lode_encoder_tuning_t *tuning, float theta_rad,
                    float error) {
    const correction_t by = correction(self, tuning, error);
    const float load = self->load_rad_s2 + by.load_rad_s2;
    self->theta_rad = lode_wrap(theta_rad);
    self->omega_rad_s += by.omega_rad_s;
    self->load_rad_s2 = lode_clamp(load, -tuning->load_most, tuning->load_most);
    self->since_s = 0.0f;
}

// (A6): the rotor turns round between two edges. A load that has opposed its motion is taken for friction.
static void turn_round(lode_encoder_t *self, float before_rad_s) {
    const bool turned = self->omega_rad_s * before_rad_s < 0.0f;
    if (turned && self->load_rad_s2 * before_rad_s < 0.0f) {
        self->load_rad_s2 = -self->load_rad_s2;
    }
}

// (A3): between two edges the rotor follows torque and load. When the prediction is a whole count beyond the present count
// and no edge has come, the correction is that of an edge, and the angle the middle of the count (A4).
static void follow_edges(lode_encoder_t *self, const lode_encoder_tuning_t *tuning, float predicted,
                         float off, float moved) {
    const float before_rad_s = self->omega_rad_s;
    self->since_s += tuning->ts_s;
    self->omega_rad_s += tuning->ts_s * (self->acc_rad_s2 + self->load_rad_s2);
    turn_round(self, before_rad_s);
    if (lode_abs(moved) > tuning->half_rad) {
        // An edge is seen half a period late on average.
        const float late = 0.5f * tuning->ts_s * self->omega_rad_s;
        const float error = off + late - lode_sign(moved) * tuning->half_rad;
        correct(self, tuning, predicted + error, error);
    } else if (lode_abs(off) > 3.0f * tuning->half_rad) {
        const float made_s =
            2.0f * tuning->half_rad / lode_max(lode_abs(self->omega_rad_s), FLT_MIN);
        const float since_s = lode_min(self->since_s, made_s);
        correct(self, tuning, predicted + off, off - lode_sign(off) * tuning->half_rad);
        self->since_s = since_s;
    } else {
        self->theta_rad = lode_wrap(predicted);
    }
}

typedef struct {
    float theta_rad;
    float omega_rad_s;
} shaft_t;

// Angle and speed for the drive. When an edge is overdue, the speed is the one that the edge would give now, and the angle
// goes back to the middle of the count with the delay (A4).
static shaft_t shaft(const lode_encoder_t *self, const lode_encoder_tuning_t *tuning) {
    const float off = lode_wrap(self->seen_rad - self->theta_rad);
    const float reach = tuning->half_rad + tuning->ts_s * lode_abs(self->omega_rad_s);
    const float error = off - lode_clamp(off, -reach, reach);
    if (!tuning->coarse || !(lode_abs(error) > 0.0f)) {
        return (shaft_t){self->theta_rad, self->omega_rad_s};
    }
    const float back = lode_min(0.5f * lode_abs(error) / tuning->half_rad, 1.0f);
    const float theta_rad = lode_wrap(self->theta_rad + error + lode_sign(error) * back * reach);
    return (shaft_t){theta_rad, self->omega_rad_s + correction(self, tuning, error).omega_rad_s};
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

// The sensor shows a speed at which the EMF can tell whether it is right. Of coarse counts only the edges show one.
static bool is_checked(const lode_encoder_t *self, const lode_encoder_tuning_t *tuning,
                       float omega_rad_s) {
    const bool shown =
        !tuning->coarse || self->since_s * tuning->omega_check <= 2.0f * tuning->half_rad;
    return shown && lode_abs(omega_rad_s) >= tuning->omega_check;
}

// `own`: the drive's own estimate. With the gates off it has no EMF, and after that it needs some time.
static void check(lode_encoder_t *self, const lode_encoder_tuning_t *tuning,
                  const lode_estimate_t *own, bool checked) {
    if (own->source == LODE_ESTIMATE_NONE) {
        self->unseen = tuning->settle_periods;
    } else if (self->unseen > 0u) {
        self->unseen--;
    } else {
        // the lock says whether the EMF agrees
    }
    const bool disagrees = checked && self->unseen == 0u && own->lock < LODE_LOCK_LOST;
    self->disagreed = disagrees ? self->disagreed + 1u : 0u;
    self->distrusted = self->distrusted || self->disagreed >= tuning->check_periods;
}

// Acceleration by torque and friction, for the coming period.
static float acceleration(const lode_encoder_tuning_t *tuning, lode_dq_t i_A, float omega_rad_s) {
    const float flux_Wb = tuning->psi_Wb + tuning->salient_H * i_A.d;
    return tuning->acc_per_torque * flux_Wb * i_A.q - tuning->acc_per_omega * omega_rad_s;
}

lode_estimate_t lode_encoder_estimate(lode_encoder_t *self, const lode_encoder_tuning_t *tuning,
                                      const lode_estimate_t *own, lode_ab_t i_A, uint32_t count) {
    track(self, tuning, angle_of(tuning, count));
    lode_estimate_t estimate = *own;
    const shaft_t rotor = shaft(self, tuning);
    const bool checked = is_checked(self, tuning, rotor.omega_rad_s);
    check(self, tuning, own, checked);
    estimate.rotor = lode_sincos(lode_wrap(rotor.theta_rad + tuning->delay_s * rotor.omega_rad_s));
    estimate.omega_rad_s = rotor.omega_rad_s;
    estimate.i_A = lode_park(i_A, estimate.rotor);
    self->acc_rad_s2 = acceleration(tuning, estimate.i_A, rotor.omega_rad_s);
    if (self->distrusted && tuning->falls_back) {
        return *own;
    }
    estimate.load_torque_Nm = 0.0f; // the estimator's load belongs to its own angle
    estimate.lock = checked && self->unseen == 0u ? own->lock : 1.0f;
    estimate.source = tuning->coarse ? LODE_ESTIMATE_EDGES : LODE_ESTIMATE_SENSOR;
    return estimate;
}

float lode_encoder_offset_rad(const lode_encoder_tuning_t *tuning, const lode_estimate_t *own,
                              uint32_t count) {
    const float raw = angle_of(tuning, count) - tuning->offset_rad;
    const float moved = tuning->delay_s * own->omega_rad_s;
    return lode_wrap(lode_estimate_theta_rad(own) - moved - raw);
}
