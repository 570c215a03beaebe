#include "lodestar/signal_check.h"

#include "inverter_inline.h"

#define PHASES ((uint32_t)LODE_PHASES)

// Periods of a pulse. The gates switch on two periods before its voltage acts, as a board may switch them a period late.
#define ON_PERIOD 1u
#define FORWARD_PERIOD 2u
#define BACK_PERIOD 3u
#define OFF_PERIOD 4u
// Length of a pulse: the current is back where it was, and its rest has decayed against the whole bus voltage.
#define PERIODS 6u

#define CURRENT_SHARE 0.25f // of i_max, through the smaller inductance
#define CURRENT_MOST 0.5f
#define DUTY_MOST 0.4f // from half duty, so that both switches of a leg act
#define WINDOW 0.98f   // of the duty that low-side shunts allow
// Voltage of a pulse over that of dead time and another microsecond, which then put the response off by an eighth.
#define PER_DEAD 4.0f
#define UNKNOWN_s 1.0e-6f
#define COUNTS_LEAST 64.0f // response to a pulse: the noise of three phases is then a tenth of it

#define NOTHING 0.1f   // of the expected response
#define OFF_MOST 0.05f // of i_max: the offsets have been calibrated
// Of i_max: some six counts, twice the threshold of the low-side pulses. With three counts of noise the mean of six pulses
// exceeds it once in ten thousand times, a single pulse once in five (S46).
#define MOVES 0.006f
// Of the expected response: more than a rotor makes which the low-side pulses have not seen.
#define BEFORE_MOST 0.35f
// The same without low-side pulses: a rotor that makes more turns too far during the check. With one shunt in the DC link,
// whose samples are brought to t_k by a mean inductance, a rotor at rest makes up to a tenth.
#define TURNS_ALONE 0.15f
// Of the response expected at the larger inductance, which may be twice as large before the iron saturates.
#define PULSE_LEAST 0.3f
#define LACKS 0.08f // of the largest phase response: a salient rotor leaves a sixth
#define FLOWS 0.1f  // of the same: the sum of the currents where the phase carries one
// Of the smallest phase response: gains that differ by 2 % make sums of up to 0.2 in a very salient rotor, a single gain of
// 0.7 or 1.5 makes 0.33.
#define SUM_MOST 0.28f
#define FOLLOWS 0.05f // of the expected response: the weaker axis of a salient rotor leaves a third
// Over the configured inductance. Its error of 20 %, and another 20 % of iron that is not yet saturated, make up to 1.6
// times; current gains of 0.4 make 2.5.
#define INDUCTANCE_HIGH 2.0f
#define INDUCTANCE_LOW 0.4f
// Saliency from which the rotor's axis is known within 25 degrees, in spite of gains that differ by 2 % and noise (S40).
#define SALIENT 0.03f
#define SALIENT_NOISE 1.6f // of `moves_A`: 9.6 counts

#ifdef LODE_WITHOUT_SIGNAL_CHECK

lode_status_t lode_signal_check_tune(lode_signal_check_tuning_t *tuning,
                                     const lode_start_config_t *config,
                                     const lode_inverter_config_t *inverter,
                                     const lode_motor_t *motor, const lode_sense_config_t *sense,
                                     lode_signal_check_given_t given) {
    (void)inverter, (void)motor, (void)sense, (void)given;
    *tuning = (lode_signal_check_tuning_t){.pulses = 0u};
    return config->signal_check == LODE_ON ? LODE_ERROR_CHOICE : LODE_OK;
}

#else

// The gates of a board without low-side pulses may take more than a period, unless double update is why it has none.
static bool switches_in_time(const lode_start_config_t *config,
                             const lode_inverter_config_t *inverter,
                             lode_signal_check_given_t given) {
    return given.pulses || (inverter->double_update == LODE_ON && config->pulses != LODE_OFF);
}

