/// Reactions to faults: the library's supervisor and fault log, used as in a main loop.
#ifndef RIG_REACTIONS_H
#define RIG_REACTIONS_H

#include "config/rig_config.h"

#include "lodestar/fault_log.h"
#include "lodestar/supervisor.h"

enum { REACTIONS_FAULTS = 16 };

/// Not to be copied: it points into itself.
typedef struct {
    bool on;        ///< some fault has a reaction other than to coast and latch
    uint32_t every; ///< periods from one pass of the main loop to the next
    float dt_s;     ///< the same
    lode_supervisor_config_t config;
    lode_attempts_t attempts;
    lode_supervisor_t supervisor;
    lode_fault_log_t log;
    lode_telemetry_t rows[LODE_FAULT_LOG_ROWS(REACTIONS_FAULTS, 1)];
} reactions_t;

/// `config` has been accepted, and the schema has checked its values. LODE_OK, or why the library refuses the motor.
lode_status_t reactions_init(reactions_t *self, const rig_config_t *config,
                             const lode_drive_t *drive);

/// Call after each period: in a period with a pass of the main loop it posts the command, or the supervisor's
/// version of it.
void reactions_step(reactions_t *self, lode_drive_t *drive, lode_command_t wanted);

#endif
