#include "drive_inline.h"
#include "open_phase_inline.h"
#include "start_inline.h"

#define TELEMETRY_TRIES 3
// Of the voltage circle: with less EMF there is voltage left to drive the current that is asked for.
#define EMF_SHARE 0.8f
// Lost lock is that of another flux where the EMF is where it should be, there is half of it at least (a rotor that is
// stopped has less), and it is off by more than a tuning and a hot magnet explain.
#define LEAST_FLUX 0.5f
#define ANOTHER_FLUX 0.2f
// Of inductances and resistance, as for (S34) and (K16).
#define L_UNSURE 0.2f
#define R_UNSURE 0.5f
#define FLUX_CURRENT 9.0f // times the least current that is judged by, squared: 0.15 of i_max
#define FLUX_s 0.05f      // longer than a speed that changes fast is behind the EMF
#define FLUX_ROUNDS_MAX 255u
#define SOUND_LOCK 0.9f   // an EMF that is off by less than 8 %
#define ALL_VOLTAGE 0.99f // of the circle, on which rounding leaves it
// Of what limits the torque: the voltage moves that a little in each round.
#define ALL_TORQUE 0.9f
#define FOLLOWED 0.8f  // of the current that is asked for
#define FAR_OFF 0.05f  // of the speed that is asked for
#define BUS_SHARE 0.1f // of the flux, by which the EMF is off when the bus is not what is read
#define MOVED_FLUX_MAX 0.35f // of the flux, that a d current may take or give at once

lode_status_t lode_drive_begin(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
    if (!lode_mode_is_finite(tuning)) {
        return LODE_ERROR_TUNING;
    }
    *self = (lode_drive_t){.tuning = tuning, .direction = 1.0f};
#ifndef LODE_WITHOUT_TORQUE_LIMITS
    lode_drive_limit_torque(self, 1.0f);
#endif
    self->command.check = lode_mode_order_check(&self->command);
    lode_mode_post_check(self, lode_mode_words(tuning));
    lode_mode_take_check(self);
    lode_sense_reset(&self->sense, &tuning->sense);
    lode_guard_reset(&self->guard);
    lode_mode_switch_off(self);
    return LODE_OK;
}

lode_status_t lode_drive_init(lode_drive_t *self, lode_drive_tuning_t *tuning,
                              const lode_drive_config_t *config) {
    if (self == NULL) {
        return LODE_ERROR_NULL;
    }
    const lode_status_t status = lode_drive_tune(tuning, config);
    return status == LODE_OK ? lode_drive_begin(self, tuning) : status;
}

// Tells the interrupt that there is mail. In this order: it may come in between.
void lode_drive_call(lode_drive_t *self) {
    LODE_SIGNAL_FENCE();
    LODE_SHARED_STORE(self->mail, true);
    LODE_SIGNAL_FENCE();
    LODE_SHARED_STORE(self->steady, false);
}

static bool is_finite(const lode_command_t *command) {
#ifndef LODE_WITHOUT_COMMISSIONING
    if (!lode_is_finite(command->vector.d) || !lode_is_finite(command->vector.q) ||
        !lode_is_finite(command->theta_rad) || !lode_is_finite(command->omega_rad_s)) {
        return false;
    }
#endif
    return lode_is_finite(command->speed_rad_s) && lode_is_finite(command->torque_Nm);
}

static bool wants_short(const lode_command_t *command) {
#ifdef LODE_WITHOUT_ACTIVE_SHORT
    (void)command;
    return false;
#else
    return command->active_short;
#endif
}

// The largest speed of a command, mechanical: for more the estimator is not made, or the guard trips.
static float most_rad_s(const lode_drive_tuning_t *tuning) {
    const float estimator = tuning->estimator.omega_limit / LODE_ALIAS_SHARE;
    return lode_min(estimator, tuning->guard.omega_max) * tuning->speed.inv_pole_pairs;
}

lode_status_t lode_drive_post_command(lode_drive_t *self, const lode_command_t *command) {
    if (self == NULL || command == NULL) {
        return LODE_ERROR_NULL;
    }
    const bool known = command->mode == LODE_MODE_OFF || command->mode == LODE_MODE_CALIBRATE ||
                       command->mode == LODE_MODE_RUN || lode_mode_is_commissioning(command->mode);
#ifdef LODE_WITHOUT_TORQUE_CONTROL
    const bool torque = false;
#else
    const bool torque = command->control == LODE_CONTROL_TORQUE;
#endif
    const bool controlled = command->control == LODE_CONTROL_SPEED || torque;
    if (!known || !controlled || !is_finite(command)) {
        return LODE_ERROR_COMMAND;
    }
    if (command->mode == LODE_MODE_RUN &&
        lode_abs(command->speed_rad_s) > most_rad_s(self->tuning)) {
        return LODE_ERROR_COMMAND_SPEED;
    }
    LODE_SHARED_STORE(self->command_posted, LODE_POST_NONE);
    LODE_SIGNAL_FENCE();
    lode_order_t order = {
        .speed_rad_s = command->speed_rad_s,
        .value.torque_Nm = command->torque_Nm,
        .mode = command->mode,
        .flags = (uint_least8_t)((command->clear_fault ? (uint32_t)LODE_ORDER_CLEAR_FAULT : 0u) |
                                 (torque ? (uint32_t)LODE_ORDER_TORQUE : 0u) |
                                 (wants_short(command) ? (uint32_t)LODE_ORDER_SHORT : 0u)),
    };
#ifndef LODE_WITHOUT_COMMISSIONING
    if (command->mode != LODE_MODE_RUN) {
        order.speed_rad_s = command->omega_rad_s;
        order.theta_rad = command->theta_rad;
        order.value.vector = command->vector;
    }
#endif
    order.check = lode_mode_order_check(&order);
    self->posted = order;
    LODE_SIGNAL_FENCE();
    LODE_SHARED_STORE(self->command_posted, LODE_POST_FULL);
    lode_drive_call(self);
    return LODE_OK;
}

