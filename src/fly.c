#include "lodestar/fly.h"

#define PEAK_SHARE 0.8f   // of i_max: current of a pulse at the highest speed (S22)
#define TARGET_SHARE 0.1f // of i_max, at t_k: by its end a pulse makes twice that
// (S50): least current whose direction is used. 0.003 of i_max are some three counts, which show the angle within 10 degrees. One
// noise vector in 8000 is longer than three times their rms length.
#define SEEN_SHARE 0.003f // of i_max
#define SEEN_NOISE 3.0f   // times the noise
#define SEEN_MORE 1.5f    // factor for the next try
#define NOISE_PERIODS 8u  // of BEGIN: noise is measured with the gates off
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
#define KNOWN_rad 0.035f     // (S57): two degrees
#define TURN_PERIODS 12u     // periods of TURN, at least
#define SCATTER_PERIODS 24u  // vectors after which those off the line end TURN
#define TURN_PART (LODE_SLOW_PERIODS / 2u) // half of catch_rounds, in periods
// Of omega_handover: a slower rotor is left to START.
#define LEAST_SHARE 0.75f
// (S24): bounds of the EMF by the vectors' size, over that of the configured flux. The inductance may be 20 % off.
#define FLUX_LOW 0.5f
#define FLUX_HIGH 1.6f
// (S45): below 4 times the noise, vectors may be off the line because of noise alone.
#define NOISY 4.0f
#define NOISE_TRIES 3u   // searches in all; then START looks for the rotor
#define GONE_SHARE 0.25f // of the target: the current has decayed
#define SETTLE 2u        // periods from a new share to its first sample
// Pulses of whole periods (S51), used where a pulse within a period shows less than half of the target. With a line EMF of two
// thirds of the bus, where (S23) allows a share of 0.2667, the current decays in twice the time of the pulse.
#define LONG_BELOW 0.5f // of the target
#define LONG_LEAST 0.2667f
#define LONG_MOST 16u   // periods
#define LONG_SEEN 1.5f  // times the least current: enough, no longer pulse is needed
#define LONG_VECTORS 8u // least number of vectors
#define LONG_GAP 5u     // periods between two vectors of pulses of one period
#define LONG_TURN_rad 2.0f

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

// Pulse length as a share of the period. A pulse of n whole periods ends at t_k, so that the EMF has acted as long as in one of
// twice its length around t_k.
static float pulse_share(const lode_fly_t *self) {
    return self->span > 0u ? 2.0f * (float)(int32_t)self->span : self->share;
}

