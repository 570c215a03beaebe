#include "estimator_inline.h"

#define EMIN_SHARE 0.03f     // of the EMF at rated speed: 2 V for paper 1's motor
#define OMEGA_MAX_SHARE 2.5f // of the rated speed
#define OMEGA_TS_MAX 0.5f    // EMF observer's lag and modulator need 12 periods per turn
#define LOCK_TIME_s 5.0e-3f
#define SETTLE_OBSERVER 8.0f // time constants 1/w0 until the double pole has settled to 0.3 %
#define SETTLE_ROTATION 3.0f // time constants of the mean rotation until it tells the speed to 5 %
// 1.2 s at 200 kHz. The sum of two fits into 16 bits.
#define ROUNDS_MAX 3.0e4f
// Amplitudes beyond any motor's.
#define INPUT_LIMIT 1.0e6f
// Sine of the position error above which the notch, and an amplitude some periods old, mislead.
#define ERROR_SMALL 0.5f
// Limits of (P24): where speed and EMF disagree this much, the current tells little about the angle.
#define SLIP_MAX 0.8f
#define SLIP_ERROR_MAX_rad 0.5f
#define ACTIVE_MIN_SHARE 0.2f // of the magnets' flux: least divisor
#define ALIGNED_SHARE 0.9f    // cosine of 25 degrees
// Up to this correction the rotation's length stays within 1 % until it is normalised.
#define CORRECTION_SMALL_rad 0.05f

void lode_estimator_design(lode_estimator_config_t *config, const lode_motor_t *motor, float ts_s) {
    const float omega_rated = motor->omega_rated_rad_s;
    lode_pll_design(&config->pll, omega_rated, ts_s);
    lode_emf_design(&config->emf, motor, config->pll.sigma_rad_s, ts_s);
    if (config->active_flux == LODE_AUTO) {
        config->active_flux = LODE_ON;
    }
    config->emin_V = lode_given_or(config->emin_V, EMIN_SHARE * omega_rated * motor->psi_Wb);
    const float omega_max = lode_min(OMEGA_MAX_SHARE * omega_rated, OMEGA_TS_MAX / ts_s);
    config->omega_max_rad_s = lode_given_or(config->omega_max_rad_s, omega_max);
    config->lock_s = lode_given_or(config->lock_s, LOCK_TIME_s);
}

static lode_status_t check(const lode_estimator_config_t *config, float ts_s) {
    if (!lode_is_on_or_off(config->active_flux)) {
        return LODE_ERROR_CHOICE;
    }
    if (!lode_in_range(config->emin_V, 1.0e-4f, 1.0e3f)) {
        return LODE_ERROR_EMIN;
    }
    if (!lode_in_range(config->omega_max_rad_s, 1.0f, 1.001f * OMEGA_TS_MAX / ts_s)) {
        return LODE_ERROR_OMEGA_MAX;
    }
    if (!lode_in_range(config->lock_s, ts_s, 1.0f)) {
        return LODE_ERROR_LOCK_TIME;
    }
    if (!lode_in_range(config->w_filter_rad_s, 0.0f, 1.0f / ts_s)) {
        return LODE_ERROR_W_FILTER;
    }
    return lode_observer_check_pll(&config->emf, config->pll.sigma_rad_s,
                                   config->pll.kind == LODE_PLL_LESO);
}

static uint_least16_t rounds_in(float time_s, float slow_s) {
    return (uint_least16_t)((uint32_t)(int32_t)lode_min(time_s / slow_s, ROUNDS_MAX) + 1u);
}

static lode_status_t tune_notches(lode_estimator_tuning_t *t, const lode_estimator_config_t *config,
                                  float ts_s) {
    const float sigma = config->pll.sigma_rad_s;
    lode_notch_tuning_t notch;
    lode_notch_tuning_t notch12;
    lode_status_t status = lode_notch_tune(&notch, 6.0f, config->notch_k, sigma, ts_s);
    if (status == LODE_OK) {
        status = lode_notch_tune(&notch12, 12.0f, config->notch12_k, sigma, ts_s);
    }
#ifdef LODE_WITHOUT_NOTCH
    (void)t;
#else
    if (status == LODE_OK) {
        t->notch = notch;
        t->notch12_k = notch12.k;
    }
#endif
    return status;
}