lode_status_t lode_signal_check_tune(lode_signal_check_tuning_t *tuning,
                                     const lode_start_config_t *config,
                                     const lode_inverter_config_t *inverter,
                                     const lode_motor_t *motor, const lode_sense_config_t *sense,
                                     lode_signal_check_given_t given) {
    const lode_choice_t choice = config->signal_check;
    if (!lode_is_choice(choice)) {
        return LODE_ERROR_CHOICE;
    }
    const float ts_s = given.ts_s;
    const float L_H = lode_min(motor->Ld_H, motor->Lq_H);
    const float all_V = inverter->i_max_A * L_H / ts_s; // drives i_max within a period
    const float edge_s = // a call has half of a carrier's dead time with double update (I10)
        inverter->double_update == LODE_ON ? 2.0f * ts_s : ts_s;
    const float dead_V =
        inverter->v_drop_V + inverter->v_bus_V * (inverter->dead_time_s + UNKNOWN_s) / edge_s;
    const float least_V = PER_DEAD * DEAD_PER_PHASE * dead_V;
    const float room = lode_min(DUTY_MOST, WINDOW * (sense->duty_max - 0.5f));
    const float most_V = lode_min(CURRENT_MOST * all_V, room * inverter->v_bus_V);
    const float u_V = lode_min(lode_max(CURRENT_SHARE * all_V, least_V), most_V);
    // (S37): the response at the larger inductance, and the mean of both axes.
    const float weakest_A = 2.0f * u_V * ts_s / lode_max(motor->Ld_H, motor->Lq_H);
    const float mean_A = 0.5f * (weakest_A + 2.0f * u_V * ts_s / L_H);
    const bool seen = weakest_A >= COUNTS_LEAST * lode_abs(sense->i_gain_A_count);
    const bool can = least_V <= most_V && seen;
    const bool wanted =
        choice == LODE_ON || (choice == LODE_AUTO && switches_in_time(config, inverter, given));
    if (choice == LODE_ON && !can) {
        return LODE_ERROR_CHOICE;
    }
    *tuning = (lode_signal_check_tuning_t){
        // otherwise a rotor that turns makes it
        .pulse = u_V / inverter->v_bus_V,
        .mean_A_V = mean_A / inverter->v_bus_V,
        .least_A_V = PULSE_LEAST * weakest_A / inverter->v_bus_V,
        .off_A = OFF_MOST * inverter->i_max_A,
        .before_most = given.pulses ? BEFORE_MOST : FLT_MAX,
        .sum_most = given.sums ? SUM_MOST : FLT_MAX,
        .turns_A = given.pulses ? FLT_MAX : TURNS_ALONE * mean_A,
        .moves_A = given.pulses ? MOVES * inverter->i_max_A : TURNS_ALONE * mean_A,
        .pulses = can && wanted ? LODE_SIGNAL_PULSES : 0u,
    };
    return LODE_OK;
}

#define AXES (LODE_SIGNAL_PULSES / 2u)

// The phase axes a, -c, b, -a, c, -b.
static const lode_sincos_t axis_of[LODE_SIGNAL_PULSES] = {
    {0.0f, 1.0f},  {0.5f * LODE_SQRT3, 0.5f},   {0.5f * LODE_SQRT3, -0.5f},
    {0.0f, -1.0f}, {-0.5f * LODE_SQRT3, -0.5f}, {-0.5f * LODE_SQRT3, 0.5f}};

static void forget(lode_signal_check_t *self) {
    *self = (lode_signal_check_t){
        .before_A = self->before_A, .least_A = FLT_MAX, .pulse = self->pulse, .axis = self->axis};
}

void lode_signal_check_begin(lode_signal_check_t *self, const lode_signal_check_tuning_t *tuning,
                             bool rests) {
    self->pulse = (uint_least8_t)(rests ? 0u : tuning->pulses);
    self->axis = 0u;
    self->before_A = 0.0f;
    forget(self);
}

static lode_ab_t current_A(const lode_sense_tuning_t *sense, const float i[LODE_PHASES]) {
    return (lode_ab_t){(2.0f * i[0] - i[1] - i[2]) * sense->alpha_gain,
                       (i[1] - i[2]) * sense->beta_gain};
}

