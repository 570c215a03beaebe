#include "commission_parts.h"

#ifndef LODE_WITHOUT_COMMISSIONING

// Inductances: steps of the current's reference, on top of a current that holds rotor and signs of all phase currents.
#define HOLD_SHARE 0.7f  // of the current at the first level
#define STEP_SHARE 0.4f  // of the holding current, in both directions
#define STEP_SIX 0.2f    // in q of six phases, two of which carry a quarter of the holding current
#define STEP_SPREAD 0.2f // growth over all steps, of their mean: each rounds to other counts
#define HALF_WAVE 8u     // periods
#define WAVES 68u
#define WAVES_BESIDE 30u // at the other two currents
#define HOLD_TIME_s 0.1f
#define NEXT_TIME_s 0.02f    // to settle at another current
#define STEP_DEVIATION 0.01f // of the inductance: allowed standard deviation, by the residuals

// Largest common gain error of the currents. It would put resistance and inductances off together.
#define GAIN_OFF 0.6f

// The xy plane in the same way: its control is pushed in alternating directions, towards this share of the holding current.
#define XY_SHARE 0.4f
#define XY_CIRCLE 0.5f // of the voltage available to the plane
#define XY_DEVIATION 0.03f

// Fall of the inductances over current: in d steps about three currents (N2), in q large waves of three amplitudes (N4).
#define FALL_POINTS 3u
// Difference of the currents over the holding current: the smallest is clear of the dead band.
#define FALL_D_STEP 0.35f
#define FALL_D_MIDDLE 1u   // Ld is measured here, unless it falls
#define FALL_Q_MIDDLE 0.5f // of i_max, as the next
#define FALL_Q_HIGH 0.75f  // within i_max with the holding current and an overshoot
#define FALL_HALVES 6u
#define FALL_VOLTAGE 0.75f   // of the circle, for the change from one peak to the other
#define FALL_LONGEST_s 0.05f // a longer half-wave would move the rotor
#define FALL_LEAST 0.05f     // a smaller fall counts as none
#define FALL_DEVIATION 0.03f // of the inductance: allowed distance from the line

static float sign_of_half(uint32_t half) {
    return half % 2u == 0u ? 1.0f : -1.0f;
}

// Response of the current to a step: y, by the voltage x.
typedef struct {
    float x;
    float y;
} step_t;

// (N1): second differences of L di = (u - R i) Ts, from which dead time and the EMF of a rotor that hardly moves cancel. The
// voltage is known and the current has noise, so 1/L is regressed.
static step_t step_of(const lode_commission_t *self, float u_V, float u1_V, float i_A, float i1_A,
                      float i2_A) {
    const float r_Ohm = lode_commission_found(self, LODE_COMMISSION_RS_Ohm);
    return (step_t){u_V - u1_V - 0.5f * r_Ohm * (i_A - i2_A),
                    (i_A - 2.0f * i1_A + i2_A) * self->config.f_pwm_Hz};
}

static void note_step(lode_commission_t *self, step_t step, float i_A) {
    lode_commission_steps_t *s = &self->sums.steps;
    s->count++;
    s->xx += step.x * step.x;
    s->xy += step.x * step.y;
    s->yy += step.y * step.y;
    s->ixx += lode_abs(i_A) * step.x * step.x;
}

static float step_share(const lode_commission_t *self, bool q_axis) {
    return q_axis && self->sets > 1u ? STEP_SIX : STEP_SHARE;
}

static float step_hold_A(const lode_commission_t *self) {
    return HOLD_SHARE * self->current_A;
}

// (N6): what else changes the current in q. The current turns the rotor, so that the EMF changes with it from period to
// period; and the iron saturates.
static void note_beside(lode_commission_t *self, step_t step, float mean_A) {
    const float x = step.x;
    const float y = step.y;
    const float z = mean_A;
    const float v = x * lode_abs(z);
    lode_commission_beside_t *s = &self->sums.beside;
    s->xz += x * z;
    s->yz += y * z;
    s->zz += z * z;
    s->xv += x * v;
    s->yv += y * v;
    s->vv += v * v;
    s->zv += z * v;
}