lode_status_t lode_drive_post_tuning(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
    if (self == NULL || tuning == NULL) {
        return LODE_ERROR_NULL;
    }
    if (!lode_mode_is_finite(tuning)) {
        return LODE_ERROR_TUNING;
    }
    LODE_SHARED_STORE(self->posted_tuning,
                      NULL); // one not yet taken would come with this one's check
    LODE_SIGNAL_FENCE();
    lode_mode_post_check(self, lode_mode_words(tuning));
    LODE_SIGNAL_FENCE();
    LODE_SHARED_STORE(self->posted_tuning, tuning);
    lode_drive_call(self);
    return LODE_OK;
}

#ifndef LODE_WITHOUT_TORQUE_LIMITS

static uint_least16_t torque_share(float share) {
    const float steps = (float)LODE_TORQUE_SHARE_ONE * lode_clamp(share, 0.0f, 1.0f) + 0.5f;
    return (uint_least16_t)steps;
}

void lode_drive_limit_torque(lode_drive_t *self, float share) {
    lode_drive_limit_torques(self, share, share);
}

void lode_drive_limit_torques(lode_drive_t *self, float motoring, float braking) {
    self->torque_share[0] = torque_share(motoring); // each is read once in a round, as a whole
    self->torque_share[1] = torque_share(braking);
}

#endif

bool lode_drive_tuning_taken(const lode_drive_t *self) {
    LODE_SIGNAL_FENCE();
    return LODE_SHARED_LOAD(self->posted_tuning) == NULL;
}

static bool is_limited(const lode_speed_t *speed) {
    return !(speed->torque_Nm > speed->limit_Nm.min && speed->torque_Nm < speed->limit_Nm.max);
}

static float most_Nm(const lode_drive_t *self) {
#ifdef LODE_WITHOUT_TORQUE_LIMITS
    (void)self;
    return 0.0f;
#else
    return lode_references_allowed_Nm(&self->state.run.references, &self->tuning->references,
                                      self->ref_A.d);
#endif
}

// The least speed is held in place of the commanded one. (A stop goes through it.)
static bool is_raised(const lode_drive_t *self) {
    const float commanded = lode_abs(self->command.speed_rad_s);
    return !lode_mode_is_sensored(self) && commanded > 0.0f &&
           commanded < self->tuning->omega_min * self->tuning->speed.inv_pole_pairs;
}

// The position error by either source, and how the loop shares them.
static void tell_errors(const lode_estimator_t *estimator, lode_telemetry_t *telemetry) {
    telemetry->emf_error_rad =
        lode_park(estimator->emf.observer.e_V, estimator->pll.frame).d * estimator->per_V;
#ifndef LODE_WITHOUT_HFI
    if (estimator->by.hfi.active) {
        telemetry->injected = estimator->by.hfi.weight;
        telemetry->injection_error_rad = estimator->by.hfi.error;
    }
#endif
}

bool lode_drive_telemetry(const lode_drive_t *self, lode_telemetry_t *telemetry) {
    for (int32_t i = 0; i < TELEMETRY_TRIES; i++) {
        const uint32_t steps = LODE_SHARED_LOAD(self->steps);
        LODE_SIGNAL_FENCE();
        const lode_pll_t *pll = &self->estimator.pll;
        const lode_speed_t *speed =
            lode_mode(self) == LODE_MODE_RUN ? &self->state.run.speed : NULL;
        *telemetry = (lode_telemetry_t){
            .steps = steps,
            .mode = lode_mode(self),
            .start_stage = lode_drive_start_stage(self),
            .fault = self->guard.fault,
            .torque_limited = speed != NULL && is_limited(speed),
            .speed_raised = speed != NULL && is_raised(self),
            .retries = lode_drive_retries(self),
            .duty = self->duty,
            .i_A = self->i_A,
            .ref_A = self->ref_A,
            .u_V = self->u_V,
            .v_bus_V = self->inverter.v_bus_V,
            .temperature_degC =
                lode_sense_temperature_degC(&self->tuning->sense, self->temperature),
            .theta_rad = lode_estimator_theta_rad(&self->estimator),
            .omega_rad_s = pll->omega_rad_s,
            .speed_ref_rad_s = lode_drive_speed_ref_rad_s(self),
            .torque_ref_Nm = speed != NULL ? speed->torque_Nm : 0.0f,
            .torque_most_Nm = speed != NULL ? most_Nm(self) : 0.0f,
            .load_torque_Nm = self->tuning->estimator.load_per_f_Nm * pll->f_rad_s2,
            .lock = self->estimator.lock,
            .e_V = self->estimator.emf.observer.e_V,
        };
        tell_errors(&self->estimator, telemetry);
        LODE_SIGNAL_FENCE();
        if (steps == LODE_SHARED_LOAD(self->steps)) {
            return true;
        }
    }
    return false;
}

