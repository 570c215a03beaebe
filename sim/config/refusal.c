#include "config/refusal.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "config/ini_config.h"
#include "config/plausible.h"
#include "config/schema.h"
#include "support/diag.h"

#define NAME_LETTERS "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_"

/// Keys are written "section.key" and separated by spaces, the likeliest first.
typedef struct {
    lode_status_t status;
    const char *keys;     ///< keys whose values are compared
    const char *causes;   ///< keys from which the default of the first one is computed; NULL: none
    const char *expected; ///< uses the names of keys, and Ts for the PWM period
} refusal_t;

// Sources of the rated speed, which scales most defaults. It comes last in a list: if the rated speed is given,
// the keys after it do not count.
#define VOLTAGE "drive.v_bus_V motor.psi_Wb motor.Lq_H drive.i_max_A"
#define RATED "motor.speed_rated_rpm " VOLTAGE

static const refusal_t refusals[] = {
    {LODE_ERROR_F_PWM, "drive.f_pwm_Hz", NULL, "1e3 .. 2e5"},
    {LODE_ERROR_MOTOR_POLE_PAIRS, "motor.pole_pairs", NULL, "a whole number, 1 .. 100"},
    {LODE_ERROR_MOTOR_RS, "motor.Rs_Ohm", NULL, "0 .. 1e3"},
    {LODE_ERROR_MOTOR_LD, "motor.Ld_H", NULL, "1e-7 .. 10"},
    {LODE_ERROR_MOTOR_LQ, "motor.Lq_H", NULL, "1e-7 .. 10"},
    {LODE_ERROR_MOTOR_PSI, "motor.psi_Wb", NULL, "1e-6 .. 100"},
    {LODE_ERROR_MOTOR_J, "motor.J_kgm2", NULL, "1e-9 .. 1e4"},
    {LODE_ERROR_MOTOR_B, "motor.B_Nms motor.J_kgm2 drive.f_pwm_Hz", NULL,
     "0 .. 1e3, and at most J_kgm2 over the PWM period"},
    {LODE_ERROR_MOTOR_OMEGA, "motor.speed_rated_rpm", VOLTAGE, "1 .. 1e5 electrical rad/s"},
    {LODE_ERROR_MOTOR_SETS, "motor.sets", NULL, "1 or 2"},
    {LODE_ERROR_MOTOR_PERIOD, "drive.f_pwm_Hz motor.Rs_Ohm motor.Ld_H motor.Lq_H drive.r_on_Ohm",
     NULL, "a PWM period shorter than L/R: R Ts at most the smaller of Ld and Lq"},
    {LODE_ERROR_V_BUS, "drive.v_bus_V", NULL, "1 .. 2000"},
    {LODE_ERROR_I_MAX, "drive.i_max_A", NULL, "1e-3 .. 1e4"},
    {LODE_ERROR_DEAD_TIME, "drive.dead_time_s drive.f_pwm_Hz", NULL, "0 .. 0.2 Ts"},
    {LODE_ERROR_V_DROP, "drive.v_drop_V", NULL, "0 .. 10"},
    {LODE_ERROR_R_ON, "drive.r_on_Ohm", NULL, "0 .. 10"},
    {LODE_ERROR_I_DEAD, "drive.i_dead_A", NULL, "1e-3 .. 1 times i_max_A"},
    {LODE_ERROR_PWM_TICKS, "drive.pwm_ticks", NULL, "0 .. 65535"},
    {LODE_ERROR_PRECHARGE, "drive.precharge_s", NULL, "0 (none) .. 1"},
    {LODE_ERROR_SENSE_SHUNTS, "drive.shunts", NULL, "three or two"},
    {LODE_ERROR_SENSE_CURRENT, "drive.i_range_A", "guard.i_trip_A drive.i_max_A",
     "at least i_max_A"},
    {LODE_ERROR_SENSE_BUS, "drive.v_range_V", "drive.v_bus_V", "at least v_bus_V"},
    {LODE_ERROR_SENSE_OFFSET, "drive.i_offset_tol_count drive.adc_bits", NULL,
     "within the ADC's range"},
    {LODE_ERROR_SENSE_WINDOW, "current.voltage_use drive.duty_max", NULL,
     "duty_max 0.5 .. 1, and with two shunts voltage_use at most 2 duty_max - 1 minus the share of "
     "the dead time"},
    {LODE_ERROR_DOUBLE_UPDATE, "drive.double_update", "drive.duty_max",
     "off, or currents sensed in the phases: duty_max 1"},
    {LODE_ERROR_SENSE_CALIBRATION, "drive.calibrate_s drive.i_noise_count", "drive.f_pwm_Hz",
     "calibrate_s 1 period .. 10 s, at most 65536 periods; i_noise_count 0, or 0.4 .. 64 and at "
     "least 256 periods"},
    {LODE_ERROR_EMF_KIND, "estimator.emf", NULL, "an observer of this build"},
    {LODE_ERROR_EMF_W0, "estimator.w0_rad_s", RATED, "1 .. 2/Ts"},
    {LODE_ERROR_EMF_GI, "estimator.gi_kappa estimator.gi_wc_rad_s", NULL,
     "gi_kappa 0 .. 7 and gi_wc_rad_s 0.01 .. 100"},
    {LODE_ERROR_EMF_FA, "estimator.k2_rad_s estimator.k1_rad2_s2", "estimator.sigma_rad_s " RATED,
     "k2_rad_s 1 .. 1/Ts, k1_rad2_s2 0 .. 1e4 and at most k2_rad_s^2/10"},
    {LODE_ERROR_NOTCH, "estimator.notch_k estimator.notch12_k", NULL, "0 (none) or 0.01 .. 2"},
    {LODE_ERROR_EMF_PLL, "estimator.k2_rad_s estimator.sigma_rad_s", RATED,
     "k2_rad_s at least 0.549 (fa-multi: 0.6) sigma_rad_s: else observer and PLL are unstable "
     "together"},
    {LODE_ERROR_W_FILTER, "estimator.w_filter_rad_s", NULL, "0 (none) .. 1/Ts"},
    {LODE_ERROR_CHOICE,
     "start.signal_check estimator.active_flux drive.dead_time_correction drive.dead_time_model "
     "speed.every_period start.measure start.pulses",
     NULL,
     "auto or off, or on if possible: signal_check needs dead_time_s of at most a quarter of its "
     "longest pulse, and a current of at least 64 counts"},
    {LODE_ERROR_PLL_KIND, "estimator.pll", NULL, "a PLL of this build"},
    {LODE_ERROR_PLL_SIGMA, "estimator.sigma_rad_s estimator.sigma_low_rad_s",
     "drive.f_pwm_Hz " RATED, "1 .. 0.3/Ts, and sigma_low_rad_s at most sigma_rad_s"},
    {LODE_ERROR_PLL_OBSERVER, "estimator.sigma_rad_s estimator.w0_rad_s", "drive.f_pwm_Hz " RATED,
     "sigma_rad_s at most a fifth of w0_rad_s: a PLL clearly slower than the EMF observer (for one "
     "that rotates with the speed: see its theory page)"},
    {LODE_ERROR_PLL_SCHEDULE, "estimator.omega_low_rad_s estimator.omega_high_rad_s", RATED,
     "omega_low_rad_s below omega_high_rad_s"},
    {LODE_ERROR_LAG, "estimator.w0_rad_s estimator.omega_max_rad_s", "drive.f_pwm_Hz " RATED,
     "an observer whose phase a polynomial fits within 0.01 degree: larger w0_rad_s or smaller "
     "omega_max_rad_s"},
    {LODE_ERROR_EMIN, "estimator.emin_V", "motor.psi_Wb " RATED, "1e-4 .. 1e3"},
    {LODE_ERROR_OMEGA_MAX, "estimator.omega_max_rad_s", "drive.f_pwm_Hz " RATED, "1 .. 0.5/Ts"},
    {LODE_ERROR_LOCK_TIME, "estimator.lock_s", "drive.f_pwm_Hz", "1 period .. 1 s"},
    {LODE_ERROR_CURRENT_BANDWIDTH, "current.bandwidth_rad_s", "drive.f_pwm_Hz", "1 .. 0.4/Ts"},
    {LODE_ERROR_CURRENT_GAINS,
     "current.kp_d_V_A current.kp_q_V_A current.ki_d_V_As current.ki_q_V_As",
     "current.bandwidth_rad_s motor.Rs_Ohm motor.Ld_H motor.Lq_H drive.r_on_Ohm drive.f_pwm_Hz",
     "positive gains that are stable with the motor's inductances"},
    {LODE_ERROR_CURRENT_VOLTAGE, "current.voltage_use", NULL, "0.1 .. 1.1547"},
    {LODE_ERROR_SPEED_GAINS,
     "speed.kp_Nms speed.ki_Nm speed.gain_rise speed.dip_gain speed.swing_Nm",
     "speed.bandwidth_rad_s motor.J_kgm2 " RATED,
     "kp_Nms 1e-9 .. 1e6, ki_Nm 0 .. 1e6, gain_rise 1 .. 10, dip_gain 0 .. 10 or none, swing_Nm up "
     "to 1e6 or none"},
    {LODE_ERROR_SPEED_BANDWIDTH, "speed.bandwidth_rad_s speed.kp_Nms",
     "estimator.sigma_low_rad_s motor.J_kgm2 " RATED,
     "a speed loop slower than the PLL that feeds it: kp_Nms at most sigma_low_rad_s times J_kgm2"},
    {LODE_ERROR_SPEED_RAMP, "speed.ramp_rad_s2 speed.ramp_down_rad_s2 speed.jerk_rad_s3",
     "motor.J_kgm2 motor.psi_Wb drive.i_max_A drive.f_pwm_Hz",
     "slopes 1e-3 .. 1e7 rad/s^2; jerk_rad_s3 0, or from the steeper slope over 65536 periods of "
     "speed control to 1e12"},
    {LODE_ERROR_SPEED_FEED_FORWARD, "speed.load_feed_forward speed.inertia_feed_forward", NULL,
     "0 .. 1 or none"},
    {LODE_ERROR_ID_BIAS,
     "references.id_bias_A hfi.id_A references.omega_low_rad_s references.omega_high_rad_s",
     "drive.i_max_A " RATED,
     "id_bias_A and [hfi] id_A none or 0 .. i_max_A, and omega_low_rad_s below omega_high_rad_s"},
    {LODE_ERROR_REFERENCES, "references.strategy references.field_weakening", NULL,
     "id0 or mtpa, and auto, on or off"},
    {LODE_ERROR_WEAKENING_ESTIMATOR, "references.field_weakening estimator.pll estimator.emf", NULL,
     "off with the QPLL and with the GI-LESO: their errors while the speed changes move the d "
     "current"},
    {LODE_ERROR_FIELD_WEAKENING,
     "references.voltage_use references.trim_rad_s references.release_s references.id_max_A",
     "drive.i_max_A",
     "voltage_use 0.1 .. 1, trim_rad_s 0.1 .. 1e3 or none, release_s 1e-3 .. 10, id_max_A at most "
     "i_max_A"},
    {LODE_ERROR_LQ_FALL, "references.Lq_fall", "drive.i_max_A", "0 .. 10/i_max_A"},
    {LODE_ERROR_BUS_FADE,
     "references.v_regen_V references.v_motor_V references.v_bus_max_V references.v_bus_min_V",
     "guard.v_bus_max_V guard.v_bus_min_V drive.v_bus_V",
     "v_bus_V <= v_regen_V < v_bus_max_V and v_bus_min_V < v_motor_V <= v_bus_V"},
    {LODE_ERROR_START_CURRENT, "start.current_A start.current_last_A",
     "motor.Ld_H motor.Lq_H motor.psi_Wb drive.i_max_A",
     "current_A above 0, at most i_max_A; current_last_A from there to i_max_A"},
    {LODE_ERROR_START_SPEED, "start.omega_handover_rad_s speed.omega_min_rad_s",
     "estimator.omega_max_rad_s " RATED,
     "omega_handover_rad_s above 0, at most omega_max_rad_s; omega_min_rad_s at least half of it"},
    {LODE_ERROR_START_RAMP,
     "start.ramp_rad_s2 start.current_rise_s start.align_s start.catch_s start.lock_s "
     "start.timeout_s start.fade_s",
     "start.current_A start.omega_handover_rad_s motor.J_kgm2 motor.psi_Wb drive.i_max_A",
     "ramp_rad_s2 1e-3 .. 1e7; current_rise_s 1 period .. 100 s, lock_s and fade_s 1 period .. 10 "
     "s, align_s and catch_s at most 10 s, timeout_s from lock_s to 1000 s"},
    {LODE_ERROR_START_DAMPING, "start.damping", NULL, "0 .. 2 or none"},
    {LODE_ERROR_HFI_MODE, "hfi.mode", NULL,
     "default, on, off or auto, in a build with signal injection"},
    {LODE_ERROR_HFI_SALIENCY, "hfi.Lq_i_max_H",
     "motor.Ld_H motor.Lq_H references.Lq_fall drive.i_max_A",
     "a differential Lq at i_max_A of at least 1.15 Ld_H"},
    {LODE_ERROR_HFI_VOLTAGE, "hfi.V_h_V hfi.noise_A",
     "motor.Ld_H drive.f_pwm_Hz drive.i_max_A drive.v_bus_V drive.dead_time_s current.voltage_use",
     "above 0, at most half of the voltage circle; noise_A at most i_max_A"},
    {LODE_ERROR_HFI_DEAD_TIME, "hfi.V_h_V",
     "drive.dead_time_s drive.v_drop_V drive.v_bus_V motor.Ld_H motor.Lq_H",
     "V_h_V at least 2 (v_bus_V dead_time_s/Ts + v_drop_V)/(saliency - 1)"},
    {LODE_ERROR_HFI_SPEEDS, "hfi.w1_rad_s hfi.w2_rad_s",
     "estimator.omega_max_rad_s motor.psi_Wb drive.dead_time_s drive.v_drop_V " RATED,
     "w1_rad_s 0.1 .. 0.95 times w2_rad_s, w2_rad_s at most omega_max_rad_s"},
    {LODE_ERROR_HFI_SIGMA, "hfi.sigma_rad_s", "estimator.sigma_rad_s " RATED, "1 .. 0.1/Ts"},
    {LODE_ERROR_HFI_AXIS, "hfi.k_x_rad_A", "drive.i_max_A", "within +-0.5/i_max_A"},
    {LODE_ERROR_HFI_LEARN, "hfi.learn", "hfi.mode",
     "auto, on or off; on with injection of three phases only"},
    {LODE_ERROR_HFI_FLUX, "estimator.active_flux", "hfi.mode", "on, with injection"},
    {LODE_ERROR_XY_INDUCTANCE, "motor.Lxy_H", NULL, "1e-7 .. 10"},
    {LODE_ERROR_XY_BANDWIDTH, "xy.bandwidth_rad_s xy.resonance_rad_s", "drive.f_pwm_Hz",
     "a bandwidth of 1 .. 0.4/Ts, and a resonance of at most a quarter of it, or none"},
    {LODE_ERROR_XY_VOLTAGE, "xy.voltage_share", NULL, "0 .. 0.5"},
    {LODE_ERROR_SOURCE, "estimator.winding", NULL, "vsd, set-1 or set-2"},
    {LODE_ERROR_OPEN_PHASE, "guard.open_phase", NULL, "trip, go-on or ignore"},
    {LODE_ERROR_GUARD_CURRENT, "guard.i_trip_A guard.i_sum_A drive.i_range_A",
     "drive.i_max_A drive.i_range_A",
     "i_trip_A i_max_A .. 1e5, inside the sensor's range ([drive] i_range_A); i_sum_A 1e-3 .. 10 "
     "times i_max_A or none"},
    {LODE_ERROR_GUARD_BUS, "guard.v_bus_max_V guard.v_bus_min_V drive.v_range_V",
     "drive.v_bus_V drive.v_range_V",
     "limits around v_bus_V, inside the sensor's range ([drive] v_range_V)"},
    {LODE_ERROR_GUARD_TEMPERATURE, "guard.temperature_max_degC guard.temperature_min_degC", NULL,
     "temperature_max_degC -100 .. 1000, temperature_min_degC -300 .. temperature_max_degC; "
     "without a temperature sensor the constant temperature between both"},
    {LODE_ERROR_GUARD_SPEED, "guard.omega_max_rad_s", "estimator.omega_max_rad_s " RATED,
     "1 .. 1e6; without injection at least start.omega_handover_rad_s and speed.omega_min_rad_s"},
    {LODE_ERROR_GUARD_TIME,
     "guard.bus_s guard.lock_s guard.stamp_per_period guard.temperature_still_s guard.bus_still_s "
     "guard.overload_s",
     "drive.f_pwm_Hz",
     "bus_s and lock_s 1 period .. 10 s, stamp_per_period 0 or 1 .. 1e9, temperature_still_s and "
     "bus_still_s 0 .. 524280 periods (temperature_still_s 0 without a sensor), overload_s 1 "
     "period .. 10 s or none"},
    {LODE_ERROR_GUARD_FLUX, "guard.flux_share", NULL, "0.1 .. 1 or none"},
};

