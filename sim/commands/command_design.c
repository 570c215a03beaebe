#include "commands/command_design.h"

#include <math.h>
#include <stdio.h>

#include "config/data_files.h"
#include "config/ini_config.h"
#include "config/refusal.h"
#include "config/schema.h"
#include "design/design.h"
#include "design/tuning_source.h"
#include "report/report_design.h"
#include "support/atomic_file.h"
#include "support/diag.h"
#include "support/outputs.h"
#include "support/units.h"

// Where no drive is given: a common switching frequency, a bus and a current that suit the motor.
#define ASSUMED_F_PWM_Hz 10000.0f
#define ASSUMED_RATED_rpm 1500.0
#define CURRENT_SHARE 0.3 // of the current whose field equals the magnets'
#define VOLTAGE_RESERVE 1.25

static bool load(rig_config_t *config, const options_t *options) {
    rig_config_init(config);
    bool good = data_files_load_part(config, "motors", options->motor) &&
                data_files_load_part(config, "drives", options->drive);
    for (int k = 0; good && k < options->sets; ++k) {
        good = ini_config_set(config, "--set", options->set[k]);
    }
    return good;
}

/// A motor alone says nothing of the drive: something plausible, and a word about it.
static void assume_drive(rig_config_t *config) {
    lode_drive_config_t *drive = &config->drive;
    const lode_motor_t *motor = &drive->motor;
    if (!(drive->f_pwm_Hz > 0.0f)) {
        drive->f_pwm_Hz = ASSUMED_F_PWM_Hz;
        (void)fprintf(stderr, "assumed: [drive] f_pwm_Hz = %g\n", (double)drive->f_pwm_Hz);
    }
    if (!(drive->inverter.i_max_A > 0.0f)) {
        drive->inverter.i_max_A =
            (float)(CURRENT_SHARE * (double)motor->psi_Wb / (double)motor->Ld_H);
        (void)fprintf(stderr, "assumed: [drive] i_max_A = %.4g (0.3 psi/Ld)\n",
                      (double)drive->inverter.i_max_A);
    }
    if (!(drive->inverter.v_bus_V > 0.0f)) {
        const double rpm = isnan(config->people.speed_rated_rpm) ? ASSUMED_RATED_rpm
                                                                 : config->people.speed_rated_rpm;
        const double omega = rig_rad_s_from_rpm(rpm) * (double)motor->pole_pairs;
        const double flux = hypot((double)motor->psi_Wb,
                                  0.5 * (double)motor->Lq_H * (double)drive->inverter.i_max_A);
        drive->inverter.v_bus_V = (float)(VOLTAGE_RESERVE * sqrt(3.0) * omega * flux);
        (void)fprintf(stderr, "assumed: [drive] v_bus_V = %.4g (enough for %g rpm)\n",
                      (double)drive->inverter.v_bus_V, rpm);
    }
}

/// Says where the two sets stand that the C constant is not for.
static void refuse_six(const rig_config_t *config, const char *source) {
    const int row = rig_schema_find(rig_schema(), "motor", "sets");
    const rig_origin_t *origin = &config->origin[row];
    rig_error_at(origin->file >= 0 ? config->file[origin->file] : "--set",
                 origin->file >= 0 ? origin->line : 0,
                 "[motor] sets: --c %s: expected a drive for three phases; one for six is designed "
                 "on the target, by lode_drive6_init()",
                 source);
}

/// The C constant that was asked for, if one was. The configuration is one that passes.
static bool print_source(const options_t *options, const rig_config_t *config) {
    if (options->source == NULL) {
        return true;
    }
    if (rig_config_is_six(config)) {
        refuse_six(config, options->source);
        return false;
    }
    char name[RIG_NAME_LENGTH * 2];
    char from[RIG_PATH_LENGTH * 2];
    FILE *file = NULL;
    lode_drive_tuning_t tuning;
    (void)snprintf(
        from, sizeof from, "%s%s%s%s", options->motor, options->drive != NULL ? " and " : "",
        options->drive != NULL ? options->drive : "", options->sets > 0 ? ", --set" : "");
    if (!tuning_source_name(name, sizeof name, options->source) ||
        !outputs_open(&file, options->source)) {
        return false;
    }
    (void)lode_drive_tune(&tuning, &config->drive);
    tuning_source_print(file, name, &tuning, from);
    return true;
}

rig_exit_t command_design(const options_t *options) {
    rig_config_t config;
    design_t design;
    FILE *json = NULL;
    if (!load(&config, options) || !outputs_open(&json, options->json)) {
        return RIG_BAD_INPUT;
    }
    if (options->source == NULL) {
        assume_drive(&config);
    }
    if (!rig_config_complete(&config, options->source == NULL ? RIG_NEED_MOTOR : RIG_NEED_BOARD)) {
        return RIG_BAD_INPUT;
    }
    lode_drive_design(&config.drive);
    const lode_status_t status = design_compute(&design, &config);
    if (status != LODE_OK) {
        refusal_report(&config, status);
        return RIG_BAD_INPUT;
    }
    if (!print_source(options, &config)) {
        return RIG_BAD_INPUT;
    }
    if (options->json_on_stdout) {
        report_design_json(stdout, &config, &design);
    } else {
        report_design_text(stdout, &config, &design);
    }
    if (json != NULL) {
        report_design_json(json, &config, &design);
    }
    if (!atomic_file_commit_all()) {
        return RIG_BAD_INPUT;
    }
    if (!options->json_on_stdout) {
        outputs_say(options->json);
        outputs_say(options->source);
    }
    return RIG_DONE;
}
