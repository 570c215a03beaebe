#include "config/rig_config.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "config/assumptions.h"
#include "config/conversions.h"
#include "config/flux_map.h"
#include "config/ini_config.h"
#include "config/schema.h"
#include "support/diag.h"
#include "support/splitmix.h"
#include "support/units.h"

// A typical board: head-room above the trip current and the bus voltage.
#define RANGE_PER_TRIP 1.3
#define RANGE_PER_BUS 1.6
#define TRIP_PER_MAX 1.5
#define ADC_BITS 12.0
#define TEMPERATURE_ZERO_degC (-50.0)
#define TEMPERATURE_SPAN_degC 200.0
#define AMBIENT_degC 25.0
#define STAMP_Hz 1.0e6
#define NOTCH_K 0.5f // paper 1, Section 5

static void unset_all(rig_schema_t schema, void *object) {
    const double unset = RIG_UNSET;
    for (int k = 0; k < schema.rows; ++k) {
        const rig_key_t *key = &schema.row[k];
        if (key->kind == RIG_KEY_DOUBLE || key->kind == RIG_KEY_DOUBLE_OR) {
            memcpy((char *)object + key->offset, &unset, sizeof unset);
        }
    }
}

void rig_config_init(rig_config_t *config) {
    memset(config, 0, sizeof *config);
    unset_all(rig_schema(), config);
    for (int k = 0; k < RIG_KEYS_MAX; ++k) {
        config->origin[k] = (rig_origin_t){.file = -1, .line = -1};
    }
    config->plant.inverter = PLANT_SWITCHING;
    for (int k = 0; k < RIG_PHASES_MAX; ++k) {
        rig_phase_t *phase = &config->scenario.phase[k];
        unset_all(rig_phase_schema(), phase);
        phase->mode = -1;
        phase->control = -1;
        phase->trip = -1;
        phase->open_phase = -1;
        phase->shorted = -1;
        phase->end_mode = -1;
    }
}

bool rig_config_is_given(const rig_config_t *config, const char *section, const char *key) {
    const rig_origin_t *origin = &config->origin[rig_schema_find(rig_schema(), section, key)];
    return origin->file >= 0 || origin->line == 0;
}

/// `why`: behind "missing", why it is not assumed.
static bool all_given(const rig_config_t *config, const char *section, const char *const *key,
                      const char *why) {
    bool good = true;
    for (; *key != NULL; ++key) {
        if (!rig_config_is_given(config, section, *key)) {
            char others[512];
            conversions_instead_of(section, *key, others, sizeof others);
            rig_error_at(
                config->files > 0 ? config->file[0] : "command line", 0,
                "[%s] %s: missing%s; expected it in %s, or as --set %s.%s=VALUE%s%s", section, *key,
                why,
                strcmp(section, "drive") == 0
                    ? "the motor's file (`run`, `design` and `commission` take a file of its own: "
                      "--drive F.ini)"
                    : "a file",
                section, *key, others[0] != '\0' ? "; or one of " : "", others);
            good = false;
        }
    }
    return good;
}

static void default_to(double *value, double otherwise) {
    *value = isnan(*value) ? otherwise : *value;
}

/// Gains and offsets of the ADC. Currents are unsigned counts around mid-range.
static void fit_board(rig_config_t *config) {
    lode_drive_config_t *drive = &config->drive;
    rig_board_t *board = &config->board;
    const double i_trip = drive->guard.i_trip_A > 0.0f
                              ? (double)drive->guard.i_trip_A
                              : TRIP_PER_MAX * (double)drive->inverter.i_max_A;
    default_to(&board->adc_bits, ADC_BITS);
    default_to(&board->i_range_A, RANGE_PER_TRIP * i_trip);
    default_to(&board->v_range_V, RANGE_PER_BUS * (double)drive->inverter.v_bus_V);
    board->adc_bits = floor(board->adc_bits);
    const double steps = exp2(board->adc_bits);
    drive->sense.count_max = (float)(steps - 1.0);
    drive->sense.i_gain_A_count = (float)(2.0 * board->i_range_A / steps);
    drive->sense.i_offset_count = (float)(0.5 * steps);
    drive->sense.v_bus_gain_V_count = (float)(board->v_range_V / steps);
    drive->sense.temperature_gain_degC_count = (float)(TEMPERATURE_SPAN_degC / steps);
    drive->sense.temperature_offset_degC = (float)TEMPERATURE_ZERO_degC;
}

