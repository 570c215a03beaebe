// Defaults, checks and tuning of the start.
#include "start_parts.h"

#include "inverter_inline.h"
#include "lodestar/current.h"

#define CURRENT_SHARE 0.7f  // of i_max
#define SALIENT_SHARE 0.5f  // of psi/(Lq - Ld), at which nothing holds a salient rotor any more
#define HANDOVER_SHARE 0.1f // of rated speed
// Least ratio of the EMF at hand-over to the voltage that is not modelled (S12): a microsecond of dead time, which
// makes (4/pi) v_bus f_pwm times that along the current, and 30 % of the resistance (a warm winding). Without dead-time
// correction the configured dead time and drops too.
#define EMF_PER_UNKNOWN 2.0f
#define DEAD_TIME_UNKNOWN_s 1.0e-6f
#define RESISTANCE_UNKNOWN 0.3f
// Least ratio of the EMF at hand-over to the drop across the resistance: gain errors of 2 % between the phase currents
// make the measured drop swing by as much, twice per turn.
#define EMF_PER_DROP 0.25f
// Factor of (S18): omega_handover^2 over the largest acceleration times the share of the flux that the current takes.
#define LIGHT_ROTOR 4.5f
// Least (Lq - Ld)/Lq in (S18). An error of 20 % in Lq turns the angle even of a rotor configured without saliency; it
// counts as in a rotor of this saliency, where it is 0.55 of Lq - Ld.
#define LIGHT_UNSURE 0.36f
// (S52): hand-over speed as a share of rated speed, over Lq i_max/psi.
#define RELUCTANCE 0.08f
// Of rated or base speed: a higher hand-over would leave too little of the speed range.
#define HANDOVER_SHARE_MAX 0.5f
// Factor by which noise of the currents may raise the hand-over speed (S49). At much higher speed a rotor that slips
// makes the current swing in a way that (S43) takes for failing sensors.
#define NOISE_MOST 2.5f
#define RAMP_TORQUE_SHARE 0.1f // of the start torque: ten times the inertia takes all of it
// Gentle ramp (S35): the share STEEPENS (omega + omega_handover/STEEP)/omega_handover of the ramp, a sixteenth at rest.
// For a configured ramp STEEP takes the place of STEEPENS, and the share is 1 from rest on.
#define STEEPENS 4.0f
#define GENTLE_SHARE 0.46f // (ln 16 - 15/16)/4: share of its time that (S35) adds to a ramp
#define RISE_TIME_s 0.2f
// Current rise for a rotor whose axis no pulse shows: RISE_rad radians of its swing, within these two times. The vector
// sweeps past it, and the slower the vector the less a rotor with ten times its inertia swings (S29).
#define RISE_rad 35.0f
#define RISE_TIME_MAX_s 0.4f
#define DAMPING 0.5f
#define LOCK_TIME_s 0.1f
#define CATCH_TIME_s 0.05f // the estimator needs 20 to 30 ms from a reset to a sure lock
#define FADE_TIME_s 0.1f
#define SALIENT_TIME_SHARE 0.5f // of lock and fade, where reluctance bounds the start current
#define LOST_UNSURE 1.2f        // of the flux taken by the current: Lq - Ld may be 20 % more
#define LOCK_TURNS 2.0f         // electrical
#define PATIENCE_s 0.4f
#define TIMEOUT_MAX_s 1000.0f
#define ROUNDS_MAX 2.0e9f // inside an int32
#define COUNTER_MAX 65535.0f
// Sweep of the vector while the current rises (S29): in total, or with a measurement from half of the current on.
#define SWEEP_rad (LODE_TWO_PI * 240.0f / 360.0f)
#define SWEEP_SECOND_rad (LODE_TWO_PI * 60.0f / 360.0f)
#define MEAN_CORNER 0.3f // corner of the mean EMF's filter over the swing's natural frequency
// Largest gain of the loop through the shift (S15): in a salient rotor a moving vector moves the d current and so the
// active flux, which appears as EMF just as a swing does.
#define SHIFT_LOOP 1.0f
// Largest gain from load angle to shift (S16): the EMF of a loaded rotor shows its angle too, at speed more than its swing.
#define SHIFT_STIFFENS 2.0f
// Longest wait of the measurement at each current. A rotor that is not at rest by then is measured by the mean of its
// swing.
#define DWELL_TIME_s 0.15f
#define MEASUREMENTS 2.0f // with half the current and with all of it
#define CALM_SHARE 0.1f   // of the unknown voltage
// Standard deviations of what a user knows (S33): of the resistance, relative; of the dead time.
#define RESISTANCE_DEVIATION 0.2f
#define DEAD_TIME_DEVIATION_s 0.5e-6f
#define KNOWN_MAX 1.0e6f
#ifdef LODE_WITHOUT_START_MEASUREMENT
#define MEASURES LODE_OFF
#else
#define MEASURES LODE_ON
#endif

