/// The main loop of a fuzzed drive: torque limits, derating, limits of the supply, supervisor and brake chopper.
#ifndef SUPPORT_FUZZ_LOOP_H
#define SUPPORT_FUZZ_LOOP_H

#include "support/fuzz_guide.h"

#include "lodestar/adaptation.h"
#include "lodestar/chopper.h"
#include "lodestar/derate.h"
#include "lodestar/supervisor.h"
#include "lodestar/supply.h"

/// Periods per call of the main loop.
#define FUZZ_LOOP_PERIODS 8u
#define FUZZ_LOOP_s (2.0e-4f * (float)FUZZ_LOOP_PERIODS)

/// Limits of the torque that the main loop computes.
typedef struct {
    bool on;
    bool measures;  ///< the supply's current is measured, `supply_A`
    float supply_A; ///< any number
    lode_derate_tuning_t derate_tuning;
    lode_derate_t derate;
    lode_supply_tuning_t supply_tuning;
    lode_supply_t supply;
} fuzz_limits_t;

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
    fuzz_limits_t limits;
} fuzz_loop_t;

static inline void fuzz_limits_init(fuzz_limits_t *self) {
    // So little that both limit within the periods of an input.
    const lode_derate_config_t derate = {
        .i_max_A = 12.0f, .i_continuous_A = 3.0f, .winding_s = 0.1f, .to_degC = 100.0f};
    const lode_supply_config_t supply = {.battery_A = 1.0f, .regen_A = 0.5f, .correct_s = 0.01f};
    const lode_drive_config_t drive = fuzz_drive_config(0u);
    FUZZ_CHECK(lode_derate_tune(&self->derate_tuning, &derate) == LODE_OK);
    FUZZ_CHECK(lode_supply_tune(&self->supply_tuning, &supply, &drive) == LODE_OK);
    lode_derate_reset(&self->derate, 0.0f);
    lode_supply_reset(&self->supply);
}

static inline void fuzz_limits_step(fuzz_limits_t *self, lode_drive_t *drive,
                                    const lode_telemetry_t *t) {
    const float by_heat = lode_derate_step(&self->derate, &self->derate_tuning, t, FUZZ_LOOP_s);
    const float modelled_A = lode_supply_current_A(&self->supply_tuning, t);
    FUZZ_CHECK(lode_is_finite(modelled_A));
    const lode_shares_t share =
        lode_supply_step(&self->supply, &self->supply_tuning, t,
                         self->measures ? self->supply_A : modelled_A, FUZZ_LOOP_s);
    FUZZ_CHECK(lode_in_range(by_heat, 0.0f, 1.0f) && lode_is_finite(self->derate.heat));
    FUZZ_CHECK(lode_in_range(share.motoring, 0.0f, 1.0f));
    FUZZ_CHECK(lode_in_range(share.braking, 0.0f, 1.0f));
    lode_drive_limit_torques(drive, lode_min(by_heat, share.motoring),
                             lode_min(by_heat, share.braking));
}

static inline void fuzz_limits_choose(fuzz_limits_t *self, fuzz_t *in) {
    const uint8_t choice = fuzz_byte(in);
    self->on = choice % 4u != 0u;
    self->measures = choice % 4u == 1u;
    if (self->measures) {
        self->supply_A = fuzz_number(in, 10.0f);
    } else if (choice % 4u == 2u) {
        lode_derate_reset(&self->derate, fuzz_number(in, 4.0f));
    }
}

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
    fuzz_limits_init(&self->limits);
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
    FUZZ_CHECK(drive->torque_share[0] <= (LODE_TORQUE_SHARE_ONE | LODE_TORQUE_SHARE_PARITY));
    FUZZ_CHECK(drive->torque_share[1] <= (LODE_TORQUE_SHARE_ONE | LODE_TORQUE_SHARE_PARITY));
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
    if (self->periods % FUZZ_LOOP_PERIODS != 0u) {
        return;
    }
    if (self->limits.on) {
        fuzz_limits_step(&self->limits, drive, t);
    }
    if (self->supervised) {
        const lode_command_t command =
            lode_supervisor_step(&self->supervisor, t, self->wanted, FUZZ_LOOP_s);
        const lode_status_t status = lode_drive_post_command(drive, &command);
        self->may_short = self->may_short || (status == LODE_OK && command.active_short);
    }
}

/// What adaptation begins with: any of the three, and values that may have been stored.
typedef struct {
    lode_adaptation_config_t config;
    bool has;
    lode_adaptation_found_t stored;
} fuzz_adaptation_t;

static inline lode_adapted_t fuzz_stored(fuzz_t *in, float configured) {
    const float value = configured * (1.0f + fuzz_number(in, 1.0f));
    const float confidence = fuzz_number(in, 1.0f);
    return (lode_adapted_t){value, confidence};
}

static inline fuzz_adaptation_t fuzz_adaptation(fuzz_t *in, uint8_t choice) {
    static const lode_choice_t choices[] = {LODE_AUTO, LODE_OFF};
    const lode_motor_t motor = fuzz_motor();
    fuzz_adaptation_t self = {
        .config = {.J = LODE_AUTO, .psi = choices[choice % 2u], .Rs = choices[choice / 2u % 2u]},
        .has = choice / 4u % 2u != 0u};
    if (self.has) {
        self.stored.J_kgm2 = fuzz_stored(in, motor.J_kgm2);
        self.stored.psi_Wb = fuzz_stored(in, motor.psi_Wb);
        self.stored.Rs_Ohm = fuzz_stored(in, motor.Rs_Ohm);
    }
    return self;
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
    } else if (what < 250u) {
        fuzz_limits_choose(&loop->limits, in);
    }
}

#endif
