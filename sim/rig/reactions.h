/// What follows a fault: the library's supervisor and fault log, as a main loop has them beside the drive.
#ifndef RIG_REACTIONS_H
#define RIG_REACTIONS_H

#include "config/rig_config.h"

#include "lodestar/fault_log.h"
#include "lodestar/supervisor.h"

enum { REACTIONS_FAULTS = 16 };

/// Not to be copied: it points into itself.
typedef struct {
    bool on;        ///< some fault has another reaction than to coast, and to stay
    uint32_t every; ///< periods from one pass of the main loop to the next
    float dt_s;     ///< the same
    lode_supervisor_config_t config;
    lode_attempts_t attempts;
    lode_supervisor_t supervisor;
    lode_fault_log_t log;
    lode_telemetry_t rows[LODE_FAULT_LOG_ROWS(REACTIONS_FAULTS, 1)];
} reactions_t;

/// `config` has been accepted, its values by their schema. LODE_OK, or what the library refuses of the motor.
lode_status_t reactions_init(reactions_t *self, const rig_config_t *config,
                             const lode_drive_t *drive);

/// After a period: in those of the main loop what is wanted is posted, or what the supervisor makes of it.
void reactions_step(reactions_t *self, lode_drive_t *drive, lode_command_t wanted);

#endif
