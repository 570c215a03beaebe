#include "commands/command_analyse.h"

#include <stdio.h>
#include <stdlib.h>

#include "analyse/analyse.h"
#include "commands/command_load.h"
#include "config/refusal.h"
#include "report/plot_bode.h"
#include "report/report_analyse.h"
#include "support/atomic_file.h"
#include "support/outputs.h"
#include "support/plot.h"
#include "support/shown.h"

#define PAPER "jiang2022"

typedef struct {
    FILE *csv;
    FILE *json;
    plot_output_t plot[PLOT_BODE_COUNT];
} files_t;

/// Without a motor and a drive, those of paper 1 are used. A given motor uses the drive in its own file or an
/// assumed one, never the paper's.
static bool load(rig_config_t *config, const options_t *options) {
    const bool own = options->motor != NULL && options->drive == NULL;
    const char *motor = options->motor != NULL ? options->motor : PAPER;
    const char *drive = options->drive != NULL || own ? options->drive : PAPER;
    if (!command_load_drive(config, motor, drive, options) ||
        !rig_config_complete(config, own ? RIG_NEED_MOTOR : RIG_NEED_DRIVE)) {
        return false;
    }
    rig_config_design(config);
    return true;
}

static void plot_path(char *path, const options_t *options, int k) {
    plot_path_in(path, RIG_PATH_LENGTH, options->plots, plot_bode_all[k].file, options->format);
}

static bool open_files(files_t *files, const options_t *options) {
    bool good =
        outputs_open(&files->csv, options->csv) && outputs_open(&files->json, options->json);
    if (!good || options->plots == NULL) {
        return good;
    }
    good = plot_available() && outputs_folder(options->plots);
    for (int k = 0; good && k < PLOT_BODE_COUNT; ++k) {
        char path[RIG_PATH_LENGTH];
        plot_path(path, options, k);
        good = plot_open(&files->plot[k], path);
    }
    return good;
}

static bool write_files(files_t *files, const rig_config_t *config, const analyse_t *analysis,
                        const char *text) {
    if (files->csv != NULL) {
        report_analyse_csv(files->csv, analysis);
    }
    if (files->json != NULL) {
        report_analyse_json(files->json, config, analysis);
    }
    bool good = true;
    for (int k = 0; good && k < PLOT_BODE_COUNT; ++k) {
        files->plot[k].text = text;
        good =
            files->plot[k].file == NULL || plot_bode(&files->plot[k], &plot_bode_all[k], analysis);
    }
    return good && atomic_file_commit_all();
}

static void say_files(const options_t *options) {
    outputs_say(options->csv);
    outputs_say(options->json);
    for (int k = 0; k < PLOT_BODE_COUNT && options->plots != NULL; ++k) {
        char path[RIG_PATH_LENGTH];
        plot_path(path, options, k);
        outputs_say(path);
    }
}

rig_exit_t command_analyse(const options_t *options) {
    rig_config_t config;
    files_t files = {.csv = NULL};
    if (!load(&config, options)) {
        return RIG_BAD_INPUT;
    }
    analyse_t *analysis = malloc(sizeof *analysis);
    if (analysis == NULL) {
        rig_error("out of memory");
        return RIG_BAD_INPUT;
    }
    const lode_status_t status = analyse_compute(analysis, &config);
    bool good = status == LODE_OK;
    if (!good) {
        refusal_report(&config, status);
    }
    shown_t text = {.file = NULL};
    good = good && open_files(&files, options) && shown_begin(&text);
    if (good) {
        report_analyse_text(text.file, &config, analysis);
        good = shown_end(&text) && write_files(&files, &config, analysis, text.text);
    }
    shown_free(&text);
    free(analysis);
    if (!good) {
        return RIG_BAD_INPUT;
    }
    say_files(options);
    return RIG_DONE;
}
