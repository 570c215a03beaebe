#include "commands/command_commission.h"

#include <math.h>
#include <stdio.h>

#include "commands/command_load.h"
#include "commands/command_source.h"
#include "config/config_json.h"
#include "config/ini_write.h"
#include "rig/commission.h"
#include "support/atomic_file.h"
#include "support/fault_text.h"
#include "support/outputs.h"
#include "support/units.h"

#define MAIN_SCENARIO "main"

/// False for the quantities that only a six-phase motor has, if it has three.
static bool has(const commission_run_t *run, int quantity) {
    const bool of_six =
        (quantity >= LODE_COMMISSION_OFFSET_A2 && quantity <= LODE_COMMISSION_OFFSET_C2) ||
        quantity == LODE_COMMISSION_LXY_H;
    return run->sets > 1 || !of_six;
}

static void print_lowered(FILE *file, const commission_run_t *run) {
    const double np = (double)commission_of(run)->config.motor.pole_pairs;
    if (!isnan(run->lowered_rad_s)) {
        (void)fprintf(
            file,
            "\nlimited by the bus voltage, see `design`: the run was that of a rated speed "
            "of %.0f rpm: up to\n0.7 of it rated torque is possible\n",
            rig_rpm_from_rad_s(run->lowered_rad_s) / np);
    }
}

static void print_table(FILE *file, const commission_run_t *run) {
    const lode_commission_t *own = commission_of(run);
    (void)fprintf(file, "%-16s %14s %10s %14s %9s\n", "quantity", "value", "confidence", "plant",
                  "off by %");
    for (int k = 0; k < LODE_COMMISSION_QUANTITIES; ++k) {
        if (!has(run, k)) {
            continue;
        }
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
        if (found->confidence < LODE_COMMISSION_SURE) {
            (void)fputs(fabs(run->truth[k]) > 0.0 ? "  unsure: not used"
                                                  : "            unsure: not used",
                        file);
        }
        (void)fputc('\n', file);
    }
    print_lowered(file, run);
    (void)fprintf(file, "\nlargest current %.4g A of %.4g A\n", run->i_max_A,
                  (double)own->config.inverter.i_max_A);
}

/// After a start that succeeded, the criterion is that of an earlier attempt.
static void print_no_start(FILE *file, const lode_commission_t *own) {
    char what[120];
    if (own->wanted_rad_s > 0.0f) {
        (void)fprintf(file, "the rotor reached %.4g rad/s instead of %.4g with %.4g Nm, ",
                      (double)own->reached_rad_s, (double)own->wanted_rad_s,
                      (double)own->torque_Nm);
    } else if (own->drive->guard.fault.criterion != (uint_least8_t)LODE_CRITERION_NONE) {
        fault_text(&own->drive->guard.fault, what, sizeof what);
        (void)fprintf(file, "%s, ", what); // the last attempt of its start
    } else {
        // no attempt has ended
    }
}

/// The signals were plausible at rest; resistance and inductances show a wrong gain.
static void print_gain(FILE *file, const lode_commission_t *own) {
    const lode_commission_value_t *Lq_H = &own->found[LODE_COMMISSION_LQ_H];
    if (own->quantity == LODE_COMMISSION_SIGNALS && Lq_H->confidence > 0.0f) {
        (void)fprintf(file,
                      ": resistance, Ld and Lq all differ far from the data sheet, Lq by a factor "
                      "of %.3g; check the gain of the current sensors",
                      (double)(Lq_H->value / own->config.motor.Lq_H));
    }
    (void)fputc('\n', file);
}

