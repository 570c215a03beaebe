#include "commands/command_replay.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "commands/command_load.h"
#include "config/conversions.h"
#include "config/ini_config.h"
#include "config/refusal.h"
#include "config/schema.h"
#include "report/plot_replay.h"
#include "report/report_replay.h"
#include "rig/euler_estimate.h"
#include "rig/recording_load.h"
#include "rig/replay.h"
#include "support/atomic_file.h"
#include "support/outputs.h"
#include "support/shown.h"

#define F_PWM_MIN_Hz 1.0e3
#define F_PWM_MAX_Hz 2.0e5
// The library scales its bandwidths with the rated speed, which it derives from the bus voltage. A short
// recording at low speed does not show that voltage: this is the lowest rated speed assumed, electrical.
#define LEAST_RATED_rad_s 400.0

typedef struct {
    FILE *out;
    FILE *json;
    plot_output_t plot;
} files_t;

static bool set_choice(rig_config_t *config, const char *option, const char *key,
                       const char *value) {
    char text[RIG_NAME_LENGTH + 64];
    if (value == NULL) {
        return true;
    }
    (void)snprintf(text, sizeof text, "estimator.%s=%.40s", key, value);
    return ini_config_set(config, option, text);
}

static bool load(rig_config_t *config, const options_t *options) {
    return command_load_drive(config, options->motor, options->drive, options) &&
           set_choice(config, "--emf", "emf", options->emf) &&
           set_choice(config, "--pll", "pll", options->pll) &&
           conversions_apply(config); // a recorded mechanical speed needs the pole pairs
}

/// Marks a key as taken from the recording. It keeps its place in the list of files.
static bool note_origin(rig_config_t *config, const char *recording, const char *key) {
    if (config->files == RIG_FILES_MAX || strlen(recording) >= RIG_PATH_LENGTH) {
        return false;
    }
    const bool listed =
        config->files > 0 && strcmp(config->file[config->files - 1], recording) == 0;
    if (!listed) {
        (void)snprintf(config->file[config->files++], RIG_PATH_LENGTH, "%s", recording);
    }
    const int row = rig_schema_find(rig_schema(), "drive", key);
    config->origin[row] = (rig_origin_t){.file = config->files - 1, .line = 0};
    return true;
}

static double largest(const recording_t *recording, bool voltage) {
    double most = 0.0;
    for (size_t k = 0; k < recording->rows; ++k) {
        const recording_row_t *row = &recording->row[k];
        const double length =
            voltage ? hypot(row->u_alpha_V, row->u_beta_V) : hypot(row->i_alpha_A, row->i_beta_A);
        most = fmax(most, length);
    }
    return most;
}

/// Values that a file with only [motor] does not give are taken from the recording.
static bool fill_in(rig_config_t *config, const char *path, const recording_t *recording) {
    lode_inverter_config_t *inverter = &config->drive.inverter;
    const double f_Hz = 1.0 / recording->ts_s;
    if (!(f_Hz >= F_PWM_MIN_Hz && f_Hz <= F_PWM_MAX_Hz)) {
        rig_error_at(path, 0,
                     "t_s: steps of %.6g s; expected 5 us .. 1 ms, one row per PWM period. Slower "
                     "rows cannot be resampled: record every period (ring and scope: decimation 1; "
                     "run: scenario.log_s = one period). Faster rows can be, with --resample and "
                     "f_pwm_Hz of the drive",
                     recording->ts_s);
        return false;
    }
    config->drive.f_pwm_Hz = (float)f_Hz;
    bool good = note_origin(config, path, "f_pwm_Hz");
    if (!(inverter->v_bus_V > 0.0f)) {
        inverter->v_bus_V = (float)(sqrt(3.0) * largest(recording, true));
        good = note_origin(config, path, "v_bus_V") && good;
    }
    if (!(inverter->i_max_A > 0.0f)) {
        inverter->i_max_A = (float)fmax(largest(recording, false), 1e-3);
        good = note_origin(config, path, "i_max_A") && good;
    }
    return good;
}

