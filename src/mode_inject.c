#include "mode_parts.h"

#include "estimator_inline.h"
#include "open_phase_inline.h"
#include "plausibility_inline.h"
#include "start_inline.h"

// A lost rotor is searched for by injection up to this multiple of the speed at which injection ends: the EMF may have pulled
// the estimate there.
#define LOST_SPEED 2.0f
// Number of such searches. One of them is forgotten after this many rounds, 3.3 s at 5 kHz.
#define LOSSES_MAX 3u
#define FORGET_ROUNDS 2048u
// Polarity by motion (H25): share of the largest current along the axis, which keeps the phase currents away from zero, and
// the largest share of the flux that it takes or adds.
#define ALONG_SHARE 0.33f
#define ALONG_FLUX 0.5f

// Of a round, in the mean square of the EMF by which a rotor that turns is told: some periods of its ripple.
#define EMF_WEIGHT 0.125f

// Swing of the current by the wave, of the expected one: with less the sensors do not measure, with more their gains are wrong.
#define STUCK_SWING 0.1f

#ifndef LODE_WITHOUT_HFI

// The axis found points south: turns estimate, currents and voltages by half a turn.
static void turn_round(lode_drive_t *self) {
    lode_estimator_t *estimator = &self->estimator;
    estimator->pll.frame.sin = -estimator->pll.frame.sin;
    estimator->pll.frame.cos = -estimator->pll.frame.cos;
    estimator->id_A = -estimator->id_A;
    lode_hfi_turn_round(&estimator->by.hfi);
    self->i_A = (lode_dq_t){-self->i_A.d, -self->i_A.q};
    self->u_V = (lode_dq_t){-self->u_V.d, -self->u_V.q};
    lode_current_reset(&self->current, self->u_V, (lode_dq_t){0.0f, 0.0f});
}

// Starts as from OFF, but with the gates on: a rotor that turns is found by its EMF, another one by injection.
static void find_again(lode_drive_t *self) {
    self->losses++;
    self->guard.lock = 0u;
    lode_estimator_restart(&self->estimator, &self->tuning->estimator);
    lode_mode_take_q_axis(self);
    lode_current_reset(&self->current, (lode_dq_t){0.0f, 0.0f}, (lode_dq_t){0.0f, 0.0f});
    lode_start_begin(&self->state.start, &self->tuning->start);
    self->state.start.failed = self->losses;
    self->start_rounds = 0u;
    lode_mode_set(self, LODE_MODE_START);
}

// Injection found no axis, or nothing shows the polarity. The EMF shows whether a load has come to turn the rotor; any other
// one is started by the vector, from its first stage.
static void give_up(lode_drive_t *self) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const float emf_V = lode_sqrt(self->estimator.by.hfi.emf_V2);
    const lode_fault_t turned = {.state = self->mode,
                                 .stage = self->state.start.stage,
                                 .criterion = (uint_least8_t)LODE_CRITERION_SPEED,
                                 .measured = emf_V / tuning->estimator.psi_Wb,
                                 .limit = tuning->start.omega_ready};
    if (turned.measured > turned.limit) {
#ifdef LODE_WITHOUT_HANDOVER_RETRY
        if (self->losses < LOSSES_MAX) {
            find_again(self);
            return;
        }
#endif
        lode_mode_catch_again(self, &turned);
        return;
    }
    lode_estimator_restart(&self->estimator, &self->tuning->estimator);
    self->estimator.by.alone.step = (uint_least8_t)LODE_HFI_UNDECIDED;
    lode_current_reset(&self->current, (lode_dq_t){0.0f, 0.0f}, (lode_dq_t){0.0f, 0.0f});
    if (lode_mode_is_stop(self)) { // a vector would turn the rotor
        const lode_fault_t why = {.stage = self->state.start.stage,
                                  .criterion = (uint_least8_t)LODE_CRITERION_POLARITY,
                                  .measured = self->estimator.lock,
                                  .limit = LODE_LOCK_HANDOVER};
        lode_mode_fail_start(self, &why);
    }
}

