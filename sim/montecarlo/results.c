#include "montecarlo/results.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "config/config_json.h"
#include "support/diag.h"
#include "support/inputs.h"
#include "support/shell.h"
#include "support/utf8.h"

// The bar for each motor.
#define MOTOR_SHARE 0.97

enum { CAUSES_MAX = 64 };
#define SILENT "silent: "
// One motor without usable EMF per so many motors is not counted against the bars.
#define MOTORS_PER_NAMED 12
#define LISTED_STEPS                                                                               \
    "load steps left out: without a response they would halve the speed within 10 ms"
#define NAMED "  no usable EMF (see `design`): not counted against the bars"
#define OTHER_CAUSE "  (other cause: this hardware is sound)"
#define LISTED_COASTS                                                                              \
    "speeds left out: the EMF is above the bus, and drives a current through the diodes"

static const char *const tests[] = {"start", "run", "fly", "quiet", "open-phase"};
static const char *const kinds[] = {"narrow", "wide", "start", "commissioned"};
enum { TESTS = sizeof tests / sizeof tests[0], KINDS = sizeof kinds / sizeof kinds[0] };

const char *mc_test_name(mc_test_t test) {
    return tests[test];
}

const char *mc_errors_name(mc_errors_t errors) {
    return kinds[errors];
}

bool mc_results_init(mc_results_t *self) {
    self->row = calloc((size_t)mc_results_size(self), sizeof *self->row);
    if (self->row == NULL) {
        rig_error("monte-carlo: out of memory for %llu cases; expected fewer",
                  (unsigned long long)mc_results_size(self));
    }
    return self->row != NULL;
}

void mc_results_free(mc_results_t *self) {
    free(self->row);
    self->row = NULL;
}

uint64_t mc_results_size(const mc_results_t *self) {
    return (uint64_t)self->campaign.motors * self->campaign.cases;
}

void mc_results_take(mc_results_t *self, uint64_t number, const mc_result_t *result) {
    mc_row_t *row = &self->row[number];
    row->done = 1u;
    row->passed = result->passed ? 1u : 0u;
    row->listed = (uint_least8_t)result->listed;
    row->periods = result->periods;
    row->max_error_deg = (float)(0.01 * round(100.0 * result->max_error_deg));
    row->found_ms = (float)(0.01 * round(1.0e5 * result->found_s));
    (void)snprintf(row->cause, sizeof row->cause, "%s%s",
                   result->passed || result->noticed ? "" : SILENT,
                   result->passed ? "" : result->cause);
}

static bool is_reported(const mc_row_t *row) {
    return strncmp(row->cause, MC_REPORTED, strlen(MC_REPORTED)) == 0;
}

static bool is_silent(const mc_row_t *row) {
    return strncmp(row->cause, SILENT, strlen(SILENT)) == 0;
}

/// A fault in RUN although the angle was usable. A start has no angle; `start` judges it.
static bool is_false_trip(const mc_row_t *row) {
    return row->done != 0u && row->passed == 0u && !is_silent(row) && !is_reported(row) &&
           (double)row->max_error_deg < MC_ERROR_MAX_deg;
}

/// Checks that blame hardware. Resistance and inductance are not among them: the trials have these wrong on purpose.
static const char *const blames[] = {"OPEN_PHASE ",
                                     "CURRENT_",
                                     "SWITCH_SHORTED ",
                                     "FLUX ",
                                     "BUS_STUCK ",
                                     "TEMPERATURE_STUCK ",
                                     "UNDER_TEMPERATURE",
                                     "MEMORY ",
                                     "TIMING ",
                                     "SIGNALS ",
                                     "OFFSET "};
enum { BLAMES = sizeof blames / sizeof blames[0] };

/// A fault with another cause: it blames hardware, all of which is sound in a trial without a broken phase.
static bool is_other_cause(const mc_campaign_t *campaign, const mc_row_t *row) {
    int k = 0;
    while (k < BLAMES && strncmp(row->cause, blames[k], strlen(blames[k])) != 0) {
        ++k;
    }
    return campaign->test != MC_OPEN_PHASE && row->done != 0u && row->passed == 0u && k < BLAMES;
}

