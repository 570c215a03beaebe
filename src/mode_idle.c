#include "mode_parts.h"

#include "estimator_inline.h"
#include "inverter_inline.h"
#include "start_inline.h"

// The low sides short-circuit a rotor that turns: a fifth of a period limits its current, and is longer than any shunt
// amplifier takes to settle.
#define DUTY_PRECHARGE 0.8f

// The mode to which the command leads from OFF: START for RUN (with speed 0 only where the rotor can be held at rest).
static lode_mode_t driven_mode(const lode_drive_t *self) {
    const lode_mode_t wanted = (lode_mode_t)self->command.mode;
    const bool at_rest = lode_mode_finds_at_rest(self) || lode_mode_is_sensored(self);
    if (wanted == LODE_MODE_RUN && (!lode_mode_is_stop(self) || at_rest)) {
        return LODE_MODE_START;
    }
    return lode_mode_is_commissioning(wanted) ? wanted : LODE_MODE_OFF;
}

#ifndef LODE_WITHOUT_PRECHARGE

// The attempt before has ended because a phase seemed to be open.
static bool seemed_open(const lode_drive_t *self) {
    return lode_mode_retries(self) &&
           self->guard.fault.criterion == (uint_least8_t)LODE_CRITERION_OPEN_PHASE;
}

// Bridge and sensors are to be checked. Another attempt relies on the first one's check, unless a phase has seemed open since.
static bool check_is_due(const lode_drive_t *self) {
    return !lode_mode_retries(self) || seemed_open(self);
}

#endif

// The low sides switch on with their duties, one period later. False: PRECHARGE is not needed.
static bool begins_precharge(lode_drive_t *self, lode_mode_t driven) {
#ifdef LODE_WITHOUT_PRECHARGE
    (void)self;
    (void)driven;
    return false;
#else
    const lode_drive_tuning_t *tuning = self->tuning;
    if (driven == LODE_MODE_START && check_is_due(self)) {
        self->known = (uint_least8_t)(self->known & (uint32_t)LODE_KNOWN_OFFSETS);
    }
    bool flies = false;
    bool only_checks = false; // no low-side pulses show a rotor that turns: the check itself does
#ifndef LODE_WITHOUT_FLYING_START
    flies = driven == LODE_MODE_START && tuning->fly.share_first > 0.0f;
#else
    (void)driven;
#endif
#ifndef LODE_WITHOUT_SIGNAL_CHECK
    only_checks = driven == LODE_MODE_START && tuning->signal_check.pulses > 0u && !flies;
#endif
    if (tuning->inverter.precharge_periods == 0u && !flies && !only_checks) {
        return false;
    }
    self->state.precharge = (lode_precharge_t){
        .driven = (uint_least8_t)driven,
        .part = (uint_least8_t)(flies ? LODE_PRECHARGE_PULSES : LODE_PRECHARGE_CHARGE),
        .rests = (uint_least8_t)(only_checks ? 1u : 0u)};
    // These act when the low sides switch on: a board may do so at once.
    lode_mode_set_duties(self, flies ? 1.0f : lode_min(DUTY_PRECHARGE, tuning->sense.duty_max));
    lode_mode_reset_guard(self);
    lode_mode_set(self, LODE_MODE_PRECHARGE);
    return true;
#endif
}

static void follow_off(lode_drive_t *self) {
    const lode_mode_t driven = driven_mode(self);
    if (driven != LODE_MODE_START) { // no further attempt of the start before
        self->losses = 0u;
        self->calm = 0u;
    }
    if (self->command.mode == (uint_least8_t)LODE_MODE_CALIBRATE ||
        (driven == LODE_MODE_START && !lode_drive_knows(self, LODE_KNOWN_OFFSETS))) {
        lode_sense_begin(&self->state.sums);
        lode_mode_set(self, LODE_MODE_CALIBRATE);
    } else if (driven != LODE_MODE_OFF && !begins_precharge(self, driven)) {
        lode_mode_switch_on(self, driven);
    } else {
        // it stays off, or PRECHARGE comes first
    }
}

#ifndef LODE_WITHOUT_FLYING_START

