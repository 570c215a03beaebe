#include "hfi_inline.h"
#include "inverter_inline.h"
#include "pll_inline.h"

// Least ripple, peak to peak, over i_max: with less the currents stay in the dead band of the inverter.
#define RIPPLE_SHARE 0.08f
// Position error of one period by noise of the current, rms (H7). Behind a PLL of 100 rad/s at 5 kHz it is 0.6 degrees (H8).
#define NOISE_rad 0.03f
// As many times that where the circle does not allow more voltage.
#define NOISE_TIMES 2.0f
// (H7): sqrt(6)/2, the second difference of white noise over twice the voltage.
#define NOISE_GAIN 1.2247f
// Noise of a 12-bit ADC and its amplifier: 20 mA of +-25 A.
#define NOISE_COUNTS 1.6f
// Position error, rad, by a dead-time voltage that changes with the sign of a current (H9): by default, and at most.
#define DEAD_TIME_rad 0.3f
#define DEAD_TIME_MAX_rad 0.5f
// Largest share of the voltage circle. The rest drives the load: at w2 the EMF itself is small.
#define CIRCLE_SHARE 0.5f
// (H10): EMF at w2 over the fundamental, 4/pi, of the error of a dead-time correction that is 20 % off.
#define EMF_TIMES 10.0f
#define CORRECTION_ERROR 0.2f
// Least w2 over rated speed: w1 is then almost twice the speed at which an I-f start hands over. W1_SHARE is of w2.
#define W2_SHARE 0.275f
#define W1_SHARE 0.65f
// For learning Lq: w1 is then 0.42 of rated speed, where a dead-time error is small compared to the EMF. It is less where EMF
// and reactance at half of i_max would leave the wave too little of the circle.
#define W2_LEARN_SHARE 0.65f
#define CIRCLE_LEARN_SHARE 0.9f
// Largest sigma Ts: an error at its limit then lengthens the PLL's rotation to 1.07 within a round.
#define SIGMA_TS_MAX 0.1f
#define AXIS_MAX_rad 0.5f
// With less saliency (1.5, less rounding) id is positive by default: at 1.2 the rotor is lost without it.
#define SALIENCY_ENOUGH 1.49f
#define ID_SHARE 0.3f
// Start at rest: time for the axis, whose angle turns at 50 rad/s while the error is at its limit. It is extended up to
// FIND_TIMES; either current for the polarity has half of it.
#define FIND_s 0.08f
#define FIND_TIMES 3u
// Of i_max: enough to change Ld by some percent.
#define POLAR_SHARE 0.33f
// (H15): least relative difference of the responses. Without saturation it was at most 0.0044 in 100 simulated starts, with
// an Ld that falls by 2.6 % over twice the current 0.011 and more.
#define POLAR_LEAST 0.008f
// (H21): the difference must also be this many times its standard deviation by noise.
#define POLAR_DEVIATIONS 4.0f
// (H27): a rotor has moved if it turns at this share of the loop's bandwidth, ten times the noise of its speed, and is this
// far from where it was.
#define MOVES_SHARE 0.1f
#define MOVED_rad 0.15f
// Time over that for the axis in which the current across it rises. The push then waits as long again.
#define PUSH_TIMES 3u
// Mean error at which the axis counts as found.
#define FOUND_rad 0.15f
// Low-pass of the i_q that turns the axis (H6): slower than current control, faster than the load.
#define IQ_rad_s 500.0f
// Of H0: the least excitation by which (H4) divides.
#define LEAST_SHARE 0.3f
// Injection ends a little above the speed at which it begins.
#define HYSTERESIS 1.05f
// (H29): least swing by the wave, of the expected one. Without a fault it was at least 0.6, with Ld and Lq 20 % off.
#define SHOWN_SHARE 0.5f
// The round in which the wave begins, and the one in which the currents begin to show it.
#define EARLY_ROUNDS 2u
// Fault after two rounds in a row with less swing than any axis leaves (one may have only the beginning of the wave), or after
// eight below half.
#define WEAK_MAX 8u
#define WEAK_EACH 4u
// (S54): share of a rated load which a start must move; by how much (Lq - Ld)/psi may be
// larger than configured, with errors of 20 % in Lq and Ld and 10 % in psi.
#define START_LOAD 0.8f
#define UNSURE 1.5f
// Mean error at which the lock quality is 0 (H13).
#define OFF_rad 0.35f

// d(psi_q)/d(i_q) at i_max, for a flux Lq i/(1 + k i).
static float differential_Lq(const lode_hfi_system_t *system) {
    const float by = 1.0f + system->Lq_fall * system->inverter->i_max_A;
    return system->motor->Lq_H / (by * by);
}

