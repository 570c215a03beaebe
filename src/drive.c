#include "drive_inline.h"
#include "drive_slots_inline.h"

#define TELEMETRY_TRIES 3
#define ROUNDED 1.000001f    // for a limit that the caller has computed in another order
#define HELD_SHARE 0.01f     // of the range of torques
#define MOVED_FLUX_MAX 0.35f // share of the flux that a quick change of the d current may move
#define FADE_QUICK 24.0f     // (S20): twice the default bias in 2 ms

lode_status_t lode_drive_begin(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
    if (self == NULL || tuning == NULL) {
        return LODE_ERROR_NULL;
    }
    if (!lode_tuning_is_finite(tuning)) {
        return LODE_ERROR_TUNING;
    }
    *self = (lode_drive_t){.tuning = tuning, .direction = 1.0f};
#ifndef LODE_WITHOUT_TORQUE_LIMITS
    lode_drive_limit_torque(self, 1.0f);
#endif
    self->command.check = lode_mode_order_check(&self->command);
    lode_tuning_post_check(self, lode_tuning_words(tuning));
    lode_tuning_take_check(self);
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

// Tells the interrupt that something is posted. `mail` first: in the other order, an interrupt in between could set `steady`
// again.
void lode_drive_notify(lode_drive_t *self) {
    LODE_SIGNAL_FENCE();
    LODE_SHARED_STORE(self->mail, true);
    LODE_SIGNAL_FENCE();
    LODE_SHARED_STORE(self->steady, false);
}

LODE_INLINE bool is_within(float x, float most) {
    return lode_in_range(x, -most, most);
}

static bool is_in_range(const lode_command_t *command) {
#ifndef LODE_WITHOUT_COMMISSIONING
    if (!is_within(command->vector.d, LODE_COMMAND_MAX) ||
        !is_within(command->vector.q, LODE_COMMAND_MAX) ||
        !is_within(command->omega_rad_s, LODE_COMMAND_MAX) ||
        !is_within(command->theta_rad, LODE_ANGLE_LIMIT_rad)) {
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

lode_status_t lode_drive_post_command(lode_drive_t *self, const lode_command_t *command) {
    if (self == NULL || command == NULL || self->tuning == NULL) {
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
    const bool off = command->mode == LODE_MODE_OFF;
    if (!known || !controlled || !is_in_range(command) || (command->clear_fault && !off)) {
        return LODE_ERROR_COMMAND;
    }
    const float most_rad_s = ROUNDED * lode_mode_most_rad_s(self->tuning);
    if (command->mode == LODE_MODE_RUN && lode_abs(command->speed_rad_s) > most_rad_s) {
        return LODE_ERROR_COMMAND_SPEED;
    }
    LODE_SHARED_STORE(self->command_posted, LODE_POST_NONE);
    LODE_SIGNAL_FENCE();
    // A command that clears a fault and was not taken yet must not be lost: the new one then clears it too.
    const bool clears = command->clear_fault || lode_mode_clears(&self->posted);
    lode_order_t order = {
        .speed_rad_s = command->speed_rad_s,
        .mode = (uint_least8_t)command->mode,
        .flags = (uint_least8_t)((clears ? (uint32_t)LODE_ORDER_CLEAR_FAULT : 0u) |
                                 (torque ? (uint32_t)LODE_ORDER_TORQUE : 0u) |
                                 (wants_short(command) ? (uint32_t)LODE_ORDER_SHORT : 0u)),
    };
#ifdef LODE_WITHOUT_COMMISSIONING
    order.value.torque_Nm = command->torque_Nm;
#else
    // Write all of the union `value`: the check reads its bits.
    order.value.vector = (lode_dq_t){command->torque_Nm, 0.0f};
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
    lode_drive_notify(self);
    return LODE_OK;
}

lode_status_t lode_drive_post_tuning(lode_drive_t *self, const lode_drive_tuning_t *tuning) {
    if (self == NULL || tuning == NULL) {
        return LODE_ERROR_NULL;
    }
    if (!lode_tuning_is_finite(tuning)) {
        return LODE_ERROR_TUNING;
    }
    // A tuning not yet taken is withdrawn first: it would be taken with the check of this one.
    LODE_SHARED_STORE(self->posted_tuning, NULL);
    LODE_SIGNAL_FENCE();
    lode_tuning_post_check(self, lode_tuning_words(tuning));
    LODE_SIGNAL_FENCE();
    LODE_SHARED_STORE(self->posted_tuning, tuning);
    lode_drive_notify(self);
    return LODE_OK;
}

#ifndef LODE_WITHOUT_TORQUE_LIMITS

static uint_least16_t torque_share(float share) {
    const float steps = 0.5f * (float)LODE_TORQUE_SHARE_ONE * lode_clamp(share, 0.0f, 1.0f) + 0.5f;
    const uint32_t even = 2u * (uint32_t)(int32_t)steps;
    return (uint_least16_t)(even | (lode_mode_share_is_sound(even) ? 0u : 1u));
}

void lode_drive_limit_torque(lode_drive_t *self, float share) {
    lode_drive_limit_torques(self, share, share);
}

void lode_drive_limit_torques(lode_drive_t *self, float motoring, float braking) {
    self->torque_share[0] = torque_share(motoring); // read once per round, in one access
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

// RUN holds its lowest speed because the command is below it. Not for a stop, which passes through that speed.
static bool is_raised(const lode_drive_t *self) {
    const float commanded = lode_abs(self->command.speed_rad_s);
    return !lode_mode_is_sensored(self) && !lode_mode_is_torque(self) && commanded > 0.0f &&
           commanded < self->tuning->omega_min * self->tuning->speed.inv_pole_pairs;
}

// Torque control holds a speed. Its torque is the commanded one otherwise.
static bool is_held(const lode_drive_t *self, const lode_speed_t *speed) {
#ifdef LODE_WITHOUT_TORQUE_CONTROL
    (void)self;
    (void)speed;
    return false;
#else
    const lode_range_t limit_Nm = speed->limit_Nm;
    const float wanted_Nm = lode_clamp(self->command.value.torque_Nm, limit_Nm.min, limit_Nm.max);
    const float least_Nm = HELD_SHARE * (limit_Nm.max - limit_Nm.min);
    return lode_mode_is_torque(self) && lode_abs(wanted_Nm - speed->torque_Nm) > least_Nm;
#endif
}

uint32_t lode_drive_limited(const lode_drive_t *self) {
    if (lode_mode(self) != LODE_MODE_RUN) {
        return 0u;
    }
    const lode_speed_t *speed = &self->state.run.speed;
    return (is_limited(speed) ? (uint32_t)LODE_LIMITED_TORQUE : 0u) |
           (is_raised(self) ? (uint32_t)LODE_LIMITED_RAISED : 0u) |
           (is_held(self, speed) ? (uint32_t)LODE_LIMITED_HELD : 0u) |
           (speed->calmed != 0u ? (uint32_t)LODE_LIMITED_GAINS : 0u);
}

// Position error by EMF and by injection, and the weight of injection in the PLL.
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
    if (self->tuning == NULL) {
        return false; // the drive has not begun
    }
    for (int32_t i = 0; i < TELEMETRY_TRIES; i++) {
        const uint32_t steps = LODE_SHARED_LOAD(self->steps);
        LODE_SIGNAL_FENCE();
        const lode_pll_t *pll = &self->estimator.pll;
        const uint32_t limited = lode_drive_limited(self);
        const lode_speed_t *speed =
            lode_mode(self) == LODE_MODE_RUN ? &self->state.run.speed : NULL;
        *telemetry = (lode_telemetry_t){
            .steps = steps,
            .mode = lode_mode(self),
            .start_stage = lode_drive_start_stage(self),
            .fault = self->guard.fault,
            .torque_limited = (limited & (uint32_t)LODE_LIMITED_TORQUE) != 0u,
            .speed_raised = (limited & (uint32_t)LODE_LIMITED_RAISED) != 0u,
            .speed_held = (limited & (uint32_t)LODE_LIMITED_HELD) != 0u,
            .gains_halved = (limited & (uint32_t)LODE_LIMITED_GAINS) != 0u,
            .retries = lode_drive_retries(self),
            .trips = self->guard.trips,
            .signals_checked = lode_drive_knows(self, LODE_KNOWN_SIGNALS),
            .shorted = lode_mode(self) == LODE_MODE_FAULT && lode_mode_shorts(self),
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

#ifndef LODE_WITHOUT_OPTIMAL_REFERENCES

// The EMF has a part in the angle: injection alone uses the inductances themselves.
static bool goes_by_emf(const lode_estimator_t *estimator) {
#ifdef LODE_WITHOUT_HFI
    (void)estimator;
    return true;
#else
    return !estimator->by.hfi.active || estimator->by.hfi.weight < 1.0f;
#endif
}

// Gain and inductance of the q axis for the present current and its reference (K20), (K21).
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
    run->speed.limit_Nm = lode_mode_torque_limits(self, out.torque_Nm);
    if (lode_references_has(tuning, LODE_REFERENCES_SATURATE)) {
        saturate_control(self); // before current control meets the new reference
    }
}

// Flux that the saturated q axis lacks, in stator axes; `at`: rotor angle.
static lode_ab_t lacking_Wb(const lode_references_tuning_t *tuning, lode_ab_t i_A,
                            lode_sincos_t at) {
    const float flux_Wb = lode_references_lacking_Wb(tuning, lode_park(i_A, at).q);
    return (lode_ab_t){-flux_Wb * at.sin, flux_Wb * at.cos};
}

// Applies (E31) as a shift of the observer's last current, which enters (E3) with the factor a/b. So the step needs no
// additional argument.
// Not LODE_RAMFUNC: small fast memories have no room for it.
LODE_NOINLINE void lode_drive_lessen_saturated(lode_drive_t *self, lode_ab_t i_A) {
    const lode_references_tuning_t *motor = &self->tuning->references;
    const lode_estimator_tuning_t *tuning = &self->tuning->estimator;
    lode_estimator_t *estimator = &self->estimator;
    if (!estimator->aligned || !goes_by_emf(estimator)) {
        return;
    }
    const float angle_rad = lode_pll_predict(&estimator->pll, &tuning->pll).angle_rad;
    const lode_sincos_t step = lode_angle_double(lode_sincos_small(0.5f * angle_rad));
    const lode_sincos_t before = lode_estimator_rotor(estimator);
    const lode_ab_t rise_Wb = lode_ab_subtract(lacking_Wb(motor, i_A, lode_angle_add(before, step)),
                                               lacking_Wb(motor, estimator->emf.i_A, before));
    const float per_Wb_A = tuning->pll.inv_ts / tuning->emf.a_over_b;
    estimator->emf.i_A = lode_ab_add_scaled(estimator->emf.i_A, per_Wb_A, rise_Wb);
}

LODE_NOINLINE void lode_drive_adapt_saturated_lag(lode_drive_t *self) {
    const lode_drive_tuning_t *tuning = self->tuning;
    lode_estimator_t *estimator = &self->estimator;
    const lode_dq_t i_A = lode_park(estimator->emf.i_A, lode_estimator_rotor(estimator));
    lode_estimator_adapt_lag(estimator, &tuning->estimator);
    if (goes_by_emf(estimator) && !estimator->aligned) {
        estimator->lag.at = lode_references_saturated(&tuning->references, estimator->lag.at, i_A);
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

// Zero speed and reversal are allowed: with a sensor, or with injection.
static bool is_any_speed(const lode_drive_t *self) {
    return lode_mode_is_sensored(self) || self->tuning->omega_min < 0.0f;
}

// Mechanical speeds that the command allows in RUN. Without a sensor only the present direction, from the lowest speed on; a
// command for the other direction leaves only the lowest speed.
static lode_range_t allowed_speeds(const lode_drive_t *self) {
    const float speed = self->command.speed_rad_s;
    if (is_any_speed(self)) {
        return (lode_range_t){-lode_abs(speed), lode_abs(speed)};
    }
    const float least = self->tuning->omega_min * self->tuning->speed.inv_pole_pairs;
    const float most = lode_max(speed * self->direction, least);
    return self->direction < 0.0f ? (lode_range_t){-most, -least} : (lode_range_t){least, most};
}

// Next value of the start current's fade. While the current passes through zero, the dead time's effect on all phases is
// unknown. So the fade is quick where the current is shorter than the bias (S20), except in a very salient rotor: there the
// change moves so much flux that an error of Lq - Ld disturbs the EMF.
LODE_NOINLINE float lode_drive_faded(const lode_drive_t *self) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const float bias_A = tuning->references.id_bias_A;
    const lode_dq_t i_A = self->ref_A;
    const bool is_short = i_A.d * i_A.d + i_A.q * i_A.q < bias_A * bias_A &&
                          2.0f * bias_A * tuning->start.lost_per_A <= MOVED_FLUX_MAX;
    const float step = (is_short ? FADE_QUICK : 1.0f) * tuning->start.fade_step;
    return lode_max(self->state.run.fade - step, 0.0f);
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
    lode_drive_diagnose(self, &self->sense, &sample, &self->shorted);
    if (driven && !self->gates) {
        lode_mode_note_trip(self, i_A);
    }
}

// Converts counts to amperes and volts, adds the voltage that acted over the last period, and makes the guard's fast checks.
LODE_INLINE lode_sample_t sense(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                const lode_counts_t *counts) {
    lode_sample_t sample = lode_sense_next(&self->sense, &tuning->sense, counts, &self->omitted);
    if (!lode_guard_all_ok(&self->guard, &tuning->guard, &sample)) {
        // A copy: to pass the current in the sample itself, the step would keep a whole sample, 16 bytes more stack.
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
    return lode_drive_find(self, tuning, sample->u_V, sample->i_A);
}

// Duties for the requested voltage, and the voltage that the motor will see.
LODE_INLINE lode_abc_t modulate(lode_drive_t *self, const lode_drive_tuning_t *tuning,
                                const lode_frame_t *frame, bool free) {
    const lode_demand_t demand = lode_drive_demand(self, tuning, frame);
    const lode_ab_t v =
        lode_ab_scale(self->inverter.per_V, lode_park_inverse(demand.u_V, frame->applied));
    const lode_ab_t i_A = lode_park_inverse(demand.i_A, frame->applied);
    const lode_modulator_out_t out =
        lode_modulator_step(&tuning->inverter, &self->inverter.dead_time, v, i_A, free);
    lode_inverter_write(&self->inverter, self->steps, out.realised);
    self->duty = out.duty;
    return out.duty;
}

static LODE_NOINLINE lode_drive_out_t idle_out(const lode_drive_t *self) {
    return lode_mode_idle_out(self, &self->duty);
}

// End of a period with all gates off, or with only the low sides on.
static LODE_NOINLINE lode_drive_out_t end_idle(lode_drive_t *self) {
    self->steps++;
    return idle_out(self);
}

// A whole period with the gates off. The voltage at open terminals is unknown, so nothing is estimated.
LODE_INLINE lode_drive_out_t idle(lode_drive_t *self, const lode_sample_t *sample) {
    lode_calibration_t calibration = LODE_CALIBRATION_RUNNING;
    float worst_count = 0.0f;
    if (lode_mode(self) == LODE_MODE_CALIBRATE) {
        calibration = lode_sense_calibrate(&self->sense, &self->state.sums, &self->tuning->sense,
                                           sample, &worst_count);
    }
    self->temperature = sample->temperature;
    if (self->mail && !self->guard.fresh) { // a fault is told for a period at least
        (void)lode_mode_take_mail(self);
    }
    if (self->guard.fresh) {
        self->shorted = (lode_shorted_t){.periods = 0u};
        self->guard.fresh = false;
    }
    lode_mode_idle(self, lode_tuning_words(self->tuning), sample, calibration, worst_count);
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
            (void)lode_mode_take_mail(self);
            tuning = self->tuning;
        }
        lode_mode_follow(self);
        if (!self->gates || !lode_drive_jump_ok(self)) {
            return end_idle(self);
        }
        given = lode_drive_by_mode(self, sample, &frame);
    }
    const float left_V = lode_drive_left_V(self, sample->v_bus_V);
    const bool free = lode_drive_control(self, tuning, &frame, left_V, given);
    const lode_abc_t duty = modulate(self, tuning, &frame, free);
    // Last check of the duties, whichever mode made them.
    if (!lode_modulator_is_within(duty, tuning->sense.duty_max) &&
        !lode_drive_accept(self, &self->omitted, &self->duty)) {
        return end_idle(self);
    }
    const lode_slot_t slot = lode_slot_of(self->steps);
    self->steps++;
    const bool driven = lode_drive_slow_job(self, tuning, lode_tuning_words(tuning), sample,
                                            sample->temperature, true, slot);
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
                                                  uint_least8_t omitted, lode_ab_t i_A) {
    lode_sample_t sample;
    lode_sense_again(&self->sense, counts, omitted, &sample);
    sample.i_A = i_A; // for the pulses that look for a turning rotor
    return idle(self, &sample);
}

LODE_RAMFUNC lode_drive_out_t lode_drive_step(lode_drive_t *self, const lode_counts_t *counts) {
    const lode_drive_tuning_t *tuning = self->tuning;
    const lode_sample_t sample = sense(self, tuning, counts); // counts -> A, V at t_k
    if (!lode_drive_is_steady(self) && !self->gates) {
        return idle_period(self, counts, sample.omitted, sample.i_A);
    }
    const lode_estimate_t rotor = estimate(self, tuning, &sample); // -> angle and speed at t_k
    return act(self, tuning, &sample, &rotor);                     // -> duties, gates
}