void mc_results_print_failure(FILE *file, const mc_results_t *self, uint64_t number) {
    const mc_campaign_t *campaign = &self->campaign;
    const char *motor = campaign->motor[number / campaign->cases];
    const uint64_t seed = campaign->seed + number % campaign->cases;
    const mc_row_t *row = &self->row[number];
    char word[SHELL_GROWTH * NAMES_LENGTH + 3];
    char name[NAMES_LENGTH + 4];
    char cause[sizeof row->cause + 4];
    (void)shell_word(word, sizeof word, motor);
    (void)fprintf(file,
                  "%-18s %-60s lodestar monte-carlo %s --motors %s --errors %s --n 1 --seed "
                  "%llu%s\n",
                  utf8_copy_shown(name, sizeof name, motor),
                  utf8_copy_shown(cause, sizeof cause, row->cause), mc_test_name(campaign->test),
                  word, mc_errors_name(campaign->errors), (unsigned long long)seed, campaign->sets);
}

// ---- Table --------------------------------------------------------------------------------------

typedef struct {
    uint64_t cases, passed, silent, reported, listed, false_trips, other_causes, periods;
    double max_error_deg;
} count_t;

typedef struct {
    const char *words;
    uint64_t count;
    bool is_other;
} cause_t;

static count_t count_of(const mc_results_t *self, uint64_t from, uint64_t to) {
    count_t count = {.max_error_deg = 0.0};
    for (uint64_t n = from; n < to; ++n) {
        const mc_row_t *row = &self->row[n];
        count.cases += row->done;
        count.passed += row->passed;
        count.listed += row->listed;
        count.silent += is_silent(row) ? 1u : 0u;
        count.reported += is_reported(row) ? 1u : 0u;
        count.false_trips += is_false_trip(row) ? 1u : 0u;
        count.other_causes += is_other_cause(&self->campaign, row) ? 1u : 0u;
        count.periods += row->periods;
        count.max_error_deg = fmax(count.max_error_deg, (double)row->max_error_deg);
    }
    return count;
}

static int by_count(const void *a, const void *b) {
    const cause_t *one = a;
    const cause_t *other = b;
    if (one->count != other->count) {
        return one->count < other->count ? 1 : -1;
    }
    return strcmp(one->words, other->words);
}

static void print_causes(FILE *file, const mc_results_t *self, uint64_t from, uint64_t to) {
    cause_t cause[CAUSES_MAX] = {{NULL, 0u, false}};
    int causes = 0;
    for (uint64_t n = from; n < to; ++n) {
        const mc_row_t *row = &self->row[n];
        int k = 0;
        while (k < causes && strcmp(cause[k].words, row->cause) != 0) {
            ++k;
        }
        if (row->done == 0u || row->passed != 0u || k == CAUSES_MAX) {
            continue;
        }
        if (k == causes) {
            cause[causes++] = (cause_t){row->cause, 0u, is_other_cause(&self->campaign, row)};
        }
        cause[k].count++;
    }
    qsort(cause, (size_t)causes, sizeof cause[0], by_count);
    for (int k = 0; k < causes; ++k) {
        char words[sizeof self->row->cause + 4];
        (void)fprintf(file, "    %6llu  %s%s\n", (unsigned long long)cause[k].count,
                      utf8_copy_shown(words, sizeof words, cause[k].words),
                      cause[k].is_other ? OTHER_CAUSE : "");
    }
}

static double share_of(const count_t *count) {
    return count->cases > 0u ? (double)count->passed / (double)count->cases : 1.0;
}

/// For all motors together.
typedef struct {
    double share;
    const char *missed;
} bar_t;

static bar_t bar_of(mc_errors_t errors) {
    switch (errors) {
    case MC_ERRORS_WIDE:
        return (bar_t){0.95, "  BAR MISSED: 95 %"};
    case MC_ERRORS_COMMISSIONED:
        return (bar_t){0.999, "  BAR MISSED: 99.9 %"};
    case MC_ERRORS_NARROW:
    case MC_ERRORS_START:
    default:
        return (bar_t){0.99, "  BAR MISSED: 99 %"};
    }
}