/// The papers' own observers work only with their own PLLs: if one is given, it selects the other one.
static bool pair_up(rig_config_t *config) {
    bool emf = config->emf >= RIG_EMF_C_EULER;
    bool pll = config->pll >= RIG_PLL_LESO_EULER;
    if (emf && !pll && !rig_config_is_given(config, "estimator", "pll")) {
        config->pll = (rig_pll_t)((int)config->pll + (int)RIG_PLL_LESO_EULER);
        pll = true;
    }
    if (pll && !emf && !rig_config_is_given(config, "estimator", "emf")) {
        config->emf = RIG_EMF_C_EULER;
        emf = true;
    }
    if (emf != pll) {
        rig_error(
            "[estimator] emf, pll: expected an observer and a PLL that both end in -euler, or "
            "neither");
    }
    return emf == pll;
}

static void choose_compensation(rig_config_t *config) {
    const bool euler = config->emf >= RIG_EMF_C_EULER;
    if (config->compensation == RIG_COMPENSATION_AUTO) {
        // Eq. 30 is the lag of the C-LESO; paper 2 compensates nothing.
        const bool eq30 = config->pll == RIG_PLL_ENHANCED_EULER && config->emf == RIG_EMF_C_EULER;
        const rig_compensation_t printed = eq30 ? RIG_COMPENSATION_EQ30 : RIG_COMPENSATION_NONE;
        config->compensation = euler ? printed : RIG_COMPENSATION_EXACT;
    }
    // With the papers' own forms, the library's counterpart, which starts the motor, keeps the exact compensation.
    const lode_lag_kind_t kinds[] = {LODE_LAG_EXACT, LODE_LAG_NONE,
                                     euler ? LODE_LAG_EXACT : LODE_LAG_EQ30};
    config->drive.estimator.compensation = kinds[config->compensation - RIG_COMPENSATION_EXACT];
}

/// Sets observer and PLL from their names. With the papers' own forms the library's counterpart is also set up,
/// for its gains and for the start.
static bool choose_estimator(rig_config_t *config) {
    static const lode_emf_kind_t counterparts[] = {LODE_EMF_C_LESO, LODE_EMF_GI_LESO,
                                                   LODE_EMF_FA_LESO};
    lode_estimator_config_t *estimator = &config->drive.estimator;
    if (!pair_up(config)) {
        return false;
    }
    choose_compensation(config);
    const rig_pll_t pll = config->pll;
    const bool second = pll == RIG_PLL_QPLL || pll == RIG_PLL_QPLL_EULER;
    estimator->emf.kind = config->emf < RIG_EMF_C_EULER
                              ? (lode_emf_kind_t)config->emf
                              : counterparts[config->emf - RIG_EMF_C_EULER];
    estimator->pll.kind = second ? LODE_PLL_QPLL : LODE_PLL_LESO;
    if (pll == RIG_PLL_ENHANCED || pll == RIG_PLL_ENHANCED_EULER) {
        estimator->notch_k = lode_given_or(estimator->notch_k, NOTCH_K);
    }
    return true;
}

bool rig_config_is_six(const rig_config_t *config) {
    return config->drive.motor.sets == 2.0f;
}

static lode_drive6_config_t six_of(const lode_drive_config_t *drive, const rig_six_t *six) {
    return (lode_drive6_config_t){
        .drive = *drive,
        .Lxy_H = six->Lxy_H,
        .source = six->source,
        .xy = six->xy,
        .open_phase = six->open_phase,
    };
}

lode_drive6_config_t rig_config_six(const rig_config_t *config) {
    return six_of(&config->given, &config->given_six);
}

void rig_config_design(rig_config_t *config) {
    if (!rig_config_is_six(config)) {
        lode_drive_design(&config->drive);
        return;
    }
    lode_drive6_config_t six = six_of(&config->drive, &config->six);
    lode_drive6_design(&six);
    config->drive = six.drive;
    config->six.xy = six.xy;
}

lode_status_t rig_config_tune(const rig_config_t *config, lode_drive6_tuning_t *tuning) {
    if (!rig_config_is_six(config)) {
        return lode_drive_tune(&tuning->drive, &config->given);
    }
    const lode_drive6_config_t six = rig_config_six(config);
    return lode_drive6_tune(tuning, &six);
}

