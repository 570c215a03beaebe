#include "drive_parts.h"
#include "hfi_inline.h"

#include <stddef.h>

#define F_PWM_MIN_Hz 1.0e3f
#define F_PWM_MAX_Hz 2.0e5f

// Largest period of speed control, times its bandwidth (K12).
#define SPEED_PERIOD_SHARE 0.1f
// Largest electrical angle per call of speed control, at rated speed (K12). The position error's ripple, at six times the
// electrical frequency, then aliases to twice that frequency or more. Where it aliased to the frequency itself, a 400 V
// machine at 4.7 samples per turn hunted with 9 A.
#define SPEED_ANGLE_MAX_rad (LODE_TWO_PI / 8.0f)
// Lightest rotor that speed control is designed for, as a share of the configured inertia.
#define LIGHT_SHARE 0.25f

// Lowest speed with injection: none.
#define ANY_SPEED (-1.0e9f)

#define ROUNDING 1.0e-5f

// Machines are rated at about two thirds of the speed at which the bus voltage is used up; the rest is for control. (Paper 1:
// 471 of 713 rad/s.)
#define RATED_SHARE 0.66f

// Default of the rated speed, from the electrical speed at which the EMF and the reactance of i_max/2 use up the bus voltage.
static float rated_omega(const lode_motor_t *motor, const lode_inverter_config_t *inverter) {
    const float reactive = motor->Lq_H * 0.5f * inverter->i_max_A;
    const float flux = lode_sqrt(motor->psi_Wb * motor->psi_Wb + reactive * reactive);
    return RATED_SHARE * inverter->v_bus_V / (LODE_SQRT3 * lode_max(flux, FLT_MIN));
}

// With field weakening the voltage no longer limits the speed. Default of omega_max: twice the speed at which the magnets'
// EMF takes all the voltage, between 2.5 and 5 times rated (the default observer's lag is compensated up to 5.9 times), with
// at least 12 periods per turn.
#define WEAKENED_SHARE 2.0f
#define WEAKENED_RATED_MIN 2.5f
#define WEAKENED_RATED_MAX 5.0f
#define WEAKENED_TS 0.5f
// The fade of the torque with the bus ends at this share of the way from its beginning to the guard's limit (R14).
#define BUS_FADE_SHARE 0.5f

static float weakened_omega(const lode_drive_config_t *config) {
    const lode_motor_t *motor = &config->motor;
    const float full = config->inverter.v_bus_V / (LODE_SQRT3 * lode_max(motor->psi_Wb, FLT_MIN));
    const float omega =
        lode_clamp(WEAKENED_SHARE * full, WEAKENED_RATED_MIN * motor->omega_rated_rad_s,
                   WEAKENED_RATED_MAX * motor->omega_rated_rad_s);
    return lode_min(omega, WEAKENED_TS * config->f_pwm_Hz);
}

// The motor as estimator and current control see it: the switches' slope resistance adds to the winding's.
static lode_motor_t circuit_of(const lode_drive_config_t *config) {
    lode_motor_t circuit = config->motor;
    circuit.Rs_Ohm += config->inverter.r_on_Ohm;
    return circuit;
}

// sigma times the run-up time, in which the torque at i_max brings the rotor to rated speed (P20). Below some 10 a load step
// or a slam is over before PLL and speed control respond. Motors with 18 and more need only the rule by speed.
#define SIGMA_RUN_UP 17.0f
// More than this many times as much only passes on ripple, of dead time above all (P33).
#define SIGMA_HEAVY 4.0f
// (P28): a hand-over beyond this share of rated speed is late; sigma is raised if below this share of what is required. Both
// go further for a motor whose angle an error of Lq - Ld hardly turns and that a rated load does not stop at once (P29).
#define LATE_HANDOVER 0.2f
#define LATE_NEED 0.175f
#define FIRM_HANDOVER 0.15f
#define FIRM_NEED 0.6f
#define FIRM_LOST 0.2f
#define FIRM_STOPS_s 0.0066f // 2/e 2/3 over the 74 rad/s of (K37)
// (P34): at any hand-over such a motor gets more sigma, as far as the swing that dead time makes in its torque allows it, and no
// more than this many times the hand-over speed.
#define SIGMA_DEAD_TIME 0.153f
#define SIGMA_PER_HANDOVER 8.0f
#define ROOT_STEPS 20u // each has a quarter of the error of the one before, on a logarithmic scale
// Upper bounds, for the observer (0.2 w0) and for sampling ...
#define SIGMA_RATED_MAX 0.66f
#define SIGMA_TS_MAX 0.07f
// ... and lower where the start current weakens the active flux, because an error of Lq - Ld then turns the angle. With MTPA
// the d current moves with the torque, and such an error turns the angle twice; with half of the flux lost (the largest start
// current by default) only the rule by speed is then left.
#define SIGMA_FLUX_LOST 1.2f
// Factor on both sigma for a light rotor with MTPA, to which (P20) gives no more than the rule by speed (P27).
#define SIGMA_MTPA 1.1f
// The above is for the LESO-QPLL. A QPLL has more (P22), up to what the default observer allows: a fifth of w0 (P10).
#define SIGMA_OBSERVER 0.84f
#define SIGMA_TS_OBSERVER 0.0999f