// Before the first pulse of a set. Pulses of another set may precede it: by their end an EMF has driven twice the current
// from before a pulse, part of which may still flow.
static void note_off(lode_signal_check_t *self, const lode_signal_check_tuning_t *tuning,
                     const lode_sense_tuning_t *sense, const int32_t i[LODE_PHASES]) {
    if (2.0f * self->before_A > tuning->off_A) {
        return;
    }
    for (uint32_t x = 0u; x < PHASES; x++) {
        self->off_A = lode_max(self->off_A, lode_abs(sense->i_gain * (float)i[x]));
    }
}

// Adds the response to the pulse along `at`.
static void note(lode_signal_check_t *self, const lode_sense_tuning_t *sense, lode_sincos_t at) {
    const float *i = self->shown;
    const float gain = lode_abs(sense->i_gain);
    const lode_ab_t i_A = current_A(sense, i);
    const lode_dq_t seen_A = lode_park(i_A, at);
    const lode_ab_t turned_A = lode_ab_rotate(i_A, at);
    self->along.alpha += seen_A.d;
    self->along.beta += seen_A.q;
    self->mirrored.alpha += turned_A.alpha;
    self->mirrored.beta += turned_A.beta;
    // (S48): a gain error makes sums of opposite signs in the two pulses of an axis, noise sums of any sign.
    const uint32_t pulse = (uint32_t)self->pulse % LODE_SIGNAL_PULSES;
    const float way = pulse < AXES ? 1.0f : -1.0f;
    self->sum_A[pulse % AXES] += way * gain * (i[0] + i[1] + i[2]);
    for (uint32_t x = 0u; x < PHASES; x++) {
        self->phase_A[x] += gain * lode_abs(i[x]);
        self->shown[x] = 0.0f;
    }
}

// Response to the forward half alone: twice the rise, less what an EMF has added, as in the two periods before.
static void note_rise(lode_signal_check_t *self, const lode_sense_tuning_t *sense,
                      lode_sincos_t at) {
    const float rise_A = lode_park(current_A(sense, self->shown), at).d - 2.0f * self->emf_A;
    if (rise_A < self->least_A) {
        self->least_A = rise_A;
        self->least = self->pulse;
    }
}

// (S46): by the current before this pulse, or by the sum over the pulses so far, from which noise mostly cancels.
static bool is_turning(const lode_signal_check_t *self, const lode_signal_check_tuning_t *tuning) {
    const lode_ab_t sum_A = self->moves_A;
    const uint32_t pulse = (uint32_t)self->pulse % LODE_SIGNAL_PULSES + 1u;
    const float pulses = (float)(int32_t)pulse;
    const float most_A2 =
        (float)(int32_t)LODE_SIGNAL_PULSES * pulses * tuning->moves_A * tuning->moves_A;
    return self->before_A > tuning->turns_A ||
           (!(tuning->turns_A < FLT_MAX) &&
            sum_A.alpha * sum_A.alpha + sum_A.beta * sum_A.beta > most_A2);
}

// All gates have been on for two periods: takes the current that this has made. The pulse begins.
static void note_before(lode_signal_check_t *self, const lode_signal_check_tuning_t *tuning,
                        const lode_sense_tuning_t *sense, lode_sincos_t at,
                        const int32_t i[LODE_PHASES]) {
    const lode_ab_t before_A = current_A(sense, self->shown);
    self->before_A = lode_max(self->before_A, lode_ab_length(before_A));
    self->emf_A = lode_park(before_A, at).d;
    self->moves_A.alpha += before_A.alpha;
    self->moves_A.beta += before_A.beta;
    for (uint32_t x = 0u; x < PHASES; x++) {
        self->shown[x] = -(float)i[x];
    }
    if (is_turning(self, tuning)) {
        self->pulse = (uint_least8_t)tuning->pulses; // ends the check
        self->axis = 0u;
    }
}

