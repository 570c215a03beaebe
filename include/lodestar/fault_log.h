/// Log of the last faults: for each one the telemetry row at the trip and the rows that the main loop has seen
/// before. For the main loop, in every pass, next to the supervisor (supervisor.h):
///
///     if (lode_fault_log_step(&log, &now)) {
///         const lode_telemetry_t *row = lode_fault_log_row(&log, 0u, 0u); /* the fault that has just come */
///     }
///
/// Rows of every control period before a fault: the scope with LODE_TRIGGER_FAULT (scope.h).
#ifndef LODESTAR_FAULT_LOG_H
#define LODESTAR_FAULT_LOG_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Rows of a buffer for `faults` faults of `rows` rows each, plus the rows before the next fault.
#define LODE_FAULT_LOG_ROWS(faults, rows) (((uint32_t)(faults) + 1u) * (uint32_t)(rows))

/// The members are visible for static allocation; only the functions below write them.
typedef struct {
    lode_telemetry_t *buffer;
    uint32_t faults;      ///< faults that the buffer holds
    uint32_t rows;        ///< rows per fault, including the one at the trip
    uint32_t total;       ///< faults since init or erase, modulo 2^32
    uint32_t held;        ///< number of those that can be read, up to `faults`
    uint32_t block;       ///< block that collects the rows before the next fault: 0 .. faults
    bool faulted;         ///< there was a fault at the last step
    uint_least16_t trips; ///< lode_telemetry_t.trips at the last step
} lode_fault_log_t;

/// Takes LODE_FAULT_LOG_ROWS(faults, rows) rows at `buffer`, which belong to the log from then on. Both counts: 1
/// .. 1000. Errors: NULL, BUFFER; `self` and the buffer are then left alone.
lode_status_t lode_fault_log_init(lode_fault_log_t *self, lode_telemetry_t *buffer, uint32_t faults,
                                  uint32_t rows);

/// True: the drive is in FAULT, by a fault that is not in the log yet. A fault that a posted `clear_fault` has cleared in
/// its first period never shows in telemetry, but lode_telemetry_t.trips counts it. `telemetry->steps` is the time base.
bool lode_fault_log_step(lode_fault_log_t *self, const lode_telemetry_t *telemetry);

/// Number of faults that can be read. `total` in the structure counts all of them.
uint32_t lode_fault_log_count(const lode_fault_log_t *self);

/// `back`: 0 for the last fault, 1 for the one before it, and so on. `row`: 0 for the row at the trip, with the
/// cause in `fault`; 1 for the row that the main loop saw before it, and so on. NULL if there is no such row. Valid
/// until the next call of another function.
const lode_telemetry_t *lode_fault_log_row(const lode_fault_log_t *self, uint32_t back,
                                           uint32_t row);

/// Deletes all entries.
void lode_fault_log_erase(lode_fault_log_t *self);

#ifdef __cplusplus
}
#endif

#endif
