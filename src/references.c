#include "lodestar/references.h"
#include "references_inline.h"

// With 471 rad/s rated: full bias below 94, none above 188 rad/s. With a narrower range, a load step from no load at a quarter
// of rated speed met all three currents in the dead band: 11 degrees of error instead of 4.
#define OMEGA_LOW_SHARE 0.2f
#define OMEGA_HIGH_SHARE 0.4f
#define BIAS_SHARE 0.25f // of i_max: 3 A of 12 A leaves no phase at zero for long

#define VOLTAGE_USE 0.95f // leaves control 5 % of its circle, some 20 times the noise of the bus
#define TRIM_rad_s 20.0f  // a decade below speed control
#define TRIM_MAX 0.15f    // dead time, drops and 10 % of psi
#define RELEASE_s 0.1f
#define FALL_s 4.0e-3f       // id falls by i_max in some four time constants of current control
#define FLUX_MIN_SHARE 0.02f // of psi: at some 50 times the speed at which psi takes the voltage
// Near MTPV the flux no longer depends on id. The slope is kept above a tenth of its value at zero current, and fall_A bounds
// the step.
#define SLOPE_MIN_SHARE 0.1f
#define WEAKENING_SHARE 1.0e-3f // of i_max: id counts as weakened this far below the free id
#define SETTLED_SHARE 0.9f      // of the slower rate of id: below it no rate limit acts
#define FLUX_UNLIMITED 1.0e9f   // finite when squared, beyond any motor's
#define FLUX_SLACK 1.02f        // part of what voltage_use leaves, against noise on iq
#define SATURATION_STEPS 32
#define LQ_UNKNOWN 0.1f // of Lq at i_max; equivalent to 20 % at 0.7 i_max
// Share of the limit of (R15). There a change of the current moves the angle 1.7 times as much as with little current (R16),
// and towards the limit without bound; the PLL passes this to speed control as a speed.
#define ANGLE_SHARE 0.5f

// With id* = 0 an error of Lq turns the angle, so that a part of the current strengthens the d flux; a salient rotor then loses
// active flux, and the angle turns further. Beyond (psi/iq)^2 = 4 (Lq - Ld) dLq this has no end (R15). With id < 0 it has, and
// the angle depends less on the current (R16).
static lode_references_kind_t default_kind(const lode_inverter_config_t *inverter,
                                           const lode_motor_t *motor) {
#ifdef LODE_WITHOUT_OPTIMAL_REFERENCES
    (void)inverter;
    (void)motor;
    return LODE_REFERENCES_ID0;
#else
    const float lost = (motor->Lq_H - motor->Ld_H) * inverter->i_max_A;
    const float turned = LQ_UNKNOWN * motor->Lq_H * inverter->i_max_A;
    const bool bounded = 4.0f * lost * turned < ANGLE_SHARE * motor->psi_Wb * motor->psi_Wb;
    return bounded ? LODE_REFERENCES_ID0 : LODE_REFERENCES_MTPA;
#endif
}

void lode_references_design(lode_references_config_t *config,
                            const lode_inverter_config_t *inverter, const lode_motor_t *motor) {
    if (config->kind == LODE_REFERENCES_AUTO) {
        config->kind = default_kind(inverter, motor);
    }
    if (config->field_weakening == LODE_AUTO) {
        config->field_weakening = LODE_OFF;
    }
    config->id_bias_A = lode_given_or(config->id_bias_A, BIAS_SHARE * inverter->i_max_A);
    config->omega_low_rad_s =
        lode_given_or(config->omega_low_rad_s, OMEGA_LOW_SHARE * motor->omega_rated_rad_s);
    config->omega_high_rad_s =
        lode_given_or(config->omega_high_rad_s, OMEGA_HIGH_SHARE * motor->omega_rated_rad_s);
    config->voltage_use = lode_given_or(config->voltage_use, VOLTAGE_USE);
    config->trim_rad_s = lode_given_or(config->trim_rad_s, TRIM_rad_s);
    config->release_s = lode_given_or(config->release_s, RELEASE_s);
    config->id_max_A = lode_given_or(config->id_max_A, inverter->i_max_A);
}