static float saliency(const lode_hfi_config_t *config, const lode_hfi_system_t *system) {
    return config->Lq_i_max_H / lode_max(system->motor->Ld_H, FLT_MIN);
}

// Voltage that a phase loses to dead time and drops.
static float dead_time_V(const lode_hfi_system_t *system) {
    const lode_inverter_config_t *inverter = system->inverter;
    const float carrier_Hz = lode_inverter_carrier_Hz(inverter, 1.0f / system->ts_s);
    return inverter->v_bus_V * inverter->dead_time_s * carrier_Hz + inverter->v_drop_V;
}

// The largest of the voltages that noise (H7), dead time (H9) and dead band ask for, as far as the circle allows it; 0: no voltage
// shows a round rotor.
static float needed_V(const lode_hfi_config_t *config, const lode_hfi_system_t *system) {
    const float more = saliency(config, system) - 1.0f;
    if (!(more > 0.0f)) {
        return 0.0f;
    }
    const float per_A = system->motor->Ld_H / system->ts_s;
    const float noise_V = NOISE_GAIN / NOISE_rad * config->noise_A * per_A * (1.0f + 1.0f / more);
    const float dead_V = dead_time_V(system) / (DEAD_TIME_rad * more);
    const float ripple_V = RIPPLE_SHARE * system->inverter->i_max_A * per_A;
    const float asked_V =
        lode_max(lode_max(noise_V, dead_V), config->silent == LODE_ON ? 0.0f : ripple_V);
    const float most_V = CIRCLE_SHARE * system->circle_V;
    return noise_V > NOISE_TIMES * most_V ? asked_V : lode_min(asked_V, most_V);
}

static uint_least16_t rounds_in(float time_s, float ts_s) {
    return (uint_least16_t)((uint32_t)(int32_t)(time_s / ((float)LODE_SLOW_PERIODS * ts_s)) + 1u);
}

#ifdef LODE_WITHOUT_HFI

static lode_status_t check(const lode_hfi_config_t *config, const lode_hfi_system_t *system) {
    (void)config, (void)system;
    return LODE_ERROR_HFI_MODE;
}

#else

static lode_status_t check_voltage(const lode_hfi_config_t *config,
                                   const lode_hfi_system_t *system) {
    const float xi = saliency(config, system);
    const bool rises = system->motor->Lq_H > system->motor->Ld_H;
    if (!system->active_flux) {
        return LODE_ERROR_HFI_FLUX;
    }
    if (!rises || !lode_in_range(xi, LODE_HFI_SALIENCY_MIN, FLT_MAX)) {
        return LODE_ERROR_HFI_SALIENCY;
    }
    if (!lode_in_range(config->V_h_V, FLT_MIN, CIRCLE_SHARE * system->circle_V) ||
        !lode_in_range(config->noise_A, 0.0f, system->inverter->i_max_A)) {
        return LODE_ERROR_HFI_VOLTAGE;
    }
    return dead_time_V(system) <= DEAD_TIME_MAX_rad * config->V_h_V * (xi - 1.0f)
               ? LODE_OK
               : LODE_ERROR_HFI_DEAD_TIME;
}

static lode_status_t check(const lode_hfi_config_t *config, const lode_hfi_system_t *system) {
    const lode_status_t status = check_voltage(config, system);
    if (status != LODE_OK) {
        return status;
    }
    if (!lode_in_range(config->w2_rad_s, 1.0f, system->omega_max_rad_s) ||
        !lode_in_range(config->w1_rad_s, 0.1f, 0.95f * config->w2_rad_s)) {
        return LODE_ERROR_HFI_SPEEDS;
    }
    if (!lode_in_range(config->sigma_rad_s, 1.0f, SIGMA_TS_MAX / system->ts_s)) {
        return LODE_ERROR_HFI_SIGMA;
    }
    if (!lode_is_none_or_in(config->id_A, 0.0f, system->inverter->i_max_A)) {
        return LODE_ERROR_ID_BIAS;
    }
    return lode_abs(config->k_x_rad_A) * system->inverter->i_max_A <= AXIS_MAX_rad
               ? LODE_OK
               : LODE_ERROR_HFI_AXIS;
}

#endif

// Highest w2 at which Lq can be learned, for the given V_h.
static float learning_speed(const lode_hfi_config_t *config, const lode_hfi_system_t *system) {
    const lode_motor_t *motor = system->motor;
    const float across_Wb = 0.5f * system->inverter->i_max_A * motor->Lq_H;
    const float flux_Wb = lode_sqrt(motor->psi_Wb * motor->psi_Wb + across_Wb * across_Wb);
    const float left_V = CIRCLE_LEARN_SHARE * system->circle_V - config->V_h_V;
    return lode_min(W2_LEARN_SHARE * motor->omega_rated_rad_s, left_V / lode_max(flux_Wb, FLT_MIN));
}

