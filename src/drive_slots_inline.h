// The slow jobs of a drive, slot by slot (schedule.h): shared by the steps for three and six phases. Where a function returns
// bool, false means that the gates are off.
#ifndef LODE_DRIVE_SLOTS_INLINE_H
#define LODE_DRIVE_SLOTS_INLINE_H

#include "drive_parts.h"
#include "drive_speed_inline.h"
#include "estimator_inline.h"
#include "guard_inline.h"
#include "inverter_inline.h"
#include "mode.h"
#include "plausibility_inline.h"
#include "references_inline.h"
#include "sense_inline.h"

// Below this multiple of the lowest speed, a sensorless drive that stops or reverses leaves RUN.
#define HAND_BACK_SHARE 1.15f
#define SOUND_LOCK 0.9f // the EMF is off by less than 8 %

// One round less until the start counts as proven, once the rotor turns as commanded.
LODE_INLINE void lode_drive_count_proof(lode_drive_t *self) {
#ifdef LODE_WITHOUT_HANDOVER_RETRY
    (void)self;
#else
    const uint32_t proving = self->state.run.proving;
    const float along = self->estimator.pll.omega_rad_s * self->command.speed_rad_s;
    if (proving == LODE_PROVING_ENDLESS) {
        const bool turns = along >= 0.0f; // as commanded
        self->state.run.proving =
            turns ? self->tuning->start.patience_rounds : LODE_PROVING_ENDLESS;
    } else if (proving > 0u) {
        self->state.run.proving = (uint_least16_t)(proving - 1u);
    } else {
        // proven
    }
#endif
}

LODE_INLINE void lode_drive_adapt_lag(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
#ifndef LODE_WITHOUT_OPTIMAL_REFERENCES
    if (lode_references_has(&tuning->references, LODE_REFERENCES_SATURATE)) {
        lode_drive_adapt_saturated_lag(self);
        return;
    }
#endif
    // Renewed in each round, as with saturation: a corrupted value does not last.
    lode_current_renew(&self->current, &tuning->current, tuning->references.Lq_H);
    lode_estimator_adapt_lag(&self->estimator, &tuning->estimator);
}

LODE_INLINE void lode_drive_lead(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
    // Half a period's angle times three: from the sample to the middle of its duties' period.
    const float half_rad = 0.5f * tuning->estimator.pll.ts_s * self->estimator.pll.omega_rad_s;
    self->lead = lode_angle_triple(lode_sincos_small(half_rad));
}

LODE_INLINE bool lode_drive_watch_flux(lode_drive_t *self) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    return true;
#else
    const bool sound = self->estimator.lock >= SOUND_LOCK && self->guard.flux_rounds == 0u;
    return sound || lode_drive_judge_flux(self);
#endif
}

// RUN: the current is near its reference, as nearly always, or current control has not lost it (K49).
LODE_INLINE bool lode_drive_holds_current(lode_drive_t *self) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    return true;
#else
    const float d_A = self->ref_A.d - self->i_A.d;
    const float q_A = self->ref_A.q - self->i_A.q;
    const bool near = d_A * d_A + q_A * q_A <= self->tuning->plausibility.off_A2;
    if (near && self->state.run.off == 0u) {
        return true;
    }
    return lode_drive_watch_control(self);
#endif
}

LODE_INLINE bool lode_drive_slot_lag(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
    lode_drive_adapt_lag(self, tuning);
    lode_drive_lead(self, tuning);
    if (lode_mode(self) != LODE_MODE_RUN) {
        return true;
    }
    if (lode_references_weakens(&tuning->references) && lode_drive_speed_once(self)) {
        lode_drive_limit_flux(self);
    }
    return lode_drive_watch_flux(self) && lode_drive_holds_current(self) &&
           lode_drive_watch_half_waves(self);
}

LODE_INLINE bool lode_drive_measured_ok(const lode_drive_t *self,
                                        const lode_drive_tuning_t *tuning) {
#ifdef LODE_WITHOUT_START_MEASUREMENT
    (void)self;
    (void)tuning;
    return true;
#else
    return lode_inverter_is_sound(&self->inverter, &tuning->inverter, tuning->start.R_Ohm);
#endif
}

