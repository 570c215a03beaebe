#include "config/conversions.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "config/schema.h"
#include "support/diag.h"
#include "support/units.h"

typedef enum {
    SCALED,     ///< another unit of the same quantity
    LINE_LINE,  ///< measured between two terminals
    WINDING,    ///< of one winding, with the connection of `winding`
    KV,         ///< rpm per volt, peak line to line
    VRMS_KRPM,  ///< V RMS line to line at 1000 rpm
    V_HZ,       ///< peak phase voltage per electrical Hz
    KT,         ///< Nm per ampere of the phase current's amplitude
    RPM,        ///< mechanical rpm to electrical rad/s
    RPM_S,      ///< rpm/s to mechanical rad/s^2
    PER_AMPERE, ///< a gain in A, converted to Nm
} conversion_t;

typedef struct {
    const char *section, *key;
    const char *target[2]; ///< keys of the same section; NULL: none
    conversion_t conversion;
    double factor;
} row_t;

#define ROW(key, one, other, conversion, factor) {"motor", #key, {one, other}, conversion, factor},

// The order matters: later rows need pole pairs and flux.
static const row_t rows[] = {
    DATA_SHEET_KEYS(ROW){"estimator", "speed_max_rpm", {"omega_max_rad_s", NULL}, RPM, 1.0},
    {"start", "handover_rpm", {"omega_handover_rad_s", NULL}, RPM, 1.0},
    {"speed", "ramp_rpm_s", {"ramp_rad_s2", NULL}, RPM_S, 1.0},
    {"speed", "kp_A_s_rad", {"kp_Nms", NULL}, PER_AMPERE, 1.0},
    {"speed", "ki_A_rad", {"ki_Nm", NULL}, PER_AMPERE, 1.0},
};
enum { ROWS = sizeof rows / sizeof rows[0] };

static int find(const char *section, const char *key) {
    return rig_schema_find(rig_schema(), section, key);
}

/// True if a file or the command line gives exactly this key.
static bool is_typed(const rig_config_t *config, int row) {
    const rig_origin_t *origin = &config->origin[row];
    return origin->instead == NULL && (origin->file >= 0 || origin->line == 0);
}

static double convert(const rig_config_t *config, const row_t *row, double given) {
    const lode_motor_t *motor = &config->drive.motor;
    const float value = (float)(row->factor * given);
    const float np = motor->pole_pairs;
    switch (row->conversion) {
    case LINE_LINE:
        return (double)lode_phase_from_line_line(value);
    case WINDING:
        return (double)lode_phase_from_winding(value, (lode_winding_t)config->sheet.winding);
    case KV:
        return (double)lode_psi_from_KV(value, np);
    case VRMS_KRPM:
        return (double)lode_psi_from_Vrms_krpm(value, np);
    case V_HZ:
        return (double)lode_psi_from_V_Hz(value);
    case KT: // of all winding sets together
        return (double)(lode_psi_from_kt(value, np) / lode_max(motor->sets, 1.0f));
    case RPM:
        return (double)np * rig_rad_s_from_rpm(given);
    case RPM_S:
        return rig_rad_s_from_rpm(given);
    case PER_AMPERE:
        return (double)lode_motor_torque_factor(motor) * (double)motor->psi_Wb * given;
    case SCALED:
    default:
        return (double)value;
    }
}

static const char *place_of(const rig_config_t *config, const rig_origin_t *origin) {
    return origin->file >= 0 ? config->file[origin->file] : "--set";
}

/// Reports two keys for one quantity, with the places of both.
static void refuse_both(const rig_config_t *config, const row_t *row, int later, int earlier) {
    const rig_schema_t schema = rig_schema();
    const rig_origin_t *there = &config->origin[earlier];
    const rig_origin_t *here = &config->origin[later];
    char line[16] = "";
    if (there->line > 0) {
        (void)snprintf(line, sizeof line, ":%d", there->line);
    }
    rig_error_at(place_of(config, here), here->line,
                 "[%s] %s: sets the same quantity as %s in %s%s; expected one of them",
                 row->section, schema.row[later].key, schema.row[earlier].key,
                 place_of(config, there), line);
}