// (S54). The current vector that lets the active flux vanish makes less torque than the load that a start has to move.
static bool is_start_weak(const lode_hfi_system_t *system) {
    const lode_motor_t *motor = system->motor;
    const float load_A = START_LOAD * LODE_RATED_SHARE * system->inverter->i_max_A;
    return UNSURE * (motor->Lq_H - motor->Ld_H) * load_A > motor->psi_Wb;
}

void lode_hfi_design(lode_hfi_config_t *config, const lode_hfi_system_t *system) {
    const lode_motor_t *motor = system->motor;
    config->learn = config->learn == LODE_AUTO ? LODE_OFF : config->learn;
    config->silent = config->silent == LODE_AUTO ? LODE_OFF : config->silent;
    // The machine's current is the mean of its sets' currents, which averages the noise.
    const float noise_A =
        NOISE_COUNTS * lode_abs(system->count_A) / lode_sqrt(lode_max(motor->sets, 1.0f));
    config->noise_A = lode_given_or(config->noise_A, noise_A);
    config->Lq_i_max_H = lode_given_or(config->Lq_i_max_H, differential_Lq(system));
    config->V_h_V = lode_given_or(config->V_h_V, needed_V(config, system));
    const float error_V = FOUR_PER_PI * CORRECTION_ERROR * dead_time_V(system);
    float w2 = lode_max(EMF_TIMES * error_V / lode_max(motor->psi_Wb, FLT_MIN),
                        W2_SHARE * motor->omega_rated_rad_s);
    if (config->learn == LODE_ON) {
        w2 = lode_max(w2, learning_speed(config, system));
    }
    config->w2_rad_s = lode_given_or(config->w2_rad_s, w2);
    config->w1_rad_s = lode_given_or(config->w1_rad_s, W1_SHARE * config->w2_rad_s);
    const float id_A = saliency(config, system) < SALIENCY_ENOUGH
                           ? ID_SHARE * system->inverter->i_max_A
                           : LODE_NONE;
    config->id_A = lode_given_or(config->id_A, id_A);
    const float sigma_max = SIGMA_TS_MAX / lode_max(system->ts_s, FLT_MIN);
    config->sigma_rad_s =
        lode_given_or(config->sigma_rad_s, lode_min(system->sigma_rad_s, sigma_max));
    if (config->mode == LODE_HFI_DEFAULT) {
        const bool on = is_start_weak(system) && check(config, system) == LODE_OK;
        config->mode = on ? LODE_HFI_ON : LODE_HFI_OFF;
    }
    if (config->mode == LODE_HFI_AUTO) {
        config->mode = check(config, system) == LODE_OK ? LODE_HFI_ON : LODE_HFI_OFF;
        config->learn = config->mode == LODE_HFI_ON ? config->learn : LODE_OFF;
    }
}

bool lode_hfi_is_missed(const lode_hfi_config_t *config, const lode_hfi_system_t *system) {
    return config->mode == LODE_HFI_OFF && is_start_weak(system) &&
           check(config, system) != LODE_OK;
}

lode_status_t lode_hfi_tune(lode_hfi_tuning_t *tuning, const lode_hfi_config_t *config,
                            const lode_hfi_system_t *system) {
    const bool on = config->mode == LODE_HFI_ON;
    if (!on && config->mode != LODE_HFI_OFF) {
        return LODE_ERROR_HFI_MODE;
    }
    if (config->learn != LODE_OFF && (config->learn != LODE_ON || !on)) {
        return LODE_ERROR_HFI_LEARN;
    }
    if (!lode_is_on_or_off(config->silent)) {
        return LODE_ERROR_CHOICE;
    }
    *tuning = lode_hfi_none();
    if (!on) {
        return LODE_OK;
    }
    const lode_status_t status = check(config, system);
    if (status != LODE_OK) {
        return status;
    }
    const lode_motor_t *motor = system->motor;
    const float full_V = 2.0f * config->V_h_V * (motor->Lq_H - motor->Ld_H) / motor->Ld_H;
    const float least_V = LEAST_SHARE * full_V;
    *tuning = (lode_hfi_tuning_t){
        .V_h_V = config->V_h_V,
        .omega_high = config->w2_rad_s,
        .inv_span = 1.0f / (config->w2_rad_s - config->w1_rad_s),
        .inv_full = 1.0f / full_V,
        .least_V2 = lode_max(least_V * least_V, FLT_MIN),
        .k_x = config->k_x_rad_A,
        .iq_weight = lode_one_minus_exp(IQ_rad_s * (float)LODE_SLOW_PERIODS * system->ts_s),
        .find_gain = lode_one_minus_exp(config->sigma_rad_s * system->ts_s),
        .find_rounds = rounds_in(FIND_s, system->ts_s),
        .silent = config->silent == LODE_ON ? 1u : 0u,
    };
    return LODE_OK;
}

