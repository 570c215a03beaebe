#include "commission_machine.h"

#ifndef LODE_WITHOUT_COMMISSIONING

#include "inverter_inline.h"

#include <stddef.h>

#define PHASES ((uint32_t)LODE_PHASES)
#define BEFORE_FIRST 0xFFFFFFFFu // counts on to 0

// Signals: pulses along each phase, first forward, then back, so that the rotor stays where it is; then rest.
#define PULSE_PERIODS 5u
#define REST_PERIODS 60u
#define SEEN_PERIODS 3u   // from a voltage that is written to the current that it makes
#define PULSE_SHARE 0.15f // of i_max, by the smaller inductance
#define PULSE_SEEN 0.08f  // the same, by the larger one; with less the voltage is raised
#define PULSES_MOST 12u
#define DRIVEN_LEAST                                                                               \
    0.7f // of the largest phase current: saliency turns the vector by up to 35 degrees
#define SUM_MOST 0.25f // of the same: what flows in must flow out
#define XY_MOST                                                                                    \
    0.45f // of the vector: both sets see the same but for dead time, which makes up to 0.3; swapped ones 0.6
#define NOISE_MOST 0.02f // of full scale, peak to peak
#define OFFSET_SAMPLES 1024u

// Holding the rotor: along phase a, where all phases have current; of six phases halfway from a1 to a2 (N5).
#define AXIS_SIX_rad (LODE_PI / 12.0f)
#define CURRENT_SHARE 0.5f // of i_max
#define SALIENT_SHARE                                                                              \
    0.4f // of the current at which reluctance pulls as much across as the magnet along
#define QUICK_TIME_s 1.0f // of the voltage to its end, until there is some current
#define SOME_SHARE 0.02f  // of the current
#define CATCH_SHARE 0.4f  // of it: as far as it rises until the rotor lies along it
// Then slowly: a winding of little resistance is a short circuit for a rotor that turns. The rotor lies along
// the vector after some volt seconds per weber, and shall do that with little current.
#define RISE_LEAST_s 0.6f
#define RISE_MOST_s 2.0f
#define RISE_FLUXES 40.0f
#define QUICKER 4.0f // times as fast where the rotor lies along the vector, or has too much current
#define TURN_TIME_s                                                                                \
    0.8f // from the first direction, across, so that no rotor can lie opposite to both
#define WINDOW_s 0.1f
#define CALM_WINDOWS 2u
#define CALM_SHARE 0.005f // of the current, between the halves of a window
#define SETTLE_TIME_s 4.0f
#define UNKNOWN_R 1.5f // of the configured one: as far as the voltage goes
#define UNKNOWN_DEAD_s 1.5e-6f
#define LEVELS 3u
#define LEVEL_STEP 0.3f // of the current, from level to level
// Voltage along the axis that holds, per volt that each phase loses (N5): two thirds of the sum of the phases' cosines.
#define DEAD_THREE (4.0f / 3.0f)
#define DEAD_SIX 1.2879f
#define LINE_DEVIATION 0.03f // of the middle level's voltage off the line, allowed

// Inductances: steps of the current's reference, on top of a current that holds the rotor and the signs of
// all phase currents.
#define HOLD_SHARE 0.7f  // of the current at the first level
#define STEP_SHARE 0.4f  // of what holds, either way
#define STEP_SIX 0.2f    // the same in q of six phases, of which two have a quarter of what holds
#define STEP_SPREAD 0.2f // from the first to the last, of the mean: each rounds to other counts
#define HALF_WAVE 8u     // periods
#define WAVES 68u
#define WAVES_BESIDE 30u // about the other currents
#define HOLD_TIME_s 0.1f
#define NEXT_TIME_s 0.02f    // to another current
#define STEP_DEVIATION 0.01f // of the inductance, standard deviation by what it does not explain

// The xy plane, the same way: its control is pushed to and fro, towards so much of the current that holds.
#define XY_SHARE 0.4f
#define XY_CIRCLE 0.5f // of the voltage that the plane may use
#define XY_DEVIATION 0.03f

// Their fall over current: in d about three currents, in q large waves of three amplitudes.
#define FALL_POINTS 3u
// Of the current that holds, from one to the next: the least is clear of the dead band.
#define FALL_D_STEP 0.35f
#define FALL_D_MIDDLE 1u   // where Ld is taken, unless it falls
#define FALL_Q_MIDDLE 0.5f // of i_max
#define FALL_Q_HIGH 0.75f  // with the current that holds, and its overshoot, within i_max
#define FALL_HALVES 6u
#define FALL_VOLTAGE 0.75f   // of the circle, to get from one end to the other
#define FALL_LONGEST_s 0.05f // of a half-wave that moves no rotor
#define FALL_LEAST 0.05f     // less is none
#define FALL_DEVIATION 0.03f // of the inductance, off the line

// The run.
#define LOW_SHARE 0.3f // of rated speed
#define HIGH_SHARE 0.7f
#define HANDOVER_SHARE 0.2f // of rated speed
#define HANDOVER_MORE 2.0f  // of the default
#define ABOVE_HANDOVER 1.3f
#define SPAN_WANTED 2.0f // of the lower speed
#define SPAN_LEAST 1.3f
#define HIGH_MOST 0.9f     // of rated speed
#define HIGH_OF_MOST 0.8f  // of the largest that may be commanded: SPEED_ROOM is left
#define RUN_TIME_s 0.4f    // from the one speed to the other, by the configured J
#define TORQUE_LEAST 0.02f // of the torque at i_max
#define TORQUE_MOST 0.6f
#define REACHED 0.03f
#define STEADY_s 0.2f
#define RUN_WAIT_s 3.0f
#define SPEED_ROOM 1.2f        // below the commanded speed torque does not give way
#define EDGE_SHARE 0.15f       // of the span at either end that is not looked at
#define TORQUE_DEVIATION 0.02f // of what the currents say of the torque
#define B_DEVIATION 0.2f
#define PSI_DEVIATION 0.06f // between up and down
#define POINTS_LEAST 20u
#define PSI_ROUGH 0.03f // of what was reckoned with: more, and the run is made again
#define J_ROUGH 0.2f
#define LOST_MOST 2u // times that a lost rotor is looked for again
#define LOST_INERTIA 2.0f

typedef enum {
    STAGE_CALIBRATE,
    STAGE_PULSES, // a, b, c
    STAGE_ACROSS,
    STAGE_ALONG,
    STAGE_LEVEL,
    STAGE_LD, // three currents
    STAGE_LQ,
    STAGE_LQ_FALL, // three amplitudes
    STAGE_LXY,     // of six phases alone
    STAGE_RETUNE,
    STAGE_START,
    STAGE_UP,
    STAGE_DOWN,
    STAGE_OVER
} stage_t;