// Bandwidth of the GI-LESO's resonance times the run-up time, within its smallest default and the largest accepted value.
#define GI_WC_RUN_UP 17.0f
#define GI_WC_MIN_rad_s LODE_TWO_PI
#define GI_WC_MAX_rad_s 100.0f
// k2 of the FA-LESO over sigma where an error of its speed does more harm (P23); the multi-mode form has it always.
#define K2_FAST 10.0f

#define WARM 1.3f // warm over configured resistance, as for the hand-over (S12)
// Magnets' EMF at the end of a start, over the error that noise makes in it (S49).
#define EMF_PER_NOISE 10.0f

static float sigma_of_kind(const lode_drive_config_t *config, float sigma_rad_s) {
    const float most = lode_min(SIGMA_OBSERVER * config->motor.omega_rated_rad_s,
                                SIGMA_TS_OBSERVER * config->f_pwm_Hz);
    const float sigma = lode_pll_times(config->estimator.pll.kind) * sigma_rad_s;
    return lode_min(sigma, lode_max(sigma_rad_s, most));
}

// What the run-up time requires (P20).
static float sigma_by_run_up(const lode_drive_config_t *config) {
    const float run_up_s = lode_motor_run_up_s(&config->motor, config->inverter.i_max_A);
    return SIGMA_RUN_UP / lode_max(run_up_s, FLT_MIN);
}

// What an error of Lq - Ld allows at rated speed.
static float sigma_by_speed(const lode_drive_config_t *config) {
    const lode_motor_t *motor = &config->motor;
    const float lost = lode_abs(motor->Lq_H - motor->Ld_H) * config->start.current_A;
    const float left =
        lode_max(1.0f - SIGMA_FLUX_LOST * lost / lode_max(motor->psi_Wb, FLT_MIN), 0.0f);
    const float share = config->references.kind == LODE_REFERENCES_MTPA ? left * left : left;
    return SIGMA_RATED_MAX * share * motor->omega_rated_rad_s;
}

// (P29): an error of Lq - Ld hardly turns the angle, and a loop can hold a rated load at this speed.
static bool bears_more_sigma(const lode_drive_config_t *config, float omega_rad_s) {
    const lode_motor_t *motor = &config->motor;
    const float lost_Wb = lode_abs(motor->Lq_H - motor->Ld_H) * config->start.current_A;
    const float run_up_s = lode_motor_run_up_s(motor, config->inverter.i_max_A);
    return lost_Wb <= FIRM_LOST * motor->psi_Wb &&
           run_up_s * omega_rad_s >= FIRM_STOPS_s * motor->omega_rated_rad_s;
}

// Cube root of 0 .. FLT_MAX, slow.
static float cube_root(float x) {
    float root = 1.0f;
    for (uint32_t k = 0u; k < ROOT_STEPS; ++k) {
        root = lode_sqrt(lode_sqrt(x) * lode_sqrt(root));
    }
    return root;
}

// (P34): largest sigma with which dead time hardly swings the torque.
static float sigma_by_dead_time(const lode_drive_config_t *config) {
    const lode_inverter_config_t *inverter = &config->inverter;
    const float carrier_Hz = lode_inverter_carrier_Hz(inverter, config->f_pwm_Hz);
    const float dead_V =
        inverter->dead_time_s * carrier_Hz * inverter->v_bus_V + inverter->v_drop_V;
    const float dead_Wb = dead_V * lode_motor_run_up_s(&config->motor, inverter->i_max_A);
    const float cube = SIGMA_DEAD_TIME * config->motor.psi_Wb / lode_max(dead_Wb, FLT_MIN);
    return lode_min(cube_root(cube) * config->motor.omega_rated_rad_s,
                    SIGMA_PER_HANDOVER * config->start.omega_handover_rad_s);
}