static const refusal_t *find(lode_status_t status) {
    for (size_t k = 0; k < sizeof refusals / sizeof refusals[0]; ++k) {
        if (refusals[k].status == status) {
            return &refusals[k];
        }
    }
    return NULL;
}

// ---- Which of the keys causes the refusal ----------------------------------------------------------------

enum { ROWS_MAX = 16 };

typedef struct {
    int count;
    int row[ROWS_MAX];
} rows_t;

static int find_row(const char *name) {
    const char *dot = strchr(name, '.');
    char section[RIG_NAME_LENGTH];
    if (dot == NULL) {
        return -1;
    }
    (void)snprintf(section, sizeof section, "%.*s", (int)(dot - name), name);
    return rig_schema_find(rig_schema(), section, dot + 1);
}

static bool is_typed(const rig_config_t *config, int row) {
    const rig_origin_t *origin = &config->origin[row];
    return origin->file >= 0 || origin->line == 0;
}

static rows_t rows_of(const rig_config_t *config, const char *keys) {
    rows_t rows = {.count = 0};
    char name[2 * RIG_NAME_LENGTH];
    for (const char *at = keys; at != NULL && *at != '\0';) {
        const size_t length = strcspn(at, " ");
        (void)snprintf(name, sizeof name, "%.*s", (int)length, at);
        const int row = find_row(name);
        if (row >= 0 && rows.count < ROWS_MAX) {
            rows.row[rows.count++] = row;
        }
        const bool ends = strcmp(name, "motor.speed_rated_rpm") == 0 && is_typed(config, row);
        at = ends ? NULL : at + length + strspn(at + length, " ");
    }
    return rows;
}