#define NAME(enumerator, name)                                                                     \
    case LODE_COMMISSION_##enumerator:                                                             \
        return name

const char *lode_commission_name(lode_commission_quantity_t quantity) {
    switch (quantity) {
        NAME(OFFSET_A, "offset_a_count");
        NAME(OFFSET_B, "offset_b_count");
        NAME(OFFSET_C, "offset_c_count");
        NAME(OFFSET_A2, "offset_a2_count");
        NAME(OFFSET_B2, "offset_b2_count");
        NAME(OFFSET_C2, "offset_c2_count");
        NAME(SIGNALS, "signals");
        NAME(RS_Ohm, "Rs_Ohm");
        NAME(DEAD_V, "dead_V");
        NAME(LD_H, "Ld_H");
        NAME(LQ_H, "Lq_H");
        NAME(LD_FALL_1_A, "Ld_fall");
        NAME(LQ_FALL_1_A, "Lq_fall");
        NAME(LXY_H, "Lxy_H");
        NAME(PSI_Wb, "psi_Wb");
        NAME(J_kgm2, "J_kgm2");
        NAME(B_Nms, "B_Nms");
    case LODE_COMMISSION_QUANTITIES:
    default:
        return "unknown";
    }
}

const char *lode_commission_result_name(lode_commission_result_t result) {
    switch (result) {
        NAME(RUNNING, "RUNNING");
        NAME(DONE, "DONE");
        NAME(FAULT, "FAULT");
        NAME(UNSURE, "UNSURE");
        NAME(NO_CURRENT, "NO_CURRENT");
        NAME(UNSETTLED, "UNSETTLED");
        NAME(REFUSED, "REFUSED");
        NAME(NO_START, "NO_START");
    default:
        return "UNKNOWN";
    }
}

static uint32_t periods_in(const lode_commission_t *self, float time_s) {
    const float periods = time_s * self->config.f_pwm_Hz + 0.5f;
    return (uint32_t)(int32_t)periods;
}

static float float_of(uint32_t count) {
    return (float)(int32_t)count;
}

static void post(lode_commission_t *self, lode_command_t command) {
    (void)lode_drive_post_command(self->drive, &command);
}

static void post_vector(lode_commission_t *self, lode_mode_t mode, float d, float q) {
    post(self, (lode_command_t){.mode = mode, .vector = {d, q}, .theta_rad = self->axis_rad});
}

// The next period is the stage's first again.
static void restart(lode_commission_t *self) {
    self->since = BEFORE_FIRST;
}

static void enter(lode_commission_t *self, stage_t stage) {
    self->stage = (uint32_t)stage;
    restart(self);
    self->calm = 0u;
    self->sums = (lode_commission_sums_t){.count = 0u};
}

static void finish(lode_commission_t *self, lode_commission_result_t result) {
    enter(self, STAGE_OVER);
    self->result = result;
    post(self, (lode_command_t){.mode = LODE_MODE_OFF});
}

// How far a value agrees with itself.
static lode_commission_value_t judged(float value, float deviation, float allowed) {
    const float share = deviation / lode_max(allowed, FLT_MIN);
    const float confidence = 1.0f / (1.0f + share * share);
    return (lode_commission_value_t){value, lode_is_finite(value + confidence) ? confidence : 0.0f};
}

static lode_commission_quantity_t offset_of(uint32_t phase) {
    const uint32_t quantity = (uint32_t)LODE_COMMISSION_OFFSET_A + phase;
    return (lode_commission_quantity_t)quantity;
}

// False: refused, and it is over.
static bool keep(lode_commission_t *self, lode_commission_quantity_t quantity, float value,
                 float deviation, float allowed) {
    self->found[quantity] = judged(value, deviation, allowed);
    self->quantity = quantity;
    if (self->found[quantity].confidence < LODE_COMMISSION_SURE) {
        finish(self, LODE_COMMISSION_UNSURE);
        return false;
    }
    return true;
}

static float found(const lode_commission_t *self, lode_commission_quantity_t quantity) {
    return self->found[quantity].value;
}

static bool is_sure(const lode_commission_t *self, lode_commission_quantity_t quantity) {
    return self->found[quantity].confidence >= LODE_COMMISSION_SURE;
}

static float length_of(lode_dq_t x) {
    return lode_ab_length((lode_ab_t){x.d, x.q});
}

static uint32_t phases_of(const lode_commission_t *self) {
    return PHASES * self->sets;
}

// Voltage along the axis that holds, per volt that each phase loses.
static float dead_along(const lode_commission_t *self) {
    return self->sets > 1u ? DEAD_SIX : DEAD_THREE;
}

// --- Offsets ---

// Extremes of the counts, in the fields of the pulses' peaks.
static void note_counts(lode_commission_t *self, const lode_counts_t *counts) {
    for (uint32_t x = 0u; x < PHASES; x++) {
        const float count = (float)counts->i[x];
        const bool first = self->since == 0u;
        self->level_u_V[x] = first ? count : lode_min(self->level_u_V[x], count);
        self->level_i_A[x] = first ? count : lode_max(self->level_i_A[x], count);
        self->phase_A[x] = (first ? 0.0f : self->phase_A[x]) + count;
    }
}

// False: refused.
static bool judge_offsets(lode_commission_t *self) {
    const lode_sense_config_t *sense = &self->designed.sense;
    for (uint32_t x = 0u; x < PHASES; x++) {
        const bool there = x < 2u || sense->shunts == LODE_SHUNTS_THREE;
        const float span = there ? self->level_i_A[x] - self->level_u_V[x] : 0.0f;
        self->phase_A[x] /= float_of(OFFSET_SAMPLES);
        if (!keep(self, offset_of(PHASES * self->level + x), self->phase_A[x], span,
                  NOISE_MOST * sense->count_max)) {
            return false;
        }
    }
    return true;
}

// A set after the other, then the drive's own.
static void calibrate(lode_commission_t *self, const lode_commission_period_t *period) {
    if (self->since < OFFSET_SAMPLES) {
        note_counts(self, period->set[self->level]);
    } else if (self->since == OFFSET_SAMPLES) {
        if (!judge_offsets(self)) {
            return;
        }
        if (self->level + 1u < self->sets) {
            self->level++;
            restart(self);
        } else {
            post(self, (lode_command_t){.mode = LODE_MODE_CALIBRATE});
        }
    } else if (self->drive->calibrated) {
        self->quantity = LODE_COMMISSION_SIGNALS;
        self->level = 0u;
        enter(self, STAGE_PULSES);
    } else {
        // a fault, if it does not come
    }
}

// --- Signals ---

