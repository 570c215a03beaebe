#include "commands/command_monte_carlo.h"

#include <stdlib.h>
#include <string.h>

#include "config/data_files.h"
#include "montecarlo/results.h"
#include "support/atomic_file.h"
#include "support/names.h"
#include "support/outputs.h"
#include "support/progress.h"
#include "support/shell.h"
#include "support/workers.h"

#define CASES_DEFAULT 200u
#define SEED_DEFAULT 1u

typedef struct {
    const options_t *options;
    mc_results_t results;
    mc_machine_t *machine; ///< one per motor
    uint64_t first, every; ///< of the shard: cases first, first + every, ...
    uint64_t last;         ///< number of the shard's last case, counted from 0
    progress_t progress;
} monte_carlo_t;

typedef char result_fits[sizeof(mc_result_t) <= WORKERS_RESULT_MAX ? 1 : -1];

static bool add_motor(void *user, const char *name) {
    mc_campaign_t *campaign = user;
    if (campaign->motors == MC_MOTORS_MAX) {
        rig_error("monte-carlo: expected at most %d motors", MC_MOTORS_MAX);
        return false;
    }
    (void)snprintf(campaign->motor[campaign->motors++], sizeof campaign->motor[0], "%s", name);
    return true;
}

static bool check_seeds(const mc_campaign_t *campaign) {
    const bool good = campaign->seed + (campaign->cases - 1u) <= OPTIONS_SEED_MAX;
    if (!good) {
        rig_error("--seed %llu, --n %llu: expected a last seed (seed + n - 1) of at most 2^53",
                  (unsigned long long)campaign->seed, (unsigned long long)campaign->cases);
    }
    return good;
}

/// The --set options as words of the command that repeats a case.
static bool describe_sets(mc_campaign_t *campaign, const options_t *options) {
    for (int k = 0; k < options->sets; ++k) {
        const size_t used = strlen(campaign->sets);
        const size_t room = sizeof campaign->sets - used;
        const int head = snprintf(campaign->sets + used, room, " --set ");
        if (head < 0 || (size_t)head >= room ||
            !shell_word(campaign->sets + used + (size_t)head, room - (size_t)head,
                        options->set[k])) {
            rig_error("--set: expected fewer or shorter ones, at most %zu characters together",
                      sizeof campaign->sets - 1u);
            return false;
        }
    }
    return true;
}

static bool describe(mc_campaign_t *campaign, const options_t *options) {
    campaign->test = MC_START;
    for (int k = MC_START; k <= MC_OPEN_PHASE; ++k) {
        if (strcmp(options->test, mc_test_name((mc_test_t)k)) == 0) {
            campaign->test = (mc_test_t)k;
        }
    }
    campaign->errors = campaign->test == MC_START ? MC_ERRORS_START : MC_ERRORS_NARROW;
    for (int k = MC_ERRORS_NARROW; options->errors != NULL && k <= MC_ERRORS_COMMISSIONED; ++k) {
        if (strcmp(options->errors, mc_errors_name((mc_errors_t)k)) == 0) {
            campaign->errors = (mc_errors_t)k;
        }
    }
    campaign->cases = options->cases > 0u ? options->cases : CASES_DEFAULT;
    campaign->seed = options->has_seed ? options->seed : SEED_DEFAULT;
    return describe_sets(campaign, options) && check_seeds(campaign) &&
           (options->motors != NULL ? names_take("--motors", options->motors, add_motor, campaign)
                                    : data_files_pairs(add_motor, campaign));
}

static bool load_machines(monte_carlo_t *self) {
    mc_campaign_t *campaign = &self->results.campaign;
    self->machine = calloc((size_t)campaign->motors, sizeof *self->machine);
    bool good = self->machine != NULL;
    for (int k = 0; good && k < campaign->motors; ++k) {
        good = mc_machine_load(&self->machine[k], campaign->motor[k], self->options->sets,
                               self->options->set);
        campaign->named[k] = good && !self->machine[k].has_emf;
    }
    return good;
}

