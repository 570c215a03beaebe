#include "lodestar/learn.h"
#include "scalar_inline.h"

#include <stddef.h>

// Bounds over the configured values: the iron may be far from the data sheet; magnets lose a fifth from 20 to 120 degC.
#define LQ_LEAST 0.3f
#define LQ_MOST 3.0f
#define PSI_LEAST 0.7f
#define PSI_MOST 1.2f
// Over the least saliency that init accepts.
#define SALIENCY_ROOM 1.01f
// Of rated speed: from here on there is EMF enough to learn Lq, and psi.
#define OMEGA_LEAST 0.13f
#define OMEGA_PSI 0.32f
#define I_LEAST 0.15f // of i_max
// Least weight of injection in the position (H11).
#define SHARE_LEAST 0.5f
// Time that observer and PLL need after a new tuning, or a change of speed or load; then the samples of a measurement.
#define SETTLE_s 0.05f
#define MEASURE_s 0.15f
// Share of its error that a measurement corrects: a steady error falls to 1 % in four measurements.
#define GAIN 0.7f
#define CONFIDENCE_GAIN 0.25f
// Relative error of Lq from which a measurement adds no confidence.
#define AGREE 0.1f
// Relative change that is worth a new tuning.
#define WORTH 0.003f

lode_status_t lode_learn_design(lode_learn_tuning_t *tuning, const lode_drive_config_t *config,
                                lode_choice_t psi) {
    if (tuning == NULL || config == NULL) {
        return LODE_ERROR_NULL;
    }
    if (!lode_is_choice(psi)) {
        return LODE_ERROR_CHOICE;
    }
    lode_drive_tuning_t drive;
    const lode_status_t status = lode_drive_tune(&drive, config);
    if (status != LODE_OK) {
        return status;
    }
    lode_drive_config_t complete = *config;
    lode_drive_design(&complete);
    if (complete.hfi.learn != LODE_ON) {
        return LODE_ERROR_HFI_LEARN;
    }
    const lode_motor_t *motor = &complete.motor;
    const float salient =
        SALIENCY_ROOM * LODE_HFI_SALIENCY_MIN * motor->Ld_H / complete.hfi.Lq_i_max_H;
    *tuning = (lode_learn_tuning_t){
        .Ld_H = motor->Ld_H,
        .Lq_H = {lode_min(lode_max(LQ_LEAST, salient), 1.0f) * motor->Lq_H, LQ_MOST * motor->Lq_H},
        .psi_Wb = {PSI_LEAST * motor->psi_Wb, PSI_MOST * motor->psi_Wb},
        .omega_least = OMEGA_LEAST * motor->omega_rated_rad_s,
        .omega_psi = OMEGA_PSI * motor->omega_rated_rad_s,
        .i_least_A = I_LEAST * complete.inverter.i_max_A,
        .droop_s2 = drive.estimator.droop_s2,
        .learns_psi = psi != LODE_OFF,
    };
    return LODE_OK;
}

static void restart(lode_learn_t *self) {
    self->time_s = 0.0f;
    self->iq2_A2 = 0.0f;
    self->off_VsA = 0.0f;
    self->psi_Wb = 0.0f;
    self->samples = 0.0f;
    self->psi_samples = 0.0f;
}

// True: a value that was stored, not the content of a memory that was never written.
static bool is_sound(const lode_learn_tuning_t *tuning, const lode_learned_t *stored) {
    return lode_in_range(stored->Lq_H, tuning->Lq_H.min, tuning->Lq_H.max) &&
           lode_in_range(stored->confidence, FLT_MIN, 1.0f) &&
           (!tuning->learns_psi ||
            lode_in_range(stored->psi_Wb, tuning->psi_Wb.min, tuning->psi_Wb.max));
}

void lode_learn_begin(lode_learn_t *self, const lode_learn_tuning_t *tuning,
                      const lode_drive_config_t *config, const lode_learned_t *stored) {
    const lode_learned_t given = {config->motor.Lq_H, config->motor.psi_Wb, 0.0f};
    const lode_learned_t *from = stored != NULL && is_sound(tuning, stored) ? stored : &given;
    const float psi_Wb = tuning->learns_psi
                             ? lode_clamp(from->psi_Wb, tuning->psi_Wb.min, tuning->psi_Wb.max)
                             : given.psi_Wb;
    self->used = given;
    self->now = (lode_learned_t){
        lode_clamp(from->Lq_H, tuning->Lq_H.min, tuning->Lq_H.max),
        psi_Wb,
        lode_clamp(from->confidence, 0.0f, 1.0f),
    };
    restart(self);
}

