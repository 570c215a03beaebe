#include "commands/command_faults.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands/command_load.h"
#include "config/data_files.h"
#include "config/ini_config.h"
#include "config/refusal.h"
#include "report/report_faults.h"
#include "support/atomic_file.h"
#include "support/names.h"
#include "support/outputs.h"
#include "support/progress.h"
#include "support/shown.h"
#include "support/workers.h"

#define ALL_MOTORS "jiang2022,eldeeb2017"
enum { MOTORS_MAX = 8 };

/// Settings that the campaign adds where the motor's files leave them open: time stamps of the port, field weakening, a
/// switched inverter, one count of noise on the temperature sensor as on the bus sensor, and the checks of the guard that rely
/// on the noise of both.
static const struct {
    const char *section, *key, *value;
} added[] = {
    {"references", "field_weakening", "on"}, {"guard", "stamp_per_period", "1000"},
    {"plant", "inverter", "switched"},       {"plant", "temperature_noise_degC", "0.05"},
    {"guard", "temperature_still_s", "0.5"}, {"guard", "bus_still_s", "0.1"},
};
enum { ADDED = sizeof added / sizeof added[0] };

typedef struct {
    const options_t *options;
    int kinds;
    const inject_kind_t *kind[INJECT_KINDS_MAX];
    int motors;
    char motor[MOTORS_MAX][NAMES_LENGTH];
    fault_bench_t *bench[MOTORS_MAX];
    inject_place_t place;
    fault_result_t *result; ///< [motor][kind][point]
    progress_t progress;
} faults_t;

typedef char result_fits[sizeof(fault_result_t) <= WORKERS_RESULT_MAX ? 1 : -1];

// ---- Input --------------------------------------------------------------------------------------

static bool take_kind(void *user, const char *name) {
    faults_t *self = user;
    for (int k = 0; k < inject_kind_count; ++k) {
        if (strcmp(inject_kinds[k].name, name) == 0) {
            self->kind[self->kinds++] = &inject_kinds[k];
            return true;
        }
    }
    char known[1400] = "";
    for (int k = 0; k < inject_kind_count; ++k) {
        const size_t used = strlen(known);
        (void)snprintf(known + used, sizeof known - used, "%s%s", k > 0 ? ", " : "",
                       inject_kinds[k].name);
    }
    rig_error("--kinds %s: unknown; expected one or more of %s, separated by commas", name, known);
    return false;
}

static bool take_kinds(faults_t *self) {
    if (self->options->kinds != NULL) {
        return names_take("--kinds", self->options->kinds, take_kind, self);
    }
    for (int k = 0; k < inject_kind_count; ++k) {
        self->kind[self->kinds++] = &inject_kinds[k];
    }
    return true;
}

static const struct {
    const char *name;
    inject_place_t place;
} places[] = {
    {"a1", {0, INJECT_BOTH_SETS}},
    {"b1", {1, INJECT_BOTH_SETS}},
    {"c1", {2, INJECT_BOTH_SETS}},
    {"a2", {3, INJECT_BOTH_SETS}},
    {"b2", {4, INJECT_BOTH_SETS}},
    {"c2", {5, INJECT_BOTH_SETS}},
    {"set-1", {0, 0}},
    {"set-2", {3, 1}},
};
enum { PLACES = sizeof places / sizeof places[0] };

static bool take_place(faults_t *self) {
    const char *name = self->options->place != NULL ? self->options->place : places[0].name;
    for (int k = 0; k < PLACES; ++k) {
        if (strcmp(places[k].name, name) == 0) {
            self->place = places[k].place;
            return true;
        }
    }
    rig_error("--in %s: unknown; expected a1, b1, c1, a2, b2, c2, set-1 or set-2", name);
    return false;
}

/// Three phases have one set.
static bool has_place(const faults_t *self, const rig_config_t *config) {
    const bool six = self->place.set != INJECT_BOTH_SETS || self->place.leg >= PLANT_PHASES;
    if (six && !rig_config_is_six(config)) {
        rig_error_at(config->file[0], 0, "--in %s: expected a motor with six phases",
                     self->options->place);
        return false;
    }
    return true;
}

/// Loads a motor and a drive, and adds the settings of the campaign.
static bool load(rig_config_t *config, const char *name, const options_t *options) {
    rig_config_init(config);
    bool good = data_files_load_pair(config, name);
    for (int k = 0; good && k < ADDED; ++k) {
        char setting[96];
        (void)snprintf(setting, sizeof setting, "%s.%s=%s", added[k].section, added[k].key,
                       added[k].value);
        good = rig_config_is_given(config, added[k].section, added[k].key) ||
               ini_config_set(config, "faults", setting);
    }
    good =
        good && command_load_sets(config, options) && rig_config_complete(config, RIG_NEED_DRIVE);
    if (!good) {
        return false;
    }
    if (isnan(config->plant.v_bus_noise_V)) { // one count, as for the temperature
        config->plant.v_bus_noise_V = (double)config->drive.sense.v_bus_gain_V_count;
    }
    rig_config_design(config);
    config->scenario.seed = options->has_seed ? (double)options->seed : 1.0;
    const lode_status_t status = rig_config_judge(config);
    if (status != LODE_OK) {
        refusal_report(config, status);
    }
    return status == LODE_OK;
}

