#include "bringup.h"

// Times, s.
#define PWM_TIME 0.5f  // long enough for a scope's trigger and for a mean over thousands of periods
#define RISE_TIME 0.5f // of the test voltage from zero to its end
#define FIRST_TIME 0.02f  // s
#define SETTLE_TIME 0.3f  // for the rotor to swing out
#define AVERAGE_TIME 0.2f // of telemetry
#define HOLD_TIME 0.5f    // time that the lock must hold after a start
#define RUN_TIME 2.0f
#define RUN_TIMEOUT 30.0f
#define MARGIN_TIME 1.0f // added to the drive's own time-outs

#define WINDOW_PERIODS 1024u // at gates off, for offsets
#define SIGN_PERIODS 64u

// Criteria.
#define PERIOD_TOLERANCE 0.01f  // a wrong divider has a far larger error
#define JITTER_SHARE 0.05f      // a masked or delayed interrupt
#define WORK_SHARE 0.8f         // the rest is for the thread
#define NOISE_SHARE 0.02f       // of full scale
#define TEST_CURRENT_SHARE 0.2f // of i_max: above the noise, far from the trip
#define VOLTAGE_MARGIN 2.0f     // times R i: the limit for the resistance
#define LOSS_MARGIN 2.0f        // times dead time and drops
#define BALANCE_PERIODS 16u     // against noise
#define BALANCE_SHARE 0.5f      // of the test current: largest sum of the three currents
// Rise time of current control: three periods from the first voltage to a sample that shows it, the rest for
// the rise.
#define CONTROL_PERIODS 20u
#define FIRST_SHARE 0.3f // of the final controlled current
#define SEEN_SHARE 0.5f  // of the test current; below it there is no current
#define IN_PHASE 0.75f   // share of the largest current: +-1 is right, +-0.5 another phase
#define NOTHING 0.25f
#define RETURN_TOLERANCE 0.2f // of the half that should return in each other phase
#define LATENCY_MAX 0.25f     // calls: one leg of three that is one period off gives half a call
#define LATENCY_SIGMAS 2.0f   // of the noise
#define FALL_SHARE 0.5f       // of the step of a duty
#define LEAST_TICKS 4.0f      // of the timer, in a step
#define TAUS 12.0f // until a current is constant: six time constants of a winding twice as slow
#define ACROSS_SHARE 0.3f
#define RESISTANCE_FACTOR 2.0f
#define CURRENT_SHARE 0.3f
#define CURRENT_TOLERANCE 0.05f
#define RIPPLE_SHARE 0.3f
#define START_SHARE 1.5f // speed commanded for the start, of the hand-over speed
#define SPEED_TOLERANCE 0.02f

#define PHASE_ANGLE_rad 2.0943951f // 2 pi/3

#define NAME(x)                                                                                    \
    case BRINGUP_##x:                                                                              \
        return #x

const char *bringup_state_name(uint_least8_t state) {
    switch (state) {
        NAME(RUNNING);
        NAME(PASS);
    default:
        return "FAIL";
    }
}

const char *bringup_reason_name(uint_least8_t reason) {
    switch (reason) {
        NAME(OK);
        NAME(NO_TIME_BASE);
        NAME(PERIOD);
        NAME(JITTER);
        NAME(TOO_SLOW);
        NAME(TRIP);
        NAME(OFFSET);
        NAME(NOISE);
        NAME(BUS);
        NAME(NO_CURRENT);
        NAME(NO_SIGNAL);
        NAME(SIGN);
        NAME(ORDER);
        NAME(RATIO);
        NAME(LATENCY);
        NAME(BALANCE);
        NAME(ANGLE);
        NAME(RESISTANCE);
        NAME(CURRENT_OFF);
        NAME(RIPPLE);
        NAME(LOCK);
        NAME(SPEED);
        NAME(TIMEOUT);
        NAME(UNSURE);
        NAME(UNSETTLED);
        NAME(NO_START);
        NAME(REFUSED);
        NAME(FAULT);
    default:
        return "UNKNOWN";
    }
}

