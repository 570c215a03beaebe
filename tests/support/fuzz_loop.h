/// The main loop of a fuzzed drive: torque limits, supervisor and brake chopper.
#ifndef SUPPORT_FUZZ_LOOP_H
#define SUPPORT_FUZZ_LOOP_H

#include "support/fuzz_guide.h"

#include "lodestar/chopper.h"
#include "lodestar/supervisor.h"

/// Periods per call of the main loop.
#define FUZZ_LOOP_PERIODS 8u

typedef struct {
    lode_command_t wanted; ///< posted last
    bool supervised;
    bool adapts;
    bool may_short; ///< a command has allowed the active short
    uint32_t periods;
    uint32_t periods_without; ///< periods of RUN for which no torque is allowed
    lode_supervisor_config_t reactions;
    lode_attempts_t attempts;
    lode_supervisor_t supervisor;
    lode_chopper_tuning_t chopper_tuning;
    lode_chopper_t chopper;
} fuzz_loop_t;

static inline void fuzz_loop_init(fuzz_loop_t *self) {
    const lode_chopper_config_t chopper = {.on_V = 210.0f,
                                           .full_V = 220.0f,
                                           .R_Ohm = 50.0f,
                                           .power_W = 20.0f,
                                           .thermal_s = 0.1f,
                                           .period_s = 2.0e-4f};
    *self = (fuzz_loop_t){.wanted = {.mode = LODE_MODE_OFF}};
    FUZZ_CHECK(lode_chopper_tune(&self->chopper_tuning, &chopper) == LODE_OK);
    lode_chopper_reset(&self->chopper, 0.0f);
}

static inline lode_status_t fuzz_loop_post(fuzz_loop_t *self, lode_drive_t *drive,
                                           const lode_command_t *command) {
    self->wanted = *command;
    const lode_status_t status = lode_drive_post_command(drive, command);
    self->may_short = self->may_short || (status == LODE_OK && command->active_short);
    return status;
}

/// Begins to supervise, with reactions of the input's; `tuning`: of the drive's beginning.
static inline void fuzz_loop_supervise(fuzz_loop_t *self, fuzz_t *in,
                                       const lode_drive_tuning_t *tuning) {
    const uint8_t choice = fuzz_byte(in);
    self->reactions = (lode_supervisor_config_t){
        .attempts = choice / 4u % 8u,
        .wait_s = 2.0e-3f,
        .good_s = 0.05f,
        .active_short = (choice & 32u) != 0u ? LODE_ON : LODE_OFF,
    };
    for (int n = 0; n < LODE_CHECK_COUNT; n++) {
        self->reactions.reaction[n] = (lode_reaction_t)((choice + n) % 3);
    }
    self->supervised = lode_supervisor_init(&self->supervisor, &self->reactions, tuning,
                                            &self->attempts, (choice & 64u) != 0u) == LODE_OK;
}

static inline void fuzz_loop_limit(fuzz_loop_t *self, fuzz_t *in, lode_drive_t *drive) {
    const float motoring = fuzz_number(in, 1.2f);
    const float braking = fuzz_number(in, 1.2f);
    lode_drive_limit_torques(drive, motoring, braking);
    FUZZ_CHECK(drive->torque_share[0] <= LODE_TORQUE_SHARE_ONE);
    FUZZ_CHECK(drive->torque_share[1] <= LODE_TORQUE_SHARE_ONE);
    self->periods_without = 0u;
}

// No torque is asked for once none is allowed for some rounds of the slow jobs.
static inline void fuzz_loop_check_limit(fuzz_loop_t *self, const lode_drive_t *drive,
                                         const lode_telemetry_t *t) {
    const bool without = drive->torque_share[0] == 0u && drive->torque_share[1] == 0u;
    self->periods_without = without && t->mode == LODE_MODE_RUN ? self->periods_without + 1u : 0u;
    if (self->periods_without > 4u * LODE_SLOW_PERIODS) {
        FUZZ_CHECK(lode_abs(t->torque_ref_Nm) < 1.0e-3f);
    }
}

/// After each period, with what the drive told of it.
static inline void fuzz_loop_step(fuzz_loop_t *self, lode_drive_t *drive,
                                  const lode_telemetry_t *t) {
    const float duty = lode_chopper_step(&self->chopper, &self->chopper_tuning, t->v_bus_V);
    FUZZ_CHECK(lode_in_range(duty, 0.0f, 1.0f) && lode_is_finite(self->chopper.heat));
    FUZZ_CHECK(self->may_short || !t->shorted);
    fuzz_loop_check_limit(self, drive, t);
    self->periods++;
    if (self->supervised && self->periods % FUZZ_LOOP_PERIODS == 0u) {
        const float dt_s = (float)FUZZ_LOOP_PERIODS * 2.0e-4f;
        const lode_command_t command =
            lode_supervisor_step(&self->supervisor, t, self->wanted, dt_s);
        const lode_status_t status = lode_drive_post_command(drive, &command);
        self->may_short = self->may_short || (status == LODE_OK && command.active_short);
    }
}

/// What adaptation has found stays in its bounds.
static inline void fuzz_check_adapted(const lode_adapted_motor_t *found) {
    const lode_motor_t motor = fuzz_motor();
    const lode_adapted_t *const all[] = {&found->J_kgm2, &found->psi_Wb, &found->Rs_Ohm};
    for (int n = 0; n < 3; n++) {
        FUZZ_CHECK(lode_in_range(all[n]->confidence, 0.0f, 1.0f));
    }
    FUZZ_CHECK(lode_in_range(found->J_kgm2.value / motor.J_kgm2, 0.199f, 5.001f));
    FUZZ_CHECK(lode_in_range(found->psi_Wb.value / motor.psi_Wb, 0.799f, 1.201f));
    FUZZ_CHECK(lode_in_range(found->Rs_Ohm.value / motor.Rs_Ohm, 0.499f, 1.501f));
}

/// What the input may choose besides, from this byte on.
#define FUZZ_ALSO 192u

/// Of the drive `drive`, which began with `tuning`.
static inline void fuzz_choose_surroundings(fuzz_t *in, uint8_t what, lode_drive_t *drive,
                                            plant_t *plant, fuzz_guide_t *guide, fuzz_loop_t *loop,
                                            const lode_drive_tuning_t *tuning) {
    if (what < FUZZ_ALSO) {
        return;
    }
    if (what < 204u) {
        fuzz_guide_choose(guide, in);
    } else if (what < 214u) {
        fuzz_guide_spoil(guide, in);
    } else if (what < 222u) {
        fuzz_loop_limit(loop, in, drive);
    } else if (what < 230u) {
        plant_set_load(plant, 0.1 * (double)fuzz_byte(in));
    } else if (what < 236u) {
        fuzz_loop_supervise(loop, in, tuning);
    } else if (what < 240u) {
        loop->supervised = false;
    } else if (what < 244u) {
        loop->adapts = what < 243u;
    }
}

#endif
