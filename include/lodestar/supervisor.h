/// Reaction to a fault: it stays, or the drive is restarted, a few times. For the main loop, called 100 to
/// 1000 times a second; the interrupt has no part in it:
///
///     lode_telemetry_t now;
///     (void)lode_drive_telemetry(&drive, &now);
///     const lode_command_t command = lode_supervisor_step(&supervisor, &now, wanted, 1.0e-3f);
///     (void)lode_drive_post_command(&drive, &command);
///
/// Until it is started again the motor coasts, or is short-circuited where its EMF is above the bus; the start
/// catches a rotor that still turns (start.h). Which reaction suits which fault: docs/reactions.md.
#ifndef LODESTAR_SUPERVISOR_H
#define LODESTAR_SUPERVISOR_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    LODE_REACTION_LATCH,       ///< it stays until it is cleared
    LODE_REACTION_AGAIN,       ///< started again after wait_s
    LODE_REACTION_RIDE_THROUGH ///< as soon as bus and temperature are within the guard's limits
} lode_reaction_t;

/// 0 in all fields: every fault stays. It must not change while a supervisor uses it.
typedef struct {
    lode_reaction_t reaction[LODE_CHECK_COUNT]; ///< by lode_check_t
    uint_least8_t attempts;                     ///< in a row, 0 .. 255
    float wait_s; ///< from the fault to the attempt, 1e-3 .. 1e4; 0: 1
    /// of uninterrupted RUN, after which the count of attempts returns to 0, 1e-3 .. 1e5: there are never more than
    /// `attempts` in such an interval; 0: 10
    float good_s;
    /// after a fault the low sides are on where the motor would otherwise charge the bus through the diodes; auto: off.
    /// Refused where the current of the short, psi/Ld, is above i_max
    lode_choice_t active_short;
} lode_supervisor_config_t;

/// What a port may keep across a reset, in memory that start-up does not initialise.
typedef struct {
    uint32_t count; ///< attempts since the last good run
    uint32_t check; ///< of it: memory that was not kept does not match
} lode_attempts_t;

/// Visible for static allocation; written by its functions only.
typedef struct {
    const lode_supervisor_config_t *config;
    const lode_drive_tuning_t *tuning;
    lode_attempts_t *attempts;
    float wait_s;
    float good_s;
    float time_s;        ///< in FAULT, or in RUN
    bool faulted;        ///< at the last step
    bool waits;          ///< the time is that in FAULT
    bool shorts;         ///< the EMF was above the bus when the drive last ran
    uint32_t faulted_at; ///< period in which the fault was first seen
    bool asked;          ///< an attempt is in the mail, since ...
    uint32_t asked_at;   ///< ... so many periods
} lode_supervisor_t;

/// `tuning`: what the drive began with, which must stay. `attempts`: continues where it holds a valid count, else
/// begins at 0. `by_reset`: this is the start after a reset by a watchdog or the like, and counts as an attempt:
/// a fault that comes with a reset is not retried for ever. LODE_OK, or why not; everything is then
/// unchanged.
lode_status_t lode_supervisor_init(lode_supervisor_t *self, const lode_supervisor_config_t *config,
                                   const lode_drive_tuning_t *tuning, lode_attempts_t *attempts,
                                   bool by_reset);

/// Call `dt_s` after the last call. Returns the command to post: `wanted`, except that after a fault it is OFF until the
/// next attempt, and for good where there is none. A wanted OFF with clear_fault clears the fault and sets the count of attempts to 0.
lode_command_t lode_supervisor_step(lode_supervisor_t *self, const lode_telemetry_t *telemetry,
                                    lode_command_t wanted, float dt_s);

/// The drive does not run, and will not until the fault is cleared.
bool lode_supervisor_is_latched(const lode_supervisor_t *self, const lode_telemetry_t *telemetry);

#ifdef __cplusplus
}
#endif

#endif