static uint32_t options_of(const lode_estimator_tuning_t *t,
                           const lode_estimator_config_t *config) {
    const bool notch12 = config->notch12_k > 0.0f;
    uint32_t options = 0u;
    options |= lode_abs(t->emf.salient_Ohm) > 0.0f ? (uint32_t)LODE_ESTIMATOR_SALIENT : 0u;
    options |= t->w_weight < 1.0f ? (uint32_t)LODE_ESTIMATOR_FILTERED : 0u;
    options |= config->notch_k > 0.0f || notch12 ? (uint32_t)LODE_ESTIMATOR_NOTCH : 0u;
    options |= notch12 ? (uint32_t)LODE_ESTIMATOR_NOTCH12 : 0u;
    options |= t->pll.third_order != 0u ? (uint32_t)LODE_ESTIMATOR_THIRD_ORDER : 0u;
    return options;
}

lode_status_t lode_estimator_tune(lode_estimator_tuning_t *tuning,
                                  const lode_estimator_config_t *config, const lode_motor_t *motor,
                                  float ts_s) {
    lode_estimator_tuning_t t = {.options = 0u};
#ifndef LODE_WITHOUT_HFI
    t.hfi = lode_hfi_none();
#endif
    lode_status_t status = lode_motor_check(motor);
    // With friction that stops the rotor within a period, the predicted motion would be unstable.
    if (status == LODE_OK && !(motor->B_Nms * ts_s <= motor->J_kgm2)) {
        status = LODE_ERROR_MOTOR_B;
    }
    if (status == LODE_OK) {
        status = lode_pll_tune(&t.pll, &config->pll, ts_s);
    }
    if (status == LODE_OK) {
        status = lode_emf_tune(&t.emf, &config->emf, motor, lode_pll_notch_rad_s(&config->pll),
                               config->active_flux == LODE_ON, ts_s);
    }
    if (status == LODE_OK) {
        status = check(config, ts_s);
    }
    if (status == LODE_OK) {
        status = lode_lag_tune(&t.lag, config->compensation, &config->emf, motor, ts_s,
                               config->omega_max_rad_s);
    }
    if (status == LODE_OK) {
        status = tune_notches(&t, config, ts_s);
    }
    if (status != LODE_OK) {
        return status;
    }
    const bool leso = config->pll.kind == LODE_PLL_LESO;
    const float np = motor->pole_pairs;
    const float settle_s =
        lode_max(SETTLE_OBSERVER / config->emf.w0_rad_s, SETTLE_ROTATION * config->lock_s);
    t.w_weight =
        config->w_filter_rad_s > 0.0f ? lode_one_minus_exp(config->w_filter_rad_s * ts_s) : 1.0f;
    t.droop_s2 = lode_observer_droop_s2(&config->emf);
    t.options = options_of(&t, config);
    t.emin_V = config->emin_V;
    t.omega_limit = LODE_ALIAS_SHARE * config->omega_max_rad_s;
    const float theta_gain = lode_pll_gains(&t.pll, config->pll.omega_high_rad_s).theta;
    t.error_small = lode_min(ERROR_SMALL, CORRECTION_SMALL_rad / theta_gain);
    t.psi_Wb = motor->psi_Wb;
    t.salient_H = motor->Ld_H - motor->Lq_H;
    t.acc_per_torque = leso ? np * lode_motor_torque_factor(motor) / motor->J_kgm2 : 0.0f;
    t.acc_per_omega = leso ? motor->B_Nms / motor->J_kgm2 : 0.0f;
    t.load_per_f_Nm = leso ? -motor->J_kgm2 / np : 0.0f;
    const float slow_s = (float)LODE_SLOW_PERIODS * ts_s;
    t.lock_weight = lode_one_minus_exp(slow_s / config->lock_s);
    t.rotation_weight = lode_one_minus_exp(ts_s / config->lock_s);
    t.settle_rounds = rounds_in(settle_s, slow_s);
    t.patience_rounds = rounds_in(config->lock_s, slow_s);
    *tuning = t;
    return LODE_OK;
}

