#include "scalar_inline.h"
#include "speed_inline.h"

// (K22): with such a light rotor the loop with the PLL is stable up to the bandwidth (sigma + d)/(one + delay tau), tau = delay
// times sigma.
typedef struct {
    float one;
    float delay;
} light_t;

// Leaves the loop inside the PLL with an inertia up to four times lighter than configured.
#define BANDWIDTH_PER_SIGMA 0.25f
#define INTEGRAL_SHARE 0.25f // ki = kp bandwidth/4: the zero two octaves below the crossover
#define BANDWIDTH_PER_SIGMA_MAX 1.0f
#define RISE_MAX 10.0f
// The ramp gets less torque where the loop is slow for the rotor: if half of the ramp's torque is wrong because the inertia is,
// the speed is off by a twentieth of rated at most where the ramp ends.
#define RAMP_BANDWIDTH_SHARE 0.114f
#define INERTIA_FEED_FORWARD 1.0f
// A rated load, applied as a step, costs 2/e of the speed that it would take from a free rotor in 1/bandwidth (K15).
#define DIP 0.735759f
// (K16): the fit to where the loop swings that an error of Lq closes.
#define TURNED_PER_SIGMA 1.37f
static const light_t four_times = {0.75f, 4.9f};
#define LIGHT_GAIN_MARGIN 1.41f // 3 dB
#define BOTH_SHARE 0.9f         // (K44): 1 dB, for a light rotor and a wrong Lq at once
// (K37): bandwidths with which a rated load, by (K18), takes half of the lowest speed, and nine tenths of it; and no more of
// sigma than leaves the loop an octave inside the PLL.
#define HELD_TIMES 2.4f
#define STOPPED_TIMES 1.35f
// An error of Lq does not lower it so far that such a load takes more than two thirds of the lowest speed.
#define FIRM_TIMES 1.5f
#define HELD_PER_SIGMA 0.5f
// A rotor that a rated load stops within 10 ms: no loop holds that one.
#define STOPPED_MAX_rad_s 74.0f
// (K40): a load that is fed forward delays the light rotor's loop by as much per share and tau; to the loop through Lq its share
// of sigma/3 is like bandwidth. More than a half would leave little of the damping.
#define LIGHT_FED 2.7f
#define FED_PER_SIGMA (1.0f / 3.0f)
#define LOAD_FEED_FORWARD 0.5f
#define LEAST_FEED_FORWARD 0.01f // less is none
// (K47): three times the gain in all, with which a rotor twice lighter than configured is still stable.
#define DIP_GAIN 2.0f
#define DIP_GAIN_MAX 10.0f
// (K48): half-waves of a swing, the slowest one over half a period of sigma at low speed, and their amplitude over the rated torque.
#define SWINGS 16u
#define SWING_TIMES 1.5f
#define SWING_SHARE 0.03f
#define SWING_MAX_Nm 1.0e6f
#define SWING_CALLS_MAX 65535.0f
// Where the PLL is this much faster than the rotor, the estimated load is mostly noise.
#define SIGMA_RUN_UP_NOISY 78.0f

#ifndef LODE_WITHOUT_SHAPED_RAMP

// Share of the jerk that the end of a ramp is planned with. The rest is for the rounding of steps of up to JERK_CALLS_MAX times
// the jerk: 1.5 of their last bits, each up to 2^-7 of the jerk.
#define JERK_PLANNED 0.96875f
#define JERK_CALLS_MAX 65536.0f // largest number of calls in which a slope builds up
#define JERK_MAX_rad_s3 1.0e12f
#define JERK_AT_ONCE 1.0e15f // rad/s per call, more than any slope: two slopes, no jerk limit

#endif

// (K15): bandwidth with which a rated load takes all of the lowest speed.
static float stopped_rad_s(const lode_speed_config_t *config,
                           const lode_inverter_config_t *inverter, const lode_motor_t *motor) {
    const float load_Nm = LODE_RATED_SHARE * inverter->i_max_A * lode_motor_kt_Nm_A(motor);
    const float load_rad_s2 = motor->pole_pairs * load_Nm / lode_max(motor->J_kgm2, FLT_MIN);
    return DIP * load_rad_s2 / lode_max(config->omega_min_rad_s, FLT_MIN);
}