/// Summary of a campaign without any reason to trip.
static bool print_quiet(FILE *file, const count_t *all) {
    const bool ran = all->periods > 0u;
    const char *missed = all->false_trips > 0u ? "  BAR MISSED: none" : "";
    (void)fprintf(file, "%.3g periods in RUN, %llu false trips%s\n", (double)all->periods,
                  (unsigned long long)all->false_trips,
                  ran ? missed : "  BAR MISSED: no drive ran");
    return ran && all->false_trips == 0u;
}

static int by_size(const void *a, const void *b) {
    const float one = *(const float *)a;
    const float other = *(const float *)b;
    return (one > other) - (one < other);
}

/// Summary of a campaign in which phases break: the time until a fault was found.
static void print_found(FILE *file, const mc_results_t *self) {
    float *found_ms = calloc((size_t)mc_results_size(self), sizeof *found_ms);
    size_t found = 0u;
    for (uint64_t n = 0; found_ms != NULL && n < mc_results_size(self); ++n) {
        if (self->row[n].done != 0u && !isnan(self->row[n].found_ms)) {
            found_ms[found++] = self->row[n].found_ms;
        }
    }
    if (found > 0u) {
        qsort(found_ms, found, sizeof found_ms[0], by_size);
        (void)fprintf(file, "found after %.1f ms (median), %.1f ms at most\n",
                      (double)found_ms[found / 2u], (double)found_ms[found - 1u]);
    }
    free(found_ms);
}

/// Number of motors without usable EMF that are not counted against the bars: at most one of twelve, in the
/// tests start and run with errors that are neither doubled nor corrected by commissioning.
static int spared(const mc_campaign_t *campaign) {
    int named = 0;
    if ((campaign->test != MC_START && campaign->test != MC_RUN) ||
        campaign->errors == MC_ERRORS_WIDE || campaign->errors == MC_ERRORS_COMMISSIONED) {
        return 0;
    }
    for (int k = 0; k < campaign->motors; ++k) {
        named += campaign->named[k] ? 1 : 0;
    }
    return MOTORS_PER_NAMED * named <= campaign->motors ? named : 0;
}

/// Of all motors that are held against the bars.
static count_t count_held(const mc_results_t *self, bool spares) {
    const mc_campaign_t *campaign = &self->campaign;
    count_t sum = {.max_error_deg = 0.0};
    for (int k = 0; k < campaign->motors; ++k) {
        const uint64_t from = (uint64_t)k * campaign->cases;
        const count_t count = count_of(self, from, from + campaign->cases);
        if (!spares || !campaign->named[k]) {
            sum.cases += count.cases;
            sum.passed += count.passed;
        }
    }
    return sum;
}

static void print_motor(FILE *file, const mc_results_t *self, int k, const char *verdict) {
    const mc_campaign_t *campaign = &self->campaign;
    const uint64_t from = (uint64_t)k * campaign->cases;
    const count_t count = count_of(self, from, from + campaign->cases);
    char name[NAMES_LENGTH + 4];
    (void)fprintf(file, "%-20s %9llu %9llu %8.2f %8llu  %.1f%s\n",
                  utf8_copy_shown(name, sizeof name, campaign->motor[k]),
                  (unsigned long long)count.cases, (unsigned long long)count.passed,
                  100.0 * share_of(&count), (unsigned long long)count.silent, count.max_error_deg,
                  verdict);
    if (count.listed > 0u) {
        (void)fprintf(file, "    %6llu  %s\n", (unsigned long long)count.listed,
                      campaign->test == MC_FLY ? LISTED_COASTS : LISTED_STEPS);
    }
    print_causes(file, self, from, from + campaign->cases);
}

/// Below the table: what the causes of all failures have in common.
static void print_causes_of_all(FILE *file, const mc_results_t *self, const count_t *all) {
    if (self->campaign.test == MC_OPEN_PHASE) {
        print_found(file, self);
    } else if (all->passed < all->cases) {
        (void)fprintf(file, "failures whose fault blames sound hardware: %llu of %llu\n",
                      (unsigned long long)all->other_causes,
                      (unsigned long long)(all->cases - all->passed));
    } else {
        // nothing to blame
    }
}

