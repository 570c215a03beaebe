#include "start_inline.h"

#include "inverter_inline.h"
#include "lodestar/current.h"

#define CURRENT_SHARE 0.7f  // of i_max
#define SALIENT_SHARE 0.5f  // of the current at which a salient rotor is no longer pulled
#define HANDOVER_SHARE 0.1f // of rated speed
// The EMF at hand-over over the voltage that is not modelled: of a microsecond of dead time, which comes to
// (4/pi) v_bus f_pwm times that along the current, and of 30 % of the resistance.
#define EMF_PER_UNKNOWN 2.0f
#define DEAD_TIME_UNKNOWN_s 1.0e-6f
#define RESISTANCE_UNKNOWN 0.3f
// The EMF at hand-over over the drop across the resistance, at least: errors of 2 % of a phase current's gain swing
// the drop, once measured, by as much twice per turn.
#define EMF_PER_DROP 0.25f
// Square of the hand-over speed over the largest acceleration and the share of the flux that is lost.
#define LIGHT_ROTOR 4.5f
// Lq - Ld over Lq, at least: where an error of 20 % in Lq is 0.55 of Lq - Ld, it counts as much as in a rotor of that
// saliency, however little is configured.
#define LIGHT_UNSURE 0.36f
#define HANDOVER_SHARE_MAX                                                                         \
    0.5f // of rated or base speed: beyond, too little of the speed range is left
// Of the hand-over speed, to which noise of the currents may raise it: a rotor that slips at twice that looks to (S43)
// like sensors that fail.
#define NOISE_MOST 2.5f
#define RAMP_TORQUE_SHARE 0.1f // ten times the inertia takes it all
// Share of the ramp that the vector has: this, times its speed and a 64th of the hand-over speed, over the hand-over
// speed (S35). By default a sixteenth at rest; of a ramp that is given all of it.
#define STEEPENS 4.0f
#define STEEP 64.0f
#define GENTLE_SHARE 0.46f // (ln 16 - 15/16)/4: what the default adds to a ramp, at most
#define RISE_TIME_s 0.2f
// Past a rotor whose axis no pulse shows the vector sweeps while the current rises. It takes so much of the rotor's swing, up to
// this time: one with ten times its inertia then swings less about the vector (S29).
#define RISE_rad 35.0f
#define RISE_TIME_MAX_s 0.4f
#define DAMPING 0.5f
#define LOCK_TIME_s 0.1f
#define CATCH_TIME_s 0.05f // the estimator needs 20 to 30 ms from a reset to a sure lock
#define CATCH_PARTS 5u     // the lock must hold for this part of the time
#define FADE_TIME_s 0.1f
#define SALIENT_TIME_SHARE 0.5f // of lock and fade, where reluctance bounds the start current
#define LOST_UNSURE 1.2f // flux that the current may take of a rotor whose Lq - Ld is 20 % off
#define LOCK_TURNS 2.0f  // electrical
#define PATIENCE_s 0.4f
#define TIMEOUT_MAX_s 1000.0f
// Of the start current, in the last attempt; from CURRENT_SHARE of i_max up to i_max. A rotor that needs so much is
// loaded, and lags by so much that reluctance adds to its torque.
#define CURRENT_LAST 2.0f
// Of the current, by the end of an attempt at speed without a lock, and of twice the start current at most: what is left of
// that takes less than a third of a salient rotor's flux.
#define CURRENT_LEFT 0.3f
#define ROUNDS_MAX 2.0e9f // inside an int32
#define COUNTER_MAX 65535.0f
// Of the vector while the current rises (S29): all of it, or from half of the current on, where it is measured there.
#define SWEEP_rad (LODE_TWO_PI * 240.0f / 360.0f)
#define SWEEP_SECOND_rad (LODE_TWO_PI * 60.0f / 360.0f)
#define MEAN_CORNER 0.3f  // of the mean EMF, over the swing's natural frequency
#define SWING_CORNER 3.0f // of its deviation: above, an error in Lq would close a loop
// Gain that is left to the loop of the shift: a moving vector moves d current, and so active flux, in a salient
// rotor, which shows as EMF as the swing does (S15).
#define SHIFT_LOOP 1.0f
// Gain of the shift by the rotor's angle, which a loaded rotor's EMF shows too, at speed more than its swing (S16).
#define SHIFT_STIFFENS 2.0f
// Share of the EMF's size in the swing, at least: at 90 degrees of lag, where a rotor is that needs so much current,
// what the size and the EMF across the vector show of the angle cancels at 1/(1 + c), with c about 1.
#define BY_SIZE_MIN 0.5f
// In the last attempt, of a vector that takes at most all of the flux (a hundredth more is rounding), a round with a
// lock counts as so many, and the speed may be so many times as far off the vector's (S32).
#define LOST_LAST 1.01f
#define WEIGHT_LAST 2u
// Of the EMF of a rotor that follows: one that is as slow as (S8) allows has 0.75 of it, with magnets and current sensors that are
// a tenth off each 0.6. The current takes up to SLIP_LOST of what the configured inductances say of the flux, with both inductances 20 %
// off; where less than SLIP_FLUX is left a rotor that follows is not known from one that does not (S42).
#define SLIP_SHARE 0.6f
#define SLIP_LOST 1.4f
#define SLIP_FLUX 0.2f
// A rotor slips that lacks this EMF for so much of the patience, and so many radians of its swing: half of one with ten times
// the inertia.
#define SLIP_PART 2u
#define SLIP_rad 10.0f
#define SLIPS_MAX 65535u
// Times the current: beyond the 1/CURRENT_SHARE that the last attempt has of it where no reluctance bounds the start current.
#define MUCH_MORE 1.5f

