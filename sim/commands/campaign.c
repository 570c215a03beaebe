#include "commands/campaign.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "commands/command_load.h"
#include "config/config_json.h"
#include "report/report_run.h"
#include "rig/capture.h"
#include "rig/runner.h"
#include "support/atomic_file.h"
#include "support/outputs.h"
#include "support/progress.h"
#include "support/units.h"
#include "support/workers.h"

typedef struct {
    const options_t *options;
    rig_config_t config;
    uint64_t passed;
    bool barred;  ///< the scenario sets a bar
    bool random;  ///< seeds differ
    cJSON *cases; ///< NULL: no JSON wanted
    progress_t progress;
} campaign_t;

/// Result of one seed. It passes through a pipe, so it holds no pointers.
typedef struct {
    bool passed;
    bool barred;
    char verdict[64];
    double theta0_deg, load_Nm, Rs_Ohm, Lq_H, J_kgm2;
    double handover_s;                         ///< NaN: never
    double speed_rpm, error_deg, error_pp_deg; ///< at the end; NaN: not in RUN at the end
} case_t;

typedef char case_fits[sizeof(case_t) <= WORKERS_RESULT_MAX ? 1 : -1];

static const char *verdict(const runner_result_t *result) {
    if (result->fault.check != LODE_CHECK_NONE) {
        return lode_check_name((lode_check_t)result->fault.check);
    }
    if (result->never_ran) {
        return "RUN was never reached";
    }
    if (result->starts_yet) {
        return "RUN was lost";
    }
    if (report_run_refused(result) != NULL && !result->missed) {
        return "a command was refused";
    }
    return result->missed ? "missed a bar" : "passed";
}

static void print_case(uint64_t seed, const case_t *one) {
    (void)printf(
        "seed %-5llu %-6s  theta0 %6.1f deg, %5.2f Nm, Rs %6.4g Ohm, Lq %6.4g mH, J %6.4g | ",
        (unsigned long long)seed, one->passed ? "passed" : "FAILED", one->theta0_deg, one->load_Nm,
        one->Rs_Ohm, 1e3 * one->Lq_H, one->J_kgm2);
    if (!isnan(one->handover_s)) {
        (void)printf("hand-over %.4f s", one->handover_s);
    }
    if (!isnan(one->error_deg)) {
        (void)printf(", at the end %.1f rpm, error %.2f deg mean, %.2f pp", one->speed_rpm,
                     one->error_deg, one->error_pp_deg);
    }
    (void)printf("%s%s\n", one->passed ? "" : ", ", one->passed ? "" : one->verdict);
}

static void add_case(cJSON *cases, uint64_t seed, const case_t *one) {
    cJSON *item = config_json_item(cases);
    config_json_number(item, "seed", (double)seed);
    (void)cJSON_AddBoolToObject(item, "passed", one->passed);
    (void)cJSON_AddStringToObject(item, "verdict", one->verdict);
    config_json_number(item, "handover_s", one->handover_s);
    config_json_number(item, "theta0_deg", one->theta0_deg);
    config_json_number(item, "load_Nm", one->load_Nm);
    config_json_number(item, "Rs_Ohm", one->Rs_Ohm);
    config_json_number(item, "Lq_H", one->Lq_H);
    config_json_number(item, "J_kgm2", one->J_kgm2);
}

/// Runs one seed, in a process of its own if there are several.
static bool run_case(void *user, uint64_t seed, void *into) {
    campaign_t *self = user;
    runner_result_t result;
    runlog_t log;
    plant_config_t plant;
    double load_Nm = 0.0;
    self->config.scenario.seed = (double)seed;
    runlog_init(&log);
    const bool good = runner_run(&self->config, runner_estimator(&self->config), &result, &log) &&
                      rig_config_plant(&self->config, &plant, &load_Nm);
    runlog_free(&log);
    if (!good) {
        return false;
    }
    const runner_phase_t *last = &result.phase[result.phases - 1];
    const bool ran = last->error_deg.count > 0;
    case_t one = {
        .passed = !report_run_failed(&result),
        .barred = result.barred,
        .theta0_deg = rig_deg_from_rad(plant.theta_e_rad),
        .load_Nm = load_Nm,
        .Rs_Ohm = plant.Rs_Ohm,
        .Lq_H = plant.Lq_H,
        .J_kgm2 = plant.J_kgm2,
        .handover_s = result.handover_s,
        .speed_rpm = ran ? rig_stats_mean(&last->speed_rpm) : NAN,
        .error_deg = ran ? rig_stats_mean(&last->error_deg) : NAN,
        .error_pp_deg = ran ? rig_stats_peak_to_peak(&last->error_deg) : NAN,
    };
    (void)snprintf(one.verdict, sizeof one.verdict, "%s", verdict(&result));
    memcpy(into, &one, sizeof one);
    return true;
}

static void take_case(void *user, uint64_t seed, const void *from) {
    campaign_t *self = user;
    case_t one;
    memcpy(&one, from, sizeof one);
    (void)progress_end(&self->progress);
    print_case(seed, &one);
    (void)fflush(stdout);
    self->passed += one.passed ? 1u : 0u;
    self->barred = one.barred;
    if (self->cases != NULL) {
        add_case(self->cases, seed, &one);
    }
    const uint64_t first = self->options->seed;
    const uint64_t last = self->options->seed_last;
    progress_show(&self->progress, (double)(seed - first + 1u) / (double)(last - first + 1u),
                  "of the seeds");
}

static bool run_cases(campaign_t *self) {
    const workers_t workers = {.first = self->options->seed,
                               .last = self->options->seed_last,
                               .processes = self->options->jobs,
                               .user = self,
                               .work = run_case,
                               .take = take_case};
    progress_start(&self->progress);
    const bool good = workers_run(&workers);
    (void)progress_end(&self->progress);
    return good;
}

static rig_exit_t finish(const campaign_t *self, FILE *json, cJSON *root) {
    const uint64_t cases = self->options->seed_last - self->options->seed + 1;
    (void)printf("\n%llu of %llu passed%s\n", (unsigned long long)self->passed,
                 (unsigned long long)cases,
                 self->barred ? ""
                              : " (no bars set: passed means no fault, no refused command, and in "
                                "RUN where commanded)");
    if (!self->random && cases > 1u) {
        (void)printf(
            "Nothing in this run is random: that is %llu times the same run. [plant] may spread "
            "values (Rs_spread,\ni_offset_spread_A, theta0_deg = random, ...) or add noise "
            "(i_noise_A); `monte-carlo run --motors F.ini`\ntries many wrong parameters.\n",
            (unsigned long long)cases);
    }
    if (json != NULL) {
        (void)cJSON_AddBoolToObject(root, "random", self->random);
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
    FILE *json = NULL;
    campaign_t self = {.options = options};
    if (options->csv != NULL || options->plot != NULL || capture_wanted(options)) {
        rig_error("run --seeds: expected no --csv, --plot, --ring or --scope; they are for a run "
                  "with one --seed");
        return RIG_BAD_INPUT;
    }
    if (!command_load_run(&self.config, options, options->scenario) ||
        !outputs_open(&json, options->json)) {
        return RIG_BAD_INPUT;
    }
    self.random = rig_config_is_random(&self.config);
    cJSON *root = json != NULL ? cJSON_CreateObject() : NULL;
    self.cases = json != NULL ? cJSON_AddArrayToObject(root, "seeds") : NULL;
    if (!run_cases(&self)) {
        cJSON_Delete(root);
        return RIG_BAD_INPUT;
    }
    return finish(&self, json, root);
}