static bool is_weakening_sound(const lode_references_config_t *config, float i_max_A) {
    return lode_in_range(config->voltage_use, 0.1f, 1.0f) &&
           lode_is_none_or_in(config->trim_rad_s, 0.1f, 1.0e3f) &&
           lode_in_range(config->release_s, 1.0e-3f, 10.0f) &&
           lode_in_range(config->id_max_A, 1.0e-3f * i_max_A, i_max_A);
}

// Each configured fade lies between the nominal bus voltage and the end of the fade.
static bool is_fade_sound(const lode_references_config_t *config, float v_bus_V) {
    const float above_V = config->v_bus_max_V - config->v_regen_V;
    const float below_V = config->v_motor_V - config->v_bus_min_V;
    const bool regen = lode_in_range(config->v_regen_V, 0.0f, 0.0f) ||
                       (config->v_regen_V >= v_bus_V && lode_in_range(above_V, FLT_MIN, FLT_MAX));
    const bool motor = lode_in_range(config->v_motor_V, 0.0f, 0.0f) ||
                       (config->v_motor_V <= v_bus_V && config->v_bus_min_V >= 0.0f &&
                        lode_in_range(below_V, FLT_MIN, FLT_MAX));
    return regen && motor;
}

static lode_status_t check(const lode_references_config_t *config,
                           const lode_inverter_config_t *inverter) {
    const float span = config->omega_high_rad_s - config->omega_low_rad_s;
    if (!lode_is_none_or_in(config->id_bias_A, 0.0f, inverter->i_max_A) ||
        !lode_in_range(span, FLT_MIN, FLT_MAX)) {
        return LODE_ERROR_ID_BIAS;
    }
    if ((config->kind != LODE_REFERENCES_ID0 && config->kind != LODE_REFERENCES_MTPA) ||
        !lode_is_on_or_off(config->field_weakening)) {
        return LODE_ERROR_REFERENCES;
    }
    if (!is_weakening_sound(config, inverter->i_max_A)) {
        return LODE_ERROR_FIELD_WEAKENING;
    }
    if (!lode_in_range(config->Lq_fall, 0.0f, 10.0f / inverter->i_max_A)) {
        return LODE_ERROR_LQ_FALL;
    }
    return is_fade_sound(config, inverter->v_bus_V) ? LODE_OK : LODE_ERROR_BUS_FADE;
}

LODE_INLINE float Lq_at(const lode_references_tuning_t *tuning, float iq_A) {
    return tuning->Lq_H / (1.0f + tuning->Lq_fall * lode_abs(iq_A));
}

// Largest torque on the current circle (R6), over the torque factor: id from the amplitude in closed form, with the Lq of the
// previous step's iq.
static float most_tau(const lode_references_tuning_t *tuning) {
    const float i_max = tuning->i_max_A;
    float iq = i_max;
    float id = 0.0f;
    float salient = lode_references_salient_H(tuning);
    for (int32_t i = 0;
         lode_references_has(tuning, LODE_REFERENCES_LEAST_CURRENT) && i < SATURATION_STEPS; i++) {
        salient = tuning->Ld_H - Lq_at(tuning, iq);
        const float arm = 2.0f * salient * i_max;
        id = arm * i_max /
             (tuning->psi_Wb + lode_sqrt(tuning->psi_Wb * tuning->psi_Wb + 2.0f * arm * arm));
        iq = lode_sqrt(i_max * i_max - id * id);
    }
    return (tuning->psi_Wb + salient * id) * iq;
}

static uint32_t options_of(const lode_references_config_t *config, const lode_motor_t *motor) {
    const bool weakens = config->field_weakening == LODE_ON;
    // With Lq >= Ld the point of maximum torque per volt lies beyond psi/Ld (R13).
    const bool reaches =
        motor->Ld_H > motor->Lq_H || motor->psi_Wb < motor->Ld_H * config->id_max_A;
    const bool fades = config->v_regen_V > 0.0f || config->v_motor_V > 0.0f;
    uint32_t options = 0u;
    options |= config->kind == LODE_REFERENCES_MTPA ? (uint32_t)LODE_REFERENCES_LEAST_CURRENT : 0u;
    options |= weakens ? (uint32_t)LODE_REFERENCES_WEAKEN : 0u;
    options |= weakens && reaches ? (uint32_t)LODE_REFERENCES_REACH_MTPV : 0u;
    options |= fades ? (uint32_t)LODE_REFERENCES_FADE : 0u;
    options |= config->Lq_fall > 0.0f ? (uint32_t)LODE_REFERENCES_SATURATE : 0u;
    return options;
}