// How many times more it allows, if needed: (P28) and (P29) at a late hand-over, (P34) at any.
static float more_times(const lode_drive_config_t *config) {
    const bool firm = bears_more_sigma(config, config->start.omega_handover_rad_s);
    const float late = firm ? FIRM_HANDOVER : LATE_HANDOVER;
    const float by_handover = config->start.omega_handover_rad_s /
                              (late * lode_max(config->motor.omega_rated_rad_s, FLT_MIN));
    const float by_speed = lode_max(sigma_by_speed(config), FLT_MIN);
    const float need = sigma_by_run_up(config) / by_speed;
    const float late_times = lode_min(by_handover, (firm ? FIRM_NEED : LATE_NEED) * need);
    const bool bears = bears_more_sigma(config, config->motor.omega_rated_rad_s);
    const float calm_times = lode_min(sigma_by_dead_time(config) / by_speed, FIRM_NEED * need);
    return lode_max(bears ? lode_max(late_times, calm_times) : late_times, 1.0f);
}

static float sigma_of_light_rotor(const lode_drive_config_t *config) {
    const float most =
        lode_min(more_times(config) * sigma_by_speed(config), SIGMA_TS_MAX * config->f_pwm_Hz);
    return sigma_of_kind(config, lode_min(sigma_by_run_up(config), most));
}

// Where a light rotor has moved the hand-over beyond omega_high, sigma rises up to the hand-over speed (P21), (P27): the
// effect of an error of Lq - Ld depends on sigma over the speed.
static void stretch_pll(lode_pll_config_t *pll, const lode_drive_config_t *config) {
    const float most =
        sigma_of_kind(config, lode_min(sigma_by_run_up(config), SIGMA_TS_MAX * config->f_pwm_Hz));
    const float by_speed =
        config->start.omega_handover_rad_s / lode_max(pll->omega_high_rad_s, FLT_MIN);
    const float by_sigma = most / lode_max(pll->sigma_rad_s, FLT_MIN);
    const float stretch = lode_max(lode_min(by_speed, by_sigma), 1.0f);
    const bool mtpa = config->references.kind == LODE_REFERENCES_MTPA;
    const float times = mtpa ? lode_clamp(by_sigma, stretch, stretch * SIGMA_MTPA) : stretch;
    pll->sigma_low_rad_s *= times;
    pll->sigma_rad_s *= times;
    pll->omega_low_rad_s *= mtpa ? 1.0f : stretch;
    pll->omega_high_rad_s *= mtpa ? 1.0f : stretch;
}

static bool is_open(float value) {
    return lode_in_range(value, 0.0f, 0.0f);
}

// The resonance follows the run-up time: what it has learned must fade as fast as the rotor can change its speed.
static void design_gi(lode_drive_config_t *config) {
    lode_emf_config_t *emf = &config->estimator.emf;
    const float run_up_s = lode_motor_run_up_s(&config->motor, config->inverter.i_max_A);
    const float gi_wc =
        lode_clamp(GI_WC_RUN_UP / lode_max(run_up_s, FLT_MIN), GI_WC_MIN_rad_s, GI_WC_MAX_rad_s);
    emf->gi_wc_rad_s = lode_given_or(emf->gi_wc_rad_s, gi_wc);
}

// (P23). An error of the speed that tunes the FA-LESO turns the EMF. With field weakening that moves the d current, which
// turns the angle. With injection a load may change the speed this fast even where the rotor has no EMF.
static void design_fast_fa(lode_drive_config_t *config) {
    const bool fast =
        config->references.field_weakening == LODE_ON || config->hfi.mode == LODE_HFI_ON;
    if (config->estimator.emf.kind == LODE_EMF_FA_LESO && fast) {
        config->estimator.emf.k2_rad_s =
            lode_min(K2_FAST * config->estimator.pll.sigma_rad_s, config->f_pwm_Hz);
    }
}

// Neither bandwidth is given.
static bool is_pll_open(const lode_pll_config_t *pll) {
    return is_open(pll->sigma_rad_s) && is_open(pll->sigma_low_rad_s);
}