// One over the EMF's amplitude, with the sign that the phase detector needs.
static float per_V_of(const lode_estimator_tuning_t *tuning, float e2_V2, float omega_rad_s) {
    const float size = 1.0f / lode_max(lode_sqrt(e2_V2), tuning->emin_V);
    return omega_rad_s < 0.0f ? size : -size;
}

static LODE_NOINLINE LODE_SMALL_CALL void
renew_lag(lode_estimator_t *self, const lode_estimator_tuning_t *tuning, float omega_rad_s) {
    self->lag = lode_lag_line(&tuning->lag, omega_rad_s);
}

// After a speed that is set, or has moved too far for the line through the lag. Not LODE_RAMFUNC: rare.
LODE_NOINLINE void lode_estimator_move_lag(lode_estimator_t *self,
                                           const lode_estimator_tuning_t *tuning,
                                           float omega_rad_s) {
    if (lode_lag_is_far(&self->lag, omega_rad_s)) {
        renew_lag(self, tuning, omega_rad_s);
    }
}

void lode_estimator_reset(lode_estimator_t *self, const lode_estimator_tuning_t *tuning) {
    *self = (lode_estimator_t){
        .pll.frame = {0.0f, 1.0f},
        .per_V = -1.0f / tuning->emin_V,
        .by.alone.wait = tuning->settle_rounds,
    };
    renew_lag(self, tuning, 0.0f);
    self->gains = lode_pll_gains(&tuning->pll, 0.0f);
}

void lode_estimator_set_current(lode_estimator_t *self, lode_ab_t i_A) {
    self->emf.i_A = i_A;
    self->id_A = lode_park(i_A, lode_estimator_rotor(self)).d;
}

// Keeps the present current; zero if it is not finite.
LODE_NOINLINE void lode_estimator_restart(lode_estimator_t *self,
                                          const lode_estimator_tuning_t *tuning) {
    const uint_least8_t slot = self->slot;
    const lode_ab_t i_A = self->emf.i_A;
    lode_estimator_reset(self, tuning);
    self->slot = slot;
    if (lode_ab_in_range(i_A, INPUT_LIMIT)) {
        lode_estimator_set_current(self, i_A);
    }
}

// Gains, notches and EMF amplitude follow in their slots.
void lode_estimator_hold(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                         lode_sincos_t rotor, float omega_rad_s) {
    lode_estimator_move_lag(self, tuning, omega_rad_s);
    const lode_sincos_t lag = lode_lag_near(&self->lag, omega_rad_s);
    const float per_V = lode_abs(self->per_V);
    self->pll.frame = lode_angle_subtract(rotor, lag);
    self->pll.omega_rad_s = omega_rad_s;
    self->pll.f_rad_s2 = 0.0f;
    self->pll.rise_rad_s = 0.0f;
    self->per_V = omega_rad_s < 0.0f ? per_V : -per_V;
    self->id_A = lode_park(self->emf.i_A, rotor).d;
    self->omega_tune = omega_rad_s;
    self->by.alone.wait = tuning->patience_rounds;
    self->found = 1u;
}

#ifndef LODE_WITHOUT_FLYING_START

// Sets EMF, lag and gains too, as if it had been running for long.
void lode_estimator_begin_at(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                             lode_sincos_t rotor, float omega_rad_s) {
    lode_estimator_reset(self, tuning);
    lode_estimator_hold(self, tuning, rotor, omega_rad_s);
    const float taken = lode_estimator_droop(tuning, omega_rad_s);
    const float seen_V = omega_rad_s * tuning->psi_Wb / taken;
    const lode_sincos_t frame = self->pll.frame;
    const lode_ab_t e_V = {-seen_V * frame.sin, seen_V * frame.cos};
    lode_observer_begin(&self->emf.observer, &tuning->emf.observer, e_V,
                        tuning->pll.ts_s * omega_rad_s);
    self->per_V = per_V_of(tuning, seen_V * seen_V, omega_rad_s);
    self->gains = lode_pll_gains(&tuning->pll, omega_rad_s);
    self->lock = 1.0f;
    self->locked = true;
    self->aligned = true;
}

