#include "commands/command_commission.h"

#include <math.h>
#include <stdio.h>

#include "commands/command_load.h"
#include "config/config_json.h"
#include "rig/commission.h"
#include "support/atomic_file.h"
#include "support/outputs.h"

#define MAIN_SCENARIO "main"

static void print_table(FILE *file, const commission_run_t *run) {
    const lode_commission_t *own = &run->commission;
    (void)fprintf(file, "%-16s %14s %10s %14s %9s\n", "quantity", "value", "confidence", "plant",
                  "off by %");
    for (int k = 0; k < LODE_COMMISSION_QUANTITIES; ++k) {
        const lode_commission_value_t *found = &own->found[k];
        const char *name = lode_commission_name((lode_commission_quantity_t)k);
        if (!(found->confidence > 0.0f)) {
            (void)fprintf(file, "%-16s %14s\n", name, "not measured");
            continue;
        }
        (void)fprintf(file, "%-16s %14.6g %10.2f %14.6g", name, (double)found->value,
                      (double)found->confidence, run->truth[k]);
        if (fabs(run->truth[k]) > 0.0) {
            (void)fprintf(file, " %9.2f", 100.0 * ((double)found->value / run->truth[k] - 1.0));
        }
        (void)fputc('\n', file);
    }
    (void)fprintf(file, "\nlargest current %.4g A of %.4g A\n", run->i_max_A,
                  (double)own->config.inverter.i_max_A);
}

/// Why it did not come to its end.
static void print_failure(FILE *file, const commission_run_t *run) {
    const lode_commission_t *own = &run->commission;
    const char *name = lode_commission_name(own->quantity);
    switch (own->result) {
    case LODE_COMMISSION_FAULT:
        (void)fprintf(file, "%s, measured %.4g, limit %.4g, while looking for %s\n",
                      lode_check_name(own->drive.guard.fault.check),
                      (double)own->drive.guard.fault.measured, (double)own->drive.guard.fault.limit,
                      name);
        break;
    case LODE_COMMISSION_REFUSED:
        (void)fprintf(file, "the drive refuses what was found at standstill: %s\n",
                      lode_status_name(own->status));
        break;
    case LODE_COMMISSION_UNSURE:
        (void)fprintf(file, "%s: confidence %.2f, needed %.2f\n", name,
                      (double)own->found[own->quantity].confidence, (double)LODE_COMMISSION_SURE);
        break;
    case LODE_COMMISSION_RUNNING:
    case LODE_COMMISSION_DONE:
    case LODE_COMMISSION_NO_CURRENT:
    case LODE_COMMISSION_UNSETTLED:
    case LODE_COMMISSION_NO_START:
    default:
        (void)fprintf(file, "while looking for %s\n", name);
        break;
    }
}

/// A motor file that the tool reads.
static void print_motor(FILE *file, const lode_commission_t *own) {
    const lode_drive_config_t *config = lode_commission_config(own);
    const lode_motor_t *motor = &config->motor;
    (void)fprintf(file, "; Measured by lodestar commission\n[motor]\npole_pairs = %g\n",
                  (double)motor->pole_pairs);
    (void)fprintf(file, "Rs_Ohm = %.6g\nLd_H = %.6g\nLq_H = %.6g\npsi_Wb = %.6g\n",
                  (double)motor->Rs_Ohm, (double)motor->Ld_H, (double)motor->Lq_H,
                  (double)motor->psi_Wb);
    (void)fprintf(file, "J_kgm2 = %.6g\nB_Nms = %.6g\n", (double)motor->J_kgm2,
                  (double)motor->B_Nms);
    (void)fprintf(file, "[drive]\ndead_time_s = %.6g\n", (double)config->inverter.dead_time_s);
}

static void print_json(FILE *file, const lode_commission_t *own) {
    cJSON *root = cJSON_CreateObject();
    for (int k = 0; k < LODE_COMMISSION_QUANTITIES; ++k) {
        const bool known = own->found[k].confidence > 0.0f;
        cJSON *item =
            cJSON_AddObjectToObject(root, lode_commission_name((lode_commission_quantity_t)k));
        config_json_number(item, "value", known ? (double)own->found[k].value : NAN);
        config_json_number(item, "confidence", (double)own->found[k].confidence);
    }
    (void)config_json_write(file, root);
}

rig_exit_t command_commission(const options_t *options) {
    static commission_run_t run;
    rig_config_t config;
    FILE *json = NULL, *out = NULL;
    const char *scenario = options->scenario;
    if (scenario == NULL && options->motor == NULL) {
        scenario = MAIN_SCENARIO;
    }
    if (!command_load_run(&config, options, scenario)) {
        return RIG_BAD_INPUT;
    }
    if (rig_config_is_six(&config)) {
        rig_error("commission: expected a motor with three phases; [motor] sets = 2 has six");
        return RIG_BAD_INPUT;
    }
    if (!outputs_open(&json, options->json) || !outputs_open(&out, options->out) ||
        !commission_run(&run, &config)) {
        return RIG_BAD_INPUT;
    }
    const lode_commission_t *own = &run.commission;
    const bool done = own->result == LODE_COMMISSION_DONE;
    print_table(stdout, &run);
    if (json != NULL) {
        print_json(json, own);
    }
    if (out != NULL && done) {
        print_motor(out, own);
    }
    (void)printf("%s after %.2f s", lode_commission_result_name(own->result), run.took_s);
    if (done) {
        (void)putchar('\n');
    } else {
        (void)printf(": ");
        print_failure(stdout, &run);
    }
    if (!done && out != NULL) {
        // nothing is kept of what is not whole
        atomic_file_discard_all();
        return RIG_FAILED;
    }
    if (!atomic_file_commit_all()) {
        return RIG_BAD_INPUT;
    }
    outputs_say(options->json);
    outputs_say(options->out);
    return done ? RIG_DONE : RIG_FAILED;
}