// Bandwidth by the rated speed, and a higher one where the inertia requires it (P20).
static void design_pll(lode_drive_config_t *config, float ts_s) {
    lode_pll_config_t *pll = &config->estimator.pll;
    const bool open = is_pll_open(pll);
    const bool all_open = open && is_open(pll->omega_low_rad_s) && is_open(pll->omega_high_rad_s);
    lode_pll_design(pll, config->motor.omega_rated_rad_s, ts_s);
    // Not with field weakening: there the d current moves with the torque, and a fast PLL follows the angle error that an
    // error of Lq - Ld makes (7.2 instead of 3.5 degrees where a motor came back from its MTPV range).
    if (all_open && config->references.field_weakening != LODE_ON) {
        stretch_pll(pll, config);
    }
    if (open) {
        const float most = sigma_of_kind(config, SIGMA_HEAVY * sigma_by_run_up(config));
        pll->sigma_low_rad_s = lode_max(pll->sigma_low_rad_s, sigma_of_light_rotor(config));
        pll->sigma_rad_s = lode_max(lode_min(pll->sigma_rad_s, most), pll->sigma_low_rad_s);
    }
}

// (K31). Unequal gains of the current sensors make EMF and torque swing twice per turn, by a share of the current. The bias
// makes this worse, and is left out, where its drop across a warm winding exceeds the EMF at the hand-over and the full
// torque, swinging this fast, moves the rotor by more than its speed.
static bool bias_swings(const lode_drive_config_t *config) {
    const lode_motor_t *motor = &config->motor;
    const float omega = config->start.omega_handover_rad_s;
    const float R_Ohm = WARM * (motor->Rs_Ohm + config->inverter.r_on_Ohm);
    const float run_up_s = lode_motor_run_up_s(motor, config->inverter.i_max_A);
    return R_Ohm * config->references.id_bias_A > motor->psi_Wb * omega &&
           motor->omega_rated_rad_s > 2.0f * omega * omega * run_up_s;
}

// Dead time that a start may find by the noise of its measurement where there is none beyond the configured one.
#define FOUND_BY_CHANCE_s 5.0e-8f

// Largest voltage_use with which no duty, dead-time correction included, exceeds the sampling window. With two low-side
// shunts no third phase can replace one that has no time.
static float seen_voltage_use(const lode_drive_config_t *c) {
    const float loss =
        c->inverter.dead_time_s * lode_inverter_carrier_Hz(&c->inverter, c->f_pwm_Hz) +
        c->inverter.v_drop_V / lode_max(c->inverter.v_bus_V, FLT_MIN);
    return 2.0f * (c->sense.duty_max - loss) - 1.0f;
}

float lode_drive_voltage_use(const lode_drive_config_t *c) {
    const bool windowed = c->sense.shunts == LODE_SHUNTS_TWO && c->sense.duty_max < 1.0f;
    const float room =
        2.0f * FOUND_BY_CHANCE_s * lode_inverter_carrier_Hz(&c->inverter, c->f_pwm_Hz);
    return windowed ? lode_min(seen_voltage_use(c) - room, LODE_VOLTAGE_USE) : LODE_VOLTAGE_USE;
}

static bool has_blind_sectors(const lode_drive_config_t *c) {
    return c->sense.shunts == LODE_SHUNTS_TWO && c->sense.duty_max < 1.0f &&
           c->current.voltage_use > seen_voltage_use(c) + ROUNDING;
}

static lode_hfi_system_t injected_into(const lode_drive_config_t *c) {
    return (lode_hfi_system_t){
        .motor = &c->motor,
        .inverter = &c->inverter,
        .ts_s = 1.0f / lode_max(c->f_pwm_Hz, FLT_MIN),
        .circle_V = c->current.voltage_use * c->inverter.v_bus_V / LODE_SQRT3,
        .count_A = c->sense.i_gain_A_count,
        .sigma_rad_s = c->estimator.pll.sigma_rad_s,
        .omega_max_rad_s = c->estimator.omega_max_rad_s,
        .Lq_fall = c->references.Lq_fall,
        .active_flux = c->estimator.active_flux == LODE_ON,
    };
}

// Bus voltage at which a torque that fades from `from_V` on is zero. It lies before the guard's limit, because the bus moves
// on until the torque has followed (R14).
static float fade_end_V(float given_V, float from_V, float limit_V) {
    const float own_V = from_V > 0.0f ? from_V + BUS_FADE_SHARE * (limit_V - from_V) : limit_V;
    return lode_given_or(given_V, own_V);
}

static void design_bus_fade(lode_references_config_t *config, const lode_guard_config_t *guard) {
    config->v_bus_max_V = fade_end_V(config->v_bus_max_V, config->v_regen_V, guard->v_bus_max_V);
    config->v_bus_min_V = fade_end_V(config->v_bus_min_V, config->v_motor_V, guard->v_bus_min_V);
}