#endif

// Keeps the rotor's angle: another observer, or another bandwidth, has another lag and droop, so its EMF is at another angle and of another size.
static void change_observer(lode_estimator_t *self, const lode_estimator_tuning_t *before,
                            const lode_estimator_tuning_t *now) {
    const float omega = self->pll.omega_rad_s;
    const lode_sincos_t rotor = lode_estimator_rotor(self);
    const lode_dq_t e_V = lode_park(self->emf.observer.e_V, self->pll.frame);
    renew_lag(self, now, omega);
    self->pll.frame = lode_angle_subtract(rotor, lode_lag_near(&self->lag, omega));
    const float size = lode_estimator_droop(before, omega) / lode_estimator_droop(now, omega);
    const lode_dq_t seen_V = {size * e_V.d, size * e_V.q};
    lode_observer_begin(&self->emf.observer, &now->emf.observer,
                        lode_park_inverse(seen_V, self->pll.frame), now->pll.ts_s * omega);
    self->per_V = per_V_of(now, lode_ab_length2(self->emf.observer.e_V), omega);
}

static bool is_same_observer(const lode_observer_tuning_t *a, const lode_observer_tuning_t *b) {
    bool same = a->kind == b->kind;
    for (uint32_t n = 0u; n < sizeof a->own / sizeof a->own[0]; n++) {
        same = same && lode_in_range(a->own[n], b->own[n], b->own[n]);
    }
    return same;
}

void lode_estimator_retune(lode_estimator_t *self, const lode_estimator_tuning_t *before,
                           const lode_estimator_tuning_t *now) {
    lode_estimator_forget_motion(self); // other gains and another inertia
    if ((before->options & (uint32_t)LODE_ESTIMATOR_FILTERED) == 0u) {
        self->omega_tune = self->pll.omega_rad_s; // was not kept up to date
    }
    if (!is_same_observer(&before->emf.observer, &now->emf.observer)) {
        change_observer(self, before, now);
    }
#ifndef LODE_WITHOUT_HFI
    if (!lode_hfi_is_on(&now->hfi)) {
        lode_estimator_end_injection(self, now);
    }
#endif
}

// A large position error is computed again, with the present amplitude and without the notches, which are not tuned for such a
// step. Returns more than SINE_MAX if the state is not that of a motor.
// Not LODE_RAMFUNC: rare, and small fast memories have no room for it.
float lode_estimator_recompute(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                               lode_sincos_t frame) {
    const lode_ab_t e_V = self->emf.observer.e_V;
    const float e2 = lode_ab_length2(e_V);
    if (!(e2 <= EMF_LIMIT_V * EMF_LIMIT_V) ||
        !(lode_abs(self->pll.omega_rad_s) <= tuning->omega_limit)) {
        return 2.0f * SINE_MAX;
    }
    self->per_V = per_V_of(tuning, e2, self->pll.omega_rad_s);
    lode_estimator_clear_notches(self);
    return lode_park(e_V, frame).d * self->per_V;
}

// Returns more than SINE_MAX if the EMF is not that of a motor: not finite, or too large to be blended.
LODE_NOINLINE float lode_estimator_limit(const lode_estimator_t *self, float error) {
    if (!(lode_ab_length2(self->emf.observer.e_V) <= EMF_LIMIT_V * EMF_LIMIT_V)) {
        return 2.0f * SINE_MAX;
    }
    return lode_clamp(error, -LODE_HFI_ERROR_MAX_rad, LODE_HFI_ERROR_MAX_rad);
}

#ifndef LODE_WITHOUT_PLAUSIBILITY

