#include "lodestar/drive6.h"

#include "drive_parts.h"
#include "open_phase_inline.h"

#include <stddef.h>

// A phase within so many counts of zero is open rather than its ADC channel stuck.
#define STILL_COUNTS 4

lode_motor_t lode_drive6_motor_alone(const lode_motor_t *motor, float Lxy_H) {
    lode_motor_t alone = *motor;
    alone.Ld_H = 0.5f * (motor->Ld_H + Lxy_H);
    alone.Lq_H = 0.5f * (motor->Lq_H + Lxy_H);
    alone.sets = 1.0f;
    return alone;
}

// Inductance for the ripple of a set's currents, which has parts in both planes: 1/L is the mean of theirs, mostly the
// leakage's.
static float ripple_H(float L_H, float Lxy_H) {
    return 2.0f * L_H * Lxy_H / lode_max(L_H + Lxy_H, FLT_MIN);
}

void lode_drive6_design(lode_drive6_config_t *config) {
    const float ts_s = 1.0f / lode_max(config->drive.f_pwm_Hz, FLT_MIN);
    config->drive.motor.sets = (float)LODE_SETS;
    lode_motor_t ripple = config->drive.motor;
    ripple.Ld_H = ripple_H(ripple.Ld_H, config->Lxy_H);
    ripple.Lq_H = ripple_H(ripple.Lq_H, config->Lxy_H);
    lode_inverter_design(&config->drive.inverter, &ripple, ts_s);
    lode_xy_design(&config->xy, ts_s);
    // A set's voltage may be the sum of both planes' voltages.
    lode_sense_design(&config->drive.sense);
    const float use = lode_drive_voltage_use(&config->drive) - config->xy.voltage_share;
    config->drive.current.voltage_use = lode_given_or(config->drive.current.voltage_use, use);
    lode_drive_design(&config->drive);
}

static lode_status_t check(const lode_drive6_config_t *config) {
    if (config->source != LODE_SOURCE_VSD && config->source != LODE_SOURCE_SET_1 &&
        config->source != LODE_SOURCE_SET_2) {
        return LODE_ERROR_SOURCE;
    }
    const bool known = config->open_phase == LODE_OPEN_PHASE_TRIP ||
                       config->open_phase == LODE_OPEN_PHASE_GO_ON ||
                       config->open_phase == LODE_OPEN_PHASE_IGNORE;
    if (!known) {
        return LODE_ERROR_OPEN_PHASE;
    }
    return config->drive.hfi.learn == LODE_ON ? LODE_ERROR_HFI_LEARN : LODE_OK; // three phases only
}

// One set is checked while the other has no voltage: half of the voltage acts in each plane.
static lode_status_t tune_signal_check(lode_drive6_tuning_t *t,
                                       const lode_drive6_config_t *config) {
#ifdef LODE_WITHOUT_SIGNAL_CHECK
    (void)t;
    (void)config;
    return LODE_OK;
#else
    lode_motor_t set = config->drive.motor;
    set.Ld_H = ripple_H(set.Ld_H, config->Lxy_H);
    set.Lq_H = ripple_H(set.Lq_H, config->Lxy_H);
    const lode_status_t status =
        lode_drive_tune_signal_check(&t->drive, &config->drive, &set, &t->drive.fly);
    // Open phases that are to be ignored have no signal to check.
    const bool ignores = config->open_phase == LODE_OPEN_PHASE_IGNORE;
    t->drive.signal_check.pulses *= ignores ? 0u : (uint32_t)LODE_SETS;
    return status;
#endif
}

// Given values hold for one set too, current gains with its inductances; what follows from the inductances is designed again.
// Where no set goes on alone, one that cannot is no error.
static lode_status_t tune_alone(lode_drive6_tuning_t *t, const lode_drive6_config_t *given) {
    const lode_motor_t *both = &given->drive.motor;
    lode_drive_config_t alone = given->drive;
    alone.hfi.mode = LODE_HFI_OFF;
    alone.motor = lode_drive6_motor_alone(both, given->Lxy_H);
    alone.current.kp_d_V_A *= alone.motor.Ld_H / both->Ld_H;
    alone.current.kp_q_V_A *= alone.motor.Lq_H / both->Lq_H;
    const lode_status_t status = lode_drive_tune(&t->alone, &alone);
    if (status != LODE_OK && given->open_phase != LODE_OPEN_PHASE_GO_ON) {
        t->alone = t->drive;
        return LODE_OK;
    }
    return status;
}

lode_status_t lode_drive6_tune(lode_drive6_tuning_t *tuning, const lode_drive6_config_t *config) {
    if (tuning == NULL || config == NULL) {
        return LODE_ERROR_NULL;
    }
    lode_status_t status = lode_drive_check_given(&config->drive);
    if (status == LODE_OK) {
        status = check(config);
    }
    if (status != LODE_OK) {
        return status;
    }
    // The xy plane first: it checks Lxy_H, with which the rest is designed.
    lode_drive6_config_t complete = *config;
    lode_drive6_tuning_t t;
    const float ts_s = 1.0f / config->drive.f_pwm_Hz;
    lode_xy_design(&complete.xy, ts_s);
    status = lode_xy_tune(&t.xy, &complete.xy,
                          config->drive.motor.Rs_Ohm + config->drive.inverter.r_on_Ohm,
                          config->Lxy_H, ts_s);
    if (status == LODE_OK) {
        lode_drive6_design(&complete);
        status = lode_drive_tune(&t.drive, &complete.drive);
    }
    if (status == LODE_OK) {
        status = tune_alone(&t, config);
    }
    if (status == LODE_OK) {
        status = tune_signal_check(&t, &complete);
    }
    if (status == LODE_OK) {
        const float xy_rad_s = lode_max(t.xy.bandwidth_rad_s, t.xy.corner_rad_s);
        t.watch = lode_open_phase_tune(complete.drive.inverter.i_max_A, xy_rad_s,
                                       (float)LODE_WATCH_PERIODS * ts_s);
        // A set's voltage vector is the sum of those of the dq and the xy plane.
        t.drive.current.free = lode_min(t.drive.current.free, t.drive.inverter.free - t.xy.circle);
#ifndef LODE_WITHOUT_PLAUSIBILITY
        t.drive.plausibility.i_still = STILL_COUNTS * LODE_COUNT_FRACTION;
        t.alone.plausibility.i_still = t.drive.plausibility.i_still;
        t.drive.plausibility.per_wave_A = 0.0f; // open_phase.h watches six phases
        t.alone.plausibility.per_wave_A = 0.0f;
#endif
#ifndef LODE_WITHOUT_FLYING_START
        // A single set has another inductance, and the other set's current flows too.
        t.alone.fly.share_first = 0.0f;
#endif
#ifndef LODE_WITHOUT_SIGNAL_CHECK
        t.alone.signal_check.pulses = 0u; // for the same reason
#endif
        t.source = (uint_least16_t)complete.source;
        t.open_phase = (uint_least16_t)complete.open_phase;
        *tuning = t;
    }
    return status;
}