// Takes what these two explain out of the sums of the steps. Returns the mean current of the steps, at which 1/L holds.
static float take_beside_out(lode_commission_steps_t *s, const lode_commission_beside_t *beside) {
    const float near_A = beside->xv / s->xx;
    const float by_z = 1.0f / lode_max(beside->zz, FLT_MIN);
    const float zv = beside->zv - near_A * beside->xz;
    const float vv = beside->vv - near_A * beside->xv - zv * zv * by_z;
    const float xv = -beside->xz * zv * by_z;
    const float yv = beside->yv - near_A * s->xy - beside->yz * zv * by_z;
    const float by_v = 1.0f / lode_max(vv, FLT_MIN);
    s->xx -= beside->xz * beside->xz * by_z + xv * xv * by_v;
    s->xy -= beside->xz * beside->yz * by_z + xv * yv * by_v;
    s->yy -= beside->yz * beside->yz * by_z + yv * yv * by_v;
    return near_A;
}

static bool judge_steps(lode_commission_t *self, lode_commission_quantity_t quantity,
                        float allowed) {
    const lode_commission_steps_t *s = &self->sums.steps;
    const float fit = s->xy * s->xy / (s->xx * s->yy);
    const float deviation =
        lode_sqrt(lode_max(1.0f / fit - 1.0f, 0.0f) / lode_commission_float(s->count));
    return lode_commission_keep(self, quantity, s->xx / s->xy, deviation, allowed);
}

// Steps of the current along one axis on top of `hold_A`, which holds the rotor. True at their end.
static bool steps(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A, bool q_axis, float hold_A,
                  float wait_s, uint32_t waves) {
    const lode_dq_t *u1 = &self->before_u_V;
    const lode_dq_t *i1 = &self->before_i_A[0];
    const lode_dq_t *i2 = &self->before_i_A[1];
    const uint32_t begin = lode_commission_periods(self, wait_s);
    float step_A = 0.0f;
    if (self->since >= begin) {
        const uint32_t half = (self->since - begin) / HALF_WAVE;
        const float part = 0.5f * lode_commission_float(half) / lode_commission_float(waves) - 0.5f;
        const float share = step_share(self, q_axis) * (1.0f + STEP_SPREAD * part);
        step_A = sign_of_half(half) * share * hold_A;
        if (q_axis) {
            const step_t step = step_of(self, u_V.q, u1->q, i_A.q, i1->q, i2->q);
            note_step(self, step, i_A.q);
            note_beside(self, step, (i_A.q + 4.0f * i1->q + i2->q) / 6.0f);
        } else {
            note_step(self, step_of(self, u_V.d, u1->d, i_A.d, i1->d, i2->d), i_A.d);
        }
    }
    lode_commission_post_vector(self, LODE_MODE_CURRENT, hold_A + (q_axis ? 0.0f : step_A),
                                q_axis ? step_A : 0.0f);
    return self->since >= begin + 2u * HALF_WAVE * waves;
}

// --- Fall over current ---

// Line through 1/L over current by least squares; returns its value at no current. `reach_A`: current at which the fall must
// exceed FALL_LEAST. Without confidence the configured fall stays.
static float judge_fall(lode_commission_t *self, lode_commission_quantity_t quantity,
                        const lode_commission_fall_t *points, float reach_A) {
    const float *x_A = points->i_A;
    const float *y_1_H = points->inverse_1_H;
    const float third = 1.0f / lode_commission_float(FALL_POINTS);
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
    self->found[quantity] = lode_commission_judged(fall * reach_A > FALL_LEAST ? fall : 0.0f,
                                                   off_1_H, FALL_DEVIATION * none_1_H);
    return none_1_H;
}

static bool falls(const lode_commission_t *self, lode_commission_quantity_t quantity) {
    return lode_commission_is_sure(self, quantity) && lode_commission_found(self, quantity) > 0.0f;
}

static void judge_fall_d(lode_commission_t *self) {
    const float none_1_H =
        judge_fall(self, LODE_COMMISSION_LD_FALL_1_A, &self->fall_d, self->current_A);
    if (falls(self, LODE_COMMISSION_LD_FALL_1_A)) {
        self->found[LODE_COMMISSION_LD_H].value = 1.0f / none_1_H;
    }
    self->quantity = LODE_COMMISSION_LQ_H;
    lode_commission_enter(self, STAGE_LQ);
}

void lode_commission_Ld(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A) {
    const uint32_t level = self->level;
    const float hold_A = self->current_A * (1.0f - FALL_D_STEP * lode_commission_float(level));
    const float wait_s = level == 0u ? HOLD_TIME_s : NEXT_TIME_s;
    uint32_t waves = WAVES_BESIDE;
    if (level == FALL_D_MIDDLE) {
        waves = WAVES;
    }
    if (!steps(self, u_V, i_A, false, hold_A, wait_s, waves) ||
        (level == FALL_D_MIDDLE && !judge_steps(self, LODE_COMMISSION_LD_H, STEP_DEVIATION))) {
        return;
    }
    self->fall_d.i_A[level] = self->sums.steps.ixx / self->sums.steps.xx;
    self->fall_d.inverse_1_H[level] = self->sums.steps.xy / self->sums.steps.xx;
    self->level++;
    if (self->level < FALL_POINTS) {
        lode_commission_enter(self, STAGE_LD);
    } else {
        judge_fall_d(self);
    }
}

