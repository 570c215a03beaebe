#include "montecarlo/trial.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "rig/rig.h"
#include "rig/runner.h"
#include "support/units.h"

// Limits that define a pass. Do not change them.
#define SPEED_SHARE 0.05 // a speed within this share of the command is reached
#define HOLD_s 0.1       // for this time without interruption
// Averaging time of the speed; a turn of the shaft if the load pulsates within a turn.
#define MEAN_s 0.01
#define REVERSE_MAX_deg 200.0 // electrical, against the command, at the start
// Share of HOLD_s with the torque at its limit that explains a speed not reached.
#define LIMITED_SHARE 0.1
#define NOTICE_s 0.1 // a fault must follow an unusable angle within this time
#define SETTLE_s 2.0
#define SETTLE_PER_BANDWIDTH 20.0 // of speed control
#define TORQUE_RESERVE 6.0        // factor on the time with i_max and no load
#define RIPPLE_SHARE 0.1          // of 100 % torque: the reference at a steady load
#define RIPPLE_LOAD_SHARE 0.2
#define RIPPLE_s 0.3
#define QUIET_PERIODS 20000   // periods with the same speed and load
#define TELEMETRY_PERIODS 16u // periods from one reading of telemetry to the next
#define GLIDE_STEPS 100       // steps of a gradual change
#define CATCH_s 0.05          // a rotor that turns already is caught within this time ...
#define CATCH_TURNS 2.0       // ... or so many electrical turns, whichever is longer
#define FOUND_s 0.05          // an open phase is found within this time ...
#define FOUND_TURNS 1.2       // ... or this number of electrical turns, whichever is longer
#define LOOKED_s 1.0          // observation time for a late fault
#define ALONE_s 0.5           // a set that goes on alone has to drive on for this long ...
#define ALONE_LOAD_SHARE 0.4  // ... with up to this load: it has half of the torque
#define KICK_s 5.0e-3         // time after the catch in which the peak current still counts
#define LISTED_s 0.01
#define LISTED_SHARE 0.5

typedef struct {
    const mc_machine_t *machine;
    const mc_case_t *one;
    mc_result_t *result;
    rig_t rig;
    runner_estimator_t estimate;
    runner_memory_t memory;
    rig_moment_t now;
    double ts_s;
    double command_m_rad_s;
    double mean_m_rad_s;            ///< of the true speed
    double turned_m_rad, turning_s; ///< of the present turn
    double travelled_rad;           ///< electrical, in the commanded direction, since the start
    double lowest_rad;
    double limited;   ///< share of the last HOLD_s with the torque at its limit, from telemetry
    bool raised;      ///< the commanded speed is below the least speed, from telemetry
    double useless_s; ///< time since the angle became unusable; below 0: it is usable
    bool ran;
    const char *what; ///< the present part of the trial
} trial_t;

static void fail(trial_t *trial, bool noticed, const char *cause) {
    mc_result_t *result = trial->result;
    result->passed = false;
    result->noticed = noticed;
    (void)snprintf(result->cause, sizeof result->cause, "%s, %s", cause, trial->what);
}

static lode_mode_t mode_of(const trial_t *trial) {
    return (lode_mode_t)trial->rig.drive->mode;
}

static void fail_by_fault(trial_t *trial) {
    const lode_fault_t *fault = &trial->rig.drive->guard.fault;
    char cause[64];
    (void)snprintf(cause, sizeof cause, "%s in %s",
                   lode_check_name((lode_check_t)fault->check) + strlen("LODE_CHECK_"),
                   lode_mode_name((lode_mode_t)fault->state) + strlen("LODE_MODE_"));
    fail(trial, true, cause);
}