lode_status_t rig_config_judge(const rig_config_t *config) {
    if (rig_config_is_six(config)) {
        lode_drive6_tuning_t tuning;
        const lode_drive6_config_t six = six_of(&config->drive, &config->six);
        return lode_drive6_tune(&tuning, &six);
    }
    lode_drive_tuning_t tuning;
    return lode_drive_tune(&tuning, &config->drive);
}

/// Six phases need one more inductance, and their step cannot be split to insert another estimate.
static bool check_six(const rig_config_t *config) {
    static const char *const motor[] = {"Lxy_H", NULL};
    if (!rig_config_is_six(config)) {
        return true;
    }
    if (!all_given(config, "motor", motor, "")) {
        return false;
    }
    if (config->source != RIG_SOURCE_OWN || config->emf >= RIG_EMF_C_EULER) {
        rig_error(
            "[estimator] source, emf: with six phases expected source = own and an observer of "
            "the library");
        return false;
    }
    return true;
}

bool rig_config_given(const rig_config_t *config, rig_need_t need) {
    static const char *const motor[] = {"pole_pairs", "Rs_Ohm", "Ld_H", "Lq_H",
                                        "psi_Wb",     "J_kgm2", NULL};
    static const char *const drive[] = {"f_pwm_Hz", "v_bus_V", "i_max_A", NULL};
    static const char *const board[] = {"i_range_A", "v_range_V", NULL};
    bool good = all_given(config, "motor", motor, "");
    good = (need == RIG_NEED_MOTOR || all_given(config, "drive", drive, "")) && good;
    return (need != RIG_NEED_BOARD ||
            all_given(config, "drive", board,
                      ", and --c needs it: an assumed value is not used for firmware")) &&
           good;
}

bool rig_config_complete(rig_config_t *config, rig_need_t need) {
    if (!conversions_apply(config) || !rig_config_given(config, need)) {
        return false;
    }
    if (need == RIG_NEED_MOTOR) {
        assumptions_drive(config);
    }
    config->drive.motor.sets = lode_given_or(config->drive.motor.sets, 1.0f);
    fit_board(config);
    assumptions_note(config);
    if (!choose_estimator(config) || !check_six(config)) {
        return false;
    }
    default_to(&config->scenario.seed, 1.0);
    config->given = config->drive;
    config->given_six = config->six;
    return true;
}

// ---- Plant --------------------------------------------------------------------------------------

/// Uniform in -1 .. 1.
static double either_way(uint64_t *state) {
    return 2.0 * splitmix_uniform(state) - 1.0;
}

static double or_else(double value, double otherwise) {
    return isnan(value) ? otherwise : value;
}

static double spread(double value, double share, double draw) {
    return value * (1.0 + or_else(share, 0.0) * draw);
}