// Measuring resistance and dead time: mean of 20 ms in which the rotor rests, after 10 ms in which observer and
// current settle; of one that does not come to rest in 0.15 s the mean of its swing.
#define CALM_PART 20u // of the patience
#define DWELL_TIME_s 0.15f
#define MEASUREMENTS 2.0f // with half the current and with all of it
#define SETTLE_PART 15u   // of the dwell
#define CALM_SHARE 0.1f   // of the voltage that is not known
// What a voltage along the vector may be off its mean, in the first half of the dwell and in the second, in calm
// voltages; and the time for which it must be, where the rotor does not come to rest: twice that of a calm mean, and so
// many radians of the swing, in which a rotor that falls passes the right angle (S30).
#define STEADY_EARLY 0.5f
#define STEADY_LATE 2.0f
#define STEADY_TIMES 2u
#define STEADY_rad 2.0f
#define LEVEL_SHARE 0.5f
// Where one current alone is measured with, half of its voltage counts as resistance's, the other half as dead time's.
#define HALF_OF_FULL 0.75f
#define FULL_OF_HALF 1.5f
#ifdef LODE_WITHOUT_START_MEASUREMENT
#define MEASURES LODE_OFF
#else
#define MEASURES LODE_ON
#endif

// Torque per electrical radian between rotor and vector, Nm/rad.
static float stiffness(float current_A, const lode_motor_t *motor) {
    return current_A * lode_motor_kt_Nm_A(motor);
}

// Reluctance pulls a rotor with Lq > Ld across the vector, in the end more than the magnets along it.
static float default_current_A(const lode_motor_t *motor, float i_max_A) {
    const float lost_A = motor->psi_Wb / lode_max(motor->Lq_H - motor->Ld_H, FLT_MIN);
    return lode_min(CURRENT_SHARE * i_max_A, SALIENT_SHARE * lost_A);
}

// Rotor and vector make a spring of stiffness K, natural frequency wn = sqrt(np K/J), rad/s.
static float swing_rad_s(float current_A, const lode_motor_t *motor) {
    return lode_sqrt(motor->pole_pairs * stiffness(current_A, motor) /
                     lode_max(motor->J_kgm2, FLT_MIN));
}

static float default_rise_s(const lode_motor_t *motor, float current_A) {
    const float swing = lode_max(swing_rad_s(current_A, motor), FLT_MIN);
    const float most = motor->Lq_H > motor->Ld_H ? RISE_TIME_s : RISE_TIME_MAX_s;
    return lode_clamp(RISE_rad / swing, RISE_TIME_s, most);
}

static float ramp_s(const lode_start_config_t *config) {
    return config->omega_handover_rad_s / lode_max(config->ramp_rad_s2, FLT_MIN);
}

// Electrical.
static float default_ramp_rad_s2(const lode_motor_t *motor, float current_A) {
    const float torque = RAMP_TORQUE_SHARE * stiffness(current_A, motor);
    return torque / lode_max(motor->J_kgm2, FLT_MIN) * motor->pole_pairs;
}

// A ramp that is given is meant from its beginning.
static bool begins_gently(const lode_start_config_t *config, const lode_motor_t *motor) {
    const float own = default_ramp_rad_s2(motor, config->current_A);
    return lode_in_range(config->ramp_rad_s2, own, own);
}

// What that adds to a ramp, at most.
static float gentle_s(const lode_start_config_t *config, const lode_motor_t *motor) {
    return begins_gently(config, motor) ? GENTLE_SHARE * ramp_s(config) : 0.0f;
}

static float dwell_s(const lode_start_config_t *config) {
    return config->measure == LODE_ON ? MEASUREMENTS * DWELL_TIME_s : 0.0f;
}

static float sweep_rad_s(const lode_start_config_t *config) {
    const float rad = config->measure == LODE_ON ? SWEEP_SECOND_rad / LEVEL_SHARE : SWEEP_rad;
    return rad / config->current_rise_s;
}

// What the profile takes, and as long again, at least 0.4 s, for the rotor to settle and the lock to come.
static float attempt_s(const lode_start_config_t *config, const lode_motor_t *motor, float ease) {
    const float ramps_s = ramp_s(config) / ease + gentle_s(config, motor);
    const float profile_s = config->current_rise_s + dwell_s(config) + ramps_s + config->lock_s;
    return profile_s + lode_max(profile_s, PATIENCE_s);
}

static float drop_V(const lode_motor_t *motor, const lode_inverter_config_t *inverter,
                    float current_A) {
    return (motor->Rs_Ohm + inverter->r_on_Ohm) * current_A;
}

// Voltage along the start current that no model has.
static float unknown_V(const lode_motor_t *motor, const lode_inverter_config_t *inverter,
                       float current_A, float ts_s) {
    const float carrier_Hz = lode_inverter_carrier_Hz(inverter, 1.0f / ts_s);
    const float dead_time_V = FOUR_PER_PI * inverter->v_bus_V * DEAD_TIME_UNKNOWN_s * carrier_Hz;
    return dead_time_V + RESISTANCE_UNKNOWN * drop_V(motor, inverter, current_A);
}

// Electrical speed at which the largest current, in a warm winding, and the EMF use up the bus.
static float base_omega(const lode_motor_t *motor, const lode_inverter_config_t *inverter) {
    const float u_V = LODE_VOLTAGE_USE * inverter->v_bus_V / LODE_SQRT3;
    const float warm_V = (1.0f + RESISTANCE_UNKNOWN) * drop_V(motor, inverter, inverter->i_max_A);
    const float psi_q = motor->Lq_H * inverter->i_max_A;
    const float flux2 = motor->psi_Wb * motor->psi_Wb + psi_q * psi_q;
    const float half = warm_V * motor->psi_Wb;
    const float left_V2 = lode_max(u_V * u_V - warm_V * warm_V, 0.0f);
    return (lode_sqrt(half * half + flux2 * left_V2) - half) / lode_max(flux2, FLT_MIN);
}

