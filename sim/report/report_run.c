#include "report/report_run.h"

#include <math.h>
#include <string.h>

#include "config/config_json.h"
#include "config/schema.h"
#include "support/fault_text.h"

const runner_phase_t *report_run_refused(const runner_result_t *result) {
    for (int k = 0; k < result->phases; ++k) {
        if (result->phase[k].refused) {
            return &result->phase[k];
        }
    }
    return NULL;
}

bool report_run_failed(const runner_result_t *result) {
    const bool faulted = result->fault.check != LODE_CHECK_NONE && !result->fault_expected;
    return faulted || result->missed || result->never_ran || result->starts_yet ||
           report_run_refused(result) != NULL;
}

static int warnings_of(const runner_result_t *result) {
    int warnings = 0;
    for (int k = 0; k < result->phases; ++k) {
        warnings += result->phase[k].warnings;
    }
    return warnings;
}

const char *report_mode_name(lode_mode_t mode) {
    const char *name = lode_mode_name(mode);
    const char *prefix = "LODE_MODE_";
    return strncmp(name, prefix, strlen(prefix)) == 0 ? name + strlen(prefix) : name;
}

// ---- Table --------------------------------------------------------------------------------------

/// A number in a column of the table, or a dash.
static void cell(FILE *file, int width, int decimals, double value) {
    if (isnan(value)) {
        (void)fprintf(file, " %*s", width, "-");
    } else {
        (void)fprintf(file, " %*.*f", width, decimals, value);
    }
}

static void print_phase(FILE *file, const runner_phase_t *phase) {
    (void)fprintf(file, "%-18s %6.2f %6.2f", phase->name, phase->start_s, phase->end_s);
    const double wanted_rpm = phase->speed_command_rpm;
    cell(file, 7, fabs(wanted_rpm - round(wanted_rpm)) < 0.05 ? 0 : 1, wanted_rpm);
    cell(file, 8, 1, rig_stats_mean(&phase->speed_rpm));
    cell(file, 6, 1, rig_stats_peak_to_peak(&phase->speed_rpm));
    cell(file, 6, 2, phase->load_Nm);
    cell(file, 7, 3, rig_stats_mean(&phase->error_deg));
    cell(file, 6, 2, rig_stats_peak_to_peak(&phase->error_deg));
    cell(file, 6, 2, rig_stats_peak(&phase->run_error_deg));
    cell(file, 6, 2, rig_stats_rms(&phase->id_A));
    cell(file, 6, 2, rig_stats_rms(&phase->iq_A));
    cell(file, 5, 2, rig_stats_min(&phase->run_lock));
    (void)fprintf(file, "  %s\n", report_mode_name(phase->mode));
    if (!isnan(phase->Lq_off_percent)) {
        (void)fprintf(file, "    learned: Lq %+.1f %% from the motor's value, confidence %.2f\n",
                      phase->Lq_off_percent, phase->Lq_confidence);
    }
    if (!isnan(phase->battery_A)) {
        (void)fprintf(file,
                      "    supply: at most %.2f A drawn, %.2f A fed back, bus at most %.1f V\n",
                      fmax(phase->battery_A, 0.0), fmax(phase->regen_A, 0.0), phase->v_bus_V);
    }
    if (!isnan(phase->heat)) {
        (void)fprintf(
            file,
            "    derating: winding at most %.2f of its continuous heat, torque down to %.0f %%\n",
            phase->heat, 100.0 * phase->derated_share);
    }
    if (phase->missed[0] != '\0') {
        (void)fprintf(file, "    BAR MISSED: %s\n", phase->missed);
    }
    if (phase->warning[0] != '\0') {
        (void)fprintf(file, "    warning: %s\n", phase->warning);
    }
}

static void print_events(FILE *file, const runlog_t *log) {
    (void)fputs("\nevents\n", file);
    for (int k = 0; k < log->events; ++k) {
        (void)fprintf(file, "%9.4f s  %s\n", log->event[k].t_s, log->event[k].text);
    }
    if (log->events_dropped > 0) {
        (void)fprintf(file, "            ... and %d more\n", log->events_dropped);
    }
}

typedef struct {
    const char *name, *unit;
    bool on;
    lode_adapted_t found;
    double configured;
} adapted_row_t;

enum { ADAPTED = 4 };

