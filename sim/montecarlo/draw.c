#include "montecarlo/draw.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "config/data_files.h"
#include "config/ini_config.h"
#include "config/speed_limits.h"
#include "rig/commission.h"
#include "support/diag.h"
#include "support/splitmix.h"
#include "support/units.h"

#define RATED_PER_MAX (1.0 / 1.5) // current at 100 % torque, as a share of i_max
#define BASE_SHARE 0.9            // room for a load step below base speed
#define ESTIMATOR_SHARE 0.95      // room for overshoot
#define SLOW_SHARE 0.2            // of full speed
#define PER_HANDOVER 1.5          // clear of the hand-over
#define START_LOAD_SHARE 0.8      // mean plus ripple of the load at the start, as a share of 100 %
#define COAST_STEPS 10u           // steps of the initial speed, up to rated speed
#define LEAST_LOAD_SHARE 0.1      // smallest load when a phase breaks
#define NOISE_COUNTS 0.5          // rms, of a current
#define OFFSET_SHARE 0.01         // of the ADC's range; calibrated before the start
#define GAIN_SHARE 0.02

/// Ranges of the parameters of the drive over the true ones; for R and J the reverse.
typedef struct {
    double R_low, R_high;
    double L_share, psi_share;
    double dead_time_share, dead_time_s;
    double J_low, J_high;
} ranges_t;

static ranges_t ranges_of(mc_errors_t errors) {
    switch (errors) {
    case MC_ERRORS_START:
        return (ranges_t){0.7, 1.5, 0.2, 0.1, 0.0, 1.0e-6, 0.3, 10.0};
    case MC_ERRORS_WIDE:
        return (ranges_t){0.7, 1.3, 0.2, 0.1, 0.4, 0.0, 0.25, 4.0};
    case MC_ERRORS_NARROW:
    case MC_ERRORS_COMMISSIONED:
    default:
        return (ranges_t){0.85, 1.15, 0.1, 0.05, 0.2, 0.0, 0.5, 2.0};
    }
}

bool mc_machine_load(mc_machine_t *machine, const char *name, int sets, const char *const *set) {
    rig_config_t *given = &machine->given;
    rig_config_init(given);
    (void)snprintf(machine->name, sizeof machine->name, "%s", name);
    bool good = data_files_load_pair(given, name);
    for (int k = 0; good && k < sets; ++k) {
        good = ini_config_set(given, "--set", set[k]);
    }
    if (!good || !rig_config_complete(given, RIG_NEED_DRIVE)) {
        return false;
    }
    rig_config_t designed = *given;
    rig_config_design(&designed);
    const lode_drive_config_t *drive = &designed.drive;
    machine->has_emf = lode_start_has_emf(&drive->start, &drive->inverter, &drive->motor);
    machine->np = (double)drive->motor.pole_pairs;
    machine->torque_max_Nm =
        (double)lode_motor_kt_Nm_A(&drive->motor) * (double)drive->inverter.i_max_A;
    machine->torque_Nm = RATED_PER_MAX * machine->torque_max_Nm;
    machine->rated_e_rad_s = (double)drive->motor.omega_rated_rad_s;
    machine->bus_e_rad_s =
        (double)drive->inverter.v_bus_V / (sqrt(3.0) * (double)drive->motor.psi_Wb);
    const speed_limits_t limits = speed_limits_of(drive);
    machine->full_e_rad_s =
        fmin(fmin((double)drive->motor.omega_rated_rad_s, ESTIMATOR_SHARE * limits.estimator_rad_s),
             BASE_SHARE * limits.base_rad_s);
    return true;
}

/// SplitMix64, started from the name and the seed, so that machines draw independently. Of a file its name alone counts: its
/// cases are the same in another folder.
static uint64_t begin(const char *name, uint64_t seed) {
    const char *folder_end = strrchr(name, '/');
    const char *first = folder_end != NULL ? folder_end + 1 : name;
    uint64_t hash = UINT64_C(0xCBF29CE484222325); // FNV-1a
    for (const char *at = first; *at != '\0'; ++at) {
        hash = (hash ^ (uint64_t)(unsigned char)*at) * UINT64_C(0x100000001B3);
    }
    return hash + seed * UINT64_C(0xD1B54A32D192ED03);
}

static double between(uint64_t *state, double low, double high) {
    return low + (high - low) * splitmix_uniform(state);
}

static double either_way(uint64_t *state, double share) {
    return between(state, -share, share);
}

/// Draws the parameters of motor and inverter in the drive.
static void tell_wrong(lode_drive_config_t *drive, const ranges_t *ranges, uint64_t *state) {
    lode_motor_t *motor = &drive->motor;
    lode_inverter_config_t *inverter = &drive->inverter;
    // A data sheet with one inductance has one error for both axes.
    const bool round = !(motor->Ld_H < motor->Lq_H) && !(motor->Ld_H > motor->Lq_H);
    const double R = between(state, ranges->R_low, ranges->R_high);
    const double Lq = 1.0 + either_way(state, ranges->L_share);
    const double Ld = 1.0 + either_way(state, ranges->L_share);
    const double psi = 1.0 + either_way(state, ranges->psi_share);
    const double dead_time = either_way(state, 1.0);
    motor->Rs_Ohm = (float)((double)motor->Rs_Ohm / R);
    motor->Lq_H = (float)((double)motor->Lq_H * Lq);
    motor->Ld_H = (float)((double)motor->Ld_H * (round ? Lq : Ld));
    motor->psi_Wb = (float)((double)motor->psi_Wb * psi);
    const double assumed_s =
        (double)inverter->dead_time_s * (1.0 + ranges->dead_time_share * dead_time) +
        ranges->dead_time_s * dead_time;
    inverter->dead_time_s = (float)fmax(assumed_s, 0.0);
}