// Periods per call of speed control: a round of the slow jobs, or a part of it (K12).
static uint32_t speed_periods(const lode_drive_config_t *c, float bandwidth_rad_s) {
    if (c->speed.every_period == LODE_ON) {
        return 1u;
    }
    const float least_Hz = lode_max(bandwidth_rad_s / SPEED_PERIOD_SHARE,
                                    c->motor.omega_rated_rad_s / SPEED_ANGLE_MAX_rad);
    uint32_t periods = LODE_SLOW_PERIODS;
    while (periods > 1u && (float)periods * least_Hz > c->f_pwm_Hz) {
        periods /= 2u;
    }
    return periods;
}

// (K22): the delay of position, torque and speed control, and the damping by the EMF: a rotor faster than its estimate is
// braked by the current that current control lets pass.
static lode_speed_loop_t speed_loop(const lode_drive_config_t *c, const lode_motor_t *circuit,
                                    float ts_s) {
    const uint32_t periods = speed_periods(c, 0.0f);
    const float late =
        periods == LODE_SLOW_PERIODS ? (float)LODE_SLOW_PERIODS : 1.0f + 0.5f * (float)periods;
    const float sigma = lode_max(c->estimator.pll.sigma_low_rad_s, FLT_MIN);
    const float r_Ohm = circuit->Rs_Ohm + c->current.kp_q_V_A;
    const float x_Ohm = sigma * circuit->Lq_H - c->current.ki_q_V_As / sigma;
    const float z2_Ohm2 = lode_max(r_Ohm * r_Ohm + x_Ohm * x_Ohm, FLT_MIN);
    const float light_kgm2 = lode_max(LIGHT_SHARE * c->motor.J_kgm2, FLT_MIN);
    const float Nm_per_V = lode_motor_kt_Nm_A(&c->motor) * r_Ohm / z2_Ohm2;
    return (lode_speed_loop_t){
        .delay_s = lode_observer_delay_s(&c->estimator.emf) +
                   1.0f / lode_max(c->current.bandwidth_rad_s, FLT_MIN) + late * ts_s,
        .damping_rad_s = Nm_per_V * c->motor.pole_pairs * c->motor.psi_Wb / light_kgm2,
    };
}

void lode_drive_design(lode_drive_config_t *config) {
    const float ts_s = 1.0f / lode_max(config->f_pwm_Hz, FLT_MIN);
    lode_motor_t *motor = &config->motor;
    const lode_inverter_config_t *inverter = &config->inverter;
    motor->omega_rated_rad_s =
        lode_given_or(motor->omega_rated_rad_s, rated_omega(motor, inverter));
    lode_sense_design(&config->sense);
    lode_inverter_design(&config->inverter, motor, ts_s);
    const bool bias_open = is_open(config->references.id_bias_A);
    lode_references_design(&config->references, inverter, motor);
    if (config->references.field_weakening == LODE_ON) {
        config->estimator.omega_max_rad_s =
            lode_given_or(config->estimator.omega_max_rad_s, weakened_omega(config));
    }
    lode_start_design(&config->start, inverter, motor, ts_s);
    if (bias_open && bias_swings(config)) {
        config->references.id_bias_A = LODE_NONE;
    }
    // to the EMF observer, where sigma is higher than the rated speed's (P28), (P34)
    lode_motor_t faster = *motor;
    faster.omega_rated_rad_s *= is_pll_open(&config->estimator.pll) ? more_times(config) : 1.0f;
    design_pll(config, ts_s);
    design_gi(config);
    const bool k2_open = is_open(config->estimator.emf.k2_rad_s);
    lode_emf_design(&config->estimator.emf, &faster, config->estimator.pll.sigma_rad_s, ts_s);
    lode_estimator_design(&config->estimator, motor, ts_s);
    const lode_motor_t circuit = circuit_of(config);
    config->current.voltage_use =
        lode_given_or(config->current.voltage_use, lode_drive_voltage_use(config));
    lode_current_design(&config->current, &circuit, ts_s);
    const lode_hfi_system_t injected = injected_into(config);
    lode_hfi_design(&config->hfi, &injected);
    // only now is it settled whether a wave is injected
    if (k2_open) {
        design_fast_fa(config);
    }
    const lode_speed_loop_t loop = speed_loop(config, &circuit, ts_s);
    lode_speed_design(&config->speed, inverter, motor, &config->estimator.pll, &loop,
                      config->start.omega_handover_rad_s, config->hfi.mode == LODE_HFI_ON);
    lode_guard_design(&config->guard, inverter, &config->estimator);
    design_bus_fade(&config->references, &config->guard);
}