// A load step must not stop the rotor before the PLL has seen it. An error of Lq - Ld turns the angle the more
// the lower the speed, and holds the PLL's bandwidth to some omega psi/((Lq - Ld) I): so the speed of hand-over
// must be high where the rotor is light (S18).
static float omega_of_light_rotor(const lode_motor_t *motor, const lode_inverter_config_t *inverter,
                                  float current_A) {
    const float unsure_H =
        lode_max(lode_abs(motor->Lq_H - motor->Ld_H), LIGHT_UNSURE * motor->Lq_H);
    const float lost = unsure_H * current_A / lode_max(motor->psi_Wb, FLT_MIN);
    const float acc_rad_s2 =
        motor->omega_rated_rad_s / lode_max(lode_motor_run_up_s(motor, inverter->i_max_A), FLT_MIN);
    return lode_sqrt(LIGHT_ROTOR * lost * acc_rad_s2);
}

// Electrical speed from which the EMF stands out of the voltage that is not modelled (S12).
static float omega_of_emf(const lode_motor_t *motor, const lode_inverter_config_t *inverter,
                          float current_A, float ts_s) {
    return EMF_PER_UNKNOWN * unknown_V(motor, inverter, current_A, ts_s) /
           lode_max(motor->psi_Wb, FLT_MIN);
}

// Electrical speed from which the EMF stands out of what the current sensors' errors leave of the drop.
static float seen_omega(const lode_motor_t *motor, const lode_inverter_config_t *inverter,
                        float current_A) {
    return EMF_PER_DROP * drop_V(motor, inverter, current_A) / lode_max(motor->psi_Wb, FLT_MIN);
}

// The highest speed of a hand-over.
static float most_omega(const lode_motor_t *motor, const lode_inverter_config_t *inverter) {
    return HANDOVER_SHARE_MAX * lode_min(motor->omega_rated_rad_s, base_omega(motor, inverter));
}

static float within_speeds(float omega_rad_s, const lode_motor_t *motor,
                           const lode_inverter_config_t *inverter, float current_A) {
    const float least =
        lode_max(HANDOVER_SHARE * motor->omega_rated_rad_s, seen_omega(motor, inverter, current_A));
    return lode_clamp(omega_rad_s, least, lode_max(most_omega(motor, inverter), least));
}

bool lode_start_has_emf(const lode_start_config_t *config, const lode_inverter_config_t *inverter,
                        const lode_motor_t *motor) {
    return seen_omega(motor, inverter, config->current_A) <= most_omega(motor, inverter);
}

static float default_handover(const lode_motor_t *motor, const lode_inverter_config_t *inverter,
                              float current_A, float ts_s) {
    const float by_emf = omega_of_emf(motor, inverter, current_A, ts_s);
    const float by_rotor = omega_of_light_rotor(motor, inverter, current_A);
    return within_speeds(lode_max(by_emf, by_rotor), motor, inverter, current_A);
}

// A speed that is given is meant.
static bool is_own_handover(const lode_start_config_t *config,
                            const lode_inverter_config_t *inverter, const lode_motor_t *motor,
                            float ts_s) {
    const float own = default_handover(motor, inverter, config->current_A, ts_s);
    return lode_in_range(config->omega_handover_rad_s, own, own);
}

// The angle can be seen from this speed on: a vector on its way to a speed that only load steps ask for need
// not arrive.
static float omega_ready(const lode_start_config_t *config, const lode_inverter_config_t *inverter,
                         const lode_motor_t *motor, float ts_s) {
    const float by_emf = within_speeds(omega_of_emf(motor, inverter, config->current_A, ts_s),
                                       motor, inverter, config->current_A);
    return is_own_handover(config, inverter, motor, ts_s) ? by_emf : config->omega_handover_rad_s;
}

// A rotor with too little flux left for (S8) is handed over while its vector gives way, and where the load swings within
// every turn of the shaft, in a part of the turn.
static float default_lock_s(const lode_start_config_t *config, const lode_motor_t *motor,
                            float time_share) {
    const float lost = (motor->Lq_H - motor->Ld_H) * config->current_A;
    const bool waits = LOST_UNSURE * lost > LODE_START_LOST_MAX * motor->psi_Wb;
    const float turns_s =
        LOCK_TURNS * LODE_TWO_PI / lode_max(config->omega_handover_rad_s, FLT_MIN);
    const float by_turns =
        lode_clamp(turns_s, SALIENT_TIME_SHARE * LOCK_TIME_s, time_share * LOCK_TIME_s);
    return waits ? by_turns : time_share * LOCK_TIME_s;
}