static void describe_motor(const rig_config_t *config, plant_config_t *plant, uint64_t *state) {
    const rig_plant_t *truth = &config->plant;
    const lode_motor_t *motor = &config->drive.motor;
    // Every seed draws all values in this order, so that each keeps its value whichever others are in use.
    const double angle = either_way(state);
    const double draw_Rs = either_way(state);
    const double draw_Lq = either_way(state);
    const double draw_J = either_way(state);
    const double draw_psi = either_way(state);
    plant->sets = rig_config_is_six(config) ? PLANT_SETS : 1;
    plant->pole_pairs = (int)motor->pole_pairs;
    plant->Lxy_H = or_else(truth->Lxy_H, (double)config->six.Lxy_H);
    plant->Rs_Ohm =
        spread(or_else(truth->Rs_Ohm, (double)motor->Rs_Ohm), truth->Rs_spread, draw_Rs);
    plant->Ld_H = or_else(truth->Ld_H, (double)motor->Ld_H);
    plant->Lq_H = spread(or_else(truth->Lq_H, (double)motor->Lq_H), truth->Lq_spread, draw_Lq);
    plant->psi_Wb =
        spread(or_else(truth->psi_Wb, (double)motor->psi_Wb), truth->psi_spread, draw_psi);
    plant->J_kgm2 = spread(or_else(truth->J_kgm2, (double)motor->J_kgm2), truth->J_spread, draw_J);
    plant->B_Nms = or_else(truth->B_Nms, (double)motor->B_Nms);
    plant->i_sat_A = or_else(truth->i_sat_A, 0.0);
    plant->Lq_sat_H = or_else(truth->Lq_sat_H, plant->Lq_H);
    plant->id_sat_A = or_else(truth->id_sat_A, 0.0);
    plant->Ld_sat_H = or_else(truth->Ld_sat_H, plant->Ld_H);
    plant->i_cross_A = or_else(truth->i_cross_A, 0.0);
    plant->Ldq_H = or_else(truth->Ldq_H, 0.0);
    if (plant->map != NULL) {
        plant->psi_Wb = fmax(plant->map->psi_Wb, 0.0); // rounding may make it negative
        plant->Ld_H = plant->map->Ld_H;
        plant->Lq_H = plant->map->Lq_H;
    }
    plant->emf5_ratio = or_else(truth->emf5_ratio, 0.0);
    plant->emf5_phase_rad = rig_rad_from_deg(or_else(truth->emf5_phase_deg, 0.0));
    plant->emf7_ratio = or_else(truth->emf7_ratio, 0.0);
    plant->emf7_phase_rad = rig_rad_from_deg(or_else(truth->emf7_phase_deg, 0.0));
    plant->emf11_ratio = or_else(truth->emf11_ratio, 0.0);
    plant->emf11_phase_rad = rig_rad_from_deg(or_else(truth->emf11_phase_deg, 0.0));
    plant->emf13_ratio = or_else(truth->emf13_ratio, 0.0);
    plant->emf13_phase_rad = rig_rad_from_deg(or_else(truth->emf13_phase_deg, 0.0));
    const double theta0_deg = isinf(truth->theta0_deg) ? 180.0 * angle : truth->theta0_deg;
    plant->theta_e_rad = remainder(rig_rad_from_deg(or_else(theta0_deg, 0.0)), 2.0 * RIG_PI);
    plant->omega_m_rad_s = rig_rad_s_from_rpm(or_else(truth->speed0_rpm, 0.0));
}

/// A fan is given by its torque at a speed, by default the rated one.
static double fan_Nms2(const rig_config_t *config) {
    if (!(or_else(config->plant.fan_Nm, 0.0) > 0.0)) { // then no rated speed is needed
        return 0.0;
    }
    const double np = (double)config->drive.motor.pole_pairs;
    const double rated = (double)config->drive.motor.omega_rated_rad_s / np;
    const double rpm = or_else(config->plant.fan_rpm, rig_rpm_from_rad_s(rated));
    const double omega = rig_rad_s_from_rpm(rpm);
    return config->plant.fan_Nm / (omega * omega);
}

static void describe_load(const rig_config_t *config, plant_config_t *plant) {
    const rig_plant_t *truth = &config->plant;
    plant->load_is_passive = truth->load_kind == 0;
    plant->J_kgm2 *= or_else(truth->J_factor, 1.0);
    plant->load_ripple = or_else(truth->load_ripple, 0.0);
    plant->stiction_Nm = or_else(truth->stiction_Nm, 0.0);
    plant->fan_Nms2 = fan_Nms2(config);
    plant->cogging_Nm = or_else(truth->cogging_Nm, 0.0);
    plant->cogging_per_turn =
        or_else(truth->cogging_per_turn, 2.0 * (double)config->drive.motor.pole_pairs);
    plant->load_J_kgm2 = or_else(truth->load_J_kgm2, 0.0);
    plant->shaft_Nm_rad = or_else(truth->shaft_Nm_rad, 0.0);
    plant->shaft_Nms_rad = or_else(truth->shaft_Nms_rad, 0.0);
    plant->backlash_rad = rig_rad_from_deg(or_else(truth->backlash_deg, 0.0));
}

/// The current of the supply is to be reported.
static bool looks_at_supply(const rig_config_t *config) {
    bool looks = !isnan(config->supply.battery_A) || !isnan(config->supply.regen_A);
    for (int k = 0; k < config->scenario.phases; ++k) {
        const rig_phase_t *phase = &config->scenario.phase[k];
        looks = looks || !isnan(phase->bar_battery_A) || !isnan(phase->bar_regen_A) ||
                !isnan(phase->bar_v_bus_V);
    }
    return looks;
}

