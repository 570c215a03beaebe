#include "commands/command_reproduce.h"

#include <stdio.h>
#include <string.h>

#include "commands/command_load.h"
#include "reproduce/li_plots.h"
#include "reproduce/plots.h"
#include "reproduce/report.h"
#include "support/atomic_file.h"
#include "support/outputs.h"
#include "support/progress.h"
#include "support/shown.h"

enum {
    PLOTS_MAX = LI_PLOTS, // the largest number of any paper
    SEEDS = 5
};

/// Interface of one paper.
typedef struct {
    const char *name;
    bool (*load)(const options_t *options);
    const table_t *(*run)(const reproduce_extent_t *extent); ///< NULL after a message
    const rig_config_t *config;
    int plots;
    const char *(*plot_file)(int k);
    bool (*plot)(const plot_output_t *output, int k);
} study_t;

typedef struct {
    FILE *csv;
    FILE *json;
    plot_output_t plot[PLOTS_MAX];
} files_t;

// ---- Paper 1 ------------------------------------------------------------------------------------

static case_bases_t bases;
static reproduction_t reproduction;

static bool jiang_load(const options_t *options) {
    return case_load(&bases) && command_load_sets(&bases.paper, options) &&
           command_load_sets(&bases.library, options);
}

static const table_t *jiang_run(const reproduce_extent_t *extent) {
    return reproduction_run(&reproduction, &bases, extent) ? &reproduction.table : NULL;
}

static bool jiang_plot(const plot_output_t *output, int k) {
    return reproduce_plot(output, k, &reproduction, &bases);
}

// ---- Paper 2 ------------------------------------------------------------------------------------

static rig_config_t li_base;
static table_t li_table;

static bool li_load(const options_t *options) {
    return li_case_load(&li_base) && command_load_sets(&li_base, options);
}

static const table_t *li_run(const reproduce_extent_t *extent) {
    return li_reproduction_run(&li_table, &li_base, extent) ? &li_table : NULL;
}

static bool li_draw(const plot_output_t *output, int k) {
    return li_plot(output, k, &li_table, &li_base);
}

// ---- Both ---------------------------------------------------------------------------------------

static const study_t studies[] = {
    {CASE_PAPER, jiang_load, jiang_run, &bases.paper, REPRODUCE_PLOTS, reproduce_plot_file,
     jiang_plot},
    {LI_PAPER, li_load, li_run, &li_base, LI_PLOTS, li_plot_file, li_draw},
};

static const study_t *study_of(const char *paper) {
    for (size_t k = 0; k < sizeof studies / sizeof studies[0]; ++k) {
        if (strcmp(paper, studies[k].name) == 0) {
            return &studies[k];
        }
    }
    rig_error("reproduce %s: unknown; expected %s or %s", paper, CASE_PAPER, LI_PAPER);
    return NULL;
}

static void plot_path(char *path, const options_t *options, const char *file) {
    plot_path_in(path, RIG_PATH_LENGTH, options->plots, file, options->format);
}

static bool open_files(files_t *files, const options_t *options, const study_t *study) {
    bool good =
        outputs_open(&files->csv, options->csv) && outputs_open(&files->json, options->json);
    if (!good || options->plots == NULL) {
        return good;
    }
    good = plot_available() && outputs_folder(options->plots);
    for (int k = 0; good && k < study->plots; ++k) {
        char path[RIG_PATH_LENGTH];
        plot_path(path, options, study->plot_file(k));
        good = plot_open(&files->plot[k], path);
    }
    return good;
}

/// False after a message.
static bool write_files(files_t *files, const study_t *study, const table_t *table,
                        const char *text) {
    if (files->csv != NULL) {
        reproduce_report_csv(files->csv, table);
    }
    if (files->json != NULL) {
        reproduce_report_json(files->json, table, study->config);
    }
    bool good = true;
    progress_t progress;
    progress_start(&progress);
    for (int k = 0; good && k < study->plots; ++k) {
        progress_show(&progress, (double)k / study->plots, "pictures");
        files->plot[k].text = text;
        good = files->plot[k].file == NULL || study->plot(&files->plot[k], k);
    }
    (void)progress_end(&progress);
    return good && atomic_file_commit_all();
}

/// False after a message.
static bool extent_of(const options_t *options, reproduce_extent_t *extent) {
    *extent = (reproduce_extent_t){.first_seed = 1u, .seeds = SEEDS, .processes = options->jobs};
    if (options->has_campaign) {
        const uint64_t more = options->seed_last - options->seed;
        if (more >= SEEDS_MAX) {
            rig_error("reproduce --seeds: expected at most %d", SEEDS_MAX);
            return false;
        }
        extent->first_seed = options->seed;
        extent->seeds = (int)more + 1;
    }
    return true;
}

rig_exit_t command_reproduce(const options_t *options) {
    files_t files = {.csv = NULL};
    reproduce_extent_t extent;
    const study_t *study = study_of(options->paper);
    if (study == NULL || !extent_of(options, &extent) || !study->load(options) ||
        !open_files(&files, options, study)) {
        return RIG_BAD_INPUT;
    }
    const table_t *table = study->run(&extent);
    if (table == NULL) {
        return RIG_BAD_INPUT;
    }
    shown_t shown;
    bool good = shown_begin(&shown);
    if (good) {
        reproduce_report_table(shown.file, table);
        good = shown_end(&shown) && write_files(&files, study, table, shown.text);
    }
    shown_free(&shown);
    if (!good) {
        return RIG_BAD_INPUT;
    }
    outputs_say(options->csv);
    outputs_say(options->json);
    for (int k = 0; options->plots != NULL && k < study->plots; ++k) {
        char path[RIG_PATH_LENGTH];
        plot_path(path, options, study->plot_file(k));
        outputs_say(path);
    }
    return RIG_DONE;
}