/// The low-passed speed, or its mean over the last whole turn.
static void follow_speed(trial_t *trial, double turned_e_rad) {
    const double np = trial->machine->np;
    trial->turned_m_rad += turned_e_rad / np;
    trial->turning_s += trial->ts_s;
    if (!(trial->one->plant.load_ripple > 0.0)) {
        trial->mean_m_rad_s += fmin(trial->ts_s / MEAN_s, 1.0) *
                               (trial->now.truth.omega_m_rad_s - trial->mean_m_rad_s);
    } else if (fabs(trial->turned_m_rad) >= 2.0 * RIG_PI) {
        trial->mean_m_rad_s = trial->turned_m_rad / trial->turning_s;
        trial->turned_m_rad = 0.0;
        trial->turning_s = 0.0;
    }
}

static void follow_angle(trial_t *trial, double turned_e_rad) {
    trial->travelled_rad += trial->one->direction * turned_e_rad;
    trial->lowest_rad = fmin(trial->lowest_rad, trial->travelled_rad);
}

/// False if an unusable angle has gone unnoticed. `ran`: the period's estimate was that of RUN.
static bool follow_error(trial_t *trial, bool ran) {
    if (!ran || mode_of(trial) != LODE_MODE_RUN) {
        trial->useless_s = -1.0;
        return true;
    }
    trial->result->periods++;
    const double error_deg = fabs(rig_angle_error_deg(
        (double)lode_estimate_theta_rad(&trial->now.estimate), trial->now.truth.theta_e_rad));
    trial->result->max_error_deg = fmax(trial->result->max_error_deg, error_deg);
    if (trial->useless_s >= 0.0) {
        trial->useless_s += trial->ts_s;
    } else if (error_deg > MC_ERROR_MAX_deg) {
        trial->useless_s = 0.0;
    }
    return trial->useless_s < NOTICE_s;
}

/// The reason for a speed not reached that telemetry gives to a user.
static void follow_telemetry(trial_t *trial) {
    lode_telemetry_t telemetry;
    if (trial->rig.drive->steps % TELEMETRY_PERIODS != 0u ||
        !lode_drive_telemetry(trial->rig.drive, &telemetry)) {
        return;
    }
    const double weight = fmin((double)TELEMETRY_PERIODS * trial->ts_s / HOLD_s, 1.0);
    trial->limited += weight * ((telemetry.torque_limited ? 1.0 : 0.0) - trial->limited);
    trial->raised = telemetry.speed_raised;
}

static void fail_by_speed(trial_t *trial) {
    if (mode_of(trial) != LODE_MODE_RUN) {
        fail(trial, false, "not in RUN");
    } else if (trial->raised) {
        fail(trial, true, MC_REPORTED "speed raised to the least");
    } else if (trial->limited >= LIMITED_SHARE) {
        fail(trial, true, MC_REPORTED "torque at its limit, speed not reached");
    } else {
        fail(trial, false, "speed not reached");
    }
}

/// One period. False: the trial has ended.
static bool step(trial_t *trial) {
    const double theta_before_rad = trial->now.truth.theta_e_rad;
    const bool ran = mode_of(trial) == LODE_MODE_RUN;
    rig_step(&trial->rig, trial->estimate, &trial->memory, &trial->now);
    const double turned_rad =
        remainder(trial->now.truth.theta_e_rad - theta_before_rad, 2.0 * RIG_PI);
    follow_speed(trial, turned_rad);
    follow_angle(trial, turned_rad);
    if (mode_of(trial) == LODE_MODE_FAULT) {
        fail_by_fault(trial);
        return false;
    }
    if (!follow_error(trial, ran)) {
        fail(trial, false, "angle lost without a fault");
        return false;
    }
    return true;
}

static bool wait(trial_t *trial, double time_s) {
    bool good = true;
    for (double left_s = time_s; good && left_s > 0.0; left_s -= trial->ts_s) {
        good = step(trial);
    }
    return good;
}

/// Waits until the speed is reached and held, in RUN.
static bool settle(trial_t *trial, double limit_s) {
    double held_s = 0.0;
    for (double left_s = limit_s; left_s > 0.0; left_s -= trial->ts_s) {
        if (!step(trial)) {
            return false;
        }
        follow_telemetry(trial);
        const double off = fabs(trial->mean_m_rad_s - trial->command_m_rad_s);
        const bool there = off <= SPEED_SHARE * fabs(trial->command_m_rad_s) &&
                           mode_of(trial) == LODE_MODE_RUN && trial->useless_s < 0.0;
        held_s = there ? held_s + trial->ts_s : 0.0;
        if (held_s >= HOLD_s) {
            return true;
        }
    }
    fail_by_speed(trial);
    return false;
}