LODE_INLINE bool lode_drive_slot_dead_time(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                           lode_words_t words) {
    lode_inverter_adapt(&self->inverter, &tuning->inverter, self->u_V);
    if (!lode_mode_memory_ok(self, words)) {
        lode_mode_distrust(self);
        return false;
    }
    if (!lode_drive_measured_ok(self, tuning)) {
        lode_mode_trip_memory(self, LODE_MEMORY_START);
        return false;
    }
    if (lode_mode(self) != LODE_MODE_RUN) {
        return true;
    }
    if (!lode_mode_speed_ok(self)) {
        return false;
    }
    if (!lode_estimator_has_rotor(&self->estimator)) {
        lode_mode_lose_rotor(self);
    }
    return true;
}

// False: a fault was found.
LODE_INLINE bool lode_drive_adapt_gains(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
#ifndef LODE_WITHOUT_HFI
    if (lode_hfi_is_on(&tuning->estimator.hfi) && (lode_mode_inject(self) || !self->gates)) {
        return self->gates;
    }
#endif
    lode_estimator_adapt_gains(&self->estimator, &tuning->estimator);
    return true;
}

LODE_INLINE bool lode_drive_slot_gains(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
    lode_estimator_t *estimator = &self->estimator;
    if (!lode_mode_motion_ok(self)) {
        return false;
    }
    if (!estimator->locked && lode_mode_seed(self)) {
        lode_estimator_forget_motion(estimator);
        return true; // the rest a round later: together 1459 cycles, the worst-case call of a start
    }
    if (!lode_drive_adapt_gains(self, tuning)) {
        return false;
    }
    lode_mode_count_sensor(self);
    lode_estimator_adapt_notches(estimator, &tuning->estimator);
    lode_estimator_note_motion(estimator);
    return true;
}

// Too slow to stay in RUN, and no speed in this direction is commanded.
LODE_INLINE bool lode_drive_is_too_slow(const lode_drive_t *self) {
    return !lode_mode_is_sensored(self) && !(self->command.speed_rad_s * self->direction > 0.0f) &&
           lode_abs(self->estimator.pll.omega_rad_s) <= HAND_BACK_SHARE * self->tuning->omega_min;
}

LODE_INLINE void lode_drive_run(lode_drive_t *self) {
    if (lode_drive_is_too_slow(self)) {
        lode_mode_hand_back(self);
    } else if (lode_drive_speed_once(self)) {
        // Mean of two speeds half a round apart (the first is that of the lag): less ripple and noise of the position error
        // aliases.
        const lode_estimator_t *estimator = &self->estimator;
        lode_drive_speed(self, 0.5f * (estimator->lag.omega_rad_s + estimator->pll.omega_rad_s));
        lode_drive_free_id(self);
    } else {
        // more than once per round: in lode_drive_fast_speed()
    }
}

// Otherwise they follow speed control in lode_drive_fast_speed().
LODE_INLINE void lode_drive_renew_references(lode_drive_t *self) {
    if (lode_drive_speed_once(self)) {
        lode_drive_references(self);
    }
}

LODE_INLINE bool lode_drive_watch_waves(lode_drive_t *self, const int32_t i[LODE_PHASES]) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    (void)i;
    return true;
#else
    if (lode_mode(self) != LODE_MODE_START ||
        self->state.start.stage != (uint_least8_t)LODE_START_TURN) {
        return true;
    }
    const int32_t copy[LODE_PHASES] = {i[0], i[1], i[2]}; // a copy, as in lode_drive_watch()
    return lode_drive_note_waves(self, copy);
#endif
}

LODE_INLINE bool lode_drive_slot_references(lode_drive_t *self, const lode_sample_t *sample) {
    if (lode_mode(self) == LODE_MODE_RUN) {
        lode_drive_renew_references(self);
        return true;
    }
    return lode_drive_watch_waves(self, sample->i);
}

// Checks that the readings of temperature and bus change, as noise alone makes healthy ones do.
LODE_INLINE void lode_drive_note_still(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                       uint16_t count, float v_bus_V) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    (void)tuning;
    (void)count;
    (void)v_bus_V;
#else
    const uint32_t watched =
        (uint32_t)tuning->guard.still_rounds | (uint32_t)tuning->guard.bus_still_rounds;
    if (watched > 0u) {
        lode_drive_count_still(self, count, v_bus_V);
    }
#endif
}

// Plausibility of a set's currents (1/256 count). The last check was `checks` times LODE_GUARD_PERIODS ago.
LODE_INLINE void lode_drive_watch(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                  lode_plausibility_t *watch, const int32_t i[LODE_PHASES],
                                  float checks) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    (void)tuning;
    (void)watch;
    (void)i;
    (void)checks;
