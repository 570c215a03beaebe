/// A drive on a motor in double with an ideal inverter and 12-bit ADCs.
#ifndef SUPPORT_RIG_H
#define SUPPORT_RIG_H

#include "support/ipmsm.h"

#include "lodestar/drive.h"

#define RIG_GAIN_A 0.0125
#define RIG_GAIN_V 0.1
#define RIG_TS_s 2.0e-4

/// Only what cannot be computed.
static inline lode_drive_config_t rig_config(void) {
    lode_drive_config_t config = {.f_pwm_Hz = 5000.0f,
                                  .motor = paper_motor(),
                                  .inverter = {.v_bus_V = PAPER_V_BUS, .i_max_A = 12.0f},
                                  .sense = {.i_gain_A_count = (float)RIG_GAIN_A,
                                            .i_offset_count = 2048.0f,
                                            .v_bus_gain_V_count = (float)RIG_GAIN_V}};
    config.motor.omega_rated_rad_s = 0.0f;
    return config;
}

typedef struct {
    lode_drive_t drive;
    lode_drive_out_t out;
    ipmsm_t motor;
    double load_Nm;     ///< friction-like: against the rotation
    double pull_Nm;     ///< constant, whichever way the rotor turns
    bool blocked;       ///< the rotor stands still
    double offset[3];   ///< of the current ADC channels, counts
    lode_abc_t applied; ///< duties under way
    uint32_t stamp;
    bool trip;
    double sag_V; ///< of the bus, below the nominal one
    double low_s; ///< for which the low sides have been on
    double angle_error;
} rig_t;

static inline void rig_init(rig_t *self, lode_drive_tuning_t *tuning,
                            const lode_drive_config_t *config) {
    *self = (rig_t){.motor = ipmsm_paper(0.0), .applied = {0.5f, 0.5f, 0.5f}};
    TEST_ASSERT_EQUAL_STRING("LODE_OK",
                             lode_status_name(lode_drive_init(&self->drive, tuning, config)));
}

static inline uint16_t rig_count(double x) {
    return (uint16_t)fmax(0.0, fmin(4095.0, floor(x + 0.5)));
}

static inline lode_counts_t rig_counts(const rig_t *self) {
    const lode_abc_t i = lode_clarke_inverse(ipmsm_current(&self->motor));
    lode_counts_t counts = {.v_bus = rig_count(((double)PAPER_V_BUS - self->sag_V) / RIG_GAIN_V),
                            .trip = self->trip,
                            .stamp = self->stamp};
    counts.i[0] = rig_count(2048.0 + self->offset[0] + (double)i.a / RIG_GAIN_A);
    counts.i[1] = rig_count(2048.0 + self->offset[1] + (double)i.b / RIG_GAIN_A);
    counts.i[2] = rig_count(2048.0 + self->offset[2] + (double)i.c / RIG_GAIN_A);
    return counts;
}

/// Motor and shaft over one period, with the duties of the call before.
static inline void rig_move(rig_t *self) {
    ipmsm_t *m = &self->motor;
    const double torque = ipmsm_torque(m);
    const double drag = self->load_Nm * tanh(m->omega / 3.0) + 7.5e-4 * m->omega / 3.0;
    m->acc = self->blocked ? 0.0 : 3.0 / 0.0174 * (torque - drag - self->pull_Nm);
    const lode_ab_t u = lode_clarke(self->applied);
    if (self->out.gates == LODE_GATES_ON) {
        ipmsm_step(m, (double)PAPER_V_BUS * (double)u.alpha, (double)PAPER_V_BUS * (double)u.beta,
                   RIG_TS_s);
    } else { // the diodes let the current die at once
        m->id = 0.0;
        m->iq = 0.0;
        m->theta = remainder(m->theta + RIG_TS_s * m->omega, 2.0 * CHECK_PI);
        m->omega += RIG_TS_s * m->acc;
        if (self->out.gates ==
            LODE_GATES_LOW) { // short-circuited since half of the share ago, or for whole periods
            const double share = 1.0 - (double)self->applied.a;
            self->low_s = share < 1.0 ? 0.5 * share * RIG_TS_s : self->low_s + RIG_TS_s;
            const double turned = self->low_s * m->omega;
            m->id = 0.142 * (cos(turned) - 1.0) / 3.5e-3;
            m->iq = -0.142 * sin(turned) / 9.8e-3;
        }
    }
    self->applied = self->out.duty;
}

static inline void rig_step(rig_t *self) {
    self->stamp += 1000u;
    const lode_counts_t counts = rig_counts(self);
    self->out = lode_drive_step(&self->drive, &counts);
    lode_telemetry_t t;
    (void)lode_drive_telemetry(&self->drive, &t);
    self->angle_error = angle_error((double)t.theta_rad, self->motor.theta);
    rig_move(self);
}

static inline void rig_run(rig_t *self, double seconds) {
    const int count = (int)(seconds / RIG_TS_s + 0.5);
    for (int n = 0; n < count; n++) {
        rig_step(self);
    }
}

static inline void rig_command(rig_t *self, lode_command_t command) {
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_drive_post_command(&self->drive, &command));
}

static inline lode_telemetry_t rig_telemetry(const rig_t *self) {
    lode_telemetry_t t;
    TEST_ASSERT_TRUE(lode_drive_telemetry(&self->drive, &t));
    return t;
}

static inline void rig_expect(const rig_t *self, lode_mode_t mode) {
    TEST_ASSERT_EQUAL_STRING(lode_mode_name(mode), lode_mode_name(rig_telemetry(self).mode));
}

#endif