static double settle_limit_s(const trial_t *trial, double change_m_rad_s) {
    const double bandwidth = (double)trial->one->config.drive.speed.bandwidth_rad_s;
    return SETTLE_s + SETTLE_PER_BANDWIDTH / bandwidth +
           TORQUE_RESERVE * trial->one->plant.J_kgm2 * fabs(change_m_rad_s) /
               trial->machine->torque_max_Nm;
}

static void command(trial_t *trial, double omega_e_rad_s) {
    trial->command_m_rad_s = omega_e_rad_s / trial->machine->np;
    const lode_command_t run = {.mode = LODE_MODE_RUN,
                                .speed_rad_s = (float)trial->command_m_rad_s};
    (void)lode_drive_post_command(trial->rig.drive, &run);
}

/// Runs to the electrical speed, in the case's direction.
static bool go(trial_t *trial, const char *what, double omega_e_rad_s) {
    const double before = trial->command_m_rad_s;
    const bool turns_back = before * trial->one->direction * omega_e_rad_s < 0.0;
    trial->what = what;
    command(trial, trial->one->direction * omega_e_rad_s);
    // A reversal goes through a start.
    const double start_s = turns_back ? (double)trial->one->config.drive.start.timeout_s : 0.0;
    return settle(trial, start_s + settle_limit_s(trial, trial->command_m_rad_s - before));
}

/// Without a response of the control, the step would halve the speed within 10 ms.
static bool is_listed(const trial_t *trial, double torque_Nm) {
    return fabs(torque_Nm) / trial->one->plant.J_kgm2 * LISTED_s >
           LISTED_SHARE * fabs(trial->command_m_rad_s);
}

/// A load against the commanded speed, and then none. 100 % is torque_Nm.
static bool load_step(trial_t *trial, const char *what, double share) {
    const double torque_Nm = share * trial->machine->torque_Nm;
    const double omega = trial->command_m_rad_s;
    if (is_listed(trial, torque_Nm)) {
        trial->result->listed++;
        return true;
    }
    trial->what = what;
    plant_set_load(&trial->rig.plant, copysign(torque_Nm, omega));
    if (!wait(trial, HOLD_s) || !settle(trial, settle_limit_s(trial, omega))) {
        return false;
    }
    plant_set_load(&trial->rig.plant, 0.0);
    return wait(trial, HOLD_s) && settle(trial, settle_limit_s(trial, omega));
}

static void load_passive(trial_t *trial, double share) {
    plant_set_passive(&trial->rig.plant, share > 0.0);
    plant_set_load(&trial->rig.plant, share * trial->machine->torque_Nm);
}

/// Changes from one passive load to another: in a step, or gradually if such a step is listed as too large.
static bool change_load(trial_t *trial, const char *what, double from, double to) {
    if (!is_listed(trial, (to - from) * trial->machine->torque_Nm)) {
        load_passive(trial, to);
        return true;
    }
    bool good = true;
    trial->what = what;
    trial->result->listed++;
    for (int k = 1; good && k <= GLIDE_STEPS; ++k) {
        load_passive(trial, from + (to - from) * (double)k / GLIDE_STEPS);
        good = wait(trial, settle_limit_s(trial, 0.0) / GLIDE_STEPS);
    }
    return good;
}