// Torque per electrical radian between rotor and vector, Nm/rad.
static float stiffness(float current_A, const lode_motor_t *motor) {
    return current_A * lode_motor_kt_Nm_A(motor);
}

// Reluctance torque works against the stiffness of the magnets; at psi/(Lq - Ld) nothing holds the rotor any more.
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
    const bool salient = motor->Lq_H >= LODE_SURELY_SALIENT * motor->Ld_H;
    const float most = salient ? RISE_TIME_s : RISE_TIME_MAX_s;
    return lode_clamp(RISE_rad / swing, RISE_TIME_s, most);
}

static float ramp_s(const lode_start_config_t *config) {
    return config->omega_handover_rad_s / lode_max(config->ramp_rad_s2, FLT_MIN);
}

// Electrical acceleration (S7).
static float default_ramp_rad_s2(const lode_motor_t *motor, float current_A) {
    const float torque = RAMP_TORQUE_SHARE * stiffness(current_A, motor);
    return torque / lode_max(motor->J_kgm2, FLT_MIN) * motor->pole_pairs;
}

// True for the default ramp. A configured ramp applies in full from rest on.
static bool begins_gently(const lode_start_config_t *config, const lode_motor_t *motor) {
    const float own = default_ramp_rad_s2(motor, config->current_A);
    return lode_in_range(config->ramp_rad_s2, own, own);
}

// Time that (S35) adds to a ramp, at most.
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

// (S9): the profile, and as long again, at least 0.4 s, for the rotor to settle and the lock to come.
static float attempt_s(const lode_start_config_t *config, const lode_motor_t *motor, float ease) {
    const float ramps_s = ramp_s(config) / ease + gentle_s(config, motor);
    const float rise_s = config->current_rise_s / (ease < 1.0f ? LODE_START_LATER_RISE : 1.0f);
    const float profile_s = rise_s + dwell_s(config) + ramps_s + config->lock_s;
    return profile_s + lode_max(profile_s, PATIENCE_s);
}

static float drop_V(const lode_motor_t *motor, const lode_inverter_config_t *inverter,
                    float current_A) {
    return (motor->Rs_Ohm + inverter->r_on_Ohm) * current_A;
}

// Voltage along the start current that dead time of `dead_time_s` takes, and drops.
static float lost_V(const lode_inverter_config_t *inverter, float dead_time_s, float v_drop_V,
                    float ts_s) {
    const float carrier_Hz = lode_inverter_carrier_Hz(inverter, 1.0f / ts_s);
    return FOUR_PER_PI * (inverter->v_bus_V * dead_time_s * carrier_Hz + v_drop_V);
}

// Voltage along the start current that nobody knows (S12).
static float unknown_V(const lode_motor_t *motor, const lode_inverter_config_t *inverter,
                       float current_A, float ts_s) {
    return lost_V(inverter, DEAD_TIME_UNKNOWN_s, 0.0f, ts_s) +
           RESISTANCE_UNKNOWN * drop_V(motor, inverter, current_A);
}

// Voltage along the start current that is known, but neither corrected nor part of the observer's voltage (S12).
static float left_out_V(const lode_inverter_config_t *inverter, float ts_s) {
    const bool known =
        inverter->dead_time_correction == LODE_ON || inverter->dead_time_model == LODE_ON;
    return known ? 0.0f : lost_V(inverter, inverter->dead_time_s, inverter->v_drop_V, ts_s);
}

// Electrical speed at which i_max in a warm winding and the EMF use up the bus.
static float base_omega(const lode_motor_t *motor, const lode_inverter_config_t *inverter) {
    const float u_V = LODE_VOLTAGE_USE * inverter->v_bus_V / LODE_SQRT3;
    const float warm_V = (1.0f + RESISTANCE_UNKNOWN) * drop_V(motor, inverter, inverter->i_max_A);
    const float psi_q = motor->Lq_H * inverter->i_max_A;
    const float flux2 = motor->psi_Wb * motor->psi_Wb + psi_q * psi_q;
    const float half = warm_V * motor->psi_Wb;
    const float left_V2 = lode_max(u_V * u_V - warm_V * warm_V, 0.0f);
    return (lode_sqrt(half * half + flux2 * left_V2) - half) / lode_max(flux2, FLT_MIN);
}

