#include "design/advice.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "config/ini_config.h"
#include "config/schema.h"

// Up to a factor of 4.3, beyond which the advice would be another drive.
#define RATIO 1.2
enum { STEPS = 8, BISECTIONS = 5, KEYS_MAX = 4, VALUE_LENGTH = 32 };

/// One way to remove a complaint: values that change together by one factor. A key after `=` keeps its value, which
/// would follow the others otherwise.
typedef struct {
    const char *complaint; ///< key of the change
    bool raises;
    const char *key[KEYS_MAX]; ///< as for --set; NULL: no further one
    const char *word;          ///< a choice in place of a number; NULL: none
    const char *besides;       ///< NULL: nothing
} way_t;

#define RAISE(complaint, key)                                                                      \
    { complaint, true, {key}, NULL, NULL }
#define LOWER(complaint, key)                                                                      \
    { complaint, false, {key}, NULL, NULL }
#define CHOOSE(complaint, key, word)                                                               \
    { complaint, true, {key}, word, NULL }
#define COMMANDS " (and the commanded speeds)"
#define W0 "estimator.w0_rad_s"
#define SIGMA "estimator.sigma_rad_s"
#define SIGMA_LOW "estimator.sigma_low_rad_s"

// In the order of preference.
static const way_t ways[] = {
    RAISE("margin_pll", W0),
    {"margin_pll", false, {SIGMA, SIGMA_LOW, "=" W0}, NULL, NULL},
    RAISE("margin_pll", "drive.f_pwm_Hz"),
    LOWER("margin_current", "current.bandwidth_rad_s"),
    LOWER("margin_current", "current.ki_q_V_As"),
    LOWER("margin_current", "current.ki_d_V_As"),
    CHOOSE("margin_current", "current.ki_q_V_As", "auto"),
    CHOOSE("margin_current", "current.ki_d_V_As", "auto"),
    LOWER("margin_current", "current.kp_q_V_A"),
    LOWER("margin_current", "current.kp_d_V_A"),
    LOWER("margin_speed", "speed.bandwidth_rad_s"),
    LOWER("margin_speed", "speed.kp_Nms"),
    LOWER("margin_speed", "speed.gain_rise"),
    LOWER("margin_speed", "speed.ki_Nm"),
    CHOOSE("margin_speed", "speed.ki_Nm", "auto"),
    RAISE("step_at_handover", "drive.i_max_A"),
    RAISE("step_at_handover", "drive.f_pwm_Hz"),
    {"step_at_handover", true, {"speed.omega_min_rad_s"}, NULL, COMMANDS},
    {"step_at_handover", true, {"start.omega_handover_rad_s"}, NULL, COMMANDS},
    RAISE("step_at_handover", "speed.kp_Nms"),
    {"step_at_handover", true, {"speed.kp_Nms", SIGMA_LOW, SIGMA, W0}, NULL, NULL},
    RAISE("step_at_handover", "motor.J_kgm2"),
    RAISE("step_at_base", "drive.i_max_A"),
    RAISE("step_at_base", "speed.gain_rise"),
    RAISE("step_at_base", "speed.kp_Nms"),
    RAISE("step_at_base", "drive.f_pwm_Hz"),
    {"step_at_base", true, {"speed.kp_Nms", SIGMA, "=" SIGMA_LOW, W0}, NULL, NULL},
    RAISE("step_at_base", "motor.J_kgm2"),
    RAISE("rated_above_estimator", "drive.f_pwm_Hz"),
    RAISE("rated_above_estimator", "estimator.omega_max_rad_s"),
    LOWER("rated_above_estimator", "motor.speed_rated_rpm"),
    RAISE("rated_above_voltage", "drive.v_bus_V"),
    RAISE("rated_above_voltage", "references.id_max_A"),
    CHOOSE("rated_above_voltage", "references.field_weakening", "on"),
    LOWER("rated_above_voltage", "motor.speed_rated_rpm"),
    RAISE("rated_torque_above_voltage", "drive.v_bus_V"),
    CHOOSE("rated_torque_above_voltage", "references.field_weakening", "on"),
    LOWER("rated_torque_above_voltage", "motor.speed_rated_rpm"),
    RAISE("base_below_handover", "drive.v_bus_V"),
    LOWER("base_below_handover", "drive.i_max_A"),
};

typedef struct {
    const verdict_t *verdict;
    const rig_config_t *read;
    const rig_config_t *config;
} task_t;

/// One key and the value that it is given.
typedef struct {
    char section[RIG_NAME_LENGTH];
    const char *key;
    const char *name; ///< section.key
    bool kept;
    char value[VALUE_LENGTH];
} setting_t;

/// As a user would type it: three digits.
static void print_value(char *text, double value) {
    char digits[VALUE_LENGTH];
    double rounded = 0.0;
    (void)snprintf(digits, sizeof digits, "%.2e", value);
    (void)sscanf(digits, "%lf", &rounded);
    (void)snprintf(text, VALUE_LENGTH, "%.6g", rounded);
}

static setting_t split(const char *name) {
    setting_t setting = {.kept = name[0] == '='};
    const char *from = name + (setting.kept ? 1 : 0);
    const char *dot = strchr(from, '.');
    (void)snprintf(setting.section, sizeof setting.section, "%.*s", (int)(dot - from), from);
    setting.key = dot + 1;
    setting.name = from;
    return setting;
}