// What a phase loses, as far as it is known.
static float dead_known_V(const lode_drive_config_t *config) {
    const lode_inverter_config_t *inverter = &config->inverter;
    return inverter->v_drop_V + inverter->v_bus_V * inverter->dead_time_s *
                                    lode_inverter_carrier_Hz(inverter, config->f_pwm_Hz);
}

// Phase currents at the largest length of the vector, and the current of the xy plane.
static void note_peak(lode_commission_t *self, const lode_commission_period_t *period,
                      lode_dq_t i_A) {
    const lode_counts_t *counts = period->set[self->level / PHASES];
    const lode_sense_config_t *sense = &self->designed.sense;
    const float length_A = length_of(i_A);
    if (length_A <= self->peak_A) {
        return;
    }
    self->peak_xy_A = lode_ab_length(period->i_xy_A);
    self->peak_A = length_A;
    for (uint32_t x = 0u; x < PHASES; x++) {
        const float offset = found(self, offset_of(PHASES * (self->level / PHASES) + x));
        self->phase_A[x] = sense->i_gain_A_count * ((float)counts->i[x] - offset);
    }
    if (sense->shunts == LODE_SHUNTS_TWO) {
        self->phase_A[2] = -(self->phase_A[0] + self->phase_A[1]);
    }
}

// A wrong sign or a wrong place makes the driven phase small or negative, a dead one leaves a sum; in the wrong set it makes
// current of the xy plane.
static bool judge_phase(lode_commission_t *self, uint32_t driven) {
    const float *i = self->phase_A;
    const float largest = lode_max(lode_max(lode_abs(i[0]), lode_abs(i[1])), lode_abs(i[2]));
    const float inv = 1.0f / lode_max(largest, FLT_MIN);
    const float off = 1.0f - i[driven % PHASES] * inv;
    const float sum = lode_abs(i[0] + i[1] + i[2]) * inv;
    const float xy = self->peak_xy_A / lode_max(self->peak_A, FLT_MIN);
    const float worst =
        lode_max(lode_max(off / (1.0f - DRIVEN_LEAST), sum / SUM_MOST), xy / XY_MOST);
    const float least_A = NOISE_MOST * self->designed.inverter.i_max_A;
    return keep(self, LODE_COMMISSION_SIGNALS, float_of(driven + 1u),
                self->peak_A > least_A ? worst : 2.0f, 1.0f);
}

// Voltage along the driven phase: by what is known at first, then more, for the dead time may take more.
static float pulse_V(const lode_commission_t *self) {
    const lode_motor_t *motor = &self->designed.motor;
    const float step_A = PULSE_SHARE * self->designed.inverter.i_max_A;
    const float rise_s = float_of(PULSE_PERIODS) / self->config.f_pwm_Hz;
    const float rise_V = lode_min(motor->Ld_H, motor->Lq_H) * step_A / rise_s;
    return dead_along(self) * dead_known_V(&self->designed) +
           rise_V * (1.0f + 0.5f * float_of(self->calm));
}

// Once more with more voltage, or the next phase.
static void end_pulse(lode_commission_t *self) {
    const float seen_A = PULSE_SEEN * self->designed.inverter.i_max_A;
    if (self->peak_A < seen_A && self->calm < PULSES_MOST) {
        self->calm++;
        restart(self);
    } else if (judge_phase(self, self->level)) {
        self->peak_A = 0.0f;
        self->level++;
        enter(self, self->level < phases_of(self) ? STAGE_PULSES : STAGE_ACROSS);
    } else {
        // refused
    }
}

// Axis of a phase; those of set 2 stand 30 degrees on.
static float phase_rad(uint32_t phase) {
    const float set_2_rad = phase < PHASES ? 0.0f : LODE_PI / 6.0f;
    return set_2_rad + LODE_TWO_PI / 3.0f * float_of(phase % PHASES);
}

static void pulse(lode_commission_t *self, const lode_commission_period_t *period, lode_dq_t i_A) {
    const lode_sincos_t axis = lode_sincos(phase_rad(self->level) - self->axis_rad);
    const float pulse_u_V = pulse_V(self);
    float u_V = 0.0f;
    if (self->since < PULSE_PERIODS) {
        u_V = pulse_u_V;
    } else if (self->since < 2u * PULSE_PERIODS) {
        u_V = -pulse_u_V;
    } else {
        // rest
    }
    post_vector(self, LODE_MODE_VOLTAGE, u_V * axis.cos, u_V * axis.sin);
    if (self->since < PULSE_PERIODS + SEEN_PERIODS) {
        note_peak(self, period, i_A);
    } else if (self->since >= REST_PERIODS) {
        end_pulse(self);
    } else {
        // it dies away
    }
}

// --- Resistance and dead time ---

// Means over the halves of a window. True at its end.
static bool window_ends(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A) {
    lode_commission_sums_t *s = &self->sums;
    const uint32_t length = periods_in(self, WINDOW_s);
    uint32_t half = 0u;
    if (s->count >= length / 2u) {
        half = 1u;
    }
    s->u.d += u_V.d;
    s->i[half].d += i_A.d;
    s->i[half].q += i_A.q;
    s->count++;
    return s->count >= length / 2u * 2u;
}

// The current has been the same for long enough: the rotor rests. `i_A`: its mean along the vector, `u_V` that of
// the voltage.
static bool settled(lode_commission_t *self, float *u_V, float *i_A) {
    const lode_commission_sums_t s = self->sums;
    const float inv = 1.0f / float_of(s.count);
    const lode_dq_t change = {2.0f * inv * (s.i[1].d - s.i[0].d),
                              2.0f * inv * (s.i[1].q - s.i[0].q)};
    *u_V = inv * s.u.d;
    *i_A = inv * (s.i[0].d + s.i[1].d);
    self->sums = (lode_commission_sums_t){.count = 0u};
    self->calm = length_of(change) <= CALM_SHARE * self->current_A ? self->calm + 1u : 0u;
    return self->calm >= CALM_WINDOWS;
}

// The first direction: the voltage rises until the current is there, then turns to the other.
static void across(lode_commission_t *self, lode_dq_t i_A) {
    if (self->level == phases_of(self)) {
        const float length_A = length_of(i_A);
        // Once is enough: while the rotor turns, its EMF takes the current away.
        self->calm += length_A >= SOME_SHARE * self->current_A ? 1u : 0u;
        self->quantity = LODE_COMMISSION_RS_Ohm;
        self->u_V += self->calm > 0u ? self->slow_V : self->quick_V;
        post_vector(self, LODE_MODE_VOLTAGE, 0.0f, self->u_V);
        if (length_A >= CATCH_SHARE * self->current_A) {
            self->level++;
            restart(self);
        } else if (self->u_V > self->u_max_V) {
            finish(self, LODE_COMMISSION_NO_CURRENT);
        } else {
            // it rises
        }
    } else {
        const float turned = float_of(self->since) / (TURN_TIME_s * self->config.f_pwm_Hz);
        self->u_V -= length_of(i_A) > CATCH_SHARE * self->current_A ? QUICKER * self->slow_V : 0.0f;
        const lode_sincos_t at = lode_sincos(0.5f * LODE_PI * lode_max(1.0f - turned, 0.0f));
        post_vector(self, LODE_MODE_VOLTAGE, self->u_V * at.cos, self->u_V * at.sin);
        if (turned >= 1.0f) {
            self->level = 0u;
            enter(self, STAGE_LEVEL);
        }
    }
}

