/// Where a fuzzed drive has angle and speed from: its own estimator, an angle sensor, or a host that
/// tells the truth with the errors that the input gives it.
#ifndef SUPPORT_FUZZ_GUIDE_H
#define SUPPORT_FUZZ_GUIDE_H

#include "support/fuzz_plant.h"

#include "lodestar/encoder.h"

enum {
    FUZZ_BY_STEP,    ///< lode_drive_step()
    FUZZ_BY_PARTS,   ///< the same in its three parts
    FUZZ_BY_TRUTH,   ///< the motor's own angle and speed
    FUZZ_BY_ENCODER, ///< 4095 counts per turn
    FUZZ_BY_HALL,    ///< 6 counts per pole pair
    FUZZ_GUIDES
};

enum { FUZZ_ESTIMATE_FIELDS = 9 };

typedef struct {
    lode_encoder_tuning_t fine;
    lode_encoder_tuning_t hall;
} fuzz_sensors_t;

typedef struct {
    uint8_t kind;
    uint8_t source; ///< lode_estimate_source_t of FUZZ_BY_TRUTH
    float off_rad;  ///< errors of FUZZ_BY_TRUTH
    float off_rad_s;
    float lock;
    uint32_t slip;   ///< counts by which the sensor is off
    uint8_t strange; ///< fields that the next estimate has from `values`
    float values[FUZZ_ESTIMATE_FIELDS];
    lode_encoder_t encoder;
} fuzz_guide_t;

static inline void fuzz_sensors_init(fuzz_sensors_t *self, const lode_drive_tuning_t *drive) {
    const lode_encoder_config_t fine = {.counts_per_turn = 4095u};
    const lode_encoder_config_t hall = {.counts_per_turn = 18u, .falls_back = true};
    FUZZ_CHECK(lode_encoder_tune(&self->fine, &fine, drive) == LODE_OK);
    FUZZ_CHECK(lode_encoder_tune(&self->hall, &hall, drive) == LODE_OK);
}

/// Takes another guide; its errors are small, or any.
static inline void fuzz_guide_choose(fuzz_guide_t *self, fuzz_t *in) {
    const uint8_t choice = fuzz_byte(in);
    *self = (fuzz_guide_t){.kind = choice % (uint8_t)FUZZ_GUIDES, .lock = 1.0f};
    self->source = choice / 8u % 8u < 5u ? choice / 8u % 8u : (uint8_t)LODE_ESTIMATE_SENSOR;
    if ((choice & 64u) != 0u) {
        self->off_rad = fuzz_number(in, 3.0f);
        self->off_rad_s = fuzz_number(in, 500.0f);
        self->lock = fuzz_number(in, 1.0f);
        self->slip = fuzz_word(in);
    }
}

/// Of the next estimate some fields are any numbers.
static inline void fuzz_guide_spoil(fuzz_guide_t *self, fuzz_t *in) {
    self->strange = fuzz_byte(in);
    const float size = powf(10.0f, (float)(fuzz_byte(in) % 40u));
    for (int n = 0; n < FUZZ_ESTIMATE_FIELDS; n++) {
        self->values[n] = fuzz_number(in, size);
    }
}

/// The drive checks it.
static inline bool fuzz_is_external(const lode_estimate_t *x) {
    return x->source != LODE_ESTIMATE_OWN && x->source != LODE_ESTIMATE_NONE;
}

static inline lode_estimate_t fuzz_guide_spoiled(fuzz_guide_t *self, lode_estimate_t x) {
    float *const fields[FUZZ_ESTIMATE_FIELDS] = {&x.omega_rad_s,    &x.rotor.sin, &x.rotor.cos,
                                                 &x.i_A.d,          &x.i_A.q,     &x.e_V.alpha,
                                                 &x.load_torque_Nm, &x.lock,      &x.e_V.beta};
    for (unsigned n = 0; n < FUZZ_ESTIMATE_FIELDS && self->strange != 0u; n++) {
        if ((self->strange >> n % 8u & 1u) != 0u) {
            *fields[n] = self->values[n];
        }
    }
    self->strange = 0u;
    return x;
}

static inline lode_estimate_t fuzz_guide_truth(const fuzz_guide_t *self, lode_estimate_t own,
                                               lode_ab_t i_A, const plant_truth_t *truth) {
    lode_estimate_t x = own;
    x.source = (lode_estimate_source_t)self->source;
    x.omega_rad_s = (float)truth->omega_e_rad_s + self->off_rad_s;
    x.rotor = lode_sincos((float)truth->theta_e_rad + self->off_rad);
    x.i_A = lode_park(i_A, x.rotor);
    x.lock = self->lock;
    return x;
}

static inline lode_estimate_t fuzz_guide_sensor(fuzz_guide_t *self,
                                                const lode_encoder_tuning_t *tuning,
                                                const lode_estimate_t *own, lode_ab_t i_A,
                                                const plant_truth_t *truth) {
    const double turns = truth->theta_e_rad / (2.0 * 3.14159265358979323846);
    const double counts = (double)tuning->counts_per_turn / (double)tuning->pole_pairs;
    const uint32_t count = (uint32_t)((turns + 1.0) * counts + 0.5) + self->slip;
    return lode_encoder_estimate(&self->encoder, tuning, own, i_A, count);
}

/// The estimate of this period, from the drive's `own`.
static inline lode_estimate_t fuzz_guide_next(fuzz_guide_t *self, const fuzz_sensors_t *sensors,
                                              const lode_estimate_t *own, lode_ab_t i_A,
                                              const plant_truth_t *truth) {
    lode_estimate_t x = *own;
    if (self->kind == FUZZ_BY_TRUTH) {
        x = fuzz_guide_truth(self, *own, i_A, truth);
    } else if (self->kind == FUZZ_BY_ENCODER) {
        x = fuzz_guide_sensor(self, &sensors->fine, own, i_A, truth);
    } else if (self->kind == FUZZ_BY_HALL) {
        x = fuzz_guide_sensor(self, &sensors->hall, own, i_A, truth);
    }
    FUZZ_CHECK(lode_is_finite(self->encoder.theta_rad) &&
               lode_is_finite(self->encoder.omega_rad_s));
    x = fuzz_guide_spoiled(self, x);
    return fuzz_is_external(&x) ? x : *own;
}

static inline bool fuzz_is_finite(const lode_estimate_t *x) {
    return lode_is_finite(x->omega_rad_s) && lode_is_finite(x->rotor.sin) &&
           lode_is_finite(x->rotor.cos) && lode_is_finite(x->i_A.d) && lode_is_finite(x->i_A.q) &&
           lode_is_finite(x->e_V.alpha) && lode_is_finite(x->e_V.beta) &&
           lode_is_finite(x->load_torque_Nm) && lode_is_finite(x->lock);
}

/// After lode_drive_act() with `given`: an estimate from outside that is not made of numbers drives nothing. A drive that is
/// not `driven` yet ignores it, also while it checks its signals by pulses of all gates.
static inline void fuzz_check_given(const lode_estimate_t *given, bool driven, lode_gates_t gates) {
    FUZZ_CHECK(
        !(driven && fuzz_is_external(given) && !fuzz_is_finite(given) && gates == LODE_GATES_ON));
}

#endif