/// The settings of a way with this factor; their number, 0: the present value is not a positive number.
static int settings_of(const way_t *way, const rig_config_t *config, double factor,
                       setting_t *setting) {
    int count = 0;
    for (; count < KEYS_MAX && way->key[count] != NULL; ++count) {
        setting_t *one = &setting[count];
        *one = split(way->key[count]);
        char present[VALUE_LENGTH];
        double value = 0.0;
        ini_config_value(config, rig_schema_find(rig_schema(), one->section, one->key), present,
                         sizeof present);
        if (way->word != NULL) {
            (void)snprintf(one->value, sizeof one->value, "%s", way->word);
        } else if (sscanf(present, "%lf", &value) == 1 && value > 0.0) {
            print_value(one->value, value * (one->kept ? 1.0 : factor));
        } else {
            return 0;
        }
    }
    return count;
}

static bool has(const verdict_t *verdict, const char *key) {
    for (int k = 0; k < verdict->changes; ++k) {
        if (strcmp(verdict->change[k].key, key) == 0) {
            return true;
        }
    }
    return false;
}

/// The complaint is gone, and no other one has come.
static bool is_better(const verdict_t *before, const verdict_t *after, const char *complaint) {
    for (int k = 0; k < after->changes; ++k) {
        if (!has(before, after->change[k].key)) {
            return false;
        }
    }
    return !has(after, complaint);
}

/// Goes the way of the files and of --set, so that everything follows that follows there.
static bool works(const task_t *task, const way_t *way, double factor) {
    static rig_config_t trial; // large
    setting_t setting[KEYS_MAX];
    lode_drive6_tuning_t tuning;
    verdict_t verdict;
    const int count = settings_of(way, task->config, factor, setting);
    trial = *task->read;
    for (int k = 0; k < count; ++k) {
        ini_config_override(&trial, setting[k].section, setting[k].key, setting[k].value);
    }
    if (count == 0 || !rig_config_complete(&trial, RIG_NEED_MOTOR)) {
        return false;
    }
    rig_config_design(&trial);
    if (rig_config_tune(&trial, &tuning) != LODE_OK) {
        return false;
    }
    const speed_limits_t speeds = speed_limits_of(&trial.drive);
    verdict_compute(&verdict, &trial.drive, &tuning.drive, &speeds);
    return is_better(task->verdict, &verdict, way->complaint);
}

/// The smallest change that works; NaN: none.
static double factor_of(const task_t *task, const way_t *way) {
    const double ratio = way->raises ? RATIO : 1.0 / RATIO;
    double high = 1.0;
    int k = 0;
    for (; k < STEPS && !works(task, way, high *= ratio); ++k) {
        if (way->word != NULL) {
            return NAN;
        }
    }
    if (k == STEPS) {
        return NAN;
    }
    double low = high / ratio;
    for (int n = 0; way->word == NULL && n < BISECTIONS; ++n) {
        const double middle = sqrt(low * high);
        *(works(task, way, middle) ? &high : &low) = middle;
    }
    return high;
}

static void append(char *text, size_t size, const char *more) {
    const size_t used = strlen(text);
    (void)snprintf(text + used, size - used, "%s", more);
}

/// In words, and as the assignments that --set takes.
static void describe(verdict_change_t *change, const way_t *way, const setting_t *setting,
                     int count) {
    verdict_way_t *found = &change->way[change->ways++];
    char part[VERDICT_ASSIGNMENT + 16];
    const char *verb = way->raises ? "raise " : "lower ";
    verb = way->word != NULL ? "set " : verb;
    append(change->help, sizeof change->help, change->ways > 1 ? ", or " : "");
    for (int k = 0; k < count; ++k) {
        const setting_t *one = &setting[k];
        (void)snprintf(part, sizeof part, "%.40s %s %.20s", one->name,
                       one->kept || way->word != NULL ? "=" : "to", one->value);
        append(change->help, sizeof change->help, k == 0 ? verb : one->kept ? " with " : " and ");
        append(change->help, sizeof change->help, part);
        (void)snprintf(found->assignment[found->assignments++], VERDICT_ASSIGNMENT, "%.40s=%.20s",
                       one->name, one->value);
    }
    append(change->help, sizeof change->help, way->besides != NULL ? way->besides : "");
}

static void help_with(const task_t *task, verdict_change_t *change) {
    for (size_t k = 0u; k < sizeof ways / sizeof ways[0]; ++k) {
        const way_t *way = &ways[k];
        if (change->ways == VERDICT_WAYS_MAX || strcmp(way->complaint, change->key) != 0) {
            continue;
        }
        const double factor = factor_of(task, way);
        if (!isnan(factor)) {
            setting_t setting[KEYS_MAX];
            const int count = settings_of(way, task->config, factor, setting);
            change->help[0] = change->ways == 0 ? '\0' : change->help[0];
            describe(change, way, setting, count);
        }
    }
}

void advice_find(verdict_t *verdict, const rig_config_t *read, const rig_config_t *config) {
    const verdict_t before = *verdict;
    const task_t task = {&before, read, config};
    for (int k = 0; k < verdict->changes; ++k) {
        verdict_change_t *change = &verdict->change[k];
        int same = 0;
        while (strcmp(before.change[same].key, change->key) != 0) {
            ++same;
        }
        if (same == k) {
            help_with(&task, change);
        } else { // the same complaint at another speed: the ways remove both
            const verdict_change_t *first = &verdict->change[same];
            memcpy(change->way, first->way, sizeof change->way);
            change->ways = first->ways;
            if (first->ways > 0) {
                (void)snprintf(change->help, sizeof change->help, "%s", first->help);
            }
        }
    }
}
