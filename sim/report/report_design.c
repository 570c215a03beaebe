#include "report/report_design.h"

#include <math.h>
#include <string.h>

#include "config/assumptions.h"
#include "config/config_json.h"
#include "config/ini_config.h"
#include "config/ini_write.h"
#include "config/schema.h"
#include "report/report_guide.h"
#include "report/report_injection.h"
#include "report/report_motor.h"
#include "report/report_verdict.h"
#include "support/units.h"

// ---- Text ---------------------------------------------------------------------------------------

static void print_values(FILE *file, const rig_config_t *config) {
    const rig_schema_t schema = rig_schema();
    const char *section = "";
    for (int k = 0; k < schema.rows; ++k) {
        const rig_key_t *key = &schema.row[k];
        char value[RIG_PATH_LENGTH];
        char where[RIG_PATH_LENGTH + 16];
        rig_key_print(key, config, value, sizeof value);
        if (value[0] == '\0' || !ini_write_is_of_drive(config, key)) {
            continue;
        }
        if (strcmp(section, key->section) != 0) {
            section = key->section;
            (void)fprintf(file, "\n[%s]\n", section);
        }
        ini_config_where(config, k, where, sizeof where);
        double number = 0.0;
        const bool is_none = rig_key_number(key, config, &number) && isinf(number); // cannot be
        (void)fprintf(file, "%-22s = %-12s ; %s\n", key->key, is_none ? "-" : value, where);
    }
}

static void print_margin(FILE *file, int width, double value) {
    if (isnan(value)) {
        (void)fprintf(file, " %*s", width, "-");
    } else {
        (void)fprintf(file, " %*.1f", width, value);
    }
}

static void print_lags(FILE *file, const design_t *design) {
    (void)fputs("\nlag of the EMF observer, electrical degrees, and the EMF\n"
                "     rpm    rad/s   EMF [V]     exact  polynomial    differ   eq. (30)\n",
                file);
    for (int k = 0; k < DESIGN_SPEEDS; ++k) {
        const design_speed_t *at = &design->at[k];
        (void)fprintf(file, "%8.1f %8.1f %9.2f %9.3f %11.3f %9.4f %10.3f\n", at->speed_rpm,
                      at->omega_rad_s, at->emf_V, at->lag_deg, at->lag_polynomial_deg,
                      at->lag_polynomial_deg - at->lag_deg, at->lag_eq30_deg);
    }
}

static void print_margins(FILE *file, const design_t *design) {
    (void)fputs(
        "\nstability of the PLL, alone and with the observer in its loop. The PLL's speed tunes "
        "the\nobserver and so closes a second loop; with C-LESO it closes through currents and "
        "EMF\n     rpm    sigma  crossover  margin alone |  margin  gain up  gain down   sigma at\n"
        "             rad/s      rad/s       deg el. |     deg       dB         dB   no margin\n",
        file);
    for (int k = 0; k < DESIGN_SPEEDS; ++k) {
        const margins_t *m = &design->at[k].margins;
        (void)fprintf(file, "%8.1f", design->at[k].speed_rpm);
        print_margin(file, 8, m->sigma_rad_s);
        print_margin(file, 10, m->crossover_rad_s);
        print_margin(file, 13, m->phase_alone_deg);
        (void)fputs(" |", file);
        print_margin(file, 7, m->phase_deg);
        print_margin(file, 8, m->gain_up_dB);
        print_margin(file, 10, m->gain_down_dB);
        print_margin(file, 11, m->sigma_limit_rad_s);
        (void)fputc('\n', file);
    }
    (void)fprintf(file, "the library accepts sigma up to %.1f rad/s with this observer\n",
                  design->sigma_accepted_rad_s);
}

static void print_bandwidths(FILE *file, const rig_config_t *config, const design_t *design) {
    const lode_drive_config_t *drive = &config->drive;
    const double current = design->current_bandwidth_rad_s;
    const double observer = (double)drive->estimator.emf.w0_rad_s;
    const double sigma = (double)drive->estimator.pll.sigma_rad_s;
    const double sigma_low = (double)drive->estimator.pll.sigma_low_rad_s;
    const double speed = design->speed_bandwidth_rad_s;
    (void)fprintf(file,
                  "\nbandwidths, rad/s\n"
                  "sampling (2 pi f_pwm)  %9.0f\n"
                  "current control        %9.1f\n"
                  "EMF observer (w0)      %9.1f   %.1f times the rated electrical speed\n"
                  "PLL (sigma)            %9.1f   1/%.1f of the observer\n"
                  "PLL at low speed       %9.1f   1/%.1f of the observer\n"
                  "speed control (kp/J)   %9.1f   1/%.1f of the PLL at low speed\n",
                  6.283185307 * (double)drive->f_pwm_Hz, current, observer,
                  observer / (double)drive->motor.omega_rated_rad_s, sigma, observer / sigma,
                  sigma_low, observer / sigma_low, speed, sigma_low / speed);
}