/// The torque reference at a steady load.
static bool is_calm(trial_t *trial) {
    float low = HUGE_VALF;
    float high = -HUGE_VALF;
    trial->what = "steady 20 % load";
    if (!wait(trial,
              SETTLE_PER_BANDWIDTH / (double)trial->one->config.drive.speed.bandwidth_rad_s)) {
        return false;
    }
    for (double left_s = RIPPLE_s; left_s > 0.0; left_s -= trial->ts_s) {
        if (!step(trial)) {
            return false;
        }
        if (mode_of(trial) != LODE_MODE_RUN) {
            fail(trial, false, "not in RUN");
            return false;
        }
        const float torque = trial->rig.drive->state.run.speed.torque_Nm;
        low = fminf(low, torque);
        high = fmaxf(high, torque);
    }
    // Speed control responds to a load that pulsates by itself.
    if (!(trial->one->plant.load_ripple > 0.0) &&
        (double)(high - low) > RIPPLE_SHARE * trial->machine->torque_Nm) {
        fail(trial, false, "torque reference swings");
        return false;
    }
    return true;
}

static bool start(trial_t *trial) {
    const lode_drive_config_t *config = &trial->one->config.drive;
    trial->what = "start";
    command(trial, trial->one->direction * trial->one->slow_e_rad_s);
    const double wait_s = (double)config->start.timeout_s + (double)config->sense.calibrate_s;
    // Up to a load of 0.8/1.5 of i_max, half of the torque is left.
    if (!settle(trial, wait_s + 2.0 * settle_limit_s(trial, trial->command_m_rad_s))) {
        return false;
    }
    if (rig_deg_from_rad(trial->lowest_rad) < -REVERSE_MAX_deg) {
        fail(trial, false, "turned backwards");
        return false;
    }
    return true;
}

static bool all_load_steps(trial_t *trial) {
    static const struct {
        double share; ///< of full speed; 0: the slow one
        const char *go, *half, *full;
    } speeds[] = {
        {0.0, "to 20 % speed", "load 50 % at 20 % speed", "load 100 % at 20 % speed"},
        {0.5, "to 50 % speed", "load 50 % at 50 % speed", "load 100 % at 50 % speed"},
        {0.9, "to 90 % speed", "load 50 % at 90 % speed", "load 100 % at 90 % speed"},
    };
    bool good = true;
    plant_set_passive(&trial->rig.plant, false);
    for (size_t k = 0; good && k < sizeof speeds / sizeof speeds[0]; ++k) {
        const double speed =
            fmax(speeds[k].share * trial->machine->full_e_rad_s, trial->one->slow_e_rad_s);
        good = go(trial, speeds[k].go, speed) && load_step(trial, speeds[k].half, 0.5) &&
               load_step(trial, speeds[k].full, 1.0);
    }
    return good;
}

static bool all_changes(trial_t *trial) {
    const double slow = trial->one->slow_e_rad_s;
    const double fast = fmax(0.9 * trial->machine->full_e_rad_s, slow);
    bool good = go(trial, "slam down", slow) && go(trial, "slam up", fast);
    good = good && change_load(trial, "50 % load", 0.0, 0.5) &&
           go(trial, "slam down, 50 % load", slow) && go(trial, "slam up, 50 % load", fast) &&
           change_load(trial, "down to 20 % load", 0.5, RIPPLE_LOAD_SHARE) &&
           go(trial, "20 % load", fmax(0.5 * trial->machine->full_e_rad_s, slow)) &&
           is_calm(trial) && change_load(trial, "no load", RIPPLE_LOAD_SHARE, 0.0);
    return good && go(trial, "before the reversal", slow) && go(trial, "reversal", -slow) &&
           change_load(trial, "50 % load", 0.0, 0.5) && go(trial, "reversal, 50 % load", slow);
}

// ---- A rotor that already turns ------------------------------------------------------------------

static bool is_turned(const trial_t *trial) {
    return mode_of(trial) == LODE_MODE_START &&
           trial->rig.drive->state.start.stage != (uint_least8_t)LODE_START_CATCH;
}

static bool calibrate(trial_t *trial) {
    static const lode_command_t calibration = {.mode = LODE_MODE_CALIBRATE};
    trial->what = "calibration";
    plant_set_speed(&trial->rig.plant, 0.0);
    (void)lode_drive_post_command(trial->rig.drive, &calibration);
    for (double left_s = 2.0 * (double)trial->one->config.drive.sense.calibrate_s;
         !lode_drive_knows(trial->rig.drive, LODE_KNOWN_OFFSETS) && left_s > 0.0;
         left_s -= trial->ts_s) {
        if (!step(trial)) {
            return false;
        }
    }
    return wait(trial, 4.0 * trial->ts_s);
}