// A line through the voltages at three currents: its slope, and what is left without current. Both the drops
// and the dead time go by the signs of the phase currents.
static bool judge_levels(lode_commission_t *self) {
    const float *u = self->level_u_V;
    const float *i = self->level_i_A;
    const float r_Ohm = (u[0] - u[2]) / (i[0] - i[2]);
    const float dead_V = (u[0] - r_Ohm * i[0]) / dead_along(self);
    const float off_V = u[1] - (u[0] + r_Ohm * (i[1] - i[0]));
    const float span_V = r_Ohm * (i[0] - i[2]);
    // By the same deviation, of which more is allowed.
    self->found[LODE_COMMISSION_DEAD_V] =
        judged(dead_V, lode_abs(off_V), LINE_DEVIATION * lode_max(lode_abs(dead_V), span_V));
    return r_Ohm > 0.0f &&
           keep(self, LODE_COMMISSION_RS_Ohm, r_Ohm, lode_abs(off_V), LINE_DEVIATION * span_V);
}

// Rest at the present level, then note it.
static void along(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A) {
    float mean_V;
    float mean_A;
    if (!window_ends(self, u_V, i_A)) {
        return;
    }
    if (!settled(self, &mean_V, &mean_A)) {
        if (self->since > periods_in(self, SETTLE_TIME_s)) {
            finish(self, LODE_COMMISSION_UNSETTLED);
        }
        return;
    }
    self->level_u_V[self->level] = mean_V;
    self->level_i_A[self->level] = mean_A;
    self->level++;
    if (self->level < LEVELS) {
        enter(self, STAGE_LEVEL);
    } else if (judge_levels(self)) {
        self->quantity = LODE_COMMISSION_LD_H;
        self->level = 0u;
        enter(self, STAGE_LD);
    } else {
        finish(self, LODE_COMMISSION_UNSURE);
    }
}

// To the next level, up or down: a rotor that swung makes more current than the voltage does, or less.
static void move_level(lode_commission_t *self, lode_dq_t i_A) {
    const float wanted_A = self->current_A * (1.0f - LEVEL_STEP * float_of(self->level));
    const bool below = i_A.d < wanted_A;
    if (self->since == 0u) {
        self->rises = below;
    }
    self->u_V += (self->rises ? QUICKER : -QUICKER) * self->slow_V;
    post_vector(self, LODE_MODE_VOLTAGE, self->u_V, 0.0f);
    if (self->u_V > self->u_max_V) {
        finish(self, LODE_COMMISSION_NO_CURRENT);
    } else if (below != self->rises) {
        enter(self, STAGE_ALONG);
    } else {
        // it moves
    }
}

// --- Inductances ---

static float sign_of_half(uint32_t half) {
    return half % 2u == 0u ? 1.0f : -1.0f;
}

// Second differences of L di = (u - R i) Ts: neither the dead time nor the EMF of a rotor that hardly moves
// stands in them (N1). The voltage is known, the current has noise: 1/L is what is regressed.
static void note_step(lode_commission_t *self, float u_V, float u1_V, float i_A, float i1_A,
                      float i2_A) {
    const float r_Ohm = found(self, LODE_COMMISSION_RS_Ohm);
    const float x = u_V - u1_V - 0.5f * r_Ohm * (i_A - i2_A);
    const float y = (i_A - 2.0f * i1_A + i2_A) * self->config.f_pwm_Hz;
    self->sums.count++;
    self->sums.tx += lode_abs(i_A) * x * x;
    self->sums.xx += x * x;
    self->sums.xy += x * y;
    self->sums.yy += y * y;
}

static bool judge_steps(lode_commission_t *self, lode_commission_quantity_t quantity,
                        float allowed) {
    const lode_commission_sums_t *s = &self->sums;
    const float fit = s->xy * s->xy / (s->xx * s->yy);
    const float deviation = lode_sqrt(lode_max(1.0f / fit - 1.0f, 0.0f) / float_of(s->count));
    return keep(self, quantity, s->xx / s->xy, deviation, allowed);
}

static float step_share(const lode_commission_t *self, bool q_axis) {
    return q_axis && self->sets > 1u ? STEP_SIX : STEP_SHARE;
}

// Steps of the current along one axis on top of `hold_A`, which holds the rotor. True at their end.
static bool steps(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A, bool q_axis, float hold_A,
                  float wait_s, uint32_t waves) {
    const lode_dq_t *u1 = &self->before_u_V;
    const lode_dq_t *i1 = &self->before_i_A[0];
    const lode_dq_t *i2 = &self->before_i_A[1];
    const uint32_t begin = periods_in(self, wait_s);
    float step_A = 0.0f;
    if (self->since >= begin) {
        const uint32_t half = (self->since - begin) / HALF_WAVE;
        const float part = 0.5f * float_of(half) / float_of(waves) - 0.5f;
        const float share = step_share(self, q_axis) * (1.0f + STEP_SPREAD * part);
        step_A = sign_of_half(half) * share * hold_A;
        if (q_axis) {
            note_step(self, u_V.q, u1->q, i_A.q, i1->q, i2->q);
        } else {
            note_step(self, u_V.d, u1->d, i_A.d, i1->d, i2->d);
        }
    }
    post_vector(self, LODE_MODE_CURRENT, hold_A + (q_axis ? 0.0f : step_A), q_axis ? step_A : 0.0f);
    return self->since >= begin + 2u * HALF_WAVE * waves;
}

static float step_hold_A(const lode_commission_t *self) {
    return HOLD_SHARE * self->current_A;
}

// --- Their fall over current ---

// By least squares through 1/L over current; returns what the line has without current. `reach_A`: where a fall
// must show to be one. Without confidence it stays as it was known.
static float judge_fall(lode_commission_t *self, lode_commission_quantity_t quantity,
                        const float *x_A, const float *y_1_H, float reach_A) {
    const float third = 1.0f / float_of(FALL_POINTS);
    const float x_mean = third * (x_A[0] + x_A[1] + x_A[2]);
    const float y_mean = third * (y_1_H[0] + y_1_H[1] + y_1_H[2]);
    float xx = 0.0f;
    float xy = 0.0f;
    float yy = 0.0f;
    for (uint32_t k = 0u; k < FALL_POINTS; k++) {
        const float x = x_A[k] - x_mean;
        const float y = y_1_H[k] - y_mean;
        xx += x * x;
        xy += x * y;
        yy += y * y;
    }
    const float slope = xy / xx;
    const float none_1_H = y_mean - slope * x_mean;
    const float off_1_H = lode_sqrt(lode_max(yy - slope * xy, 0.0f));
    const float fall = slope / none_1_H;
    self->found[quantity] =
        judged(fall * reach_A > FALL_LEAST ? fall : 0.0f, off_1_H, FALL_DEVIATION * none_1_H);
    return none_1_H;
}

