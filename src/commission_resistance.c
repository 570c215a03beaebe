#include "commission_parts.h"

#ifndef LODE_WITHOUT_COMMISSIONING

#define CURRENT_SHARE 0.5f // of i_max
// Of psi/(Lq - Ld), where reluctance pulls across as strongly as the magnets pull along.
#define SALIENT_SHARE 0.4f
#define QUICK_TIME_s 1.0f // for all of the voltage, until some current flows
#define SOME_SHARE 0.02f  // of the holding current: counts as some current
#define CATCH_SHARE 0.4f  // of it: rises to this before the rotor lies along it
// Then the voltage rises slowly: a winding of little resistance short-circuits a rotor that turns. The rotor lies along the
// vector after some volt seconds per weber, and should do so with little current.
#define RISE_LEAST_s 0.6f
#define RISE_MOST_s 2.0f
#define RISE_FLUXES 40.0f
#define QUICKER 4.0f // times slow_V once the rotor is along the vector, or at too much current
// Time of the turn from the first direction, across the axis: no rotor can lie opposite to both directions.
#define TURN_TIME_s 0.8f
#define WINDOW_s 0.1f
#define CALM_WINDOWS 2u
#define CALM_SHARE 0.005f // of the holding current: largest change between the halves of a window
#define SETTLE_TIME_s 4.0f
#define UNKNOWN_R 1.5f // of the configured one, for the limit of the voltage
#define UNKNOWN_DEAD_s 1.5e-6f
#define LEVELS 3u
#define LEVEL_STEP 0.3f      // of the holding current, from level to level
#define LINE_DEVIATION 0.03f // of the span: allowed distance of the middle level off the line

void lode_commission_choose_vector(lode_commission_t *self) {
    const lode_motor_t *motor = &self->designed.motor;
    const lode_inverter_config_t *inverter = &self->config.inverter;
    const float r_Ohm = motor->Rs_Ohm + self->designed.inverter.r_on_Ohm;
    const float dead_V = lode_commission_dead_known_V(&self->designed) +
                         UNKNOWN_DEAD_s * inverter->v_bus_V *
                             lode_inverter_carrier_Hz(inverter, self->config.f_pwm_Hz);
    const float most_A =
        SALIENT_SHARE * motor->psi_Wb / lode_max(motor->Lq_H - motor->Ld_H, FLT_MIN);
    self->current_A = lode_min(CURRENT_SHARE * self->designed.inverter.i_max_A, most_A);
    const float drop_V = r_Ohm * self->current_A;
    const float rise_s = lode_clamp(RISE_FLUXES * motor->psi_Wb / lode_max(drop_V, FLT_MIN),
                                    RISE_LEAST_s, RISE_MOST_s);
    const float most_V = UNKNOWN_R * drop_V + lode_commission_dead_along(self) * dead_V;
    self->vector = (lode_commission_vector_t){
        .most_V = most_V,
        .quick_V = most_V / (QUICK_TIME_s * self->config.f_pwm_Hz),
        .slow_V = drop_V / (rise_s * self->config.f_pwm_Hz),
    };
}

// Sums over the halves of a window. True at its end.
static bool window_ends(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A) {
    lode_commission_window_t *s = &self->sums.window;
    const uint32_t length = lode_commission_periods(self, WINDOW_s);
    uint32_t half = 0u;
    if (s->count >= length / 2u) {
        half = 1u;
    }
    s->u_V += u_V.d;
    s->i_A[half].d += i_A.d;
    s->i_A[half].q += i_A.q;
    s->count++;
    return s->count >= length / 2u * 2u;
}

// True: the current has been constant for long enough, and the rotor rests. Gives the means along the vector.
static bool settled(lode_commission_t *self, float *u_V, float *i_A) {
    const lode_commission_window_t s = self->sums.window;
    const float inv = 1.0f / lode_commission_float(s.count);
    const lode_dq_t change = {2.0f * inv * (s.i_A[1].d - s.i_A[0].d),
                              2.0f * inv * (s.i_A[1].q - s.i_A[0].q)};
    *u_V = inv * s.u_V;
    *i_A = inv * (s.i_A[0].d + s.i_A[1].d);
    self->sums.window = (lode_commission_window_t){.count = 0u};
    self->calm =
        lode_commission_length(change) <= CALM_SHARE * self->current_A ? self->calm + 1u : 0u;
    return self->calm >= CALM_WINDOWS;
}

static void give_up_current(lode_commission_t *self, float reached_A) {
    self->reached_A = reached_A;
    lode_commission_finish(self, LODE_COMMISSION_NO_CURRENT);
}