#ifndef LODE_WITHOUT_PLAUSIBILITY

// In FAULT without a short of the drive's own. Where the EMF is above the bus, current flows through the diodes of a
// sound bridge too.
static bool is_open(const lode_drive_t *self) {
    const float emf_V =
        LODE_SQRT3 * self->tuning->references.psi_Wb * lode_abs(self->estimator.pll.omega_rad_s);
    return lode_mode(self) == LODE_MODE_FAULT && !lode_mode_shorts(self) &&
           emf_V <= self->inverter.v_bus_V;
}

#endif

LODE_NOINLINE void lode_drive_diagnose(lode_drive_t *self, const lode_sense_t *sense,
                                       const lode_sample_t *sample) {
    if (self->gates || lode_mode_precharges(self)) {
        lode_guard_diagnose(&self->guard, &self->tuning->guard, sense, &self->tuning->sense, sample,
                            self->mode);
        lode_mode_obey_guard(self);
        return;
    }
#ifndef LODE_WITHOUT_PLAUSIBILITY
    if (is_open(self)) {
        lode_guard_suspect(&self->guard, &self->tuning->guard, &self->tuning->sense, sample);
    }
#endif
}

#ifndef LODE_WITHOUT_PLAUSIBILITY

// The EMF is along the rotor's q axis, and off what the speed induces by `least_Wb` at least.
static bool is_another_flux(lode_flux_t flux, float least_Wb) {
    return flux.aligned && flux.seen_Wb >= LEAST_FLUX * flux.expected_Wb &&
           lode_abs(flux.seen_Wb - flux.expected_Wb) >= least_Wb;
}

// The lock was lost by the EMF's size alone, at every look since it was first found to be.
static void name_lost_lock(lode_drive_t *self) {
    lode_guard_t *guard = &self->guard;
    const lode_flux_t flux = lode_estimator_flux(&self->estimator, &self->tuning->estimator);
    const bool before = guard->flux || guard->lock <= 1u;
    const bool now = is_another_flux(flux, ANOTHER_FLUX * flux.expected_Wb);
    guard->flux = guard->lock > 0u && before && now;
    if (guard->flux && guard->fault.check == (uint_least8_t)LODE_CHECK_LOST_LOCK) {
        guard->fault.check = (uint_least8_t)LODE_CHECK_FLUX;
        guard->fault.measured = flux.seen_Wb;
        guard->fault.limit = flux.expected_Wb;
    }
}

#endif

LODE_NOINLINE void lode_drive_check_slow(lode_drive_t *self) {
    const lode_situation_t now = {self->mode, lode_mode(self) == LODE_MODE_RUN};
    lode_guard_check_slow(&self->guard, &self->tuning->guard, lode_drive_condition(self), now);
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    lode_mode_prove_start(self);
#endif
#ifndef LODE_WITHOUT_PLAUSIBILITY
    name_lost_lock(self);
#endif
    lode_mode_obey_guard(self);
}

#ifndef LODE_WITHOUT_OPTIMAL_REFERENCES

// Not with injection: it goes by the inductances themselves, and learn.h may have found the present Lq.
static bool goes_by_emf(const lode_estimator_tuning_t *tuning) {
#ifdef LODE_WITHOUT_HFI
    (void)tuning;
    return true;
#else
    return !lode_hfi_is_on(&tuning->hfi);
#endif
}

// Current control with the q axis of the present current and its reference.
static void saturate_control(lode_drive_t *self) {
    const lode_references_tuning_t *motor = &self->tuning->references;
    lode_current_saturate(&self->current, &self->tuning->current, motor->Lq_H, motor->Lq_fall,
                          self->i_A.q, self->ref_A.q);
}

LODE_NOINLINE void lode_drive_optimal_references(lode_drive_t *self) {
    const lode_references_tuning_t *tuning = &self->tuning->references;
    lode_running_t *run = &self->state.run;
    const lode_references_out_t out =
        lode_references_optimal(&run->references, tuning, run->speed.torque_Nm,
                                self->estimator.pll.omega_rad_s, self->inverter.v_bus_V);
    self->ref_A = out.i_A;
    run->speed.limit_Nm = lode_drive_torque_limits(self, out.torque_Nm);
    if (lode_references_asks(tuning, LODE_REFERENCES_SATURATE)) {
        saturate_control(self); // before the step of the current
    }
}