#else
    if (!lode_plausibility_is_on(&tuning->plausibility)) {
        return;
    }
    if (lode_plausibility_all_move(watch, &tuning->plausibility, i)) {
        lode_plausibility_note(watch, i, 0u);
    } else {
        // A copy: a sample passed by address would be kept in memory in every period.
        const int32_t copy[LODE_PHASES] = {i[0], i[1], i[2]};
        lode_drive_suspect(self, watch, copy, checks);
    }
#endif
}

#ifndef LODE_WITHOUT_PLAUSIBILITY

// The current vector is frozen (K36). Once in LODE_SLOW_PERIODS.
LODE_INLINE bool lode_drive_is_frozen(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                      lode_frozen_t *frozen, lode_ab_t i_A) {
    return !lode_frozen_moves(frozen, &tuning->plausibility, i_A) &&
           lode_drive_doubt_frozen(self, frozen);
}

#endif

// SLOT_LOCK. False: it is frozen.
LODE_INLINE bool lode_drive_watch_frozen(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
#ifdef LODE_WITHOUT_PLAUSIBILITY
    (void)self;
    (void)tuning;
    return true;
#else
    if (lode_drive_is_frozen(self, tuning, &self->frozen, self->estimator.emf.i_A)) {
        lode_mode_fault(self, LODE_CHECK_CURRENT_STUCK, 0.0f, 0.0f);
        return false;
    }
    return true;
#endif
}

// Input of the guard's slow checks. With injection either direction is right.
LODE_INLINE lode_condition_t lode_drive_condition(const lode_drive_t *self) {
    const float omega = self->estimator.pll.omega_rad_s;
    const bool either_way = lode_estimator_injects(&self->estimator);
    return (lode_condition_t){self->inverter.v_bus_V,
                              lode_sense_temperature_degC(&self->tuning->sense, self->temperature),
                              either_way ? lode_abs(omega) : self->direction * omega,
                              self->estimator.lock};
}

// `other`: temperature count of a second power stage, or of the same one.
LODE_SHARED bool lode_drive_guard(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                  const lode_sample_t *sample, uint16_t other) {
    const uint16_t count = lode_sense_hotter(&tuning->sense, sample->temperature, other);
    self->temperature = count;
    const lode_condition_t condition = lode_drive_condition(self);
    const bool runs = lode_mode(self) == LODE_MODE_RUN;
    if (!lode_guard_slow_ok(&self->guard, &tuning->guard, &condition, runs)) {
        lode_drive_check_slow(self);
    }
#ifndef LODE_WITHOUT_PLAUSIBILITY
    lode_drive_watch(self, tuning, &self->plausibility, sample->i, 1.0f);
#endif
    return self->gates;
}

// One slot; runs after the duties are made. `words`: the complete tuning, for the memory check; `tuning` is all of it or a
// part. `one_set`: false where both of two sets are driven, which drive6.c watches each (K36).
LODE_INLINE bool lode_drive_slow_job(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                     lode_words_t words, const lode_sample_t *sample,
                                     uint16_t other, bool one_set, lode_slot_t slot) {
    switch (slot) {
    case SLOT_LOCK:
        lode_estimator_note_lock(&self->estimator, &tuning->estimator);
#ifndef LODE_WITHOUT_PLAUSIBILITY
        lode_jump_note_noise(&self->jump);
#endif
        if (one_set && !lode_drive_watch_frozen(self, tuning)) {
            return false;
        }
        if (lode_mode(self) == LODE_MODE_RUN) {
            lode_drive_count_proof(self);
            return lode_drive_watch_load(self);
        }
        break;
    case SLOT_GUARD:
        lode_drive_note_still(self, tuning,
                              lode_sense_hotter(&tuning->sense, sample->temperature, other),
                              sample->v_bus_V);
        return lode_drive_guard(self, tuning, sample, other);
    case SLOT_LAG:
        return lode_drive_slot_lag(self, tuning);
    case SLOT_DEAD_TIME:
        return lode_drive_slot_dead_time(self, tuning, words);
    case SLOT_GAINS:
        return lode_drive_slot_gains(self, tuning);
    case SLOT_GUARD_2:
        return lode_drive_guard(self, tuning, sample, other);
    case SLOT_SPEED:
        if (lode_mode(self) == LODE_MODE_RUN) {
            lode_drive_run(self);
        }
        break;
    case SLOT_REFERENCES:
        return lode_drive_slot_references(self, sample);
    case SLOT_COUNT:
    default:
        break;
    }
    return true;
}

#endif