void lode_start_design(lode_start_config_t *config, const lode_inverter_config_t *inverter,
                       const lode_motor_t *motor, float ts_s) {
    // A current that is configured applies to every attempt.
    const float own_A = default_current_A(motor, inverter->i_max_A);
    const float last_A =
        lode_clamp(CURRENT_LAST * own_A, CURRENT_SHARE * inverter->i_max_A, inverter->i_max_A);
    config->current_last_A =
        lode_given_or(config->current_last_A, lode_given_or(config->current_A, last_A));
    config->current_A = lode_given_or(config->current_A, own_A);
    config->omega_handover_rad_s = lode_given_or(
        config->omega_handover_rad_s, default_handover(motor, inverter, config->current_A, ts_s));
    const float time_share = own_A < CURRENT_SHARE * inverter->i_max_A ? SALIENT_TIME_SHARE : 1.0f;
    config->ramp_rad_s2 =
        lode_given_or(config->ramp_rad_s2, default_ramp_rad_s2(motor, config->current_A));
    config->current_rise_s =
        lode_given_or(config->current_rise_s, default_rise_s(motor, config->current_A));
    config->damping = lode_given_or(config->damping, DAMPING);
    config->lock_s = lode_given_or(config->lock_s, default_lock_s(config, motor, time_share));
    config->catch_s = lode_given_or(config->catch_s, CATCH_TIME_s);
    config->fade_s = lode_given_or(config->fade_s, time_share * FADE_TIME_s);
    if (config->measure == LODE_AUTO) {
        config->measure = MEASURES;
    }
    const float attempts_s = attempt_s(config, motor, 1.0f) +
                             attempt_s(config, motor, LODE_START_EASE) +
                             attempt_s(config, motor, LODE_START_EASE_LAST);
    config->timeout_s =
        lode_given_or(config->timeout_s, lode_min(attempts_s + config->align_s, TIMEOUT_MAX_s));
}

static lode_status_t check(const lode_start_config_t *config,
                           const lode_inverter_config_t *inverter, float omega_max_rad_s,
                           float ts_s) {
    if (!lode_in_range(config->current_A, 1.0e-3f * inverter->i_max_A, inverter->i_max_A) ||
        !lode_in_range(config->current_last_A, config->current_A, inverter->i_max_A)) {
        return LODE_ERROR_START_CURRENT;
    }
    if (!lode_in_range(config->omega_handover_rad_s, 1.0e-3f * omega_max_rad_s, omega_max_rad_s)) {
        return LODE_ERROR_START_SPEED;
    }
    const float longest_s = lode_min(10.0f, COUNTER_MAX * (float)LODE_SLOW_PERIODS * ts_s);
    if (!lode_in_range(config->ramp_rad_s2, 1.0e-3f, 1.0e7f) ||
        !lode_in_range(config->current_rise_s, ts_s, 100.0f) ||
        !(lode_is_none(config->catch_s) || lode_in_range(config->catch_s, 0.0f, longest_s)) ||
        !lode_in_range(config->align_s, 0.0f, longest_s) ||
        !lode_in_range(config->lock_s, ts_s, longest_s) ||
        !lode_in_range(config->fade_s, ts_s, 10.0f) ||
        !lode_in_range(config->timeout_s, config->lock_s, TIMEOUT_MAX_s)) {
        return LODE_ERROR_START_RAMP;
    }
    if (config->measure != MEASURES && config->measure != LODE_OFF) {
        return LODE_ERROR_CHOICE;
    }
    if (!(lode_is_none(config->damping) || lode_in_range(config->damping, 0.0f, 2.0f))) {
        return LODE_ERROR_START_DAMPING;
    }
    return LODE_OK;
}

// To the nearest; 0 only for no time at all.
static uint32_t rounds_in(float time_s, float ts_s) {
    const float rounds = time_s / ((float)LODE_SLOW_PERIODS * ts_s);
    const float least = time_s > 0.0f ? 1.0f : 0.0f;
    return (uint32_t)(int32_t)lode_clamp(rounds + 0.5f, least, ROUNDS_MAX);
}

lode_status_t lode_start_tune(lode_start_tuning_t *tuning, const lode_start_config_t *config,
                              const lode_inverter_config_t *inverter, const lode_motor_t *motor,
                              float omega_max_rad_s, float ts_s) {
    const lode_status_t status = check(config, inverter, omega_max_rad_s, ts_s);
    if (status != LODE_OK) {
        return status;
    }
    // A vector that gives way by 2 zeta/wn per rad/s of the rotor's swing damps it with the ratio zeta: torque K times
    // that angle. The swing shows as EMF across the vector, psi volts per rad/s, at standstill too.
    const float swing = swing_rad_s(config->current_A, motor);
    const float round_s = (float)LODE_SLOW_PERIODS * ts_s;
    *tuning = (lode_start_tuning_t){
        .current_A = config->current_A,
        .current_step = config->current_A * ts_s / config->current_rise_s,
        .omega_handover = config->omega_handover_rad_s,
        .omega_ready = omega_ready(config, inverter, motor, ts_s),
        .sweep_step_rad = sweep_rad_s(config) * ts_s,
        .omega_step = config->ramp_rad_s2 * ts_s,
        .steepens =
            (begins_gently(config, motor) ? STEEPENS : STEEP) / config->omega_handover_rad_s,
        .damping = 2.0f * lode_max(config->damping, 0.0f) / (swing * motor->psi_Wb),
        .damping_A = SHIFT_LOOP / (SWING_CORNER * swing *
                                   lode_max(lode_abs(motor->Lq_H - motor->Ld_H), FLT_MIN)),
        .damping_rad_s = SHIFT_STIFFENS / motor->psi_Wb,
        .lost_per_A = lode_abs(motor->Lq_H - motor->Ld_H) / motor->psi_Wb,
        .mean_weight = lode_one_minus_exp(MEAN_CORNER * swing * ts_s),
        .swing_weight = lode_one_minus_exp(SWING_CORNER * swing * ts_s),
        .fade_step = ts_s / config->fade_s,
        .catch_rounds = (uint_least16_t)rounds_in(lode_max(config->catch_s, 0.0f), ts_s),
        .lock_rounds = (uint_least16_t)rounds_in(config->lock_s, ts_s),
        .current_last_A = config->current_last_A,
        .still_rounds =
            (config->current_rise_s + dwell_s(config) + gentle_s(config, motor) + config->lock_s) /
            round_s,
        .align_rounds = lode_min(config->align_s / round_s, COUNTER_MAX),
        .timeout_rounds = rounds_in(config->timeout_s, ts_s),
        .patience_rounds = (uint_least16_t)rounds_in(PATIENCE_s, ts_s),
#ifndef LODE_WITHOUT_PLAUSIBILITY
        .omega_most = is_own_handover(config, inverter, motor, ts_s)
                          ? lode_clamp(most_omega(motor, inverter), config->omega_handover_rad_s,
                                       NOISE_MOST * config->omega_handover_rad_s)
                          : config->omega_handover_rad_s,
#endif
#ifndef LODE_WITHOUT_START_MEASUREMENT
        .dwell_rounds =
            config->measure == LODE_ON ? (uint_least16_t)rounds_in(DWELL_TIME_s, ts_s) : 0u,
        .calm_V = CALM_SHARE * unknown_V(motor, inverter, config->current_A, ts_s),
#endif
    };
    return LODE_OK;
}