/// Row of the key that already gave this target; -1: none.
static int earlier_key(const rig_config_t *config, const char *section, int target) {
    const rig_origin_t *origin = &config->origin[target];
    if (is_typed(config, target)) {
        return target;
    }
    return origin->instead != NULL ? find(section, origin->instead) : -1;
}

/// Result of a key for one of its targets.
typedef enum { GIVEN, OVERRULED, REFUSED } outcome_t;

/// The later one of two sources counts; one source must not give two keys.
static outcome_t compare(const rig_config_t *config, const row_t *row, int from, const char *key) {
    const int to = find(row->section, key);
    const int earlier = earlier_key(config, row->section, to);
    if (earlier < 0 || config->origin[to].order < config->origin[from].order) {
        return GIVEN;
    }
    if (config->origin[to].order > config->origin[from].order) {
        return OVERRULED;
    }
    refuse_both(config, row, from, earlier);
    return REFUSED;
}

static void give(rig_config_t *config, const row_t *row, int from, const char *key) {
    const rig_schema_t schema = rig_schema();
    const int to = find(row->section, key);
    double given = NAN;
    (void)rig_key_number(&schema.row[from], config, &given);
    const float value = (float)convert(config, row, given);
    memcpy((char *)config + schema.row[to].offset, &value, sizeof value);
    config->origin[to] = config->origin[from];
    config->origin[to].instead = row->key;
}

/// The value of one winding needs the connection of the windings.
static bool is_connected(const rig_config_t *config, const row_t *row, int from) {
    if (row->conversion != WINDING || is_typed(config, find("motor", "winding"))) {
        return true;
    }
    const rig_origin_t *origin = &config->origin[from];
    rig_error_at(place_of(config, origin), origin->line,
                 "[motor] %s: expected winding = star or winding = delta as well", row->key);
    return false;
}

static void forget_earlier_results(rig_config_t *config) {
    for (int k = 0; k < RIG_KEYS_MAX; ++k) {
        if (config->origin[k].instead != NULL) {
            config->origin[k] = (rig_origin_t){.file = -1, .line = -1};
        }
    }
}

/// Resets a key as if it had not been given.
static void forget(rig_config_t *config, int row) {
    const double unset = RIG_UNSET;
    memcpy((char *)config + rig_schema().row[row].offset, &unset, sizeof unset);
    config->origin[row] = (rig_origin_t){.file = -1, .line = -1};
}

/// False after a message.
static bool apply(rig_config_t *config, const row_t *row) {
    const int from = find(row->section, row->key);
    bool used = false;
    for (int k = 0; k < 2 && is_typed(config, from) && row->target[k] != NULL; ++k) {
        const outcome_t outcome = compare(config, row, from, row->target[k]);
        if (outcome == REFUSED || (outcome == GIVEN && !is_connected(config, row, from))) {
            return false;
        }
        if (outcome == GIVEN) {
            give(config, row, from, row->target[k]);
            used = true;
        }
    }
    if (!used) {
        forget(config, from);
    }
    return true;
}

bool conversions_apply(rig_config_t *config) {
    forget_earlier_results(config);
    for (int k = 0; k < ROWS; ++k) {
        if (!apply(config, &rows[k])) {
            return false;
        }
    }
    if (!isnan(config->people.speed_rated_rpm)) {
        config->drive.motor.omega_rated_rad_s =
            (float)((double)config->drive.motor.pole_pairs *
                    rig_rad_s_from_rpm(config->people.speed_rated_rpm));
    }
    return true;
}

bool conversions_has(const char *section, const char *key) {
    for (int k = 0; k < ROWS; ++k) {
        if (strcmp(rows[k].section, section) == 0 && strcmp(rows[k].key, key) == 0) {
            return true;
        }
    }
    return false;
}

void conversions_instead_of(const char *section, const char *key, char *text, size_t size) {
    text[0] = '\0';
    for (int k = 0; k < ROWS; ++k) {
        const row_t *row = &rows[k];
        const bool gives = strcmp(row->target[0], key) == 0 ||
                           (row->target[1] != NULL && strcmp(row->target[1], key) == 0);
        if (gives && strcmp(row->section, section) == 0) {
            const size_t used = strlen(text);
            (void)snprintf(text + used, size - used, "%s%s", used > 0 ? ", " : "", row->key);
        }
    }
}
