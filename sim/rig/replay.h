/// The firmware's estimator over recorded signals.
#ifndef RIG_REPLAY_H
#define RIG_REPLAY_H

#include "lodestar/estimator.h"

#include "rig/euler.h"
#include "rig/recording.h"
#include "support/stats.h"

/// Steady values are those of the last part. Extremes are without the first part, and without as much after
/// each gap.
#define REPLAY_WINDOW_s 0.1
#define REPLAY_SETTLE_s 0.2
#define REPLAY_CLOSE_deg 1.0
#define REPLAY_ACQUIRE_s 0.02

/// One estimate per row of the recording, valid at that row's t_s.
typedef struct {
    size_t rows;
    lode_estimate_t *row;
    double *error_deg; ///< estimate - truth; NaN without a true angle or an estimate
    rig_stats_t error_window_deg;
    rig_stats_t error_settled_deg;
    rig_stats_t error_locked_deg;   ///< lock quality of LODE_LOCK_LOST at least
    rig_stats_t speed_window_rad_s; ///< estimate - truth, electrical
    rig_stats_t speed_settled_rad_s;
    /// after this time the error stays below REPLAY_CLOSE_deg; NaN: it does not
    double close_after_s;
    size_t off; ///< rows with the gates off
    size_t reseeds;
} replay_t;

/// Runs from reset. Row k uses the voltage of row k-1 and the current of row k. The first row has no voltage
/// before it and gives no estimate, nor does the first row after a gap. Rows with the gates off give none
/// either: their voltage is 0, and their current is 0 or, after a fault, constant. The estimator restarts after
/// these. `euler`: the papers' own forms instead of the library's estimator, or NULL. They have no acquisition,
/// so for REPLAY_ACQUIRE_s they are set to the EMF that they observe. False after a message.
bool replay_run(replay_t *self, const recording_t *recording, const lode_estimator_tuning_t *tuning,
                const euler_config_t *euler);

/// True if there is an estimate for a row.
bool replay_is_known(const recording_t *recording, size_t k);

void replay_free(replay_t *self);

#endif