// What is seen of the stage before is forgotten.
static void enter(lode_start_t *self, uint_least8_t stage) {
    self->stage = stage;
#ifndef LODE_WITHOUT_PLAUSIBILITY
    self->drop = (lode_drop_t){.rounds = 0u};
#endif
    if (stage == (uint_least8_t)LODE_START_TURN) {
#ifndef LODE_WITHOUT_PLAUSIBILITY // which alone looks at what turns
        self->seen.turn.waves = (lode_waves_t){.turn_rad = 0.0f};
        self->seen.turn.shift_rad = lode_start_shift_rad(self);
#endif
    } else {
        self->seen.rest = (lode_start_rest_t){.sum_V = 0.0f};
    }
}

void lode_start_reset(lode_start_t *self, lode_sincos_t at, float omega_rad_s, float current_A) {
    *self = (lode_start_t){.at = at,
                           .omega_rad_s = omega_rad_s,
                           .current_A = current_A,
                           .omega_target = omega_rad_s,
                           .current_target = current_A};
    enter(self, (uint_least8_t)LODE_START_TURN);
}

// After the measurement, if there is one (S47).
static uint_least8_t last_stage(const lode_start_tuning_t *tuning) {
    return (uint_least8_t)(tuning->align_rounds > 0.0f ? LODE_START_ALIGN : LODE_START_TURN);
}

// Without looking for a rotor that turns.
static uint_least8_t first_stage(const lode_start_tuning_t *tuning) {
#ifndef LODE_WITHOUT_START_MEASUREMENT
    if (tuning->dwell_rounds > 0u) {
        return (uint_least8_t)LODE_START_HALF;
    }
#endif
    return last_stage(tuning);
}

void lode_start_begin(lode_start_t *self, const lode_start_tuning_t *tuning) {
    lode_start_reset(self, (lode_sincos_t){0.0f, 1.0f}, 0.0f, 0.0f);
    self->attempt = tuning->catch_rounds;
    enter(self, self->attempt > 0u ? (uint_least8_t)LODE_START_CATCH : first_stage(tuning));
}

void lode_start_lead(lode_start_t *self, lode_sincos_t axis, float direction) {
    const lode_sincos_t ahead = {lode_sign(direction) * 0.5f * LODE_SQRT3, -0.5f}; // 120 degrees
    self->at = lode_angle_add(axis, ahead);
    self->stands = 1u;
}

static float profile_rounds(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    const float step = lode_start_ease(self) * tuning->omega_step;
    const float omega = lode_max(lode_abs(self->omega_target), tuning->omega_handover);
    return tuning->still_rounds + omega / ((float)LODE_SLOW_PERIODS * step);
}

// After the profile.
static float waiting_rounds(const lode_start_tuning_t *tuning, float profile) {
    return lode_max(profile, (float)tuning->patience_rounds);
}

float lode_start_waited(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    const float profile = profile_rounds(self, tuning);
    const float late = (float)(int32_t)self->attempt - profile;
    return lode_clamp(late / waiting_rounds(tuning, profile), 0.0f, 1.0f);
}

// Of the current of an attempt what it takes now: the half that is measured with, all of it, and of a vector at speed
// that finds no lock less and less (S17).
static float current_now_A(const lode_start_t *self, const lode_start_tuning_t *tuning,
                           float most_A) {
#ifndef LODE_WITHOUT_START_MEASUREMENT
    if (self->stage == (uint_least8_t)LODE_START_HALF) {
        return LEVEL_SHARE * most_A;
    }
#endif
    if (lode_abs(self->omega_rad_s) < tuning->omega_handover) {
        return most_A;
    }
    const float left_A = CURRENT_LEFT * lode_min(most_A, CURRENT_LAST * tuning->current_A);
    return most_A - lode_start_waited(self, tuning) * (most_A - left_A);
}

// Radians of the rotor's swing, with the configured inertia, in so many rounds. The weight of the swing's filter is nearly its
// corner times a period.
static float swung_rad(const lode_start_tuning_t *tuning, float rounds) {
    return rounds * (float)LODE_SLOW_PERIODS / SWING_CORNER * tuning->swing_weight;
}

static bool slips(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    return SLIP_PART * (uint32_t)self->slips > tuning->patience_rounds &&
           swung_rad(tuning, (float)(int32_t)self->slips) >= SLIP_rad;
}

