/// What a drive makes of a fault: from a state that it has reached without one, until it has found the
/// fault or some time is over.
#ifndef RIG_FAULT_CASE_H
#define RIG_FAULT_CASE_H

#include "rig/inject.h"

/// Where the drive is when the fault comes.
typedef enum {
    FAULT_AT_STANDSTILL, ///< before calibration; then it is commanded to half speed
    FAULT_AT_START,      ///< the current vector turns the rotor up
    FAULT_AT_10,         ///< 10 % of full speed, or just above the least
    FAULT_AT_50,
    FAULT_AT_100,
    FAULT_AT_WEAKENING,
    FAULT_POINTS
} fault_point_t;

extern const char *const fault_point_name[FAULT_POINTS];

/// A motor with its drive, and the states that faults begin from.
typedef struct {
    rig_config_t config;
    plant_config_t plant;
    double full_rad_s;                ///< mechanical, 100 %
    double speed_rad_s[FAULT_POINTS]; ///< commanded when the fault comes; 0: below RUN
    bool left_out[FAULT_POINTS];      ///< the drive runs, but its speed does not settle
    rig_t at[FAULT_POINTS];
} fault_bench_t;

/// What was wrong while nothing was found; each held for 10 ms. All but the last make it silent.
enum {
    FAULT_HARM_ROTOR = 1,   ///< the estimate is off by more than 60 degrees
    FAULT_HARM_CURRENT = 2, ///< a phase carries more than 1.2 i_max
    FAULT_HARM_CONTROL = 4, ///< the current is off its reference's direction, or beyond i_max in
                            ///< it, by more than 0.3 i_max
    FAULT_HARM_SPEED =
        8, ///< in the end the speed is off the commanded one by more than 10 % of full
    FAULT_HARM_HEAT = 16,  ///< the power stage is hotter than its limit by 10 K
    FAULT_HARM_STUCK = 32, ///< the drive neither runs at the end nor says why
    FAULT_HARM_DIP =
        64 ///< the speed was off by as much for 0.1 s, and came back, as after a load step
};

/// It passes through a pipe: no pointers.
typedef struct {
    lode_check_t found; ///< NONE: nothing
    double found_s;     ///< since the fault began; NaN
    double peak_A;      ///< of a phase, in truth
    double back_deg;    ///< largest turn against the commanded direction, mechanical
    int harm;           ///< FAULT_HARM_..., before it was found
    int given_up; ///< starts given up for lost right after their hand-over, before it was found
    int tried;    ///< of a kind that comes in many: how many; 0: the state is left out
    int silent;   ///< ... and how many of them were silent
} fault_result_t;

/// Loads nothing: `config` is designed and accepted. False, after a message, where the drive does not
/// start, or does not run on.
bool fault_bench_init(fault_bench_t *self, const rig_config_t *config);

fault_result_t fault_case_run(const fault_bench_t *self, const inject_kind_t *kind,
                              fault_point_t point, uint64_t seed);

/// No fault although something was wrong.
bool fault_is_silent(const fault_result_t *result);

#endif
