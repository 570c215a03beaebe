#include "commands/command_load.h"

#include <math.h>
#include <string.h>

#include "config/data_files.h"
#include "config/ini_config.h"
#include "config/refusal.h"
#include "config/trial_scenario.h"
#include "support/diag.h"

static bool is_of_phase(const char *set) {
    return strncmp(set, "phase.", strlen("phase.")) == 0;
}

/// Applies each --set of a phase, or each other one.
static bool take_sets(rig_config_t *config, const options_t *options, bool of_phase) {
    bool good = true;
    for (int k = 0; good && k < options->sets; ++k) {
        good = is_of_phase(options->set[k]) != of_phase ||
               ini_config_set(config, "--set", options->set[k]);
    }
    return good;
}

bool command_load_sets(rig_config_t *config, const options_t *options) {
    return take_sets(config, options, false) && take_sets(config, options, true);
}

static bool load_parts(rig_config_t *config, const char *motor, const char *drive) {
    rig_config_init(config);
    return data_files_load_part(config, "motors", motor) &&
           data_files_load_part(config, "drives", drive);
}

bool command_load_drive(rig_config_t *config, const char *motor, const char *drive,
                        const options_t *options) {
    return load_parts(config, motor, drive) && command_load_sets(config, options);
}

static void report_no_speed(const rig_config_t *config, const char *motor) {
    const lode_inverter_config_t *inverter = &config->drive.inverter;
    const lode_status_t status = rig_config_judge(config);
    if (status != LODE_OK) {
        refusal_report(config, status);
        return;
    }
    rig_error("%s: no speed to run at: with i_max, %.3g A, Rs and r_on take all of the phase "
              "voltage of %.3g V; "
              "`design` with the same arguments tells more",
              motor, (double)inverter->i_max_A, (double)inverter->v_bus_V / sqrt(3.0));
}

/// A motor without a scenario uses the drive in its own file or an assumed one, as in `design`. The phases are
/// made last, because they depend on all other values.
static bool load_motor(rig_config_t *config, const options_t *options) {
    if (!load_parts(config, options->motor, options->drive) || !take_sets(config, options, false) ||
        !rig_config_complete(config, options->drive == NULL ? RIG_NEED_MOTOR : RIG_NEED_DRIVE)) {
        return false;
    }
    rig_config_design(config);
    if (!trial_scenario(config)) {
        report_no_speed(config, options->motor);
        return false;
    }
    const double start_s = config->scenario.phase[0].duration_s;
    const bool good = take_sets(config, options, true);
    trial_scenario_keep_start(config, start_s);
    return good;
}

static bool load_scenario(rig_config_t *config, const options_t *options, const char *scenario) {
    char path[RIG_PATH_LENGTH];
    rig_config_init(config);
    if (!data_files_find("scenarios", scenario, path, sizeof path) ||
        !ini_config_load_scenario(config, path) || !command_load_sets(config, options) ||
        !rig_config_complete(config, RIG_NEED_DRIVE)) {
        return false;
    }
    rig_config_design(config);
    return true;
}

bool command_load_run(rig_config_t *config, const options_t *options, const char *scenario) {
    const bool good =
        scenario != NULL ? load_scenario(config, options, scenario) : load_motor(config, options);
    if (good && (options->has_seed || options->has_campaign)) {
        config->scenario.seed = (double)options->seed;
    }
    return good;
}