static void adapted_rows(adapted_row_t row[ADAPTED], const rig_config_t *config,
                         const runner_result_t *result) {
    const lode_motor_t *motor = &config->drive.motor;
    const rig_adaptation_t *wanted = &config->adaptation;
    const lode_telemetry_t *last = &result->last;
    row[0] =
        (adapted_row_t){"J", "kgm2", wanted->J == 1, last->motor.J_kgm2, (double)motor->J_kgm2};
    row[1] =
        (adapted_row_t){"psi", "Wb", wanted->psi == 1, last->motor.psi_Wb, (double)motor->psi_Wb};
    row[2] =
        (adapted_row_t){"Rs", "Ohm", wanted->Rs == 1, last->motor.Rs_Ohm, (double)motor->Rs_Ohm};
    row[3] = (adapted_row_t){"Lq", "H", result->learns, last->motor.Lq_H, (double)motor->Lq_H};
}

static void print_adaptation(FILE *file, const rig_config_t *config,
                             const runner_result_t *result) {
    adapted_row_t row[ADAPTED];
    if (!result->adapts && !result->learns) {
        return;
    }
    adapted_rows(row, config, result);
    (void)fputs("\nadapted     configured       found  confidence\n", file);
    for (int k = 0; k < ADAPTED; ++k) {
        if (row[k].on) {
            (void)fprintf(file, "%-4s %-4s %12.4g %11.4g %11.2f\n", row[k].name, row[k].unit,
                          row[k].configured, (double)row[k].found.value,
                          (double)row[k].found.confidence);
        }
    }
}

static const char *verdict(const runner_result_t *result) {
    if (report_run_failed(result)) {
        return "FAILED";
    }
    return result->barred ? "passed" : "done, no bars set";
}

/// The events show after which of these faults the drive was started again.
static void print_log(FILE *file, const runner_result_t *result) {
    if (result->faults == 0 || !result->supervised) {
        return;
    }
    (void)fputs("\nthe drive's fault log\n", file);
    for (int k = 0; k < result->faults; ++k) {
        const runner_fault_t *logged = &result->logged[k];
        char what[120];
        fault_text(&logged->fault, what, sizeof what);
        (void)fprintf(file, "%9.4f s  %-9s %s\n", logged->t_s,
                      report_mode_name((lode_mode_t)logged->fault.state), what);
    }
}

static void print_verdict(FILE *file, const runner_result_t *result) {
    if (result->fault.check != LODE_CHECK_NONE) {
        char what[120];
        fault_text(&result->fault, what, sizeof what);
        (void)fprintf(file, "\nFAULT at %.4f s in %s: %s%s\n", result->fault_s,
                      report_mode_name((lode_mode_t)result->fault.state), what,
                      result->fault_expected ? " (as the scenario expects)" : "");
        const char *hint = fault_text_hint(&result->fault);
        if (hint != NULL && !result->fault_expected) {
            (void)fprintf(file, "look at: %s\n", hint);
        }
        if (result->retries > 0) {
            (void)fprintf(file, "start attempts that had failed before: %d\n", result->retries);
        }
    }
    if (result->never_ran) {
        (void)fprintf(file, "\nRUN was commanded and never reached; %s at the end\n",
                      report_mode_name(result->phase[result->phases - 1].mode));
    }
    if (result->starts_yet) {
        (void)fprintf(file, "\nRUN was lost and not reached again: %d start attempts failed\n",
                      result->retries);
    }
    if (report_run_refused(result) != NULL) {
        (void)fprintf(file, "\nthe drive has refused a command, first in phase %s\n",
                      report_run_refused(result)->name);
    }
    (void)fprintf(file,
                  "\n%s: %.2f s of drive simulated in %.2f s on one core: %.0f times real time",
                  verdict(result), result->simulated_s, result->processor_s,
                  result->simulated_s / result->processor_s);
    const int warnings = warnings_of(result);
    if (warnings > 0) {
        (void)fprintf(file, "; %d warning%s above", warnings, warnings > 1 ? "s" : "");
    }
    (void)fputc('\n', file);
}

static void key_text(const rig_config_t *config, const char *key, char *text, size_t size) {
    const rig_schema_t schema = rig_schema();
    rig_key_print(&schema.row[rig_schema_find(schema, "estimator", key)], config, text, size);
}

