/// The response of a drive to a fault: from a state that it has reached without one, until it has found the
/// fault or the observation time is over.
#ifndef RIG_FAULT_CASE_H
#define RIG_FAULT_CASE_H

#include "rig/inject.h"

/// State of the drive when the fault begins.
typedef enum {
    FAULT_AT_STANDSTILL, ///< before calibration; then half speed is commanded
    FAULT_AT_START,      ///< the current vector accelerates the rotor
    FAULT_AT_10,         ///< 10 % of full speed, or just above the least speed
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
    double load_share; ///< of the torque of i_max in RUN up to the base speed; NaN: the default
    double full_rad_s; ///< mechanical, 100 %
    double base_rad_s; ///< mechanical
    double speed_rad_s[FAULT_POINTS]; ///< commanded when the fault begins; 0: below RUN
    bool left_out[FAULT_POINTS];      ///< the drive runs, but its speed does not settle
    rig_t at[FAULT_POINTS];
} fault_bench_t;

/// Harms while no fault was found; each held for 10 ms. Every one but the last makes the case silent.
enum {
    FAULT_HARM_ROTOR = 1,   ///< the estimate is off by more than 60 degrees
    FAULT_HARM_CURRENT = 2, ///< the current vector is longer than 1.2 i_max; or a phase carries
                            ///< more than that for 10 ms out of 50 ms, which need not be one piece
    FAULT_HARM_CONTROL = 4, ///< the current is off its reference's direction, or beyond i_max in
                            ///< it, by more than 0.3 i_max
    FAULT_HARM_SPEED =
        8, ///< in the end the speed is off the commanded one by more than 10 % of full
    FAULT_HARM_HEAT = 16,  ///< the power stage is 10 K above its limit
    FAULT_HARM_STUCK = 32, ///< at the end the drive is not in RUN and reports no reason
    FAULT_HARM_DIP =
        64 ///< the speed was off by as much for 0.1 s and recovered, as after a load step
};

/// It passes through a pipe, so it holds no pointers.
typedef struct {
    lode_check_t found; ///< NONE: not found
    lode_check_t named; ///< at the end of the observation time: `found`, or what replaced it since
    double found_s;     ///< since the fault began; NaN
    double peak_A;      ///< largest true phase current
    double over_s;   ///< time of a phase current, or a vector, beyond 1.2 i_max before it was found
    double back_deg; ///< largest turn against the commanded direction, mechanical
    int harm;        ///< FAULT_HARM_..., before it was found
    int given_up; ///< start attempts given up right after their hand-over, before the fault was found
    int tried;    ///< number of variants tried; 0: the state is left out
    int silent;   ///< number of variants that were silent
} fault_result_t;

/// `config` is already designed and accepted. `load_share`: as in fault_bench_t. False after a message if the drive
/// does not start or does not keep running.
bool fault_bench_init(fault_bench_t *self, const rig_config_t *config, double load_share);

fault_result_t fault_case_run(const fault_bench_t *self, const inject_kind_t *kind,
                              inject_place_t place, fault_point_t point, uint64_t seed);

/// The same for FAULT_BITS_MAX bits from `first` on, not beyond `last`, of a kind that flips one. `silent`: bit n is set
/// where the flip of bit first + n was silent.
fault_result_t fault_case_bits(const fault_bench_t *self, const inject_kind_t *kind,
                               fault_point_t point, uint64_t first, uint64_t last,
                               uint64_t *silent);

enum { FAULT_BITS_MAX = 64 };

/// The result of the variants of both: the worse one, and how many were silent.
fault_result_t fault_case_both(const fault_result_t *a, const fault_result_t *b);

/// True if no fault was reported although something was wrong.
bool fault_is_silent(const fault_result_t *result);

#endif