// (K22), (K37): one over the bandwidth with which a light rotor, behind a PLL of bandwidth `sigma_rad_s`, has no margin.
static float light_s(const light_t *light, const lode_speed_loop_t *loop, float sigma_rad_s) {
    return (light->one + light->delay * loop->delay_s * sigma_rad_s) /
           lode_max(sigma_rad_s + loop->damping_rad_s, FLT_MIN);
}

// (K16): one over the bandwidth with which the loop through an error of Lq, the angle and this PLL has no margin.
static float turned_s(const lode_motor_t *motor, float sigma_rad_s) {
    const float turned_rad_A = LODE_L_UNSURE * motor->Lq_H / lode_max(motor->psi_Wb, FLT_MIN);
    const float turned_rad_Nm = turned_rad_A / lode_max(lode_motor_kt_Nm_A(motor), FLT_MIN);
    return TURNED_PER_SIGMA * sigma_rad_s * turned_rad_Nm * motor->J_kgm2 /
           lode_max(motor->pole_pairs, FLT_MIN);
}

// The largest bandwidth with a margin for a rotor four times lighter (K22), and with less of one if Lq is wrong as well (K44).
// `share`: of the load, fed forward.
static float most_rad_s(const lode_motor_t *motor, const lode_speed_loop_t *loop, float sigma_rad_s,
                        float share) {
    const float later = 1.0f + LIGHT_FED * share * loop->delay_s * sigma_rad_s;
    const float light = later * light_s(&four_times, loop, sigma_rad_s);
    const float turned = turned_s(motor, sigma_rad_s);
    const float left = BOTH_SHARE - share * FED_PER_SIGMA * sigma_rad_s * turned;
    return lode_min(1.0f / lode_max(LIGHT_GAIN_MARGIN * light, FLT_MIN),
                    left / lode_max(light + turned, FLT_MIN));
}

// (K40): the share of the load that (K22) and (K44) leave to a feed-forward.
static float fed_share(const lode_motor_t *motor, const lode_speed_loop_t *loop, float sigma_rad_s,
                       float bandwidth_rad_s) {
    const float light = bandwidth_rad_s * light_s(&four_times, loop, sigma_rad_s);
    const float turned = bandwidth_rad_s * turned_s(motor, sigma_rad_s);
    const float later = LIGHT_FED * loop->delay_s * sigma_rad_s * light; // by the whole load
    const float like_more = FED_PER_SIGMA * sigma_rad_s * turned_s(motor, sigma_rad_s);
    const float by_both = (BOTH_SHARE - light - turned) / lode_max(later + like_more, FLT_MIN);
    const float by_light = (1.0f / LIGHT_GAIN_MARGIN - light) / lode_max(later, FLT_MIN);
    return lode_min(by_both, by_light);
}

// (K46): what is left at speed of a share of the load that is fed forward.
static float left_at_speed(const lode_pll_config_t *pll) {
    const float slower = pll->sigma_low_rad_s / lode_max(pll->sigma_rad_s, FLT_MIN);
    return slower * slower;
}

// (K40), at low speed and at speed. LODE_NONE: the margins leave no share, or the estimated load is noise.
static float default_share(const lode_motor_t *motor, const lode_speed_loop_t *loop,
                           const lode_pll_config_t *pll, float bandwidth_rad_s, float run_up_s) {
    const float slow = fed_share(motor, loop, pll->sigma_low_rad_s, bandwidth_rad_s);
    const float fast = fed_share(motor, loop, pll->sigma_rad_s, bandwidth_rad_s) /
                       lode_max(left_at_speed(pll), FLT_MIN);
    const float share = lode_min(lode_min(slow, fast), LOAD_FEED_FORWARD);
    const bool noisy = pll->sigma_low_rad_s * run_up_s > SIGMA_RUN_UP_NOISY;
    return !noisy && share > LEAST_FEED_FORWARD ? share : LODE_NONE;
}