// Adds injection to a tuning that is otherwise complete.
static lode_status_t tune_injection(lode_drive_tuning_t *t, const lode_drive_config_t *c) {
    const lode_hfi_system_t system = injected_into(c);
    lode_hfi_tuning_t hfi;
    const lode_status_t status = lode_hfi_tune(&hfi, &c->hfi, &system);
#ifdef LODE_WITHOUT_HFI
    (void)t;
#else
    if (status == LODE_OK) {
        t->estimator.hfi = hfi;
    }
    if (status == LODE_OK && lode_hfi_is_on(&hfi)) {
        t->omega_min = ANY_SPEED;
        t->references.id_bias_A = -lode_max(c->hfi.id_A, 0.0f);
        t->references.fade = (lode_fade_t){2.0f * c->hfi.w2_rad_s, 1.0f / c->hfi.w2_rad_s};
    }
#endif
    return status;
}

// Tunes sensing, inverter and estimator.
static lode_status_t tune_senses(lode_drive_tuning_t *t, const lode_drive_config_t *c) {
    const float ts_s = 1.0f / c->f_pwm_Hz;
    lode_status_t status = lode_inverter_tune(&t->inverter, &c->inverter, ts_s);
    if (status == LODE_OK) {
        // Phase currents up to the trip limit, whose sum need not be zero, make a vector of up to 1.8 times that.
        lode_inverter_bound_current(&t->inverter, 2.0f * c->guard.i_trip_A);
        status =
            lode_sense_tune(&t->sense, &c->sense, c->inverter.i_max_A, c->inverter.v_bus_V, ts_s);
    }
    if (status == LODE_OK) {
        const lode_motor_t circuit = circuit_of(c);
        status = lode_estimator_tune(&t->estimator, &c->estimator, &circuit, ts_s);
    }
    return status;
}

// Bandwidth of current control, in its slower axis.
static float control_rad_s(const lode_drive_config_t *c) {
    return lode_min(c->current.kp_d_V_A / c->motor.Ld_H, c->current.kp_q_V_A / c->motor.Lq_H);
}

static lode_status_t tune_plausibility(lode_drive_tuning_t *t, const lode_drive_config_t *c) {
    lode_plausibility_tuning_t plausibility;
    lode_status_t status =
        lode_plausibility_tune(&plausibility, &c->guard, c->inverter.i_max_A, &t->sense);
    if (status == LODE_OK) {
        const float most_Nm = t->references.torque_factor * t->references.tau_max;
        status = lode_plausibility_tune_load(&plausibility, &c->guard,
                                             c->motor.pole_pairs * most_Nm / c->motor.J_kgm2,
                                             c->motor.omega_rated_rad_s, 1.0f / c->f_pwm_Hz);
        lode_plausibility_tune_voltages(&plausibility, &c->guard, c->inverter.i_max_A,
                                        c->inverter.i_max_A * t->estimator.emf.inv_b,
                                        lode_inverter_taken_V(&c->inverter, 1.0f / c->f_pwm_Hz));
        plausibility.waves = lode_half_waves_tune(c->inverter.i_max_A, control_rad_s(c),
                                                  (float)LODE_SLOW_PERIODS / c->f_pwm_Hz);
    }
#ifndef LODE_WITHOUT_PLAUSIBILITY
    if (status == LODE_OK) {
        t->plausibility = plausibility;
    }
#endif
    return status;
}

lode_status_t lode_drive_tune_signal_check(lode_drive_tuning_t *t, const lode_drive_config_t *c,
                                           const lode_motor_t *motor,
                                           const lode_fly_tuning_t *fly) {
    lode_signal_check_tuning_t check;
    const lode_signal_check_given_t given = {
        .ts_s = 1.0f / c->f_pwm_Hz,
        .pulses = fly->share_first > 0.0f,
        .sums = !lode_is_none(c->guard.i_sum_A),
    };
    const lode_status_t status =
        lode_signal_check_tune(&check, &c->start, &c->inverter, motor, &c->sense, given);
#ifdef LODE_WITHOUT_SIGNAL_CHECK
    (void)t;
#else
    if (status == LODE_OK) {
        t->signal_check = check;
    }
#endif
    return status;
}