void bringup_window_ask(volatile bringup_window_t *self, uint32_t periods) {
    self->wanted = 0u; // from here on the interrupt does not write it
    self->taken = 0u;
    self->trips = 0u;
    for (uint32_t x = 0; x < 3u; x++) {
        self->sum_count[x] = 0u;
        self->min_count[x] = 65535u;
        self->max_count[x] = 0u;
    }
    self->wanted = periods;
}

// Runs from flash: outside bring-up it returns at once, and the fast memory is reserved for the step.
void bringup_window_take(volatile bringup_window_t *self, const lode_counts_t *counts,
                         lode_abc_t duty) {
    edge_take(&self->edge, counts, duty);
    if (self->taken >= self->wanted) {
        return;
    }
    for (uint32_t x = 0; x < 3u; x++) {
        const uint16_t count = counts->i[x];
        self->sum_count[x] += count;
        self->min_count[x] = count < self->min_count[x] ? count : self->min_count[x];
        self->max_count[x] = count > self->max_count[x] ? count : self->max_count[x];
    }
    self->trips += counts->trip ? 1u : 0u;
    self->taken++;
}

static bool window_done(const bringup_t *self) {
    return self->window->wanted > 0u && self->window->taken >= self->window->wanted;
}

static float window_mean(const bringup_t *self, uint32_t x) {
    return (float)self->window->sum_count[x] / (float)self->window->taken;
}

static void post(const bringup_t *self, lode_command_t command) {
    (void)lode_drive_post_command(self->drive, &command);
}

static void post_off(const bringup_t *self) {
    post(self, (lode_command_t){.mode = LODE_MODE_OFF, .clear_fault = true});
}

static void next_stage(bringup_t *self, const bringup_view_t *view) {
    self->stage++;
    self->since = view->now.steps;
}

static float elapsed_s(const bringup_t *self, const bringup_view_t *view) {
    return (float)(view->now.steps - self->since) / self->config->f_pwm_Hz;
}

static void finish(bringup_t *self, bringup_reason_t reason, uint32_t phase, float measured,
                   float limit) {
    self->result.state = (uint_least8_t)(reason == BRINGUP_OK ? BRINGUP_PASS : BRINGUP_FAIL);
    self->result.reason = (uint_least8_t)reason;
    self->result.phase = (uint_least8_t)phase;
    self->result.measured = measured;
    self->result.limit = limit;
    if (reason != BRINGUP_OK || self->result.mode != (uint_least8_t)BRINGUP_RUN) {
        post(self, (lode_command_t){.mode = LODE_MODE_OFF});
    }
}

void bringup_begin(bringup_t *self, bringup_mode_t mode) {
    self->result = (bringup_result_t){.mode = (uint_least8_t)mode};
    self->stage = 0u;
    self->u_V = 0.0f;
    self->count = 0.0f;
    self->window->wanted = 0u;
    self->window->edge.wanted = 0u;
    post_off(self);
}

// --- 1: clock and PWM ---

