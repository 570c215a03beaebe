#include "lodestar/fly.h"

#define PEAK_SHARE 0.8f     // of i_max, by a pulse at the highest speed
#define TARGET_SHARE 0.1f   // of i_max, at t_k: the pulse goes on to twice that
#define SEEN_SHARE 0.003f   // of i_max: some three counts, and so within 10 degrees
#define SHARE_MAX 0.5f      // the current must decay before the next pulse
#define FIRST_MAX 0.05f     // of the period: short enough for an EMF that is nearly that of the bus
#define DECAY_SHARE 0.8f    // of the time in which it just does
#define FITS 1.2f           // of the longest share: another look at the EMF moves that too
#define ACTED_MIN 0.3f      // of a pulse that dead time may have taken
#define GROWTH 2.0f         // of a pulse that shows nothing: it may come to three times
#define UNKNOWN_s 1.0e-6f   // of dead time
#define TURN_rad 3.0f       // seen turning by so much, the speed is known to a few per cent ...
#define TURN_LEAST_rad 0.5f // ... by so much to some 20 %
#define SCATTER_MAX_rad 0.5f // rms about the line; of noise alone it is some 1.6 and more
#define TURN_PERIODS 12u     // of it, at least
#define TURN_PART (LODE_SLOW_PERIODS / 2u) // half of the time in which a rotor is looked for
#define LEAST_SHARE 0.75f                  // of the speed from which the estimator may take over
#define FLUX_LOW                                                                                   \
    0.5f // of the configured flux, by the size of the vectors: the inductance may be 20 % off
#define FLUX_HIGH 1.6f  // the same, upwards
#define LOST_SHARE 0.5f // of the current that is seen: noise alone is rarely that, and not for long
#define GONE_SHARE 0.25f // of the current of a pulse
#define SETTLE 2u        // periods from a new share to its first sample

#ifdef LODE_WITHOUT_FLYING_START

lode_status_t lode_fly_tune(lode_fly_tuning_t *tuning, const lode_start_config_t *config,
                            const lode_inverter_config_t *inverter, const lode_motor_t *motor,
                            float omega_max_rad_s, float duty_max, float ts_s) {
    (void)inverter, (void)motor, (void)omega_max_rad_s, (void)duty_max, (void)ts_s;
    *tuning = (lode_fly_tuning_t){.share_first = 0.0f};
    return config->pulses == LODE_ON ? LODE_ERROR_CHOICE : LODE_OK;
}

#else

// To which the pulses go back where the EMF is nearly that of the bus.
static float window(float duty_max) {
    return lode_max(FIRST_MAX, 1.0f - duty_max);
}

lode_status_t lode_fly_tune(lode_fly_tuning_t *tuning, const lode_start_config_t *config,
                            const lode_inverter_config_t *inverter, const lode_motor_t *motor,
                            float omega_max_rad_s, float duty_max, float ts_s) {
    if (!lode_is_choice(config->pulses)) {
        return LODE_ERROR_CHOICE;
    }
    // (S22): what the largest EMF drives through the smaller inductance.
    const float rise_A =
        motor->psi_Wb * omega_max_rad_s * ts_s / lode_min(motor->Ld_H, motor->Lq_H);
    const float first = lode_min(PEAK_SHARE * inverter->i_max_A / rise_A, window(duty_max));
    // Low-side pulses lie about the lower turning point.
    const bool flies = config->pulses != LODE_OFF && inverter->double_update != LODE_ON &&
                       config->catch_s > 0.0f && first >= 1.0f - duty_max;
    *tuning = (lode_fly_tuning_t){
        .share_first = flies ? first : 0.0f,
        .share_dead = 2.0f * inverter->dead_time_s / ts_s,
    };
    return LODE_OK;
}

typedef struct {
    float more_rad;     // where the line ends, beyond the last angle
    float slope_rad;    // per period
    float scatter_rad2; // mean square of the angles about it
} line_t;

void lode_fly_begin(lode_fly_t *self, const lode_fly_tuning_t *tuning) {
    *self = (lode_fly_t){
        .stage = (uint_least8_t)(tuning->share_first > 0.0f ? LODE_FLY_BEGIN : LODE_FLY_SLOW)};
}