static bool may_be_auto(int row) {
    const rig_key_kind_t kind = rig_schema().row[row].kind;
    return kind == RIG_KEY_FLOAT || kind == RIG_KEY_FLOAT_OR_NONE;
}

/// True if the refusal disappears when the library computes the key.
static bool is_to_blame(const rig_config_t *config, int row, lode_status_t status) {
    rig_config_t trial = *config;
    const float open = 0.0f;
    trial.drive = config->given;
    trial.six = config->given_six;
    const bool refused = rig_config_judge(&trial) == status;
    memcpy((char *)&trial + rig_schema().row[row].offset, &open, sizeof open);
    return refused && rig_config_judge(&trial) != status;
}

/// The command line overrides the scenario, which overrides the files that it names.
static int rank(const rig_origin_t *origin) {
    return origin->file < 0 ? 2 : origin->file == 0 ? 1 : 0;
}

/// The row that was given; of several, the one with the highest priority; -1: none.
static int last_word(const rig_config_t *config, const rows_t *keys, bool with_auto) {
    int found = -1;
    for (int k = 0; k < keys->count; ++k) {
        const int row = keys->row[k];
        const bool counts = is_typed(config, row) && (with_auto || !may_be_auto(row));
        if (counts && (found < 0 || rank(&config->origin[row]) > rank(&config->origin[found]))) {
            found = row;
        }
    }
    return found;
}

