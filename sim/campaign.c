#include "campaign.h"

#include <math.h>
#include <stdio.h>

#include "atomic_file.h"
#include "capture.h"
#include "command_run.h"
#include "config_json.h"
#include "outputs.h"
#include "report_run.h"
#include "runner.h"
#include "units.h"

typedef struct {
    const options_t *options;
    unsigned passed;
    cJSON *cases; ///< NULL: no JSON wanted
} campaign_t;

static const char *verdict(const runner_result_t *result) {
    if (result->fault.check != LODE_CHECK_NONE) {
        return lode_check_name((lode_check_t)result->fault.check);
    }
    return result->missed ? "missed a bar" : "passed";
}

static void print_case(double seed, const plant_config_t *plant, double load_Nm,
                       const runner_result_t *result) {
    const runner_phase_t *last = &result->phase[result->phases - 1];
    (void)printf(
        "seed %-5.0f %-6s  theta0 %6.1f deg, %5.2f Nm, Rs %6.4g Ohm, Lq %6.4g mH, J %6.4g | ", seed,
        report_run_failed(result) ? "FAILED" : "passed", rig_deg_from_rad(plant->theta_e_rad),
        load_Nm, plant->Rs_Ohm, 1e3 * plant->Lq_H, plant->J_kgm2);
    if (!isnan(result->handover_s)) {
        (void)printf("hand-over %.4f s", result->handover_s);
    }
    if (last->error_deg.count > 0) {
        (void)printf(", at the end %.1f rpm, error %.2f deg mean, %.2f pp",
                     rig_stats_mean(&last->speed_rpm), rig_stats_mean(&last->error_deg),
                     rig_stats_peak_to_peak(&last->error_deg));
    }
    (void)printf("%s%s\n", report_run_failed(result) ? ", " : "",
                 report_run_failed(result) ? verdict(result) : "");
}

static void add_case(cJSON *cases, double seed, const plant_config_t *plant, double load_Nm,
                     const runner_result_t *result) {
    cJSON *item = cJSON_CreateObject();
    (void)cJSON_AddItemToArray(cases, item);
    config_json_number(item, "seed", seed);
    (void)cJSON_AddBoolToObject(item, "passed", !report_run_failed(result));
    (void)cJSON_AddStringToObject(item, "verdict", verdict(result));
    config_json_number(item, "handover_s", result->handover_s);
    config_json_number(item, "theta0_deg", rig_deg_from_rad(plant->theta_e_rad));
    config_json_number(item, "load_Nm", load_Nm);
    config_json_number(item, "Rs_Ohm", plant->Rs_Ohm);
    config_json_number(item, "Lq_H", plant->Lq_H);
    config_json_number(item, "J_kgm2", plant->J_kgm2);
}

static bool run_case(campaign_t *self, rig_config_t *config, double seed) {
    runner_result_t result;
    runlog_t log;
    plant_config_t plant;
    double load_Nm = 0.0;
    config->scenario.seed = seed;
    runlog_init(&log);
    const bool good = runner_run(config, runner_estimator(config), &result, &log) &&
                      rig_config_plant(config, &plant, &load_Nm);
    runlog_free(&log);
    if (!good) {
        return false;
    }
    print_case(seed, &plant, load_Nm, &result);
    (void)fflush(stdout);
    self->passed += report_run_failed(&result) ? 0u : 1u;
    if (self->cases != NULL) {
        add_case(self->cases, seed, &plant, load_Nm, &result);
    }
    return true;
}

static bool run_cases(campaign_t *self, rig_config_t *config) {
    bool good = true;
    for (uint64_t seed = self->options->seed; good && seed <= self->options->seed_last; ++seed) {
        good = run_case(self, config, (double)seed);
    }
    return good;
}

static rig_exit_t finish(const campaign_t *self, FILE *json, cJSON *root) {
    const uint64_t cases = self->options->seed_last - self->options->seed + 1;
    (void)printf("\n%u of %llu passed\n", self->passed, (unsigned long long)cases);
    if (json != NULL) {
        config_json_number(root, "cases", (double)cases);
        config_json_number(root, "passed", (double)self->passed);
        (void)config_json_write(json, root);
    }
    if (!atomic_file_commit_all()) {
        return RIG_BAD_INPUT;
    }
    outputs_say(self->options->json);
    return self->passed == cases ? RIG_DONE : RIG_FAILED;
}

rig_exit_t campaign(const options_t *options) {
    rig_config_t config;
    FILE *json = NULL;
    campaign_t self = {.options = options};
    if (options->csv != NULL || options->plot != NULL || capture_wanted(options)) {
        rig_error("run --seeds: expected no --csv, --plot, --ring and --scope; they show a single "
                  "--seed");
        return RIG_BAD_INPUT;
    }
    if (!command_run_load(&config, options, options->scenario) ||
        !outputs_open(&json, options->json)) {
        return RIG_BAD_INPUT;
    }
    cJSON *root = json != NULL ? cJSON_CreateObject() : NULL;
    self.cases = json != NULL ? cJSON_AddArrayToObject(root, "seeds") : NULL;
    if (!run_cases(&self, &config)) {
        cJSON_Delete(root);
        return RIG_BAD_INPUT;
    }
    return finish(&self, json, root);
}