// If not wanted, a fade that is never reached.
static lode_fade_t fade_between(float low, float high, bool wanted) {
    return wanted ? (lode_fade_t){high, 1.0f / (high - low)} : (lode_fade_t){FLT_MAX, 1.0f};
}

// True: this build includes what the options need.
static bool is_built_in(const lode_references_tuning_t *t) {
#if defined(LODE_WITHOUT_OPTIMAL_REFERENCES)
    return t->options == 0u;
#elif defined(LODE_WITHOUT_FIELD_WEAKENING)
    return !lode_references_has(t, LODE_REFERENCES_WEAKEN);
#else
    (void)t;
    return true;
#endif
}

static void tune_weakening(lode_references_tuning_t *t, const lode_references_config_t *config,
                           const lode_inverter_config_t *inverter, const lode_motor_t *motor,
                           float voltage_use, float ts_s) {
    const float i_max = inverter->i_max_A;
    const float trim_ts = lode_max(config->trim_rad_s, 0.0f) * ts_s;
    t->circle = config->voltage_use * voltage_use / LODE_SQRT3;
    const float nominal = t->circle * inverter->v_bus_V;
    t->trim_gain = 0.5f * trim_ts / (nominal * nominal);
    t->trim_decay = lode_min(trim_ts, 1.0f);
    t->drop = motor->Rs_Ohm / nominal;
    t->id_min_A = -config->id_max_A;
    t->fall_A = i_max * lode_min(ts_s / FALL_s, 1.0f);
    t->rise_A = i_max * lode_min(ts_s / config->release_s, 1.0f);
}

lode_status_t lode_references_tune(lode_references_tuning_t *tuning,
                                   const lode_references_config_t *config,
                                   const lode_inverter_config_t *inverter,
                                   const lode_motor_t *motor, float voltage_use, float ts_s) {
    const lode_status_t status = check(config, inverter);
    if (status != LODE_OK) {
        return status;
    }
    const bool regen = config->v_regen_V > 0.0f;
    const bool motoring = config->v_motor_V > 0.0f;
    lode_references_tuning_t t = {
        .options = options_of(config, motor),
        .fade = fade_between(config->omega_low_rad_s, config->omega_high_rad_s, true),
        .id_bias_A = lode_max(config->id_bias_A, 0.0f),
        .i_max_A = inverter->i_max_A,
        .psi_Wb = motor->psi_Wb,
        .torque_factor = lode_motor_torque_factor(motor),
        .inv_torque_factor = 1.0f / lode_motor_torque_factor(motor),
        .inv_psi2 = 1.0f / (motor->psi_Wb * motor->psi_Wb),
        .Ld_H = motor->Ld_H,
        .inv_Ld = 1.0f / motor->Ld_H,
        .Lq_H = motor->Lq_H,
        .Lq_fall = config->Lq_fall,
        .regen = fade_between(config->v_regen_V, config->v_bus_max_V, regen),
        .motor = fade_between(-config->v_motor_V, -config->v_bus_min_V, motoring),
    };
    if (!is_built_in(&t)) {
        return LODE_ERROR_REFERENCES;
    }
    t.tau_max = most_tau(&t);
    tune_weakening(&t, config, inverter, motor, voltage_use, ts_s);
    *tuning = t;
    return LODE_OK;
}

void lode_references_reset(lode_references_t *self, float id_A) {
    *self = (lode_references_t){.id_A = id_A,
                                .id_free_A = id_A,
                                .id_least_A = id_A,
                                .flux = FLUX_UNLIMITED,
                                .tau_most = FLT_MAX};
}