// Bandwidth at low speed (K37). `holds`: where a rated load would otherwise stop the rotor, more than a share of sigma, as far as
// the margins allow it at every speed; and where they leave too little, with a margin for a rotor three times lighter.
static float firm_rad_s(const lode_motor_t *motor, const lode_speed_loop_t *loop,
                        const lode_pll_config_t *pll, float stopped, bool holds) {
    const float sigma = lode_max(pll->sigma_low_rad_s, FLT_MIN);
    const float most = most_rad_s(motor, loop, sigma, 0.0f);
    const float light =
        1.0f / lode_max(LIGHT_GAIN_MARGIN * light_s(&four_times, loop, sigma), FLT_MIN);
    const float least = lode_min(light, FIRM_TIMES * stopped);
    const float firm = lode_min(BANDWIDTH_PER_SIGMA * sigma, lode_max(most, least));
    if (!holds) {
        return firm;
    }
    static const light_t three_times = {0.38f, 3.4f};
    const float most_fast = most_rad_s(motor, loop, pll->sigma_rad_s, 0.0f);
    const float wanted = lode_min(HELD_TIMES * stopped, lode_min(most, most_fast));
    const float less_light = LIGHT_GAIN_MARGIN * light_s(&three_times, loop, sigma);
    const float needed = lode_min(STOPPED_TIMES * stopped, 1.0f / lode_max(less_light, FLT_MIN));
    return lode_max(firm, lode_min(lode_max(wanted, needed), HELD_PER_SIGMA * sigma));
}

void lode_speed_design(lode_speed_config_t *config, const lode_inverter_config_t *inverter,
                       const lode_motor_t *motor, const lode_pll_config_t *pll,
                       const lode_speed_loop_t *loop, float omega_handover_rad_s, bool injects) {
    const float J = lode_max(motor->J_kgm2, FLT_MIN);
    const float sigma = lode_max(pll->sigma_rad_s, FLT_MIN);
    const float sigma_low = lode_max(pll->sigma_low_rad_s, FLT_MIN);
    const bool given = config->kp_Nms > 0.0f;
    const float run_up_s = lode_max(lode_motor_run_up_s(motor, inverter->i_max_A), FLT_MIN);
    config->omega_min_rad_s = lode_given_or(config->omega_min_rad_s, omega_handover_rad_s);
    // with injection no load is too large for a low speed
    const float stopped = injects ? 0.0f : stopped_rad_s(config, inverter, motor);
    const bool sudden = stopped > STOPPED_MAX_rad_s;
    const bool knows = pll->kind == LODE_PLL_LESO; // torque and load; a QPLL does not
    const float firm = firm_rad_s(motor, loop, pll, stopped, knows && !sudden);
    const float quiet = LODE_SPEED_RUN_UP_MAX / run_up_s;
    const float bandwidth = given ? config->kp_Nms / J : lode_min(firm, quiet);
    config->bandwidth_rad_s = lode_given_or(config->bandwidth_rad_s, bandwidth);
    const float share = knows && (injects || sudden)
                            ? default_share(motor, loop, pll, config->bandwidth_rad_s, run_up_s)
                            : LODE_NONE;
    config->load_feed_forward = lode_given_or(config->load_feed_forward, share);
    const float fed = left_at_speed(pll) * lode_max(config->load_feed_forward, 0.0f);
    const float most_fast = lode_min(quiet, most_rad_s(motor, loop, sigma, fed));
    const float rise =
        lode_min(sigma / sigma_low, most_fast / lode_max(config->bandwidth_rad_s, FLT_MIN));
    config->gain_rise =
        lode_given_or(config->gain_rise, given ? 1.0f : lode_clamp(rise, 1.0f, RISE_MAX));
    config->kp_Nms = lode_given_or(config->kp_Nms, config->bandwidth_rad_s * J);
    config->ki_Nm =
        lode_given_or(config->ki_Nm, INTEGRAL_SHARE * config->bandwidth_rad_s * config->kp_Nms);
    const float room = BANDWIDTH_PER_SIGMA_MAX * sigma_low * J / lode_max(config->kp_Nms, FLT_MIN);
    const float dip_gain = injects ? LODE_NONE : lode_min(DIP_GAIN, room - 1.0f);
    config->dip_gain = lode_given_or(config->dip_gain, dip_gain > 0.0f ? dip_gain : LODE_NONE);
    const float rated_Nm = LODE_RATED_SHARE * inverter->i_max_A * lode_motor_kt_Nm_A(motor);
    config->swing_Nm =
        lode_given_or(config->swing_Nm, injects ? LODE_NONE : SWING_SHARE * rated_Nm);
    const float ramp_share =
        lode_min(LODE_SPEED_RAMP_SHARE, RAMP_BANDWIDTH_SHARE * config->bandwidth_rad_s * run_up_s);
    config->ramp_rad_s2 = lode_given_or(config->ramp_rad_s2, ramp_share * inverter->i_max_A *
                                                                 lode_motor_kt_Nm_A(motor) / J);
    config->inertia_feed_forward =
        lode_given_or(config->inertia_feed_forward, INERTIA_FEED_FORWARD);
    if (config->every_period == LODE_AUTO) {
        config->every_period = LODE_OFF;
    }
}