/// Draws the true values: angle, inertia, and the errors of the board's sensors.
static void draw_truth(rig_config_t *truth, const ranges_t *ranges, uint64_t *state) {
    rig_plant_t *plant = &truth->plant;
    plant->theta0_deg = either_way(state, 180.0);
    const double coupled = isnan(plant->J_factor) ? 1.0 : plant->J_factor; // of --set or the file
    plant->J_factor = coupled * exp(between(state, log(ranges->J_low), log(ranges->J_high)));
    plant->i_noise_A = NOISE_COUNTS * fabs((double)truth->drive.sense.i_gain_A_count);
    for (int k = 0; k < PLANT_LEGS; ++k) {
        plant->i_offset_A[k] = either_way(state, OFFSET_SHARE * truth->board.i_range_A);
        plant->i_gain_error[k] = either_way(state, GAIN_SHARE);
    }
}

/// Commissioning of the drive with the wrong parameters and a free shaft. Uses the measured values in place of
/// them; returns why there are none, or NULL.
static const char *commission(rig_config_t *config, const plant_config_t *truth) {
    static commission_run_t run; // large
    plant_config_t plant = *truth;
    plant.load_Nm = 0.0;
    if (!commission_run_on(&run, config, &plant)) {
        return "refused";
    }
    const lode_commission_t *ended = commission_of(&run);
    if (ended->result != LODE_COMMISSION_DONE) {
        static char text[48];
        (void)snprintf(text, sizeof text, "%s, %s", lode_commission_result_name(ended->result),
                       lode_commission_name(ended->quantity));
        return text;
    }
    const lode_drive_config_t *found = lode_commission_config(ended);
    const float rated = config->given.motor.omega_rated_rad_s; // the run may have had a lower one
    config->given.motor = found->motor;
    config->given.motor.omega_rated_rad_s = rated;
    config->given.inverter = found->inverter;
    config->given.references.Lq_fall = found->references.Lq_fall;
    if (run.sets > 1) {
        config->given_six.Lxy_H = lode_commission6_config(&run.commission)->Lxy_H;
        config->six = config->given_six;
    }
    config->drive = config->given;
    rig_config_design(config);
    return NULL;
}

/// Consecutive seeds go through all speeds, in both directions.
static double coast_share(uint64_t seed) {
    return (double)(seed % (2u * COAST_STEPS + 1u)) / COAST_STEPS - 1.0;
}

/// Half of the loads are below a third.
static mc_break_t draw_break(const mc_case_t *one, const mc_machine_t *machine, uint64_t *state) {
    const int legs = one->plant.sets * PLANT_PHASES;
    return (mc_break_t){
        .what = (mc_breaks_t)(splitmix_uniform(state) * (double)MC_BREAKS),
        .leg = (int)(splitmix_uniform(state) * legs),
        .omega_e_rad_s = between(state, one->slow_e_rad_s, machine->full_e_rad_s),
        .load_share = exp(between(state, log(LEAST_LOAD_SHARE), 0.0)),
        .turn = splitmix_uniform(state),
    };
}

bool mc_draw(mc_case_t *one, const mc_machine_t *machine, mc_test_t test, mc_errors_t errors,
             uint64_t seed) {
    const ranges_t ranges = ranges_of(errors);
    uint64_t state = begin(machine->name, seed);
    double none = 0.0;
    rig_config_t *truth = &one->config; // holds the true values until the plant is made
    *truth = machine->given;
    truth->scenario.seed = (double)(state >> 11);
    draw_truth(truth, &ranges, &state);
    rig_config_design(truth);
    if (!rig_config_plant(truth, &one->plant, &none)) {
        rig_error("%s: the plant refuses this machine", machine->name);
        return false;
    }
    one->config = machine->given;
    tell_wrong(&one->config.drive, &ranges, &state);
    one->config.given = one->config.drive;
    rig_config_design(&one->config);
    one->unfit = NULL;
    if (errors == MC_ERRORS_COMMISSIONED) {
        one->unfit = commission(&one->config, &one->plant);
    }
    one->direction = splitmix_uniform(&state) < 0.5 ? -1.0 : 1.0;
    const double peak_Nm = splitmix_uniform(&state) * START_LOAD_SHARE * machine->torque_Nm;
    one->start_load_Nm = test == MC_START ? peak_Nm / (1.0 + one->plant.load_ripple) : 0.0;
    one->slow_e_rad_s = fmax(SLOW_SHARE * machine->full_e_rad_s,
                             PER_HANDOVER * (double)one->config.drive.start.omega_handover_rad_s);
    one->slow_e_rad_s = fmin(one->slow_e_rad_s, machine->full_e_rad_s);
    one->coast_e_rad_s = test == MC_FLY ? coast_share(seed) * machine->rated_e_rad_s : 0.0;
    one->breaks = draw_break(one, machine, &state);
    return true;
}
