#include "config/trial_scenario.h"

#include <math.h>
#include <string.h>

#include "config/load_step.h"
#include "config/speed_limits.h"
#include "support/units.h"

#define SETTLE_s                                                                                   \
    1.0 // for the speed to settle after its ramp, and for the evaluation window; at least
// The same in time constants of speed control, whose double pole lies at half its bandwidth, and the window.
#define SETTLE_CONSTANTS 12.0
// After a load step at full speed: the slow pole lies at a quarter of the bandwidth or above (K8); six time constants.
#define LOADED_CONSTANTS 24.0
#define WINDOW_s 0.4
#define BASE_SHARE 0.9 // of the base speed: room for a load step
#define LOAD_SHARE 0.5 // of the torque at i_max
// Largest electrical acceleration by a load step, over sigma^2: about 10 degrees of error.
#define STEP_SHARE 0.5
#define HANDOVER_FACTOR 2.0 // clear of the hand-over
#define RAMP_RESERVE 2.0    // a load and the current limit make ramps longer
#define ROUNDING 1.0e-3     // of a printed load
#define START_SHARE_s 0.5   // of the start's time-out, which allows for three attempts
#define BEFORE_RAMP_s 1.0   // of a start that needs one attempt
#define NEAR_RATED 0.99

static void add(rig_config_t *config, const char *name, double duration_s, double speed_rpm,
                double load_Nm) {
    rig_phase_t *phase = &config->scenario.phase[config->scenario.phases++];
    (void)snprintf(phase->name, sizeof phase->name, "%s", name);
    phase->duration_s = duration_s;
    phase->speed_rpm = speed_rpm;
    phase->load_Nm = load_Nm;
}

/// The largest load step (K18); NaN for a drive that the library refuses.
static double step_Nm(const lode_drive_config_t *drive, double omega_rad_s) {
    lode_drive_tuning_t tuning;
    return lode_drive_tune(&tuning, drive) == LODE_OK
               ? load_step_largest(drive, &tuning.speed, omega_rad_s).torque_Nm
               : NAN;
}

static double most_Nm(const lode_drive_config_t *drive) {
    return (double)lode_motor_kt_Nm_A(&drive->motor) * (double)drive->inverter.i_max_A;
}

/// Until the speed has settled; `constants`: that time by the bandwidth of speed control.
static double settle_s(const lode_drive_config_t *drive, double constants) {
    const double bandwidth = (double)drive->speed.kp_Nms / (double)drive->motor.J_kgm2;
    return fmax(SETTLE_s, constants / bandwidth + WINDOW_s);
}

/// From the vector's full speed to rest, or the other way.
static double turning_s(const lode_drive_config_t *drive) {
    return RAMP_RESERVE * (double)drive->start.omega_handover_rad_s /
           (double)drive->start.ramp_rad_s2;
}

static void add_start(rig_config_t *config, double speed_rpm) {
    const lode_drive_config_t *drive = &config->drive;
    const double settle = settle_s(drive, SETTLE_CONSTANTS);
    add(config, "start", settle + START_SHARE_s * (double)drive->start.timeout_s, speed_rpm, 0.0);
    config->scenario.phase[0].settled_s = settle;
    config->scenario.phase[0].about_s = settle + BEFORE_RAMP_s + turning_s(drive);
}