// The current of LODE_HFI_PUSH (H25).
static LODE_NOINLINE lode_dq_t pushing_A(lode_drive_t *self) {
    const lode_start_tuning_t *start = &self->tuning->start;
    const lode_hfi_tuning_t *tuning = &self->tuning->estimator.hfi;
    lode_estimator_t *estimator = &self->estimator;
    if (lode_mode_is_stop(self)) { // a push would move the rotor
        estimator->by.hfi.step = (uint_least8_t)LODE_HFI_UNDECIDED;
        return (lode_dq_t){0.0f, 0.0f};
    }
    const float direction = lode_sign(self->command.speed_rad_s);
    const float step_rad = self->tuning->estimator.pll.ts_s * estimator->pll.omega_rad_s;
    const float share = lode_hfi_push(&estimator->by.hfi, tuning, lode_estimator_rotor(estimator),
                                      direction * step_rad, direction);
    if (estimator->by.hfi.step != (uint_least8_t)LODE_HFI_PUSH) {
        estimator->pll.f_rad_s2 = 0.0f; // stood for the torque, which is known from now on
    }
    const float most_A = start->current_last_A;
    const float along_A =
        lode_min(ALONG_SHARE * most_A, ALONG_FLUX / lode_max(start->lost_per_A, FLT_MIN));
    const float across_A = lode_sqrt(most_A * most_A - along_A * along_A);
    return (lode_dq_t){-along_A, direction * share * across_A};
}

// START, when no turning rotor has been caught.
static void find_at_rest(lode_drive_t *self) {
    lode_estimator_t *estimator = &self->estimator;
    lode_hfi_t *hfi = &estimator->by.hfi;
    const lode_hfi_tuning_t *tuning = &self->tuning->estimator.hfi;
    if (!hfi->active) {
        lode_estimator_restart(estimator, &self->tuning->estimator);
        const lode_ab_t i_A = estimator->emf.i_A;
        lode_hfi_begin(hfi, tuning, (lode_dq_t){i_A.alpha, i_A.beta});
    }
    // An observer whose speed is 0 shows the EMF of a rotor that turns, but not the same in every round.
    hfi->emf_V2 += EMF_WEIGHT * (lode_ab_length2(estimator->emf.observer.e_V) - hfi->emf_V2);
    estimator->gains = lode_pll_gains_of(&self->tuning->estimator.pll, tuning->find_gain);
    if (hfi->step == (uint_least8_t)LODE_HFI_RIGHT) {
        // The rotor stands still or nearly so, and the currents are in its frame already.
        lode_mode_run_at_once(self);
        return;
    }
    if (hfi->step == (uint_least8_t)LODE_HFI_PUSH) {
        self->ref_A = pushing_A(self);
    } else {
        const float i_max_A = self->tuning->references.i_max_A;
        self->ref_A = (lode_dq_t){lode_hfi_find(hfi, tuning, i_max_A), 0.0f};
    }
    switch ((lode_hfi_step_t)hfi->step) {
    case LODE_HFI_FIND: // (H14): a loop of third order would wind up its speed, and slip
        estimator->gains = (lode_pll_gains_t){tuning->find_gain, 0.0f, 0.0f};
        estimator->pll.omega_rad_s = 0.0f;
        estimator->pll.f_rad_s2 = 0.0f;
        estimator->pll.rise_rad_s = 0.0f;
        break;
    case LODE_HFI_WRONG: // RUN begins in the next round, with the right angle
        turn_round(self);
        hfi->step = (uint_least8_t)LODE_HFI_RIGHT;
        break;
    case LODE_HFI_UNDECIDED:
        give_up(self);
        break;
    case LODE_HFI_NORTH:
    case LODE_HFI_SOUTH:
    case LODE_HFI_PUSH:
    case LODE_HFI_RIGHT: // RUN begins in the next round
    default:
        break;
    }
}

#ifndef LODE_WITHOUT_PLAUSIBILITY

// A phase may be open (K41), or a load has stopped the rotor (K45): no search helps.
static bool is_explained(const lode_drive_t *self) {
    return lode_half_waves_suspect(&self->state.run.waves) > 0u ||
           lode_guard_saw_rotor_stopped(&self->guard);
}

#else

static bool is_explained(const lode_drive_t *self) {
    (void)self;
    return false;
}

#endif

