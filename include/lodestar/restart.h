/// What follows a fault: it stays, or the drive is tried again, a few times. For the main loop, as derate.h:
///
///     lode_telemetry_t now;
///     (void)lode_drive_telemetry(&drive, &now);
///     const lode_command_t command = lode_restart_step(&restart, &config, &now, wanted, 0.1f);
///     (void)lode_drive_post_command(&drive, &command);
///
/// Until the attempt the motor coasts; the attempt catches a rotor that still turns (start.h).
#ifndef LODESTAR_RESTART_H
#define LODESTAR_RESTART_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

/// The bit of a check in lode_restart_config_t.again.
#define LODE_RESTART_AFTER(check) (UINT32_C(1) << (uint32_t)(check))

typedef struct {
    uint32_t again;         ///< checks after which it is tried again, a bit each; all others stay
    uint_least8_t attempts; ///< in a row
    float wait_s;           ///< from the fault to the attempt
    float good_s;           ///< in RUN, after which the attempts begin at 0 again
} lode_restart_config_t;

typedef struct {
    uint_least8_t count; ///< attempts since the last good run: what a port keeps over a reset
    float time_s;        ///< in FAULT, or in RUN
} lode_restart_t;

/// `count`: 0, or what was kept over a reset: a fault that comes with every reset is not tried for ever.
void lode_restart_begin(lode_restart_t *self, uint_least8_t count);

/// `dt_s` after the last time: the command to post. `wanted`, save that after a fault it is OFF until the attempt,
/// and for good where there is none. A wanted OFF with clear_fault is somebody's, and begins the attempts at 0.
lode_command_t lode_restart_step(lode_restart_t *self, const lode_restart_config_t *config,
                                 const lode_telemetry_t *telemetry, lode_command_t wanted,
                                 float dt_s);

#ifdef __cplusplus
}
#endif

#endif