static void describe_inverter(const rig_config_t *config, plant_config_t *plant) {
    const rig_plant_t *truth = &config->plant;
    const lode_inverter_config_t *inverter = &config->drive.inverter;
    plant->level = (plant_level_t)truth->inverter;
    plant->period_s = 1.0 / (double)config->drive.f_pwm_Hz;
    plant->double_update = inverter->double_update == LODE_ON;
    plant->v_bus_V = or_else(truth->v_bus_V, (double)inverter->v_bus_V);
    plant->bus_C_F = or_else(truth->bus_C_F, 0.0);
    plant->chopper_R_Ohm = or_else(truth->chopper_R_Ohm, or_else(config->chopper.R_Ohm, 0.0));
    plant->keeps_accounts =
        plant->keeps_accounts || plant->bus_C_F > 0.0 || looks_at_supply(config);
    plant->dead_time_s = or_else(truth->dead_time_s, (double)inverter->dead_time_s);
    plant->v_transistor_V = or_else(truth->v_drop_V, (double)inverter->v_drop_V);
    plant->v_diode_V = or_else(truth->v_diode_V, plant->v_transistor_V);
    plant->r_on_Ohm = or_else(truth->r_on_Ohm, (double)inverter->r_on_Ohm);
    plant->pwm_ticks = (uint32_t)or_else(truth->pwm_ticks, (double)inverter->pwm_ticks);
}

static void describe_board(const rig_config_t *config, plant_config_t *plant, uint64_t *state) {
    const rig_plant_t *truth = &config->plant;
    const double steps = exp2(config->board.adc_bits);
    const double stamp = (double)config->drive.guard.stamp_per_period;
    plant->adc_bits = (int)config->board.adc_bits;
    plant->i_A_per_count = 2.0 * config->board.i_range_A / steps;
    plant->v_bus_V_per_count = config->board.v_range_V / steps;
    plant->temperature_degC_per_count = TEMPERATURE_SPAN_degC / steps;
    plant->temperature_zero_degC = TEMPERATURE_ZERO_degC;
    plant->temperature_degC = or_else(truth->temperature_degC, AMBIENT_degC);
    plant->i_noise_A =
        hypot(or_else(truth->i_noise_A, 0.0),
              or_else(truth->i_noise_share, 0.0) * (double)config->drive.inverter.i_max_A);
    plant->v_bus_noise_V = or_else(truth->v_bus_noise_V, 0.0);
    plant->temperature_noise_degC = or_else(truth->temperature_noise_degC, 0.0);
    plant->sample_offset_s = or_else(truth->sample_offset_s, 0.0);
    plant->stamp_Hz = stamp > 0.0 ? stamp / plant->period_s : STAMP_Hz;
    for (int k = 0; k < plant->sets * PLANT_PHASES; ++k) {
        plant->i_offset_A[k] = or_else(truth->i_offset_A[k], 0.0) +
                               or_else(truth->i_offset_spread_A, 0.0) * either_way(state);
        plant->i_gain_error[k] = or_else(truth->i_gain_error[k], 0.0);
    }
}

/// Row of the given key: the plant's own, or the one that it defaults to; -1: none.
static int given_row(const rig_config_t *config, const char *key) {
    static const char *const sections[] = {"plant", "motor", "drive", "guard"};
    for (size_t k = 0; k < sizeof sections / sizeof sections[0]; ++k) {
        const int row = rig_schema_find(rig_schema(), sections[k], key);
        if (row >= 0 && rig_config_is_given(config, sections[k], key)) {
            return row;
        }
    }
    return -1;
}

/// `why` begins with the plant's name of the quantity, which is usually that of its key.
static void refuse_plant(const rig_config_t *config, const char *why) {
    char name[RIG_NAME_LENGTH];
    (void)snprintf(name, sizeof name, "%.*s", (int)strcspn(why, " ,"), why);
    const char *key = strcmp(name, "stamp_Hz") == 0 ? "stamp_per_period" : name;
    const int row = given_row(config, key);
    if (row < 0) {
        rig_error("[plant] %s", why);
        return;
    }
    const rig_origin_t *origin = &config->origin[row];
    char value[64];
    rig_key_print(&rig_schema().row[row], config, value, sizeof value);
    rig_error_at(origin->file >= 0 ? config->file[origin->file] : "--set", origin->line,
                 "[%s] %s = %s: refused by the plant: %s", rig_schema().row[row].section, key,
                 value, why);
}

