#include "lodestar/fly.h"

#define PEAK_SHARE 0.8f   // of i_max: current of a pulse at the highest speed (S22)
#define TARGET_SHARE 0.1f // of i_max, at t_k: by its end a pulse makes twice that
#define SEEN_SHARE 0.003f // of i_max: some three counts, which show the angle within 10 degrees
#define SHARE_MAX 0.5f    // the current must decay before the next pulse
#define FIRST_MAX 0.05f   // of the period: short enough for an EMF close to the bus voltage
#define DECAY_SHARE 0.8f  // of the time in which the current just decays (S23)
#define FITS 1.2f      // of the longest share: tolerance, as it varies with each sample of the EMF
#define ACTED_MIN 0.3f // share of a pulse that acts at least, whatever dead time takes
#define GROWTH 2.0f    // of the part of a pulse that acts but shows nothing: this triples
#define UNKNOWN_s 1.0e-6f    // unknown part of the dead time
#define TURN_rad 3.0f        // after this rotation the speed is known to a few per cent ...
#define TURN_LEAST_rad 0.5f  // ... after this one to some 20 %
#define SCATTER_MAX_rad 0.5f // rms about the line; noise alone has 1.6 and more
#define TURN_PERIODS 12u     // periods of TURN, at least
#define TURN_PART (LODE_SLOW_PERIODS / 2u) // half of catch_rounds, in periods
// Of omega_handover: a slower rotor is left to START.
#define LEAST_SHARE 0.75f
// (S24): bounds of the EMF by the vectors' size, over that of the configured flux. The inductance may be 20 % off.
#define FLUX_LOW 0.5f
#define FLUX_HIGH 1.6f
#define LOST_SHARE 0.5f  // of the least current that is used: noise rarely has it, and not for long
#define GONE_SHARE 0.25f // of the target: the current has decayed
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

// Shortest share, to which the pulses go back where the EMF is close to the bus voltage.
static float window(float duty_max) {
    return lode_max(FIRST_MAX, 1.0f - duty_max);
}

lode_status_t lode_fly_tune(lode_fly_tuning_t *tuning, const lode_start_config_t *config,
                            const lode_inverter_config_t *inverter, const lode_motor_t *motor,
                            float omega_max_rad_s, float duty_max, float ts_s) {
    if (!lode_is_choice(config->pulses)) {
        return LODE_ERROR_CHOICE;
    }
    // (S22): current that the largest EMF drives through the smaller inductance.
    const float rise_A =
        motor->psi_Wb * omega_max_rad_s * ts_s / lode_min(motor->Ld_H, motor->Lq_H);
    const float first = lode_min(PEAK_SHARE * inverter->i_max_A / rise_A, window(duty_max));
    // With double update low-side pulses would lie about one of the two turning points only.
    const bool flies = config->pulses != LODE_OFF && inverter->double_update != LODE_ON &&
                       config->catch_s > 0.0f && first >= 1.0f - duty_max;
    *tuning = (lode_fly_tuning_t){
        .share_first = flies ? first : 0.0f,
        .share_dead = 2.0f * inverter->dead_time_s / ts_s,
    };
    return LODE_OK;
}

typedef struct {
    float more_rad;     // end of the line less the last angle
    float slope_rad;    // per period
    float scatter_rad2; // mean square of the angles' distance from it
} line_t;

void lode_fly_begin(lode_fly_t *self, const lode_fly_tuning_t *tuning) {
    *self = (lode_fly_t){
        .stage = (uint_least8_t)(tuning->share_first > 0.0f ? LODE_FLY_BEGIN : LODE_FLY_SLOW)};
}

// Current at t_k from which a vector has a usable direction.
static float seen_A(const lode_fly_given_t *given) {
    return SEEN_SHARE * given->i_max_A;
}

// Current at t_k up to which the pulses lengthen.
static float target_A(const lode_fly_given_t *given) {
    return TARGET_SHARE * given->i_max_A;
}

// Share of the period that dead time may take.
static float share_blind(const lode_fly_tuning_t *tuning, const lode_fly_given_t *given) {
    return tuning->share_dead + 2.0f * UNKNOWN_s / given->ts_s;
}

// EMF that a current at t_k shows, times the share.
static float emf_V(const lode_fly_given_t *given, float i_abs_A) {
    return 2.0f * given->Lq_H / given->ts_s * i_abs_A;
}

// Longest time for which the vectors are watched, in periods.
static uint32_t most_periods(const lode_fly_given_t *given) {
    const uint32_t part = TURN_PART * given->catch_rounds;
    return part > TURN_PERIODS ? part : TURN_PERIODS;
}

static void enter(lode_fly_t *self, uint_least8_t stage) {
    self->stage = stage;
    self->periods = 0u;
}

// (S23): longest share after which the current, driven down by the bus less the EMF, is gone before the next pulse.
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
        self->rests = (uint_least8_t)(seen ? 0u : 1u); // TURN decides, if there is a vector
        enter(self, (uint_least8_t)(seen ? LODE_FLY_TURN : LODE_FLY_SLOW));
        return;
    }
    float more = lode_max(tuning->share_first, GROWTH * (self->share - share_blind(tuning, given)));
    if (seen) { // no further than to the target
        more = lode_min(more, self->share * lode_min(target_A(given) / i_abs_A - 1.0f, 1.0f));
    }
    self->share = lode_min(self->share + lode_max(more, 0.0f), most);
    self->wait = SETTLE;
}

// (S24): the size of the vectors fits the flux at the speed found, with or without what dead time may take of the pulses.
static bool is_motor(const lode_fly_t *self, const lode_fly_tuning_t *tuning, float i_abs_A,
                     float omega, const lode_fly_given_t *given) {
    const float seen_V = emf_V(given, i_abs_A);
    const float induced_V = given->psi_Wb * lode_abs(omega);
    return lode_abs(omega) >= LEAST_SHARE * given->omega_handover &&
           seen_V <= FLUX_HIGH * induced_V * self->share &&
           seen_V >= FLUX_LOW * induced_V * (self->share - share_blind(tuning, given));
}

// (S25): line through the angles of TURN, by least squares. Noise of the last angle alone would be an error of the angle,
// noise of the first and the last one an error of the speed.
static line_t line_of(const lode_fly_t *self) {
    const float last = (float)(int32_t)self->periods;
    const float count = last + 1.0f;
    const float mean = self->sum_rad / count;
    const float slope =
        12.0f * (self->moment_rad - 0.5f * last * self->sum_rad) / (count * (count * count - 1.0f));
    const float spread = (count * count - 1.0f) * (1.0f / 12.0f); // variance of the period numbers
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
    // (S45): vectors of noise or of an offset do not turn. Then the rotor may be at rest.
    const bool turns =
        turned >= TURN_LEAST_rad && line.scatter_rad2 <= SCATTER_MAX_rad * SCATTER_MAX_rad;
    if (turns && is_motor(self, tuning, i_abs_A, omega, given)) {
        // (S21): the current lags the rotor by a quarter turn, and by what the rotor turns during the pulse.
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

// With the EMF above the bus the diodes conduct, and their current would hide that of the pulses.
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
        // the EMF may fall
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
    case LODE_FLY_SLOW: // nothing left to do
    default:
        break;
    }
}

#endif