/// From the command until the drive runs with a correct angle or starts with a current vector of its own.
/// False: it has failed.
static bool is_caught(trial_t *trial) {
    const double coast = fabs(trial->one->coast_e_rad_s);
    const double limit_s = fmax(CATCH_s, CATCH_TURNS * 2.0 * RIG_PI / fmax(coast, 1.0e-3));
    const bool fast = coast >= (double)trial->one->config.drive.start.omega_handover_rad_s;
    double time_s = 0.0;
    trial->what = "catch";
    plant_watch_peak(&trial->rig.plant);
    while (mode_of(trial) != LODE_MODE_RUN && !is_turned(trial)) {
        if (!step(trial)) {
            return false;
        }
        time_s += trial->ts_s;
    }
    if (fast && (is_turned(trial) || time_s > limit_s)) {
        fail(trial, false, is_turned(trial) ? "passed over" : "too late");
        return false;
    }
    if (mode_of(trial) == LODE_MODE_RUN && !wait(trial, KICK_s)) {
        return false;
    }
    if (plant_peak_A(&trial->rig.plant) > (double)trial->machine->given.drive.inverter.i_max_A) {
        fail(trial, false, "peak current above i_max");
        return false;
    }
    return true;
}

static bool fly(trial_t *trial) {
    const double coast = trial->one->coast_e_rad_s;
    const double np = trial->machine->np;
    if (fabs(coast) >= trial->machine->bus_e_rad_s) {
        trial->result->listed++;
        return true;
    }
    if (!calibrate(trial)) {
        return false;
    }
    plant_set_speed(&trial->rig.plant, coast / np);
    if (!wait(trial, 4.0 * trial->ts_s)) {
        return false;
    }
    plant_release_speed(&trial->rig.plant);
    const double speed =
        fmin(fmax(fabs(coast), trial->one->slow_e_rad_s), trial->machine->full_e_rad_s);
    command(trial, trial->one->direction * speed);
    if (!is_caught(trial)) {
        return false;
    }
    trial->what = "after the catch";
    return settle(trial, (double)trial->one->config.drive.start.timeout_s +
                             settle_limit_s(trial, 2.0 * trial->command_m_rad_s));
}

// ---- No reason to trip ------------------------------------------------------------------------

/// To a speed and a passive load, as a share of 100 %, in small steps that speed control follows.
static bool glide(trial_t *trial, double omega_e_rad_s, const double share[2]) {
    const double from = trial->command_m_rad_s * trial->machine->np;
    const double to = trial->one->direction * omega_e_rad_s;
    const double limit_s = settle_limit_s(trial, (to - from) / trial->machine->np);
    bool good = true;
    for (int k = 1; good && k <= GLIDE_STEPS; ++k) {
        const double part = (double)k / GLIDE_STEPS;
        command(trial, from + part * (to - from));
        load_passive(trial, share[0] + part * (share[1] - share[0]));
        good = wait(trial, limit_s / GLIDE_STEPS);
    }
    return good && settle(trial, limit_s);
}

static bool all_quiet(trial_t *trial) {
    static const double speeds[] = {0.0, 0.5, 0.9}; // of full speed; 0: the slow one
    static const double loads[] = {0.0, RIPPLE_LOAD_SHARE, 0.5};
    double share[2] = {0.0, 0.0};
    for (int n = 0; n < 9; ++n) {
        const double speed =
            fmax(speeds[n % 3] * trial->machine->full_e_rad_s, trial->one->slow_e_rad_s);
        share[1] = loads[n / 3];
        trial->what = share[1] > 0.0 ? "steady, with load" : "steady, without load";
        if (!glide(trial, speed, share) || !wait(trial, QUIET_PERIODS * trial->ts_s)) {
            return false;
        }
        share[0] = share[1];
    }
    return true;
}