void lode_start_note_slip(lode_start_t *self, const lode_start_tuning_t *tuning,
                          const lode_estimator_t *estimator,
                          const lode_estimator_tuning_t *estimator_tuning) {
    const float vector = lode_sign(self->omega_target) * self->omega_rad_s;
    const float left = 1.0f - SLIP_LOST * tuning->lost_per_A * self->current_A;
    if (!(vector >= tuning->omega_ready && left >= SLIP_FLUX)) {
        return;
    }
    // What the observer takes of the amplitude of an EMF that turns with the vector.
    const float taken = 1.0f + vector * vector * estimator_tuning->droop_s2;
    const float emf_V = taken * lode_ab_length(estimator->emf.observer.e_V);
    if (!(emf_V >= SLIP_SHARE * left * vector * estimator_tuning->psi_Wb)) {
        self->slips = (uint_least16_t)(self->slips < SLIPS_MAX ? self->slips + 1u : SLIPS_MAX);
    } else if (self->slips > 0u) {
        self->slips--;
    } else {
        // it follows
    }
}

bool lode_start_is_lost(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    return self->failed >= LODE_START_FAILED_MAX && slips(self, tuning);
}

// Counts a round. True: the attempt has had its time, or the rotor slips.
static bool is_spent(lode_start_t *self, const lode_start_tuning_t *tuning) {
    if (!(lode_abs(self->omega_target) > 0.0f)) {
        self->attempt = 0u;
        self->slips = 0u;
        return false;
    }
    self->attempt++;
    const float rounds = (float)(int32_t)self->attempt;
    if (rounds <= tuning->still_rounds) {
        return false; // the profile alone takes longer; spares a division
    }
    if (slips(self, tuning)) {
        return true;
    }
    const float profile = profile_rounds(self, tuning);
    return rounds > profile + waiting_rounds(tuning, profile);
}

// A rotor that fell out of step with the turning vector only shakes: the next attempt begins at rest, on a phase for
// the measurement, and 120 degrees on from where the first one began (S41). If it slipped, and the last attempt's current is much more,
// it has that at once (S42).
void lode_start_again(lode_start_t *self, const lode_start_tuning_t *tuning) {
    const bool much = tuning->current_last_A > MUCH_MORE * tuning->current_A;
    self->more = much && slips(self, tuning) ? 1u : 0u;
    self->attempt = 0u;
    self->slips = 0u;
    self->at = (lode_sincos_t){lode_sign(self->omega_target) * 0.5f * LODE_SQRT3, -0.5f};
    self->omega_rad_s = 0.0f;
    self->current_A = 0.0f;
    self->stands = 0u; // the rotor is anywhere now
    self->failed = self->failed == 0u ? 1u : LODE_START_FAILED_MAX;
    enter(self, first_stage(tuning));
}

#ifndef LODE_WITHOUT_START_MEASUREMENT

// (S13), (S14): from the voltages along half and all of the current.
static lode_start_found_t found_at_rest(const lode_start_t *self) {
    const float mean_V = self->seen.rest.sum_V;
    const float r_Ohm =
        (mean_V - self->seen.rest.along_V) / ((1.0f - LEVEL_SHARE) * self->current_A);
    return (lode_start_found_t){.r_Ohm = r_Ohm, .dead_V = mean_V - r_Ohm * self->current_A};
}

// One round's voltage, in the axis at which the vector waits. Resistance shows along the current, dead time along the phase
// of the axis, whatever the damping adds to that. A rotor that falls past a right angle to the vector shows nothing
// across it, but along it, and ever more: then the sum begins anew. In the second half of the dwell it takes the ripple of
// a swing for no such change (S30).
static void add_at_rest(lode_start_rest_t *rest, const lode_start_tuning_t *tuning,
                        lode_dq_t axis_V) {
    const bool late = rest->dwelt > tuning->dwell_rounds / 2u;
    const float steady_V = (late ? STEADY_LATE : STEADY_EARLY) * tuning->calm_V;
    if (lode_abs(axis_V.d * rest->summed - rest->sum_V) > steady_V * rest->summed) {
        rest->sum_V = 0.0f;
        rest->summed = 0.0f;
        rest->calm = 0u;
    }
    rest->sum_V += axis_V.d;
    rest->summed += 1.0f;
    rest->calm = (uint_least16_t)(rest->calm + (lode_abs(axis_V.q) <= tuning->calm_V ? 1u : 0u));
}

// The voltage with the present current is known, or is not: the rotor has its time to come to rest at both, as it is
// all of the current that it is to follow. Of the current at which it did not, the voltage follows from that of the
// other one (S33).
static LODE_NOINLINE void end_dwell(lode_start_t *self, const lode_start_tuning_t *tuning,
                                    bool known) {
    lode_start_rest_t *rest = &self->seen.rest;
    const float mean_V = rest->sum_V / lode_max(rest->summed, 1.0f);
    if (self->stage == (uint_least8_t)LODE_START_HALF) {
        enter(self, (uint_least8_t)(known ? LODE_START_FULL : LODE_START_ALONE));
        rest->along_V = mean_V;
    } else if (known || self->stage == (uint_least8_t)LODE_START_FULL) {
        rest->sum_V = known ? mean_V : FULL_OF_HALF * rest->along_V;
        if (self->stage == (uint_least8_t)LODE_START_ALONE) {
            rest->along_V = HALF_OF_FULL * mean_V;
        }
        self->stage = (uint_least8_t)LODE_START_FOUND;
    } else {
        enter(self, last_stage(tuning));
    }
}

// The mean of a swing is known.
static bool is_steady(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    const float summed = self->seen.rest.summed;
    const uint32_t least = STEADY_TIMES * (tuning->patience_rounds / CALM_PART);
    return summed >= (float)least && swung_rad(tuning, summed) >= STEADY_rad;
}