static bool falls(const lode_commission_t *self, lode_commission_quantity_t quantity) {
    return is_sure(self, quantity) && found(self, quantity) > 0.0f;
}

static void judge_fall_d(lode_commission_t *self) {
    const float none_1_H = judge_fall(self, LODE_COMMISSION_LD_FALL_1_A, self->fall_A[0],
                                      self->fall_1_H[0], self->current_A);
    if (falls(self, LODE_COMMISSION_LD_FALL_1_A)) {
        self->found[LODE_COMMISSION_LD_H].value = 1.0f / none_1_H;
    }
    self->quantity = LODE_COMMISSION_LQ_H;
    enter(self, STAGE_LQ);
}

static void find_Ld(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A) {
    const uint32_t level = self->level;
    const float hold_A = self->current_A * (1.0f - FALL_D_STEP * float_of(level));
    const float wait_s = level == 0u ? HOLD_TIME_s : NEXT_TIME_s;
    uint32_t waves = WAVES_BESIDE;
    if (level == FALL_D_MIDDLE) {
        waves = WAVES;
    }
    if (!steps(self, u_V, i_A, false, hold_A, wait_s, waves) ||
        (level == FALL_D_MIDDLE && !judge_steps(self, LODE_COMMISSION_LD_H, STEP_DEVIATION))) {
        return;
    }
    self->fall_A[0][level] = self->sums.tx / self->sums.xx;
    self->fall_1_H[0][level] = self->sums.xy / self->sums.xx;
    self->level++;
    if (self->level < FALL_POINTS) {
        enter(self, STAGE_LD);
    } else {
        judge_fall_d(self);
    }
}

static void find_Lq(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A) {
    if (steps(self, u_V, i_A, true, step_hold_A(self), NEXT_TIME_s, WAVES) &&
        judge_steps(self, LODE_COMMISSION_LQ_H, STEP_DEVIATION)) {
        self->near_A = self->sums.tx / self->sums.xx;
        self->quantity = LODE_COMMISSION_LQ_FALL_1_A;
        self->level = 0u;
        enter(self, STAGE_LQ_FALL);
    }
}

static lode_abc_t phase_losses_V(const lode_dead_time_t *loss, lode_abc_t i_A) {
    return (lode_abc_t){lode_inverter_error(loss, i_A.a), lode_inverter_error(loss, i_A.b),
                        lode_inverter_error(loss, i_A.c)};
}

// What the phases lose, as it shows in q (N3): by the currents in the middle of the period, of which the ripple
// goes by the voltage (I4).
static float dead_q_V(const lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A) {
    const lode_inverter_tuning_t *tuning = &self->drive->tuning->inverter;
    const float span =
        lode_min(LODE_SQRT3 * length_of(u_V) / self->designed.inverter.v_bus_V, 1.0f);
    const float i_dead_A = tuning->i_dead_min_A + tuning->i_dead_span_A * span;
    const lode_dead_time_t loss = {0.5f * found(self, LODE_COMMISSION_DEAD_V) / i_dead_A, i_dead_A};
    const lode_ab_t at_A = lode_park_inverse(i_A, self->axis);
    lode_ab_t V = lode_clarke(phase_losses_V(&loss, lode_clarke_inverse(at_A)));
    if (self->sets > 1u) {
        const lode_ab_t V_2 =
            lode_set2_clarke(phase_losses_V(&loss, lode_set2_clarke_inverse(at_A)));
        V = lode_vsd_ab((lode_sets_t){{V, V_2}});
    }
    return lode_park(V, self->axis).q;
}

// Current and flux that a half-wave has moved. `sign`: of the half-wave.
static void note_half_wave(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A, float sign) {
    const lode_dq_t *i1 = &self->before_i_A[0];
    const lode_dq_t mean_A = {0.5f * (i_A.d + i1->d), 0.5f * (i_A.q + i1->q)};
    const float drop_V =
        found(self, LODE_COMMISSION_RS_Ohm) * mean_A.q + dead_q_V(self, u_V, mean_A);
    self->sums.x += sign * (i_A.q - i1->q);
    self->sums.y += sign * (u_V.q - drop_V) / self->config.f_pwm_Hz;
}

// The same at all amplitudes.
static uint32_t half_wave_periods(const lode_commission_t *self) {
    const lode_inverter_config_t *inverter = &self->designed.inverter;
    const float swing_Vs =
        2.0f * FALL_Q_HIGH * inverter->i_max_A * found(self, LODE_COMMISSION_LQ_H);
    const float u_V = FALL_VOLTAGE * inverter->v_bus_V / LODE_SQRT3;
    return HALF_WAVE + periods_in(self, lode_clamp(swing_Vs / u_V, 0.0f, FALL_LONGEST_s));
}

static float amplitude_A(const lode_commission_t *self) {
    const float i_max_A = self->designed.inverter.i_max_A;
    const float small_A = step_share(self, true) * step_hold_A(self);
    const float large_A = (self->level == 1u ? FALL_Q_MIDDLE : FALL_Q_HIGH) * i_max_A;
    return self->level == 0u ? small_A : large_A;
}

static void judge_fall_q(lode_commission_t *self) {
    (void)judge_fall(self, LODE_COMMISSION_LQ_FALL_1_A, self->fall_A[1], self->fall_1_H[1],
                     self->designed.inverter.i_max_A);
    if (falls(self, LODE_COMMISSION_LQ_FALL_1_A)) {
        const float by = 1.0f + found(self, LODE_COMMISSION_LQ_FALL_1_A) * self->near_A;
        self->found[LODE_COMMISSION_LQ_H].value *= by * by;
    }
    if (self->sets > 1u) {
        self->quantity = LODE_COMMISSION_LXY_H;
        enter(self, STAGE_LXY);
    } else {
        enter(self, STAGE_RETUNE);
    }
}