// At t_k, from which on a vector has a direction.
static float seen_A(const lode_fly_given_t *given) {
    return SEEN_SHARE * given->i_max_A;
}

// At t_k, up to which the pulses lengthen.
static float target_A(const lode_fly_given_t *given) {
    return TARGET_SHARE * given->i_max_A;
}

// Of the period, that dead time may take.
static float share_blind(const lode_fly_tuning_t *tuning, const lode_fly_given_t *given) {
    return tuning->share_dead + 2.0f * UNKNOWN_s / given->ts_s;
}

// EMF of a vector at t_k, times the share.
static float emf_V(const lode_fly_given_t *given, float i_abs_A) {
    return 2.0f * given->Lq_H / given->ts_s * i_abs_A;
}

// At most, in which the vectors are seen to turn.
static uint32_t most_periods(const lode_fly_given_t *given) {
    const uint32_t part = TURN_PART * given->catch_rounds;
    return part > TURN_PERIODS ? part : TURN_PERIODS;
}

static void enter(lode_fly_t *self, uint_least8_t stage) {
    self->stage = stage;
    self->periods = 0u;
}

// Longest share after which the current, driven down by what the bus is above the EMF, is gone before the
// next pulse (S23).
static float longest(const lode_fly_t *self, const lode_fly_tuning_t *tuning, float i_abs_A,
                     const lode_fly_given_t *given) {
    const float acted = lode_max(self->share - tuning->share_dead, ACTED_MIN * self->share);
    const float line_V = LODE_SQRT3 * emf_V(given, i_abs_A) / acted;
    const float left = 1.0f - line_V / lode_max(given->v_bus_V, FLT_MIN);
    // No current flowed with the gates off: the EMF is below the bus.
    return lode_clamp(DECAY_SHARE * left, window(given->duty_max), SHARE_MAX);
}

static void grow(lode_fly_t *self, const lode_fly_tuning_t *tuning, lode_ab_t i_A,
                 const lode_fly_given_t *given) {
    const float i_abs_A = lode_ab_length(i_A);
    const bool seen = i_abs_A >= seen_A(given);
    const float most = seen ? longest(self, tuning, i_abs_A, given) : SHARE_MAX;
    const bool enough = i_abs_A >= target_A(given) || self->share >= most;
    const bool fits = self->share <= FITS * most;
    self->periods++;
    if ((enough && fits) || self->periods >= most_periods(given)) {
        self->theta_rad = lode_atan2(i_A.beta, i_A.alpha);
        self->rests = (uint_least8_t)(seen ? 0u : 1u); // if seen, TURN says
        enter(self, (uint_least8_t)(seen ? LODE_FLY_TURN : LODE_FLY_SLOW));
        return;
    }
    float more = lode_max(tuning->share_first, GROWTH * (self->share - share_blind(tuning, given)));
    if (seen) { // no more than the target asks for
        more = lode_min(more, self->share * lode_min(target_A(given) / i_abs_A - 1.0f, 1.0f));
    }
    self->share = lode_min(self->share + lode_max(more, 0.0f), most);
    self->wait = SETTLE;
}

// The size of the vectors is that of the flux at the speed found (S24). Dead time may have taken its part of
// the pulses, or none.
static bool is_motor(const lode_fly_t *self, const lode_fly_tuning_t *tuning, float i_abs_A,
                     float omega, const lode_fly_given_t *given) {
    const float seen_V = emf_V(given, i_abs_A);
    const float induced_V = given->psi_Wb * lode_abs(omega);
    return lode_abs(omega) >= LEAST_SHARE * given->omega_handover &&
           seen_V <= FLUX_HIGH * induced_V * self->share &&
           seen_V >= FLUX_LOW * induced_V * (self->share - share_blind(tuning, given));
}

// The line through the angles of TURN, by least squares: noise of the last one alone would be an error of the
// angle, and of the first and the last one of the speed (S25).
static line_t line_of(const lode_fly_t *self) {
    const float last = (float)(int32_t)self->periods;
    const float count = last + 1.0f;
    const float mean = self->sum_rad / count;
    const float slope =
        12.0f * (self->moment_rad - 0.5f * last * self->sum_rad) / (count * (count * count - 1.0f));
    const float spread = (count * count - 1.0f) * (1.0f / 12.0f); // of the periods
    const float scatter = self->square_rad2 / count - mean * mean - slope * slope * spread;
    return (line_t){mean + 0.5f * last * slope - self->turned_rad, slope, scatter};
}