// One round with the present current. What it makes known is worked out in the next round, by a call of its own.
static void watch_at_rest(lode_start_t *self, const lode_start_tuning_t *tuning, lode_ab_t e_V) {
    lode_start_rest_t *rest = &self->seen.rest;
    rest->dwelt++;
    if (SETTLE_PART * rest->dwelt > tuning->dwell_rounds) {
        add_at_rest(rest, tuning, lode_park(e_V, self->at));
    }
    const bool calm = CALM_PART * (rest->calm + 1u) > tuning->patience_rounds;
    if (calm || rest->dwelt >= tuning->dwell_rounds) {
        end_dwell(self, tuning, calm || is_steady(self, tuning));
    }
}

bool lode_start_measure(lode_start_t *self, const lode_start_tuning_t *tuning, lode_ab_t e_V,
                        lode_start_found_t *found) {
    if (self->stage == (uint_least8_t)LODE_START_FOUND) {
        *found = found_at_rest(self);
        enter(self, last_stage(tuning));
        return true;
    }
    if (self->stage < (uint_least8_t)LODE_START_ALIGN && self->current_A > 0.0f &&
        !(self->current_A < self->current_target)) {
        watch_at_rest(self, tuning, e_V);
    }
    return false;
}

#endif

// Share of the steepest ramp that the vector has now (S35). A rotor that is stopped has followed it.
static float ramp_share(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    const float ease = lode_start_ease(self);
#ifdef LODE_WITHOUT_GENTLE_START
    (void)tuning;
    return ease;
#else
    const float at_rest = tuning->omega_handover * (1.0f / STEEP);
    const float gentle = tuning->steepens * (at_rest + lode_abs(self->omega_rad_s));
    return lode_abs(self->omega_target) > 0.0f ? lode_min(ease, gentle) : ease;
#endif
}

// Counts a round in which the vector stands at its axis with all of its current, which is none of the attempt's time; of the
// first attempt alone (S47).
static bool aligns(lode_start_t *self, const lode_start_tuning_t *tuning) {
    if (self->stage != (uint_least8_t)LODE_START_ALIGN || self->current_A < self->current_target) {
        return false;
    }
    lode_start_rest_t *rest = &self->seen.rest;
    rest->dwelt++;
    if (self->failed > 0u || (float)rest->dwelt >= tuning->align_rounds) {
        enter(self, (uint_least8_t)LODE_START_TURN);
    }
    return true;
}

bool lode_start_aim(lode_start_t *self, const lode_start_tuning_t *tuning, float omega_target_rad_s,
                    float current_A) {
    float most_A = current_A;
    self->omega_target = omega_target_rad_s;
    if (current_A > 0.0f) {
        const bool more = self->failed >= LODE_START_FAILED_MAX || self->more != 0u;
        most_A = more ? tuning->current_last_A : current_A;
    } else {
        self->stands = 0u;
        if (self->stage < (uint_least8_t)LODE_START_TURN) {
            enter(self, (uint_least8_t)LODE_START_TURN); // a stop ends what is done at rest
        }
    }
    self->current_target = current_now_A(self, tuning, most_A);
    self->omega_step = tuning->omega_step * ramp_share(self, tuning);
    self->at =
        lode_angle_normalise(self->at); // what the periods in between have left of its length
    const float most =
        lode_min(tuning->damping_A / lode_max(self->current_A, FLT_MIN),
                 tuning->damping_rad_s / lode_max(lode_abs(self->omega_rad_s), FLT_MIN));
    self->give = lode_min(tuning->damping, most);
    const float speed = self->omega_rad_s / (LODE_START_HOLD * tuning->omega_ready);
    self->by_size = lode_clamp(speed, -1.0f, 1.0f) *
                    lode_max(1.0f - tuning->lost_per_A * self->current_A, BY_SIZE_MIN);
    return !aligns(self, tuning) && is_spent(self, tuning);
}

// What a round with a lock counts on the vector. A lock that goes again is no worse than none where no attempt is
// left (S32).
static uint32_t lock_weight(const lode_start_t *self, const lode_start_tuning_t *tuning) {
#ifndef LODE_WITHOUT_HANDOVER_RETRY
    if (self->failed >= LODE_START_FAILED_MAX && !lode_start_catches(self) &&
        tuning->lost_per_A * tuning->current_last_A <= LOST_LAST) {
        return WEIGHT_LAST;
    }
#else
    (void)self;
    (void)tuning;
#endif
    return 1u;
}

void lode_start_judge(lode_start_t *self, const lode_start_tuning_t *tuning, float omega_rad_s,
                      float lock) {
    const bool catching = lode_start_catches(self);
    const float slack = lode_start_slack(self, tuning);
    const uint32_t weight = lock_weight(self, tuning);
    const bool arrived = lode_start_follows(self, tuning, omega_rad_s, (float)weight * slack);
    const bool sound = (catching || arrived) && lock >= LODE_LOCK_HANDOVER &&
                       lode_abs(omega_rad_s) >= tuning->omega_ready - slack;
    self->locked = (uint_least16_t)(sound ? self->locked + weight : 0u);
    if (catching && self->attempt > 1u) {
        self->attempt--;
    } else if (catching) { // the vector begins
        self->attempt = 0u;
        self->locked = 0u;
        enter(self, first_stage(tuning));
    } else {
        // on the vector
    }
}

bool lode_start_is_ready(const lode_start_t *self, const lode_start_tuning_t *tuning) {
    const uint32_t caught = tuning->catch_rounds / CATCH_PARTS + 1u;
    return self->locked >= (lode_start_catches(self) ? caught : tuning->lock_rounds);
}

static lode_start_unmet_t unmet(lode_criterion_t criterion, float measured, float limit) {
    return (lode_start_unmet_t){criterion, measured, limit};
}