lode_ab_t lode_signal_check_step(lode_signal_check_t *self,
                                 const lode_signal_check_tuning_t *tuning,
                                 const lode_sense_tuning_t *sense, const int32_t i[LODE_PHASES]) {
    // The first weight is for the current before the pulse. The others give the rise while the voltage acts forward, less
    // that while it acts back: EMF, offset and, as the current keeps its sign, dead time are in both (S37).
    static const float weight[PERIODS] = {-1.0f, 0.0f, 1.0f, 2.0f, -1.0f, 0.0f};
    const lode_sincos_t at = axis_of[(uint32_t)self->pulse % LODE_SIGNAL_PULSES];
    const uint32_t period = (uint32_t)self->period % PERIODS;
    for (uint32_t x = 0u; x < PHASES; x++) {
        self->shown[x] += weight[period] * (float)i[x];
    }
    if (period == 0u && (uint32_t)self->pulse % LODE_SIGNAL_PULSES == 0u) {
        note_off(self, tuning, sense, i);
    }
    self->period = (uint_least8_t)(period + 1u);
    float u = 0.0f;
    if (period == ON_PERIOD) {
        u = tuning->pulse;
    } else if (period == FORWARD_PERIOD) {
        u = -tuning->pulse;
        note_before(self, tuning, sense, at, i);
    } else if (period == BACK_PERIOD) {
        note_rise(self, sense, at);
    } else if (period == PERIODS - 1u) {
        note(self, sense, at);
        self->period = 0u;
        self->pulse++;
    } else {
        // gates on or off, without voltage
    }
    return (lode_ab_t){u * at.cos, u * at.sin};
}

bool lode_signal_check_drives(const lode_signal_check_t *self) {
    return self->period >= ON_PERIOD && self->period <= OFF_PERIOD;
}

static float all_sums_A(const lode_signal_check_t *self) {
    return lode_abs(self->sum_A[0]) + lode_abs(self->sum_A[1]) + lode_abs(self->sum_A[2]);
}

static float least_phase_A(const lode_signal_check_t *self) {
    return lode_min(lode_min(self->phase_A[0], self->phase_A[1]), self->phase_A[2]);
}

static float most_phase_A(const lode_signal_check_t *self) {
    return lode_max(lode_max(self->phase_A[0], self->phase_A[1]), self->phase_A[2]);
}

// The phase, from 1, with hardly any response compared to the others; 0: none.
static uint32_t lacking_phase(const lode_signal_check_t *self) {
    const float limit_A = LACKS * most_phase_A(self);
    for (uint32_t x = 0u; x < PHASES; x++) {
        if (self->phase_A[x] < limit_A) {
            return x + 1u;
        }
    }
    return 0u;
}

static lode_finding_t finding(lode_check_t check, float measured, float limit) {
    return (lode_finding_t){check, measured, limit};
}

// Sensors: offsets with the gates off, then the phases against each other.
static lode_finding_t find_in_sensors(const lode_signal_check_t *self,
                                      const lode_signal_check_tuning_t *tuning, float mean_A) {
    const float most_A = most_phase_A(self);
    const float sum_A = all_sums_A(self);
    const float limit_A = tuning->sum_most * least_phase_A(self);
    const uint32_t lacks = lacking_phase(self);
    if (self->off_A > tuning->off_A) {
        return finding(LODE_CHECK_OFFSET, self->off_A, tuning->off_A);
    }
    if (most_A < NOTHING * (float)(int32_t)LODE_SIGNAL_PULSES * mean_A) {
        return finding(LODE_CHECK_CURRENT_STUCK, 0.0f, 0.0f);
    }
    if (lacks > 0u) {
        const bool flows = sum_A > FLOWS * most_A; // the others do not add up to zero
        return finding(flows ? LODE_CHECK_CURRENT_STUCK : LODE_CHECK_OPEN_PHASE,
                       (float)(int32_t)lacks, 0.0f);
    }
    return finding(sum_A > limit_A ? LODE_CHECK_CURRENT_SUM : LODE_CHECK_NONE, sum_A, limit_A);
}

