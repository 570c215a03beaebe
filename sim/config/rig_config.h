/// Everything that INI files and --set can say: drive, plant, scenario.
#ifndef RIG_CONFIG_H
#define RIG_CONFIG_H

#include <stdbool.h>
#include <stdint.h>

#include "config/data_sheet.h"
#include "lodestar/drive6.h"
#include "plant/plant.h"

enum {
    RIG_PATH_LENGTH = 512,
    RIG_NAME_LENGTH = 32,
    RIG_FILES_MAX = 8,
    RIG_KEYS_MAX = 320,
    RIG_PHASE_KEYS_MAX = 40,
    RIG_PHASES_MAX = 48,
    RIG_ORDER_SET = 1000 ///< of the command line, after all files
};

/// A double that no file has set.
#define RIG_UNSET NAN
/// A value that is drawn at random.
#define RIG_RANDOM HUGE_VAL

/// The board's ADC, which gives gains and offsets.
typedef struct {
    double adc_bits;
    double i_range_A; ///< current at either end of the ADC's range
    double v_range_V; ///< bus voltage at full scale
} rig_board_t;

/// Additional values of six phases.
typedef struct {
    float Lxy_H;
    lode_source_t source;
    lode_xy_config_t xy;
    lode_open_phase_response_t open_phase;
} rig_six_t;

/// Values in common units; each replaces one field of the drive's configuration.
typedef struct {
    double speed_rated_rpm;
    double speed_max_rpm;
    double handover_rpm;
    double ramp_rpm_s;
    double kp_A_s_rad; ///< speed controller as the papers give it: amperes per mechanical rad/s
    double ki_A_rad;
} rig_convenience_t;

/// The true values, which the firmware does not know. Unset values are those of motor and drive.
typedef struct {
    double Rs_Ohm, Ld_H, Lq_H, Lxy_H, psi_Wb, J_kgm2, B_Nms;
    char flux_map[RIG_PATH_LENGTH];
    double i_sat_A, Lq_sat_H, id_sat_A, Ld_sat_H, i_cross_A, Ldq_H;
    double emf5_ratio, emf5_phase_deg, emf7_ratio, emf7_phase_deg;
    double emf11_ratio, emf11_phase_deg, emf13_ratio, emf13_phase_deg;
    int inverter;  ///< plant_level_t
    int load_kind; ///< 0 passive, 1 signed
    double load_ripple, stiction_Nm, cogging_Nm, cogging_per_turn;
    double fan_Nm, fan_rpm; ///< torque of a fan at a speed
    double J_factor;        ///< factor on J_kgm2 for what is coupled to the motor
    double load_J_kgm2, shaft_Nm_rad, shaft_Nms_rad, backlash_deg;
    double v_bus_V, bus_C_F, chopper_R_Ohm, dead_time_s, v_drop_V, v_diode_V, r_on_Ohm, pwm_ticks;
    double i_offset_A[PLANT_LEGS], i_gain_error[PLANT_LEGS];
    double i_noise_A, i_noise_share; ///< both add up; the share is of i_max_A
    double v_bus_noise_V, temperature_noise_degC, temperature_degC, sample_offset_s;
    double theta0_deg; ///< RIG_RANDOM: anywhere
    double speed0_rpm;
    // Half widths of uniform distributions, drawn for each seed.
    double Rs_spread, Lq_spread, J_spread, psi_spread; ///< relative
    double i_offset_spread_A;
    double load_spread_Nm; ///< a value of 0 .. this is added to the load of every phase
} rig_plant_t;

/// Source of the drive's estimate.
typedef enum {
    RIG_SOURCE_OWN,
    RIG_SOURCE_TRUTH, ///< the plant
    /// the plant until the drive runs and seeded_s is over, then `own` from the true angle and speed on
    RIG_SOURCE_SEEDED,
    RIG_SOURCE_ENCODER ///< an angle sensor on the plant's shaft
} rig_source_t;

/// The angle sensor of `source = encoder`.
typedef struct {
    double counts_per_turn; ///< of one mechanical turn; unset: 4096
    double offset_deg; ///< electrical, offset that the firmware assumes; unset: 0, the true one
    double bandwidth_rad_s; ///< unset: the library's
    int falls_back;         ///< 1: goes sensorless if the EMF disagrees
} rig_encoder_t;

