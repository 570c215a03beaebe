/// What the tests of the drive begin with: a drive on its rig, at rest, running, or holding a current.
#ifndef SUPPORT_DRIVE_CASES_H
#define SUPPORT_DRIVE_CASES_H

#include "support/rig.h"

#include "drive_inline.h"
#include "drive_slots_inline.h"
#include "mode.h"
#include "start_inline.h"

static lode_drive_tuning_t tuning;

static inline rig_t fresh(void) {
    const lode_drive_config_t config = rig_config();
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    return rig;
}

static const lode_command_t off = {.mode = LODE_MODE_OFF};

static const lode_command_t clear = {.mode = LODE_MODE_OFF, .clear_fault = true};

/// Sensorless running at a mechanical speed.
static inline lode_command_t run_at(double speed) {
    return (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = (float)speed};
}

/// Steps until `mode`, at most `seconds`; false if it never comes.
static inline bool reach(rig_t *rig, lode_mode_t mode, double seconds) {
    for (int n = 0; n < (int)(seconds / RIG_TS_s); n++) {
        rig_step(rig);
        if (rig_telemetry(rig).mode == mode) {
            return true;
        }
    }
    return false;
}

/// From here the first vector of a start (S40) hardly swings the rotor, in either direction.
#define CALM_rad CHECK_PI

/// Into RUN at a mechanical speed.
static inline void run_up(rig_t *rig, double speed, double within_s) {
    rig_command(rig, run_at(speed));
    TEST_ASSERT_TRUE(reach(rig, LODE_MODE_RUN, within_s));
}

/// A fresh one that runs.
static inline rig_t running(double speed, double within_s) {
    rig_t rig = fresh();
    run_up(&rig, speed, within_s);
    return rig;
}

/// One that runs and has nothing else to look at in a period than its slot.
static inline rig_t steady(void) {
    lode_drive_config_t config = rig_config();
    config.motor.omega_rated_rad_s = 300.0f; // speed control in its slot is enough
    rig_t rig;
    rig_init(&rig, &tuning, &config);
    run_up(&rig, 80.0, 8.0);
    rig_run(&rig, 0.5);
    TEST_ASSERT_TRUE(rig.drive.steady);
    return rig;
}

static inline bool is_idle(lode_drive_out_t out) {
    return !out.gates && out.duty.a == 0.5f && out.duty.b == 0.5f && out.duty.c == 0.5f;
}

#define PRECHARGE_PERIODS 50

static inline bool is_low(lode_drive_out_t out, float duty) {
    return out.gates == LODE_GATES_LOW && out.duty.a == duty && out.duty.b == duty &&
           out.duty.c == duty;
}

static inline void check_running_within(rig_t *rig, double speed, double most_deg) {
    worst_t angle = {0.0};
    worst_t off_speed = {0.0};
    for (int n = 0; n < 1000; n++) {
        rig_step(rig);
        worst_note(&angle, rig->angle_error);
        worst_note(&off_speed, rig->motor.omega / 3.0 - speed);
    }
    rig_expect(rig, LODE_MODE_RUN);
    CHECK_AT_MOST(most_deg * CHECK_DEG, angle.value);
    CHECK_AT_MOST(0.01 * fabs(speed), off_speed.value);
    CHECK_AT_LEAST(0.7, rig_telemetry(rig).lock);
}

static inline void check_running(rig_t *rig, double speed) {
    check_running_within(rig, speed, 1.0); // counts of 12.5 mA move it
}

static inline lode_command_t torque_of(double torque, double speed) {
    return (lode_command_t){.mode = LODE_MODE_RUN,
                            .speed_rad_s = (float)speed,
                            .control = LODE_CONTROL_TORQUE,
                            .torque_Nm = (float)torque};
}

/// Of a rotor that turns at `omega` rad/s before the command comes.
static inline rig_t coasting(double omega) {
    rig_t rig = fresh();
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
    TEST_ASSERT_TRUE(reach(&rig, LODE_MODE_OFF, 0.2));
    rig.motor.omega = 3.0 * omega;
    return rig;
}

/// Holds 4 A along the axis of `phase`, so that its duty is the longest, with the phase not sampled.
static inline rig_t holding_without(int phase, const lode_drive_config_t *config) {
    rig_t rig;
    rig_init(&rig, &tuning, config);
    rig.blocked = true;
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT,
                                       .vector = {4.0f, 0.0f},
                                       .theta_rad = (float)(phase * 2.0 * CHECK_PI / 3.0)});
    rig_run(&rig, 0.2);
    TEST_ASSERT_TRUE(rig.out.gates);
    return rig;
}

/// A rig that holds 4 A at an angle.
static inline rig_t holding(void) {
    rig_t rig = fresh();
    rig.blocked = true;
    rig_command(&rig, (lode_command_t){.mode = LODE_MODE_CURRENT, .vector = {4.0f, 0.0f}});
    rig_run(&rig, 0.1);
    TEST_ASSERT_TRUE(rig.out.gates);
    return rig;
}

/// Steps in RUN with an estimate of the host's own until the gates go off; how many it took.
static inline int steps_until_off(rig_t *rig, float lock, float omega_share, int limit) {
    for (int n = 1; n <= limit; n++) {
        const lode_counts_t counts = rig_counts(rig);
        const lode_sample_t m = lode_drive_sense(&rig->drive, &counts);
        lode_estimate_t e = lode_drive_estimate(&rig->drive, &m);
        e.source = LODE_ESTIMATE_EXTERNAL;
        e.lock = lock;
        // The drive keeps the speed that it is given: a negative share is not to turn it back in the next period.
        e.omega_rad_s = omega_share < 0.0f ? omega_share * lode_abs(e.omega_rad_s)
                                           : omega_share * e.omega_rad_s;
        rig->out = lode_drive_act(&rig->drive, &m, &e);
        if (!rig->out.gates) {
            return n;
        }
        rig_move(rig);
    }
    return limit + 1;
}

#endif