lode_flux_t lode_estimator_flux(const lode_estimator_t *self,
                                const lode_estimator_tuning_t *tuning) {
    const lode_ab_t e_V = self->emf.observer.e_V;
    const float length_V = lode_ab_length(e_V);
    const float omega = lode_abs(self->pll.omega_rad_s);
    const float taken = lode_estimator_droop(tuning, omega);
    return (lode_flux_t){.expected_Wb = tuning->psi_Wb + tuning->salient_H * self->id_A,
                         .seen_Wb = length_V * taken / lode_max(omega, FLT_MIN),
                         .aligned = lode_abs(lode_park(e_V, self->pll.frame).q) >=
                                    ALIGNED_SHARE * length_V};
}

LODE_NOINLINE lode_ab_t lode_estimator_beyond_V(const lode_estimator_t *self,
                                                const lode_estimator_tuning_t *tuning) {
    const float omega = self->pll.omega_rad_s;
    const float taken = lode_estimator_droop(tuning, omega);
    const float flux_Wb = tuning->psi_Wb + tuning->salient_H * self->id_A;
    const float expected_V = omega * flux_Wb / taken;
    const lode_ab_t e_V = self->emf.observer.e_V;
    const lode_sincos_t frame = self->pll.frame;
    return (lode_ab_t){e_V.alpha + expected_V * frame.sin, e_V.beta - expected_V * frame.cos};
}

#endif

#ifndef LODE_WITHOUT_BRAKE_SLIP

// Gives back the part of the position error that slip makes in a braked salient rotor (P24), for a whole round at once.
// Not LODE_RAMFUNC: rare.
LODE_NOINLINE void lode_estimator_brake_slip(lode_estimator_t *self,
                                             const lode_estimator_tuning_t *tuning, float slip) {
    const lode_dq_t i_A = lode_park(self->emf.i_A, lode_estimator_rotor(self));
    const float flux_Wb =
        lode_max(tuning->psi_Wb + tuning->salient_H * i_A.d, ACTIVE_MIN_SHARE * tuning->psi_Wb);
    const float share = tuning->salient_H * i_A.q / flux_Wb;
    if (!self->aligned || !(share * self->pll.omega_rad_s > 0.0f)) { // motoring, or not salient
        return;
    }
    const float error = lode_clamp(-share * lode_min(slip - SLIP_MIN, SLIP_MAX),
                                   -SLIP_ERROR_MAX_rad, SLIP_ERROR_MAX_rad);
    const float sum = (float)LODE_SLOW_PERIODS * error;
    const float turn_rad = lode_clamp(self->gains.theta * sum, -0.25f * LODE_PI, 0.25f * LODE_PI);
    self->pll.frame = lode_angle_add(self->pll.frame, lode_sincos_octant(turn_rad));
    self->pll.omega_rad_s += self->gains.omega_s * sum;
    self->pll.f_rad_s2 += self->gains.f_s2 * sum;
    lode_estimator_move_lag(self, tuning, self->pll.omega_rad_s);
}

// A load that stops the rotor shows in the EMF's amplitude before the PLL's speed has followed. Bounds that speed by it, where the
// frame is as much slower: its corrections turn it, too. Not below the frame, and no faster than torque changes it (P35).
// Not LODE_RAMFUNC: rare.
LODE_NOINLINE void lode_estimator_limit_slip(lode_estimator_t *self,
                                             const lode_estimator_tuning_t *tuning, float slip) {
    const float sign = lode_sign(self->pll.omega_rad_s);
    const float omega = lode_abs(self->pll.omega_rad_s);
    const lode_dq_t e_V = lode_park(self->emf.observer.e_V, self->pll.frame);
    const float sine = e_V.d * self->per_V;
    const float cosine = lode_abs(e_V.q * self->per_V);
    const float frame = omega + sign * self->gains.theta * tuning->pll.inv_ts * sine;
    const bool both = cosine >= ALIGNED_SHARE && (1.0f + SLIP_MIN) * frame < omega;
    if (self->locked && both) {
        const float by_emf = omega * (1.0f + SLIP_MIN) / (1.0f + slip);
        const float round_s = (float)LODE_SLOW_PERIODS * tuning->pll.ts_s;
        const float fall = lode_min(omega - lode_max(by_emf, frame), tuning->acc_most * round_s);
        self->pll.omega_rad_s -= sign * fall;
        self->omega_noted -= lode_abs(self->omega_noted) > 0.0f ? sign * fall : 0.0f; // for (P30)
        lode_estimator_move_lag(self, tuning, self->pll.omega_rad_s);
    }
}