static lode_status_t tune_flight(lode_drive_tuning_t *t, const lode_drive_config_t *c) {
    lode_fly_tuning_t fly;
    const lode_status_t status =
        lode_fly_tune(&fly, &c->start, &c->inverter, &c->motor, c->estimator.omega_max_rad_s,
                      c->sense.duty_max, 1.0f / c->f_pwm_Hz);
#ifndef LODE_WITHOUT_FLYING_START
    if (status == LODE_OK) {
        t->fly = fly;
    }
#endif
    return status == LODE_OK ? lode_drive_tune_signal_check(t, c, &c->motor, &fly) : status;
}

// The last check refuses the QPLL and the GI-LESO with field weakening; docs/theory/pll.md and emf.md tell why.
static lode_status_t tune_references(lode_drive_tuning_t *t, const lode_drive_config_t *c,
                                     const lode_motor_t *circuit) {
    const float period_s = (float)t->speed_periods * (1.0f / c->f_pwm_Hz);
    const lode_status_t status = lode_references_tune(&t->references, &c->references, &c->inverter,
                                                      circuit, c->current.voltage_use, period_s);
    if (status != LODE_OK || c->references.field_weakening != LODE_ON) {
        return status;
    }
    t->current.weakens = 1u;
    const bool slow =
        c->estimator.pll.kind == LODE_PLL_QPLL || c->estimator.emf.kind == LODE_EMF_GI_LESO;
    return slow ? LODE_ERROR_WEAKENING_ESTIMATOR : LODE_OK;
}

#ifndef LODE_WITHOUT_PLAUSIBILITY
// Speed at which the magnets' EMF is EMF_PER_NOISE times the error that current noise makes on each axis of an observer with
// the bandwidth w0, p = exp(-w0 Ts); per volt of lode_jump_t's noise (S49).
static float omega_per_noise(const lode_drive_config_t *c) {
    const float one_m_p = lode_one_minus_exp(c->estimator.emf.w0_rad_s / c->f_pwm_Hz);
    const float filters = one_m_p / (2.0f - one_m_p);
    const float seen = lode_sqrt(filters * filters * filters * (1.0f / 6.0f));
    return EMF_PER_NOISE * seen / c->motor.psi_Wb;
}
#endif

static lode_status_t tune_start(lode_drive_tuning_t *t, const lode_drive_config_t *c) {
    const lode_status_t status = lode_start_tune(&t->start, &c->start, &c->inverter, &c->motor,
                                                 c->estimator.omega_max_rad_s, 1.0f / c->f_pwm_Hz);
    if (status == LODE_OK) {
        t->start.fade_step *= (float)t->speed_periods;
#ifndef LODE_WITHOUT_PLAUSIBILITY
        t->start.omega_per_noise = omega_per_noise(c);
#endif
    }
    return status;
}

// Current vector of three phases that are all just below the trip limit, and the largest sum of the two terms of (P19) by a
// vector of length 1, of either linkage, with a position error of SINE_MAX.
#define VECTOR_PER_PHASE 1.1547005f
#define ACC_PER_LINKAGE 1.6f

// (P30): the largest acceleration by current that does not trip, and by friction.
static float most_acceleration(const lode_drive_tuning_t *t) {
    const lode_estimator_tuning_t *e = &t->estimator;
    const float i_A = VECTOR_PER_PHASE * t->guard.i_trip;
    const float linkage_Wb = e->psi_Wb + lode_abs(e->salient_H) * i_A;
    return e->acc_per_torque * ACC_PER_LINKAGE * linkage_Wb * i_A +
           e->acc_per_omega * e->omega_limit;
}