LODE_NOINLINE void lode_drive_adapt_saturated_lag(lode_drive_t *self) {
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_estimator_t *estimator = &self->estimator;
    const lode_dq_t i_A = lode_park(estimator->emf.i_A, lode_estimator_rotor(estimator));
    lode_estimator_adapt_lag(estimator, &tuning->estimator);
    if (goes_by_emf(&tuning->estimator)) {
        estimator->lag.at = lode_references_saturated(&tuning->references, estimator->lag.at, i_A);
    }
}

#endif

#ifndef LODE_WITHOUT_PLAUSIBILITY

// In seconds, rounds of the slow jobs.
static float rounds_s(const lode_drive_t *self, uint32_t rounds) {
    const uint32_t periods = rounds * LODE_SLOW_PERIODS;
    return (float)periods * self->tuning->estimator.pll.ts_s;
}

// One more round with the same count. True: it has been `limit` of them. 0: it may be any.
static bool is_still(uint_least16_t *rounds, bool same, uint32_t limit) {
    const bool still = same && limit > 0u;
    *rounds = still ? (uint_least16_t)(*rounds + 1u) : 0u;
    return still && *rounds >= limit;
}

LODE_NOINLINE void lode_drive_count_still(lode_drive_t *self, uint16_t count, float v_bus_V) {
    lode_guard_t *guard = &self->guard;
    const lode_drive_tuning_t *tuning = self->tuning;
    const uint32_t rounds = tuning->guard.still_rounds;
    const uint32_t bus_rounds = tuning->guard.bus_still_rounds;
    const bool same = count == guard->still_count;
    const bool same_bus = lode_in_range(v_bus_V, guard->still_V, guard->still_V);
    guard->still_count = count;
    guard->still_V = v_bus_V;
    if (is_still(&guard->still, same, rounds)) {
        lode_mode_fault(self, LODE_CHECK_TEMPERATURE_STUCK,
                        lode_sense_temperature_degC(&tuning->sense, count), rounds_s(self, rounds));
    }
    // Another bus than the one that is read makes another EMF of the same voltage.
    const lode_flux_t flux = lode_estimator_flux(&self->estimator, &tuning->estimator);
    const bool off = lode_mode(self) == LODE_MODE_RUN &&
                     lode_abs(flux.seen_Wb - flux.expected_Wb) > BUS_SHARE * flux.expected_Wb;
    if (is_still(&guard->bus_still, same_bus && off, bus_rounds)) {
        lode_mode_fault(self, LODE_CHECK_BUS_STUCK, v_bus_V, rounds_s(self, bus_rounds));
    }
}

// Square of the current that the phases should show.
static float expected_A2(const lode_drive_t *self, float omega_rad_s) {
    const lode_current_tuning_t *control = &self->tuning->current;
    // Where the EMF takes the voltage, the current need not follow its reference.
    const bool follows = self->tuning->references.psi_Wb * omega_rad_s <
                         EMF_SHARE * control->circle * self->inverter.v_bus_V;
    const lode_dq_t i_A = follows ? self->ref_A : self->i_A;
    return i_A.d * i_A.d + i_A.q * i_A.q;
}

// At its zero a phase's current asks for the voltage of the inductance: where dead time and drops take more, they
// hold it there.
static lode_hold_t hold_of(const lode_drive_t *self) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const lode_inverter_tuning_t *inverter = &tuning->inverter;
    const float dead_duty = inverter->dead_duty + inverter->dead_more_max;
    const float Lq_H = tuning->estimator.emf.inv_b * tuning->estimator.pll.ts_s;
    return (lode_hold_t){.taken_V = dead_duty * self->inverter.v_bus_V + 2.0f * inverter->v_drop_V,
                         .x_Ohm = Lq_H * lode_mode_frame_omega(self)};
}

static LODE_NOINLINE void find(lode_drive_t *self, lode_plausibility_t *watch, uint32_t doubt) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const lode_finding_t found =
        lode_plausibility_find(watch, &tuning->plausibility, doubt, tuning->guard.lock_looks,
                               hold_of(self), lode_abs(tuning->sense.i_gain));
    if (found.check != LODE_CHECK_NONE) {
        const bool second = watch != &self->plausibility && found.check == LODE_CHECK_CURRENT_STUCK;
        const float before = second ? (float)LODE_PHASES : 0.0f;
        lode_mode_fault(self, found.check, found.measured + before, found.limit);
    }
}

LODE_NOINLINE void lode_drive_note_waves(lode_drive_t *self, const int32_t i[LODE_PHASES]) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const float round_s = (float)LODE_SLOW_PERIODS * tuning->estimator.pll.ts_s;
    const uint_least8_t phase =
        lode_waves_step(&self->state.start.seen.turn.waves, &tuning->plausibility, i,
                        self->ref_A.d * self->ref_A.d, round_s * self->state.start.omega_rad_s);
    if (phase > 0u) {
        lode_mode_fault(self, LODE_CHECK_OPEN_PHASE, (float)phase, 0.0f);
    }
}