/// Relative to the file that names it or, with --set, to the current folder.
static bool find_map(const rig_config_t *config, const plant_map_t **map) {
    char path[RIG_PATH_LENGTH];
    *map = NULL;
    if (!rig_config_is_given(config, "plant", "flux_map")) {
        return true;
    }
    const rig_origin_t *origin =
        &config->origin[rig_schema_find(rig_schema(), "plant", "flux_map")];
    const char *from = origin->file >= 0 ? config->file[origin->file] : "";
    if (!ini_config_relative(from, config->plant.flux_map, path, sizeof path)) {
        rig_error_at(from, origin->line,
                     "[plant] flux_map: expected a path of at most %zu characters",
                     sizeof path - 1);
        return false;
    }
    *map = flux_map_find(path);
    return *map != NULL;
}

/// Refuses values of a shaft between two masses without the second mass.
static bool check_masses(const rig_config_t *config) {
    static const char *const shaft[] = {"backlash_deg", "shaft_Nm_rad", "shaft_Nms_rad"};
    enum { SHAFT_KEYS = sizeof shaft / sizeof shaft[0] };
    const rig_plant_t *truth = &config->plant;
    const double value[] = {truth->backlash_deg, truth->shaft_Nm_rad, truth->shaft_Nms_rad};
    for (int k = 0; isnan(truth->load_J_kgm2) && k < SHAFT_KEYS; ++k) {
        if (value[k] > 0.0) {
            const rig_origin_t *origin =
                &config->origin[rig_schema_find(rig_schema(), "plant", shaft[k])];
            rig_error_at(origin->file >= 0 ? config->file[origin->file] : "--set", origin->line,
                         "[plant] %s = %g: needs a second mass; expected load_J_kgm2%s as well",
                         shaft[k], value[k], isnan(truth->shaft_Nm_rad) ? " and shaft_Nm_rad" : "");
            return false;
        }
    }
    return true;
}

/// Refuses values that a signed load does not have.
static bool check_stiction(const rig_config_t *config) {
    const rig_plant_t *truth = &config->plant;
    if (truth->stiction_Nm > 0.0 && truth->load_kind != 0) {
        const rig_origin_t *origin =
            &config->origin[rig_schema_find(rig_schema(), "plant", "stiction_Nm")];
        rig_error_at(origin->file >= 0 ? config->file[origin->file] : "--set", origin->line,
                     "[plant] stiction_Nm = %g: applies only to a passive load; expected load_kind "
                     "= passive as well",
                     truth->stiction_Nm);
        return false;
    }
    return true;
}

bool rig_config_plant(const rig_config_t *config, plant_config_t *plant, double *extra_load_Nm) {
    uint64_t state = (uint64_t)config->scenario.seed;
    memset(plant, 0, sizeof *plant);
    plant->seed = state;
    if (!check_masses(config) || !check_stiction(config) || !find_map(config, &plant->map)) {
        return false;
    }
    describe_motor(config, plant, &state);
    describe_load(config, plant);
    describe_inverter(config, plant);
    describe_board(config, plant, &state);
    *extra_load_Nm = or_else(config->plant.load_spread_Nm, 0.0) * splitmix_uniform(&state);
    plant_t trial;
    const char *why = plant_init(&trial, plant);
    if (why != NULL) {
        refuse_plant(config, why);
    }
    return why == NULL;
}

bool rig_config_is_random(const rig_config_t *config) {
    static rig_config_t other; // large
    plant_config_t plant[2];
    double load_Nm[2];
    other = *config;
    other.scenario.seed += 1.0;
    if (!rig_config_plant(config, &plant[0], &load_Nm[0]) ||
        !rig_config_plant(&other, &plant[1], &load_Nm[1])) {
        return true;
    }
    const bool noisy = plant[0].i_noise_A > 0.0 || plant[0].v_bus_noise_V > 0.0 ||
                       plant[0].temperature_noise_degC > 0.0;
    plant[1].seed = plant[0].seed;
    return noisy || memcmp(&plant[0], &plant[1], sizeof plant[0]) != 0 ||
           memcmp(&load_Nm[0], &load_Nm[1], sizeof load_Nm[0]) != 0;
}