// The first half-wave has half the length: the rotor swings about where it lies.
static void find_Lq_fall(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A) {
    const uint32_t length = half_wave_periods(self);
    const uint32_t begin = periods_in(self, NEXT_TIME_s);
    const uint32_t under_way = self->since + length / 2u;
    const bool begun = self->since >= begin;
    const uint32_t half = begun ? (under_way - begin) / length : 0u;
    const uint32_t seen =
        self->since >= begin + SEEN_PERIODS ? (under_way - begin - SEEN_PERIODS) / length : 0u;
    const float step_A = begun ? sign_of_half(half) * amplitude_A(self) : 0.0f;
    post_vector(self, LODE_MODE_CURRENT, step_hold_A(self), step_A);
    if (seen > FALL_HALVES) {
        self->fall_A[1][self->level] = 0.5f * self->sums.x / float_of(FALL_HALVES);
        self->fall_1_H[1][self->level] = self->sums.x / self->sums.y;
        self->level++;
        if (self->level < FALL_POINTS) {
            enter(self, STAGE_LQ_FALL);
        } else {
            judge_fall_q(self);
        }
    } else if (seen > 0u) {
        note_half_wave(self, u_V, i_A, sign_of_half(seen));
    } else {
        // the current settles
    }
}

// --- The xy plane ---

// Its control, whose reference is none, is pushed to and fro: current of one sign, then of the other. The rotor, which it
// does not turn, is held meanwhile.
static void find_Lxy(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A) {
    const lode_dq_t *i1 = &self->before_i_A[0];
    const lode_dq_t *i2 = &self->before_i_A[1];
    const uint32_t begin = periods_in(self, NEXT_TIME_s);
    const uint32_t end = begin + 2u * HALF_WAVE * WAVES;
    const bool moves = self->since >= begin && self->since < end;
    const float wanted_V =
        moves ? sign_of_half((self->since - begin) / HALF_WAVE) * self->xy_V : 0.0f;
    self->push_V = wanted_V - self->pushed_V;
    self->pushed_V = wanted_V;
    post_vector(self, LODE_MODE_CURRENT, step_hold_A(self), 0.0f);
    if (moves) {
        note_step(self, u_V.d, self->before_u_V.d, i_A.d, i1->d, i2->d);
    } else if (self->since >= end && judge_steps(self, LODE_COMMISSION_LXY_H, XY_DEVIATION)) {
        enter(self, STAGE_RETUNE);
    } else {
        // the current settles, or it is refused
    }
}

void lode_commission_push_by(lode_commission_t *self, float kp_Ohm, float most_V) {
    self->xy_V = lode_min(kp_Ohm * XY_SHARE * step_hold_A(self), XY_CIRCLE * most_V);
}

// --- With what is known by now ---

void lode_commission_take_standstill(lode_commission_t *self) {
    lode_motor_t *motor = &self->config.motor;
    lode_inverter_config_t *inverter = &self->config.inverter;
    const float lost_V = found(self, LODE_COMMISSION_DEAD_V) - inverter->v_drop_V;
    motor->Rs_Ohm = lode_max(found(self, LODE_COMMISSION_RS_Ohm) - inverter->r_on_Ohm, 0.0f);
    motor->Ld_H = found(self, LODE_COMMISSION_LD_H);
    motor->Lq_H = found(self, LODE_COMMISSION_LQ_H);
#ifndef LODE_WITHOUT_OPTIMAL_REFERENCES
    if (is_sure(self, LODE_COMMISSION_LQ_FALL_1_A)) {
        self->config.references.Lq_fall = found(self, LODE_COMMISSION_LQ_FALL_1_A);
    }
#endif
    inverter->dead_time_s =
        lode_max(lost_V, 0.0f) /
        (self->drive->inverter.v_bus_V * lode_inverter_carrier_Hz(inverter, self->config.f_pwm_Hz));
}

// Flux and inertia are not known yet: the EMF at hand-over has more room than usual.
lode_drive_config_t lode_commission_for_run(lode_commission_t *self) {
    const float handover = self->designed.start.omega_handover_rad_s;
    const float wanted = HANDOVER_SHARE * self->designed.motor.omega_rated_rad_s;
    lode_drive_config_t config = self->config;
    config.start.omega_handover_rad_s = lode_clamp(wanted, handover, HANDOVER_MORE * handover);
    self->designed.start.omega_handover_rad_s = config.start.omega_handover_rad_s;
    return config;
}

void lode_commission_go_on(lode_commission_t *self, lode_status_t status) {
    self->status = status;
    LODE_SIGNAL_FENCE();
    self->wants_tuning = false;
}

lode_commission_result_t lode_commission_work(lode_commission_t *self) {
    if (self->wants_tuning) {
        lode_commission_take_standstill(self);
        self->designed = self->config;
        lode_drive_design(&self->designed);
        const lode_drive_config_t config = lode_commission_for_run(self);
        lode_drive_tuning_t *next = &self->tuning[self->drive->tuning == &self->tuning[0] ? 1 : 0];
        const lode_status_t status = lode_drive_tune(next, &config);
        if (status == LODE_OK) {
            (void)lode_drive_post_tuning(self->drive, next);
        }
        lode_commission_go_on(self, status);
    }
    return self->result;
}

static void retune(lode_commission_t *self) {
    const lode_drive_config_t *config = &self->designed;
    if (self->since == 0u) {
        post(self, (lode_command_t){.mode = LODE_MODE_OFF, .clear_fault = true});
        self->wants_tuning = true;
    } else if (self->wants_tuning) {
        // the thread is at it
    } else if (self->status != LODE_OK) {
        finish(self, LODE_COMMISSION_REFUSED);
    } else {
        const float inv_np = 1.0f / config->motor.pole_pairs;
        const float rated = config->motor.omega_rated_rad_s;
        const float low =
            lode_max(LOW_SHARE * rated, ABOVE_HANDOVER * config->start.omega_handover_rad_s);
        const float wanted = lode_max(
            lode_clamp(SPAN_WANTED * low, HIGH_SHARE * rated, HIGH_MOST * rated), SPAN_LEAST * low);
        const float high = lode_min(wanted, HIGH_OF_MOST * config->estimator.omega_max_rad_s);
        const float kt_Nm_A = lode_motor_kt_Nm_A(&config->motor);
        const float most_Nm = kt_Nm_A * config->inverter.i_max_A;
        // Within the dead band of the currents the dead time's loss changes with speed, and stands in the slope.
        const float least_Nm =
            lode_max(TORQUE_LEAST * most_Nm, kt_Nm_A * config->inverter.i_dead_A);
        self->low_rad_s = low * inv_np;
        self->high_rad_s = high * inv_np;
        self->torque_Nm =
            lode_clamp(config->motor.J_kgm2 * (self->high_rad_s - self->low_rad_s) / RUN_TIME_s,
                       least_Nm, TORQUE_MOST * most_Nm);
        self->quantity = LODE_COMMISSION_PSI_Wb;
        enter(self, STAGE_START);
    }
}

// --- The run ---