#ifndef LODE_WITHOUT_HFI

void lode_hfi_begin(lode_hfi_t *self, const lode_hfi_tuning_t *tuning, lode_dq_t i_A) {
    // the shift register may begin with anything but 0
    *self = (lode_hfi_t){
        .active = true, .signs = tuning->silent, .weight = 1.0f, .i_A = i_A, .early = EARLY_ROUNDS};
}

static uint32_t polar_rounds(const lode_hfi_tuning_t *tuning) {
    return ((uint32_t)tuning->find_rounds + 1u) / 2u;
}

// (H15): current along the magnet's north saturates the iron, which makes the response larger. `start` has sums over the
// later half of each current.
static lode_hfi_step_t polarity(const lode_hfi_start_t *start, const lode_hfi_tuning_t *tuning) {
    const uint32_t each = polar_rounds(tuning) - polar_rounds(tuning) / 2u;
    const float along_V = start->along_V;
    const float against_V = start->against_V;
    const float more_V = along_V - against_V;
    const float least_V = POLAR_LEAST * (along_V + against_V);
    const float scatter_V2 = start->squares_V2 - (along_V * along_V + against_V * against_V) /
                                                     lode_max((float)each, 1.0f);
    const float least_V2 = POLAR_DEVIATIONS * POLAR_DEVIATIONS * scatter_V2; // (H21)
    if (more_V * more_V <= lode_max(least_V * least_V, least_V2)) {
        return LODE_HFI_PUSH;
    }
    return more_V > 0.0f ? LODE_HFI_RIGHT : LODE_HFI_WRONG;
}

static lode_hfi_step_t next_step(const lode_hfi_t *self, const lode_hfi_tuning_t *tuning) {
    const lode_hfi_start_t *start = &self->of.start;
    switch ((lode_hfi_step_t)self->step) {
    case LODE_HFI_FIND:
        if (self->off_rad <= FOUND_rad) {
            return LODE_HFI_NORTH;
        }
        return start->rounds < FIND_TIMES * tuning->find_rounds ? LODE_HFI_FIND
                                                                : LODE_HFI_UNDECIDED;
    case LODE_HFI_NORTH:
        return LODE_HFI_SOUTH;
    case LODE_HFI_SOUTH:
    case LODE_HFI_PUSH:
    case LODE_HFI_RIGHT:
    case LODE_HFI_WRONG:
    case LODE_HFI_UNDECIDED:
    default:
        return polarity(start, tuning);
    }
}

// Ends the step and begins the next one.
static void go_on(lode_hfi_t *self, lode_hfi_step_t next) {
    if (next == LODE_HFI_FIND) {
        return; // the present step is extended
    }
    self->step = (uint_least8_t)next;
    self->of.start.rounds = 0u;
    if (next == LODE_HFI_PUSH) {
        self->of.push = (lode_hfi_push_t){.rounds = 0u};
    }
    if (next == LODE_HFI_RIGHT || next == LODE_HFI_WRONG) {
        self->of.iq_A = self->i_A.q;
    }
}

float lode_hfi_find(lode_hfi_t *self, const lode_hfi_tuning_t *tuning, float i_max_A) {
    const bool finding = self->step == (uint_least8_t)LODE_HFI_FIND;
    const uint32_t rounds = finding ? tuning->find_rounds : polar_rounds(tuning);
    lode_hfi_start_t *start = &self->of.start;
    start->rounds++;
    if (!finding && 2u * start->rounds > rounds) { // the current has settled
        *(self->step == (uint_least8_t)LODE_HFI_NORTH ? &start->along_V : &start->against_V) +=
            self->swing_V;
        start->squares_V2 += self->swing_V * self->swing_V;
    }
    if (start->rounds >= rounds) {
        go_on(self, next_step(self, tuning));
    }
    const float polar_A = POLAR_SHARE * i_max_A;
    if (self->step == (uint_least8_t)LODE_HFI_NORTH) {
        return polar_A;
    }
    return self->step == (uint_least8_t)LODE_HFI_SOUTH ? -polar_A : 0.0f;
}