/// The given key that causes the refusal; -1: none.
static int find_culprit(const rig_config_t *config, const rows_t *keys, lode_status_t status) {
    for (int k = 0; k < keys->count; ++k) {
        const int row = keys->row[k];
        if (is_typed(config, row) && may_be_auto(row) && is_to_blame(config, row, status)) {
            return row;
        }
    }
    return last_word(config, keys, false);
}

// ---- The message ------------------------------------------------------------------------------------

typedef struct {
    char text[1024];
    rows_t shown; ///< rows whose values it shows
} message_t;

static void append(message_t *message, const char *format, ...) RIG_PRINTF(2, 3);
static void append(message_t *message, const char *format, ...) {
    const size_t used = strlen(message->text);
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(message->text + used, sizeof message->text - used, format, arguments);
    va_end(arguments);
}

static bool is_shown(const message_t *message, int row) {
    bool found = false;
    for (int k = 0; k < message->shown.count; ++k) {
        found = found || message->shown.row[k] == row;
    }
    return found;
}

/// "[section] key = value".
static void append_value(message_t *message, const rig_config_t *config, int row) {
    if (message->shown.count < ROWS_MAX) {
        message->shown.row[message->shown.count++] = row;
    }
    const rig_schema_t schema = rig_schema();
    const rig_key_t *key = &schema.row[row];
    char value[RIG_PATH_LENGTH];
    ini_config_value(config, row, value, sizeof value);
    append(message, "[%s] %s = %s", key->section, key->key, value);
}