bool mc_results_print(FILE *file, const mc_results_t *self) {
    const mc_campaign_t *campaign = &self->campaign;
    const bool wide = campaign->errors == MC_ERRORS_WIDE;
    const bool quiet = campaign->test == MC_QUIET;
    const bool shares = !wide && !quiet;
    const count_t all = count_of(self, 0u, mc_results_size(self));
    bool good = true;
    (void)fprintf(file, "%-20s %9s %9s %8s %8s  %s\n", "motor", "cases", "passed", "%", "silent",
                  "largest angle error in RUN, deg");
    const bool spares = spared(campaign) > 0;
    for (int k = 0; k < campaign->motors; ++k) {
        const uint64_t from = (uint64_t)k * campaign->cases;
        const count_t count = count_of(self, from, from + campaign->cases);
        const bool named = spares && campaign->named[k];
        const bool held = !shares || named || share_of(&count) >= MOTOR_SHARE;
        good = good && held;
        print_motor(file, self, k, named ? NAMED : (held ? "" : "  BAR MISSED: 97 %"));
    }
    const count_t counted = count_held(self, spares);
    const bar_t bar = bar_of(campaign->errors);
    const bool pooled = quiet || share_of(&counted) >= bar.share;
    const bool faulted = quiet || !wide || all.silent + all.reported == 0u;
    (void)fprintf(file, "%-20s %9llu %9llu %8.2f %8llu  %.1f%s%s\n", "all",
                  (unsigned long long)all.cases, (unsigned long long)all.passed,
                  100.0 * share_of(&all), (unsigned long long)all.silent, all.max_error_deg,
                  pooled ? "" : bar.missed,
                  faulted ? "" : "  BAR MISSED: not every failure ended in a fault");
    print_causes_of_all(file, self, &all);
    return (!quiet || print_quiet(file, &all)) && good && pooled && faulted;
}

// ---- Files --------------------------------------------------------------------------------------

static void write_object(FILE *file, cJSON *object) {
    char *text = cJSON_PrintUnformatted(object);
    (void)fputs(text != NULL ? text : "null", file);
    cJSON_free(text);
    cJSON_Delete(object);
}

static void write_row(FILE *file, const mc_results_t *self, uint64_t number) {
    const mc_campaign_t *campaign = &self->campaign;
    const mc_row_t *row = &self->row[number];
    char error[32];
    cJSON *object = cJSON_CreateObject();
    (void)snprintf(error, sizeof error, "%.2f", (double)row->max_error_deg);
    (void)cJSON_AddStringToObject(object, "motor", campaign->motor[number / campaign->cases]);
    config_json_number(object, "seed", (double)(campaign->seed + number % campaign->cases));
    (void)cJSON_AddStringToObject(object, "result", row->passed != 0u ? "pass" : "fail");
    (void)cJSON_AddStringToObject(object, "cause", row->cause);
    if (is_other_cause(campaign, row)) {
        (void)cJSON_AddBoolToObject(object, "other_cause", true);
    }
    (void)cJSON_AddRawToObject(object, "max_error_deg", isnan(row->max_error_deg) ? "null" : error);
    if (row->listed > 0u) {
        (void)cJSON_AddNumberToObject(object, "listed", (double)row->listed);
    }
    if (campaign->test == MC_QUIET) {
        (void)cJSON_AddNumberToObject(object, "periods", (double)row->periods);
    }
    if (campaign->test == MC_OPEN_PHASE) {
        char found[32];
        (void)snprintf(found, sizeof found, "%.2f", (double)row->found_ms);
        (void)cJSON_AddRawToObject(object, "found_ms", isnan(row->found_ms) ? "null" : found);
    }
    write_object(file, object);
}