// Ratio of the value found to the known one.
static float times(const lode_commission_t *self, lode_commission_quantity_t quantity,
                   float known) {
    return lode_commission_found(self, quantity) / known;
}

// A wrong gain of the currents makes resistance and inductances all too large or all too small. False: all three are off by
// more than a data sheet may be, and commissioning ends before the rotor turns.
static bool judge_gain(lode_commission_t *self) {
    const lode_drive_config_t *known = &self->designed;
    const float r =
        times(self, LODE_COMMISSION_RS_Ohm, known->motor.Rs_Ohm + known->inverter.r_on_Ohm);
    const float d = times(self, LODE_COMMISSION_LD_H, known->motor.Ld_H);
    const float q = times(self, LODE_COMMISSION_LQ_H, known->motor.Lq_H);
    const float larger = lode_min(r, lode_min(d, q));
    const float smaller = 1.0f / lode_max(r, lode_max(d, q));
    const float off = lode_max(larger, smaller) - 1.0f;
    if (!(off <= GAIN_OFF)) {
        (void)lode_commission_keep(self, LODE_COMMISSION_SIGNALS,
                                   lode_commission_found(self, LODE_COMMISSION_SIGNALS), off,
                                   GAIN_OFF);
        return false;
    }
    return true;
}

void lode_commission_Lq(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A) {
    if (!steps(self, u_V, i_A, true, step_hold_A(self), NEXT_TIME_s, WAVES)) {
        return;
    }
    self->near_A = take_beside_out(&self->sums.steps, &self->sums.beside);
    if (judge_steps(self, LODE_COMMISSION_LQ_H, STEP_DEVIATION) && judge_gain(self)) {
        self->quantity = LODE_COMMISSION_LQ_FALL_1_A;
        self->level = 0u;
        lode_commission_enter(self, STAGE_LQ_FALL);
    }
}

static lode_abc_t phase_losses_V(const lode_dead_time_t *loss, lode_abc_t i_A) {
    return (lode_abc_t){lode_inverter_error(loss, i_A.a), lode_inverter_error(loss, i_A.b),
                        lode_inverter_error(loss, i_A.c)};
}

// (N3): voltage that the phases lose, along q, by the currents in the middle of the period. Its band follows their ripple,
// which goes with the voltage (I4).
static float dead_q_V(const lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A) {
    const lode_inverter_tuning_t *tuning = &self->drive->tuning->inverter;
    const float span =
        lode_min(LODE_SQRT3 * lode_commission_length(u_V) / self->designed.inverter.v_bus_V, 1.0f);
    const float i_dead_A = tuning->i_dead_min_A + tuning->i_dead_span_A * span;
    const lode_dead_time_t loss = {
        0.5f * lode_commission_found(self, LODE_COMMISSION_DEAD_V) / i_dead_A, i_dead_A};
    const lode_ab_t at_A = lode_park_inverse(i_A, self->axis);
    lode_ab_t V = lode_clarke(phase_losses_V(&loss, lode_clarke_inverse(at_A)));
    if (self->sets > 1u) {
        const lode_ab_t V_2 =
            lode_set2_clarke(phase_losses_V(&loss, lode_set2_clarke_inverse(at_A)));
        V = lode_vsd_ab((lode_sets_t){{V, V_2}});
    }
    return lode_park(V, self->axis).q;
}

// Adds the current and the flux that a half-wave of the sign `sign` moves (N3).
static void note_half_wave(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A, float sign) {
    const lode_dq_t *i1 = &self->before_i_A[0];
    const lode_dq_t mean_A = {0.5f * (i_A.d + i1->d), 0.5f * (i_A.q + i1->q)};
    const float drop_V = lode_commission_found(self, LODE_COMMISSION_RS_Ohm) * mean_A.q +
                         dead_q_V(self, u_V, mean_A);
    self->sums.waves.i_A += sign * (i_A.q - i1->q);
    self->sums.waves.flux_Vs += sign * (u_V.q - drop_V) / self->config.f_pwm_Hz;
}