// Tunes references, controllers, start and guard.
static lode_status_t tune_control(lode_drive_tuning_t *t, const lode_drive_config_t *c) {
    const float ts_s = 1.0f / c->f_pwm_Hz;
    const lode_motor_t circuit = circuit_of(c);
    lode_status_t status = lode_current_tune(&t->current, &c->current, &circuit, ts_s);
    if (status == LODE_OK && has_blind_sectors(c)) {
        status = LODE_ERROR_SENSE_WINDOW;
    }
    if (status == LODE_OK && c->inverter.double_update == LODE_ON && c->sense.duty_max < 1.0f) {
        // low-side shunts show nothing at the upper turning point
        status = LODE_ERROR_DOUBLE_UPDATE;
    }
    if (status == LODE_OK) {
        t->current.free = lode_min(t->current.free, t->inverter.free);
        status = tune_references(t, c, &circuit);
    }
    if (status == LODE_OK) {
        status = tune_start(t, c);
    }
    if (status == LODE_OK) {
        status = tune_flight(t, c);
    }
    if (status == LODE_OK) {
        status = lode_speed_tune(&t->speed, &c->speed, &c->motor, &c->estimator.pll,
                                 (float)t->speed_periods * ts_s);
    }
    if (status == LODE_OK) {
        status = lode_guard_tune(&t->guard, &c->guard, &c->inverter, &c->sense, ts_s);
    }
    if (status == LODE_OK) {
        status = tune_plausibility(t, c);
    }
    if (status == LODE_OK) {
        t->estimator.acc_most = most_acceleration(t);
        const float trip = t->guard.i_trip / lode_abs(t->sense.i_gain);
        t->sense.alert = (uint32_t)(int32_t)lode_min((float)t->sense.alert, trip);
    }
    if (status == LODE_OK &&
        !lode_in_range(c->speed.omega_min_rad_s, 0.5f * c->start.omega_handover_rad_s,
                       c->estimator.omega_max_rad_s)) {
        status = LODE_ERROR_START_SPEED;
    }
    return status;
}

// Over-speed lies above the speed at which a start ends, and above the least one in RUN; injection needs neither.
static lode_status_t check_over_speed(const lode_drive_tuning_t *t, const lode_drive_config_t *c) {
    const float least = lode_max(t->omega_min, c->start.omega_handover_rad_s);
    const bool any = t->omega_min < 0.0f;
    return any || t->guard.omega_max >= least ? LODE_OK : LODE_ERROR_GUARD_SPEED;
}

lode_status_t lode_drive_check_given(const lode_drive_config_t *config) {
    if (!lode_in_range(config->f_pwm_Hz, F_PWM_MIN_Hz, F_PWM_MAX_Hz)) {
        return LODE_ERROR_F_PWM;
    }
    const lode_status_t status = lode_motor_check(&config->motor);
    return status == LODE_OK ? lode_inverter_check_given(&config->inverter) : status;
}

uint32_t lode_drive_warnings(const lode_drive_config_t *config) {
    lode_drive_config_t c = *config;
    lode_drive_design(&c);
    const lode_hfi_system_t injected = injected_into(&c);
    const bool sees = lode_start_has_emf(&c.start, &c.inverter, &c.motor);
    const bool missed = lode_hfi_is_missed(&c.hfi, &injected);
    return (sees ? 0u : (uint32_t)LODE_WARNING_EMF) |
           (missed ? (uint32_t)LODE_WARNING_INJECTION : 0u);
}

lode_status_t lode_drive_tune(lode_drive_tuning_t *tuning, const lode_drive_config_t *config) {
    if (tuning == NULL || config == NULL) {
        return LODE_ERROR_NULL;
    }
    lode_status_t status = lode_drive_check_given(config);
    if (status != LODE_OK) {
        return status;
    }
    lode_drive_config_t complete = *config;
    lode_drive_design(&complete);
    lode_drive_tuning_t t;
    t.speed_periods = speed_periods(&complete, complete.speed.kp_Nms * complete.speed.gain_rise /
                                                   complete.motor.J_kgm2);
    t.omega_min = complete.speed.omega_min_rad_s;
#ifdef LODE_WITHOUT_FAST_SPEED
    if (t.speed_periods != LODE_SLOW_PERIODS) {
        return LODE_ERROR_SPEED_BANDWIDTH;
    }
#endif
    status = tune_senses(&t, &complete);
    if (status == LODE_OK) {
        status = tune_control(&t, &complete);
    }
    if (status == LODE_OK) {
        status = tune_injection(&t, &complete);
    }
    if (status == LODE_OK) {
        status = check_over_speed(&t, &complete);
    }
    if (status == LODE_OK) {
        *tuning = t;
    }
    return status;
}

#define NAME(mode)                                                                                 \
    case mode:                                                                                     \
        return #mode

const char *lode_mode_name(lode_mode_t mode) {
    switch (mode) {
        NAME(LODE_MODE_OFF);
        NAME(LODE_MODE_CALIBRATE);
        NAME(LODE_MODE_VOLTAGE);
        NAME(LODE_MODE_CURRENT);
        NAME(LODE_MODE_START);
        NAME(LODE_MODE_RUN);
        NAME(LODE_MODE_FAULT);
        NAME(LODE_MODE_PRECHARGE);
    default:
        return "LODE_MODE_UNKNOWN";
    }
}
