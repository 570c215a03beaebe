/// The last faults, each with the row of telemetry that tripped and the rows that the main loop saw before it. For
/// the main loop, in every pass with the supervisor (supervisor.h):
///
///     if (lode_fault_log_step(&log, &now)) {
///         const lode_telemetry_t *row = lode_fault_log_row(&log, 0u, 0u); /* the fault that has just come */
///     }
///
/// Rows of every period before a fault: the scope with its trigger at a fault (scope.h).
#ifndef LODESTAR_FAULT_LOG_H
#define LODESTAR_FAULT_LOG_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Rows of a buffer for `faults` faults of `rows` rows each, and as many for what comes before the next one.
#define LODE_FAULT_LOG_ROWS(faults, rows) (((uint32_t)(faults) + 1u) * (uint32_t)(rows))

/// Visible for static allocation; written by its functions only.
typedef struct {
    lode_telemetry_t *buffer;
    uint32_t faults; ///< that it holds
    uint32_t rows;   ///< of each, that which tripped among them
    uint32_t total;  ///< faults since init or erase, modulo 2^32
    uint32_t held;   ///< of them, up to `faults`
    uint32_t block;  ///< in which the next one is collected: 0 .. faults
    bool faulted;    ///< at the last step
} lode_fault_log_t;

/// Takes LODE_FAULT_LOG_ROWS(faults, rows) rows at `buffer`, which belong to the log from then on. Both counts:
/// 1 .. 1000. LODE_ERROR_BUFFER otherwise; `self` and the buffer are then unchanged.
lode_status_t lode_fault_log_init(lode_fault_log_t *self, lode_telemetry_t *buffer, uint32_t faults,
                                  uint32_t rows);

/// True: a fault has come since the last call. `telemetry->steps` is the time.
bool lode_fault_log_step(lode_fault_log_t *self, const lode_telemetry_t *telemetry);

/// Faults that can be read; `total` in the structure has them all.
uint32_t lode_fault_log_count(const lode_fault_log_t *self);

/// `back`: 0 for the last fault, 1 for the one before ... `row`: 0 for what the drive was doing when it tripped,
/// its cause in `fault`, 1 for the row that the main loop saw before ... NULL where there is none. Valid until the
/// next call of another function.
const lode_telemetry_t *lode_fault_log_row(const lode_fault_log_t *self, uint32_t back,
                                           uint32_t row);

/// Erases them all.
void lode_fault_log_erase(lode_fault_log_t *self);

#ifdef __cplusplus
}
#endif

#endif