static uint64_t case_of(const monte_carlo_t *self, uint64_t piece) {
    return self->first + piece * self->every;
}

/// Runs one case, in a process of its own if there are several.
static bool run_case(void *user, uint64_t piece, void *into) {
    const monte_carlo_t *self = user;
    const mc_campaign_t *campaign = &self->results.campaign;
    const uint64_t number = case_of(self, piece);
    const mc_machine_t *machine = &self->machine[number / campaign->cases];
    static mc_case_t one; // large
    mc_result_t result;
    if (!mc_draw(&one, machine, campaign->test, campaign->errors,
                 campaign->seed + number % campaign->cases)) {
        return false;
    }
    mc_trial(&result, machine, &one, campaign->test);
    memcpy(into, &result, sizeof result);
    return true;
}

static void take_case(void *user, uint64_t piece, const void *from) {
    monte_carlo_t *self = user;
    const uint64_t number = case_of(self, piece);
    mc_result_t result;
    memcpy(&result, from, sizeof result);
    mc_results_take(&self->results, number, &result);
    if (!result.passed) {
        (void)progress_end(&self->progress);
        mc_results_print_failure(stdout, &self->results, number);
        (void)fflush(stdout);
    }
    progress_show(&self->progress, (double)(piece + 1u) / (double)(self->last + 1u),
                  self->results.campaign.motor[number / self->results.campaign.cases]);
}

static rig_exit_t finish(const mc_results_t *results, const char *path, FILE *json) {
    (void)putchar('\n');
    const bool good = mc_results_print(stdout, results);
    if (json != NULL) {
        mc_results_write(json, results);
    }
    if (!atomic_file_commit_all()) {
        return RIG_BAD_INPUT;
    }
    outputs_say(path);
    return good ? RIG_DONE : RIG_FAILED;
}

static bool run_all(monte_carlo_t *self) {
    const uint64_t size = mc_results_size(&self->results);
    const options_t *options = self->options;
    self->every = options->shards > 0u ? options->shards : 1u;
    self->first = options->shard > 0u ? options->shard - 1u : 0u;
    if (self->first >= size) {
        rig_error("--shard: expected at most %llu shards, with one case each",
                  (unsigned long long)size);
        return false;
    }
    self->last = (size - 1u - self->first) / self->every;
    const workers_t workers = {.first = 0u,
                               .last = self->last,
                               .processes = options->jobs,
                               .user = self,
                               .work = run_case,
                               .take = take_case};
    progress_start(&self->progress);
    const bool good = workers_run(&workers);
    (void)progress_end(&self->progress);
    return good;
}

static rig_exit_t run_campaign(const options_t *options) {
    FILE *json = NULL;
    monte_carlo_t self = {.options = options};
    rig_exit_t code = RIG_BAD_INPUT;
    if (describe(&self.results.campaign, options) && load_machines(&self) &&
        outputs_open(&json, options->json) && mc_results_init(&self.results) && run_all(&self)) {
        code = finish(&self.results, options->json, json);
    }
    mc_results_free(&self.results);
    free(self.machine);
    return code;
}

static rig_exit_t merge(const options_t *options) {
    FILE *json = NULL;
    mc_results_t results = {.row = NULL};
    bool good = true;
    for (int k = 0; good && k < options->files; ++k) {
        good = mc_results_merge(&results, options->file[k]);
    }
    good = good && mc_results_complete(&results) && outputs_open(&json, options->json);
    for (uint64_t n = 0; good && n < mc_results_size(&results); ++n) {
        if (results.row[n].passed == 0u) {
            mc_results_print_failure(stdout, &results, n);
        }
    }
    const rig_exit_t code = good ? finish(&results, options->json, json) : RIG_BAD_INPUT;
    mc_results_free(&results);
    return code;
}

rig_exit_t command_monte_carlo(const options_t *options) {
    return strcmp(options->test, "merge") == 0 ? merge(options) : run_campaign(options);
}
