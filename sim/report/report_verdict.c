#include "report/report_verdict.h"

#include <math.h>

#include "config/config_json.h"
#include "support/units.h"

static double rpm_of(const lode_drive_config_t *drive, double omega_rad_s) {
    return rig_rpm_from_rad_s(omega_rad_s) / (double)drive->motor.pole_pairs;
}

// ---- Text ---------------------------------------------------------------------------------------

static void print_speeds(FILE *file, const lode_drive_config_t *drive, const design_t *design) {
    const speed_limits_t *speeds = &design->speeds;
    const verdict_t *verdict = &design->verdict;
    (void)fprintf(file, "speeds: %s%.0f .. %.0f rpm; base speed %.0f rpm, voltage limit %.0f",
                  verdict->highest_rad_s < verdict->lowest_rad_s ? "none, " : "",
                  rpm_of(drive, verdict->lowest_rad_s), rpm_of(drive, verdict->highest_rad_s),
                  rpm_of(drive, speeds->base_rad_s), rpm_of(drive, speeds->no_load_rad_s));
    if (isinf(speeds->weakened_rad_s)) {
        (void)fputs(", no voltage limit with field weakening", file);
    } else if (!isnan(speeds->weakened_rad_s)) {
        (void)fprintf(file, ", with field weakening %.0f", rpm_of(drive, speeds->weakened_rad_s));
    } else {
        // the field is not weakened
    }
    (void)fprintf(file, ", estimator limit %.0f\n", rpm_of(drive, speeds->estimator_rad_s));
}

static void print_step(FILE *file, const lode_drive_config_t *drive, const verdict_step_t *step,
                       const char *where) {
    (void)fprintf(file,
                  "largest load step at %s, %.0f rpm: %.3g Nm, %.0f %% of rated torque (%s)\n",
                  where, rpm_of(drive, step->omega_rad_s), step->torque_Nm, 100.0 * step->share,
                  step->by_current ? "limited by i_max" : "limited by the speed dip");
}

static void print_loop(FILE *file, const char *name, double rpm, const analyse_loop_t *loop) {
    if (isnan(loop->crossover_rad_s)) {
        (void)fprintf(file, "%-16s %8.0f          -       -\n", name, rpm);
    } else {
        (void)fprintf(file, "%-16s %8.0f %10.1f %7.1f\n", name, rpm, loop->crossover_rad_s,
                      loop->phase_deg);
    }
}

static void print_loops(FILE *file, const lode_drive_config_t *drive, const verdict_t *verdict) {
    (void)fputs("loop                  rpm  crossover  margin\n"
                "                            rad/s     deg\n",
                file);
    for (int k = 0; k < VERDICT_SPEEDS; ++k) {
        const double rpm = rpm_of(drive, verdict->loop_rad_s[k]);
        print_loop(file, "current control", rpm, &verdict->loop[k].current);
        print_loop(file, "PLL", rpm, &verdict->loop[k].pll);
        print_loop(file, "speed control", rpm, &verdict->loop[k].speed);
    }
}

void report_verdict_text(FILE *file, const lode_drive_config_t *drive, const design_t *design) {
    const verdict_t *verdict = &design->verdict;
    (void)fputs("\nverdict\n", file);
    print_speeds(file, drive, design);
    print_step(file, drive, &verdict->step[VERDICT_LOW], "hand-over speed");
    print_step(file, drive, &verdict->step[VERDICT_HIGH],
               design->speeds.base_rad_s > design->speeds.estimator_rad_s ? "the estimator's limit"
                                                                          : "base speed");
    (void)fprintf(file, "rated torque: %.3g Nm, at i_max/%g and id = 0\n", verdict->rated_torque_Nm,
                  SPEED_LIMITS_CONTROL);
    print_loops(file, drive, verdict);
    const int doubts = plausible_print_doubts(file, &design->plausible);
    for (int k = 0; k < verdict->changes; ++k) {
        (void)fprintf(file, "change: %s: %s\n", verdict->change[k].text, verdict->change[k].help);
    }
    if (doubts == 0 && verdict->changes == 0) {
        (void)fputs("nothing to change\n", file);
    }
}