static void assume_rated_speed(rig_config_t *config) {
    lode_drive_config_t trial = config->drive;
    lode_drive_design(&trial);
    if (trial.motor.omega_rated_rad_s < (float)LEAST_RATED_rad_s &&
        isnan(config->people.speed_rated_rpm)) {
        config->drive.motor.omega_rated_rad_s = (float)LEAST_RATED_rad_s;
    }
}

static bool prepare(rig_config_t *config, const char *path, const recording_t *recording,
                    lode_estimator_tuning_t *tuning) {
    if (!fill_in(config, path, recording) || !rig_config_complete(config, RIG_NEED_MOTOR)) {
        return false;
    }
    assume_rated_speed(config);
    lode_drive_design(&config->drive);
    lode_motor_t circuit = config->drive.motor; // as in lode_drive_tune()
    circuit.Rs_Ohm += config->drive.inverter.r_on_Ohm;
    const lode_status_t status = lode_estimator_tune(tuning, &config->drive.estimator, &circuit,
                                                     1.0f / config->drive.f_pwm_Hz);
    if (status != LODE_OK) {
        refusal_report(config, status);
    }
    return status == LODE_OK;
}

static bool write_files(const files_t *files, const rig_config_t *config, const char *path,
                        const recording_t *recording, const replay_t *replay) {
    if (files->out != NULL) {
        report_replay_csv(files->out, recording, replay);
    }
    if (files->json != NULL) {
        report_replay_json(files->json, config, path, recording, replay);
    }
    const char *slash = strrchr(path, '/');
    const char *title = slash != NULL ? slash + 1 : path;
    return files->plot.file == NULL || plot_replay(&files->plot, title, config, recording, replay);
}

static rig_exit_t replay_recording(const options_t *options, rig_config_t *config,
                                   const recording_t *recording) {
    lode_estimator_tuning_t tuning;
    replay_t replay;
    euler_config_t euler;
    files_t files = {.out = NULL};
    if (!prepare(config, options->recording, recording, &tuning) ||
        !outputs_open(&files.out, options->out) || !outputs_open(&files.json, options->json) ||
        !plot_open(&files.plot, options->plot)) {
        return RIG_BAD_INPUT;
    }
    const bool wanted = euler_estimate_wanted(config);
    if (wanted) {
        euler = euler_estimate_config(config);
    }
    if (!replay_run(&replay, recording, &tuning, wanted ? &euler : NULL)) {
        return RIG_BAD_INPUT;
    }
    shown_t table;
    bool good = shown_begin(&table);
    if (good) {
        report_replay_values(table.file, config);
        report_replay_table(table.file, config, recording, &replay);
        good = shown_end(&table);
        files.plot.text = table.text;
        good = good && write_files(&files, config, options->recording, recording, &replay);
    }
    shown_free(&table);
    replay_free(&replay);
    if (!good || !atomic_file_commit_all()) {
        return RIG_BAD_INPUT;
    }
    outputs_say(options->out);
    outputs_say(options->json);
    outputs_say(options->plot);
    return RIG_DONE;
}

static recording_format_t format_of(const options_t *options, const rig_config_t *config) {
    return (recording_format_t){
        .map = options->column,
        .maps = options->columns,
        .separator = options->separator,
        .header = options->header,
        .data = options->data,
        .resample = options->resample,
        .f_pwm_Hz = (double)config->drive.f_pwm_Hz,
        .pole_pairs = (double)config->drive.motor.pole_pairs,
    };
}

rig_exit_t command_replay(const options_t *options) {
    rig_config_t config;
    recording_t recording;
    if ((options->plot != NULL && !plot_available()) || !load(&config, options)) {
        return RIG_BAD_INPUT;
    }
    const recording_format_t format = format_of(options, &config);
    if (!recording_load(&recording, options->recording, &format)) {
        return RIG_BAD_INPUT;
    }
    const rig_exit_t code = replay_recording(options, &config, &recording);
    recording_free(&recording);
    return code;
}