// Length of a half-wave. It is the same at all amplitudes, so that the motion of the rotor has the same share in each.
static uint32_t half_wave_periods(const lode_commission_t *self) {
    const lode_inverter_config_t *inverter = &self->designed.inverter;
    const float swing_Vs =
        2.0f * FALL_Q_HIGH * inverter->i_max_A * lode_commission_found(self, LODE_COMMISSION_LQ_H);
    const float u_V = FALL_VOLTAGE * inverter->v_bus_V / LODE_SQRT3;
    return HALF_WAVE +
           lode_commission_periods(self, lode_clamp(swing_Vs / u_V, 0.0f, FALL_LONGEST_s));
}

static float amplitude_A(const lode_commission_t *self) {
    const float i_max_A = self->designed.inverter.i_max_A;
    const float small_A = step_share(self, true) * step_hold_A(self);
    const float large_A = (self->level == 1u ? FALL_Q_MIDDLE : FALL_Q_HIGH) * i_max_A;
    return self->level == 0u ? small_A : large_A;
}

static void judge_fall_q(lode_commission_t *self) {
    (void)judge_fall(self, LODE_COMMISSION_LQ_FALL_1_A, &self->fall_q,
                     self->designed.inverter.i_max_A);
    if (falls(self, LODE_COMMISSION_LQ_FALL_1_A)) {
        const float by =
            1.0f + lode_commission_found(self, LODE_COMMISSION_LQ_FALL_1_A) * self->near_A;
        self->found[LODE_COMMISSION_LQ_H].value *= by * by;
    }
    if (self->sets > 1u) {
        self->quantity = LODE_COMMISSION_LXY_H;
        lode_commission_enter(self, STAGE_LXY);
    } else {
        lode_commission_enter(self, STAGE_RETUNE);
    }
}

// The first half-wave has half the length, so that the rotor swings about its position.
void lode_commission_Lq_fall(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A) {
    const uint32_t length = half_wave_periods(self);
    const uint32_t begin = lode_commission_periods(self, NEXT_TIME_s);
    const uint32_t under_way = self->since + length / 2u;
    const bool begun = self->since >= begin;
    const uint32_t half = begun ? (under_way - begin) / length : 0u;
    const uint32_t seen =
        self->since >= begin + SEEN_PERIODS ? (under_way - begin - SEEN_PERIODS) / length : 0u;
    const float step_A = begun ? sign_of_half(half) * amplitude_A(self) : 0.0f;
    lode_commission_post_vector(self, LODE_MODE_CURRENT, step_hold_A(self), step_A);
    if (seen > FALL_HALVES) {
        const float moved_A = self->sums.waves.i_A;
        self->fall_q.i_A[self->level] = 0.5f * moved_A / lode_commission_float(FALL_HALVES);
        self->fall_q.inverse_1_H[self->level] = moved_A / self->sums.waves.flux_Vs;
        self->level++;
        if (self->level < FALL_POINTS) {
            lode_commission_enter(self, STAGE_LQ_FALL);
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

// With a reference of 0 the control of the xy plane is pushed in alternating directions, which makes current of either sign.
// This current does not turn the rotor, which is held meanwhile.
void lode_commission_Lxy(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A) {
    const lode_dq_t *i1 = &self->before_i_A[0];
    const lode_dq_t *i2 = &self->before_i_A[1];
    const uint32_t begin = lode_commission_periods(self, NEXT_TIME_s);
    const uint32_t end = begin + 2u * HALF_WAVE * WAVES;
    const bool moves = self->since >= begin && self->since < end;
    const float wanted_V =
        moves ? sign_of_half((self->since - begin) / HALF_WAVE) * self->xy_V : 0.0f;
    self->push_V = wanted_V - self->pushed_V;
    self->pushed_V = wanted_V;
    lode_commission_post_vector(self, LODE_MODE_CURRENT, step_hold_A(self), 0.0f);
    if (moves) {
        note_step(self, step_of(self, u_V.d, self->before_u_V.d, i_A.d, i1->d, i2->d), i_A.d);
    } else if (self->since >= end && judge_steps(self, LODE_COMMISSION_LXY_H, XY_DEVIATION)) {
        lode_commission_enter(self, STAGE_RETUNE);
    } else {
        // the current settles, or it is refused
    }
}

void lode_commission_push_by(lode_commission_t *self, float kp_Ohm, float most_V) {
    self->xy_V = lode_min(kp_Ohm * XY_SHARE * step_hold_A(self), XY_CIRCLE * most_V);
}

#endif