// To RUN with the angle and speed found. The gates switch on two periods from now; until then the terminals are open, and
// their voltage is the EMF.
static LODE_NOINLINE void take_flight(lode_drive_t *self, float theta_rad, float omega) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const lode_sincos_t rotor = lode_sincos(theta_rad);
    const lode_sincos_t half = lode_sincos(0.5f * tuning->estimator.pll.ts_s * omega);
    self->u_V = (lode_dq_t){0.0f, tuning->estimator.psi_Wb * omega};
    lode_mode_switch_on(self, LODE_MODE_START);
    lode_estimator_begin_at(&self->estimator, &tuning->estimator, rotor, omega);
    const lode_dq_t emf = {0.0f, self->u_V.q * self->inverter.per_V};
    const lode_sincos_t first = lode_angle_add(rotor, half);
    const lode_sincos_t second = lode_angle_add(first, lode_angle_double(half));
    lode_inverter_write(&self->inverter, self->steps + 1u, lode_park_inverse(emf, first));
    lode_inverter_write(&self->inverter, self->steps, lode_park_inverse(emf, second));
    // A board may switch the gates on at once, before the first duties of RUN.
    self->duty = lode_mode_duties_at(lode_clarke_inverse(lode_park_inverse(emf, second)));
    self->i_A = (lode_dq_t){0.0f, 0.0f};
    self->lead = lode_angle_triple(half);
    self->direction = lode_sign(omega);
    lode_mode_run_at_once(self);
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    self->state.run.proving = lode_mode_rounds_to_prove(self, self->estimator.pll.omega_rad_s);
#endif
}

// One period of the low-side pulses.
static LODE_NOINLINE void fly_on(lode_drive_t *self, lode_ab_t i_A) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const lode_fly_given_t given = {
        .ts_s = tuning->estimator.pll.ts_s,
        .i_max_A = tuning->references.i_max_A,
        .psi_Wb = tuning->estimator.psi_Wb,
        .Lq_H = tuning->references.Lq_H,
        .inv_Ld = tuning->references.inv_Ld,
        .duty_max = tuning->sense.duty_max,
        .omega_handover = tuning->start.omega_handover,
        .catch_rounds = tuning->start.catch_rounds,
        .v_bus_V = self->inverter.v_bus_V,
        .charge = (1.0f - DUTY_PRECHARGE) * (float)(int32_t)tuning->inverter.precharge_periods,
    };
    lode_fly_step(&self->state.precharge.by.fly, &tuning->fly, i_A, &given);
}

// The low-side pulses of a flying start. True: the period is theirs, and RUN may have begun.
static LODE_NOINLINE bool follow_flight(lode_drive_t *self, const lode_sample_t *sample) {
    lode_precharge_t *precharge = &self->state.precharge;
    const lode_fly_t *fly = &precharge->by.fly;
    if (precharge->part != (uint_least8_t)LODE_PRECHARGE_PULSES) {
        return false;
    }
    fly_on(self, sample->i_A);
    // The last limit of the duties, as in a driven period.
    lode_mode_set_duties(self, lode_clamp(1.0f - fly->share, 0.0f, 1.0f));
    if (fly->stage == (uint_least8_t)LODE_FLY_FOUND) {
        take_flight(self, fly->theta_rad, fly->omega_rad_s); // overwrites state.precharge
        return true;
    }
    if (fly->stage == (uint_least8_t)LODE_FLY_SLOW) {
        precharge->rests = fly->rests;
        precharge->part = (uint_least8_t)LODE_PRECHARGE_CHARGE;
        return false;
    }
    return true;
}

#endif

#ifndef LODE_WITHOUT_SIGNAL_CHECK

// One period of the check of bridge and sensors. True: the period is its own, and it may have tripped.
static LODE_NOINLINE bool check_signals(lode_drive_t *self, const lode_sample_t *sample) {
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_precharge_t *precharge = &self->state.precharge;
    lode_signal_check_t *check = &precharge->by.check;
    if (precharge->part != (uint_least8_t)LODE_PRECHARGE_CHECK) {
        precharge->part = (uint_least8_t)LODE_PRECHARGE_CHECK;
        lode_signal_check_begin(check, &tuning->signal_check,
                                precharge->rests > 0u && check_is_due(self));
    }
    if (!lode_signal_check_goes_on(check, &tuning->signal_check)) {
        return false;
    }
    const lode_ab_t per_V =
        lode_signal_check_step(check, &tuning->signal_check, &tuning->sense, sample->i);
    self->duty = lode_mode_duties_at(lode_clarke_inverse(per_V));
    const float v_bus_V = self->inverter.v_bus_V;
    const lode_finding_t found =
        lode_signal_check_judge(check, &tuning->signal_check, v_bus_V, tuning->estimator.pll.ts_s);
    // With the bus outside of its limits the check says nothing: the guard reports the bus.
    const bool bus = lode_in_range(v_bus_V, tuning->guard.v_bus_min, tuning->guard.v_bus_max);
    if (bus && found.check != LODE_CHECK_NONE) {
        lode_mode_fault(self, found.check, found.measured, found.limit);
    } else if (bus && lode_signal_check_is_through(check, &tuning->signal_check)) {
        self->known = (uint_least8_t)(self->known | (uint32_t)LODE_KNOWN_SIGNALS);
    } else {
        // more pulses follow, or the check is skipped
    }
    return true;
}