static bool take_motor(void *user, const char *name) {
    faults_t *self = user;
    if (self->motors == MOTORS_MAX) {
        rig_error("--motors %s: expected at most %d of them", name, MOTORS_MAX);
        return false;
    }
    const int n = self->motors++;
    fault_bench_t *bench = calloc(1u, sizeof *bench);
    (void)snprintf(self->motor[n], sizeof self->motor[n], "%s", name);
    self->bench[n] = bench;
    if (bench == NULL) {
        rig_error("faults: out of memory");
        return false;
    }
    rig_config_t config;
    const double share = self->options->has_load ? self->options->load : (double)NAN;
    return load(&config, name, self->options) && has_place(self, &config) &&
           fault_bench_init(bench, &config, share);
}

static bool take_motors(faults_t *self) {
    const char *list = self->options->motors != NULL ? self->options->motors : ALL_MOTORS;
    return names_take("--motors", list, take_motor, self);
}

// ---- The cases ----------------------------------------------------------------------------------

static uint64_t cases_of(const faults_t *self) {
    return (uint64_t)self->motors * (uint64_t)self->kinds * FAULT_POINTS;
}

static bool work(void *user, uint64_t number, void *into) {
    faults_t *self = user;
    const uint64_t point = number % FAULT_POINTS;
    const uint64_t kind = number / FAULT_POINTS % (uint64_t)self->kinds;
    const uint64_t motor = number / FAULT_POINTS / (uint64_t)self->kinds;
    const uint64_t seed = self->options->has_seed ? self->options->seed : 1u;
    fault_result_t result = {.found = LODE_CHECK_NONE};
    if (!self->bench[motor]->left_out[point]) {
        result = fault_case_run(self->bench[motor], self->kind[kind], self->place,
                                (fault_point_t)point, seed);
    }
    memcpy(into, &result, sizeof result);
    return true;
}

static void take(void *user, uint64_t number, const void *from) {
    faults_t *self = user;
    memcpy(&self->result[number], from, sizeof self->result[number]);
    progress_show(&self->progress, (double)(number + 1u) / (double)cases_of(self), "of the cases");
}

static bool run_all(faults_t *self) {
    const workers_t workers = {.first = 0u,
                               .last = cases_of(self) - 1u,
                               .processes = self->options->jobs,
                               .user = self,
                               .work = work,
                               .take = take};
    self->result = calloc(cases_of(self), sizeof *self->result);
    if (self->result == NULL) {
        rig_error("faults: out of memory");
        return false;
    }
    progress_start(&self->progress);
    const bool good = workers_run(&workers);
    (void)progress_end(&self->progress);
    return good;
}

// ---- Output -------------------------------------------------------------------------------------

static report_faults_t report_of(const faults_t *self, int motor) {
    const uint64_t first = (uint64_t)motor * (uint64_t)self->kinds * FAULT_POINTS;
    return (report_faults_t){.motor = self->motor[motor],
                             .place = self->options->place,
                             .bench = self->bench[motor],
                             .kind = self->kind,
                             .kinds = self->kinds,
                             .result = &self->result[first]};
}

static int write_all(const faults_t *self, FILE *page, FILE *json) {
    cJSON *root = json != NULL ? report_faults_json_root() : NULL;
    shown_t table = {.file = NULL};
    int silent = -1;
    if (shown_begin(&table)) {
        silent = 0;
        for (int n = 0; n < self->motors; ++n) {
            const report_faults_t report = report_of(self, n);
            silent += report_faults_table(table.file, &report);
            report_faults_json(root, &report);
        }
        silent = shown_end(&table) ? silent : -1;
        if (page != NULL && silent >= 0) {
            report_faults_page(page, table.text);
        }
    }
    shown_free(&table);
    if (json != NULL) {
        (void)config_json_write(json, root);
    }
    return silent;
}

static void explain(void) {
    printf("A cell: the check that found the fault, after what time, the largest phase current, "
           "how far the rotor\n"
           "turned back. harmless: nothing went wrong. given up: attempts of the start. 10 %%: of "
           "full speed, or 1.25\n"
           "times the least speed. More: docs/faults.md\n"
           "Added where the files leave it open (--set changes it):");
    for (int k = 0; k < ADDED; ++k) {
        printf(" %s.%s=%s", added[k].section, added[k].key, added[k].value);
    }
    printf("\n\n");
}

static rig_exit_t run(faults_t *self) {
    FILE *page = NULL;
    FILE *json = NULL;
    if (!take_kinds(self) || !take_place(self) || !take_motors(self) ||
        !outputs_open(&json, self->options->json) || !outputs_open(&page, self->options->out) ||
        !run_all(self)) {
        return RIG_BAD_INPUT;
    }
    explain();
    const int silent = write_all(self, page, json);
    if (silent < 0 || !atomic_file_commit_all()) {
        return RIG_BAD_INPUT;
    }
    outputs_say(self->options->out);
    outputs_say(self->options->json);
    return silent == 0 ? RIG_DONE : RIG_FAILED;
}

rig_exit_t command_faults(const options_t *options) {
    static faults_t self;
    self = (faults_t){.options = options};
    const rig_exit_t code = run(&self);
    for (int n = 0; n < self.motors; ++n) {
        free(self.bench[n]);
    }
    free(self.result);
    return code;
}