static LODE_NOINLINE void judge_half_waves(lode_drive_t *self, lode_half_waves_t *waves) {
    const lode_estimator_t *estimator = &self->estimator;
    const float round_s = (float)LODE_SLOW_PERIODS * self->tuning->estimator.pll.ts_s;
    const lode_ab_t ref_A = lode_park_inverse(self->ref_A, lode_estimator_rotor(estimator));
    const lode_open_phase_t phase =
        lode_half_waves_look(waves, &self->tuning->plausibility.waves, ref_A, estimator->emf.i_A,
                             round_s * estimator->pll.omega_rad_s);
    if (phase > 0u) {
        lode_mode_fault(self, LODE_CHECK_OPEN_PHASE, (float)phase, 0.0f);
    }
}

// A start that RUN still proves is an attempt that fails by its lock; while its current fades there is less torque.
static bool is_started(const lode_drive_t *self) {
    const lode_running_t *run = &self->state.run;
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    if (run->proving > 0u) {
        return false;
    }
#endif
    return !(run->fade > 0.0f);
}

// (P25): what a tuning and a hot magnet explain of the magnets' flux, and errors of inductances and resistance, which are
// independent of each other, of the rest.
static float unsure_Wb(const lode_drive_t *self, lode_flux_t flux) {
    const lode_references_tuning_t *motor = &self->tuning->references;
    const lode_emf_tuning_t *emf = &self->tuning->estimator.emf;
    const lode_dq_t i_A = self->i_A;
    const float omega = lode_max(lode_abs(self->estimator.pll.omega_rad_s), FLT_MIN);
    const float L_share = L_UNSURE + motor->Lq_fall * lode_abs(i_A.q);
    const float turned_A = motor->Lq_H * i_A.q * i_A.q / lode_max(flux.expected_Wb, FLT_MIN);
    const float d_Wb = L_share * motor->Ld_H * i_A.d;
    const float q_Wb = L_share * lode_references_salient_H(motor) * turned_A;
    const float r_Wb = R_UNSURE * (emf->inv_b - emf->a_over_b) * i_A.q / omega;
    return ANOTHER_FLUX * self->tuning->estimator.psi_Wb +
           lode_sqrt(d_Wb * d_Wb + q_Wb * q_Wb + r_Wb * r_Wb);
}

// Current control has voltage left: it is not behind for want of it.
static bool has_voltage(const lode_drive_t *self) {
    const lode_dq_t u_V = self->u_V;
    const float most_V = ALL_VOLTAGE * self->tuning->current.circle * self->inverter.v_bus_V;
    return u_V.d * u_V.d + u_V.q * u_V.q < most_V * most_V;
}

// Of three phases. What current control misses stands for the current of the xy plane (K25).
static void note_half_waves(lode_drive_t *self) {
    const lode_open_phase_tuning_t *tuning = &self->tuning->plausibility.waves;
    const lode_estimator_t *estimator = &self->estimator;
    lode_half_waves_t *waves = &self->state.run.waves;
    const float omega = estimator->pll.omega_rad_s;
    if (lode_abs(omega) < self->tuning->start.omega_ready || lode_mode_is_sensored(self) ||
        self->state.run.fade > 0.0f) {
        *waves = (lode_half_waves_t){.idle = 0u}; // what is known of the turn is too little
        return;
    }
    const lode_dq_t ref_A = self->ref_A;
    const lode_dq_t missed_A = {ref_A.d - self->i_A.d, ref_A.q - self->i_A.q};
    if (lode_half_waves_doubt(waves, tuning, ref_A, missed_A) && has_voltage(self)) {
        judge_half_waves(self, waves);
    }
}

// The most that will be there against the load: all that i_max gives. A speed that falls for want of voltage comes to rest
// where there is enough of it; one that rises for want of it does not.
static float most_against_Nm(const lode_drive_t *self) {
    const lode_references_tuning_t *references = &self->tuning->references;
    const lode_running_t *run = &self->state.run;
    const bool brakes = run->speed.torque_Nm * self->estimator.pll.omega_rad_s < 0.0f;
    return brakes ? lode_references_allowed_Nm(&run->references, references, self->ref_A.d)
                  : references->torque_factor * references->tau_max;
}

// The estimate is sure; neither the application nor temperature or bus limits the torque; and its current flows: where the
// voltage is too little for it, so is the speed.
static bool is_all_torque(const lode_drive_t *self) {
    const float iq_A = self->ref_A.q;
    return self->estimator.lock >= LODE_LOCK_HANDOVER &&
           lode_abs(self->state.run.speed.torque_Nm) >= ALL_TORQUE * most_against_Nm(self) &&
           self->i_A.q * iq_A >= FOLLOWED * iq_A * iq_A;
}

