#include "replay.h"

#include "motor.h"
#include "plant.h"

#define FNV_PRIME 1099511628211u
#define FLIP_AT (REPLAY_ROWS / 2)

static lode_drive_config_t config_of(int32_t number) {
    lode_drive_config_t config = {.motor = motor_data()};
    plant_describe(&config);
    if (number > 0) {
        config.estimator.emf.kind = LODE_EMF_FA_MULTI;
        config.estimator.notch_k = 0.7f;
        config.estimator.notch12_k = 0.7f;
        config.estimator.w_filter_rad_s = 2000.0f;
        config.inverter.pwm_ticks = 8400.0f;
    }
    return config;
}

bool replay_begin(replay_t *self, int32_t number, uint64_t digest) {
    const lode_drive_config_t config = config_of(number);
    const lode_command_t run = {.mode = LODE_MODE_RUN, .speed_rad_s = MOTOR_SPEED_rad_s};
    self->periods = 0u;
    self->running = 0u;
    self->digest = digest;
    return lode_drive_init(&self->drive, &self->tuning, &config) == LODE_OK &&
           lode_drive_post_command(&self->drive, &run) == LODE_OK;
}

// The least significant octet first, whatever the machine's own order.
static void take(replay_t *self, uint32_t word) {
    for (int32_t k = 0; k < 4; k++) {
        self->digest = (self->digest ^ (word & 255u)) * FNV_PRIME;
        word >>= 8;
    }
}

static void take_float(replay_t *self, float x) {
    union {
        float value;
        uint32_t bits;
    } both = {x};
    take(self, both.bits);
}

static void take_dq(replay_t *self, lode_dq_t x) {
    take_float(self, x.d);
    take_float(self, x.q);
}

static void take_abc(replay_t *self, lode_abc_t x) {
    take_float(self, x.a);
    take_float(self, x.b);
    take_float(self, x.c);
}

static void take_telemetry(replay_t *self, const lode_telemetry_t *t) {
    take(self, t->steps);
    take(self, (uint32_t)t->mode);
    take(self, t->fault.state);
    take(self, t->fault.check);
    take_float(self, t->fault.measured);
    take_float(self, t->fault.limit);
    take_abc(self, t->duty);
    take_dq(self, t->i_A);
    take_dq(self, t->ref_A);
    take_dq(self, t->u_V);
    take_float(self, t->v_bus_V);
    take_float(self, t->temperature_degC);
    take_float(self, t->theta_rad);
    take_float(self, t->omega_rad_s);
    take_float(self, t->speed_ref_rad_s);
    take_float(self, t->load_torque_Nm);
    take_float(self, t->lock);
    take_float(self, t->e_V.alpha);
    take_float(self, t->e_V.beta);
}

lode_drive_out_t replay_step(replay_t *self, const replay_row_t *row) {
    self->periods++;
    const lode_counts_t counts = {.i = {row->i[0], row->i[1], row->i[2]},
                                  .v_bus = row->v_bus,
                                  .stamp = self->periods * PLANT_STAMP_PER_PERIOD};
    const lode_drive_out_t out = lode_drive_step(&self->drive, &counts);
    take_abc(self, out.duty);
    take(self, out.gates ? 1u : 0u);
    lode_telemetry_t now;
    (void)lode_drive_telemetry(&self->drive, &now);
    take_telemetry(self, &now);
    self->running += now.mode == LODE_MODE_RUN ? 1u : 0u;
    return out;
}

static bool in_run(const replay_t *self) {
    lode_telemetry_t now;
    return lode_drive_telemetry(&self->drive, &now) && now.mode == LODE_MODE_RUN;
}

bool replay_all(const replay_row_t rows[REPLAY_CASES][REPLAY_ROWS], bool flip, uint64_t *digest) {
    static replay_t replay; // too large for the stack of the smallest machine
    bool good = true;
    *digest = REPLAY_DIGEST;
    for (int32_t number = 0; number < REPLAY_CASES; number++) {
        if (!replay_begin(&replay, number, *digest)) {
            return false;
        }
        for (int32_t n = 0; n < REPLAY_ROWS; n++) {
            replay_row_t row = rows[number][n];
            if (flip && n == FLIP_AT) {
                row.i[0] ^= 1u;
            }
            (void)replay_step(&replay, &row);
        }
        *digest = replay.digest;
        // Open loop: from the flipped bit on the drive parts from the motor, and may lose it.
        good = good && (flip || in_run(&replay));
    }
    return good;
}
