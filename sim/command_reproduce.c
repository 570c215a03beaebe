#include "command_reproduce.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "atomic_file.h"
#include "ini_config.h"
#include "outputs.h"
#include "reproduce_plots.h"
#include "reproduce_report.h"

typedef struct {
    FILE *csv;
    FILE *json;
    FILE *svg[REPRODUCE_PLOTS];
} files_t;

static bool load(case_bases_t *bases, const options_t *options) {
    bool good = case_load(bases);
    for (int k = 0; good && k < options->sets; ++k) {
        good = ini_config_set(&bases->paper, "--set", options->set[k]) &&
               ini_config_set(&bases->library, "--set", options->set[k]);
    }
    return good;
}

static bool make_folder(const char *path) {
    if (mkdir(path, 0777) != 0 && errno != EEXIST) {
        rig_error("%s: %s; expected to be able to make this folder", path, strerror(errno));
        return false;
    }
    return true;
}

static void plot_path(char *path, const options_t *options, int k) {
    (void)snprintf(path, RIG_PATH_LENGTH, "%s/%s", options->plots, reproduce_plot_file(k));
}

static bool open_files(files_t *files, const options_t *options) {
    bool good =
        outputs_open(&files->csv, options->csv) && outputs_open(&files->json, options->json);
    if (!good || options->plots == NULL) {
        return good;
    }
    good = plot_available() && make_folder(options->plots);
    for (int k = 0; good && k < REPRODUCE_PLOTS; ++k) {
        char path[RIG_PATH_LENGTH];
        plot_path(path, options, k);
        good = outputs_open(&files->svg[k], path);
    }
    return good;
}

/// False after a message.
static bool write_files(const files_t *files, const reproduction_t *reproduction,
                        const case_bases_t *bases) {
    if (files->csv != NULL) {
        reproduce_report_csv(files->csv, reproduction);
    }
    if (files->json != NULL) {
        reproduce_report_json(files->json, reproduction, bases);
    }
    bool good = true;
    for (int k = 0; good && k < REPRODUCE_PLOTS; ++k) {
        good = files->svg[k] == NULL || reproduce_plot(files->svg[k], k, reproduction, bases);
    }
    return good && atomic_file_commit_all();
}

rig_exit_t command_reproduce(const options_t *options) {
    static case_bases_t bases;
    static reproduction_t reproduction;
    files_t files = {NULL, NULL, {NULL}};
    if (strcmp(options->paper, CASE_PAPER) != 0) {
        rig_error("reproduce %s: unknown; expected %s", options->paper, CASE_PAPER);
        return RIG_BAD_INPUT;
    }
    if (!load(&bases, options) || !open_files(&files, options) ||
        !reproduction_run(&reproduction, &bases)) {
        return RIG_BAD_INPUT;
    }
    reproduce_report_table(stdout, &reproduction);
    (void)fflush(stdout);
    if (!write_files(&files, &reproduction, &bases)) {
        return RIG_BAD_INPUT;
    }
    outputs_say(options->csv);
    outputs_say(options->json);
    for (int k = 0; options->plots != NULL && k < REPRODUCE_PLOTS; ++k) {
        char path[RIG_PATH_LENGTH];
        plot_path(path, options, k);
        outputs_say(path);
    }
    return RIG_DONE;
}