// The first direction: the voltage rises until the current is there, then turns to the holding axis.
void lode_commission_across(lode_commission_t *self, lode_dq_t i_A) {
    lode_commission_vector_t *vector = &self->vector;
    const float length_A = lode_commission_length(i_A);
    if (self->level == (uint32_t)LODE_PHASES * self->sets) {
        if (self->since == 0u) {
            vector->first_A = length_A; // of the last pulse
        }
        // Stays set: while the rotor turns, its EMF may take the current away again.
        const float some_A = SOME_SHARE * self->current_A + vector->first_A;
        vector->flows = vector->flows || length_A >= some_A;
        self->quantity = LODE_COMMISSION_RS_Ohm;
        vector->now_V += vector->flows ? vector->slow_V : vector->quick_V;
        lode_commission_post_vector(self, LODE_MODE_VOLTAGE, 0.0f, vector->now_V);
        if (length_A >= CATCH_SHARE * self->current_A) {
            self->level++;
            lode_commission_restart(self);
        } else if (vector->now_V > vector->most_V) {
            give_up_current(self, length_A);
        } else {
            // it rises
        }
    } else {
        const float turned =
            lode_commission_float(self->since) / (TURN_TIME_s * self->config.f_pwm_Hz);
        vector->now_V -= length_A > CATCH_SHARE * self->current_A ? QUICKER * vector->slow_V : 0.0f;
        const lode_sincos_t at = lode_sincos(0.5f * LODE_PI * lode_max(1.0f - turned, 0.0f));
        lode_commission_post_vector(self, LODE_MODE_VOLTAGE, vector->now_V * at.cos,
                                    vector->now_V * at.sin);
        if (turned >= 1.0f) {
            self->level = 0u;
            lode_commission_enter(self, STAGE_LEVEL);
        }
    }
}

// Line through the voltages at three currents. Its slope is the resistance, its value at no current the loss: drops and dead
// time have the signs of the phase currents.
static bool judge_levels(lode_commission_t *self) {
    const float *u = self->level_u_V;
    const float *i = self->level_i_A;
    const float r_Ohm = (u[0] - u[2]) / (i[0] - i[2]);
    const float dead_V = (u[0] - r_Ohm * i[0]) / lode_commission_dead_along(self);
    const float off_V = u[1] - (u[0] + r_Ohm * (i[1] - i[0]));
    const float span_V = r_Ohm * (i[0] - i[2]);
    // By the same deviation, with a wider limit.
    self->found[LODE_COMMISSION_DEAD_V] = lode_commission_judged(
        dead_V, lode_abs(off_V), LINE_DEVIATION * lode_max(lode_abs(dead_V), span_V));
    return r_Ohm > 0.0f && lode_commission_keep(self, LODE_COMMISSION_RS_Ohm, r_Ohm,
                                                lode_abs(off_V), LINE_DEVIATION * span_V);
}

// Waits for rest at the present level, then stores voltage and current.
void lode_commission_along(lode_commission_t *self, lode_dq_t u_V, lode_dq_t i_A) {
    float mean_V;
    float mean_A;
    if (!window_ends(self, u_V, i_A)) {
        return;
    }
    if (!settled(self, &mean_V, &mean_A)) {
        if (self->since > lode_commission_periods(self, SETTLE_TIME_s)) {
            lode_commission_finish(self, LODE_COMMISSION_UNSETTLED);
        }
        return;
    }
    self->level_u_V[self->level] = mean_V;
    self->level_i_A[self->level] = mean_A;
    self->level++;
    if (self->level < LEVELS) {
        lode_commission_enter(self, STAGE_LEVEL);
    } else if (judge_levels(self)) {
        self->quantity = LODE_COMMISSION_LD_H;
        self->level = 0u;
        lode_commission_enter(self, STAGE_LD);
    } else {
        lode_commission_finish(self, LODE_COMMISSION_UNSURE);
    }
}

// To the next level, up or down: while a rotor swings its current may be above or below that of the voltage.
void lode_commission_move_level(lode_commission_t *self, lode_dq_t i_A) {
    lode_commission_vector_t *vector = &self->vector;
    const float wanted_A =
        self->current_A * (1.0f - LEVEL_STEP * lode_commission_float(self->level));
    const bool below = i_A.d < wanted_A;
    if (self->since == 0u) {
        vector->rises = below;
    }
    vector->now_V += (vector->rises ? QUICKER : -QUICKER) * vector->slow_V;
    lode_commission_post_vector(self, LODE_MODE_VOLTAGE, vector->now_V, 0.0f);
    if (vector->now_V > vector->most_V) {
        give_up_current(self, i_A.d);
    } else if (below != vector->rises) {
        lode_commission_enter(self, STAGE_ALONG);
    } else {
        // it moves
    }
}

#endif
