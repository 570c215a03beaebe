#include "config/refusal.h"

#include <stdio.h>
#include <string.h>

#include "config/schema.h"
#include "support/diag.h"

typedef struct {
    lode_status_t status;
    const char *section;
    const char *keys; ///< those it may concern, separated by spaces, the likeliest first
    const char *expected;
} refusal_t;

static const refusal_t refusals[] = {
    {LODE_ERROR_F_PWM, "drive", "f_pwm_Hz", "1e3 .. 2e5"},
    {LODE_ERROR_MOTOR_POLE_PAIRS, "motor", "pole_pairs", "a whole number, 1 .. 100"},
    {LODE_ERROR_MOTOR_RS, "motor", "Rs_Ohm", "0 .. 1e3"},
    {LODE_ERROR_MOTOR_LD, "motor", "Ld_H", "1e-7 .. 10"},
    {LODE_ERROR_MOTOR_LQ, "motor", "Lq_H", "1e-7 .. 10"},
    {LODE_ERROR_MOTOR_PSI, "motor", "psi_Wb", "1e-6 .. 100"},
    {LODE_ERROR_MOTOR_J, "motor", "J_kgm2", "1e-9 .. 1e4"},
    {LODE_ERROR_MOTOR_B, "motor", "B_Nms", "0 .. 1e3"},
    {LODE_ERROR_MOTOR_OMEGA, "motor", "speed_rated_rpm", "at most 1e5 electrical rad/s"},
    {LODE_ERROR_MOTOR_SETS, "motor", "sets", "1 or 2"},
    {LODE_ERROR_MOTOR_PERIOD, "drive", "f_pwm_Hz", "a period shorter than the motor's L/R"},
    {LODE_ERROR_V_BUS, "drive", "v_bus_V", "1 .. 2000"},
    {LODE_ERROR_I_MAX, "drive", "i_max_A", "1e-3 .. 1e4"},
    {LODE_ERROR_DEAD_TIME, "drive", "dead_time_s", "0 .. 0.2 PWM periods"},
    {LODE_ERROR_V_DROP, "drive", "v_drop_V", "0 .. 10"},
    {LODE_ERROR_R_ON, "drive", "r_on_Ohm", "0 .. 10"},
    {LODE_ERROR_I_DEAD, "drive", "i_dead_A", "1e-3 .. 1 times i_max_A"},
    {LODE_ERROR_PWM_TICKS, "drive", "pwm_ticks", "0 .. 65535"},
    {LODE_ERROR_SENSE_SHUNTS, "drive", "shunts", "three or two"},
    {LODE_ERROR_SENSE_CURRENT, "drive", "i_range_A", "at least i_max_A"},
    {LODE_ERROR_SENSE_BUS, "drive", "v_range_V", "at least v_bus_V"},
    {LODE_ERROR_SENSE_OFFSET, "drive", "i_offset_tol_count adc_bits",
     "within the converter's range"},
    {LODE_ERROR_SENSE_WINDOW, "drive", "duty_max", "0.5 .. 1"},
    {LODE_ERROR_SENSE_CALIBRATION, "drive", "calibrate_s",
     "1 period .. 10 s, at most 65536 periods"},
    {LODE_ERROR_EMF_KIND, "estimator", "emf", "an observer that is built in"},
    {LODE_ERROR_EMF_W0, "estimator", "w0_rad_s", "1 .. 2/Ts"},
    {LODE_ERROR_EMF_GI, "estimator", "gi_kappa gi_wc_rad_s",
     "gi_kappa 0 .. 7 and gi_wc_rad_s 0.01 .. 100"},
    {LODE_ERROR_EMF_FA, "estimator", "k2_rad_s k1_rad2_s2",
     "k2_rad_s 1 .. 1/Ts, k1_rad2_s2 0 .. 1e4 and at most k2_rad_s^2/10"},
    {LODE_ERROR_NOTCH, "estimator", "notch_k notch12_k", "0 (none) or 0.01 .. 2"},
    {LODE_ERROR_EMF_PLL, "estimator", "k2_rad_s sigma_rad_s",
     "k2_rad_s at least 0.549 (fa-multi: 1.2) sigma_rad_s: else observer and PLL are unstable "
     "together"},
    {LODE_ERROR_W_FILTER, "estimator", "w_filter_rad_s", "0 (none) .. 1/Ts"},
    {LODE_ERROR_CHOICE, "estimator", "active_flux", "auto, on or off"},
    {LODE_ERROR_PLL_KIND, "estimator", "pll", "a PLL that is built in"},
    {LODE_ERROR_PLL_SIGMA, "estimator", "sigma_rad_s sigma_low_rad_s",
     "1 .. 0.3/Ts, and sigma_low_rad_s at most sigma_rad_s"},
    {LODE_ERROR_PLL_OBSERVER, "estimator", "sigma_rad_s w0_rad_s",
     "at most a fifth of w0_rad_s: a PLL clearly slower than the EMF observer (one that rotates "
     "with "
     "the speed: as its theory page says)"},
    {LODE_ERROR_PLL_SCHEDULE, "estimator", "omega_low_rad_s omega_high_rad_s",
     "omega_low_rad_s below omega_high_rad_s"},
    {LODE_ERROR_LAG, "estimator", "w0_rad_s omega_max_rad_s",
     "an observer whose phase a polynomial holds within 0.01 degree: larger w0_rad_s or smaller "
     "omega_max_rad_s"},
    {LODE_ERROR_EMIN, "estimator", "emin_V", "1e-4 .. 1e3"},
    {LODE_ERROR_OMEGA_MAX, "estimator", "omega_max_rad_s speed_max_rpm", "1 .. 0.5/Ts"},
    {LODE_ERROR_LOCK_TIME, "estimator", "lock_s", "1 period .. 1 s"},
    {LODE_ERROR_CURRENT_BANDWIDTH, "current", "bandwidth_rad_s", "1 .. 0.4/Ts"},
    {LODE_ERROR_CURRENT_GAINS, "current", "kp_d_V_A kp_q_V_A ki_d_V_As ki_q_V_As",
     "positive gains that are stable with the motor's inductances"},
    {LODE_ERROR_CURRENT_VOLTAGE, "current", "voltage_use", "0.1 .. 1"},
    {LODE_ERROR_SPEED_GAINS, "speed", "kp_Nms ki_Nm kp_A_s_rad ki_A_rad", "0 .. 1e6"},
    {LODE_ERROR_SPEED_BANDWIDTH, "speed", "bandwidth_rad_s kp_Nms kp_A_s_rad",
     "a speed loop slower than the PLL that feeds it (sigma_low_rad_s)"},
    {LODE_ERROR_SPEED_RAMP, "speed", "ramp_rad_s2 ramp_rpm_s", "a positive acceleration"},
    {LODE_ERROR_SPEED_FEED_FORWARD, "speed", "load_feed_forward inertia_feed_forward",
     "0 .. 1 or none"},
    {LODE_ERROR_ID_BIAS, "references", "id_bias_A omega_low_rad_s omega_high_rad_s",
     "at most i_max_A, and omega_low_rad_s below omega_high_rad_s"},
    {LODE_ERROR_REFERENCES, "references", "strategy field_weakening",
     "id0 or mtpa, and auto, on or off"},
    {LODE_ERROR_FIELD_WEAKENING, "references", "voltage_use trim_rad_s release_s id_max_A",
     "voltage_use 0.1 .. 1, trim_rad_s 0.1 .. 1e3 or none, release_s 1e-3 .. 10, id_max_A at most "
     "i_max_A"},
    {LODE_ERROR_LQ_FALL, "references", "Lq_fall", "0 .. 10/i_max_A"},
    {LODE_ERROR_BUS_FADE, "references", "v_regen_V v_motor_V v_bus_max_V v_bus_min_V",
     "v_bus_V <= v_regen_V < v_bus_max_V and v_bus_min_V < v_motor_V <= v_bus_V"},
    {LODE_ERROR_START_CURRENT, "start", "current_A", "above 0, at most i_max_A"},
    {LODE_ERROR_START_SPEED, "start", "omega_handover_rad_s handover_rpm",
     "above 0, at most the highest speed"},
    {LODE_ERROR_START_RAMP, "start", "ramp_rad_s2 current_rise_s lock_s timeout_s fade_s",
     "a positive acceleration and positive times"},
    {LODE_ERROR_START_DAMPING, "start", "damping", "0 .. 2 or none"},
    {LODE_ERROR_XY_INDUCTANCE, "motor", "Lxy_H", "1e-7 .. 10"},
    {LODE_ERROR_XY_BANDWIDTH, "xy", "bandwidth_rad_s resonance_rad_s",
     "a bandwidth of 1 .. 0.4/Ts, and a resonance of at most a quarter of it, or none"},
    {LODE_ERROR_XY_VOLTAGE, "xy", "voltage_share", "0 .. 0.5"},
    {LODE_ERROR_SOURCE, "estimator", "winding", "vsd, set-1 or set-2"},
    {LODE_ERROR_OPEN_PHASE, "guard", "open_phase", "trip, go-on or ignore"},
    {LODE_ERROR_GUARD_CURRENT, "guard", "i_trip_A",
     "i_max_A .. 1e5, inside the sensor's range ([drive] i_range_A)"},
    {LODE_ERROR_GUARD_BUS, "guard", "v_bus_max_V v_bus_min_V",
     "limits around v_bus_V, inside the sensor's range ([drive] v_range_V)"},
    {LODE_ERROR_GUARD_TEMPERATURE, "guard", "temperature_max_degC", "a finite limit"},
    {LODE_ERROR_GUARD_SPEED, "guard", "omega_max_rad_s", "0 .. 1e6"},
    {LODE_ERROR_GUARD_TIME, "guard", "bus_s lock_s stamp_per_period", "1 period .. 10 s"},
};