// Periods from one vector to the next.
static uint32_t gap_periods(const lode_fly_t *self) {
    const uint32_t span = self->span;
    return span > 0u ? 3u * span + 2u : 1u;
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

static void enter_grow(lode_fly_t *self, const lode_fly_tuning_t *tuning) {
    self->share = tuning->share_first;
    self->wait = SETTLE;
    enter(self, (uint_least8_t)LODE_FLY_GROW);
}

// EMF that a current at t_k shows of a pulse within a period, of which dead time has taken its part.
static float shown_V(const lode_fly_t *self, const lode_fly_tuning_t *tuning, float i_abs_A,
                     const lode_fly_given_t *given) {
    const float acted = lode_max(self->share - tuning->share_dead, ACTED_MIN * self->share);
    return emf_V(given, i_abs_A) / acted;
}

// (S23): longest share after which the current, driven down by the bus less the EMF, is gone before the next pulse.
static float longest(float e_V, const lode_fly_given_t *given) {
    const float left = 1.0f - LODE_SQRT3 * e_V / lode_max(given->v_bus_V, FLT_MIN);
    // No current flowed with the gates off: the EMF is below the bus.
    return lode_clamp(DECAY_SHARE * left, window(given->duty_max), SHARE_MAX);
}

// Ends GROW with the rotor's first vector, or without one above the noise.
static void end_grow(lode_fly_t *self, lode_ab_t i_A, bool seen) {
    self->theta_rad = lode_atan2(i_A.beta, i_A.alpha);
    self->rests = (uint_least8_t)(seen ? 0u : 1u); // TURN decides, if there is a vector
    enter(self, (uint_least8_t)(seen ? LODE_FLY_TURN : LODE_FLY_SLOW));
}

// (S51): pulse length at which the slowest rotor in question makes twice the least current.
static uint32_t longest_span(const lode_fly_t *self, const lode_fly_given_t *given) {
    const float least_A =
        given->psi_Wb * LEAST_SHARE * given->omega_handover * given->ts_s / given->Lq_H;
    const float span = 2.0f * self->seen_A / lode_max(least_A, FLT_MIN);
    return (uint32_t)(int32_t)lode_clamp(span + 1.0f, 1.0f, (float)LONG_MOST);
}

// Begins with the pause, in which the current of earlier pulses decays.
static void begin_span(lode_fly_t *self, uint32_t span) {
    self->span = (uint_least8_t)span;
    self->cycle = (uint_least8_t)(span + 1u);
    self->share = 0.0f;
}

// GROW with pulses of whole periods: one sample.
static void lengthen(lode_fly_t *self, lode_ab_t i_A, const lode_fly_given_t *given) {
    const uint32_t most = longest_span(self, given);
    const uint32_t span = self->span;
    const float i_abs_A = lode_ab_length(i_A);
    const bool seen = i_abs_A >= self->seen_A;
    if (span >= most || i_abs_A >= LONG_SEEN * self->seen_A) {
        end_grow(self, i_A, seen);
    } else {
        const uint32_t twice = 2u * span;
        begin_span(self, twice < most ? twice : most);
    }
}

// The current decays in the pause, and from one vector to the next the rotor turns by far less than half a turn.
static bool may_span(float most, float e_V, const lode_fly_given_t *given) {
    const float gap_s = (float)LONG_GAP * given->ts_s;
    return most >= LONG_LEAST && gap_s * e_V <= LONG_TURN_rad * given->psi_Wb;
}

static void grow(lode_fly_t *self, const lode_fly_tuning_t *tuning, lode_ab_t i_A,
                 const lode_fly_given_t *given) {
    const float i_abs_A = lode_ab_length(i_A);
    const float e_V = shown_V(self, tuning, i_abs_A, given);
    const bool seen = i_abs_A >= self->seen_A;
    const float most = seen ? longest(e_V, given) : SHARE_MAX;
    const bool enough = i_abs_A >= target_A(given) || self->share >= most;
    const bool fits = self->share <= FITS * most;
    self->periods++;
    const bool small = i_abs_A < LONG_BELOW * target_A(given);
    if (enough && fits && small && may_span(most, e_V, given)) {
        begin_span(self, 1u);
        return;
    }
    if ((enough && fits) || self->periods >= most_periods(given)) {
        end_grow(self, i_A, seen);
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
    return seen_V <= FLUX_HIGH * induced_V * pulse_share(self) &&
           seen_V >= FLUX_LOW * induced_V * (pulse_share(self) - share_blind(tuning, given));
}

// By the EMF at the speed found the pulses were too long for the current to decay (S23): it has added up.
static bool adds_up(const lode_fly_t *self, float omega, const lode_fly_given_t *given) {
    const float line_V = LODE_SQRT3 * given->psi_Wb * lode_abs(omega);
    const float most = DECAY_SHARE * (1.0f - line_V / lode_max(given->v_bus_V, FLT_MIN));
    return self->span > 0u ? most < LONG_LEAST : self->share > FITS * most;
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

// A single vector may be off by more than a quarter turn. Once the line is sure, the next vector is looked for next to it, so that
// no turn is lost.
static void note_vector(lode_fly_t *self, lode_ab_t i_A) {
    const float at_rad = lode_atan2(i_A.beta, i_A.alpha);
    float next_rad = 0.0f;
    if (self->sure != 0u) {
        const line_t line = line_of(self);
        next_rad = line.more_rad + line.slope_rad;
    }
    self->periods++;
    self->turned_rad += next_rad + lode_wrap(at_rad - self->theta_rad - next_rad);
    self->theta_rad = at_rad;
    self->sum_A += lode_ab_length(i_A);
    self->sum_rad += self->turned_rad;
    self->moment_rad += (float)(int32_t)self->periods * self->turned_rad;
    self->square_rad2 += self->turned_rad * self->turned_rad;
}

// A noise vector passed for the rotor's, or the current adds up. Another pulse length may show the rotor.
static void try_again(lode_fly_t *self, const lode_fly_tuning_t *tuning) {
    const uint32_t tries = self->tries + 1u;
    *self = (lode_fly_t){.noise_A = self->noise_A,
                         .seen_A = SEEN_MORE * self->seen_A,
                         .charged = self->charged,
                         .tries = (uint_least8_t)tries,
                         .stage = (uint_least8_t)LODE_FLY_SLOW};
    if (tries < NOISE_TRIES) {
        enter_grow(self, tuning);
    }
}

// TURN has had all of its time.
static bool is_late(const lode_fly_t *self, const lode_fly_given_t *given) {
    return self->periods * gap_periods(self) >= most_periods(given);
}

static float omega_of(const lode_fly_t *self, const lode_fly_given_t *given, const line_t *line) {
    return line->slope_rad / (given->ts_s * (float)(int32_t)gap_periods(self));
}

// (S57): standard deviation of the line's end. In noise more vectors are needed.
static bool is_known(const lode_fly_t *self, const line_t *line) {
    return 4.0f * line->scatter_rad2 <= KNOWN_rad * KNOWN_rad * (float)(int32_t)self->periods;
}

// Angle and speed are known.
static void find(lode_fly_t *self, const lode_fly_given_t *given, const line_t *line, float omega) {
    // (S21): the current lags the rotor by a quarter turn, and by what the rotor turns during the pulse.
    const float half_rad = 0.25f * pulse_share(self) * given->ts_s * omega;
    const float lead_rad = lode_atan2(given->Lq_H * given->inv_Ld * half_rad, 1.0f);
    const float ahead = lode_sign(omega) * LODE_HALF_PI + lead_rad;
    self->theta_rad = lode_wrap(self->theta_rad + line->more_rad + ahead);
    self->omega_rad_s = omega;
    self->share = 0.0f;
    self->span = 0u;
    enter(self, (uint_least8_t)LODE_FLY_COAST);
}

// Whether TURN has watched long enough.
static bool is_watched(const lode_fly_t *self, const lode_fly_given_t *given) {
    uint32_t least = TURN_PERIODS;
    if (self->span > 0u) {
        least = LONG_VECTORS;
    }
    const bool turned = lode_abs(self->turned_rad) >= TURN_rad;
    return self->charged >= given->charge && self->periods >= LONG_VECTORS &&
           (is_late(self, given) || (self->periods >= least && turned));
}

// What TURN has shown.
static void judge(lode_fly_t *self, const lode_fly_tuning_t *tuning, const lode_fly_given_t *given,
                  const line_t *line, bool on_line) {
    const bool early = self->periods <= SCATTER_PERIODS;
    const float mean_A = self->sum_A / (float)(int32_t)self->periods;
    // (S45): vectors of an offset do not turn. Those of a rotor that comes to rest leave the line.
    const bool turns = lode_abs(self->turned_rad) >= TURN_LEAST_rad && on_line;
    const float omega = omega_of(self, given, line);
    const bool fast = lode_abs(omega) >= LEAST_SHARE * given->omega_handover;
    const bool noisy = early && !on_line && mean_A < NOISY * self->noise_A;
    if (turns && fast && is_motor(self, tuning, mean_A, omega, given)) {
        self->sure = 1u;
    } else if (noisy || (turns && fast && adds_up(self, omega, given))) {
        try_again(self, tuning);
    } else {
        self->rests = (uint_least8_t)(turns ? 0u : 1u);
        enter(self, (uint_least8_t)LODE_FLY_SLOW);
    }
}

static void turn(lode_fly_t *self, const lode_fly_tuning_t *tuning, lode_ab_t i_A,
                 const lode_fly_given_t *given) {
    note_vector(self, i_A);
    const bool enough = is_watched(self, given);
    if (self->sure == 0u && !enough && self->periods != SCATTER_PERIODS) {
        return;
    }
    const line_t line = line_of(self);
    const bool on_line = line.scatter_rad2 <= SCATTER_MAX_rad * SCATTER_MAX_rad;
    if (self->sure == 0u && (enough || !on_line)) {
        judge(self, tuning, given, &line, on_line);
    }
    if (self->sure != 0u && (is_known(self, &line) || is_late(self, given))) {
        find(self, given, &line, omega_of(self, given, &line));
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

// With the EMF above the bus the diodes conduct, and their current would hide that of the pulses. Less current is noise (S50).
static void begin(lode_fly_t *self, const lode_fly_tuning_t *tuning, lode_ab_t i_A,
                  const lode_fly_given_t *given) {
    self->periods++;
    self->sum_A2 += lode_ab_length2(i_A);
    if (self->periods % NOISE_PERIODS != 0u) {
        return;
    }
    self->noise_A = lode_sqrt(self->sum_A2 * (1.0f / (float)NOISE_PERIODS));
    self->sum_A2 = 0.0f;
    self->seen_A = lode_max(SEEN_SHARE * given->i_max_A, SEEN_NOISE * self->noise_A);
    if (self->seen_A <= target_A(given)) {
        enter_grow(self, tuning);
    } else if (self->periods >= most_periods(given)) {
        enter(self, (uint_least8_t)LODE_FLY_SLOW);
    } else {
        // the EMF may fall
    }
}

// (S51): 2n + 1 periods off, n on, then the sample. True: the present current is that sample.
static bool is_sampled(lode_fly_t *self, const lode_fly_given_t *given) {
    const uint32_t span = self->span;
    const uint32_t cycle = self->cycle + 1u;
    const bool ends = cycle >= gap_periods(self);
    self->cycle = (uint_least8_t)(ends ? 0u : cycle);
    if (ends) {
        self->share = 1.0f;
    } else if (cycle == span) {
        self->share = window(given->duty_max); // low-side shunts are sampled with the low sides on
    } else if (cycle > span) {
        self->share = 0.0f;
    } else {
        // on
    }
    return cycle == span + 1u;
}

void lode_fly_step(lode_fly_t *self, const lode_fly_tuning_t *tuning, lode_ab_t i_A,
                   const lode_fly_given_t *given) {
    self->charged += self->share;
    if (self->wait > 1u) {
        self->wait--;
        return;
    }
    const bool spans = self->span > 0u;
    if (spans && !is_sampled(self, given)) {
        return;
    }
    switch (self->stage) {
    case LODE_FLY_BEGIN:
        begin(self, tuning, i_A, given);
        break;
    case LODE_FLY_GROW:
        if (spans) {
            lengthen(self, i_A, given);
        } else {
            grow(self, tuning, i_A, given);
        }
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
