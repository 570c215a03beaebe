/// Reaction to a fault: the drive stays in FAULT, or is started again a limited number of times. For the main loop,
/// called 100 to 1000 times per second; nothing runs in the interrupt:
///
///     lode_telemetry_t now;
///     (void)lode_drive_telemetry(&drive, &now);
///     const lode_command_t command = lode_supervisor_step(&supervisor, &now, wanted, 1.0e-3f);
///     (void)lode_drive_post_command(&drive, &command);
///
/// Until the next start the motor coasts, or is short-circuited if its EMF is above the bus voltage; the start
/// catches a rotor that is still turning (start.h). Which reaction suits which fault: docs/reactions.md.
#ifndef LODESTAR_SUPERVISOR_H
#define LODESTAR_SUPERVISOR_H

#include "lodestar/drive.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    LODE_REACTION_LATCH, ///< the fault stays until it is cleared
    LODE_REACTION_AGAIN, ///< start again after wait_s
    LODE_REACTION_RIDE_THROUGH ///< start again as soon as bus and temperature are within the guard's limits
} lode_reaction_t;

/// Configuration. With 0 in all fields every fault stays. It must not change while a supervisor uses it.
typedef struct {
    lode_reaction_t reaction[LODE_CHECK_COUNT]; ///< by lode_check_t
    uint_least8_t attempts;                     ///< attempts in a row, 0 .. 255
    float wait_s; ///< time from the fault to the attempt, 1e-3 .. 1e4; 0: 1
    /// time of uninterrupted RUN after which the count of attempts starts at 0 again, 1e-3 .. 1e5; 0: 10. So there
    /// are never more than `attempts` attempts within such a time
    float good_s;
    /// after a fault switch the low sides on if otherwise the EMF would charge the bus through the diodes; auto:
    /// off. LODE_ON is refused if the current of the short, psi/Ld, is above i_max
    lode_choice_t active_short;
} lode_supervisor_config_t;

/// Count of attempts. A port may keep it across a reset, in memory that start-up does not initialise.
typedef struct {
    uint32_t count; ///< attempts since the last good run
    uint32_t check; ///< check word of `count`; it does not match in memory that was not kept
} lode_attempts_t;

/// The members are visible for static allocation; only the functions below write them.
typedef struct {
    const lode_supervisor_config_t *config;
    const lode_drive_tuning_t *tuning;
    lode_attempts_t *attempts;
    float wait_s;
    float good_s;
    float time_s;         ///< time in FAULT (`waits`) or in RUN
    float rest_s;         ///< of it, too small for a float of that size
    bool faulted;         ///< the drive was in FAULT at the last step
    bool waits;           ///< time_s counts the time in FAULT
    bool shorts;          ///< the EMF was above the bus when the drive last ran
    uint_least16_t trips; ///< lode_telemetry_t.trips at the last step
    uint32_t faulted_at;  ///< lode_telemetry_t.steps when the fault was first seen
    bool posted;          ///< an attempt has been posted
    uint32_t posted_at;   ///< lode_telemetry_t.steps at that time
} lode_supervisor_t;

/// `tuning`: the one that the drive began with; it must not change. `attempts`: continues if it holds a valid
/// count, otherwise starts at 0. `by_reset`: the program starts after a reset by a watchdog or the like. That
/// counts as an attempt, so that a fault that causes a reset is not retried for ever. Errors: NULL, SUPERVISOR,
/// ACTIVE_SHORT; nothing is changed then.
lode_status_t lode_supervisor_init(lode_supervisor_t *self, const lode_supervisor_config_t *config,
                                   const lode_drive_tuning_t *tuning, lode_attempts_t *attempts,
                                   bool by_reset);

/// Returns the command to post, `dt_s` after the last call. It is `wanted`, but after a fault it is OFF until the
/// next attempt, or for good if there is none. A wanted OFF with clear_fault clears the fault and resets the count
/// of attempts.
lode_command_t lode_supervisor_step(lode_supervisor_t *self, const lode_telemetry_t *telemetry,
                                    lode_command_t wanted, float dt_s);

/// True if the drive does not run and will not be started again until the fault is cleared.
bool lode_supervisor_is_latched(const lode_supervisor_t *self, const lode_telemetry_t *telemetry);

#ifdef __cplusplus
}
#endif

#endif