// The ramp has one slope and no jerk limit.
static bool is_plain(const lode_speed_config_t *config) {
    const float up = config->ramp_rad_s2;
    const float down = lode_given_or(config->ramp_down_rad_s2, up);
    return lode_in_range(down, up, up) && lode_in_range(config->jerk_rad_s3, 0.0f, 0.0f);
}

static bool is_slope(float slope_rad_s2) {
    return lode_in_range(slope_rad_s2, 1.0e-3f, 1.0e7f);
}

static bool ramp_is_sound(const lode_speed_config_t *config, float ts_s) {
#ifdef LODE_WITHOUT_SHAPED_RAMP
    (void)ts_s;
    return is_slope(config->ramp_rad_s2) && is_plain(config);
#else
    const float up = config->ramp_rad_s2;
    const float down = lode_given_or(config->ramp_down_rad_s2, up);
    const float least = lode_max(up, down) / (JERK_CALLS_MAX * ts_s);
    return is_slope(up) && is_slope(down) &&
           (is_plain(config) || lode_in_range(config->jerk_rad_s3, 0.0f, 0.0f) ||
            lode_in_range(config->jerk_rad_s3, least, JERK_MAX_rad_s3));
#endif
}

lode_status_t lode_speed_tune(lode_speed_tuning_t *tuning, const lode_speed_config_t *config,
                              const lode_motor_t *motor, const lode_pll_config_t *pll, float ts_s) {
    if (!lode_in_range(config->kp_Nms, 1.0e-9f, 1.0e6f) ||
        !lode_in_range(config->ki_Nm, 0.0f, 1.0e6f) ||
        !lode_in_range(config->gain_rise, 1.0f, RISE_MAX) ||
        !lode_is_none_or_in(config->dip_gain, 0.0f, DIP_GAIN_MAX) ||
        !lode_is_none_or_in(config->swing_Nm, 0.0f, SWING_MAX_Nm)) {
        return LODE_ERROR_SPEED_GAINS;
    }
    if (!lode_in_range(config->bandwidth_rad_s, 1.0e-3f, 1.0e5f) ||
        !(config->kp_Nms <= BANDWIDTH_PER_SIGMA_MAX * pll->sigma_low_rad_s * motor->J_kgm2) ||
        !(config->kp_Nms * config->gain_rise <=
          BANDWIDTH_PER_SIGMA_MAX * pll->sigma_rad_s * motor->J_kgm2)) {
        return LODE_ERROR_SPEED_BANDWIDTH;
    }
    if (!ramp_is_sound(config, ts_s)) {
        return LODE_ERROR_SPEED_RAMP;
    }
    if (!lode_is_none_or_in(config->load_feed_forward, 0.0f, 1.0f) ||
        !lode_is_none_or_in(config->inertia_feed_forward, 0.0f, 1.0f)) {
        return LODE_ERROR_SPEED_FEED_FORWARD;
    }
    if (!lode_is_on_or_off(config->every_period)) {
        return LODE_ERROR_CHOICE;
    }
    const float fed = lode_max(config->load_feed_forward, 0.0f);
    const float swing_calls = SWING_TIMES * LODE_PI / (pll->sigma_low_rad_s * ts_s);
    *tuning = (lode_speed_tuning_t){
        .pi = {config->kp_Nms, config->ki_Nm * ts_s},
        .rise = config->gain_rise - 1.0f,
        // from where the PLL has its full bandwidth to twice that speed, clear of the dead band's ripple
        .inv_span = 1.0f / pll->omega_high_rad_s,
        .inv_pole_pairs = 1.0f / motor->pole_pairs,
        .ramp_step = config->ramp_rad_s2 * ts_s,
        .dip_gain = lode_max(config->dip_gain, 0.0f),
        .swing_Nm = config->swing_Nm > 0.0f ? config->swing_Nm : FLT_MAX,
        .swing_calls = lode_clamp(swing_calls, 1.0f, SWING_CALLS_MAX),
        .dip_least = config->omega_min_rad_s / motor->pole_pairs,
        .load_feed_forward = fed,
        .load_fall = fed * (1.0f - left_at_speed(pll)),
        .inertia_Nm = lode_max(config->inertia_feed_forward, 0.0f) * motor->J_kgm2 / ts_s,
    };
#ifndef LODE_WITHOUT_SHAPED_RAMP
    tuning->ramp_down_step = lode_given_or(config->ramp_down_rad_s2, config->ramp_rad_s2) * ts_s;
    if (!is_plain(config)) {
        const float jerk_step = config->jerk_rad_s3 * ts_s * ts_s;
        tuning->jerk_step = jerk_step > 0.0f ? jerk_step : JERK_AT_ONCE;
    }
#endif
    return LODE_OK;
}