static const refusal_t *find(lode_status_t status) {
    for (size_t k = 0; k < sizeof refusals / sizeof refusals[0]; ++k) {
        if (refusals[k].status == status) {
            return &refusals[k];
        }
    }
    return NULL;
}

/// The first of the keys that somebody has set; else the first of them.
static int culprit(const rig_config_t *config, const refusal_t *refusal) {
    const rig_schema_t schema = rig_schema();
    char keys[128];
    int first = -1;
    (void)snprintf(keys, sizeof keys, "%s", refusal->keys);
    for (char *key = strtok(keys, " "); key != NULL; key = strtok(NULL, " ")) {
        const int row = rig_schema_find(schema, refusal->section, key);
        if (row < 0) {
            continue;
        }
        first = first < 0 ? row : first;
        const rig_origin_t *origin = &config->origin[row];
        if (origin->file >= 0 || origin->line == 0) {
            return row;
        }
    }
    return first;
}

void refusal_report(const rig_config_t *config, lode_status_t status) {
    const refusal_t *refusal = find(status);
    const int row = refusal != NULL ? culprit(config, refusal) : -1;
    if (row < 0) {
        rig_error("the library refused the configuration: %s", lode_status_name(status));
        return;
    }
    const rig_origin_t *origin = &config->origin[row];
    const char *file = origin->file >= 0   ? config->file[origin->file]
                       : origin->line == 0 ? "--set"
                                           : "computed value";
    rig_error_at(file, origin->file >= 0 ? origin->line : 0, "[%s] %s: %s: expected %s",
                 refusal->section, rig_schema().row[row].key, lode_status_name(status),
                 refusal->expected);
}