bool trial_scenario(rig_config_t *config) {
    const lode_drive_config_t *drive = &config->drive;
    const double np = (double)drive->motor.pole_pairs;
    const speed_limits_t limits = speed_limits_of(drive);
    const double ramp_rpm_s = rig_rpm_from_rad_s((double)drive->speed.ramp_rad_s2);
    const double commanded = rig_rpm_from_rad_s(fmin((double)drive->motor.omega_rated_rad_s,
                                                     BASE_SHARE * limits.base_rad_s)) /
                             np;
    const double most = rig_rpm_from_rad_s(TRIAL_ESTIMATOR_SHARE * limits.estimator_rad_s) / np;
    const double full = fmin(commanded, most);
    if (!(full > 0.0)) {
        return false;
    }
    const double handover = rig_rpm_from_rad_s((double)drive->start.omega_handover_rad_s) / np;
    const double slow = fmin(HANDOVER_FACTOR * handover, full);
    const double sigma = (double)drive->estimator.pll.sigma_rad_s;
    const double followed_Nm = STEP_SHARE * sigma * sigma * (double)drive->motor.J_kgm2 / np;
    const double load_Nm = fmin(fmin(LOAD_SHARE * most_Nm(drive), followed_Nm),
                                step_Nm(drive, np * rig_rad_s_from_rpm(full)));
    const double settle = settle_s(drive, SETTLE_CONSTANTS);
    const double rise_s = settle + RAMP_RESERVE * full / ramp_rpm_s;
    add_start(config, slow);
    if (slow < 0.5 * full) {
        add(config, "half_speed", rise_s, 0.5 * full, 0.0);
    }
    add(config, "full_speed", rise_s, full, 0.0);
    config->scenario.phase[config->scenario.phases - 1].commanded_rpm =
        commanded > most ? commanded : 0.0;
    const double loaded_s = settle_s(drive, LOADED_CONSTANTS);
    add(config, "load", loaded_s, full, load_Nm);
    add(config, "no_load", loaded_s, full, 0.0);
    add(config, "stop", rise_s + turning_s(drive), 0.0, 0.0);
    return true;
}

void trial_scenario_keep_start(rig_config_t *config, double duration_s) {
    rig_phase_t *start = &config->scenario.phase[0];
    start->settled_s =
        start->duration_s > duration_s || start->duration_s < duration_s ? 0.0 : start->settled_s;
}

static const rig_phase_t *find(const rig_config_t *config, const char *name) {
    const rig_phase_t *found = NULL;
    for (int k = 0; k < config->scenario.phases; ++k) {
        if (strcmp(config->scenario.phase[k].name, name) == 0) {
            found = &config->scenario.phase[k];
        }
    }
    return found;
}

/// A full speed that the voltage keeps below rated speed.
static void print_full_speed(FILE *file, const rig_config_t *config) {
    const lode_drive_config_t *drive = &config->drive;
    const double np = (double)drive->motor.pole_pairs;
    const double rated_rpm = rig_rpm_from_rad_s((double)drive->motor.omega_rated_rad_s) / np;
    const double base_rpm = rig_rpm_from_rad_s(speed_limits_of(drive).base_rad_s) / np;
    const rig_phase_t *full = find(config, "full_speed");
    const bool by_voltage =
        full != NULL && fabs(full->speed_rpm / (BASE_SHARE * base_rpm) - 1.0) < ROUNDING;
    if (by_voltage && full->speed_rpm < NEAR_RATED * rated_rpm) {
        (void)fprintf(file,
                      "full speed of the trial: %.0f of the rated %.0f rpm: bus voltage; it is %g "
                      "of the base speed of %.0f rpm\n",
                      full->speed_rpm, rated_rpm, BASE_SHARE, base_rpm);
    }
}

void trial_scenario_print(FILE *file, const rig_config_t *config) {
    const lode_drive_config_t *drive = &config->drive;
    const rig_phase_t *load = find(config, "load");
    print_full_speed(file, config);
    if (load == NULL) {
        return;
    }
    const double omega = (double)drive->motor.pole_pairs * rig_rad_s_from_rpm(load->speed_rpm);
    const double step = step_Nm(drive, fabs(omega));
    const double share = fabs(load->load_Nm) / step;
    (void)fprintf(file, "load of the trial: %.3g Nm, %.0f %% of the torque at i_max", load->load_Nm,
                  100.0 * load->load_Nm / most_Nm(drive));
    if (share > 1.0 + ROUNDING) {
        (void)fprintf(file,
                      "; %.3g times the largest load step of %.3g Nm at %.0f rpm (see `design`)\n",
                      share, step, load->speed_rpm);
    } else if (share > 1.0 - ROUNDING) {
        (void)fprintf(file, ": the largest load step at %.0f rpm (see `design`)\n",
                      load->speed_rpm);
    } else {
        (void)fprintf(file, "; the largest load step is %.3g Nm at %.0f rpm (see `design`)\n", step,
                      load->speed_rpm);
    }
}