/// The key that was written, if it replaces this one.
static int written_row(const rig_config_t *config, int row) {
    const char *instead = config->origin[row].instead;
    return instead == NULL ? row
                           : rig_schema_find(rig_schema(), rig_schema().row[row].section, instead);
}

/// Appends the other values that the refusal depends on.
static void append_others(message_t *message, const rig_config_t *config, const rows_t *rows) {
    const char *gap = "; with ";
    for (int k = 0; k < rows->count; ++k) {
        const int row = written_row(config, rows->row[k]);
        if (is_typed(config, row) && !is_shown(message, row) && !is_shown(message, rows->row[k])) {
            char where[RIG_PATH_LENGTH + 64];
            append(message, "%s", gap);
            append_value(message, config, row);
            ini_config_where(config, row, where, sizeof where);
            append(message, " (%s)", where);
            gap = ", ";
        }
    }
}

/// Row of a key that `expected` names, first in the same section, then in others; -1: none, or already shown.
static int named_row(const message_t *message, const char *section, const char *name) {
    const char *const sections[] = {section, "drive", "estimator", "speed", "motor"};
    int row = -1;
    for (size_t k = 0; row < 0 && k < sizeof sections / sizeof sections[0]; ++k) {
        row = rig_schema_find(rig_schema(), sections[k], name);
    }
    return row >= 0 && !is_shown(message, row) ? row : -1;
}

