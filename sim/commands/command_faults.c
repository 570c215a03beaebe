#include "commands/command_faults.h"

#include <ctype.h>
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

/// A case, or some bits of it.
typedef struct {
    uint64_t number; ///< of the case
    bool by_bit;
    uint64_t first, last; ///< bits
} piece_t;

/// Result of a piece. It passes through a pipe, so it holds no pointers.
typedef struct {
    fault_result_t result;
    uint64_t silent; ///< bit n: the piece's bit first + n was silent
} answer_t;

typedef struct {
    const options_t *options;
    int kinds;
    const inject_kind_t *kind[INJECT_KINDS_MAX];
    int motors;
    char motor[MOTORS_MAX][NAMES_LENGTH];
    fault_bench_t *bench[MOTORS_MAX];
    inject_place_t place;
    bool by_bit;                  ///< --bits: each bit of a range instead of some random ones
    bool whole;                   ///< every bit
    uint64_t first_bit, last_bit; ///< the range otherwise
    piece_t *piece;               ///< of work
    uint64_t pieces;
    fault_result_t *result;   ///< [motor][kind][point]
    report_faults_bit_t *bit; ///< silent ones
    int bits;
    progress_t progress;
} faults_t;

typedef char answer_fits[sizeof(answer_t) <= WORKERS_RESULT_MAX ? 1 : -1];

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

static bool take_range(faults_t *self, const char *text) {
    char *end = NULL;
    if (isdigit((unsigned char)text[0]) != 0) {
        self->first_bit = strtoull(text, &end, 10);
    }
    if (end == NULL || end[0] != '-' || isdigit((unsigned char)end[1]) == 0) {
        return false;
    }
    self->last_bit = strtoull(end + 1, &end, 10);
    return end[0] == '\0' && self->first_bit <= self->last_bit;
}

/// After the kinds, which must have the bits.
static bool take_bits(faults_t *self) {
    const char *text = self->options->bits;
    self->by_bit = text != NULL && strcmp(text, "random") != 0;
    self->whole = self->by_bit && strcmp(text, "every") == 0;
    if (!self->by_bit) {
        return true;
    }
    if (!self->whole && !take_range(self, text)) {
        rig_error("--bits %s: expected random, every, or numbers as in 0-63", text);
        return false;
    }
    int flips = 0;
    for (int k = 0; k < self->kinds; ++k) {
        const uint64_t bits = inject_bits(self->kind[k]);
        flips += bits > 0u ? 1 : 0;
        if (bits > 0u && !self->whole && self->last_bit >= bits) {
            rig_error("--bits %s: %s has the bits 0 to %llu; expected some of them", text,
                      self->kind[k]->name, (unsigned long long)(bits - 1u));
            return false;
        }
    }
    if (flips == 0) {
        rig_error("--bits %s: expected a kind that flips bits in --kinds, such as flip-state",
                  text);
    }
    return flips > 0;
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

static const inject_kind_t *kind_of(const faults_t *self, uint64_t number) {
    return self->kind[number / FAULT_POINTS % (uint64_t)self->kinds];
}

static const fault_bench_t *bench_of(const faults_t *self, uint64_t number) {
    return self->bench[number / FAULT_POINTS / (uint64_t)self->kinds];
}

/// The pieces of a case: one, or with --bits one for every FAULT_BITS_MAX bits. Adds them if `piece` is not NULL; returns
/// how many there are.
static uint64_t split(const faults_t *self, uint64_t number, piece_t *piece) {
    const inject_kind_t *kind = kind_of(self, number);
    const uint64_t bits = inject_bits(kind);
    const bool by_bit = self->by_bit && bits > 0u;
    const uint64_t last = self->whole && by_bit ? bits - 1u : self->last_bit;
    uint64_t pieces = 0u;
    uint64_t first = by_bit ? self->first_bit : last;
    for (; first <= last; first += FAULT_BITS_MAX) {
        const uint64_t to =
            last - first < FAULT_BITS_MAX ? last : first + (uint64_t)FAULT_BITS_MAX - 1u;
        if (piece != NULL) {
            piece[pieces] = (piece_t){number, by_bit, first, to};
        }
        ++pieces;
    }
    return pieces;
}

static bool work(void *user, uint64_t number, void *into) {
    faults_t *self = user;
    const piece_t *piece = &self->piece[number];
    const fault_bench_t *bench = bench_of(self, piece->number);
    const inject_kind_t *kind = kind_of(self, piece->number);
    const fault_point_t point = (fault_point_t)(piece->number % FAULT_POINTS);
    const uint64_t seed = self->options->has_seed ? self->options->seed : 1u;
    answer_t answer = {.result = {.found = LODE_CHECK_NONE}};
    if (bench->left_out[point]) {
        // no result
    } else if (piece->by_bit) {
        answer.result =
            fault_case_bits(bench, kind, point, piece->first, piece->last, &answer.silent);
    } else {
        answer.result = fault_case_run(bench, kind, self->place, point, seed);
    }
    memcpy(into, &answer, sizeof answer);
    return true;
}

static void note_bits(faults_t *self, const piece_t *piece, uint64_t silent) {
    for (uint64_t n = 0u; n < FAULT_BITS_MAX; ++n) {
        if ((silent >> n & 1u) != 0u) {
            self->bit[self->bits++] =
                (report_faults_bit_t){.number = piece->number, .bit = piece->first + n};
        }
    }
}

static void take(void *user, uint64_t number, const void *from) {
    faults_t *self = user;
    const piece_t *piece = &self->piece[number];
    fault_result_t *result = &self->result[piece->number];
    answer_t answer;
    memcpy(&answer, from, sizeof answer);
    *result = result->tried > 0 ? fault_case_both(result, &answer.result) : answer.result;
    note_bits(self, piece, answer.silent);
    progress_show(&self->progress, (double)(number + 1u) / (double)self->pieces, "of the cases");
}

static bool plan(faults_t *self) {
    for (uint64_t number = 0u; number < cases_of(self); ++number) {
        self->pieces += split(self, number, NULL);
    }
    self->result = calloc(cases_of(self), sizeof *self->result);
    self->piece = calloc(self->pieces, sizeof *self->piece);
    self->bit = calloc(self->pieces * FAULT_BITS_MAX, sizeof *self->bit);
    if (self->result == NULL || self->piece == NULL || self->bit == NULL) {
        rig_error("faults: out of memory");
        return false;
    }
    piece_t *piece = self->piece;
    for (uint64_t number = 0u; number < cases_of(self); ++number) {
        piece += split(self, number, piece);
    }
    return true;
}

static bool run_all(faults_t *self) {
    if (!plan(self)) {
        return false;
    }
    const workers_t workers = {.first = 0u,
                               .last = self->pieces - 1u,
                               .processes = self->options->jobs,
                               .user = self,
                               .work = work,
                               .take = take};
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
                             .result = &self->result[first],
                             .by_bit = self->by_bit,
                             .first = first,
                             .bit = self->bit,
                             .bits = self->bits};
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
    if (!take_kinds(self) || !take_bits(self) || !take_place(self) || !take_motors(self) ||
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
    free(self.piece);
    free(self.bit);
    return code;
}