/// Why the commissioning did not complete.
static void print_failure(FILE *file, const commission_run_t *run) {
    const lode_commission_t *own = commission_of(run);
    const char *name = lode_commission_name(own->quantity);
    char what[120];
    switch (own->result) {
    case LODE_COMMISSION_FAULT:
        fault_text(&own->drive->guard.fault, what, sizeof what);
        (void)fprintf(file, "%s, while measuring %s\n", what, name);
        break;
    case LODE_COMMISSION_REFUSED:
        (void)fprintf(file, "the drive refuses what was measured, or a command of the run: %s\n",
                      lode_status_name(own->status));
        break;
    case LODE_COMMISSION_UNSURE:
        (void)fprintf(file, "%s: confidence %.2f, at least %.2f needed", name,
                      (double)own->found[own->quantity].confidence, (double)LODE_COMMISSION_SURE);
        print_gain(file, own);
        break;
    case LODE_COMMISSION_NO_START:
        print_no_start(file, own);
        (void)fprintf(file, "while measuring %s\n", name);
        break;
    case LODE_COMMISSION_NO_CURRENT:
        (void)fprintf(file, "%.3g of %.3g A while measuring %s\n", (double)own->reached_A,
                      (double)own->current_A, name);
        break;
    case LODE_COMMISSION_RUNNING:
    case LODE_COMMISSION_DONE:
    case LODE_COMMISSION_UNSETTLED:
    default:
        (void)fprintf(file, "while measuring %s\n", name);
        break;
    }
}

static void print_json(FILE *file, const commission_run_t *run) {
    const lode_commission_t *own = commission_of(run);
    cJSON *root = cJSON_CreateObject();
    for (int k = 0; k < LODE_COMMISSION_QUANTITIES; ++k) {
        if (!has(run, k)) {
            continue;
        }
        const bool known = own->found[k].confidence > 0.0f;
        cJSON *item =
            cJSON_AddObjectToObject(root, lode_commission_name((lode_commission_quantity_t)k));
        config_json_number(item, "value", known ? (double)own->found[k].value : NAN);
        config_json_number(item, "confidence", (double)own->found[k].confidence);
    }
    (void)config_json_write(file, root);
}

typedef struct {
    FILE *json, *out;
    command_source_t source;
} files_t;

static bool open_files(files_t *self, const options_t *options) {
    return outputs_open(&self->json, options->json) && outputs_open(&self->out, options->out) &&
           command_source_open(&self->source, options);
}

/// Writes the drive with the measured values to the files. False after a message if not everything was measured.
static bool print_found(const files_t *files, const options_t *options, const char *motor,
                        const commission_run_t *run, const rig_config_t *config) {
    if (commission_of(run)->result != LODE_COMMISSION_DONE) {
        (void)printf(": ");
        print_failure(stdout, run);
        return false;
    }
    static rig_config_t found;
    lode_drive6_tuning_t tuning;
    commission_found(&found, run, config);
    const lode_status_t status = rig_config_tune(&found, &tuning);
    if (status != LODE_OK) { // the drive itself has checked only the values measured at standstill
        (void)printf(": the drive refuses the measured values: %s\n", lode_status_name(status));
        return false;
    }
    (void)putchar('\n');
    if (files->out != NULL) {
        (void)fputs("; Measured by lodestar commission; all other values are as given\n",
                    files->out);
        ini_write(files->out, &found);
    }
    rig_config_design(&found);
    command_source_print(&files->source, "commission", motor, options, &found, &tuning);
    return true;
}

static bool load(rig_config_t *config, const options_t *options, const char *scenario) {
    if (!command_load_run(config, options, scenario)) {
        return false;
    }
    return options->source == NULL || rig_config_given(config, RIG_NEED_BOARD);
}

rig_exit_t command_commission(const options_t *options) {
    static commission_run_t run;
    rig_config_t config;
    files_t files;
    const char *scenario = options->scenario;
    if (scenario == NULL && options->motor == NULL) {
        scenario = MAIN_SCENARIO;
    }
    if (!load(&config, options, scenario) || !open_files(&files, options) ||
        !commission_run(&run, &config)) {
        return RIG_BAD_INPUT;
    }
    print_table(stdout, &run);
    if (files.json != NULL) {
        print_json(files.json, &run);
    }
    (void)printf("%s after %.2f s", lode_commission_result_name(commission_of(&run)->result),
                 run.took_s);
    const bool whole =
        print_found(&files, options, scenario != NULL ? scenario : options->motor, &run, &config);
    if (!whole && (files.out != NULL || files.source.file != NULL)) {
        // no file is kept if anything is missing
        atomic_file_discard_all();
        return RIG_FAILED;
    }
    if (!atomic_file_commit_all()) {
        return RIG_BAD_INPUT;
    }
    outputs_say(options->json);
    outputs_say(options->out);
    outputs_say(options->source);
    return whole ? RIG_DONE : RIG_FAILED;
}
