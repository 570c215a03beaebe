#include "config/assumptions.h"

#include <math.h>
#include <string.h>

#include "config/ini_config.h"
#include "config/schema.h"
#include "support/units.h"

// Without a drive: a common switching frequency, and a bus voltage and a current that suit the motor.
#define F_PWM_Hz 10000.0f
#define F_PWM_STEP_Hz 5000.0f
#define F_PWM_MAX_Hz 100000.0f
#define PERIODS_PER_RAD 4.5f // 28 per turn, as in the drone drive of the catalogue
#define RATED_rpm 1500.0
#define CURRENT_SHARE 0.3 // of the current whose field equals the magnets'
#define VOLTAGE_RESERVE 1.25
#define DROP_SHARE 0.1 // of the phase voltage, at i_max: as in the machines of the catalogue
#define HARMONIC_SHARE 0.03

static void note(rig_config_t *config, const char *section, const char *key, const char *words) {
    if (!rig_config_is_given(config, section, key)) {
        config->origin[rig_schema_find(rig_schema(), section, key)].assumed = words;
    }
}

/// The bus voltage for the rated speed. Without a rated speed it is for 1500 rpm, and at least so high that the
/// drop across Rs is a small share of it: no motor is run below that, and small motors turn many times faster.
static void assume_bus(rig_config_t *config) {
    lode_inverter_config_t *inverter = &config->drive.inverter;
    const lode_motor_t *motor = &config->drive.motor;
    const double i_max = (double)inverter->i_max_A;
    const bool rated = !isnan(config->people.speed_rated_rpm);
    const double rpm = rated ? config->people.speed_rated_rpm : RATED_rpm;
    const double omega = rig_rad_s_from_rpm(rpm) * (double)motor->pole_pairs;
    const double flux = hypot((double)motor->psi_Wb, 0.5 * (double)motor->Lq_H * i_max);
    const double wanted = VOLTAGE_RESERVE * omega * flux;
    const double least = rated ? 0.0 : (double)motor->Rs_Ohm * i_max / DROP_SHARE;
    inverter->v_bus_V = (float)(sqrt(3.0) * fmax(wanted, least));
    note(config, "drive", "v_bus_V",
         rated            ? "enough for the rated speed"
         : least > wanted ? "ten times the drop across Rs at i_max"
                          : "enough for 1500 rpm");
}

/// High enough for the observer of a fast motor: PERIODS_PER_RAD periods per electrical radian.
static void assume_frequency(rig_config_t *config) {
    lode_drive_config_t trial = config->drive;
    trial.f_pwm_Hz = F_PWM_Hz;
    lode_drive_design(&trial);
    const float wanted = PERIODS_PER_RAD * trial.motor.omega_rated_rad_s;
    const bool fast = wanted > F_PWM_Hz && wanted <= F_PWM_MAX_Hz;
    config->drive.f_pwm_Hz = fast ? F_PWM_STEP_Hz * ceilf(wanted / F_PWM_STEP_Hz) : F_PWM_Hz;
    note(config, "drive", "f_pwm_Hz",
         fast ? "4.5 periods per radian at rated speed" : "a common frequency");
}

void assumptions_drive(rig_config_t *config) {
    lode_drive_config_t *drive = &config->drive;
    lode_inverter_config_t *inverter = &drive->inverter;
    const lode_motor_t *motor = &drive->motor;
    // A 0 that somebody has given stays, for the library to refuse.
    if (!rig_config_is_given(config, "drive", "i_max_A")) {
        inverter->i_max_A = (float)(CURRENT_SHARE * (double)motor->psi_Wb / (double)motor->Ld_H);
        note(config, "drive", "i_max_A", "0.3 psi/Ld; not a rating of the motor");
    }
    if (!rig_config_is_given(config, "drive", "v_bus_V")) {
        assume_bus(config);
    }
    if (!rig_config_is_given(config, "drive", "f_pwm_Hz")) {
        assume_frequency(config);
    }
}

void assumptions_note(rig_config_t *config) {
    static const struct {
        const char *section, *key, *words;
    } open[] = {
        {"motor", "B_Nms", "no friction"},
        {"motor", "speed_rated_rpm", "0.66 of what the bus allows at half of i_max"},
        {"drive", "dead_time_s", "no dead time"},
        {"drive", "v_drop_V", "switches without a drop"},
        {"drive", "r_on_Ohm", "switches without resistance"},
        {"drive", "pwm_ticks", "duties not quantised"},
        {"drive", "shunts", "a current sensor in each phase"},
        {"drive", "adc_bits", "a common resolution"},
        {"drive", "i_range_A", "1.3 times the trip current"},
        {"drive", "v_range_V", "1.6 times the bus voltage"},
    };
    for (size_t k = 0; k < sizeof open / sizeof open[0]; ++k) {
        note(config, open[k].section, open[k].key, open[k].words);
    }
}

static void assume(rig_config_t *config, const char *key, double *value, double otherwise,
                   const char *words) {
    if (isnan(*value)) {
        *value = otherwise;
        note(config, "plant", key, words);
    }
}

void assumptions_disturbances(rig_config_t *config) {
    rig_plant_t *plant = &config->plant;
    assume(config, "emf5_ratio", &plant->emf5_ratio, HARMONIC_SHARE, "3 % of the EMF");
    assume(config, "emf7_ratio", &plant->emf7_ratio, HARMONIC_SHARE, "3 % of the EMF");
    // Quantisation and the noise that comes with it.
    assume(config, "i_noise_A", &plant->i_noise_A, fabs((double)config->drive.sense.i_gain_A_count),
           "one ADC count");
}

void assumptions_print(FILE *file, const rig_config_t *config, const char *before) {
    const rig_schema_t schema = rig_schema();
    for (int k = 0; k < schema.rows; ++k) {
        if (config->origin[k].assumed != NULL) {
            char value[64];
            ini_config_value(config, k, value, sizeof value);
            (void)fprintf(file, "%sassumed: [%s] %s = %s: %s\n", before, schema.row[k].section,
                          schema.row[k].key, value, config->origin[k].assumed);
        }
    }
}