static void step_pwm(bringup_t *self, const bringup_view_t *view) {
    const bringup_cycles_t *cycles = &view->cycles;
    const float expected = self->config->guard.stamp_per_period;
    if (self->stage == 0u) {
        bringup_window_ask(self->window, WINDOW_PERIODS);
        next_stage(self, view);
        return;
    }
    if (elapsed_s(self, view) < PWM_TIME || !window_done(self) || cycles->periods < 2u) {
        return;
    }
    // The counter wraps within seconds, so the difference of the stamps is valid over this half second.
    const float mean = (float)(cycles->last - cycles->first) / (float)(cycles->periods - 1u);
    const float jitter = (float)(cycles->interval_max - cycles->interval_min);
    const float work = (float)cycles->work_max / (float)cycles->interval_min;
    if (!(expected > 0.0f)) {
        finish(self, BRINGUP_NO_TIME_BASE, 0u, mean, expected);
    } else if (!(lode_abs(mean - expected) <= PERIOD_TOLERANCE * expected)) {
        finish(self, BRINGUP_PERIOD, 0u, mean, expected);
    } else if (!(jitter <= JITTER_SHARE * expected)) {
        finish(self, BRINGUP_JITTER, 0u, jitter, JITTER_SHARE * expected);
    } else if (!(work <= WORK_SHARE)) {
        finish(self, BRINGUP_TOO_SLOW, 0u, work, WORK_SHARE);
    } else if (self->window->trips > 0u) {
        finish(self, BRINGUP_TRIP, 0u, (float)self->window->trips, 0.0f);
    } else {
        finish(self, BRINGUP_OK, 0u, mean, expected);
    }
}

// --- 2: offsets ---

static void judge_offsets(bringup_t *self, const bringup_view_t *view) {
    const lode_sense_config_t *sense = &self->config->sense;
    const lode_guard_config_t *guard = &self->config->guard;
    const uint32_t phases = sense->shunts == LODE_SHUNTS_TWO ? 2u : 3u;
    float worst = 0.0f;
    uint32_t where = 0u;
    for (uint32_t x = 0; x < phases; x++) {
        const float off = window_mean(self, x) - sense->i_offset_count;
        const float noise = (float)(self->window->max_count[x] - self->window->min_count[x]);
        if (!(noise <= NOISE_SHARE * sense->count_max)) {
            finish(self, BRINGUP_NOISE, x, noise, NOISE_SHARE * sense->count_max);
            return;
        }
        if (lode_abs(off) >= lode_abs(worst)) {
            worst = off;
            where = x;
        }
    }
    const float v = view->now.v_bus_V;
    if (!(lode_abs(worst) <= sense->i_offset_tol_count)) {
        finish(self, BRINGUP_OFFSET, where, worst, sense->i_offset_tol_count);
    } else if (!(v >= guard->v_bus_min_V && v <= guard->v_bus_max_V)) {
        finish(self, BRINGUP_BUS, 0u, v,
               v > guard->v_bus_max_V ? guard->v_bus_max_V : guard->v_bus_min_V);
    } else {
        finish(self, BRINGUP_OK, where, worst, sense->i_offset_tol_count);
    }
}