static void print_heading(FILE *file, const rig_config_t *config) {
    const lode_drive_config_t *drive = &config->drive;
    char emf[RIG_NAME_LENGTH];
    char pll[RIG_NAME_LENGTH];
    key_text(config, "emf", emf, sizeof emf);
    key_text(config, "pll", pll, sizeof pll);
    (void)fprintf(
        file, "%s: %s%g pole pairs, %g Hz, %g V bus, %s inverter, %s and %s%s, seed %.0f\n\n",
        config->files > 0 ? config->file[0] : "", rig_config_is_six(config) ? "six phases, " : "",
        (double)drive->motor.pole_pairs, (double)drive->f_pwm_Hz, (double)drive->inverter.v_bus_V,
        config->plant.inverter == (int)PLANT_SWITCHING ? "switched" : "ideal", emf, pll,
        config->source == RIG_SOURCE_TRUTH     ? " unused: driven by the true angle"
        : config->source == RIG_SOURCE_ENCODER ? " with an angle sensor"
                                               : "",
        config->scenario.seed);
}

void report_run_table(FILE *file, const rig_config_t *config, const runner_result_t *result,
                      const runlog_t *log) {
    print_heading(file, config);
    (void)fputs("phase                from     to   speed [rpm]             load  angle error [deg]"
                "      id     iq   lock  mode\n"
                "                        s      s  wanted     mean     pp     Nm    mean     pp"
                "    max  A rms  A rms   min  at end\n",
                file);
    for (int k = 0; k < result->phases; ++k) {
        print_phase(file, &result->phase[k]);
    }
    (void)fprintf(
        file,
        "mean, pp (max - min) and rms: last %.1f s of a phase; max, lock: the whole phase "
        "while in RUN; angles electrical\n",
        RUNNER_WINDOW_s);
    print_adaptation(file, config, result);
    print_events(file, log);
    print_log(file, result);
    print_verdict(file, result);
}

// ---- CSV ----------------------------------------------------------------------------------------

/// The names, or the values of a row.
static void write_line(FILE *file, const runlog_t *log, const runlog_row_t *row) {
    for (const runlog_column_t *column = runlog_columns; column->name != NULL; ++column) {
        const char *gap = column == runlog_columns ? "" : ",";
        if (!runlog_has(log, column)) {
            continue;
        }
        if (row == NULL) {
            (void)fprintf(file, "%s%s", gap, column->name);
        } else {
            (void)fprintf(file, "%s%.*g", gap, column->digits, runlog_value(row, column));
        }
    }
    (void)fputc('\n', file);
}

void report_run_csv(FILE *file, const runlog_t *log) {
    write_line(file, log, NULL);
    for (size_t k = 0; k < log->rows; ++k) {
        write_line(file, log, &log->row[k]);
    }
}

// ---- JSON ---------------------------------------------------------------------------------------

static void add_stats(cJSON *object, const char *name, const rig_stats_t *stats) {
    cJSON *item = cJSON_AddObjectToObject(object, name);
    config_json_number(item, "mean", rig_stats_mean(stats));
    config_json_number(item, "pp", rig_stats_peak_to_peak(stats));
    config_json_number(item, "min", rig_stats_min(stats));
    config_json_number(item, "max", rig_stats_max(stats));
    config_json_number(item, "rms", rig_stats_rms(stats));
}

static void add_phase(cJSON *array, const runner_phase_t *phase) {
    cJSON *item = config_json_item(array);
    (void)cJSON_AddStringToObject(item, "name", phase->name);
    config_json_number(item, "start_s", phase->start_s);
    config_json_number(item, "end_s", phase->end_s);
    config_json_number(item, "speed_command_rpm", phase->speed_command_rpm);
    config_json_number(item, "load_Nm", phase->load_Nm);
    add_stats(item, "speed_rpm", &phase->speed_rpm);
    add_stats(item, "speed_error_rpm", &phase->speed_error_rpm);
    add_stats(item, "angle_error_deg", &phase->error_deg);
    config_json_number(item, "angle_error_max_deg", rig_stats_peak(&phase->run_error_deg));
    add_stats(item, "id_A", &phase->id_A);
    add_stats(item, "iq_A", &phase->iq_A);
    add_stats(item, "load_est_Nm", &phase->load_est_Nm);
    add_stats(item, "torque_Nm", &phase->torque_Nm);
    add_stats(item, "i_xy_A", &phase->i_xy_A);
    config_json_number(item, "lock_min", rig_stats_min(&phase->run_lock));
    config_json_number(item, "Lq_off_percent", phase->Lq_off_percent);
    config_json_number(item, "Lq_confidence", phase->Lq_confidence);
    config_json_number(item, "battery_A", phase->battery_A);
    config_json_number(item, "regen_A", phase->regen_A);
    config_json_number(item, "v_bus_max_V", phase->v_bus_V);
    config_json_number(item, "winding_heat_max", phase->heat);
    config_json_number(item, "derated_share_min", phase->derated_share);
    (void)cJSON_AddStringToObject(item, "mode", report_mode_name(phase->mode));
    (void)cJSON_AddStringToObject(item, "missed", phase->missed);
    (void)cJSON_AddStringToObject(item, "warning", phase->warning);
}