static float speed_of(const lode_commission_t *self) {
    return self->drive->estimator.pll.omega_rad_s / self->config.motor.pole_pairs;
}

static void start(lode_commission_t *self) {
    const float off = lode_abs(speed_of(self) - self->low_rad_s);
    const bool steady =
        self->drive->mode == (uint_least8_t)LODE_MODE_RUN && off <= REACHED * self->low_rad_s;
    post(self, (lode_command_t){.mode = LODE_MODE_RUN, .speed_rad_s = self->low_rad_s});
    // More often than not: with little EMF the speed ripples by as much.
    self->calm = steady ? self->calm + 1u : self->calm - (self->calm > 0u ? 1u : 0u);
    if (self->calm >= periods_in(self, STEADY_s)) {
        enter(self, STAGE_UP);
    } else if (self->since > periods_in(self, self->designed.start.timeout_s + RUN_WAIT_s)) {
        finish(self, LODE_COMMISSION_NO_START);
    } else {
        // on its way
    }
}

// Lines through speed over time and voltage over speed, from the first point on.
static void note_run(lode_commission_t *self) {
    const lode_drive_t *drive = self->drive;
    lode_commission_sums_t *s = &self->sums;
    const float omega = drive->estimator.pll.omega_rad_s;
    // The d current fades with speed where the references bias it.
    const float u_V = drive->u_V.q - found(self, LODE_COMMISSION_RS_Ohm) * drive->i_A.q -
                      omega * self->config.motor.Ld_H * drive->i_A.d;
    if (s->count == 0u) {
        self->before_u_V = (lode_dq_t){u_V, omega};
        self->level = self->since;
    }
    const float t = float_of(self->since - self->level) / self->config.f_pwm_Hz;
    const float x = omega - self->before_u_V.q;
    const float y = u_V - self->before_u_V.d;
    s->count++;
    s->t += t;
    s->x += x;
    s->y += y;
    s->tx += t * x;
    s->u.d += t * t;
    s->xx += x * x;
    s->xy += x * y;
    s->i[0].d += drive->i_A.d;
    s->i[0].q += drive->i_A.q;
}

static void take_run(lode_commission_t *self, uint32_t way) {
    const lode_commission_sums_t *s = &self->sums;
    const lode_motor_t *motor = &self->config.motor;
    const float n = float_of(s->count);
    const float inv = 1.0f / n;
    const lode_dq_t i_A = {inv * s->i[0].d, inv * s->i[0].q};
    self->run_psi_Wb[way] = (n * s->xy - s->x * s->y) / (n * s->xx - s->x * s->x);
    self->run_acc[way] = (n * s->tx - s->t * s->x) / (n * s->u.d - s->t * s->t) / motor->pole_pairs;
    self->run_omega[way] = (self->before_u_V.q + inv * s->x) / motor->pole_pairs;
    self->run_torque_Nm[way] = lode_motor_torque_factor(motor) *
                               (self->run_psi_Wb[way] + (motor->Ld_H - motor->Lq_H) * i_A.d) *
                               i_A.q;
}

// The run was made with a flux or an inertia so far off that it is made again.
static bool is_rough(const lode_commission_t *self, float psi_Wb, float J) {
    const lode_motor_t *motor = &self->config.motor;
    return self->runs == 0u && psi_Wb > 0.0f && J > 0.0f &&
           (lode_abs(psi_Wb - motor->psi_Wb) > PSI_ROUGH * motor->psi_Wb ||
            lode_abs(J - motor->J_kgm2) > J_ROUGH * motor->J_kgm2);
}

// Friction acts alike up and down through the same speeds.
static void judge_run(lode_commission_t *self) {
    const float *psi = self->run_psi_Wb;
    const float *acc = self->run_acc;
    const float *torque = self->run_torque_Nm;
    const float mean_Wb = 0.5f * (psi[0] + psi[1]);
    const float J = (torque[0] - torque[1]) / (acc[0] - acc[1]);
    const float friction_Nm = 0.5f * (torque[0] + torque[1] - J * (acc[0] + acc[1]));
    const float omega = 0.5f * (self->run_omega[0] + self->run_omega[1]);
    const float unequal = lode_abs(torque[0] + torque[1]) / lode_abs(torque[0] - torque[1]);
    lode_motor_t *motor = &self->config.motor;
    const bool rough = is_rough(self, mean_Wb, J);
    self->found[LODE_COMMISSION_B_Nms] =
        judged(friction_Nm / omega, TORQUE_DEVIATION * lode_abs(torque[0]),
               B_DEVIATION * lode_max(friction_Nm, 0.0f));
    if (!rough && (!keep(self, LODE_COMMISSION_PSI_Wb, mean_Wb, lode_abs(psi[0] - psi[1]),
                         PSI_DEVIATION * mean_Wb) ||
                   !keep(self, LODE_COMMISSION_J_kgm2, J, unequal, 1.0f))) {
        return;
    }
    // Of a run too short for the PLL to settle, which makes the flux too small, the inertia alone is taken.
    const bool agree = lode_abs(psi[0] - psi[1]) <= PSI_DEVIATION * mean_Wb;
    const float psi_Wb = agree ? mean_Wb : motor->psi_Wb;
    motor->J_kgm2 = J * psi_Wb / mean_Wb;
    motor->psi_Wb = psi_Wb;
    self->runs++;
    if (rough) {
        enter(self, STAGE_RETUNE);
        return;
    }
    if (is_sure(self, LODE_COMMISSION_B_Nms)) {
        motor->B_Nms = friction_Nm / omega;
    }
    finish(self, LODE_COMMISSION_DONE);
}

static void run(lode_commission_t *self, uint32_t way) {
    const float sign = way == 0u ? 1.0f : -1.0f;
    const float edge = EDGE_SHARE * (self->high_rad_s - self->low_rad_s);
    const float from = self->low_rad_s + edge;
    const float to = self->high_rad_s - edge;
    const float now = speed_of(self);
    post(self, (lode_command_t){.mode = LODE_MODE_RUN,
                                .speed_rad_s = SPEED_ROOM * self->high_rad_s,
                                .control = LODE_CONTROL_TORQUE,
                                .torque_Nm = sign * self->torque_Nm});
    const bool past = way == 0u ? now > self->high_rad_s : now < from;
    const bool inside = lode_in_range(now, from, to);
    if (inside) {
        note_run(self);
    }
    if (past && self->sums.count >= POINTS_LEAST) {
        take_run(self, way);
        if (way == 0u) {
            enter(self, STAGE_DOWN);
        } else {
            judge_run(self);
        }
    } else if (self->since > periods_in(self, RUN_WAIT_s)) {
        finish(self, LODE_COMMISSION_NO_START);
    } else {
        // under way
    }
}