/// Appends the values of the keys and of the period that `expected` names.
static void append_names(message_t *message, const rig_config_t *config, const refusal_t *refusal,
                         const char *section) {
    const char *gap = "; here ";
    for (const char *at = refusal->expected; *at != '\0';) {
        const size_t length = strspn(at, NAME_LETTERS);
        char name[RIG_NAME_LENGTH];
        (void)snprintf(name, sizeof name, "%.*s", (int)length, at);
        const int row = named_row(message, section, name);
        if (strcmp(name, "Ts") == 0) {
            append(message, "%sTs = %.4g s", gap, 1.0 / (double)config->drive.f_pwm_Hz);
            gap = ", ";
        } else if (row >= 0) {
            append(message, "%s", gap);
            append_value(message, config, row);
            gap = ", ";
        }
        at += length + strcspn(at + length, NAME_LETTERS);
    }
}

/// The compared key, and the key that causes its value: the same, or the one from which it was computed; -1:
/// none was given.
typedef struct {
    int compared, blamed;
    rows_t rows; ///< all keys that the refusal depends on
} blame_t;

static blame_t find_blame(const rig_config_t *config, const refusal_t *refusal) {
    const rows_t keys = rows_of(config, refusal->keys);
    const rows_t causes = rows_of(config, refusal->causes);
    const int culprit = find_culprit(config, &keys, refusal->status);
    if (culprit >= 0) {
        return (blame_t){culprit, culprit, keys};
    }
    const int cause = last_word(config, &causes, true);
    if (cause >= 0) {
        return (blame_t){keys.row[0], cause, causes};
    }
    return (blame_t){keys.row[0], last_word(config, &keys, true), keys};
}

