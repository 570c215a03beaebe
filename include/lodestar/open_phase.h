/// Finds a phase that carries no current while the others of the machine do: a broken wire, a switch
/// that stays off.
#ifndef LODESTAR_OPEN_PHASE_H
#define LODESTAR_OPEN_PHASE_H

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
    float
        i_min; ///< mean of a phase current's magnitude below which nothing can be told, in the unit
               ///< of the currents that are noted
} lode_open_phase_tuning_t;

typedef struct {
    lode_abc6_t sum;           ///< of the currents' magnitudes, since the electrical period began
    uint_least16_t samples;    ///< of both sets
    lode_open_phase_t suspect; ///< found in the last electrical period
    bool positive;             ///< sine of the rotor angle in the last call
} lode_open_phase_watch_t;

void lode_open_phase_reset(lode_open_phase_watch_t *self);

#ifdef __cplusplus
}
#endif

#endif