// (K19). With torque control the speed is the load's.
static LODE_NOINLINE void judge_load(lode_drive_t *self) {
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_running_t *run = &self->state.run;
    const float omega = self->estimator.pll.omega_rad_s;
    const float way = lode_sign(run->speed.torque_Nm);
    const bool gives_way = way * (run->held_rad_s - omega) > 0.0f; // first: it spares the rest
    // An angle that is wrong makes torque against itself. A sensor's is judged by the EMF (encoder.h), that of injection until
    // there is one.
    const bool by_emf = !lode_mode_is_sensored(self) && !lode_estimator_injects(&self->estimator);
    if (!gives_way || !by_emf || lode_mode_is_torque(self) || !is_started(self) ||
        !is_all_torque(self)) {
        run->held_rad_s = omega;
        return;
    }
    const float reference = run->speed.reference_rad_s;
    const float off = way * (reference - omega * tuning->speed.inv_pole_pairs);
    if (lode_plausibility_is_overloaded(&run->held_rad_s, &tuning->plausibility, way, omega) &&
        off > FAR_OFF * lode_abs(reference)) {
        lode_mode_fault(self, LODE_CHECK_OVERLOAD, omega, reference / tuning->speed.inv_pole_pairs);
    }
}

static void watch_load(lode_drive_t *self) {
    const lode_speed_t *speed = &self->state.run.speed;
    const lode_range_t limit = speed->limit_Nm;
    if (lode_in_range(speed->torque_Nm, ALL_TORQUE * limit.min, ALL_TORQUE * limit.max)) {
        self->state.run.held_rad_s = self->estimator.pll.omega_rad_s; // as nearly always
    } else {
        judge_load(self);
    }
}

// Though the angle is right: that of a sensor, or of a QPLL that a wave holds (P25).
static bool may_speed_lag(const lode_drive_t *self) {
    const bool qpll = self->tuning->estimator.pll.third_order == 0u;
    return lode_mode_is_sensored(self) || (qpll && lode_estimator_injects(&self->estimator));
}

// Though the lock is not lost: where the current makes most of the flux, less of the magnets' takes it little. With hardly any
// current, dead time is as large as what is looked for.
static LODE_NOINLINE void judge_flux(lode_drive_t *self) {
    lode_guard_t *guard = &self->guard;
    const lode_flux_t flux = lode_estimator_flux(&self->estimator, &self->tuning->estimator);
    const lode_dq_t i_A = self->i_A;
    const float i_A2 = i_A.d * i_A.d + i_A.q * i_A.q;
    if (may_speed_lag(self) || !(i_A2 >= FLUX_CURRENT * self->tuning->plausibility.i_min_A2) ||
        !is_started(self) || !is_another_flux(flux, unsure_Wb(self, flux))) {
        guard->flux_rounds = 0u;
        return;
    }
    const uint32_t rounds = guard->flux_rounds + 1u;
    guard->flux_rounds = (uint_least8_t)rounds;
    if (rounds >= FLUX_ROUNDS_MAX || rounds_s(self, rounds) >= FLUX_s) {
        lode_mode_fault(self, LODE_CHECK_FLUX, flux.seen_Wb, flux.expected_Wb);
    }
}

// Not LODE_RAMFUNC: once in a round.
LODE_NOINLINE bool lode_drive_watch_running(lode_drive_t *self) {
    const lode_plausibility_tuning_t *tuning = &self->tuning->plausibility;
    if (tuning->away_rad_s > 0.0f) {
        watch_load(self);
    }
    if (tuning->i_sum >= 0 && (self->estimator.lock < SOUND_LOCK || self->guard.flux_rounds > 0u)) {
        judge_flux(self);
    }
    if (self->gates && tuning->per_wave_A > 0.0f) {
        note_half_waves(self);
    }
    return self->gates;
}

// By how much the damping of a start has turned the vector since the last look. It may turn it back as fast as the
// vector turns on: that rests then, and so do the counts.
LODE_INLINE float damping_rad(lode_drive_t *self) {
    return lode_mode(self) == LODE_MODE_START ? lode_start_shifted_rad(&self->state.start) : 0.0f;
}

// By how much the vector has turned since the last look, `looks` times LODE_GUARD_PERIODS ago. The damping is known
// at the looks at set 1.
LODE_INLINE float turn_of(lode_drive_t *self, const lode_plausibility_t *watch, float looks) {
    if (watch != &self->plausibility && lode_mode(self) == LODE_MODE_START) {
        return 0.0f;
    }
    const uint32_t periods = LODE_GUARD_PERIODS;
    const float look_s = (float)periods * self->tuning->estimator.pll.ts_s;
    return looks * look_s * lode_mode_frame_omega(self) + damping_rad(self);
}

LODE_INLINE void judge(lode_drive_t *self, lode_plausibility_t *watch, uint32_t again, float i_A2,
                       float looks) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const uint32_t doubt =
        lode_plausibility_doubt(watch, &tuning->plausibility, again, i_A2,
                                turn_of(self, watch, looks), lode_abs(tuning->sense.i_gain));
    if (doubt > 0u || watch->sum > 0u ||
        !lode_plausibility_sum_ok(&tuning->plausibility, watch->i)) {
        find(self, watch, doubt);
    }
}

// Not LODE_RAMFUNC: one call in many, and small fast memories are full without it.
LODE_NOINLINE void lode_drive_suspect(lode_drive_t *self, lode_plausibility_t *watch,
                                      const int32_t i[LODE_PHASES], float looks) {
    const uint32_t again = lode_plausibility_look(watch, i);
    const float i_A2 = expected_A2(self, lode_abs(lode_mode_frame_omega(self)));
    if (!lode_plausibility_is_chance(watch, &self->tuning->plausibility, again, i_A2)) {
        judge(self, watch, again, i_A2, looks);
    } else if (watch == &self->plausibility) {
        (void)damping_rad(self); // for the next look
    } else {
        // not known of set 2
    }
}