#endif

// The waiting time is over: it lets observer and mean rotation settle after a reset, and a new acquisition prove itself. A time
// above the longest one comes from corrupted memory and counts as over.
static bool is_seed_due(const lode_estimator_t *self, const lode_estimator_tuning_t *tuning) {
    const uint32_t longest = (uint32_t)tuning->settle_rounds + tuning->patience_rounds;
    return self->by.alone.wait == 0u || self->by.alone.wait > longest;
}

// Change of speed of a free rotor within a time constant of the PLL, over the speed found; above it the rotor must be loaded.
#define LOADED_SHARE 2.0f

// Acceleration by the present torque that a load is assumed to cancel: where the rotor is known to be held, or a free one would
// run away from the speed found before the PLL follows. Otherwise the PLL would never lock under load.
static float load_acceleration(const lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                               bool held) {
    const lode_pll_t *pll = &self->pll;
    if (tuning->pll.third_order == 0u) {
        return 0.0f; // the QPLL has no such state
    }
    const lode_dq_t i_A = lode_park(self->emf.i_A, pll->frame);
    const float acc = lode_estimator_acceleration(tuning, i_A, 0.0f, pll->omega_rad_s);
    const float sigma = tuning->pll.x_low * tuning->pll.inv_ts;
    const bool loaded = lode_abs(acc) > LOADED_SHARE * sigma * lode_abs(pll->omega_rad_s);
    return (held || loaded) ? acc : 0.0f;
}

// Takes speed, direction and angle from the EMF alone (P16): it turns by w Ts per period, and is a quarter turn ahead of the
// PLL's frame in the direction of rotation. False if the EMF is too small or the speed too high.
static bool acquire(lode_estimator_t *self, const lode_estimator_tuning_t *tuning, bool held) {
    const lode_ab_t e_V = self->emf.observer.e_V;
    lode_observer_settle(&self->emf.observer, &tuning->emf.observer);
    const float step_rad = lode_atan2(self->by.alone.rotation.beta, self->by.alone.rotation.alpha);
    if (!(lode_abs(step_rad) > 0.0f)) { // also where the mean is NaN, which would stay
        self->by.alone.rotation = (lode_ab_t){0.0f, 0.0f};
    }
    const float omega = step_rad * tuning->pll.inv_ts;
    const float e_abs = lode_ab_length(e_V);
    if (!(e_abs > tuning->emin_V) || !(lode_abs(omega) <= tuning->omega_limit)) {
        return false;
    }
    const float unit = lode_sign(omega) / e_abs;
    const lode_sincos_t frame = {-unit * e_V.alpha, unit * e_V.beta};
    self->pll.frame = frame;
    self->pll.omega_rad_s = omega;
    self->pll.rise_rad_s = 0.0f;
    self->pll.f_rad_s2 = -load_acceleration(self, tuning, held);
    self->per_V = -unit;
    self->omega_tune = omega;
    self->by.alone.wait = tuning->patience_rounds;
    self->found = 1u; // the lag follows in the next period if the speed is far from its line's
    return true;
}

// Not LODE_RAMFUNC: rare.
LODE_NOINLINE bool lode_estimator_may_move(const lode_estimator_t *self,
                                           const lode_estimator_tuning_t *tuning) {
    if (!(lode_abs(self->omega_noted) > 0.0f)) {
        return true;
    }
    const float round_s = (float)LODE_SLOW_PERIODS * tuning->pll.ts_s;
    const float f_moves = ROUND_ERROR * self->gains.f_s2;
    const float acc_most = lode_abs(self->f_noted) + f_moves + tuning->acc_most;
    const float omega_moves = ROUND_ERROR * self->gains.omega_s + round_s * acc_most;
    return lode_abs(self->pll.f_rad_s2 - self->f_noted) <= f_moves &&
           lode_abs(self->pll.omega_rad_s - self->omega_noted) <= omega_moves;
}