void mc_results_write(FILE *file, const mc_results_t *self) {
    const mc_campaign_t *campaign = &self->campaign;
    cJSON *motors = cJSON_CreateArray();
    cJSON *named = cJSON_CreateArray();
    for (int k = 0; k < campaign->motors; ++k) {
        (void)cJSON_AddItemToArray(motors, cJSON_CreateString(campaign->motor[k]));
        if (campaign->named[k]) {
            (void)cJSON_AddItemToArray(named, cJSON_CreateString(campaign->motor[k]));
        }
    }
    (void)fprintf(file, "{\"test\":\"%s\",\"errors\":\"%s\",\"n\":%llu,\"seed\":%llu,\"set\":",
                  mc_test_name(campaign->test), mc_errors_name(campaign->errors),
                  (unsigned long long)campaign->cases, (unsigned long long)campaign->seed);
    write_object(file, cJSON_CreateString(campaign->sets));
    (void)fputs(",\"motors\":", file);
    write_object(file, motors);
    (void)fputs(",\"named\":", file);
    write_object(file, named);
    (void)fputs(",\"rows\":[", file);
    const char *between = "\n";
    for (uint64_t n = 0; n < mc_results_size(self); ++n) {
        if (self->row[n].done != 0u) {
            (void)fputs(between, file);
            write_row(file, self, n);
            between = ",\n";
        }
    }
    (void)fputs("\n]}\n", file);
}

static char *read_all(const char *path) {
    FILE *file = inputs_open(path);
    if (file == NULL) {
        rig_error("%s: %s", path, strerror(errno));
        return NULL;
    }
    size_t used = 0u;
    size_t room = 1u << 16;
    char *text = malloc(room);
    while (text != NULL && !feof(file) && !ferror(file)) {
        used += fread(text + used, 1u, room - used - 1u, file);
        if (room - used < 2u) {
            room *= 2u;
            char *more = realloc(text, room);
            if (more == NULL) {
                free(text);
            }
            text = more;
        }
    }
    const bool good = text != NULL && !ferror(file);
    (void)fclose(file);
    if (!good) {
        rig_error("%s: cannot be read", path);
        free(text);
        return NULL;
    }
    text[used] = '\0';
    return text;
}

static const char *text_of(const cJSON *object, const char *name) {
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(object, name));
    return text != NULL ? text : "";
}

/// A whole number up to `most`; -1: not a whole number.
static int64_t whole_of(const cJSON *object, const char *name, double most) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, name);
    const bool good = cJSON_IsNumber(item) && item->valuedouble >= 0.0 &&
                      item->valuedouble <= most && !(floor(item->valuedouble) < item->valuedouble);
    return good ? (int64_t)item->valuedouble : -1;
}

static int index_of(const char *name, const char *const *names, int count) {
    int k = 0;
    while (k < count && strcmp(names[k], name) != 0) {
        ++k;
    }
    return k < count ? k : -1;
}

#define WHOLE_MAX 9007199254740992.0 // 2^53
#define CASES_MAX 1.0e7

static bool has_name(const cJSON *names, const char *name) {
    const cJSON *item = NULL;
    cJSON_ArrayForEach(item, names) {
        const char *text = cJSON_GetStringValue(item);
        if (text != NULL && strcmp(text, name) == 0) {
            return true;
        }
    }
    return false;
}

static bool read_campaign(mc_campaign_t *campaign, const cJSON *root) {
    const int test = index_of(text_of(root, "test"), tests, TESTS);
    const int errors = index_of(text_of(root, "errors"), kinds, KINDS);
    const int64_t cases = whole_of(root, "n", CASES_MAX);
    const int64_t seed = whole_of(root, "seed", WHOLE_MAX);
    const cJSON *motors = cJSON_GetObjectItemCaseSensitive(root, "motors");
    const int count = cJSON_GetArraySize(motors);
    if (test < 0 || errors < 0 || cases < 1 || seed < 0 || count < 1 || count > MC_MOTORS_MAX) {
        return false;
    }
    memset(campaign, 0, sizeof *campaign);
    campaign->test = (mc_test_t)test;
    campaign->errors = (mc_errors_t)errors;
    campaign->cases = (uint64_t)cases;
    campaign->seed = (uint64_t)seed;
    campaign->motors = count;
    const char *sets = text_of(root, "set"); // printed as a part of a command
    if (strlen(sets) >= sizeof campaign->sets || !shell_is_words(sets)) {
        return false;
    }
    (void)snprintf(campaign->sets, sizeof campaign->sets, "%s", sets);
    for (int k = 0; k < count; ++k) {
        const char *name = cJSON_GetStringValue(cJSON_GetArrayItem(motors, k));
        if (name == NULL || strlen(name) >= sizeof campaign->motor[k]) {
            return false;
        }
        (void)snprintf(campaign->motor[k], sizeof campaign->motor[k], "%s", name);
        campaign->named[k] = has_name(cJSON_GetObjectItemCaseSensitive(root, "named"), name);
    }
    return true;
}