// A rotor that was lost is looked for once more, with twice the inertia: a slower start, and less of an
// acceleration that does not come. One that does not follow in any attempt of a start, which get slower by themselves, is not,
// and all other faults end it.
static void end_by_fault(lode_commission_t *self) {
    const uint_least8_t check = self->drive->guard.fault.check;
    const bool lost = check == (uint_least8_t)LODE_CHECK_LOST_LOCK ||
                      check == (uint_least8_t)LODE_CHECK_WRONG_WAY;
    if (check == (uint_least8_t)LODE_CHECK_START) {
        finish(self, LODE_COMMISSION_NO_START);
    } else if (lost && self->lost < LOST_MOST) { // these checks are of START and RUN alone
        self->lost++;
        self->config.motor.J_kgm2 *= LOST_INERTIA;
        enter(self, STAGE_RETUNE);
    } else {
        finish(self, LODE_COMMISSION_FAULT);
    }
}

// --- The whole ---

static void proceed(lode_commission_t *self, const lode_commission_period_t *period, lode_dq_t u_V,
                    lode_dq_t i_A) {
    switch ((stage_t)self->stage) {
    case STAGE_CALIBRATE:
        calibrate(self, period);
        break;
    case STAGE_PULSES:
        pulse(self, period, i_A);
        break;
    case STAGE_ACROSS:
        across(self, i_A);
        break;
    case STAGE_ALONG:
        along(self, u_V, i_A);
        break;
    case STAGE_LEVEL:
        move_level(self, i_A);
        break;
    case STAGE_LD:
        find_Ld(self, u_V, i_A);
        break;
    case STAGE_LQ:
        find_Lq(self, u_V, i_A);
        break;
    case STAGE_LQ_FALL:
        find_Lq_fall(self, u_V, i_A);
        break;
    case STAGE_LXY:
        find_Lxy(self, u_V, i_A);
        break;
    case STAGE_RETUNE:
        retune(self);
        break;
    case STAGE_START:
        start(self);
        break;
    case STAGE_UP:
        run(self, 0u);
        break;
    case STAGE_DOWN:
        run(self, 1u);
        break;
    case STAGE_OVER:
    default:
        break;
    }
}

lode_drive_config_t lode_commission_blind(const lode_drive_config_t *given) {
    lode_drive_config_t blind = *given;
    blind.inverter.dead_time_correction = LODE_OFF;
    blind.inverter.dead_time_model = LODE_OFF;
    return blind;
}

void lode_commission_begin(lode_commission_t *self, lode_drive_t *drive,
                           const lode_drive_config_t *given, const lode_drive_config_t *designed) {
    const lode_motor_t *motor = &designed->motor;
    const bool six = motor->sets > 1.0f;
    const float axis_rad = six ? AXIS_SIX_rad : 0.0f;
    *self = (lode_commission_t){
        .drive = drive,
        .config = *given,
        .designed = *designed,
        .sets = six ? (uint32_t)LODE_SETS : 1u,
        .axis_rad = axis_rad,
        .axis = lode_sincos(axis_rad),
    };
    const float r_Ohm = motor->Rs_Ohm + designed->inverter.r_on_Ohm;
    const float dead_V =
        dead_known_V(designed) + UNKNOWN_DEAD_s * given->inverter.v_bus_V *
                                     lode_inverter_carrier_Hz(&given->inverter, given->f_pwm_Hz);
    const float most_A =
        SALIENT_SHARE * motor->psi_Wb / lode_max(motor->Lq_H - motor->Ld_H, FLT_MIN);
    self->current_A = lode_min(CURRENT_SHARE * designed->inverter.i_max_A, most_A);
    const float drop_V = r_Ohm * self->current_A;
    const float rise_s = lode_clamp(RISE_FLUXES * motor->psi_Wb / lode_max(drop_V, FLT_MIN),
                                    RISE_LEAST_s, RISE_MOST_s);
    self->u_max_V = UNKNOWN_R * drop_V + dead_along(self) * dead_V;
    self->quick_V = self->u_max_V / (QUICK_TIME_s * given->f_pwm_Hz);
    self->slow_V = drop_V / (rise_s * given->f_pwm_Hz);
}

lode_status_t lode_commission_init(lode_commission_t *self, lode_drive_t *drive,
                                   lode_drive_tuning_t tuning[2],
                                   const lode_drive_config_t *config) {
    if (self == NULL || drive == NULL || tuning == NULL || config == NULL) {
        return LODE_ERROR_NULL;
    }
    if (config->motor.sets > 1.0f) {
        return LODE_ERROR_MOTOR_SETS;
    }
    lode_drive_config_t designed = lode_commission_blind(config);
    lode_drive_design(&designed);
    const lode_status_t status = lode_drive_init(drive, &tuning[0], &designed);
    if (status == LODE_OK) {
        lode_commission_begin(self, drive, config, &designed);
        self->tuning = tuning;
    }
    return status;
}

void lode_commission_follow(lode_commission_t *self, const lode_commission_period_t *period) {
    const uint32_t stage = self->stage;
    // In these two a fault has been dealt with.
    const bool dealt = stage == (uint32_t)STAGE_RETUNE || stage == (uint32_t)STAGE_OVER;
    self->push_V = 0.0f;
    if (!dealt && !lode_guard_is_good(&self->drive->guard)) {
        end_by_fault(self);
    } else {
        const bool xy = stage == (uint32_t)STAGE_LXY;
        const lode_ab_t turned_V = lode_ab_rotate(period->u_xy_V, self->axis);
        const lode_ab_t turned_A = lode_ab_rotate(period->i_xy_A, self->axis);
        const lode_dq_t u_V =
            xy ? (lode_dq_t){turned_V.alpha, turned_V.beta} : lode_park(period->u_V, self->axis);
        const lode_dq_t i_A = xy ? (lode_dq_t){turned_A.alpha, turned_A.beta} : self->drive->i_A;
        proceed(self, period, u_V, i_A);
        if (stage != (uint32_t)STAGE_UP && stage != (uint32_t)STAGE_DOWN) {
            self->before_i_A[1] = self->before_i_A[0];
            self->before_i_A[0] = i_A;
            self->before_u_V = u_V;
        }
    }
    self->since++;
}

lode_drive_out_t lode_commission_step(lode_commission_t *self, const lode_counts_t *counts) {
    lode_drive_t *drive = self->drive;
    const lode_ab_t none = {0.0f, 0.0f};
    const lode_ab_t u_V = lode_inverter_realised(&drive->inverter, drive->steps);
    const lode_drive_out_t out = lode_drive_step(drive, counts);
    const lode_commission_period_t period = {{counts, NULL}, u_V, none, none};
    lode_commission_follow(self, &period);
    return out;
}

const lode_drive_config_t *lode_commission_config(const lode_commission_t *self) {
    return &self->config;
}

#endif