// id of MTPA for `tau` >= 0, the torque over the torque factor: (R3) to (R5).
LODE_INLINE float mtpa_id(const lode_references_tuning_t *tuning, float salient, float tau) {
    const float y = 4.0f * lode_abs(salient) * tau * tuning->inv_psi2;
    const float y2 = y * y;
    const float guess = 1.0f + lode_sqrt(1.0f + y2 / (4.0f + y));
    const float guess2 = guess * guess;
    const float r =
        guess - (guess2 * guess * (guess - 2.0f) - y2) / (guess2 * (4.0f * guess - 6.0f));
    const float inv_flux = 2.0f / (tuning->psi_Wb * r);
    const float iq = tau * inv_flux;
    return salient * iq * iq * inv_flux;
}

// id for the torque alone (R7).
LODE_INLINE float free_id(const lode_references_tuning_t *tuning, float salient, float tau,
                          float omega_rad_s) {
    const float bias = -tuning->id_bias_A * lode_fade(&tuning->fade, lode_abs(omega_rad_s));
#ifndef LODE_WITHOUT_OPTIMAL_REFERENCES
    if (lode_references_has(tuning, LODE_REFERENCES_LEAST_CURRENT)) {
        const float id = mtpa_id(tuning, salient, tau);
        return bias < 0.0f ? lode_min(id, bias) : id;
    }
#endif
    (void)salient;
    (void)tau;
    return bias;
}

// The last id is below the id for the torque alone.
LODE_INLINE bool is_weakening(const lode_references_t *self,
                              const lode_references_tuning_t *tuning) {
    return self->id_A < self->id_free_A - WEAKENING_SHARE * tuning->i_max_A;
}

// Flux that the voltage allows (R8), with the trim (R9) updated. An id at its minimum, or moving at a rate limit, does not
// respond to the trim.
LODE_INLINE float flux_limit(lode_references_t *self, const lode_references_tuning_t *tuning,
                             float omega_rad_s, lode_references_voltage_t voltage) {
    const float use = tuning->circle * voltage.v_bus_V;
    const lode_dq_t u = voltage.u_V;
    const float headroom = use * use - (u.d * u.d + u.q * u.q);
    const float change = is_weakening(self, tuning) ? tuning->trim_gain * headroom
                                                    : -tuning->trim_decay * self->trim;
    const bool lowest = !(self->id_A > tuning->id_min_A);
    const bool settled = !lowest && lode_abs(self->moved_A) < SETTLED_SHARE * tuning->rise_A;
    if ((settled || (lowest && change > 0.0f)) && lode_is_finite(change)) {
        self->trim = lode_clamp(self->trim + change, -TRIM_MAX, TRIM_MAX);
    }
    const float emf = use + use * self->trim - tuning->drop * self->tau * omega_rad_s;
    const float flux = emf / lode_max(lode_abs(omega_rad_s), 1.0f);
    const float most = tuning->psi_Wb + (tuning->Ld_H + tuning->Lq_H) * tuning->i_max_A;
    return lode_clamp(flux, FLUX_MIN_SHARE * tuning->psi_Wb, most);
}

// Maximum torque per volt (R13): the currents at the flux `flux`.
LODE_INLINE lode_dq_t mtpv(const lode_references_tuning_t *tuning, float Lq, float flux) {
    const float inv_Lq = 1.0f / Lq;
    const float p = tuning->psi_Wb * tuning->inv_Ld;
    const float q = 2.0f * (tuning->inv_Ld - inv_Lq) * flux;
    const float cosine = -q / (p + lode_sqrt(p * p + 2.0f * q * q));
    const float sine = lode_sqrt(1.0f - cosine * cosine);
    return (lode_dq_t){(flux * cosine - tuning->psi_Wb) * tuning->inv_Ld, flux * sine * inv_Lq};
}

// One Newton step from the last id towards the flux `flux`: (R10) inside the circle, (R11) on it.
LODE_INLINE float newton_id(const lode_references_tuning_t *tuning, float id, float Lq, float tau,
                            float flux) {
    const float salient = tuning->Ld_H - Lq;
    const float i_max = tuning->i_max_A;
    const float psi_d = tuning->psi_Wb + tuning->Ld_H * id;
    const float active = lode_references_active_flux(tuning, salient, id);
    const float excess = psi_d * psi_d - flux * flux;
    const float iq2 = i_max * i_max - id * id;
    const float active2 = active * active;
    const float slope_min = SLOPE_MIN_SHARE * 2.0f * tuning->psi_Wb * tuning->Ld_H;
    if (tau * tau >= active2 * iq2) {
        const float slope = 2.0f * (psi_d * tuning->Ld_H - Lq * Lq * id);
        return id - (excess + Lq * Lq * iq2) / lode_max(slope, slope_min);
    }
    const float slope = 2.0f * active * (psi_d * tuning->Ld_H * active + excess * salient);
    const float psi_q = Lq * tau;
    return id - (excess * active2 + psi_q * psi_q) / lode_max(slope, slope_min * active2);
}