LODE_INLINE void keep_copy(lode_speed_t *self) {
    self->copy = (lode_speed_copy_t){self->pi.integral, self->reference_rad_s};
}

// Sets the reference, at rest.
static void set_reference(lode_speed_t *self, float reference_rad_s) {
    self->reference_rad_s = reference_rad_s;
    self->left_rad_s = 0.0f;
#ifndef LODE_WITHOUT_SHAPED_RAMP
    self->step_rad_s = 0.0f;
#endif
}

void lode_speed_reset(lode_speed_t *self, const lode_speed_tuning_t *tuning, float omega_rad_s,
                      float torque_Nm, float load_Nm, float most_Nm) {
    const float fed = lode_speed_fed(tuning, omega_rad_s / tuning->inv_pole_pairs);
    lode_pi_reset(&self->pi, torque_Nm - fed * load_Nm);
    set_reference(self, omega_rad_s);
    keep_copy(self);
    self->torque_Nm = torque_Nm;
    self->calmed = 0u;
    self->swing_age = 0;
    self->swings = 0;
    self->swung_up = 0u;
    self->limit_Nm = (lode_range_t){-most_Nm, most_Nm};
}

void lode_speed_bound(lode_speed_t *self, float most_rad_s) {
    if (lode_speed_is_whole(self)) {
        self->reference_rad_s = lode_clamp(self->reference_rad_s, -most_rad_s, most_rad_s);
        keep_copy(self);
    }
}

#ifndef LODE_WITHOUT_SHAPED_RAMP

// (K34): the largest step, up to `most_rad_s`, after which steps smaller by `less_rad_s` each still stop within `way_rad_s`.
static float largest_step(float way_rad_s, float most_rad_s, float less_rad_s) {
    const float whole = most_rad_s + less_rad_s;
    // a distance long enough for `most_rad_s`
    const float way = lode_min(way_rad_s, whole * whole / less_rad_s);
    const float root = lode_sqrt(1.0f + 8.0f * way / less_rad_s);
    const float steps = 0.5f * (root - 1.0f);
    const float more = (float)(int32_t)steps; // steps after this one
    return lode_min(way / (more + 1.0f) + 0.5f * more * less_rad_s, most_rad_s);
}