// Gates off, counts at zero current, then the drive's own calibration. True when complete.
static bool calibrated(bringup_t *self, const bringup_view_t *view) {
    const bool off = view->now.mode == LODE_MODE_OFF;
    if (self->stage == 0u && off) {
        bringup_window_ask(self->window, WINDOW_PERIODS);
        next_stage(self, view);
    } else if (self->stage == 1u && window_done(self)) {
        for (uint32_t x = 0; x < 3u; x++) {
            self->offset_count[x] = window_mean(self, x);
        }
        post(self, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
        next_stage(self, view);
    } else if (self->stage == 2u && off &&
               elapsed_s(self, view) > self->config->sense.calibrate_s) {
        next_stage(self, view);
    }
    return self->stage >= 3u;
}

// --- 3 and 4: voltage ---

static lode_command_t voltage_at(float angle_rad, float turn_rad_s) {
    return (lode_command_t){
        .mode = LODE_MODE_VOLTAGE, .theta_rad = angle_rad, .omega_rad_s = turn_rad_s};
}

static float length_of(lode_dq_t x) {
    return lode_ab_length((lode_ab_t){x.d, x.q});
}

static float test_current_A(const bringup_t *self) {
    return TEST_CURRENT_SHARE * self->config->inverter.i_max_A;
}

// Resistance of winding and switches together, because the current flows through both.
static float resistance_of(const lode_drive_config_t *config) {
    return config->motor.Rs_Ohm + config->inverter.r_on_Ohm;
}

// The largest voltage that `i_A` can need. If the currents are not measured correctly it is the only limit.
static float voltage_for(const lode_drive_config_t *config, float i_A) {
    const lode_inverter_config_t *inverter = &config->inverter;
    return VOLTAGE_MARGIN * resistance_of(config) * i_A +
           LOSS_MARGIN *
               (inverter->v_drop_V + inverter->v_bus_V * inverter->dead_time_s *
                                         lode_inverter_carrier_Hz(inverter, config->f_pwm_Hz));
}

// Checks the raw counts while the voltage rises: the currents must add up to zero. False: an amplifier is dead
// or wrong, and the length of the vector is not that of the current. With two shunts the sum is always zero.
static bool balanced(bringup_t *self) {
    const lode_sense_config_t *sense = &self->config->sense;
    if (sense->shunts == LODE_SHUNTS_TWO) {
        return true;
    }
    if (self->window->wanted != BALANCE_PERIODS) {
        bringup_window_ask(self->window, BALANCE_PERIODS);
        self->sum_A = 0.0f;
    } else if (window_done(self)) {
        float sum_count = 0.0f;
        for (uint32_t x = 0; x < 3u; x++) {
            sum_count += window_mean(self, x) - self->offset_count[x];
        }
        self->sum_A = lode_abs(sense->i_gain_A_count * sum_count);
        bringup_window_ask(self->window, BALANCE_PERIODS);
    }
    return self->sum_A < BALANCE_SHARE * test_current_A(self);
}

// Raises the voltage until a current shows. The current responds within L/R, much faster than the evaluation.
static bool raise_voltage(bringup_t *self, const bringup_view_t *view, lode_command_t at,
                          float wanted_A) {
    const float seen_A = length_of(view->now.i_A);
    if (seen_A >= wanted_A || !balanced(self)) { // the evaluation reports the error
        return true;
    }
    const float share = elapsed_s(self, view) / RISE_TIME;
    if (share > 1.0f) {
        if (seen_A >= SEEN_SHARE * wanted_A) {
            return true;
        }
        finish(self, BRINGUP_NO_CURRENT, 0u, seen_A, SEEN_SHARE * wanted_A);
        return false;
    }
    self->u_V = share * voltage_for(self->config, wanted_A);
    at.vector.d = self->u_V;
    post(self, at);
    return false;
}

// One phase is driven, and the other two each return half of its current.
static bool judge_phase(bringup_t *self, uint32_t driven) {
    const lode_sense_config_t *sense = &self->config->sense;
    float i[3];
    for (uint32_t x = 0; x < 3u; x++) {
        i[x] = sense->i_gain_A_count * (window_mean(self, x) - self->offset_count[x]);
    }
    if (sense->shunts == LODE_SHUNTS_TWO) {
        i[2] = -(i[0] + i[1]);
    }
    const float largest = lode_max(lode_max(lode_abs(i[0]), lode_abs(i[1])), lode_abs(i[2]));
    const float share = i[driven] / lode_max(largest, 1.0e-6f);
    if (share < -IN_PHASE) {
        finish(self, BRINGUP_SIGN, driven, share, IN_PHASE);
        return false;
    }
    if (!(lode_abs(share) >= NOTHING)) {
        finish(self, BRINGUP_NO_SIGNAL, driven, share, NOTHING);
        return false;
    }
    if (!(share >= IN_PHASE)) {
        finish(self, BRINGUP_ORDER, driven, share, IN_PHASE);
        return false;
    }
    for (uint32_t x = 0; x < 3u; x++) {
        const float back = -i[x] / i[driven];
        if (x != driven && !(lode_abs(back - 0.5f) <= RETURN_TOLERANCE)) {
            finish(self, back < 0.0f ? BRINGUP_SIGN : BRINGUP_RATIO, x, back, 0.5f);
            return false;
        }
    }
    self->result.measured = share;
    return true;
}

static float tau_s(const bringup_t *self) {
    const lode_motor_t *motor = &self->config->motor;
    return 0.5f * (motor->Ld_H + motor->Lq_H) / resistance_of(self->config);
}

// The interrupt follows the steps in which the voltage returns to zero. False: the steps are too small for the
// resolution of the timer.
static bool begin_edges(bringup_t *self, const bringup_view_t *view, uint32_t phase) {
    const bool unseen = phase == 2u && self->config->sense.shunts == LODE_SHUNTS_TWO;
    // Min-max centring: the driven leg leaves one half by three quarters of its voltage.
    const float step = 0.75f * self->u_V / lode_max(view->now.v_bus_V, 1.0f);
    const float ticks = self->config->inverter.pwm_ticks;
    if (ticks > 0.0f && step * ticks < LEAST_TICKS) {
        return false;
    }
    edge_begin(&self->window->edge, phase, unseen ? 0u : phase, FALL_SHARE * step);
    return true;
}

static void end_edges(bringup_t *self, const bringup_view_t *view, uint32_t stages) {
    post(self, (lode_command_t){.mode = LODE_MODE_OFF});
    self->stage += stages; // skipped stages
    next_stage(self, view);
}

// A winding with too small a response is not judged.
static bool judge_edges(bringup_t *self, uint32_t phase) {
    const volatile edge_t *edge = &self->window->edge;
    const edge_time_t time =
        edge_time(edge, self->offset_count[edge->from], tau_s(self) * self->config->f_pwm_Hz);
    const float late = time.at - EDGE_EXPECTED;
    const float limit = LATENCY_MAX + LATENCY_SIGMAS * time.sigma;
    if (time.known && !(lode_abs(late) <= limit)) {
        finish(self, BRINGUP_LATENCY, phase, late, limit);
        return false;
    }
    return true;
}

// After a step: the voltage returns for the next step, or the steps are judged.
static void follow_edges(bringup_t *self, const bringup_view_t *view, uint32_t phase) {
    if (!edge_done(&self->window->edge)) {
        if (elapsed_s(self, view) > SETTLE_TIME) {
            finish(self, BRINGUP_TIMEOUT, phase, elapsed_s(self, view), SETTLE_TIME);
        }
        return;
    }
    if (self->window->edge.edges < EDGE_COUNT) {
        lode_command_t at = voltage_at((float)phase * PHASE_ANGLE_rad, 0.0f);
        at.vector.d = self->u_V;
        post(self, at);
        next_stage(self, view);
    } else if (judge_edges(self, phase)) {
        end_edges(self, view, 1u);
    }
}

// A current that needs no voltage: the duty of a leg does not follow its command and drives the current itself.
static bool voltage_plausible(bringup_t *self, const bringup_view_t *view, uint32_t phase) {
    const float R_Ohm = self->u_V / lode_max(length_of(view->now.i_A), 1.0e-6f);
    const float least = resistance_of(self->config) / RESISTANCE_FACTOR;
    if (!(R_Ohm >= least)) {
        finish(self, BRINGUP_RESISTANCE, phase, R_Ohm, least);
        return false;
    }
    return true;
}

// Seven stages for each of the three phases, after the three of the calibration.
static void step_signs(bringup_t *self, const bringup_view_t *view) {
    if (!calibrated(self, view)) {
        return;
    }
    const uint32_t phase = (self->stage - 3u) / 7u;
    const float angle = (float)phase * PHASE_ANGLE_rad;
    switch ((self->stage - 3u) % 7u) {
    case 0u:
        if (raise_voltage(self, view, voltage_at(angle, 0.0f), test_current_A(self))) {
            next_stage(self, view);
        }
        break;
    case 1u:
        if (elapsed_s(self, view) > SETTLE_TIME) {
            bringup_window_ask(self->window, SIGN_PERIODS);
            next_stage(self, view);
        }
        break;
    case 2u:
        if (window_done(self) && judge_phase(self, phase) && voltage_plausible(self, view, phase)) {
            if (begin_edges(self, view, phase)) {
                next_stage(self, view);
            } else {
                end_edges(self, view, 3u);
            }
        }
        break;
    case 3u:
        if (edge_ready(&self->window->edge)) {
            post(self, voltage_at(angle, 0.0f));
            next_stage(self, view);
        }
        break;
    case 4u:
        follow_edges(self, view, phase);
        break;
    case 5u:
        if (elapsed_s(self, view) > lode_clamp(TAUS * tau_s(self), FIRST_TIME, SETTLE_TIME)) {
            edge_ask(&self->window->edge);
            self->stage -= 3u;
            next_stage(self, view);
        }
        break;
    default: // the current must decay before the next phase
        if (phase == 2u) {
            finish(self, BRINGUP_OK, 0u, self->result.measured, IN_PHASE);
        } else if (elapsed_s(self, view) > SETTLE_TIME) {
            self->u_V = 0.0f;
            next_stage(self, view);
        }
        break;
    }
}

// Uses the telemetry of each period once, over AVERAGE_TIME. True when the mean is complete.
static bool averaged(bringup_t *self, const bringup_view_t *view, float reference_d) {
    const lode_dq_t i = view->now.i_A;
    const float error = length_of((lode_dq_t){i.d - reference_d, i.q});
    if (!(self->count > 0.0f)) {
        self->sum_d = 0.0f;
        self->sum_q = 0.0f;
        self->sum_error = 0.0f;
        self->least = i.d;
        self->greatest = i.d;
        self->settled = view->now.steps;
    }
    if (!(self->count > 0.0f) || view->now.steps != self->seen) {
        self->seen = view->now.steps;
        self->sum_d += i.d;
        self->sum_q += i.q;
        self->sum_error += error;
        self->least = lode_min(self->least, i.d);
        self->greatest = lode_max(self->greatest, i.d);
        self->count += 1.0f;
    }
    return (float)(view->now.steps - self->settled) >= AVERAGE_TIME * self->config->f_pwm_Hz;
}

static bool resistance_plausible(bringup_t *self, float R_Ohm) {
    const float configured = resistance_of(self->config);
    if (!(R_Ohm <= RESISTANCE_FACTOR * configured && R_Ohm * RESISTANCE_FACTOR >= configured)) {
        finish(self, BRINGUP_RESISTANCE, 0u, R_Ohm, configured);
        return false;
    }
    return true;
}

static bool still_balanced(bringup_t *self) {
    if (!balanced(self)) {
        finish(self, BRINGUP_BALANCE, 0u, self->sum_A, BALANCE_SHARE * test_current_A(self));
        return false;
    }
    return true;
}

// The second of two points: the loss to dead time and drops is the same at both, and cancels.
static void judge_voltage(bringup_t *self) {
    const float d = self->sum_d / self->count;
    const float across = self->sum_q / self->count / lode_max(lode_abs(d), 1.0e-6f);
    const float R_Ohm = (self->u_V - self->first_u_V) / lode_max(d - self->first_i_A, 1.0e-6f);
    if (!(lode_abs(across) <= ACROSS_SHARE)) {
        finish(self, BRINGUP_ANGLE, 0u, across, ACROSS_SHARE);
    } else if (resistance_plausible(self, R_Ohm)) {
        finish(self, BRINGUP_OK, 0u, R_Ohm, resistance_of(self->config));
    }
}

// Two stages for each of two currents, the second twice the first, after the three of the calibration.
static void step_voltage(bringup_t *self, const bringup_view_t *view) {
    if (!calibrated(self, view)) {
        return;
    }
    const bool second = self->stage >= 5u;
    if (self->stage == 3u || self->stage == 5u) {
        const lode_command_t at = voltage_at(self->angle_rad, self->turn_rad_s);
        if (raise_voltage(self, view, at, (second ? 2.0f : 1.0f) * test_current_A(self))) {
            self->count = 0.0f;
            next_stage(self, view);
        }
    } else if (still_balanced(self) && elapsed_s(self, view) >= SETTLE_TIME &&
               averaged(self, view, 0.0f)) {
        if (second) {
            judge_voltage(self);
        } else {
            self->first_u_V = self->u_V;
            self->first_i_A = self->sum_d / self->count;
            next_stage(self, view);
        }
    }
}

// --- 5: current ---

static void post_current(bringup_t *self, const bringup_view_t *view, float wanted) {
    post(self, (lode_command_t){.mode = LODE_MODE_CURRENT,
                                .vector = {wanted, 0.0f},
                                .theta_rad = self->angle_rad,
                                .omega_rad_s = self->turn_rad_s});
    next_stage(self, view);
}

// A controller without current feedback raises the voltage until something trips. So a small current is tried
// first; the voltage of the first periods precedes any current and is not evaluated.
static bool sees_current(bringup_t *self, const bringup_view_t *view, float wanted) {
    const float seen_A = length_of(view->now.i_A);
    if (view->now.steps - self->since > CONTROL_PERIODS && seen_A < SEEN_SHARE * wanted &&
        length_of(view->now.u_V) > voltage_for(self->config, wanted)) {
        finish(self, BRINGUP_CURRENT_OFF, 0u, seen_A - wanted, CURRENT_TOLERANCE * wanted);
        return false;
    }
    return true;
}

// Stage 3 posts a small current, 4 waits for current control, 5 checks it; from 6 on the full current.
static void step_current(bringup_t *self, const bringup_view_t *view) {
    const float wanted = CURRENT_SHARE * self->config->inverter.i_max_A;
    const float first = FIRST_SHARE * wanted;
    if (!calibrated(self, view)) {
        return;
    }
    if (self->stage == 3u) {
        post_current(self, view, first);
        return;
    }
    if (self->stage == 4u) {
        if (view->now.mode == LODE_MODE_CURRENT) {
            next_stage(self, view);
        }
        return;
    }
    if (!still_balanced(self) || !sees_current(self, view, self->stage == 5u ? first : wanted)) {
        return;
    }
    if (self->stage == 5u) {
        if (elapsed_s(self, view) >= FIRST_TIME) {
            post_current(self, view, wanted);
        }
        return;
    }
    if (elapsed_s(self, view) < SETTLE_TIME || !averaged(self, view, wanted)) {
        return;
    }
    const float d = self->sum_d / self->count;
    const float ripple = self->greatest - self->least;
    if (!(lode_abs(d - wanted) <= CURRENT_TOLERANCE * wanted)) {
        finish(self, BRINGUP_CURRENT_OFF, 0u, d - wanted, CURRENT_TOLERANCE * wanted);
    } else if (!(ripple <= RIPPLE_SHARE * wanted)) {
        finish(self, BRINGUP_RIPPLE, 0u, ripple, RIPPLE_SHARE * wanted);
    } else if (resistance_plausible(self, view->now.u_V.d / d)) {
        finish(self, BRINGUP_OK, 0u, d, wanted);
    }
}

// --- 6 and 7: sensorless ---

static void step_start(bringup_t *self, const bringup_view_t *view) {
    const lode_start_config_t *start = &self->config->start;
    const float timeout = start->timeout_s + MARGIN_TIME;
    if (!calibrated(self, view)) {
        return;
    }
    if (self->stage == 3u) {
        const float speed =
            START_SHARE * start->omega_handover_rad_s / self->config->motor.pole_pairs;
        post(self, (lode_command_t){.mode = LODE_MODE_RUN,
                                    .speed_rad_s = self->speed_rad_s < 0.0f ? -speed : speed});
        next_stage(self, view);
    } else if (self->stage == 4u) {
        if (view->now.mode == LODE_MODE_RUN) {
            self->least = view->now.lock;
            next_stage(self, view);
        } else if (elapsed_s(self, view) > timeout) {
            finish(self, BRINGUP_TIMEOUT, 0u, elapsed_s(self, view), timeout);
        }
    } else {
        self->least = lode_min(self->least, view->now.lock);
        if (elapsed_s(self, view) > HOLD_TIME) {
            const bool good = self->least >= LODE_LOCK_HANDOVER;
            finish(self, good ? BRINGUP_OK : BRINGUP_LOCK, 0u, self->least, LODE_LOCK_HANDOVER);
        }
    }
}

static void judge_run(bringup_t *self) {
    const float off = self->sum_error / self->count;
    const float limit = SPEED_TOLERANCE * lode_abs(self->speed_rad_s);
    if (!(self->least >= LODE_LOCK_HANDOVER)) {
        finish(self, BRINGUP_LOCK, 0u, self->least, LODE_LOCK_HANDOVER);
    } else {
        finish(self, lode_abs(off) <= limit ? BRINGUP_OK : BRINGUP_SPEED, 0u, off, limit);
    }
}

static void step_run(bringup_t *self, const bringup_view_t *view) {
    if (!calibrated(self, view)) {
        return;
    }
    const float wanted = self->speed_rad_s;
    const bool there = view->now.mode == LODE_MODE_RUN &&
                       lode_abs(view->now.speed_ref_rad_s - wanted) <= 1.0e-3f * lode_abs(wanted);
    if (self->stage == 3u) {
        post(self, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = wanted});
        next_stage(self, view);
    } else if (self->stage == 4u) {
        if (there) {
            next_stage(self, view);
        } else if (elapsed_s(self, view) > RUN_TIMEOUT) {
            finish(self, BRINGUP_TIMEOUT, 0u, elapsed_s(self, view), RUN_TIMEOUT);
        }
    } else if (self->stage == 5u) {
        if (elapsed_s(self, view) > RUN_TIME) { // the speed has settled
            self->sum_error = 0.0f;
            self->count = 0.0f;
            self->least = view->now.lock;
            next_stage(self, view);
        }
    } else {
        const float speed = view->now.omega_rad_s / self->config->motor.pole_pairs;
        self->sum_error += speed - wanted;
        self->count += 1.0f;
        self->least = lode_min(self->least, view->now.lock);
        if (elapsed_s(self, view) > RUN_TIME) {
            judge_run(self);
        }
    }
}

