#include "commands/command_run.h"

#include <stdio.h>
#include <string.h>

#include "commands/campaign.h"
#include "commands/command_load.h"
#include "config/assumptions.h"
#include "config/ini_config.h"
#include "config/plausible.h"
#include "config/trial_scenario.h"
#include "report/plot_run.h"
#include "report/report_run.h"
#include "rig/capture.h"
#include "rig/runner.h"
#include "support/atomic_file.h"
#include "support/outputs.h"
#include "support/shown.h"

#define MAIN_FOLDER "lodestar-out"

typedef struct {
    FILE *csv;
    FILE *json;
    plot_output_t plot;
} files_t;

static bool open_files(files_t *files, const options_t *options) {
    return outputs_open(&files->csv, options->csv) && outputs_open(&files->json, options->json) &&
           plot_open(&files->plot, options->plot);
}

/// Title of a scenario or a motor: its first comment line, or its name without one.
static void title_of(const char *path, char *title, size_t size) {
    const char *slash = strrchr(path, '/');
    ini_config_title(path, title, size);
    if (title[0] == '\0') {
        (void)snprintf(title, size, "%s", slash != NULL ? slash + 1 : path);
    }
}

/// False after a message.
static bool write_files(const files_t *files, const rig_config_t *config,
                        const runner_result_t *result, const runlog_t *log) {
    if (files->csv != NULL) {
        report_run_csv(files->csv, log);
    }
    if (files->json != NULL) {
        report_run_json(files->json, config, result, log);
    }
    char title[RIG_PATH_LENGTH];
    title_of(config->file[0], title, sizeof title);
    return files->plot.file == NULL || plot_run(&files->plot, title, result, log);
}

static rig_exit_t run_once(const options_t *options, const char *scenario) {
    rig_config_t config;
    runner_result_t result;
    runlog_t log;
    files_t files = {.csv = NULL};
    static capture_t capture;
    if (!command_load_run(&config, options, scenario) || !open_files(&files, options) ||
        (capture_wanted(options) && !capture_start(&capture, options, config.drive.f_pwm_Hz))) {
        return RIG_BAD_INPUT;
    }
    runlog_init(&log);
    log.capture = capture_wanted(options) ? &capture : NULL;
    bool good = runner_run(&config, runner_estimator(&config), &result, &log);
    shown_t table = {.file = NULL};
    good = good && shown_begin(&table);
    if (good) {
        if (scenario == NULL) {
            const plausible_t plausible = plausible_of(&config.drive);
            assumptions_print(table.file, &config, "");
            (void)plausible_print_doubts(table.file, &plausible);
            trial_scenario_print(table.file, &config);
        }
        report_run_table(table.file, &config, &result, &log);
        good = shown_end(&table);
        files.plot.text = table.text;
        good = good && write_files(&files, &config, &result, &log);
    }
    shown_free(&table);
    if (log.capture != NULL) {
        capture_finish(&capture);
    }
    runlog_free(&log);
    if (!good || !atomic_file_commit_all()) {
        return RIG_BAD_INPUT;
    }
    outputs_say(options->csv);
    outputs_say(options->json);
    outputs_say(options->plot);
    outputs_say(options->ring);
    outputs_say(options->scope);
    return report_run_failed(&result) ? RIG_FAILED : RIG_DONE;
}

rig_exit_t command_run(const options_t *options) {
    if (options->plot != NULL && !plot_available()) {
        return RIG_BAD_INPUT;
    }
    return options->has_campaign ? campaign(options) : run_once(options, options->scenario);
}

rig_exit_t command_main_job(const options_t *options) {
    options_t all = *options;
    const bool asked = options->plot != NULL;
    const bool needs_folder =
        options->csv == NULL || options->json == NULL || options->plot == NULL;
    if (needs_folder && !outputs_folder(MAIN_FOLDER)) {
        return RIG_BAD_INPUT;
    }
    all.csv = options->csv != NULL ? options->csv : MAIN_FOLDER "/main.csv";
    all.json = options->json != NULL ? options->json : MAIN_FOLDER "/main.json";
    all.plot = asked ? options->plot : MAIN_FOLDER "/main.svg";
    if (!plot_available()) {
        if (asked) {
            return RIG_BAD_INPUT;
        }
        all.plot = NULL;
    }
    return run_once(&all, "main");
}