#endif

LODE_RAMFUNC LODE_NOINLINE bool lode_drive_accept(lode_drive_t *self, uint_least8_t *omitted,
                                                  const lode_abc_t *duty) {
    if (!lode_modulator_is_sound(*duty)) {
        lode_mode_fault(self, LODE_CHECK_NON_FINITE, 1.0f, 0.0f);
        return false;
    }
    const uint_least8_t phase = lode_sense_omitted(&self->tuning->sense, *duty);
    *omitted = lode_sense_omit_later(*omitted, phase);
    return true;
}

// Zero speed and both directions: with a sensor, or with injection.
static bool is_any_speed(const lode_drive_t *self) {
    return lode_mode_is_sensored(self) || self->tuning->omega_min < 0.0f;
}

// Mechanical speeds between which RUN stays, as commanded. Without a sensor: in the present direction, and no
// slower than the least speed; where another is asked for, that one alone.
static lode_range_t allowed_speeds(const lode_drive_t *self) {
    const float speed = self->command.speed_rad_s;
    if (is_any_speed(self)) {
        return (lode_range_t){-lode_abs(speed), lode_abs(speed)};
    }
    const float least = self->tuning->omega_min * self->tuning->speed.inv_pole_pairs;
    const float most = lode_max(speed * self->direction, least);
    return self->direction < 0.0f ? (lode_range_t){-most, -least} : (lode_range_t){least, most};
}

// A current on its way through zero leaves all phases where nobody knows what the dead time does: what would be
// shorter than the bias that keeps them away from there is left out (S20), unless that moves so much of a salient
// rotor's flux at once that an error of Lq - Ld takes the EMF along.
LODE_NOINLINE float lode_drive_faded(const lode_drive_t *self) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const float bias_A = tuning->references.id_bias_A;
    const lode_dq_t i_A = self->ref_A;
    const bool is_short = i_A.d * i_A.d + i_A.q * i_A.q < bias_A * bias_A &&
                          2.0f * bias_A * tuning->start.lost_per_A <= MOVED_FLUX_MAX;
    return is_short ? 0.0f : lode_max(self->state.run.fade - tuning->start.fade_step, 0.0f);
}

LODE_NOINLINE float lode_drive_other_target(lode_drive_t *self, float omega_rad_s, float load_Nm) {
    const lode_range_t speeds = allowed_speeds(self);
    const float wanted = self->command.speed_rad_s;
    const bool stops = !is_any_speed(self) && !(wanted * self->direction > 0.0f);
#ifdef LODE_WITHOUT_TORQUE_CONTROL
    (void)stops;
    (void)omega_rad_s;
    (void)load_Nm;
#else
    if (lode_mode_is_torque(self) && !stops) {
        return lode_speed_torque_target(&self->state.run.speed, &self->tuning->speed,
                                        self->command.value.torque_Nm, speeds, omega_rad_s,
                                        load_Nm);
    }
#endif
    return lode_clamp(wanted, speeds.min, speeds.max);
}

LODE_RAMFUNC LODE_NOINLINE void lode_drive_fast_speed(lode_drive_t *self) {
    const uint32_t mask = self->tuning->speed_periods - 1u;
    if (((self->steps - (uint32_t)SLOT_SPEED) & mask) == 0u) {
        lode_drive_speed(self, self->estimator.pll.omega_rad_s);
    }
    if (((self->steps - (uint32_t)SLOT_REFERENCES) & mask) == 0u) {
        lode_drive_limit_flux(self);
        lode_drive_free_id(self);
        lode_drive_references(self);
    }
}

static LODE_NOINLINE void diagnose(lode_drive_t *self, const lode_counts_t *counts,
                                   uint_least8_t omitted, lode_ab_t i_A) {
    lode_sample_t sample;
    lode_sense_again(&self->sense, counts, omitted, &sample);
    const bool driven = self->gates;
    lode_drive_diagnose(self, &self->sense, &sample);
    if (driven && !self->gates) {
        lode_mode_note_trip(self, i_A);
    }
}

// Counts to amperes and volts, the voltage that really acted over the last period, and the guard's check
// of what must not wait.
LODE_INLINE lode_sample_t sense(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                const lode_counts_t *counts) {
    lode_sample_t sample = lode_sense_next(&self->sense, &tuning->sense, counts, &self->omitted);
    if (!lode_guard_all_ok(&self->guard, &tuning->guard, &sample)) {
        // A copy: for the current of the sample itself the step would keep room for a whole one, 16 bytes of
        // stack more.
        const lode_ab_t i_A = {sample.i_A.alpha, sample.i_A.beta};
        diagnose(self, counts, sample.omitted, i_A);
    }
    const lode_ab_t u_V = lode_inverter_realised(&self->inverter, self->steps);
    sample.u_V = lode_inverter_less_drop(&self->inverter, u_V, self->estimator.emf.i_A);
    lode_guard_note(&self->guard, sample.stamp);
    lode_inverter_follow_bus(&self->inverter, &tuning->inverter, sample.v_bus_V);
    return sample;
}