// (H27). `share`: speed over the bandwidth, positive in the direction of the current.
static lode_hfi_step_t moved(const lode_hfi_push_t *push, lode_sincos_t rotor, float share,
                             float direction) {
    const float off = direction * lode_angle_subtract(rotor, push->from).sin;
    if (push->rounds == 0u && lode_abs(share) > MOVES_SHARE) {
        return LODE_HFI_UNDECIDED; // something else moves it
    }
    if (share > MOVES_SHARE && off > MOVED_rad) {
        return LODE_HFI_RIGHT;
    }
    return share < -MOVES_SHARE && off < -MOVED_rad ? LODE_HFI_WRONG : LODE_HFI_PUSH;
}

float lode_hfi_push(lode_hfi_t *self, const lode_hfi_tuning_t *tuning, lode_sincos_t rotor,
                    float step_rad, float direction) {
    lode_hfi_push_t *push = &self->of.push;
    const uint32_t rise = PUSH_TIMES * (uint32_t)tuning->find_rounds;
    if (push->rounds == 0u) {
        push->from = rotor;
    }
    const float share = step_rad / lode_max(tuning->find_gain, FLT_MIN);
    const lode_hfi_step_t next = moved(push, rotor, share, direction);
    push->rounds++;
    const float risen = (float)(int32_t)push->rounds / lode_max((float)(int32_t)rise, 1.0f);
    if (next != LODE_HFI_PUSH) {
        go_on(self, next);
    } else if (push->rounds >= 2u * rise) {
        go_on(self, LODE_HFI_UNDECIDED);
    } else {
        // on its way
    }
    return lode_min(risen, 1.0f);
}

void lode_hfi_turn_round(lode_hfi_t *self) {
    self->of.iq_A = -self->of.iq_A;
    self->i_A = (lode_dq_t){-self->i_A.d, -self->i_A.q};
    self->h_V = -self->h_V;
    self->q_V = -self->q_V;
}

bool lode_hfi_follow(lode_hfi_t *self, const lode_hfi_tuning_t *tuning, lode_dq_t i_A,
                     float omega_rad_s) {
    const float speed = lode_abs(omega_rad_s);
    const float most = self->active ? HYSTERESIS * tuning->omega_high : tuning->omega_high;
    if (!(speed < most)) {
        return false;
    }
    if (!self->active) {
        lode_hfi_begin(self, tuning, i_A);
        self->of.iq_A = i_A.q;
    }
    const bool random = (self->signs & LODE_HFI_RANDOM) != 0u;
    const bool silent = tuning->silent > 0u;
    if (random != silent) { // another tuning; the sign last used stays
        self->signs = (uint_least16_t)((self->signs & LODE_HFI_NEGATIVE) | tuning->silent);
    }
    self->weight = lode_clamp((tuning->omega_high - speed) * tuning->inv_span, 0.0f, 1.0f);
    if (lode_abs(tuning->k_x) > 0.0f) {
        self->of.iq_A += tuning->iq_weight * (self->i_A.q - self->of.iq_A);
        const float eps = lode_clamp(tuning->k_x * self->of.iq_A, -AXIS_MAX_rad, AXIS_MAX_rad);
        self->axis = eps * (1.0f + 1.0f / 3.0f * eps * eps); // tan, to 1 % at its limit
    }
    return true;
}

bool lode_hfi_shows_wave(lode_hfi_t *self, const lode_hfi_tuning_t *tuning, bool searches,
                         float least) {
    if (self->early > 0u) {
        self->early--;
        return true;
    }
    const float swing = lode_hfi_swing(self, tuning);
    const bool found = !searches && self->off_rad < OFF_rad;
    self->shown = self->shown || (found && !(swing < SHOWN_SHARE));
    if (swing < SHOWN_SHARE * least) {
        self->weak = (uint_least8_t)(self->weak + WEAK_EACH);
    } else if (found && self->shown && swing < SHOWN_SHARE) {
        self->weak++;
    } else {
        self->weak = 0u;
    }
    return self->weak < WEAK_MAX;
}

float lode_hfi_quality(lode_hfi_t *self, const lode_hfi_tuning_t *tuning, float weight) {
    const float off_rad = lode_min(lode_abs(self->error), LODE_HFI_ERROR_MAX_rad);
    self->off_rad += weight * (off_rad - self->off_rad);
    self->swing_V = 1.0f / (float)LODE_SLOW_PERIODS * self->sum_V;
    self->sum_V = 0.0f;
    const float swing = lode_min(lode_hfi_swing(self, tuning), 1.0f);
    return swing * lode_max(1.0f - 1.0f / OFF_rad * self->off_rad, 0.0f);
}

#endif
