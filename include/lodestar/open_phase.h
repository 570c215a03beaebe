/// Finds a phase that lacks the current of a half-wave, or of both: a switch that stays off, a broken wire. With six phases
/// the others of the machine carry it in its place; with three, current control has not got what it asks for.
#ifndef LODESTAR_OPEN_PHASE_H
#define LODESTAR_OPEN_PHASE_H

#include "lodestar/frames.h"
#include "lodestar/status.h"
#include "lodestar/vsd.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Open phases by number: 0 none, 1 .. 3 of set 1, 4 .. 6 of set 2, 7 and 8 all of set 1 and of set 2.
typedef uint_least8_t lode_open_phase_t;

/// The set that an open phase belongs to, 0 or 1.
static inline int32_t lode_open_phase_set(lode_open_phase_t open) {
    return open <= 3u || open == 7u ? 0 : 1;
}

typedef struct {
    float least_A; ///< asked of a phase, with less of which nothing can be told
    float per_rad; ///< of enough, per radian that the vector turns
    float most;    ///< of enough, by one look
} lode_open_phase_tuning_t;

#define LODE_HALF_WAVES 6 // of a set's phases: three positive ones, three negative ones

/// Of three phases.
typedef struct {
    uint_least16_t lacks[LODE_HALF_WAVES]; ///< for how much of enough it has been lacking
    uint_least16_t idle;                   ///< for how much there has been too little to tell
    uint_least8_t doubts;                  ///< 1: one of them has been lacking
    lode_dq_t asked_A;                     ///< a round ago
} lode_half_waves_t;

typedef struct {
    lode_half_waves_t waves;
    uint_least16_t all; ///< for how much the set has had no current
} lode_lacking_t;

typedef struct {
    lode_lacking_t set[LODE_SETS];
    bool doubts; ///< one of them has been lacking
} lode_open_phase_watch_t;

/// The currents of the xy plane die with `xy_rad_s`; a set is looked at every `look_s`.
lode_open_phase_tuning_t lode_open_phase_tune(float i_max_A, float xy_rad_s, float look_s);

/// Three phases: current control brings its error down with `control_rad_s`.
lode_open_phase_tuning_t lode_half_waves_tune(float i_max_A, float control_rad_s, float look_s);

void lode_open_phase_reset(lode_open_phase_watch_t *self);

#ifdef __cplusplus
}
#endif

#endif