// Currents against the voltages that drive them. `pulse_Vs`: volt-seconds on an inductance.
static lode_finding_t find_in_bridge(const lode_signal_check_t *self, float pulse_Vs, float mean_A,
                                     float least_A) {
    static const uint_least8_t phase_of[LODE_SIGNAL_PULSES] = {1u, 3u, 2u, 1u, 3u, 2u};
    const float inv = 1.0f / (float)(int32_t)LODE_SIGNAL_PULSES;
    const float along_A = inv * self->along.alpha;
    const float weakest_A =
        along_A - inv * (lode_ab_length(self->mirrored) + lode_abs(self->along.beta));
    // With a bus that reads 0 V no current is expected.
    if (!(mean_A > 0.0f && weakest_A >= FOLLOWS * mean_A)) {
        return finding(LODE_CHECK_SIGNALS, weakest_A, FOLLOWS * mean_A);
    }
    const float seen_H = pulse_Vs / along_A;
    const float high_H = INDUCTANCE_HIGH * pulse_Vs / mean_A;
    const float low_H = INDUCTANCE_LOW * pulse_Vs / mean_A;
    if (!lode_in_range(seen_H, low_H, high_H)) {
        return finding(LODE_CHECK_INDUCTANCE, seen_H, seen_H > high_H ? high_H : low_H);
    }
    const bool whole = self->least_A >= least_A; // false: a switch stays off
    return finding(whole ? LODE_CHECK_NONE : LODE_CHECK_OPEN_PHASE,
                   (float)phase_of[(uint32_t)self->least % LODE_SIGNAL_PULSES], 0.0f);
}

// (S38): the angle of `mirrored` is twice the rotor's. Within 60 degrees of 0 the rotor lies next to the axis of a, else next
// to that of c or b.
static LODE_NOINLINE uint_least8_t next_axis(const lode_signal_check_t *self,
                                             const lode_signal_check_tuning_t *tuning) {
    const lode_ab_t twice = self->mirrored;
    const float least_A = SALIENT * self->along.alpha + SALIENT_NOISE * tuning->moves_A;
    if (!(lode_ab_length(twice) >= least_A)) {
        return 0u;
    }
    if (lode_abs(twice.beta) <= LODE_SQRT3 * twice.alpha) {
        return 1u;
    }
    return twice.beta > 0.0f ? 2u : 3u;
}

lode_sincos_t lode_signal_check_axis(const lode_signal_check_t *self) {
    const uint32_t axis = self->axis;
    return axis > 0u ? axis_of[(axis - 1u) % LODE_SIGNAL_PULSES] : (lode_sincos_t){0.0f, 0.0f};
}

lode_finding_t lode_signal_check_judge(lode_signal_check_t *self,
                                       const lode_signal_check_tuning_t *tuning, float v_bus_V,
                                       float ts_s) {
    const uint32_t pulse = self->pulse;
    const float mean_A = tuning->mean_A_V * v_bus_V;
    const float before_A = tuning->before_most * mean_A;
    if (self->before_A > before_A) {
        return finding(LODE_CHECK_SIGNALS, -self->before_A, -before_A);
    }
    if (pulse % LODE_SIGNAL_PULSES != 0u || pulse == 0u || self->period != 0u) {
        return finding(LODE_CHECK_NONE, 0.0f, 0.0f);
    }
    lode_finding_t found = find_in_sensors(self, tuning, mean_A);
    if (found.check == LODE_CHECK_NONE) {
        found = find_in_bridge(self, 2.0f * tuning->pulse * v_bus_V * ts_s, mean_A,
                               tuning->least_A_V * v_bus_V);
    }
    if (found.check == LODE_CHECK_CURRENT_SUM && self->again == 0u) {
        self->pulse = (uint_least8_t)(pulse - LODE_SIGNAL_PULSES);
        forget(self);
        self->again = 1u;
        return finding(LODE_CHECK_NONE, 0.0f, 0.0f);
    }
    const bool phase = found.check == LODE_CHECK_OPEN_PHASE ||
                       (found.check == LODE_CHECK_CURRENT_STUCK && found.measured > 0.0f);
    if (phase && pulse > LODE_SIGNAL_PULSES) {
        found.measured += (float)LODE_PHASES;
    }
    if (pulse <= LODE_SIGNAL_PULSES && found.check == LODE_CHECK_NONE) {
        self->axis = next_axis(self, tuning); // of set 1, to which the angles refer
    }
    forget(self);
    return found;
}

#endif