static void step_mode(bringup_t *self, const bringup_view_t *view) {
    switch (self->result.mode) {
    case BRINGUP_PWM:
        step_pwm(self, view);
        break;
    case BRINGUP_OFFSETS:
        if (calibrated(self, view)) {
            judge_offsets(self, view);
        }
        break;
    case BRINGUP_SIGNS:
        step_signs(self, view);
        break;
    case BRINGUP_VOLTAGE:
        step_voltage(self, view);
        break;
    case BRINGUP_CURRENT:
        step_current(self, view);
        break;
    case BRINGUP_START:
        step_start(self, view);
        break;
    case BRINGUP_RUN:
        step_run(self, view);
        break;
    default:
        break;
    }
}

bringup_state_t bringup_step(bringup_t *self, const bringup_view_t *view) {
    if (self->result.state != (uint_least8_t)BRINGUP_RUNNING) {
        return (bringup_state_t)self->result.state;
    }
    // Before the first stage the drive may still show an earlier fault.
    if (view->now.mode == LODE_MODE_FAULT && self->stage > 0u) {
        const lode_fault_t *fault = &view->now.fault;
        self->result.check = fault->check;
        finish(self, BRINGUP_FAULT, 0u, fault->measured, fault->limit);
    } else if (view->now.mode == LODE_MODE_PRECHARGE) {
        self->since = view->now.steps; // the time of the stage starts after it
    } else {
        step_mode(self, view);
    }
    return (bringup_state_t)self->result.state;
}