// id for the torque alone or, where the voltage requires it, less: falls fast, rises slowly (R12).
LODE_INLINE float weakened_id(const lode_references_t *self, const lode_references_tuning_t *tuning,
                              float Lq, float tau) {
    const float before = self->id_A;
    const float high = lode_min(self->id_free_A, before + tuning->rise_A);
    const float low = lode_min(lode_max(self->id_least_A, before - tuning->fall_A), high);
    return lode_clamp(newton_id(tuning, before, Lq, tau, self->flux), low, high);
}

// Torque range that the bus allows, over the torque factor, by the sign of iq (R14).
LODE_INLINE lode_range_t bus_limits(const lode_references_tuning_t *tuning, float omega_rad_s,
                                    float v_bus_V) {
    const float most = tuning->tau_max;
    // the hint saves 5 cycles of the worst-case call of board_mtpa
    if (LODE_USUALLY(!lode_references_has(tuning, LODE_REFERENCES_FADE))) {
        return (lode_range_t){-most, most};
    }
    const float motor = most * lode_fade(&tuning->motor, -v_bus_V);
    const float regen = most * lode_fade(&tuning->regen, v_bus_V);
    return omega_rad_s < 0.0f ? (lode_range_t){-motor, regen} : (lode_range_t){-regen, motor};
}

LODE_INLINE float wanted_tau(const lode_references_tuning_t *tuning, float torque_Nm,
                             lode_range_t bus) {
    return lode_clamp(torque_Nm * tuning->inv_torque_factor, bus.min, bus.max);
}

// iq for the torque, within the current circle (K11); it waits until id leaves room in the flux limit (R12).
LODE_INLINE float iq_of(const lode_references_tuning_t *tuning, float tau, float active,
                        float iq_max, float id, float Lq, float flux) {
    const float iq = lode_min(tau / active, iq_max);
    const float psi_d = tuning->psi_Wb + tuning->Ld_H * id;
    const float psi_q = Lq * iq;
    const float headroom = FLUX_SLACK * FLUX_SLACK * flux * flux - psi_d * psi_d;
    return psi_q * psi_q <= headroom ? iq : lode_sqrt(headroom) / Lq;
}

// Lq as saturated by the iq of the last call.
static float present_Lq(const lode_references_t *self, const lode_references_tuning_t *tuning) {
#ifdef LODE_WITHOUT_OPTIMAL_REFERENCES
    (void)self;
    return tuning->Lq_H;
#else
    const bool falls = lode_references_has(tuning, LODE_REFERENCES_SATURATE);
    return falls ? Lq_at(tuning, self->iq_A) : tuning->Lq_H;
#endif
}

// Largest torque at the flux for which the voltage suffices, over the torque factor. Where a flipped bit has made it negative
// it counts no more until it is found anew: limits in the wrong order would wind speed control up.
static float tau_by_flux(const lode_references_t *self, const lode_references_tuning_t *tuning) {
    const bool counts = lode_references_weakens(tuning) && self->tau_most >= 0.0f;
    return counts ? self->tau_most : FLT_MAX;
}

// `circle`: torque that the d current leaves on the current circle. With MTPA and no weakening, id would follow a larger
// torque, so all of tau_max is available.
static float largest_tau(const lode_references_t *self, const lode_references_tuning_t *tuning,
                         float circle) {
    const bool opens =
        lode_references_has(tuning, LODE_REFERENCES_LEAST_CURRENT) && !is_weakening(self, tuning);
    return lode_min(opens ? lode_max(circle, tuning->tau_max) : circle, tau_by_flux(self, tuning));
}

#ifndef LODE_WITHOUT_OPTIMAL_REFERENCES