// ---- JSON ---------------------------------------------------------------------------------------

static void add_step(cJSON *object, const char *name, const lode_drive_config_t *drive,
                     const verdict_step_t *step) {
    cJSON *item = cJSON_AddObjectToObject(object, name);
    config_json_number(item, "speed_rpm", rpm_of(drive, step->omega_rad_s));
    config_json_number(item, "torque_Nm", step->torque_Nm);
    config_json_number(item, "share", step->share);
    (void)cJSON_AddStringToObject(item, "bound_by", step->by_current ? "current" : "speed");
}

static void add_loop(cJSON *array, const char *name, double rpm, const analyse_loop_t *loop) {
    cJSON *item = config_json_item(array);
    (void)cJSON_AddStringToObject(item, "loop", name);
    config_json_number(item, "speed_rpm", rpm);
    config_json_number(item, "crossover_rad_s", loop->crossover_rad_s);
    config_json_number(item, "phase_margin_deg", loop->phase_deg);
}

static void add_change(cJSON *array, const verdict_change_t *change) {
    char text[VERDICT_TEXT + VERDICT_HELP + 2];
    cJSON *item = config_json_item(array);
    (void)snprintf(text, sizeof text, "%s: %s", change->text, change->help);
    (void)cJSON_AddStringToObject(item, "key", change->key);
    (void)cJSON_AddStringToObject(item, "text", text);
    cJSON *ways = cJSON_AddArrayToObject(item, "ways");
    for (int way = 0; way < change->ways; ++way) {
        const verdict_way_t *found = &change->way[way];
        cJSON *sets = cJSON_CreateArray();
        for (int k = 0; k < found->assignments; ++k) {
            (void)cJSON_AddItemToArray(sets, cJSON_CreateString(found->assignment[k]));
        }
        (void)cJSON_AddItemToArray(ways, sets);
    }
}

void report_verdict_json(cJSON *root, const lode_drive_config_t *drive, const design_t *design) {
    const verdict_t *verdict = &design->verdict;
    cJSON *object = cJSON_AddObjectToObject(root, "verdict");
    config_json_number(object, "lowest_rpm", rpm_of(drive, verdict->lowest_rad_s));
    config_json_number(object, "highest_rpm", rpm_of(drive, verdict->highest_rad_s));
    config_json_number(object, "base_speed_rpm", rpm_of(drive, design->speeds.base_rad_s));
    config_json_number(object, "rated_torque_speed_rpm",
                       rpm_of(drive, design->speeds.rated_torque_rad_s));
    config_json_number(object, "weakened_limit_rpm", rpm_of(drive, design->speeds.weakened_rad_s));
    config_json_number(object, "estimator_limit_rpm",
                       rpm_of(drive, design->speeds.estimator_rad_s));
    config_json_number(object, "rated_torque_Nm", verdict->rated_torque_Nm);
    add_step(object, "step_at_handover", drive, &verdict->step[VERDICT_LOW]);
    add_step(object, "step_at_base", drive, &verdict->step[VERDICT_HIGH]);
    cJSON *loops = cJSON_AddArrayToObject(object, "loops");
    for (int k = 0; k < VERDICT_SPEEDS; ++k) {
        const double rpm = rpm_of(drive, verdict->loop_rad_s[k]);
        add_loop(loops, "current", rpm, &verdict->loop[k].current);
        add_loop(loops, "pll", rpm, &verdict->loop[k].pll);
        add_loop(loops, "speed", rpm, &verdict->loop[k].speed);
    }
    cJSON *changes = cJSON_AddArrayToObject(object, "changes");
    for (int k = 0; k < verdict->changes; ++k) {
        add_change(changes, &verdict->change[k]);
    }
}