// The distance that such steps cover, beginning with `step_rad_s`.
static float stopping_way(float step_rad_s, float less_rad_s) {
    const float steps = step_rad_s / less_rad_s;
    const float more = (float)(int32_t)steps;
    return (more + 1.0f) * (step_rad_s - 0.5f * more * less_rad_s);
}

// Not LODE_RAMFUNC: an option, once in some periods.
LODE_NOINLINE float lode_speed_shaped_step(lode_speed_t *self, const lode_speed_tuning_t *tuning,
                                           float target_rad_s) {
    const float before = self->reference_rad_s;
    const float target = lode_is_finite(target_rad_s) ? target_rad_s : before;
    const float way = target - before - self->left_rad_s;
    const float jerk = tuning->jerk_step;
    const float less = JERK_PLANNED * jerk;
    float ahead = lode_abs(way);
    float most = tuning->ramp_step;
    if (way * before < 0.0f) { // slowing down; beyond zero the other slope is the limit
        const float through = lode_abs(before) + stopping_way(most, less);
        ahead = lode_min(ahead, through);
        most = tuning->ramp_down_step;
    }
    const float size = largest_step(ahead, most, less);
    const float last = self->step_rad_s;
    const float step = lode_clamp(way < 0.0f ? -size : size, last - jerk, last + jerk);
    self->step_rad_s = step;
    if (lode_in_range(step, way, way)) { // the last one
        self->reference_rad_s = target;
        self->left_rad_s = 0.0f;
        return step;
    }
    lode_add_small(&self->reference_rad_s, &self->left_rad_s, step);
    return step;
}

#endif

// The rotor lacks so much of the reference.
LODE_INLINE bool dips(const lode_speed_t *self, float gain, float error) {
    const float reference = self->reference_rad_s;
    return error * reference > LODE_SPEED_DIP_SHARE * gain * reference * reference;
}

// Further torque where a load has taken more than LODE_SPEED_DIP_SHARE of the speed (K47). `error`: of the speed, with the gain's
// factor `gain`. Gains that are halved once are whole again. Not LODE_RAMFUNC: rare.
static LODE_NOINLINE float dip_Nm(const lode_speed_t *self, const lode_speed_tuning_t *tuning,
                                  float gain, float error) {
    const float reference = self->reference_rad_s;
    const float lacking = error - LODE_SPEED_DIP_SHARE * gain * reference;
    const float whole = self->calmed == 0u ? 1.0f : 1.0f / LODE_SPEED_CALM;
    const float more = (1.0f + tuning->dip_gain) * whole - 1.0f;
    return lode_abs(reference) >= tuning->dip_least ? more * tuning->pi.kp * lacking : 0.0f;
}

// A half-wave in the other direction than the last one (K48). Not LODE_RAMFUNC: rare.
static LODE_NOINLINE void count_swing(lode_speed_t *self) {
    self->swung_up = self->swung_up == 0u ? 1u : 0u;
    self->swing_age = 0;
    self->swings++;
    if ((uint32_t)self->swings >= SWINGS) {
        self->swings = 0;
        self->calmed = lode_speed_calmer(self->calmed);
    }
}

// Watches the correction `torque_Nm` for swings (K48).
LODE_INLINE void watch_swing(lode_speed_t *self, const lode_speed_tuning_t *tuning,
                             float torque_Nm) {
    if ((self->swung_up != 0u ? -torque_Nm : torque_Nm) > tuning->swing_Nm) {
        count_swing(self);
    } else if ((float)self->swing_age < tuning->swing_calls) {
        self->swing_age++;
    } else {
        self->swings = 0;
    }
}