// (S18): a load step must not stop the rotor before the PLL has seen it. An error of Lq - Ld turns the angle the more
// the lower the speed, and limits the PLL's bandwidth to some omega psi/((Lq - Ld) I). So a light rotor needs a high
// hand-over speed.
static float omega_of_light_rotor(const lode_motor_t *motor, const lode_inverter_config_t *inverter,
                                  float current_A) {
    const float unsure_H =
        lode_max(lode_abs(motor->Lq_H - motor->Ld_H), LIGHT_UNSURE * motor->Lq_H);
    const float lost = unsure_H * current_A / lode_max(motor->psi_Wb, FLT_MIN);
    const float acc_rad_s2 =
        motor->omega_rated_rad_s / lode_max(lode_motor_run_up_s(motor, inverter->i_max_A), FLT_MIN);
    return lode_sqrt(LIGHT_ROTOR * lost * acc_rad_s2);
}

// Electrical speed from which the EMF exceeds the voltage that is not modelled enough (S12).
static float omega_of_emf(const lode_motor_t *motor, const lode_inverter_config_t *inverter,
                          float current_A, float ts_s) {
    const float least_V = unknown_V(motor, inverter, current_A, ts_s) + left_out_V(inverter, ts_s);
    return EMF_PER_UNKNOWN * least_V / lode_max(motor->psi_Wb, FLT_MIN);
}

// (S52): an error of Lq turns the angle, PLL and speed control pass that on to the current, and the lower the speed the
// stiffer speed control has to be for a load.
static float omega_of_reluctance(const lode_motor_t *motor, float i_max_A) {
    const float share = RELUCTANCE * motor->Lq_H * i_max_A / lode_max(motor->psi_Wb, FLT_MIN);
    return share * motor->omega_rated_rad_s;
}

// Electrical speed from which the EMF exceeds the error that the current sensors leave in the measured drop.
static float seen_omega(const lode_motor_t *motor, const lode_inverter_config_t *inverter,
                        float current_A) {
    return EMF_PER_DROP * drop_V(motor, inverter, current_A) / lode_max(motor->psi_Wb, FLT_MIN);
}

// Highest hand-over speed that is not configured.
static float most_omega(const lode_motor_t *motor, const lode_inverter_config_t *inverter) {
    return HANDOVER_SHARE_MAX * lode_min(motor->omega_rated_rad_s, base_omega(motor, inverter));
}

static float within_speeds(float omega_rad_s, const lode_motor_t *motor,
                           const lode_inverter_config_t *inverter, float current_A) {
    const float least =
        lode_max(HANDOVER_SHARE * motor->omega_rated_rad_s, seen_omega(motor, inverter, current_A));
    return lode_clamp(omega_rad_s, least, lode_max(most_omega(motor, inverter), least));
}

float lode_start_least_rad_s(const lode_start_config_t *config,
                             const lode_inverter_config_t *inverter, const lode_motor_t *motor) {
    return lode_max(seen_omega(motor, inverter, config->current_A),
                    omega_of_light_rotor(motor, inverter, config->current_A));
}

bool lode_start_has_emf(const lode_start_config_t *config, const lode_inverter_config_t *inverter,
                        const lode_motor_t *motor) {
    return seen_omega(motor, inverter, config->current_A) <= most_omega(motor, inverter);
}

// Electrical speed from which the angle is good enough.
static float omega_of_angle(const lode_motor_t *motor, const lode_inverter_config_t *inverter,
                            float current_A, float ts_s) {
    return lode_max(omega_of_emf(motor, inverter, current_A, ts_s),
                    omega_of_reluctance(motor, inverter->i_max_A));
}

static float default_handover(const lode_motor_t *motor, const lode_inverter_config_t *inverter,
                              float current_A, float ts_s) {
    const float by_angle = omega_of_angle(motor, inverter, current_A, ts_s);
    const float by_rotor = omega_of_light_rotor(motor, inverter, current_A);
    return within_speeds(lode_max(by_angle, by_rotor), motor, inverter, current_A);
}