static bool can_measure(const lode_learn_tuning_t *tuning, const lode_telemetry_t *now) {
    return now->mode == LODE_MODE_RUN && now->injected >= SHARE_LEAST &&
           now->lock >= LODE_LOCK_LOST && lode_abs(now->omega_rad_s) >= tuning->omega_least &&
           lode_abs(now->i_A.q) >= tuning->i_least_A;
}

// (H16), (H18): adds a sample. The PLL keeps the mean of (H11) at 0, so that the two angles differ by e_e/w_h.
static void sum_up(lode_learn_t *self, const lode_learn_tuning_t *tuning,
                   const lode_telemetry_t *now) {
    const float omega = lode_abs(now->omega_rad_s);
    const float salient_Wb = (tuning->Ld_H - self->now.Lq_H) * now->i_A.d;
    const float error = now->emf_error_rad / now->injected;
    self->iq2_A2 += now->i_A.q * now->i_A.q;
    self->off_VsA += error * (self->now.psi_Wb + salient_Wb) * now->i_A.q;
    self->samples += 1.0f;
    if (tuning->learns_psi && omega >= tuning->omega_psi) {
        const float taken = 1.0f + omega * omega * tuning->droop_s2;
        self->psi_Wb += lode_ab_length(now->e_V) * taken / omega - salient_Wb;
        self->psi_samples += 1.0f;
    }
}

// (H17), (H18)
static void learn(lode_learn_t *self, const lode_learn_tuning_t *tuning) {
    const float off_H = self->off_VsA / self->iq2_A2;
    if (!lode_is_finite(off_H) || !lode_is_finite(self->psi_Wb)) {
        return;
    }
    const float agree = lode_max(1.0f - lode_abs(off_H) / (AGREE * self->now.Lq_H), 0.0f);
    self->now.Lq_H = lode_clamp(self->now.Lq_H + GAIN * off_H, tuning->Lq_H.min, tuning->Lq_H.max);
    self->now.confidence += CONFIDENCE_GAIN * (agree - self->now.confidence);
    if (self->psi_samples >= self->samples) {
        const float psi_Wb = self->psi_Wb / self->psi_samples;
        self->now.psi_Wb = lode_clamp(self->now.psi_Wb + GAIN * (psi_Wb - self->now.psi_Wb),
                                      tuning->psi_Wb.min, tuning->psi_Wb.max);
    }
}

static bool is_worth(float now, float used) {
    return lode_abs(now - used) > WORTH * used;
}

bool lode_learn_step(lode_learn_t *self, const lode_learn_tuning_t *tuning,
                     const lode_telemetry_t *telemetry, float dt_s) {
    if (!can_measure(tuning, telemetry)) {
        restart(self);
    } else {
        self->time_s += dt_s;
        if (self->time_s >= SETTLE_s) {
            sum_up(self, tuning, telemetry);
        }
        if (self->time_s >= SETTLE_s + MEASURE_s) {
            learn(self, tuning);
            restart(self);
        }
    }
    return is_worth(self->now.Lq_H, self->used.Lq_H) ||
           is_worth(self->now.psi_Wb, self->used.psi_Wb);
}

lode_status_t lode_learn_tune(lode_learn_t *self, lode_drive_tuning_t *tuning,
                              const lode_drive_config_t *config) {
    lode_drive_config_t next = *config;
    const float times = self->now.Lq_H / config->motor.Lq_H;
    next.motor.Lq_H = self->now.Lq_H;
    next.motor.psi_Wb = self->now.psi_Wb;
    next.hfi.Lq_i_max_H *= times;
    next.current.kp_q_V_A *= times;
    self->used = self->now; // a refused tuning is not tried again until a value changes
    return lode_drive_tune(tuning, &next);
}

void lode_learn_telemetry(const lode_learn_t *self, lode_telemetry_t *telemetry) {
    telemetry->motor.Lq_H = (lode_adapted_t){self->now.Lq_H, self->now.confidence};
}