/// -1: not a case of this campaign.
static int64_t number_of(const mc_campaign_t *campaign, const cJSON *item) {
    const char *motor = text_of(item, "motor");
    const int64_t seed = whole_of(item, "seed", WHOLE_MAX);
    int k = 0;
    while (k < campaign->motors && strcmp(campaign->motor[k], motor) != 0) {
        ++k;
    }
    const uint64_t after = (uint64_t)seed - campaign->seed;
    return k < campaign->motors && seed >= 0 && after < campaign->cases
               ? (int64_t)((uint64_t)k * campaign->cases + after)
               : -1;
}

static bool read_rows(mc_results_t *self, const cJSON *root, const char *path) {
    const cJSON *item = NULL;
    cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(root, "rows")) {
        const int64_t number = number_of(&self->campaign, item);
        const cJSON *error = cJSON_GetObjectItemCaseSensitive(item, "max_error_deg");
        const cJSON *found = cJSON_GetObjectItemCaseSensitive(item, "found_ms");
        const bool passed = strcmp(text_of(item, "result"), "pass") == 0;
        if (number < 0 || (!passed && strcmp(text_of(item, "result"), "fail") != 0)) {
            rig_error("%s: expected rows {motor, seed, result, cause, max_error_deg} of cases of "
                      "this campaign",
                      path);
            return false;
        }
        mc_row_t *row = &self->row[number];
        if (row->done != 0u) {
            rig_error("%s: %s, seed %.0f occurs twice; expected each case in one file only", path,
                      text_of(item, "motor"), (double)whole_of(item, "seed", WHOLE_MAX));
            return false;
        }
        const int64_t listed = whole_of(item, "listed", 255.0);
        row->done = 1u;
        row->passed = passed ? 1u : 0u;
        row->listed = listed > 0 ? (uint_least8_t)listed : 0u;
        const int64_t periods = whole_of(item, "periods", WHOLE_MAX);
        row->periods = periods > 0 ? (uint64_t)periods : 0u;
        row->max_error_deg = cJSON_IsNumber(error) ? (float)error->valuedouble : NAN;
        row->found_ms = cJSON_IsNumber(found) ? (float)found->valuedouble : NAN;
        (void)snprintf(row->cause, sizeof row->cause, "%s", text_of(item, "cause"));
    }
    return true;
}

static bool take_campaign(mc_results_t *self, const cJSON *root, const char *path) {
    mc_campaign_t campaign;
    if (!read_campaign(&campaign, root)) {
        rig_error("%s: expected a file that monte-carlo --json has written", path);
        return false;
    }
    if (self->row == NULL) {
        self->campaign = campaign;
        return mc_results_init(self);
    }
    if (memcmp(&self->campaign, &campaign, sizeof campaign) != 0) {
        rig_error("%s: expected a part of the same campaign: test, errors, n, seed, motors and "
                  "--set as in the first file",
                  path);
        return false;
    }
    return true;
}

bool mc_results_merge(mc_results_t *self, const char *path) {
    char *text = read_all(path);
    if (text == NULL) {
        return false;
    }
    cJSON *root = cJSON_Parse(text);
    free(text);
    const bool good = take_campaign(self, root, path) && read_rows(self, root, path);
    cJSON_Delete(root);
    return good;
}

bool mc_results_complete(const mc_results_t *self) {
    uint64_t missing = 0u;
    uint64_t first = 0u;
    for (uint64_t n = mc_results_size(self); n > 0u; --n) {
        if (self->row[n - 1u].done == 0u) {
            missing++;
            first = n - 1u;
        }
    }
    if (missing > 0u) {
        const mc_campaign_t *campaign = &self->campaign;
        rig_error("monte-carlo merge: %llu cases are missing, the first is %s, seed %llu; expected "
                  "the files of all shards",
                  (unsigned long long)missing, campaign->motor[first / campaign->cases],
                  (unsigned long long)(campaign->seed + first % campaign->cases));
    }
    return missing == 0u;
}
