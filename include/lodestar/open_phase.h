/// Detects a phase without one half-wave (a switch that stays off) or without both (a broken wire). With six phases
/// the others carry that current instead (V9); with three phases the current that the reference requires does not
/// flow (K24).
#ifndef LODESTAR_OPEN_PHASE_H
#define LODESTAR_OPEN_PHASE_H

#include "lodestar/frames.h"
#include "lodestar/status.h"
#include "lodestar/vsd.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Number of an open phase: 0 none, 1 .. 3 set 1, 4 .. 6 set 2, 7 all of set 1, 8 all of set 2.
typedef uint_least8_t lode_open_phase_t;

#define LODE_OPEN_SET_1 7u
#define LODE_OPEN_SET_2 8u

/// The set of an open phase, 0 or 1.
static inline int32_t lode_open_phase_set(lode_open_phase_t open) {
    return open <= 3u || open == LODE_OPEN_SET_1 ? 0 : 1;
}

/// Limits. A half-wave counts up while it is missing, and its phase is open when the count is full.
typedef struct {
    float least_A; ///< least current required of a phase; below it nothing can be decided
    float per_rad; ///< share of the full count per radian of the vector's turn
    float most;    ///< largest share of the full count per check
} lode_open_phase_tuning_t;

#define LODE_HALF_WAVES 6 // of a set: three positive ones, then three negative ones

/// Counts of a set of three phases.
typedef struct {
    uint_least16_t lacks[LODE_HALF_WAVES]; ///< count by half-wave: how long it has been missing
    uint_least16_t idle;                   ///< count of too little current to decide
    uint_least8_t doubts;                  ///< 1: a half-wave has been missing
    lode_dq_t ref_A;                       ///< current reference one round ago
} lode_half_waves_t;

/// Counts of one of two sets.
typedef struct {
    lode_half_waves_t waves;
    uint_least16_t all; ///< count of no current in the whole set
} lode_lacking_t;

/// State for six phases.
typedef struct {
    lode_lacking_t set[LODE_SETS];
    bool doubts; ///< a half-wave has been missing
} lode_open_phase_watch_t;

/// Tuning for six phases. `xy_rad_s`: rate at which the currents of the xy plane decay. `interval_s`: time between two
/// checks of a set.
lode_open_phase_tuning_t lode_open_phase_tune(float i_max_A, float xy_rad_s, float interval_s);

/// Tuning for three phases. `control_rad_s`: bandwidth of current control. `interval_s`: time between two checks.
lode_open_phase_tuning_t lode_half_waves_tune(float i_max_A, float control_rad_s, float interval_s);

void lode_open_phase_reset(lode_open_phase_watch_t *self);

#ifdef __cplusplus
}
#endif

#endif