static void turn(lode_fly_t *self, const lode_fly_tuning_t *tuning, lode_ab_t i_A,
                 const lode_fly_given_t *given) {
    const float i_abs_A = lode_ab_length(i_A);
    const float at_rad = lode_atan2(i_A.beta, i_A.alpha);
    self->periods++;
    self->turned_rad += lode_wrap(at_rad - self->theta_rad);
    self->theta_rad = at_rad;
    self->sum_rad += self->turned_rad;
    self->moment_rad += (float)(int32_t)self->periods * self->turned_rad;
    self->square_rad2 += self->turned_rad * self->turned_rad;
    const float turned = lode_abs(self->turned_rad);
    const bool charged = self->charged >= given->charge;
    if (i_abs_A < LOST_SHARE * seen_A(given)) {
        self->rests = 1u;
        enter(self, (uint_least8_t)LODE_FLY_SLOW);
        return;
    }
    if (!charged || (self->periods < most_periods(given) &&
                     (self->periods < TURN_PERIODS || turned < TURN_rad))) {
        return;
    }
    const line_t line = line_of(self);
    const float omega = line.slope_rad / given->ts_s;
    // Noise does not turn, nor an offset: that may be of a rotor at rest (S45).
    const bool turns =
        turned >= TURN_LEAST_rad && line.scatter_rad2 <= SCATTER_MAX_rad * SCATTER_MAX_rad;
    if (turns && is_motor(self, tuning, i_abs_A, omega, given)) {
        // (S21): the current lags the rotor by a quarter turn, and by what the rotor turns meanwhile.
        const float lead_rad = 0.25f * given->Lq_H * given->inv_Ld * self->share * line.slope_rad;
        const float ahead = lode_sign(omega) * LODE_HALF_PI + lead_rad;
        self->theta_rad = lode_wrap(at_rad + line.more_rad + ahead);
        self->omega_rad_s = omega;
        self->share = 0.0f;
        enter(self, (uint_least8_t)LODE_FLY_COAST);
    } else {
        self->rests = (uint_least8_t)(turns ? 0u : 1u);
        enter(self, (uint_least8_t)LODE_FLY_SLOW);
    }
}

static void coast(lode_fly_t *self, const lode_fly_given_t *given, lode_ab_t i_A) {
    self->theta_rad = lode_wrap(self->theta_rad + given->ts_s * self->omega_rad_s);
    self->periods++;
    const bool gone = lode_ab_length(i_A) < GONE_SHARE * target_A(given);
    if ((self->periods >= SETTLE && gone) || self->periods >= most_periods(given)) {
        enter(self, (uint_least8_t)LODE_FLY_FOUND);
    }
}

// With the EMF above the bus the diodes conduct, and no vector would be a pulse's.
static void begin(lode_fly_t *self, const lode_fly_tuning_t *tuning, lode_ab_t i_A,
                  const lode_fly_given_t *given) {
    self->periods++;
    if (lode_ab_length(i_A) < seen_A(given)) {
        self->share = tuning->share_first;
        self->wait = SETTLE;
        enter(self, (uint_least8_t)LODE_FLY_GROW);
    } else if (self->periods >= most_periods(given)) {
        enter(self, (uint_least8_t)LODE_FLY_SLOW);
    } else {
        // it may fall
    }
}

void lode_fly_step(lode_fly_t *self, const lode_fly_tuning_t *tuning, lode_ab_t i_A,
                   const lode_fly_given_t *given) {
    self->charged += self->share;
    if (self->wait > 1u) {
        self->wait--;
        return;
    }
    switch (self->stage) {
    case LODE_FLY_BEGIN:
        begin(self, tuning, i_A, given);
        break;
    case LODE_FLY_GROW:
        grow(self, tuning, i_A, given);
        break;
    case LODE_FLY_TURN:
        turn(self, tuning, i_A, given);
        break;
    case LODE_FLY_COAST:
        coast(self, given, i_A);
        break;
    case LODE_FLY_FOUND:
    case LODE_FLY_SLOW: // the drive goes on
    default:
        break;
    }
}

#endif
