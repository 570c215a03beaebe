#include "report/report_replay.h"

#include <math.h>
#include <string.h>

#include "config/config_json.h"
#include "config/ini_config.h"
#include "config/schema.h"
#include "support/units.h"

static double electrical_rpm(const rig_config_t *config, double rad_s) {
    return rig_rpm_from_rad_s(rad_s) / (double)config->drive.motor.pole_pairs;
}

// ---- Text ---------------------------------------------------------------------------------------

static bool matters(const rig_key_t *key) {
    static const char *const of_drive[] = {"f_pwm_Hz", "v_bus_V", "i_max_A"};
    if (strcmp(key->section, "motor") == 0) {
        return true;
    }
    if (strcmp(key->section, "estimator") == 0) {
        return strcmp(key->key, "source") != 0;
    }
    for (size_t k = 0; k < sizeof of_drive / sizeof of_drive[0]; ++k) {
        if (strcmp(key->section, "drive") == 0 && strcmp(key->key, of_drive[k]) == 0) {
            return true;
        }
    }
    return false;
}

void report_replay_values(FILE *file, const rig_config_t *config) {
    const rig_schema_t schema = rig_schema();
    (void)fputs("values used\n", file);
    for (int k = 0; k < schema.rows; ++k) {
        char value[RIG_PATH_LENGTH];
        char where[RIG_PATH_LENGTH + 16];
        rig_key_print(&schema.row[k], config, value, sizeof value);
        if (!matters(&schema.row[k]) || value[0] == '\0') {
            continue;
        }
        ini_config_where(config, k, where, sizeof where);
        (void)fprintf(file, "  [%s] %s = %s  (%s)\n", schema.row[k].section, schema.row[k].key,
                      value, where);
    }
}

void report_replay_table(FILE *file, const rig_config_t *config, const recording_t *recording,
                         const replay_t *replay) {
    (void)fprintf(file, "\n%zu rows, %.6g s, every %.6g us\n", recording->rows,
                  recording->row[recording->rows - 1].t_s - recording->row[0].t_s,
                  1e6 * recording->ts_s);
    if (recording->resampled > 0) {
        (void)fprintf(file, "resampled from %zu rows of the file\n", recording->resampled);
    }
    if (recording->gaps > 0) {
        (void)fprintf(file, "gaps: %zu, %.6g s in all; the estimator restarts after each\n",
                      recording->gaps, recording->gaps_s);
    }
    if (replay->off > 0) {
        (void)fprintf(file,
                      "gates off: %zu rows without an estimate (no voltage; current 0, or held "
                      "since the trip)\n",
                      replay->off);
    }
    const lode_estimate_t *last = &replay->row[replay->rows - 1];
    (void)fprintf(file, "at the end: speed %.2f rpm, lock %.3f; reacquired %zu times\n",
                  electrical_rpm(config, (double)last->omega_rad_s), (double)last->lock,
                  replay->reseeds);
    if (recording->has_theta) {
        (void)fprintf(
            file,
            "angle error (estimate - truth, electrical degrees)\n"
            "  last %.1f s: mean %.4f, pp %.4f\n  later than %.1f s after each start: max %.4f\n",
            REPLAY_WINDOW_s, rig_stats_mean(&replay->error_window_deg),
            rig_stats_peak_to_peak(&replay->error_window_deg), REPLAY_SETTLE_s,
            rig_stats_peak(&replay->error_settled_deg));
        (void)fprintf(file, "  while locked (lock at least %g): mean %.4f, max %.4f\n",
                      (double)LODE_LOCK_LOST, rig_stats_mean(&replay->error_locked_deg),
                      rig_stats_peak(&replay->error_locked_deg));
        if (isnan(replay->close_after_s)) {
            (void)fprintf(file, "  does not stay below %g degree\n", REPLAY_CLOSE_deg);
        } else {
            (void)fprintf(file, "  stays below %g degree from %.4f s on\n", REPLAY_CLOSE_deg,
                          replay->close_after_s);
        }
    } else {
        (void)fputs("no column theta_e_rad: no angle to compare with\n", file);
    }
    if (recording->has_omega) {
        (void)fprintf(
            file,
            "speed error (estimate - truth, rpm)\n  last %.1f s: mean %.4f\n  later than %.1f s "
            "after each start: max %.4f\n",
            REPLAY_WINDOW_s, electrical_rpm(config, rig_stats_mean(&replay->speed_window_rad_s)),
            REPLAY_SETTLE_s, electrical_rpm(config, rig_stats_peak(&replay->speed_settled_rad_s)));
    }
}

// ---- Files --------------------------------------------------------------------------------------

void report_replay_csv(FILE *file, const recording_t *recording, const replay_t *replay) {
    (void)fputs("t_s,theta_e_rad,omega_e_rad_s,e_alpha_V,e_beta_V,lock\n", file);
    for (size_t k = 0; k < replay->rows; ++k) {
        const lode_estimate_t *row = &replay->row[k];
        (void)fprintf(file, "%.12g,%.9g,%.9g,%.9g,%.9g,%.9g\n", recording->row[k].t_s,
                      (double)lode_estimate_theta_rad(row), (double)row->omega_rad_s,
                      (double)row->e_V.alpha, (double)row->e_V.beta, (double)row->lock);
    }
}

void report_replay_json(FILE *file, const rig_config_t *config, const char *recording_path,
                        const recording_t *recording, const replay_t *replay) {
    cJSON *root = config_json_root();
    (void)cJSON_AddStringToObject(root, "recording", recording_path);
    config_json_number(root, "rows", (double)replay->rows);
    config_json_number(root, "ts_s", recording->ts_s);
    config_json_number(root, "gaps", (double)recording->gaps);
    config_json_number(root, "gaps_s", recording->gaps_s);
    config_json_number(root, "resampled_rows", (double)recording->resampled);
    config_json_number(root, "angle_error_mean_deg", rig_stats_mean(&replay->error_window_deg));
    config_json_number(root, "angle_error_pp_deg",
                       rig_stats_peak_to_peak(&replay->error_window_deg));
    config_json_number(root, "angle_error_max_deg", rig_stats_peak(&replay->error_settled_deg));
    config_json_number(root, "angle_error_locked_mean_deg",
                       rig_stats_mean(&replay->error_locked_deg));
    config_json_number(root, "angle_error_locked_max_deg",
                       rig_stats_peak(&replay->error_locked_deg));
    config_json_number(root, "below_1_deg_after_s", replay->close_after_s);
    config_json_number(root, "speed_error_mean_rad_s", rig_stats_mean(&replay->speed_window_rad_s));
    config_json_number(root, "speed_error_max_rad_s", rig_stats_peak(&replay->speed_settled_rad_s));
    config_json_number(root, "lock_at_end", (double)replay->row[replay->rows - 1].lock);
    config_json_number(root, "reseeds", (double)replay->reseeds);
    (void)cJSON_AddItemToObject(root, "assumed", config_json_assumed(config));
    (void)cJSON_AddItemToObject(root, "config", config_json(config));
    (void)config_json_write(file, root);
}