static void print_speed(FILE *file, const rig_config_t *config, const char *name,
                        double omega_rad_s, const char *words) {
    const double rpm = rig_rpm_from_rad_s(omega_rad_s) / (double)config->drive.motor.pole_pairs;
    if (isinf(rpm)) {
        (void)fprintf(file, "%-16s      none   %s\n", name, words);
    } else {
        (void)fprintf(file, "%-16s %9.1f   %s\n", name, rpm, words);
    }
}

static void print_speeds(FILE *file, const rig_config_t *config, const speed_limits_t *speeds) {
    const lode_drive_config_t *drive = &config->drive;
    const int row = rig_schema_find(rig_schema(), "motor", "speed_rated_rpm");
    const char *assumed = config->origin[row].assumed;
    char rated[96];
    char base[96];
    (void)snprintf(rated, sizeof rated, "%s%s", assumed != NULL ? "assumed: " : "",
                   assumed != NULL ? assumed : "as given");
    const double id_A = speed_limits_id_A(drive, speeds->base_rad_s);
    (void)snprintf(base, sizeof base, "i_max uses up the voltage (%g A, %s: id* = %.3g A)",
                   (double)drive->inverter.i_max_A,
                   drive->references.kind == LODE_REFERENCES_MTPA ? "mtpa" : "id0",
                   round(1.0e3 * id_A) / 1.0e3 + 0.0);
    (void)fputs("\nspeeds, rpm, at the nominal bus voltage\n", file);
    print_speed(file, config, "hand-over", (double)drive->start.omega_handover_rad_s,
                drive->hfi.mode == LODE_HFI_ON
                    ? "from the start to the EMF; slower commands are kept, by signal injection"
                    : "from the start to the estimator; slower commands are raised to "
                      "omega_min_rad_s");
    print_speed(file, config, "rated", (double)drive->motor.omega_rated_rad_s, rated);
    print_speed(file, config, "base speed", speeds->base_rad_s, base);
    print_speed(file, config, "no-load limit", speeds->no_load_rad_s,
                "the magnets' EMF alone uses up the voltage");
    if (!isnan(speeds->weakened_rad_s)) {
        print_speed(file, config, "weakened limit", speeds->weakened_rad_s,
                    "the same with field weakening by id_max_A; none: no such speed");
    }
    print_speed(file, config, "estimator limit", speeds->estimator_rad_s,
                "omega_max_rad_s, the limit of the estimator, not of the voltage");
}

/// Whether bridge and sensors are tested before a start, with which pulses, or why not.
static void print_signal_check(FILE *file, const rig_config_t *config, const design_t *design) {
    const lode_start_config_t *start = &config->drive.start;
    if (config->drive.motor.sets > 1.0f) { // two sets have pulses of their own
        return;
    }
    (void)fputs("before a start: bridge and sensors are ", file);
    if (!isnan(design->signal_check_V)) {
        (void)fprintf(file, "tested with pulses of %.4g V, which drive up to %.3g A\n",
                      design->signal_check_V, design->signal_check_A);
    } else if (start->signal_check == LODE_OFF) {
        (void)fputs("not tested: start.signal_check is off\n", file);
    } else if (start->signal_check == LODE_AUTO &&
               (start->pulses == LODE_OFF || !(start->catch_s > 0.0f))) {
        (void)fputs(
            "not tested: start.pulses or start.catch_s is off, and start.signal_check is not on\n",
            file);
    } else {
        (void)fputs("not tested: dead time takes too much of a pulse, or the current of a pulse is "
                    "below 64 counts\n",
                    file);
    }
}

static void print_limits(FILE *file, const rig_config_t *config, const design_t *design) {
    print_speeds(file, config, &design->speeds);
    const int dead_time = rig_schema_find(rig_schema(), "drive", "dead_time_s");
    (void)fprintf(file,
                  "\nlimits\n"
                  "torque: %.4g Nm at i_max, %.4g Nm at the start current\n",
                  design->torque_max_Nm, design->start_current_torque_Nm);
    if (config->origin[dead_time].assumed != NULL) {
        (void)fputs("low speed: the effect of the dead time is not known, because dead_time_s is "
                    "not given\n",
                    file);
    } else {
        (void)fprintf(
            file,
            "low speed: dead time takes %.2f V (4/pi Td f v_bus), as much as the EMF at %.1f rpm;\n"
            "           below about that speed the dead-time correction decides the angle error\n",
            design->dead_time_V, design->dead_time_equal_rpm);
    }
    if (!lode_start_has_emf(&config->drive.start, &config->drive.inverter, &config->drive.motor)) {
        (void)fputs("no usable EMF: up to half of base speed it is less than a quarter of the "
                    "resistive drop at\n           the start current. A gain error of 2 % in one "
                    "current sensor makes that drop\n           pulsate twice per turn: the "
                    "sensors limit starts and low speeds\n",
                    file);
    }
    (void)fprintf(file, "Lq: each percent of error costs %.2f degrees at i_max (%g A) and id = 0\n",
                  design->angle_per_Lq_percent_deg, (double)config->drive.inverter.i_max_A);
    if (!isnan(design->hexagon.fundamental)) {
        (void)fprintf(file,
                      "over-modulation: voltage_use %g gives at most %.3f v_bus/sqrt(3), with a "
                      "ripple of %.1f %% six times\n           per turn; the angle error that it "
                      "makes is not part of the verdict: see `run`\n",
                      (double)config->drive.current.voltage_use, design->hexagon.fundamental,
                      100.0 * design->hexagon.ripple);
    }
    print_signal_check(file, config, design);
}