static void describe_fault(cJSON *item, double t_s, const lode_fault_t *fault) {
    config_json_number(item, "t_s", t_s);
    (void)cJSON_AddStringToObject(item, "state", report_mode_name((lode_mode_t)fault->state));
    (void)cJSON_AddStringToObject(item, "check", lode_check_name((lode_check_t)fault->check));
    config_json_number(item, "measured", (double)fault->measured);
    config_json_number(item, "limit", (double)fault->limit);
    (void)cJSON_AddStringToObject(item, "stage", fault_text_stage(fault));
    (void)cJSON_AddStringToObject(item, "criterion", fault_text_criterion(fault));
}

static void add_fault(cJSON *root, const runner_result_t *result) {
    if (result->fault.check == LODE_CHECK_NONE) {
        (void)cJSON_AddNullToObject(root, "fault");
        return;
    }
    describe_fault(cJSON_AddObjectToObject(root, "fault"), result->fault_s, &result->fault);
}

static void add_log(cJSON *root, const runner_result_t *result) {
    cJSON *faults = cJSON_AddArrayToObject(root, "fault_log");
    for (int k = 0; k < result->faults; ++k) {
        describe_fault(config_json_item(faults), result->logged[k].t_s, &result->logged[k].fault);
    }
}

static void add_adaptation(cJSON *root, const rig_config_t *config, const runner_result_t *result) {
    adapted_row_t row[ADAPTED];
    if (!result->adapts && !result->learns) {
        return;
    }
    adapted_rows(row, config, result);
    cJSON *all = cJSON_AddObjectToObject(root, "adapted");
    for (int k = 0; k < ADAPTED; ++k) {
        if (row[k].on) {
            cJSON *item = cJSON_AddObjectToObject(all, row[k].name);
            config_json_number(item, "configured", row[k].configured);
            config_json_number(item, "value", (double)row[k].found.value);
            config_json_number(item, "confidence", (double)row[k].found.confidence);
        }
    }
}

void report_run_json(FILE *file, const rig_config_t *config, const runner_result_t *result,
                     const runlog_t *log) {
    cJSON *root = config_json_root();
    (void)cJSON_AddStringToObject(root, "scenario", config->files > 0 ? config->file[0] : "");
    (void)cJSON_AddBoolToObject(root, "passed", !report_run_failed(result));
    (void)cJSON_AddBoolToObject(root, "bars_set", result->barred);
    config_json_number(root, "window_s", RUNNER_WINDOW_s);
    config_json_number(root, "handover_s", result->handover_s);
    (void)cJSON_AddBoolToObject(root, "never_ran", result->never_ran);
    (void)cJSON_AddBoolToObject(root, "starts_yet", result->starts_yet);
    (void)cJSON_AddBoolToObject(root, "refused", report_run_refused(result) != NULL);
    config_json_number(root, "warnings", (double)warnings_of(result));
    config_json_number(root, "retries", result->retries);
    config_json_number(root, "simulated_s", result->simulated_s);
    config_json_number(root, "times_real_time", result->simulated_s / result->processor_s);
    add_fault(root, result);
    add_log(root, result);
    add_adaptation(root, config, result);
    cJSON *phases = cJSON_AddArrayToObject(root, "phases");
    for (int k = 0; k < result->phases; ++k) {
        add_phase(phases, &result->phase[k]);
    }
    cJSON *events = cJSON_AddArrayToObject(root, "events");
    for (int k = 0; k < log->events; ++k) {
        cJSON *item = config_json_item(events);
        config_json_number(item, "t_s", log->event[k].t_s);
        (void)cJSON_AddStringToObject(item, "text", log->event[k].text);
    }
    (void)cJSON_AddItemToObject(root, "assumed", config_json_assumed(config));
    (void)cJSON_AddItemToObject(root, "config", config_json(config));
    (void)config_json_write(file, root);
}