// Angle and speed at t_k.
LODE_INLINE lode_estimate_t estimate(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                     const lode_sample_t *sample) {
    return lode_estimator_fast(&self->estimator, &tuning->estimator, sample->u_V, sample->i_A);
}

// Duties for the voltage, and what the motor will see of it.
LODE_INLINE lode_abc_t modulate(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                const lode_frame_t *frame, bool free) {
    const lode_asked_t asked = lode_drive_ask(self, tuning, frame);
    const lode_ab_t v =
        lode_ab_scale(self->inverter.per_V, lode_park_inverse(asked.u_V, frame->applied));
    const lode_ab_t i_A = lode_park_inverse(asked.i_A, frame->applied);
    const lode_modulator_out_t out =
        lode_modulator_step(&tuning->inverter, &self->inverter.dead_time, v, i_A, free);
    lode_inverter_write(&self->inverter, self->steps, out.realised);
    self->duty = out.duty;
    return out.duty;
}

static LODE_NOINLINE lode_drive_out_t idle_out(const lode_drive_t *self) {
    return lode_mode_idle_out(self, &self->duty);
}

// The end of a period with the gates off, or the low sides alone.
static LODE_NOINLINE lode_drive_out_t end_idle(lode_drive_t *self) {
    self->steps++;
    return idle_out(self);
}

// A whole one: the voltage at open terminals is not known, so there is nothing to estimate.
LODE_INLINE lode_drive_out_t idle(lode_drive_t *self, const lode_sample_t *sample) {
    lode_calibration_t calibration = LODE_CALIBRATION_RUNNING;
    float worst_count = 0.0f;
    if (lode_mode(self) == LODE_MODE_CALIBRATE) {
        calibration = lode_sense_calibrate(&self->sense, &self->state.sums, &self->tuning->sense,
                                           sample, &worst_count);
    }
    self->temperature = sample->temperature;
    if (self->mail) {
        lode_mode_take_mail(self);
    }
    lode_mode_idle(self, lode_mode_words(self->tuning), sample, calibration, worst_count);
    return end_idle(self);
}

// From angle and speed to duties.
LODE_INLINE lode_drive_out_t act(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                 const lode_sample_t *sample, const lode_estimate_t *estimate) {
    lode_frame_t frame = lode_drive_rotor_frame(self, estimate);
    self->i_A = frame.i_A;
    bool given = false;
    if (!lode_drive_is_steady(self)) {
        if (self->mail) {
            lode_mode_take_mail(self);
            tuning = self->tuning;
        }
        lode_mode_follow(self);
        if (!self->gates) {
            return end_idle(self);
        }
        given = lode_drive_by_mode(self, sample, &frame);
    }
    const float left_V = lode_drive_left_V(self, sample->v_bus_V);
    const bool free = lode_drive_control(self, tuning, &frame, left_V, given);
    const lode_abc_t duty = modulate(self, tuning, &frame, free);
    // Whoever made the duties: the last word.
    if (!lode_modulator_is_within(duty, tuning->sense.duty_max) &&
        !lode_drive_accept(self, &self->omitted, &self->duty)) {
        return end_idle(self);
    }
    const lode_slot_t slot = lode_slot_of(self->steps);
    self->steps++;
    const bool driven = lode_drive_slow_job(self, tuning, lode_mode_words(tuning), sample,
                                            sample->temperature, slot);
    return driven ? (lode_drive_out_t){duty, LODE_GATES_ON} : idle_out(self);
}

lode_sample_t lode_drive_sense(lode_drive_t *self, const lode_counts_t *counts) {
    return sense(self, self->tuning, counts);
}

lode_estimate_t lode_drive_estimate(lode_drive_t *self, const lode_sample_t *sample) {
    return self->gates ? estimate(self, self->tuning, sample) : lode_mode_estimate(self);
}

lode_drive_out_t lode_drive_act(lode_drive_t *self, const lode_sample_t *sample,
                                const lode_estimate_t *estimate) {
    lode_mode_adopt(self, estimate);
    return self->gates ? act(self, self->tuning, sample, estimate) : idle(self, sample);
}

static LODE_NOINLINE lode_drive_out_t idle_period(lode_drive_t *self, const lode_counts_t *counts,
                                                  uint_least8_t omitted) {
    lode_sample_t sample;
    lode_sense_again(&self->sense, counts, omitted, &sample);
    return idle(self, &sample);
}

LODE_RAMFUNC lode_drive_out_t lode_drive_step(lode_drive_t *self, const lode_counts_t *counts) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const lode_sample_t sample = sense(self, tuning, counts); // counts -> A, V at t_k
    if (!lode_drive_is_steady(self) && !self->gates) {
        return idle_period(self, counts, sample.omitted);
    }
    const lode_estimate_t rotor = estimate(self, tuning, &sample); // -> angle and speed at t_k
    return act(self, tuning, &sample, &rotor);                     // -> duties, gates
}