// The three below are not LODE_RAMFUNC: not called in every period, and too large for small fast memories.

void lode_references_find_flux(lode_references_t *self, const lode_references_tuning_t *tuning,
                               float omega_rad_s, lode_references_voltage_t voltage) {
    self->flux = flux_limit(self, tuning, omega_rad_s, voltage);
    self->tau_most = FLT_MAX;
    self->id_least_A = tuning->id_min_A;
    if (lode_references_has(tuning, LODE_REFERENCES_REACH_MTPV)) {
        const float Lq = present_Lq(self, tuning);
        const lode_dq_t point = mtpv(tuning, Lq, self->flux);
        self->tau_most = lode_references_active_flux(tuning, tuning->Ld_H - Lq, point.d) * point.q;
        self->id_least_A = lode_max(tuning->id_min_A, point.d);
    }
}

void lode_references_find_id(lode_references_t *self, const lode_references_tuning_t *tuning,
                             float torque_Nm, float omega_rad_s, float id_add_A, float v_bus_V) {
    const float salient = tuning->Ld_H - present_Lq(self, tuning);
    const lode_range_t bus = bus_limits(tuning, omega_rad_s, v_bus_V);
    const float tau = lode_abs(wanted_tau(tuning, torque_Nm, bus));
    self->id_free_A = lode_clamp(free_id(tuning, salient, tau, omega_rad_s) + id_add_A,
                                 -tuning->i_max_A, tuning->i_max_A);
}

lode_references_out_t lode_references_optimal(lode_references_t *self,
                                              const lode_references_tuning_t *tuning,
                                              float torque_Nm, float omega_rad_s, float v_bus_V) {
    const float Lq = present_Lq(self, tuning);
    const float salient = tuning->Ld_H - Lq;
    const float i_max = tuning->i_max_A;
    const lode_range_t bus = bus_limits(tuning, omega_rad_s, v_bus_V);
    const float wanted = wanted_tau(tuning, torque_Nm, bus);
    float tau = lode_abs(wanted);
    float flux = FLUX_UNLIMITED;
    float id = self->id_free_A;
    if (lode_references_weakens(tuning)) {
        flux = self->flux;
        tau = lode_min(tau, tau_by_flux(self, tuning));
        id = weakened_id(self, tuning, Lq, tau);
    }
    const float iq_max = lode_sqrt(i_max * i_max - id * id);
    const float active = lode_references_active_flux(tuning, salient, id);
    const float limit = largest_tau(self, tuning, active * iq_max);
    const float iq = iq_of(tuning, tau, active, iq_max, id, Lq, flux);
    const float signed_iq = wanted < 0.0f ? -iq : iq;
    self->moved_A = id - self->id_A;
    self->id_A = id;
    self->iq_A = signed_iq;
    self->tau = active * signed_iq;
    return (lode_references_out_t){{id, signed_iq},
                                   {tuning->torque_factor * lode_max(-limit, bus.min),
                                    tuning->torque_factor * lode_min(limit, bus.max)}};
}

#endif

float lode_references_id_A(const lode_references_tuning_t *tuning, float torque_Nm,
                           float omega_rad_s) {
    const float tau = lode_abs(torque_Nm) * tuning->inv_torque_factor;
    const float id = free_id(tuning, lode_references_salient_H(tuning),
                             lode_min(tau, tuning->tau_max), omega_rad_s);
    return lode_clamp(id, -tuning->i_max_A, tuning->i_max_A);
}

float lode_references_allowed_Nm(const lode_references_t *self,
                                 const lode_references_tuning_t *tuning, float id_A) {
    const float i_max = tuning->i_max_A;
    const float salient = tuning->Ld_H - present_Lq(self, tuning);
    const float circle =
        lode_references_active_flux(tuning, salient, id_A) * lode_sqrt(i_max * i_max - id_A * id_A);
    return tuning->torque_factor * largest_tau(self, tuning, circle);
}

float lode_references_torque_Nm(const lode_references_tuning_t *tuning, lode_dq_t i_A) {
    return tuning->torque_factor * (tuning->psi_Wb + lode_references_salient_H(tuning) * i_A.d) *
           i_A.q;
}
