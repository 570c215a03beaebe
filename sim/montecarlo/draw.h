/// One case of a campaign: a machine of the catalogue, and a drive with wrong parameters.
///
/// The plant keeps the values of the machine's files; only the shaft's inertia is multiplied, for what is
/// coupled to it. All errors are in the drive's parameters. A case depends only on the machine's name, the seed
/// and the kind of errors, so that each can be repeated alone.
#ifndef MONTECARLO_DRAW_H
#define MONTECARLO_DRAW_H

#include "config/rig_config.h"
#include "support/names.h"

typedef enum { MC_START, MC_RUN, MC_FLY, MC_QUIET, MC_OPEN_PHASE } mc_test_t;

/// The component that breaks while the drive runs.
typedef enum { MC_BREAKS_HIGH, MC_BREAKS_LOW, MC_BREAKS_WIRE, MC_BREAKS } mc_breaks_t;

/// MC_OPEN_PHASE: what breaks, in which state and when.
typedef struct {
    mc_breaks_t what;
    int leg;
    double omega_e_rad_s; ///< magnitude
    double load_share;    ///< of 100 % torque, passive
    double turn;          ///< 0 .. 1 of an electrical turn after speed and load have settled
} mc_break_t;

/// COMMISSIONED: narrow errors, which the drive's commissioning then corrects.
typedef enum {
    MC_ERRORS_NARROW,
    MC_ERRORS_WIDE,
    MC_ERRORS_START,
    MC_ERRORS_COMMISSIONED
} mc_errors_t;

/// A machine with its true values.
typedef struct {
    char name[NAMES_LENGTH];
    rig_config_t given;   ///< its files, read and completed; nothing computed yet
    double torque_Nm;     ///< 100 %: at i_max/1.5 with id = 0
    double torque_max_Nm; ///< at i_max
    /// 100 % of speed: rated, at most 0.9 of base speed and 0.95 of the estimator's limit
    double full_e_rad_s;
    double rated_e_rad_s;
    double bus_e_rad_s; ///< above it the EMF drives a current through the diodes
    double np;
    bool has_emf; ///< lode_start_has_emf() of the machine with its true values
} mc_machine_t;

typedef struct {
    rig_config_t config;  ///< parameters of the drive, designed
    plant_config_t plant; ///< the truth
    double slow_e_rad_s;  ///< 20 %, or 1.5 times the hand-over speed for the drive's parameters
    double direction;     ///< 1 or -1
    double start_load_Nm; ///< MC_START: mean of the passive load
    double coast_e_rad_s; ///< MC_FLY: initial speed of the rotor
    mc_break_t breaks;
    const char *unfit; ///< why commissioning failed; NULL: it did not, or was not used
} mc_case_t;

/// Reads motors/NAME, drives/NAME and, if there is one, plants/NAME, then applies `set`. False after a message.
bool mc_machine_load(mc_machine_t *machine, const char *name, int sets, const char *const *set);

/// False after a message if the plant refuses the files.
bool mc_draw(mc_case_t *one, const mc_machine_t *machine, mc_test_t test, mc_errors_t errors,
             uint64_t seed);

#endif