LODE_NOINLINE void lode_mode_find_lost(lode_drive_t *self) {
    const lode_hfi_tuning_t *tuning = &self->tuning->estimator.hfi;
    const bool searches = lode_hfi_is_on(tuning) && lode_mode(self) == LODE_MODE_RUN &&
                          !lode_mode_is_sensored(self) &&
                          lode_guard_found_nothing_else(&self->guard);
    if (searches && lode_mode_loses_lock(self) && self->losses < LOSSES_MAX &&
        !is_explained(self) &&
        lode_abs(self->estimator.pll.omega_rad_s) < LOST_SPEED * tuning->omega_high) {
        lode_guard_withdraw(&self->guard);
        self->calm = self->state.run.speed.calmed;
        find_again(self);
    }
}

static void inject_running(lode_drive_t *self) {
    lode_estimator_t *estimator = &self->estimator;
    const float omega = estimator->pll.omega_rad_s;
    if (self->losses > 0u && self->steps / LODE_SLOW_PERIODS % FORGET_ROUNDS == 0u) {
        self->losses--;
    }
    if (lode_hfi_follow(&estimator->by.hfi, &self->tuning->estimator.hfi, self->i_A, omega)) {
        const lode_estimator_tuning_t *tuning = &self->tuning->estimator;
        const float by_emf = lode_pll_x(&tuning->pll, omega);
        const float by_wave = tuning->hfi.find_gain - by_emf;
        estimator->gains =
            lode_pll_gains_of(&tuning->pll, by_emf + estimator->by.hfi.weight * by_wave); // (H28)
        self->direction = lode_sign(omega); // RUN with injection may have either direction
    } else {
        lode_estimator_end_injection(estimator, &self->tuning->estimator);
    }
}

#ifndef LODE_WITHOUT_PLAUSIBILITY

// (H29). The wave is a test of all current sensors in every round.
static void watch_wave(lode_drive_t *self) {
    lode_hfi_t *hfi = &self->estimator.by.hfi;
    const lode_hfi_tuning_t *tuning = &self->tuning->estimator.hfi;
    const lode_references_tuning_t *motor = &self->tuning->references;
    const bool searches =
        lode_mode(self) == LODE_MODE_START && hfi->step == (uint_least8_t)LODE_HFI_FIND;
    const float least = motor->Ld_H / lode_max(motor->Lq_H, FLT_MIN);
    if (lode_plausibility_is_on(&self->tuning->plausibility) &&
        !lode_hfi_shows_wave(hfi, tuning, searches, least)) {
        const lode_plausibility_tuning_t *checks = &self->tuning->plausibility;
        const float swing = lode_hfi_swing(hfi, tuning);
        const bool gone = swing < STUCK_SWING;
        const bool runs = lode_mode(self) == LODE_MODE_RUN;
        const lode_open_phase_t open =
            runs ? lode_half_waves_suspect(&self->state.run.waves) : (lode_open_phase_t)0u;
        if (open > 0u) { // the wave finds no way through it
            lode_mode_fault(self, LODE_CHECK_OPEN_PHASE, (float)open, 0.0f);
        } else if (gone && lode_plausibility_has_stuck(checks)) {
            lode_mode_fault(self, LODE_CHECK_CURRENT_STUCK, 0.0f, 0.0f);
        } else if (!gone && lode_plausibility_has_gain(checks)) {
            lode_mode_fault(self, LODE_CHECK_CURRENT_GAIN, swing, 1.0f);
        } else {
            // not checked
        }
    }
}

#else

static void watch_wave(const lode_drive_t *self) {
    (void)self;
}

#endif

LODE_NOINLINE bool lode_mode_inject(lode_drive_t *self) {
    const lode_mode_t mode = lode_mode(self);
    if (mode == LODE_MODE_START && !lode_start_catches(&self->state.start) &&
        lode_mode_finds_at_rest(self)) {
        find_at_rest(self);
    } else if (mode == LODE_MODE_RUN && !lode_mode_is_sensored(self)) {
        inject_running(self);
    } else {
        lode_estimator_end_injection(&self->estimator, &self->tuning->estimator);
    }
    lode_hfi_t *hfi = &self->estimator.by.hfi;
    if (!hfi->active) {
        return false;
    }
    // Where current control is below its limits with this reserve, the modulator is so with the wave.
    hfi->reserve_V = self->tuning->estimator.hfi.V_h_V / self->tuning->current.free;
    lode_estimator_drop_disturbance(&self->estimator, &self->tuning->estimator);
    watch_wave(self);
    return true;
}

#endif