// ---- A switch that stays off, a wire that breaks --------------------------------------------------

static void break_leg(plant_t *plant, const mc_break_t *breaks) {
    if (breaks->what == MC_BREAKS_WIRE) {
        plant_open_phase(plant, breaks->leg);
    } else {
        plant_fail_switch(plant, breaks->leg, breaks->what == MC_BREAKS_HIGH, false);
    }
}

/// A fault, or the other set goes on alone.
static bool tells_open(const trial_t *trial) {
    return mode_of(trial) == LODE_MODE_FAULT ||
           (trial->rig.sets == PLANT_SETS && trial->rig.six.open > 0u);
}

static bool is_found(trial_t *trial, double turn_s) {
    const double bar_s = fmax(FOUND_s, FOUND_TURNS * turn_s);
    mc_result_t *result = trial->result;
    for (double t_s = 0.0; t_s < fmax(LOOKED_s, bar_s) && isnan(result->found_s);
         t_s += trial->ts_s) {
        rig_step(&trial->rig, trial->estimate, &trial->memory, &trial->now);
        result->found_s = tells_open(trial) ? t_s + trial->ts_s : NAN;
    }
    if (isnan(result->found_s)) {
        fail(trial, false, "not found");
    } else if (result->found_s > bar_s) {
        fail(trial, true, "found late");
    }
    return result->found_s <= bar_s;
}

static bool open_phase(trial_t *trial) {
    static const char *const what[MC_BREAKS] = {"a dead high switch", "a dead low switch",
                                                "a broken wire"};
    const mc_break_t *breaks = &trial->one->breaks;
    const double turn_s = 2.0 * RIG_PI / breaks->omega_e_rad_s;
    const double share[2] = {0.0, breaks->load_share};
    trial->what = "before the phase breaks";
    if (!glide(trial, breaks->omega_e_rad_s, share) || !wait(trial, breaks->turn * turn_s)) {
        return false;
    }
    trial->what = what[breaks->what];
    break_leg(&trial->rig.plant, breaks);
    if (!is_found(trial, turn_s)) {
        return false;
    }
    trial->what = "on one set";
    const bool goes_on = mode_of(trial) != LODE_MODE_FAULT;
    return !goes_on || breaks->load_share > ALONE_LOAD_SHARE || wait(trial, ALONE_s);
}

static bool after_start(trial_t *trial, mc_test_t test) {
    switch (test) {
    case MC_RUN:
        return all_load_steps(trial) && all_changes(trial);
    case MC_QUIET:
        return all_quiet(trial);
    case MC_OPEN_PHASE:
        return open_phase(trial);
    case MC_FLY: // starts differently
    case MC_START:
    default:
        return true;
    }
}

void mc_trial(mc_result_t *result, const mc_machine_t *machine, const mc_case_t *one,
              mc_test_t test) {
    static trial_t trial; // large; one at a time
    *result = (mc_result_t){.passed = false, .max_error_deg = NAN, .found_s = NAN};
    memset(&trial, 0, sizeof trial);
    trial.machine = machine;
    trial.one = one;
    trial.result = result;
    trial.estimate = runner_estimator(&one->config);
    trial.ts_s = 1.0 / (double)one->config.drive.f_pwm_Hz;
    trial.useless_s = -1.0;
    trial.now.truth.theta_e_rad = one->plant.theta_e_rad;
    if (one->unfit != NULL) {
        trial.what = "commissioning";
        fail(&trial, true, one->unfit);
        return;
    }
    const lode_status_t status = rig_init(&trial.rig, &one->config, &one->plant);
    if (status != LODE_OK) {
        trial.what = "init";
        fail(&trial, true, lode_status_name(status));
        return;
    }
    plant_set_passive(&trial.rig.plant, true);
    plant_set_load(&trial.rig.plant, one->start_load_Nm);
    result->passed = test == MC_FLY ? fly(&trial) : start(&trial) && after_start(&trial, test);
}