/// Parameters that are adapted while the drive runs; 1: on.
typedef struct {
    int J, psi, Rs;
} rig_adaptation_t;

/// Reactions to faults (lode_supervisor_config_t); unset: the library's.
typedef struct {
    int reaction[LODE_CHECK_COUNT]; ///< lode_reaction_t
    double attempts;                ///< unset: none
    double wait_s, good_s;
    int active_short; ///< lode_choice_t
} rig_supervisor_t;

/// Limits of the supply's current (lode_supply_config_t); unset: none.
typedef struct {
    double battery_A;
    double regen_A; ///< infinite: "none", nothing is taken back
    double correct_s;
} rig_supply_t;

/// Derating by heat (lode_derate_config_t); all unset: none.
typedef struct {
    double i_continuous_A, winding_s, from_degC, to_degC;
    double heat; ///< of the winding at the start, over that of i_continuous_A; unset: 0
} rig_derate_t;

/// Brake chopper (lode_chopper_config_t); unset: none.
typedef struct {
    double on_V, full_V, R_Ohm, power_W, thermal_s;
} rig_chopper_t;

/// EMF observers by name: lode_emf_kind_t, then the papers' own forms.
enum { RIG_EMF_C_EULER = LODE_EMF_KINDS, RIG_EMF_GI_EULER, RIG_EMF_FA_EULER };

/// Position PLLs by name: the library has two orders, each with an optional notch.
typedef enum {
    RIG_PLL_LESO,
    RIG_PLL_QPLL,
    RIG_PLL_ENHANCED, ///< LESO-QPLL with the notch at 6 w (paper 1, Section 4)
    RIG_PLL_LESO_EULER,
    RIG_PLL_QPLL_EULER,
    RIG_PLL_ENHANCED_EULER
} rig_pll_t;

/// Compensation added to the PLL's angle.
typedef enum {
    RIG_COMPENSATION_AUTO, ///< exact; the papers' own forms: as printed
    RIG_COMPENSATION_EXACT,
    RIG_COMPENSATION_NONE,
    RIG_COMPENSATION_EQ30 ///< paper 1, eq. 30
} rig_compensation_t;

/// Hardware trip of both sets or of one.
typedef enum { RIG_TRIP_OFF, RIG_TRIP_ON, RIG_TRIP_SET_1, RIG_TRIP_SET_2 } rig_trip_t;

/// One phase of a scenario. Values that it leaves unset stay as they were.
typedef struct {
    char name[RIG_NAME_LENGTH];
    int line[RIG_PHASE_KEYS_MAX]; ///< where each key was given, 0: nowhere
    double duration_s;
    double settled_s; ///< no key: ends once the speed has been reached for so long; 0: it does not
    double about_s;   ///< no key: how long that is expected to take
    int mode;         ///< index into the list of mode names, -1: as before
    double speed_rpm; ///< commanded
    double commanded_rpm; ///< no key: the value from which speed_rpm was lowered; 0: not lowered
    int control;          ///< lode_control_t, -1: as before
    double torque_Nm;     ///< commanded, torque control
    double ramp_rpm_s;    ///< slope of the command itself; unset: a step
    double load_Nm;
    double v_bus_V;
    double temperature_degC;
    double dyno_rpm; ///< speed held by a dynamometer; RIG_RANDOM ("free"): the dynamometer lets go
    int trip;        ///< hardware trip: rig_trip_t, -1 as before
    int open_phase;  ///< this phase breaks, 0 .. 5 for a1 .. c2; -1: none
    int shorted;     ///< this switch of phase a1 is shorted from here on: 0 low, 1 high; -1: none
    int clear_fault; ///< 1: leave the fault state first
    /// from here on the firmware uses its motor's value times this factor; unset: as before
    double Lq_factor, Rs_factor;
    double d, q; ///< V or A, modes voltage and current
    double theta_deg, omega_rad_s;
    // Bars: limits that the phase must keep.
    double bar_dc_deg, bar_pp_deg, bar_error_deg, bar_speed_rpm, bar_torque_Nm, bar_Lq_percent;
    double bar_battery_A, bar_regen_A, bar_v_bus_V, bar_heat;
    int end_mode; ///< -1: any but a fault
} rig_phase_t;