#endif

#ifndef LODE_WITHOUT_PRECHARGE

// START after the check: a rotor that is surely salient gets the vector ahead of its axis, if that is known (S40).
static LODE_NOINLINE void switch_on_ahead(lode_drive_t *self, lode_mode_t driven) {
#ifdef LODE_WITHOUT_SIGNAL_CHECK
    lode_mode_switch_on(self, driven);
#else
    const lode_references_tuning_t *motor = &self->tuning->references;
    const lode_sincos_t axis = lode_signal_check_axis(&self->state.precharge.by.check);
    const bool known = lode_abs(axis.sin) + lode_abs(axis.cos) > 0.0f;
    lode_mode_switch_on(self, driven); // overwrites state.precharge
    if (driven == LODE_MODE_START && known && motor->Lq_H * motor->inv_Ld >= LODE_SURELY_SALIENT) {
        lode_start_lead(&self->state.start, axis, self->command.speed_rad_s);
    }
#endif
}

static void follow_precharge(lode_drive_t *self, const lode_sample_t *sample) {
    const lode_mode_t driven = driven_mode(self);
    if (driven != (lode_mode_t)self->state.precharge.driven) {
        lode_mode_switch_off(self); // another mode begins in OFF: it may have to calibrate first
        return;
    }
#ifdef LODE_WITHOUT_FLYING_START
    (void)sample;
#else
    if (follow_flight(self, sample)) {
        return;
    }
#endif
    if (self->state.precharge.periods < self->tuning->inverter.precharge_periods) {
        self->state.precharge.periods++;
        lode_mode_set_duties(self, lode_min(DUTY_PRECHARGE, self->tuning->sense.duty_max));
        return;
    }
#ifndef LODE_WITHOUT_SIGNAL_CHECK
    if (check_signals(self, sample)) {
        return;
    }
    if (seemed_open(self) && !lode_drive_knows(self, LODE_KNOWN_SIGNALS)) {
        const lode_fault_t last = self->guard.fault; // not refuted, as the rotor turns
        lode_mode_fault(self, LODE_CHECK_OPEN_PHASE, last.measured, last.limit);
        return;
    }
#endif
    switch_on_ahead(self, driven);
}

#endif

static void follow_calibrate(lode_drive_t *self, lode_calibration_t calibration,
                             float offset_count) {
    if (calibration == LODE_CALIBRATION_IMPLAUSIBLE) {
        const float limit = (float)self->tuning->sense.offset_tol / (float)LODE_COUNT_FRACTION;
        lode_mode_fault(self, LODE_CHECK_OFFSET, offset_count, limit);
    } else if (calibration == LODE_CALIBRATION_STUCK) {
        lode_mode_fault(self, LODE_CHECK_CURRENT_STUCK, offset_count, 0.0f);
    } else if (calibration == LODE_CALIBRATION_DONE) {
        self->known = (uint_least8_t)(self->known | (uint32_t)LODE_KNOWN_OFFSETS);
        lode_mode_set(self, LODE_MODE_OFF);
        if (self->command.mode == (uint_least8_t)LODE_MODE_CALIBRATE) {
            self->command.mode = (uint_least8_t)LODE_MODE_OFF;
            self->command.check = lode_mode_order_check(&self->command);
        }
    } else if (self->command.mode == (uint_least8_t)LODE_MODE_OFF) {
        lode_mode_set(self, LODE_MODE_OFF);
    } else {
        // more samples follow
    }
}

// At most one transition per period.
void lode_mode_idle(lode_drive_t *self, lode_words_t tuning, const lode_sample_t *sample,
                    lode_calibration_t calibration, float offset_count) {
    if (!lode_mode_memory_ok(self, tuning)) {
        lode_mode_distrust(self);
        return;
    }
#ifdef LODE_WITHOUT_PRECHARGE
    (void)sample;
#endif
    switch (lode_mode(self)) {
    case LODE_MODE_OFF:
        follow_off(self);
        break;
    case LODE_MODE_CALIBRATE:
        follow_calibrate(self, calibration, offset_count);
        break;
#ifndef LODE_WITHOUT_PRECHARGE
    case LODE_MODE_PRECHARGE:
        follow_precharge(self, sample);
        break;
#endif
    case LODE_MODE_FAULT:
        if (lode_mode_clears_fault(self)) {
            lode_guard_reset(&self->guard);
            lode_mode_switch_off(self);
        }
        break;
    case LODE_MODE_VOLTAGE: // these have the gates on and do not come here
    case LODE_MODE_CURRENT:
    case LODE_MODE_START:
    case LODE_MODE_RUN:
    default:
        break;
    }
    lode_mode_count_sensor(self);
}