// In how many of the `rounds` that are needed it was so, as times.
static lode_start_unmet_t unmet_for(lode_criterion_t criterion, uint32_t rounds, uint32_t needed,
                                    float round_s) {
    const float measured_s = (float)(int32_t)rounds * round_s;
    const float limit_s = (float)(int32_t)needed * round_s;
    return unmet(criterion, measured_s, limit_s);
}

// While the vector waits with all of its current, for rounds of `round_s`.
static lode_start_unmet_t unmet_at_rest(const lode_start_t *self, const lode_start_tuning_t *tuning,
                                        float round_s) {
    if (self->stage == (uint_least8_t)LODE_START_ALIGN) {
        const float stood_s = (float)self->seen.rest.dwelt * round_s;
        return unmet(LODE_CRITERION_REST, stood_s, tuning->align_rounds * round_s);
    }
#ifndef LODE_WITHOUT_START_MEASUREMENT
    const uint32_t calm = self->seen.rest.calm;
    const uint32_t least = tuning->patience_rounds / CALM_PART;
    if (calm < least) {
        return unmet_for(LODE_CRITERION_REST, calm, least, round_s);
    }
#else
    (void)self;
    (void)round_s;
#endif
    return unmet(LODE_CRITERION_RAMP, 0.0f, tuning->omega_ready);
}

// At speed, by what lode_start_judge() goes by. Speeds are counted in the direction of the vector.
static lode_start_unmet_t unmet_at_speed(const lode_start_t *self,
                                         const lode_start_tuning_t *tuning,
                                         const lode_estimator_t *estimator, float round_s) {
    const float sign = lode_sign(self->omega_rad_s);
    const float vector = lode_abs(self->omega_rad_s);
    const float omega = sign * estimator->pll.omega_rad_s;
    const float slack = lode_start_slack(self, tuning);
    const float off = (float)lock_weight(self, tuning) * slack;
    const float least = lode_max(vector - off, tuning->omega_ready - slack);
    const float lost = tuning->lost_per_A * estimator->id_A;
    if (!(omega >= least)) {
        return unmet(LODE_CRITERION_SPEED, estimator->pll.omega_rad_s, sign * least);
    }
    if (!(omega <= vector + off)) {
        return unmet(LODE_CRITERION_SPEED, estimator->pll.omega_rad_s, sign * (vector + off));
    }
    if (lost > LODE_START_LOST_MAX) {
        return unmet(LODE_CRITERION_FLUX, lost, LODE_START_LOST_MAX);
    }
    if (!(estimator->lock >= LODE_LOCK_HANDOVER)) {
        return unmet(LODE_CRITERION_LOCK, estimator->lock, LODE_LOCK_HANDOVER);
    }
    return unmet_for(LODE_CRITERION_HOLD, self->locked, tuning->lock_rounds, round_s);
}

LODE_NOINLINE lode_start_unmet_t lode_start_unmet(const lode_start_t *self,
                                                  const lode_start_tuning_t *tuning,
                                                  const lode_estimator_t *estimator,
                                                  const lode_estimator_tuning_t *estimator_tuning) {
    const float round_s = (float)LODE_SLOW_PERIODS * estimator_tuning->pll.ts_s;
    if (self->current_A < self->current_target) {
        return unmet(LODE_CRITERION_CURRENT, self->current_A, self->current_target);
    }
    if (self->stage != (uint_least8_t)LODE_START_TURN) {
        return unmet_at_rest(self, tuning, round_s);
    }
    const float vector = lode_sign(self->omega_target) * self->omega_rad_s;
    if (!(vector >= tuning->omega_ready)) {
        return unmet(LODE_CRITERION_RAMP, vector, tuning->omega_ready);
    }
    const float omega = estimator->pll.omega_rad_s;
    // (S39), with what the observer takes of the amplitude
    const float taken = 1.0f + omega * omega * estimator_tuning->droop_s2;
    const float emf_V = taken * lode_ab_length(estimator->emf.observer.e_V);
    const float least_V = (1.0f - LODE_START_LOST_MAX) * (1.0f - LODE_START_TOLERANCE) * vector *
                          estimator_tuning->psi_Wb;
    if (!(emf_V >= least_V)) {
        return unmet(LODE_CRITERION_EMF, emf_V, least_V);
    }
    return unmet_at_speed(self, tuning, estimator, round_s);
}

#define NAME(value)                                                                                \
    case value:                                                                                    \
        return #value

const char *lode_start_stage_name(lode_start_stage_t stage) {
    switch (stage) {
        NAME(LODE_START_NONE);
        NAME(LODE_START_CATCH);
        NAME(LODE_START_HALF);
        NAME(LODE_START_FULL);
        NAME(LODE_START_ALONE);
        NAME(LODE_START_FOUND);
        NAME(LODE_START_ALIGN);
        NAME(LODE_START_TURN);
    default:
        return "LODE_START_UNKNOWN";
    }
}

const char *lode_criterion_name(lode_criterion_t criterion) {
    switch (criterion) {
        NAME(LODE_CRITERION_NONE);
        NAME(LODE_CRITERION_CURRENT);
        NAME(LODE_CRITERION_REST);
        NAME(LODE_CRITERION_RAMP);
        NAME(LODE_CRITERION_EMF);
        NAME(LODE_CRITERION_SPEED);
        NAME(LODE_CRITERION_FLUX);
        NAME(LODE_CRITERION_LOCK);
        NAME(LODE_CRITERION_HOLD);
        NAME(LODE_CRITERION_PROOF);
        NAME(LODE_CRITERION_POLARITY);
    case LODE_CRITERION_COUNT:
    default:
        return "LODE_CRITERION_UNKNOWN";
    }
}