LODE_NOINLINE void lode_estimator_wait(lode_estimator_t *self,
                                       const lode_estimator_tuning_t *tuning) {
    if (!is_seed_due(self, tuning)) {
        self->by.alone.wait = (uint_least16_t)(self->by.alone.wait - 1u);
    }
}

// Mean of e[k] conj(e[k-1]), which is constant at constant speed, whatever the angle (P16).
// Not LODE_RAMFUNC: only without lock.
void lode_estimator_note_rotation(lode_estimator_t *self, const lode_estimator_tuning_t *tuning) {
    const lode_ab_t e = self->emf.observer.e_V;
    const lode_ab_t before = self->by.alone.before_V;
    const lode_ab_t step = {e.alpha * before.alpha + e.beta * before.beta,
                            e.beta * before.alpha - e.alpha * before.beta};
    self->by.alone.before_V = e;
    self->by.alone.rotation = lode_ab_add_scaled(self->by.alone.rotation, tuning->rotation_weight,
                                                 lode_ab_subtract(step, self->by.alone.rotation));
}

LODE_RAMFUNC LODE_NOINLINE lode_sincos_t lode_estimator_filtered_step(
    lode_estimator_t *self, const lode_estimator_tuning_t *tuning, float omega_rad_s) {
    self->omega_tune += tuning->w_weight * (omega_rad_s - self->omega_tune);
    return lode_sincos(tuning->pll.ts_s * self->omega_tune);
}

#ifndef LODE_WITHOUT_HFI

// Notches, rotation and waiting time start anew: they share memory with injection.
void lode_estimator_end_injection(lode_estimator_t *self, const lode_estimator_tuning_t *tuning) {
    if (self->by.hfi.active) {
        self->by.alone =
            (lode_estimator_alone_t){.step = self->by.hfi.step, .wait = tuning->patience_rounds};
        self->found = 1u;
    }
    self->by.alone.reserve_V = 0.0f;
}

#endif

bool lode_estimator_seed(lode_estimator_t *self, const lode_estimator_tuning_t *tuning, bool held) {
    return is_seed_due(self, tuning) && acquire(self, tuning, held);
}

float lode_estimator_theta_rad(const lode_estimator_t *self) {
    const lode_sincos_t rotor = lode_estimator_rotor(self);
    return lode_atan2(rotor.sin, rotor.cos);
}

// The slow jobs of an estimator without a drive. True: angle and speed were acquired again.
static bool do_slow_job(lode_estimator_t *self, const lode_estimator_tuning_t *tuning) {
    const lode_slot_t slot = lode_slot_of(self->slot);
    self->slot = (uint_least8_t)lode_slot_of((uint32_t)slot + 1u);
    switch (slot) {
    case SLOT_LOCK:
        lode_estimator_note_lock(self, tuning);
        return false;
    case SLOT_LAG:
        lode_estimator_adapt_lag(self, tuning);
        return false;
    case SLOT_GAINS: {
        if (!self->locked && lode_estimator_seed(self, tuning, false)) {
            return true; // as in the drive
        }
        lode_estimator_adapt_gains(self, tuning);
        lode_estimator_adapt_notches(self, tuning);
        return false;
    }
    case SLOT_GUARD:
    case SLOT_DEAD_TIME:
    case SLOT_GUARD_2:
    case SLOT_SPEED:
    case SLOT_REFERENCES:
    case SLOT_COUNT:
    default:
        return false;
    }
}

lode_estimate_t lode_estimator_step(lode_estimator_t *self, const lode_estimator_tuning_t *tuning,
                                    lode_ab_t u_V, lode_ab_t i_A) {
    lode_estimate_t estimate = lode_estimator_fast(self, tuning, u_V, i_A);
    // The drive checks the lock before it uses such a speed or load; here they would be returned.
    if (!(lode_abs(estimate.omega_rad_s) <= tuning->omega_limit) ||
        !lode_is_finite(estimate.load_torque_Nm)) {
        lode_estimator_restart(self, tuning);
        estimate = lode_estimator_nothing(self);
    }
    if (do_slow_job(self, tuning)) {
        estimate.reseeded = true;
    }
    return estimate;
}