/// Appends assumed values that may be given, as the rated speed.
static void append_assumed(message_t *message, const rig_config_t *config, const rows_t *rows) {
    for (int k = 0; k < rows->count; ++k) {
        const int row = rows->row[k];
        if (!may_be_auto(row) && config->origin[row].assumed != NULL && !is_shown(message, row)) {
            append(message, "; ");
            append_value(message, config, row);
            append(message, " is assumed, and may be given");
        }
    }
}

static void describe(message_t *message, const rig_config_t *config, const refusal_t *refusal,
                     const blame_t *blame) {
    const int row = written_row(config, blame->blamed >= 0 ? blame->blamed : blame->compared);
    append_value(message, config, row);
    if (blame->blamed < 0) {
        char where[RIG_PATH_LENGTH + 64];
        ini_config_where(config, row, where, sizeof where);
        append(message, " (%s)", where);
    }
    append(message, ": %s: ", lode_status_name(refusal->status));
    if (row != blame->compared) {
        append(message, "gives ");
        append_value(message, config, blame->compared);
        append(message, "; ");
    }
    append(message, "expected %s", refusal->expected);
    append_names(message, config, refusal, rig_schema().row[blame->compared].section);
    append_others(message, config, &blame->rows);
    append_assumed(message, config, &blame->rows);
}

static void report(const rig_config_t *config, lode_status_t status) {
    const refusal_t *refusal = find(status);
    if (refusal == NULL) {
        rig_error("the library refused the configuration: %s", lode_status_name(status));
        return;
    }
    message_t message = {.text = ""};
    const blame_t blame = find_blame(config, refusal);
    describe(&message, config, refusal, &blame);
    if (blame.blamed < 0) {
        rig_error("%s", message.text);
        return;
    }
    const rig_origin_t *origin = &config->origin[blame.blamed];
    rig_error_at(origin->file >= 0 ? config->file[origin->file] : "--set",
                 origin->file >= 0 ? origin->line : 0, "%s", message.text);
}

void refusal_report(const rig_config_t *config, lode_status_t status) {
    report(config, status);
    const plausible_t plausible = plausible_of(&config->drive);
    (void)plausible_print_doubts(stderr, &plausible);
}