typedef struct {
    char motor[RIG_PATH_LENGTH], drive[RIG_PATH_LENGTH], plant[RIG_PATH_LENGTH];
    double seed;
    double log_s; ///< time between logged rows; unset: from the length of the scenario
    int phases;
    rig_phase_t phase[RIG_PHASES_MAX];
} rig_scenario_t;

/// Source of the value of a key.
typedef struct {
    int file;            ///< index into `files`, -1: nowhere
    int line;            ///< 0: command line
    int order;           ///< the source with the larger one overrides the other
    const char *instead; ///< key of the section that was given instead of this one; NULL: this one
    const char *assumed; ///< reason of an assumed value, in words; NULL: not assumed
    bool measured;       ///< by the drive itself, which overrides the others
} rig_origin_t;

typedef struct {
    lode_drive_config_t drive; ///< also of six phases, with motor.sets = 2
    rig_six_t six;
    /// drive and six before the library computed the values that are not given
    lode_drive_config_t given;
    rig_six_t given_six;
    rig_board_t board;
    rig_convenience_t people;
    data_sheet_t sheet;
    rig_plant_t plant;
    rig_source_t source;
    double seeded_s; ///< unset: 0
    rig_encoder_t encoder;
    rig_adaptation_t adaptation;
    rig_supervisor_t supervisor;
    rig_supply_t supply;
    rig_derate_t derate;
    rig_chopper_t chopper;
    int emf;
    rig_pll_t pll;
    rig_compensation_t compensation;
    bool speed_of_eq14; ///< no key: qpll-euler follows eq. 14 literally
    bool continuous;    ///< no key: the papers' own forms in continuous time (rig/continuous.h)
    rig_scenario_t scenario;
    int readings; ///< number of files read so far
    int files;
    char file[RIG_FILES_MAX][RIG_PATH_LENGTH];
    rig_origin_t origin[RIG_KEYS_MAX]; ///< one per row of the schema
} rig_config_t;

/// Nothing set.
void rig_config_init(rig_config_t *config);

/// A file or an option gives the value.
bool rig_config_is_given(const rig_config_t *config, const char *section, const char *key);

/// Which values of the drive must be given.
typedef enum {
    RIG_NEED_MOTOR, ///< the motor only: the rest is assumed, and marked so
    RIG_NEED_DRIVE, ///< f_pwm, bus voltage and current as well
    RIG_NEED_BOARD  ///< also the ADC ranges: values for firmware are not assumed
} rig_need_t;

/// True if all of them are given; false after a message for each missing key.
bool rig_config_given(const rig_config_t *config, rig_need_t need);

/// Converts values in common units to the drive's units and fills the board's gains. False after a message: a
/// required value is missing, or given twice in two units.
bool rig_config_complete(rig_config_t *config, rig_need_t need);

/// True for a motor with two sets of windings.
bool rig_config_is_six(const rig_config_t *config);

/// The configuration as firmware gives it to the library: one set alone is designed from the given values, not
/// from the gains of both sets.
lode_drive6_config_t rig_config_six(const rig_config_t *config);

/// Lets the library compute every value of the drive that is not given.
void rig_config_design(rig_config_t *config);

/// The tuning that the library makes of the given values; of three phases only the member `drive`. On any error
/// `tuning` is left alone.
lode_status_t rig_config_tune(const rig_config_t *config, lode_drive6_tuning_t *tuning);

/// LODE_OK, or why the library refuses the drive.
lode_status_t rig_config_judge(const rig_config_t *config);

/// The plant that `config` describes, with everything random drawn from the scenario's seed. False
/// after a message.
bool rig_config_plant(const rig_config_t *config, plant_config_t *plant, double *extra_load_Nm);

/// False if every seed makes the same plant without noise. `config` makes a plant.
bool rig_config_is_random(const rig_config_t *config);

#endif