// True for the default hand-over speed. A configured one applies as it is.
static bool is_own_handover(const lode_start_config_t *config,
                            const lode_inverter_config_t *inverter, const lode_motor_t *motor,
                            float ts_s) {
    const float own = default_handover(motor, inverter, config->current_A, ts_s);
    return lode_in_range(config->omega_handover_rad_s, own, own);
}

// Speed from which the estimator may take over. Where only load steps require the default hand-over speed, the angle is
// visible earlier, and the vector need not reach it. A configured speed applies as it is.
static float omega_ready(const lode_start_config_t *config, const lode_inverter_config_t *inverter,
                         const lode_motor_t *motor, float ts_s) {
    const float by_angle = within_speeds(omega_of_angle(motor, inverter, config->current_A, ts_s),
                                         motor, inverter, config->current_A);
    return is_own_handover(config, inverter, motor, ts_s) ? by_angle : config->omega_handover_rad_s;
}

// (S26): a rotor with too little flux left for (S8) is handed over while its vector gives way (S17), and where the load
// swings within every turn of the shaft (S8) holds for a part of the turn only. Both need a shorter time.
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
    // A configured current applies to every attempt.
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
        !lode_is_none_or_in(config->catch_s, 0.0f, longest_s) ||
        !lode_in_range(config->align_s, 0.0f, longest_s) ||
        !lode_in_range(config->lock_s, ts_s, longest_s) ||
        !lode_in_range(config->fade_s, ts_s, 10.0f) ||
        !lode_in_range(config->timeout_s, config->lock_s, TIMEOUT_MAX_s)) {
        return LODE_ERROR_START_RAMP;
    }
    if (config->measure != MEASURES && config->measure != LODE_OFF) {
        return LODE_ERROR_CHOICE;
    }
    if (!lode_is_none_or_in(config->damping, 0.0f, 2.0f)) {
        return LODE_ERROR_START_DAMPING;
    }
    return LODE_OK;
}

// Rounded to the nearest; 0 only for a time of 0.
static uint32_t rounds_in(float time_s, float ts_s) {
    const float rounds = time_s / ((float)LODE_SLOW_PERIODS * ts_s);
    const float least = time_s > 0.0f ? 1.0f : 0.0f;
    return (uint32_t)(int32_t)lode_clamp(rounds + 0.5f, least, ROUNDS_MAX);
}

#ifndef LODE_WITHOUT_START_MEASUREMENT

// (S33): weight of a value that is known so well that its voltage has this standard deviation.
static float weight_known(float calm_V, float deviation_V) {
    const float share = calm_V / lode_max(deviation_V, FLT_MIN);
    return lode_min(share * share, KNOWN_MAX);
}

static void tune_measurement(lode_start_tuning_t *tuning, const lode_start_config_t *config,
                             const lode_inverter_config_t *inverter, const lode_motor_t *motor,
                             float ts_s) {
    const float calm_V = CALM_SHARE * unknown_V(motor, inverter, config->current_A, ts_s);
    const float r_V = RESISTANCE_DEVIATION * drop_V(motor, inverter, config->current_A);
    const float dead_V = lost_V(inverter, DEAD_TIME_DEVIATION_s, 0.0f, ts_s);
    tuning->dwell_rounds =
        config->measure == LODE_ON ? (uint_least16_t)rounds_in(DWELL_TIME_s, ts_s) : 0u;
    tuning->R_Ohm = motor->Rs_Ohm + inverter->r_on_Ohm;
    tuning->calm_V = calm_V;
    tuning->r_known = weight_known(calm_V, r_V);
    tuning->dead_known = weight_known(calm_V, dead_V);
}

#endif

lode_status_t lode_start_tune(lode_start_tuning_t *tuning, const lode_start_config_t *config,
                              const lode_inverter_config_t *inverter, const lode_motor_t *motor,
                              float omega_max_rad_s, float ts_s) {
    const lode_status_t status = check(config, inverter, omega_max_rad_s, ts_s);
    if (status != LODE_OK) {
        return status;
    }
    // (S6): a vector that gives way by 2 zeta/wn per rad/s of the rotor's swing damps it with the ratio zeta, as its
    // torque is K times that angle. The swing appears as EMF across the vector, psi volts per rad/s, at standstill too.
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
    };
#ifndef LODE_WITHOUT_START_MEASUREMENT
    tune_measurement(tuning, config, inverter, motor, ts_s);
#endif
    return LODE_OK;
}