void report_design_text(FILE *file, const rig_config_t *config, const design_t *design) {
    assumptions_print(file, config, "");
    (void)fputs("every value and its source", file);
    print_values(file, config);
    report_motor_text(file, &config->drive, design);
    print_bandwidths(file, config, design);
    print_margins(file, design);
    report_guide_text(file, config, design);
    print_lags(file, design);
    print_limits(file, config, design);
    report_injection_text(file, &config->drive, &design->injection);
    report_verdict_text(file, &config->drive, design);
}

// ---- JSON ---------------------------------------------------------------------------------------

static void add_speed(cJSON *array, const design_speed_t *at) {
    cJSON *item = config_json_item(array);
    config_json_number(item, "speed_rpm", at->speed_rpm);
    config_json_number(item, "omega_e_rad_s", at->omega_rad_s);
    config_json_number(item, "emf_V", at->emf_V);
    config_json_number(item, "lag_exact_deg", at->lag_deg);
    config_json_number(item, "lag_polynomial_deg", at->lag_polynomial_deg);
    config_json_number(item, "lag_eq30_deg", at->lag_eq30_deg);
    config_json_number(item, "sigma_rad_s", at->margins.sigma_rad_s);
    config_json_number(item, "crossover_rad_s", at->margins.crossover_rad_s);
    config_json_number(item, "phase_margin_alone_deg", at->margins.phase_alone_deg);
    config_json_number(item, "phase_margin_deg", at->margins.phase_deg);
    config_json_number(item, "gain_margin_up_dB", at->margins.gain_up_dB);
    config_json_number(item, "gain_margin_down_dB", at->margins.gain_down_dB);
    config_json_number(item, "sigma_limit_rad_s", at->margins.sigma_limit_rad_s);
    config_json_number(item, "pole_re_rad_s", creal(at->pole));
    config_json_number(item, "pole_im_rad_s", fabs(cimag(at->pole)));
    config_json_number(item, "pole_damping", joint_damping(at->pole));
}

static void add_rpm(cJSON *root, const rig_config_t *config, const char *name, double omega_rad_s) {
    config_json_number(root, name,
                       rig_rpm_from_rad_s(omega_rad_s) / (double)config->drive.motor.pole_pairs);
}

void report_design_json(FILE *file, const rig_config_t *config, const design_t *design) {
    cJSON *root = config_json_root();
    config_json_number(root, "rated_rpm", design->rated_rpm);
    config_json_number(root, "handover_rpm", design->handover_rpm);
    add_rpm(root, config, "base_speed_rpm", design->speeds.base_rad_s);
    add_rpm(root, config, "no_load_limit_rpm", design->speeds.no_load_rad_s);
    add_rpm(root, config, "weakened_limit_rpm", design->speeds.weakened_rad_s);
    add_rpm(root, config, "estimator_limit_rpm", design->speeds.estimator_rad_s);
    config_json_number(root, "current_bandwidth_rad_s", design->current_bandwidth_rad_s);
    config_json_number(root, "speed_bandwidth_rad_s", design->speed_bandwidth_rad_s);
    config_json_number(root, "torque_max_Nm", design->torque_max_Nm);
    config_json_number(root, "start_current_torque_Nm", design->start_current_torque_Nm);
    config_json_number(root, "sigma_accepted_rad_s", design->sigma_accepted_rad_s);
    config_json_number(root, "dead_time_V", design->dead_time_V);
    config_json_number(root, "dead_time_equal_rpm", design->dead_time_equal_rpm);
    (void)cJSON_AddBoolToObject(
        root, "usable_emf",
        lode_start_has_emf(&config->drive.start, &config->drive.inverter, &config->drive.motor));
    config_json_number(root, "hexagon_fundamental", design->hexagon.fundamental);
    config_json_number(root, "hexagon_ripple", design->hexagon.ripple);
    config_json_number(root, "signal_check_V", design->signal_check_V);
    config_json_number(root, "signal_check_A", design->signal_check_A);
    config_json_number(root, "angle_per_Lq_percent_deg", design->angle_per_Lq_percent_deg);
    cJSON *speeds = cJSON_AddArrayToObject(root, "speeds");
    for (int k = 0; k < DESIGN_SPEEDS; ++k) {
        add_speed(speeds, &design->at[k]);
    }
    report_guide_json(root, design);
    report_injection_json(root, &design->injection);
    report_motor_json(root, &config->drive, design);
    report_verdict_json(root, &config->drive, design);
    (void)cJSON_AddItemToObject(root, "assumed", config_json_assumed(config));
    (void)cJSON_AddItemToObject(root, "config", config_json(config));
    (void)config_json_write(file, root);
}