LODE_RAMFUNC LODE_NOINLINE float lode_speed_step(lode_speed_t *self,
                                                 const lode_speed_tuning_t *tuning,
                                                 float target_rad_s, float omega_rad_s,
                                                 float load_Nm) {
    const float step = lode_speed_ramp(self, tuning, target_rad_s);
    const float calm = lode_speed_calm(self);
    const float gain = calm * lode_speed_gain(tuning, omega_rad_s);
    const float error = gain * (self->reference_rad_s - omega_rad_s * tuning->inv_pole_pairs);
    // A rotor ahead of its ramp needs no torque to follow it: the controller's opposing torque is taken off the ramp's, but not
    // beyond zero.
    const float push = calm * tuning->inertia_Nm * step;
    const float against = tuning->pi.kp * error;
    watch_swing(self, tuning, against);
    const float ramp = push > 0.0f ? lode_clamp(push + against, 0.0f, push)
                                   : lode_clamp(push + against, push, 0.0f);
    const float ff = lode_speed_fed(tuning, omega_rad_s) * load_Nm + ramp;
    float unlimited = lode_pi_output(&self->pi, &tuning->pi, error, ff);
    if (dips(self, gain, error)) {
        // like the proportional part, it takes no room from the integral
        unlimited += dip_Nm(self, tuning, gain, error);
    }
    const lode_range_t limit = self->limit_Nm;
    float torque = unlimited;
    if (lode_in_range(unlimited, limit.min, limit.max)) {
        lode_pi_integrate(&self->pi, &tuning->pi, error);
    } else {
        torque = lode_clamp(unlimited, limit.min, limit.max);
        lode_pi_settle(&self->pi, &tuning->pi, error, ff, unlimited, torque);
    }
    keep_copy(self);
    self->torque_Nm = torque;
    return torque;
}

#ifndef LODE_WITHOUT_TORQUE_CONTROL

// The estimated load, and the part of it that is fed forward.
typedef struct {
    float all_Nm;
    float fed_Nm;
} load_t;

// Torque of speed control at an end of the range: with its integral if it holds that end already, else with the load in the
// integral's place (K13).
static float torque_at(const lode_speed_t *self, const lode_speed_tuning_t *tuning, float gain,
                       float error, load_t load, bool holds) {
    if (!holds) {
        return tuning->pi.kp * error + load.all_Nm;
    }
    const float torque = lode_pi_output(&self->pi, &tuning->pi, error, load.fed_Nm);
    return dips(self, gain, error) ? torque + dip_Nm(self, tuning, gain, error) : torque;
}

// Not LODE_RAMFUNC: once in a round.
LODE_NOINLINE float lode_speed_torque_target(lode_speed_t *self, const lode_speed_tuning_t *tuning,
                                             float torque_Nm, lode_range_t between_rad_s,
                                             float omega_rad_s, float load_Nm) {
    const float speed = omega_rad_s * tuning->inv_pole_pairs;
    const float gain = lode_speed_calm(self) * lode_speed_gain(tuning, omega_rad_s);
    const load_t load = {load_Nm, lode_speed_fed(tuning, omega_rad_s) * load_Nm};
    const float torque = lode_clamp(torque_Nm, self->limit_Nm.min, self->limit_Nm.max);
    const bool at_most = !(self->reference_rad_s < between_rad_s.max);
    const bool at_least = !(self->reference_rad_s > between_rad_s.min);
    float target = speed; // the present speed, at this torque
    float held_Nm = torque;
    bool holds = false;
    if (torque > torque_at(self, tuning, gain, gain * (between_rad_s.max - speed), load, at_most)) {
        target = between_rad_s.max;
        held_Nm = load_Nm;
        holds = at_most;
    } else if (torque <
               torque_at(self, tuning, gain, gain * (between_rad_s.min - speed), load, at_least)) {
        target = between_rad_s.min;
        held_Nm = load_Nm;
        holds = at_least;
    } else {
        // between the ends
    }
    if (!holds) {
        lode_pi_reset(&self->pi, held_Nm - load.fed_Nm);
    }
    set_reference(self, target);
    keep_copy(self);
    return target;
}

#endif
